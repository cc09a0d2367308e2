//! E0510: a device that the learner's backend cannot use.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::{Backend, Device};

/// `learn.device = "cuda"` needs `learn.backend = "torch"`.
pub fn devices_suit_the_backend(subject: &Subject, sink: &mut Sink) {
    let backend = subject.at(Ppo::backend);
    if subject.at(Ppo::device) != Some(Device::Cuda) || backend == Some(Backend::Torch) {
        return;
    }
    let message = "the native backend does not support `learn.device = \"cuda\"`";
    let mut diagnostic = Diagnostic::error("E0510", message);
    if let Some(place) = subject.place(&Ppo::device.path()) {
        diagnostic = diagnostic.at(place, "needs the backend `torch`");
    }
    if let (Some(_), Some(place)) = (backend, subject.place(&Ppo::backend.path())) {
        diagnostic = diagnostic.note(place, "the backend");
    }
    sink.emit(diagnostic.help("write `backend = \"torch\"` in `[learn]`, or remove `device`"));
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn codes(learn: &str) -> Vec<&'static str> {
        found(devices_suit_the_backend, &format!("[learn]\n{learn}"), None)
            .iter()
            .map(|found| found.code)
            .collect()
    }

    #[test]
    fn cuda_needs_torch() {
        assert_eq!(codes("device = \"cuda\""), ["E0510"]);
        assert_eq!(codes("device = \"cuda\"\nbackend = \"native\""), ["E0510"]);
        assert!(codes("device = \"cuda\"\nbackend = \"torch\"").is_empty());
        assert!(
            codes("device = \"cpu\"").is_empty()
                && codes("backend = \"torch\"").is_empty()
                && codes("").is_empty()
        );
    }
}
