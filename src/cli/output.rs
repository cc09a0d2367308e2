//! Where words go: data to standard output, everything else to standard error. Whatever passes here is escaped: only what
//! is [`Painted`] keeps its colours.
//!
//! A reader that has gone away (`specforge list | head`) is no failure: what it does not read is dropped. Data that cannot
//! be written otherwise, on a full disk, makes the command fail when it ends.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Color, Exit, Format, Global};
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

/// Tells the user something, on standard error, unless `--quiet`.
pub fn note(global: &Global, text: &str) {
    if !global.quiet {
        to_stderr(&terminal::lines(text));
    }
}

/// Tells the user what went wrong outside of a spec: `error: MESSAGE` and, when there is one, `help: ADVICE`.
pub fn complain(global: &Global, message: &str, advice: Option<&str>) {
    let text = Painted::new(colored(global) && global.format == Format::Human);
    let text = text.styled(Style::Error, "error").styled(Style::Bold, &format!(": {}", terminal::line(message)));
    let text = match advice {
        Some(advice) => text.plain("\n").styled(Style::Help, "help").plain(&format!(": {}", terminal::line(advice))),
        None => text,
    };
    to_stderr(text.as_str());
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
