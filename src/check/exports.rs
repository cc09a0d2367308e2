//! E0802: a transfer runs an exported policy.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy::{Deployment, Export, Transfer};
use crate::spec::Experiment;
use crate::spec::typed::InSection;

/// A spec with a transfer has an export. An abstract parent may leave it to its children; failed deployments
/// have been reported. With fine-tuning, another rule checks which policy is exported.
pub fn transfers_have_a_policy(subject: &Subject, experiment: &Experiment, sink: &mut Sink) {
    let failed = |path: &String| path.split('.').next() == Some(Deployment::SECTION);
    if experiment.is_abstract || experiment.poisoned.iter().any(failed) {
        return;
    }
    let deploys = subject.terms::<Deployment>();
    let transfer = deploys.iter().find(|(_, table)| table.is::<Transfer>());
    let (Some((path, _)), false) = (transfer, deploys.iter().any(|(_, table)| table.is::<Export>())) else {
        return;
    };
    let message = format!("`{path}` needs an exported policy, but the spec has no export");
    let mut error = Diagnostic::error("E0802", message);
    if let Some(mark) = subject.marks.nearest(path) {
        error = error.at(mark.key, "no policy to run");
    }
    sink.emit(error.help("add `[deploy.policy]` with `kind = \"export\"`"));
}
