//! What a new spec says about a user's robot: labels as soft, and exploration as strong, as those with which
//! every shipped robot squats, walks and runs (`docs/experiments/2026-11-25-figures-for-the-weight.md`).
//!
//! The figures are relative to the robot's weight and height, so they hold for any robot whose file has gains
//! and effort limits. For one without, or with figures that no key takes, the parents' shares stay.

use crate::quantity::relative;
use crate::robot::Proportions;

/// Stiffness of the labels, and the damping of the labels and the joint together.
const LABELS: [(&str, [&str; 2]); 2] = [
    ("walk", ["0.16 mgh/rad", "0.023 mgh*sqrt(h/g)/rad"]),
    ("run", ["0.338 mgh/rad", "0.0371 mgh*sqrt(h/g)/rad"]),
];
/// The labels of all other tasks.
const SOFT: [&str; 2] = ["0.13 mgh/rad", "0.023 mgh*sqrt(h/g)/rad"];
/// Stiffness of the servo with which robots train under position control: TOCABI, Atlas and G1 have 0.22, 0.26
/// and 0.32.
const SERVO: &str = "0.25 mgh/rad";
/// Exploration under torque control: the paper's value; for runs TOCABI and Atlas have 2.6 and 2.3 %.
const EXPLORATION: [(&str, &str); 2] = [("squat", "1.1 % mgh"), ("run", "2.5 % mgh")];
/// The exploration of all other tasks.
const WALKS_WITH: &str = "1.72 % mgh";
/// The exploration with which the profile `desk` trains a run; TOCABI and Atlas have 5.1 and 4.6 %.
const RUNS_WITH: &str = "4.8 % mgh";
/// The exploration in the last part of a walk and of a run.
const LAST_PARTS: [(&str, &str); 2] = [("walk", "0.87 % mgh"), ("run", "1.2 % mgh")];

/// The shares that the keys allow.
const ALLOWED: std::ops::RangeInclusive<f64> = 1e-6..=10.0;

/// Stiffness and damping of the labels of a task.
pub fn labels(robot: &Proportions, task: &str) -> Option<[&'static str; 2]> {
    let [stiffness, damping] =
        LABELS.iter().find(|(known, _)| *known == task).map_or(SOFT, |(_, labels)| *labels);
    let damps = robot.damping.is_some() && share(robot, damping)? <= *ALLOWED.end();
    Some([taken(robot, stiffness)?, damping]).filter(|_| damps)
}

/// The stiffness of the servo for training.
pub fn servo(robot: &Proportions) -> Option<&'static str> {
    taken(robot, SERVO)
}

/// The exploration of a task.
pub fn exploration(robot: &Proportions, task: &str) -> Option<&'static str> {
    taken(robot, EXPLORATION.iter().find(|(known, _)| *known == task).map_or(WALKS_WITH, |(_, of)| *of))
}

/// The exploration with which the profile `desk` trains a run.
pub fn running_exploration(robot: &Proportions) -> Option<&'static str> {
    taken(robot, RUNS_WITH)
}

/// The exploration of a task's last part; `None` if it has none.
pub fn last_exploration(robot: &Proportions, task: &str) -> Option<&'static str> {
    LAST_PARTS.iter().find(|(known, _)| *known == task).and_then(|(_, of)| taken(robot, of))
}

/// The quantity, if a key takes the share that it amounts to.
fn taken(robot: &Proportions, quantity: &'static str) -> Option<&'static str> {
    share(robot, quantity).is_some_and(|share| ALLOWED.contains(&share)).then_some(quantity)
}

fn share(robot: &Proportions, quantity: &str) -> Option<f64> {
    robot.share(relative(quantity)?.ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot;

    /// The shares of a shipped robot in percent: exploration, that of the last part, stiffness and damping of
    /// the labels.
    fn percents(name: &str, task: &str) -> [Option<f64>; 4] {
        let robot = Proportions::of(&robot::shipped(name).expect("it is shipped"));
        let labels = labels(&robot, task).expect("it has gains");
        let quantities =
            [exploration(&robot, task), last_exploration(&robot, task), Some(labels[0]), Some(labels[1])];
        quantities.map(|quantity| Some(100.0 * share(&robot, quantity?)?))
    }

    #[test]
    fn the_shipped_robots_are_trained_with_nearly_these_figures() {
        // What the parents of squats and those of the suite `one_recipe` say, in percent. They were measured
        // relative to the heights of the bases' origins, which lie differently high above the hips.
        let said = [
            ("tocabi", "walk", [Some(6.7), Some(3.4), Some(4.5), Some(19.0)]),
            ("atlas", "walk", [Some(7.4), Some(3.8), Some(30.0), Some(40.0)]),
            ("g1", "walk", [Some(5.0), Some(2.5), Some(50.0), Some(70.71)]),
            ("tocabi", "squat", [Some(4.3), None, Some(3.7), Some(19.0)]),
            ("atlas", "squat", [Some(4.8), None, Some(25.0), Some(40.0)]),
            ("g1", "squat", [Some(3.2), None, Some(41.0), Some(71.0)]),
        ];
        for (robot, task, said) in said {
            for (said, figure) in said.into_iter().zip(percents(robot, task)) {
                let agree = match (said, figure) {
                    (Some(said), Some(figure)) => (figure / said - 1.0_f64).abs() < 0.25,
                    (said, figure) => said == figure,
                };
                assert!(agree, "{robot} {task}: {said:?}, {figure:?}");
            }
        }
    }

    #[test]
    fn a_robot_without_a_figure_or_with_an_impossible_one_keeps_the_parents_shares() {
        let robot = Proportions {
            stands: 1.0,
            base: 1.0,
            torque: 1000.0,
            stiffness: Some(1.0),
            damping: Some(0.1),
            own_damping: 0.0,
            effort: Some(0.5),
        };
        assert_eq!(labels(&robot, "squat"), Some(SOFT));
        assert_eq!(labels(&Proportions { own_damping: 0.05, ..robot }, "squat"), Some(SOFT));
        for limp in [
            Proportions { stiffness: None, ..robot },
            Proportions { damping: None, ..robot },
            Proportions { stiffness: Some(1e-9), ..robot },
            Proportions { damping: Some(1e-9), ..robot },
        ] {
            assert_eq!(labels(&limp, "run"), None, "{limp:?}");
        }
        assert_eq!(exploration(&Proportions { effort: Some(1e9), ..robot }, "walk"), None);
        assert_eq!(exploration(&Proportions { effort: None, ..robot }, "walk"), None);
        assert_eq!(servo(&robot), Some(SERVO));
    }
}
