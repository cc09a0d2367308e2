//! Output: data to standard output, everything else to standard error. All text is escaped here, and only
//! [`Painted`] text keeps its colours.
//!
//! A closed pipe (`specforge list | head`) is not an error: the rest of the output is dropped. Any other
//! write error, such as a full disk, makes the command fail when it ends.

use std::ffi::OsString;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::error::ContextKind;
use serde_json::json;

use super::{Color, Exit, Format, Global};
use crate::diag::{Diagnostic, Sources, render};
use crate::escape::terminal::{self, Painted, Style};

/// Whether data could not be written.
static LOST: AtomicBool = AtomicBool::new(false);

/// Writes data to standard output, with a newline.
pub fn data(text: &str) {
    to_stdout(&terminal::lines(text));
}

/// Writes coloured data to standard output, with a newline.
pub fn painted(text: &Painted) {
    to_stdout(text.as_str());
}

/// Writes GitHub workflow commands, already escaped by `diag::render`, to standard output.
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

/// The exit code of a command, corrected for data that could not be written.
pub fn settled(exit: Exit) -> Exit {
    match exit {
        Exit::Ok if LOST.load(Ordering::Relaxed) => Exit::StageFailed,
        exit => exit,
    }
}

/// Writes an indented JSON document to standard output.
pub fn json(value: &serde_json::Value) {
    data(&serde_json::to_string_pretty(value).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}")));
}

/// Writes a message to standard error unless `--quiet`. With `--format json` it is a JSON object on one line,
/// like everything there.
pub fn note(global: &Global, text: &str) {
    match global.format {
        _ if global.quiet || text.is_empty() => {}
        Format::Json => message(&json!({ "note": text }).to_string()),
        _ => message(text),
    }
}

/// Reports an error outside of a spec that has no code; see [`fault`].
pub fn complain(global: &Global, message: &str, advice: Option<&str>) {
    fault(global, None, message, advice);
}

/// Reports an error outside of a spec as `error: [CODE] MESSAGE` and, if there is advice, `help: ADVICE`.
/// With `--format json` it is a document as from `check`, with one diagnostic, on one line of standard
/// output.
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

/// The document of `check` with one error that has no location in a file.
fn document(code: Option<&str>, message: &str, help: impl IntoIterator<Item = String>) -> serde_json::Value {
    let error = help.into_iter().fold(Diagnostic::error("", message), Diagnostic::help);
    let mut document = render::json(&Sources::default(), &[error]);
    document["diagnostics"][0]["code"] = code.into();
    document
}

/// Prints the errors in the arguments or the requested help; `asked` are the original arguments.
pub fn arguments(mut error: clap::Error, asked: &[OsString]) -> Exit {
    // Clap suggests `-- -1` for a positional argument, but no command takes a number there.
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
        // Help and version are printed here too; a closed pipe is not an error.
        let _ = error.print();
    }
    if error.use_stderr() { Exit::Usage } else { Exit::Ok }
}

/// Whether unparsable arguments request JSON.
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

/// Width of the terminal on standard output; `None` if it is not a terminal.
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

/// A path for a message, on one line.
pub fn shown(path: &Path) -> String {
    terminal::line(&path.display().to_string()).into_owned()
}

/// Writes data to standard output, unless it is empty.
pub fn data_if_any(text: &str) {
    if !text.is_empty() {
        data(text);
    }
}

/// Writes a message to standard error, even with `--quiet`.
pub fn message(text: &str) {
    to_stderr(&terminal::lines(text));
}

/// Writes diagnostics, already escaped by `diag::render`, to standard error.
pub fn diagnostics(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Writes a message to standard error, unless it is empty.
fn to_stderr(text: &str) {
    if !text.is_empty() {
        let _ = writeln!(std::io::stderr().lock(), "{}", text.trim_end_matches('\n'));
    }
}
