//! E0101: a required section whose terms are all disabled or have zero weight.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::learn::Ppo;
use crate::kinds::observe::Observations;
use crate::kinds::reward::Rewards;
use crate::spec::section::RewardTerm;
use crate::spec::typed::InSection;
use crate::spec::{Experiment, Section};

/// The policy has observations and, if it learns, a reward. Terms that failed have been reported.
pub fn some_are_switched_on(subject: &Subject, experiment: &Experiment, sink: &mut Sink) {
    let learns = subject.at(Ppo::samples).is_some_and(|samples| samples > 0);
    let sections = [
        (Observations::SECTION, true, "the policy would have no input"),
        (Rewards::SECTION, learns, "the policy would have no objective"),
    ];
    for (section, needed, without) in sections {
        let failed = |path: &String| path.strip_prefix(section).is_some_and(|rest| rest.starts_with('.'));
        let empty = subject.section(section).is_some_and(|terms| terms.table().is_empty());
        if !needed || !empty || experiment.is_abstract || experiment.poisoned.iter().any(failed) {
            continue;
        }
        let mut diagnostic = Diagnostic::error("E0101", format!("`{section}` has no terms: {without}"));
        if let Some(mark) = subject.marks.get(section) {
            diagnostic = diagnostic.at(mark.key, "no term, or all switched off");
        }
        sink.emit(diagnostic.help(format!(
            "add a term: `specforge list {section}` prints the available \
             ones"
        )));
    }
    if learns && !experiment.is_abstract {
        some_weigh(subject, experiment, sink);
    }
}

/// At least one reward term has a weight. Weights that are drawn or failed do not count as zero.
fn some_weigh(subject: &Subject, experiment: &Experiment, sink: &mut Sink) {
    let terms = subject.terms::<Rewards>();
    let weighs = |(_, term): &(String, Section)| term.value(RewardTerm::weight) != Some(0.0);
    let failed = experiment.poisoned.iter().any(|path| path.starts_with("reward."));
    if failed || terms.is_empty() || terms.iter().any(weighs) {
        return;
    }
    let mut diagnostic = Diagnostic::error(
        "E0101",
        "all terms of `reward` have weight zero: the policy would have no \
                                    objective",
    );
    if let Some(mark) = subject.marks.get(Rewards::SECTION) {
        diagnostic = diagnostic.at(mark.key, "all weights are zero");
    }
    sink.emit(diagnostic.help("give the terms positive `weight`s"));
}
