//! Where words go: data to standard output, everything else to standard error.
//!
//! A reader that has gone away (`specforge list | head`) is no failure: what it does not read is dropped. Data that cannot
//! be written otherwise, on a full disk, makes the command fail when it ends.

use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Color, Exit, Format, Global};

/// Whether data was lost.
static LOST: AtomicBool = AtomicBool::new(false);

/// Writes data to standard output, with a line end.
pub fn data(text: &str) {
    let mut out = std::io::stdout().lock();
    let end = if text.ends_with('\n') { "" } else { "\n" };
    if let Err(error) = write!(out, "{text}{end}").and_then(|()| out.flush())
        && error.kind() != ErrorKind::BrokenPipe
        && !LOST.swap(true, Ordering::Relaxed)
    {
        to_stderr(&format!("error: standard output cannot be written: {error}"));
    }
}

/// The exit code of a command that ends with this one, in view of what it could not write.
pub fn settled(exit: Exit) -> Exit {
    match exit {
        Exit::Ok if LOST.load(Ordering::Relaxed) => Exit::StageFailed,
        exit => exit,
    }
}

/// Writes a JSON value to standard output: indented for one document.
pub fn json(value: &serde_json::Value) {
    data(&serde_json::to_string_pretty(value).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}")));
}

/// Tells the user something, on standard error, unless `--quiet`.
pub fn note(global: &Global, text: &str) {
    if !global.quiet {
        to_stderr(text);
    }
}

/// Tells the user what went wrong outside of a spec: `error: MESSAGE` and, when there is one, `help: ADVICE`.
pub fn complain(global: &Global, message: &str, advice: Option<&str>) {
    let (red, cyan, bold, plain) = if colored(global) && global.format == Format::Human {
        ("\x1b[1;91m", "\x1b[1;96m", "\x1b[1m", "\x1b[0m")
    } else {
        ("", "", "", "")
    };
    let advice = advice.map(|advice| format!("\n{cyan}help{plain}: {advice}")).unwrap_or_default();
    to_stderr(&format!("{red}error{plain}{bold}: {message}{plain}{advice}"));
}

/// Whether messages on standard error are coloured.
pub fn colored(global: &Global) -> bool {
    match global.color {
        Color::Always => true,
        Color::Never => false,
        Color::Auto => {
            std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        }
    }
}

/// Characters in a line of the terminal that standard output goes to; none when it goes elsewhere.
pub fn width() -> Option<usize> {
    terminal_size::terminal_size_of(std::io::stdout()).map(|(terminal_size::Width(width), _)| usize::from(width))
}

/// Whether data on standard output is coloured.
pub fn paints(global: &Global) -> bool {
    match global.color {
        Color::Always => true,
        Color::Never => false,
        Color::Auto => {
            std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        }
    }
}

/// Writes data to standard output, when there is any.
pub fn data_if_any(text: &str) {
    if !text.is_empty() {
        data(text);
    }
}

/// Writes a block of messages to standard error as it is.
pub fn block(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Writes a message to standard error, when there is one.
fn to_stderr(text: &str) {
    if !text.is_empty() {
        let _ = writeln!(std::io::stderr().lock(), "{}", text.trim_end_matches('\n'));
    }
}
