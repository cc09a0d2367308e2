//! The reference line "standing still" of learning curves: what an episode pays in which the robot only
//! stands.

use crate::env::Blueprint;
use crate::plan::{Training, tuned};
use crate::report::model::Arm;
use crate::report::plot::{Drawing, Ink, Panel, Stroke};
use crate::report::returns::Returns;

/// Values that differ by less than this share have one line.
const SAME: f64 = 1e-6;

/// What a caption says about the line.
pub const CAPTION: &str = " Dashed, \"standing still\": the return of an episode in which the robot only \
                           stands in its default pose for the whole time limit, computed from the reward \
                           terms, the reference motion and the commanded speeds.";

/// The return of standing still under the reward of a training, as `returns` prints it; `None` if the arm's
/// spec has no environment or its robot is unknown.
pub fn standing(arm: &Arm, training: Training, returns: Returns) -> Option<f64> {
    let fields = match training {
        Training::First => arm.fields.clone(),
        Training::FineTuning => tuned(&arm.fields),
    };
    let blueprint = Blueprint::new(fields, arm.robot.clone()?, arm.motion.clone()).ok()?;
    returns.of_episode(arm, blueprint.standing_return()).filter(|value| value.is_finite())
}

/// A line: its height and the arms to which it applies.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The return.
    pub value: f64,
    /// The arms with this return, in their order.
    pub arms: Vec<usize>,
}

/// One line for all arms with the same value.
pub fn levels(values: impl IntoIterator<Item = (usize, Option<f64>)>) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for (arm, value) in values.into_iter().filter_map(|(arm, value)| Some((arm, value?))) {
        let same = |level: &&mut Level| (level.value - value).abs() <= SAME * value.abs();
        match levels.iter_mut().find(same) {
            Some(level) => level.arms.push(arm),
            None => levels.push(Level { value, arms: vec![arm] }),
        }
    }
    levels
}

/// Draws the lines; several are named after their arms.
pub fn draw(drawing: &mut Drawing, panel: &Panel, levels: &[Level], name: impl Fn(usize) -> String) {
    let words = |level: &Level| match levels.len() {
        1 => "standing still".to_owned(),
        _ => {
            let names: Vec<String> = level.arms.iter().map(|arm| name(*arm)).collect();
            format!("standing still, {}", names.join(" and "))
        }
    };
    for level in levels {
        panel.level(drawing, level.value, Stroke::dashed(Ink::Reference, 1.2));
    }
    let labels: Vec<(f64, String)> = levels.iter().map(|level| (level.value, words(level))).collect();
    panel.level_labels(drawing, &labels, Ink::Reference);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_with_the_same_return_share_a_line_and_those_without_have_none() {
        let found = levels([(0, Some(2400.0)), (1, None), (2, Some(2400.0)), (3, Some(2300.0))]);
        let level = |value, arms: &[usize]| Level { value, arms: arms.to_vec() };
        assert_eq!(found, [level(2400.0, &[0, 2]), level(2300.0, &[3])]);
    }

    #[test]
    fn the_line_is_at_the_return_of_the_arm_s_own_environment() {
        let blueprint = crate::env::tests::Recipe::new("tocabi", Some("walk")).blueprint();
        let arm = Arm {
            fields: blueprint.fields.clone(),
            robot: Some(blueprint.robot.clone()),
            motion: blueprint.motion.clone(),
            ..Arm::default()
        };
        let height = standing(&arm, Training::First, Returns::of([&arm]));
        assert_eq!(height, Some(blueprint.standing_return()));
        assert!(height.is_some_and(|height| (2300.0..2700.0).contains(&height)), "{height:?}");
    }

    #[test]
    fn without_a_robot_there_is_no_line() {
        assert_eq!(standing(&Arm::default(), Training::First, Returns::of([])), None);
    }
}
