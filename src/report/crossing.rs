//! Warnings about runs with self-collisions, and about runs whose self-collisions are unknown.

use super::measurable::is_blind;
use super::metric::average;
use super::model::Arm;
use super::verdict::INSIDE;
use super::wording::number;
use crate::kinds::terminate::Terminations;
use crate::kinds::terminate::self_collision::SelfCollision;
use crate::spec::typed::Declared;

/// Sentences on the runs with self-collisions, on those where self-collisions were not measured, and on those
/// whose robots have no collision shapes.
pub fn warnings(runs: &[&Arm]) -> Vec<String> {
    let crossing: Vec<f64> =
        runs.iter().filter_map(|run| most(run)).filter(|share| *share > INSIDE).collect();
    let worst = crossing.iter().copied().fold(0.0, f64::max);
    let unseen = runs.iter().filter(|run| moves(run) && !is_blind(run) && is_unseen(run)).count();
    let of_all = |count: usize| {
        if runs.len() > 1 { format!(" (in {count} of {} runs)", runs.len()) } else { String::new() }
    };
    let crossing = (!crossing.is_empty()).then(|| {
        format!(
            "Links collide with each other for up to {} % of the time{}: the engines allow it, a robot cannot do it.",
            number(100.0 * worst),
            of_all(crossing.len())
        )
    });
    let unseen = (unseen > 0).then(|| {
        format!(
            "Self-collisions were not measured{}: none ended an episode, and the engines let legs pass \
             through each other.",
            of_all(unseen)
        )
    });
    crossing.into_iter().chain(unseen).chain(unmeasurable(runs)).collect()
}

/// The sentence on runs whose robots have no collision shapes.
pub fn unmeasurable(runs: &[&Arm]) -> Option<String> {
    let blind = runs.iter().filter(|run| is_blind(run) && !run.evaluations.is_empty()).count();
    let of_all = if runs.len() > 1 { format!(" (in {blind} of {} runs)", runs.len()) } else { String::new() };
    (blind > 0).then(|| {
        format!(
            "Self-collisions are not measurable{of_all}: the robot has no collision shapes but its soles, so \
             its legs may pass \
             through each other."
        )
    })
}

/// Marks self-collisions as not measured for a robot without collision shapes, where a low share means
/// nothing. Shares above the limit stay: its feet passed through each other.
pub fn forget(run: &mut Arm) {
    if !is_blind(run) {
        return;
    }
    for measured in &mut run.evaluations {
        if average(&measured.evaluation, "self_collision").is_none_or(|share| share <= INSIDE) {
            measured.evaluation.episodes.iter_mut().for_each(|episode| episode.self_collision = None);
        }
    }
}

fn moves(run: &Arm) -> bool {
    run.travels() && !run.evaluations.is_empty()
}

/// The largest share of time in self-collision that an evaluation of the run measured.
fn most(run: &Arm) -> Option<f64> {
    run.evaluations
        .iter()
        .filter_map(|measured| average(&measured.evaluation, "self_collision"))
        .reduce(f64::max)
}

fn is_unseen(run: &Arm) -> bool {
    let terms = run.section().within::<Terminations>();
    let mut kinds =
        terms.into_iter().flat_map(|terms| terms.sections()).map(|(name, term)| term.kind().unwrap_or(name));
    most(run).is_none() && !kinds.any(|kind| kind == SelfCollision::KIND.name)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::report::model::Measured;
    use crate::spec::{Table, Value};

    fn run(task: &str, ends: bool, self_collision: Option<f64>) -> Arm {
        let kind =
            |word: &str| Value::Table(Table::from([("kind".to_owned(), Value::Text(word.to_owned()))]));
        let terms = if ends {
            Table::from([("self_collision".to_owned(), kind("self_collision"))])
        } else {
            Table::new()
        };
        let evaluation = Evaluation {
            episodes: vec![Episode { self_collision, ..Episode::default() }],
            ..Evaluation::default()
        };
        Arm {
            fields: BTreeMap::from([
                ("task".to_owned(), kind(task)),
                ("terminate".to_owned(), Value::Table(terms)),
            ]),
            evaluations: vec![Measured { stage: "evaluate.nominal".into(), evaluation }],
            ..Arm::default()
        }
    }

    #[test]
    fn a_robot_without_shapes_is_told_once_and_has_no_figure() {
        let mut robot = crate::robot::tests::robot("atlas");
        robot.base.collisions.clear();
        robot.links.iter_mut().for_each(|link| link.body.collisions.clear());
        let blind = |share| {
            let mut arm = Arm { robot: Some(robot.clone()), ..run("walk", true, Some(share)) };
            forget(&mut arm);
            arm
        };
        let (apart, crossed) = (blind(0.0), blind(0.25));
        assert_eq!((most(&apart), most(&crossed)), (None, Some(0.25)));
        let told = warnings(&[&apart]);
        assert!(
            told.len() == 1 && told[0].starts_with("Self-collisions are not measurable: the robot has no"),
            "{told:?}"
        );
        let told = warnings(&[&apart, &crossed]);
        assert!(told.len() == 2 && told[1].contains("(in 2 of 2 runs)"), "{told:?}");
        let mut sighted =
            Arm { robot: Some(crate::robot::tests::robot("atlas")), ..run("walk", true, Some(0.0)) };
        forget(&mut sighted);
        assert_eq!((most(&sighted), warnings(&[&sighted])), (Some(0.0), Vec::new()));
    }

    #[test]
    fn crossed_legs_are_told_and_so_is_that_nobody_looked() {
        let quiet = [run("run", true, None), run("walk", false, Some(0.005)), run("squat", false, None)];
        assert_eq!(warnings(&quiet.iter().collect::<Vec<_>>()), Vec::<String>::new());
        let unseen = run("walk", false, None);
        assert!(warnings(&[&unseen])[0].starts_with("Self-collisions were not measured: "));
        let crossed = run("run", false, Some(0.25));
        let told = warnings(&[&crossed, &unseen, &quiet[0]]);
        assert_eq!(told.len(), 2);
        assert!(
            told[0].starts_with("Links collide with each other for up to 25 % of the time (in 1 of 3 runs)"),
            "{told:?}"
        );
        assert!(told[1].contains("(in 1 of 3 runs)"), "{told:?}");
    }
}
