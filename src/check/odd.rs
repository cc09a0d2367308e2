//! W0523: values that are valid and can hardly be meant.

use super::Subject;
use crate::diag::{Diagnostic, Sink};

/// A spec whose odd values are reported.
pub struct Odd<'a, 'b> {
    /// The spec.
    pub subject: &'a Subject<'a>,
    /// Where the warnings go.
    pub sink: &'b mut Sink,
}

impl Odd<'_, '_> {
    /// Reports the value at a path.
    pub fn warn(&mut self, path: &str, message: String, help: &str) {
        let mut diagnostic = Diagnostic::warning("W0523", message);
        if let Some(place) = self.subject.place(path) {
            diagnostic = diagnostic.at(place, "");
        }
        self.sink.emit(diagnostic.help(help));
    }
}
