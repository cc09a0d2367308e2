//! Why a report has no figure of learning curves.

use super::figure::Figure;
use super::figure::learning_curves::ID;
use super::model::ReportInput;
use crate::plan::Training;
use crate::spec::suite::figures::Wanted;

/// The reason, a sentence; empty if the figure is among `figures`.
pub fn reason(input: &ReportInput, figures: &[Figure]) -> String {
    if figures.iter().any(|figure| figure.id == ID) {
        return String::new();
    }
    let trained = input.arms.iter().filter(|arm| !arm.updates.is_empty()).count();
    let single = input.arms.iter().filter(|arm| arm.updates.len() == 1).count();
    let finished = input.arms.iter().filter(|arm| arm.stage(Training::First.stage()).is_some()).count();
    let is_left_out =
        !input.figures.is_empty() && !input.figures.iter().any(|text| Wanted::parse(text).name == ID);
    match (trained, single) {
        (0, _) if finished > 0 => "There is no learning curve: the trainings ended before their first update.",
        (0, _) => "There is no learning curve: no training has finished, or the specs train nothing.",
        _ if is_left_out => "The suite does not list the figure of learning curves.",
        (trained, single) if single == trained => {
            "There is no learning curve: every training ended after a single update."
        }
        _ => {
            "There is no learning curve: no training has returns of two updates, because too few episodes ended \
             in them."
        }
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::model::{Arm, StageRecord, Update};

    #[test]
    fn the_reason_is_that_of_the_trainings() {
        let arm = |updates: usize| Arm {
            updates: vec![Update::default(); updates],
            stages: vec![StageRecord { stage: "learner".into(), ..StageRecord::default() }],
            ..Arm::default()
        };
        let told = |arms: Vec<Arm>, figures: &[&str]| {
            let figures = figures.iter().map(|name| (*name).to_owned()).collect();
            reason(&ReportInput { arms, figures, ..ReportInput::default() }, &[])
        };
        assert!(told(vec![arm(1), arm(1)], &[]).contains("after a single update"));
        assert!(told(vec![arm(1), arm(9)], &[]).contains("no training has returns of two updates"));
        assert!(told(vec![arm(0)], &[]).contains("before their first update"));
        assert!(told(vec![Arm::default()], &[]).contains("no training has finished"));
        assert!(told(vec![arm(9)], &["survival_grid"]).contains("does not list"));
    }
}
