//! Diagnostics: what is wrong with a text, where, and how to fix it. Depends only on text and spans.

pub mod codes;
pub mod position;
pub mod render;

use std::path::PathBuf;
use std::sync::Arc;

/// A text that spans point into: a file, or the argument of a `--set`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The name shown in messages: the path as the user would write it, or `--set` for an argument.
    pub name: PathBuf,
    /// The text.
    pub text: Arc<str>,
    /// Whether the file is outside the project; messages then show positions but do not quote lines.
    pub private: bool,
}

/// All texts of a run.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<Source>,
}

impl Sources {
    /// Adds a text.
    pub fn add(&mut self, name: impl Into<PathBuf>, text: impl Into<Arc<str>>) -> SourceId {
        self.texts.push(Source { name: name.into(), text: text.into(), private: false });
        SourceId(self.texts.len() - 1)
    }

    /// Adds a text that messages do not quote.
    pub fn add_private(&mut self, name: impl Into<PathBuf>, text: impl Into<Arc<str>>) -> SourceId {
        let id = self.add(name, text);
        self.texts[id.0].private = true;
        id
    }

    /// A text that was added.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.texts[id.0]
    }
}

/// Names a text in [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(pub usize);

/// A range of bytes in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The text.
    pub source: SourceId,
    /// First byte.
    pub start: usize,
    /// Byte after the last.
    pub end: usize,
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The spec cannot be used.
    Error,
    /// Legal and suspicious.
    Warning,
}

/// A place with a remark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// The remark; may be empty.
    pub text: String,
    /// Whether this is where the mistake is; the other labels explain.
    pub primary: bool,
}

/// An edit that fixes the mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What to replace.
    pub span: Span,
    /// The replacement.
    pub replacement: String,
}

/// One mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// `E0203`; each has a page in `diag/codes/`.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// One sentence, lower case, without a full stop.
    pub message: String,
    /// The places, the primary one first.
    pub labels: Vec<Label>,
    /// What to do about it.
    pub help: Vec<String>,
    /// The edit, when there is exactly one.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// An error.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: message.into(),
            labels: vec![],
            help: vec![],
            fix: None,
        }
    }

    /// A warning.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// Adds the primary label.
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.insert(0, Label { span, text: text.into(), primary: true });
        self
    }

    /// Adds a secondary label.
    pub fn note(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into(), primary: false });
        self
    }

    /// Adds a help line.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help.push(text.into());
        self
    }

    /// Shortens overlong texts: a key can be as long as its file.
    fn brief(mut self) -> Self {
        let labels = self.labels.iter_mut().map(|label| &mut label.text);
        for text in
            labels.chain(&mut self.help).chain([&mut self.message]).filter(|text| text.len() > LONGEST)
        {
            let end = position::boundary(text, LONGEST);
            text.truncate(end);
            text.push_str("...");
        }
        self
    }

    /// Replaces it by a note that this and later diagnostics of the code are omitted.
    fn and_more(self) -> Self {
        let message = format!("more than {MOST_OF_A_CODE} mistakes of this code: the others are not listed");
        let labels =
            self.labels.into_iter().take(1).map(|label| Label { text: "the next one".into(), ..label });
        let help = vec!["fix those that are listed first".to_owned()];
        Self { message, labels: labels.collect(), help, fix: None, ..self }
    }

    /// Adds an edit.
    pub fn fix(mut self, span: Span, replacement: impl Into<String>) -> Self {
        self.fix = Some(Fix { span, replacement: replacement.into() });
        self
    }
}

/// Maximum number of diagnostics listed per code.
pub const MOST_OF_A_CODE: usize = 100;

/// Maximum length of a diagnostic's sentence in bytes.
const LONGEST: usize = 4000;

/// Collects diagnostics: every phase continues as far as it can and reports all it finds.
#[derive(Clone, Debug, Default)]
pub struct Sink {
    /// In the order they were found.
    pub diagnostics: Vec<Diagnostic>,
}

impl Sink {
    /// Adds a diagnostic. Only the first [`MOST_OF_A_CODE`] of one code are listed; the next one says that
    /// more are omitted.
    pub fn emit(&mut self, diagnostic: Diagnostic) {
        match self.count(diagnostic.code) {
            ..MOST_OF_A_CODE => self.diagnostics.push(diagnostic.brief()),
            MOST_OF_A_CODE => self.diagnostics.push(diagnostic.and_more()),
            _ => {}
        }
    }

    /// Whether further diagnostics of a code would be dropped, so the caller can skip creating them.
    pub fn is_full(&self, code: &str) -> bool {
        self.count(code) > MOST_OF_A_CODE
    }

    fn count(&self, code: &str) -> usize {
        self.diagnostics.iter().filter(|known| known.code == code).count()
    }

    /// Whether any is an error.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_very_many_mistakes_of_one_code_the_first_are_listed_and_the_next_says_so() {
        let mut sink = Sink::default();
        (0..1000).for_each(|number| sink.emit(Diagnostic::error("E0301", format!("number {number}"))));
        sink.emit(Diagnostic::error("E0102", "another code"));
        assert_eq!(sink.diagnostics.len(), MOST_OF_A_CODE + 2);
        assert_eq!(sink.diagnostics[MOST_OF_A_CODE - 1].message, "number 99");
        assert!(sink.diagnostics[MOST_OF_A_CODE].message.contains("not listed"));
        assert!(sink.is_full("E0301") && !sink.is_full("E0102"));
    }
}
