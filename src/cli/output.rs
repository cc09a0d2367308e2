//! Where words go: data to standard output, everything else to standard error. Whatever passes here is
//! escaped: only what is [`Painted`] keeps its colours.
//!
//! A reader that has gone away (`specforge list | head`) is no failure: what it does not read is dropped.
//! Data that cannot be written otherwise, on a full disk, makes the command fail when it ends.

use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::error::ContextKind;
use serde_json::json;

use super::{Color, Exit, Format, Global};
use crate::diag::{Diagnostic, Sources, render};
use crate::escape::terminal::{self, Painted, Style};

/// Whether data was lost.
static LOST: AtomicBool = AtomicBool::new(false);

/// Writes data to standard output, with a line end.
pub fn data(text: &str) {
    to_stdout(&terminal::lines(text));
}

/// Writes coloured data to standard output, with a line end.
pub fn painted(text: &Painted) {
    to_stdout(text.as_str());
}

/// Writes the commands of a workflow, which `diag::render` has escaped, to standard output.
pub fn commands(text: &str) {
    if !text.is_empty() {
        to_stdout(text);
    }
}

fn to_stdout(text: &str) {
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

/// Tells the user something, on standard error, unless `--quiet`. With `--format json` it is an object on a
/// line, as everything there is.
pub fn note(global: &Global, text: &str) {
    match global.format {
        _ if global.quiet || text.is_empty() => {}
        Format::Json => message(&json!({ "note": text }).to_string()),
        _ => message(text),
    }
}

/// Tells the user what went wrong outside of a spec, where there is no code for it; see [`fault`].
pub fn complain(global: &Global, message: &str, advice: Option<&str>) {
    fault(global, None, message, advice);
}

/// Tells the user what went wrong outside of a spec: `error: [CODE] MESSAGE` and, when there is one,
/// `help: ADVICE`. With `--format json` it is the document of `check` with this one diagnostic, on a line of
/// standard output.
pub fn fault(global: &Global, code: Option<&str>, message: &str, advice: Option<&str>) {
    if global.format == Format::Json {
        data(&document(code, message, advice.map(str::to_owned)).to_string());
        return;
    }
    let code = code.map(|code| format!("[{code}] ")).unwrap_or_default();
    let message = &format!("{code}{message}");
    let text = Painted::new(colored(global) && global.format == Format::Human);
    let text =
        text.styled(Style::Error, "error").styled(Style::Bold, &format!(": {}", terminal::line(message)));
    let text = match advice {
        Some(advice) => {
            text.plain("\n").styled(Style::Help, "help").plain(&format!(": {}", terminal::line(advice)))
        }
        None => text,
    };
    to_stderr(text.as_str());
}

/// The document of `check` with one error that has no place in a file.
fn document(code: Option<&str>, message: &str, help: impl IntoIterator<Item = String>) -> serde_json::Value {
    let error = help.into_iter().fold(Diagnostic::error("", message), Diagnostic::help);
    let mut document = render::json(&Sources::default(), &[error]);
    document["diagnostics"][0]["code"] = code.into();
    document
}

/// Prints what is wrong with the arguments, or the help that they ask for; `asked` are the arguments as they
/// were given.
pub fn arguments(mut error: clap::Error, asked: &[OsString]) -> Exit {
    // `-- -1` is advice for a positional argument, and no command takes a number there.
    if let Some(tips) = error.remove(ContextKind::Suggested)
        && !format!("{tips:?}").contains("as a value")
    {
        error.insert(ContextKind::Suggested, tips);
    }
    if error.use_stderr() && asks_for_json(asked) {
        let text = error.render().to_string();
        let mut paragraphs = text.split("\n\n").map(str::trim).filter(|part| !part.is_empty());
        let message = paragraphs.next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        let help = paragraphs.map(|part| part.trim_start_matches("tip: ").to_owned());
        data(&document(None, &message, help).to_string());
    } else {
        // Help and the version arrive here too; a reader that has gone away is no failure.
        let _ = error.print();
    }
    if error.use_stderr() { Exit::Usage } else { Exit::Ok }
}

/// Whether arguments that cannot be parsed ask for JSON.
fn asks_for_json(arguments: &[OsString]) -> bool {
    let pairs = arguments.iter().zip(arguments.iter().skip(1));
    arguments.iter().any(|argument| argument == "--format=json")
        || pairs.into_iter().any(|(option, value)| option == "--format" && value == "json")
}

/// Whether messages on standard error are coloured.
pub fn colored(global: &Global) -> bool {
    match global.color {
        Color::Always => true,
        Color::Never => false,
        Color::Auto => {
            std::io::stderr().is_terminal()
                && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        }
    }
}

/// Characters in a line of the terminal that standard output goes to; none when it goes elsewhere.
pub fn width() -> Option<usize> {
    terminal_size::terminal_size_of(std::io::stdout())
        .map(|(terminal_size::Width(width), _)| usize::from(width))
}

/// Whether data on standard output is coloured.
pub fn paints(global: &Global) -> bool {
    match global.color {
        Color::Always => true,
        Color::Never => false,
        Color::Auto => {
            std::io::stdout().is_terminal()
                && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        }
    }
}

/// A path in a message, on one line.
pub fn shown(path: &Path) -> String {
    terminal::line(&path.display().to_string()).into_owned()
}

/// Writes data to standard output, when there is any.
pub fn data_if_any(text: &str) {
    if !text.is_empty() {
        data(text);
    }
}

/// Writes a message to standard error, with `--quiet` too.
pub fn message(text: &str) {
    to_stderr(&terminal::lines(text));
}

/// Writes diagnostics, which `diag::render` has escaped, to standard error as they are.
pub fn diagnostics(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Writes a message to standard error, when there is one.
fn to_stderr(text: &str) {
    if !text.is_empty() {
        let _ = writeln!(std::io::stderr().lock(), "{}", text.trim_end_matches('\n'));
    }
}
