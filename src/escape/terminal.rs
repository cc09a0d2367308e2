//! Text for terminals and logs: controls are escaped (`\u001b`), and only specforge sets colours.

use std::borrow::Cow;

use super::hidden::{self, is_hidden};

/// GitHub's workflow runner interprets this as a command anywhere in a line.
pub const COMMAND: &str = "##[";

/// Styles of specforge's own words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// The word `error`.
    Error,
    /// The word `warning`.
    Warning,
    /// The word `help`.
    Help,
    /// Success.
    Done,
    /// Headings.
    Bold,
    /// Default values.
    Dim,
    /// Values set by a profile.
    Yellow,
    /// Values set by a point of a sweep.
    Magenta,
    /// Values set on the command line.
    Cyan,
}

impl Style {
    fn code(self) -> &'static str {
        match self {
            Self::Error => "1;91",
            Self::Warning => "1;33",
            Self::Help => "1;96",
            Self::Done => "32",
            Self::Bold => "1",
            Self::Dim => "2",
            Self::Yellow => "33",
            Self::Magenta => "35",
            Self::Cyan => "36",
        }
    }
}

/// Text that is safe for a terminal: everything in it was escaped when it was added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Painted {
    text: String,
    colored: bool,
}

impl Painted {
    /// An empty text, with or without colours.
    pub fn new(colored: bool) -> Self {
        Self { text: String::new(), colored }
    }

    /// Adds plain text; keeps its line breaks.
    pub fn plain(mut self, text: &str) -> Self {
        self.text.push_str(&lines(text));
        self
    }

    /// Adds text in a style.
    pub fn styled(mut self, style: Style, text: &str) -> Self {
        let text = lines(text);
        match self.colored {
            true => self.text += &format!("\x1b[{}m{text}\x1b[0m", style.code()),
            false => self.text.push_str(&text),
        }
        self
    }

    /// Adds another text.
    pub fn then(mut self, other: &Self) -> Self {
        self.text.push_str(&other.text);
        self
    }

    /// The text, for a terminal.
    pub fn as_str(&self) -> &str {
        &self.text
    }
}

/// Escapes a text for one line, including line breaks and tabs. For names, paths and other text without line
/// breaks.
pub fn line(text: &str) -> Cow<'_, str> {
    match text.contains(is_hidden) || text.contains(COMMAND) {
        true => Cow::Owned(without_commands(&hidden::written_out(text, |_| false))),
        false => Cow::Borrowed(text),
    }
}

/// An escaped character.
pub fn written_out(letter: char) -> String {
    let mut out = String::new();
    hidden::write(&mut out, letter);
    out
}

/// The same with a newline, for a row of a listing. Leading newlines are kept.
pub fn one_line(text: &str) -> String {
    let rest = text.trim_start_matches('\n');
    format!("{}{}\n", &text[..text.len() - rest.len()], line(rest))
}

/// Escapes a text of any number of lines, including commands to GitHub's workflow runner, which reads them
/// from any output (`::error::...`, `##[error]...`).
pub fn lines(text: &str) -> Cow<'_, str> {
    let text = match text.contains(|letter| is_hidden(letter) && !is_layout(letter)) {
        true => Cow::Owned(hidden::written_out(text, is_layout)),
        false => Cow::Borrowed(text),
    };
    match text.contains("::") || text.contains(COMMAND) {
        true => Cow::Owned(text.split_inclusive('\n').map(without_command).collect()),
        false => text,
    }
}

fn is_layout(letter: char) -> bool {
    matches!(letter, '\n' | '\t')
}

fn without_commands(text: &str) -> String {
    text.replace(COMMAND, "\\u0023#[")
}

fn without_command(line: &str) -> String {
    let line = without_commands(line);
    let command = line.trim_start();
    match command.strip_prefix("::") {
        Some(rest) if rest.starts_with(|letter: char| letter.is_ascii_alphabetic()) => {
            format!("{}\\u003a:{rest}", &line[..line.len() - command.len()])
        }
        _ => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn controls_are_written_out_and_line_breaks_only_where_there_is_one_line() {
        assert_eq!(lines("a\x1b[31m\u{9b}2J\u{202e}\tb\r\nc"), "a\\u001b[31m\\u009b2J\\u202e\tb\\u000d\nc");
        assert_eq!(line("a\n\tb"), "a\\u000a\\u0009b");
        assert_eq!(line("22 °C, 3 µm – plain"), "22 °C, 3 µm – plain");
    }

    #[test]
    fn no_line_is_a_command_of_a_workflow() {
        assert_eq!(lines("a\n  ::error file=x::y\n"), "a\n  \\u003a:error file=x::y\n");
        assert_eq!(line("a ##[set-output name=x]y"), "a \\u0023#[set-output name=x]y");
        assert_eq!(lines("a ##[set-output name=x]y"), "a \\u0023#[set-output name=x]y");
        let usual = " --> a.toml:1:1\n  ::: b.toml:2:1\nstd::io\n";
        assert_eq!(lines(usual), usual);
    }

    #[test]
    fn only_our_own_colours_pass() {
        let text = Painted::new(true).styled(Style::Error, "error").plain(": \x1b[32mok");
        assert_eq!(text.as_str(), "\x1b[1;91merror\x1b[0m: \\u001b[32mok");
        assert_eq!(Painted::new(false).styled(Style::Help, "help").as_str(), "help");
    }
}
