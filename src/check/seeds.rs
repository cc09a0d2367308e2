//! E0705 between a sweep and its arms: evaluations do not use a seed of the learning.

use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::{Evaluation, Setting};
use crate::spec::Experiment;
use crate::spec::suite::Sweep;
use crate::spec::typed::InSection;

/// No evaluation or transfer of an arm has the seed of one of its runs.
pub fn learning_and_evaluation_are_apart(sweep: &Sweep, experiment: &Experiment, sink: &mut Sink) {
    for section in [Evaluation::SECTION, Deployment::SECTION] {
        for (name, term) in experiment.section(section).into_iter().flat_map(|terms| terms.sections()) {
            let Some(seed) = term.value(Setting::seed) else { continue };
            let Some((_, place)) = sweep.seeds.iter().flatten().find(|(learning, _)| *learning == seed)
            else {
                continue;
            };
            let message = format!("`{section}.{name}` uses the seed {seed}, which is also a learning seed");
            let error = Diagnostic::error("E0705", message).at(*place, format!("{seed} is a learning seed"));
            let mark = experiment.marks.nearest(&Setting::seed.below(&format!("{section}.{name}")));
            let error = mark.map_or(error.clone(), |mark| error.note(mark.value, "evaluation seed"));
            sink.emit(error.help("change one of them: the evaluation seed must be unseen in training"));
        }
    }
}
