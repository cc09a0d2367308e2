//! Diagnostics as text: for people, for programs, for GitHub. The only place that prints diagnostics.

mod github;
mod human;
mod json;
mod texts;

pub use github::github;
pub use human::{Look, human};
pub use json::json;

use super::{Diagnostic, Severity};

/// How many errors and how many warnings there are.
pub fn count(diagnostics: &[Diagnostic]) -> (usize, usize) {
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
    (errors, diagnostics.len() - errors)
}

/// `2 errors and 1 warning`; empty if both are 0.
pub fn tally(errors: usize, warnings: usize) -> String {
    let some = |count: usize, word: &str| match count {
        0 => None,
        1 => Some(format!("1 {word}")),
        _ => Some(format!("{count} {word}s")),
    };
    [some(errors, "error"), some(warnings, "warning")].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tally_leaves_out_what_there_is_none_of() {
        assert_eq!(tally(0, 0), "");
        assert_eq!(tally(1, 0), "1 error");
        assert_eq!(tally(2, 1), "2 errors and 1 warning");
        assert_eq!(tally(0, 3), "3 warnings");
    }
}
