//! Limits on templates: nesting, steps, output, time and memory. A template may come from anywhere, and the
//! template engine itself limits neither the stack of its parser nor its computations.
//!
//! Steps, output and (in the program) memory are counted, so that a template is refused on every machine or
//! on none. Time is the last resort, as one step may do the work of many (`replace`, `list`, `~`).

use std::io;
use std::ops::Range;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use minijinja::machinery::{Token, tokenize};
use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, Error, ErrorKind, Value};

use crate::{allocation, bounded};

/// Most instructions of the template engine; the largest report takes a few hundred thousand.
const MOST_STEPS: u64 = 10_000_000;
/// Largest output in bytes.
const MOST_OUTPUT: usize = 64 << 20;
/// Longest line in bytes; the template engine counts columns in 16 bits.
const LONGEST_LINE: usize = 60_000;
/// Most operators and brackets in a tag: each may add a level to the expression tree.
const MOST_OPERATORS: usize = 1000;
/// Most `elif` in a template: each adds a level to the statement tree.
const MOST_BRANCHES: usize = 1000;
/// Levels of macros and includes, as the template engine counts them.
const DEEPEST: usize = 300;
/// Stack of the parsing and rendering thread in bytes. It is reserved, and used only for nested templates.
const STACK: usize = 64 << 20;
/// Longest rendering time; the largest report takes less than a second.
const LONGEST: Duration = Duration::from_secs(20);
/// Most memory of a rendering in bytes.
const MOST_MEMORY: usize = 512 << 20;
/// The name of the rendering thread.
const THREAD: &str = "template";
/// How often time and memory are checked.
const GLANCE: Duration = Duration::from_millis(5);

/// Sets the limits that the environment itself supports.
pub fn apply(environment: &mut Environment) {
    environment.set_fuel(Some(MOST_STEPS));
    environment.set_recursion_limit(DEEPEST);
}

/// What is nested too deeply in a template, and where, found without parsing it.
pub fn crowded(text: &str, syntax: &SyntaxConfig) -> Option<(String, Range<usize>)> {
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        if line.len() > LONGEST_LINE {
            let message = format!("this line has more than {LONGEST_LINE} bytes");
            return Some((message, start..start));
        }
        start += line.len();
    }
    let (mut operators, mut branches) = (0, 0);
    // The parser reports invalid tokens.
    for (token, span) in tokenize(text, false, syntax.clone()).map_while(Result::ok) {
        let range = span.start_offset as usize..span.end_offset as usize;
        match token {
            Token::VariableStart | Token::BlockStart => operators = 0,
            Token::Ident("elif") => branches += 1,
            // Commas and colons separate values on the same level.
            Token::TemplateData(_) | Token::VariableEnd | Token::BlockEnd | Token::Comma | Token::Colon => {}
            Token::Str(_) | Token::String(_) | Token::Int(_) | Token::Int128(_) | Token::Float(_) => {}
            Token::Ident(word) if !matches!(word, "not" | "and" | "or" | "is" | "in" | "if" | "else") => {}
            _ => operators += 1,
        }
        if operators > MOST_OPERATORS {
            return Some((format!("this tag has more than {MOST_OPERATORS} operators"), range));
        }
        if branches > MOST_BRANCHES {
            return Some((format!("this template has more than {MOST_BRANCHES} `elif`"), range));
        }
    }
    None
}

/// Runs a function on a thread with enough stack for every template that is not [`crowded`].
pub fn with_stack<T: Send>(run: impl FnOnce() -> T + Send) -> io::Result<T> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run)?;
        Ok(thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Renders a template within the limits. A thread cannot be stopped from outside, so a rendering that takes
/// too long or too much memory is abandoned. It ends with the process, which has nothing left to do without
/// the report.
pub fn render(environment: Environment<'static>, name: &str, variables: Value) -> Result<String, Error> {
    let (sender, receiver) = channel();
    let (name, is_full) = (name.to_owned(), Arc::new(AtomicBool::new(false)));
    let full = is_full.clone();
    let run = move || {
        let render = || {
            let mut page = Page::default();
            let template = environment.get_template(&name);
            let rendered =
                template.and_then(|template| template.render_captured_to(variables, &mut page).map(drop));
            rendered.map(|()| page.text)
        };
        let rendered =
            allocation::limited(MOST_MEMORY, &full, || std::panic::catch_unwind(AssertUnwindSafe(render)));
        // After the time limit the receiver is gone.
        let _ = sender.send(rendered.unwrap_or_else(|_| {
            Err(exceeded(
                "the template engine failed: a number in the template may be too large for it".into(),
            ))
        }));
    };
    keep_quiet();
    // Without the program's allocator (as in the tests of this library) only the memory of the whole process
    // is known, which other templates use, too.
    let before = (!allocation::is_limiting()).then(resident_memory);
    let is_large =
        || before.is_some_and(|before| resident_memory().saturating_sub(before) > MOST_MEMORY as u64);
    let start = Instant::now();
    let thread = std::thread::Builder::new().name(THREAD.into()).stack_size(STACK);
    thread.spawn(run).map_err(|error| exceeded(error.to_string()))?;
    loop {
        let why = match receiver.recv_timeout(GLANCE) {
            Ok(rendered) => {
                return rendered
                    .and_then(|text| String::from_utf8(text).map_err(|e| exceeded(e.to_string())));
            }
            Err(RecvTimeoutError::Disconnected) => "the template engine failed".to_owned(),
            Err(RecvTimeoutError::Timeout) if start.elapsed() > LONGEST => {
                format!("rendering takes more than {} s", LONGEST.as_secs())
            }
            Err(RecvTimeoutError::Timeout) if is_full.load(Ordering::SeqCst) || is_large() => {
                format!("rendering takes more than {} MiB of memory", MOST_MEMORY >> 20)
            }
            Err(RecvTimeoutError::Timeout) => continue,
        };
        return Err(exceeded(why));
    }
}

/// Suppresses the panic message of the rendering thread, whose error is returned instead.
fn keep_quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let others = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if std::thread::current().name() != Some(THREAD) {
                others(panic);
            }
        }));
    });
}

/// Whether the template engine exceeded a limit.
pub fn is_exceeded(error: &Error) -> bool {
    let detail = error.detail().unwrap_or_default();
    matches!(error.kind(), ErrorKind::OutOfFuel | ErrorKind::WriteFailure)
        || ["recursion limit", "too large", "too many elements"].iter().any(|words| detail.contains(words))
}

/// The limit that was exceeded; `None` if the error itself names it.
pub fn in_words(error: &Error) -> Option<String> {
    match error.kind() {
        ErrorKind::OutOfFuel => {
            Some(format!("the template takes more than {} million steps", MOST_STEPS / 1_000_000))
        }
        // The only I/O error of the engine is that of `Page`.
        ErrorKind::WriteFailure if std::error::Error::source(error).is_some() => {
            Some(format!("the template writes more than {} MiB", MOST_OUTPUT >> 20))
        }
        _ if error.detail().is_some_and(|detail| detail.contains("recursion limit")) => {
            Some(format!("templates or macros are nested more than {DEEPEST} deep: does one include itself?"))
        }
        _ => None,
    }
}

/// The root cause of an error: each including template only says that the included one failed.
pub fn cause(error: &Error) -> &Error {
    let mut cause = error;
    while let Some(inner) = std::error::Error::source(cause).and_then(|inner| inner.downcast_ref()) {
        cause = inner;
    }
    cause
}

fn exceeded(why: String) -> Error {
    Error::new(ErrorKind::WriteFailure, why)
}

/// Memory of this process in bytes; 0 if unknown.
fn resident_memory() -> u64 {
    const PAGE: u64 = 4096;
    let statm = bounded::text(Path::new("/proc/self/statm"), bounded::WRITTEN).unwrap_or_default();
    statm
        .split_whitespace()
        .nth(1)
        .and_then(|pages| pages.parse::<u64>().ok())
        .map_or(0, |pages| pages * PAGE)
}

/// Output that may grow up to the limit.
#[derive(Default)]
struct Page {
    text: Vec<u8>,
}

impl io::Write for Page {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.text.len() + bytes.len() > MOST_OUTPUT {
            return Err(io::Error::other(format!("the output has more than {} MiB", MOST_OUTPUT >> 20)));
        }
        self.text.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
