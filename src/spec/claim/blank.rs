//! E0103: empty texts in a claim.

use super::Reading;
use crate::diag::Diagnostic;

/// The keys whose text must not be empty, and what to write. The other keys have their own errors.
const TEXTS: &[(&str, &str)] = &[
    ("text", "say in a sentence what is claimed"),
    ("baseline", "name another stage of the same runs, for example `evaluate.flat`, or remove `baseline`"),
    ("twin", "name the points of another arm, for example `ground=flat`, or remove `twin`"),
    ("compare.a", ARM),
    ("compare.b", ARM),
    ("arm", ARM),
    ("over.some", AXIS),
    ("over.none", AXIS),
    ("over.trend", AXIS),
    ("test", "name a test of `specforge list statistic`, or remove `test` for `welch`"),
    (
        "parameter",
        "name a parameter that the evaluation varies, for example `action_delay`, or remove `parameter`",
    ),
    ("paper.where", "say where the paper says it, or remove `paper`"),
    ("paper.value", "say what the paper says in few words, or remove `paper`"),
];

const ARM: &str = "name the arm by its points, `axis=point` joined by commas";
const AXIS: &str = "name an axis of the suite";

impl Reading<'_> {
    /// The text of a key, unless it is empty.
    fn text_at(&self, path: &str) -> Option<&str> {
        match path.split_once('.') {
            Some((table, key)) => self.fields.section(table)?.text_if(key),
            None => self.fields.text_if(path),
        }
    }

    /// Whether a key has a text without any letters.
    pub(super) fn is_blank(&self, path: &str) -> bool {
        self.text_at(path).is_some_and(|text| text.trim().is_empty())
    }

    /// Reports keys with an empty text.
    pub(super) fn texts_say_something(&mut self) {
        for (path, help) in TEXTS {
            if self.is_blank(path) {
                let error =
                    Diagnostic::error("E0103", format!("`{path}` is empty")).at(self.place(path), "no text");
                self.fail(error.help(*help));
            }
        }
    }
}
