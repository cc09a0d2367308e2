//! Feet whose frames violate the convention of robot files: z is the normal of the sole and x points forward,
//! like the base's in the default pose. Motions and labels place feet by them.

use nalgebra::Vector3;

use super::kinematics::Kinematics;
use super::model::Robot;

/// Maximum tilt in rad of a level sole in the default pose.
const LEVEL: f64 = 1e-3;
/// Maximum angle in rad between a foot's x axis and forward; toes may point outwards.
const TOE_OUT: f64 = 0.5;

/// A foot that is not flat or does not point forward in the default pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Askew {
    /// Name of the foot's link.
    pub link: String,
    /// Angle between the normal of its sole and up, in rad.
    pub tilt: f64,
    /// Angle between its x axis, seen from above, and forward, in rad; positive counter-clockwise.
    pub heading: f64,
}

/// The foot that deviates most in the default pose with the base upright; `None` if both are flat and point
/// forward.
pub fn askew(robot: &Robot) -> Option<Askew> {
    let kinematics = Kinematics::new(robot);
    let feet = [0, 1].map(|side| {
        let turn = kinematics.sole(side).rotation;
        let (normal, ahead) = (turn * Vector3::z(), turn * Vector3::x());
        Askew {
            link: robot.links[robot.feet[side].link].body.name.clone(),
            tilt: libm::atan2(libm::hypot(normal.x, normal.y), normal.z),
            heading: libm::atan2(ahead.y, ahead.x),
        }
    });
    let off = |foot: &Askew| (foot.tilt / LEVEL).max(foot.heading.abs() / TOE_OUT);
    let [left, right] = feet;
    let worst = if off(&right) > off(&left) { right } else { left };
    (off(&worst) > 1.0).then_some(worst)
}

impl Askew {
    /// What is wrong with the foot: a clause.
    pub fn in_words(&self) -> String {
        let Self { link, tilt, heading } = self;
        if *tilt > LEVEL {
            return format!(
                "the sole of `{link}` is tilted by {:.1} degrees in the default pose",
                tilt.to_degrees()
            );
        }
        format!(
            "the x axis of `{link}` points {:.0} degrees off forward in the default pose",
            heading.abs().to_degrees()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::kinematics::rotation_about;
    use crate::robot::tests::robot;

    #[test]
    fn feet_of_the_shipped_robots_stand_flat_and_ahead() {
        for name in crate::robot::names() {
            assert_eq!(askew(&robot(name)), None, "{name}");
        }
    }

    #[test]
    fn a_turned_foot_and_a_tilted_pose_are_told() {
        let mut turned = robot("tocabi");
        turned.links[11].joint.origin.rotation *= rotation_about(&Vector3::z(), 3.0);
        turned.links[11].joint.axis = rotation_about(&Vector3::z(), -3.0) * turned.links[11].joint.axis;
        let found = askew(&turned).expect("it is turned");
        assert!(
            found.link.starts_with("R_") && (found.heading - 3.0).abs() < 1e-9 && found.tilt < 1e-9,
            "{found:?}"
        );
        let mut tilted = robot("tocabi");
        tilted.links[4].joint.default_position += 0.01;
        let found = askew(&tilted).expect("it is tilted");
        assert!(found.link.starts_with("L_") && (found.tilt - 0.01).abs() < 1e-9, "{found:?}");
    }
}
