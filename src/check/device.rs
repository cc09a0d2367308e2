//! E0510: a device that the learner's backend cannot use.

use super::Subject;
use crate::diag::{Diagnostic, Sink};

/// `learn.device = "cuda"` needs `learn.backend = "torch"`.
pub fn devices_suit_the_backend(subject: &Subject, sink: &mut Sink) {
    if subject.text("learn.device") != Some("cuda") || subject.text("learn.backend") == Some("torch") {
        return;
    }
    let message = "`learn.device` is \"cuda\", and the native backend computes on the CPU only";
    let mut diagnostic = Diagnostic::error("E0510", message);
    if let Some(place) = subject.place("learn.device") {
        diagnostic = diagnostic.at(place, "needs the backend `torch`");
    }
    if let (Some(_), Some(place)) = (subject.text("learn.backend"), subject.place("learn.backend")) {
        diagnostic = diagnostic.note(place, "the backend");
    }
    sink.emit(diagnostic.help("write `backend = \"torch\"` in `[learn]`, or leave `device` out"));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn codes(learn: &str) -> Vec<&'static str> {
        found(devices_suit_the_backend, &format!("[learn]\n{learn}"), None).iter().map(|found| found.code).collect()
    }

    #[test]
    fn cuda_needs_torch() {
        assert_eq!(codes("device = \"cuda\""), ["E0510"]);
        assert_eq!(codes("device = \"cuda\"\nbackend = \"native\""), ["E0510"]);
        assert!(codes("device = \"cuda\"\nbackend = \"torch\"").is_empty());
        assert!(
            codes("device = \"cpu\"").is_empty() && codes("backend = \"torch\"").is_empty() && codes("").is_empty()
        );
    }
}
