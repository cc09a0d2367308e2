//! E0705 between learning and evaluations: no evaluation uses a seed of the learning. The learning seed is
//! that of the spec, or those of a sweep in its place.

use crate::diag::{Diagnostic, Sink, Span};
use crate::kinds::deploy::{Deployment, Transfer};
use crate::kinds::evaluate::{Evaluation, SEED, Setting};
use crate::kinds::learn::Ppo;
use crate::spec::Experiment;
use crate::spec::suite::Sweep;
use crate::spec::typed::InSection;
use crate::syntax::Layer;

/// The seed of an evaluation or transfer.
struct Used {
    /// Its table: `evaluate.nominal`.
    table: String,
    /// The seed.
    seed: u64,
}

/// No evaluation or transfer of an arm has the seed of one of its runs.
pub fn sweep_and_evaluations_are_apart(sweep: &Sweep, experiment: &Experiment, sink: &mut Sink) {
    for Used { table, seed } in used(experiment) {
        if let Some((_, place)) = sweep.seeds.iter().flatten().find(|(learning, _)| *learning == seed) {
            sink.emit(overlap(&table, seed, Some(*place), evaluation_seed(experiment, &table)));
        }
    }
}

/// No evaluation or transfer of a spec has its `learn.seed`.
pub fn learning_and_evaluations_are_apart(experiment: &Experiment, sink: &mut Sink) {
    let path = Ppo::seed.path();
    let Some(learning) = experiment.section(Ppo::SECTION).and_then(|learn| learn.value(Ppo::seed)) else {
        return;
    };
    let place = written(experiment, &path);
    for Used { table, seed } in used(experiment).into_iter().filter(|used| used.seed == learning) {
        sink.emit(overlap(&table, seed, place, evaluation_seed(experiment, &table)));
    }
}

/// The seeds of all evaluations and transfers.
fn used(experiment: &Experiment) -> Vec<Used> {
    let mut found = Vec::new();
    let has_nominal =
        experiment.section(Evaluation::SECTION).and_then(|all| all.section("nominal")).is_some();
    for section in [Evaluation::SECTION, Deployment::SECTION] {
        for (name, term) in experiment.section(section).into_iter().flat_map(|terms| terms.sections()) {
            let table = format!("{section}.{name}");
            // A transfer without a seed has that of `evaluate.nominal`, which is in the list itself.
            let usual = (term.is::<Transfer>() && !has_nominal).then_some(SEED);
            found.extend(term.value(Setting::seed).or(usual).map(|seed| Used { table, seed }));
        }
    }
    found
}

/// The place of the seed of an evaluation, or of its table.
fn evaluation_seed(experiment: &Experiment, table: &str) -> Option<Span> {
    experiment.marks.nearest(&Setting::seed.below(table)).map(|mark| mark.value)
}

/// The place of a value that is not a default.
fn written(experiment: &Experiment, path: &str) -> Option<Span> {
    experiment.marks.get(path).filter(|mark| mark.layer != Layer::Default).map(|mark| mark.value)
}

/// The diagnostic at the learning seed, and at the evaluation's.
fn overlap(table: &str, seed: u64, learning: Option<Span>, evaluation: Option<Span>) -> Diagnostic {
    let message = format!("`{table}` uses the seed {seed}, which is also a learning seed");
    let error = Diagnostic::error("E0705", message);
    let error = match (learning, evaluation) {
        (Some(learning), Some(evaluation)) => {
            error.at(learning, format!("{seed} is a learning seed")).note(evaluation, "evaluation seed")
        }
        (Some(place), None) => error.at(place, format!("{seed} is a learning seed")),
        (None, Some(place)) => error.at(place, "`learn.seed` is the same"),
        (None, None) => error,
    };
    error.help("change one of them: the evaluation seed must be unseen in training")
}
