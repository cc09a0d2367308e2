//! The physics rates of evaluations in several engines.

use super::model::Arm;
use super::wording::{listed, number};
use crate::outcome::Evaluation;

/// A warning if an arm was evaluated in several engines with different physics rates.
pub fn warning(arms: &[Arm]) -> Option<String> {
    let evaluations = || arms.iter().flat_map(|arm| &arm.evaluations).map(|measured| &measured.evaluation);
    let mixed = |arm: &Arm| {
        let [first, rest @ ..] = &arm.evaluations[..] else { return false };
        let first = &first.evaluation;
        let other = |one: &Evaluation| one.engine != first.engine && one.physics_rate != first.physics_rate;
        rest.iter().any(|measured| other(&measured.evaluation))
    };
    arms.iter().any(mixed).then(|| {
        format!(
            "The engines have different physics rates, which change the results, too: {}.",
            in_words(evaluations())
        )
    })
}

/// The rates and their engines: `500 Hz in batch, 2000 Hz in mujoco and rapier`.
pub fn in_words<'a>(evaluations: impl Iterator<Item = &'a Evaluation>) -> String {
    let mut rates: Vec<(f64, Vec<&str>)> = Vec::new();
    for evaluation in evaluations {
        let engine = evaluation.engine.as_str();
        match rates.iter_mut().find(|(rate, _)| *rate == evaluation.physics_rate) {
            Some((_, engines)) if engines.contains(&engine) => {}
            Some((_, engines)) => engines.push(engine),
            None => rates.push((evaluation.physics_rate, vec![engine])),
        }
    }
    let rates = rates.iter().map(|(rate, engines)| format!("{} Hz in {}", number(*rate), listed(engines)));
    rates.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::model::Measured;

    #[test]
    fn rates_are_told_where_they_differ_between_engines() {
        let measured = |engine: &str, physics_rate| Measured {
            stage: engine.into(),
            evaluation: Evaluation { engine: engine.into(), physics_rate, ..Evaluation::default() },
        };
        let arm = |evaluations| Arm { evaluations, ..Arm::default() };
        let rates = |of_others| {
            let all =
                vec![measured("batch", 500.0), measured("mujoco", of_others), measured("rapier", of_others)];
            warning(&[arm(vec![measured("batch", 500.0)]), arm(all)])
        };
        assert_eq!(rates(500.0), None);
        let told = "The engines have different physics rates, which change the results, too: 500 Hz in batch, 2000 Hz in \
            mujoco and rapier.";
        assert_eq!(rates(2000.0).as_deref(), Some(told));
    }
}
