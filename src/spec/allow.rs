//! `[allow]` and `--deny warnings`: which warnings are dropped and which are errors.

use std::collections::BTreeMap;

use crate::diag::{Severity, Sink};

/// Drops the allowed warnings; makes the others errors if warnings are denied.
pub fn apply(sink: &mut Sink, allow: &BTreeMap<String, String>, deny: bool) {
    sink.diagnostics.retain(|found| found.severity == Severity::Error || !allow.contains_key(found.code));
    if deny {
        sink.diagnostics.iter_mut().for_each(|found| found.severity = Severity::Error);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Diagnostic;

    #[test]
    fn allowed_warnings_go_and_denied_ones_become_errors() {
        let mut sink = Sink::default();
        ["W0501", "W0502"].iter().for_each(|code| sink.emit(Diagnostic::warning(code, "suspicious")));
        sink.emit(Diagnostic::error("E0101", "wrong"));
        let allow = [("W0501".to_owned(), "on purpose".to_owned())].into();
        apply(&mut sink, &allow, false);
        assert_eq!(sink.diagnostics.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0502", "E0101"]);
        apply(&mut sink, &allow, true);
        assert!(sink.diagnostics.iter().all(|found| found.severity == Severity::Error));
    }
}
