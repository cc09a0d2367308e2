//! Episodes with longer or shorter legs: how the nominal robot's reference is adapted.
//!
//! The reference keeps its joint angles and its timing. With other leg lengths the same angles put the soles
//! at another depth below the base, so the base's height is corrected, phase by phase.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::kinds::motion::Frame;
use crate::robot::{Kinematics, Robot};

/// The legs of an episode compared with those that the reference was made for.
#[derive(Clone, Debug)]
pub struct Stature {
    ratio: f64,
    nominal: Kinematics,
    own: Kinematics,
}

impl Stature {
    /// The stature of an episode's robot; `None` if its legs are the nominal ones.
    pub fn of(nominal: &Robot, own: &Robot) -> Option<Self> {
        let other = own.standing_height != nominal.standing_height;
        other.then(|| Self {
            ratio: own.standing_height / nominal.standing_height,
            nominal: Kinematics::new(nominal),
            own: Kinematics::new(own),
        })
    }

    /// Standing height divided by the nominal robot's.
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Moves the base of a frame of the reference to the height at which the lower sole is as high above the
    /// ground as in the reference.
    pub fn follow(&mut self, frame: &mut Frame) {
        let [w, x, y, z] = frame.base_orientation;
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let base = Isometry3::from_parts(Translation3::identity(), turn);
        frame.base_height += depth(&mut self.own, &base, frame) - depth(&mut self.nominal, &base, frame);
    }
}

/// Depth in m of the lowest point of both soles below the base.
fn depth(kinematics: &mut Kinematics, base: &Isometry3<f64>, frame: &Frame) -> f64 {
    kinematics.place(base, &frame.position);
    -kinematics.lowest_corner(0).min(kinematics.lowest_corner(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::tests::motion;
    use crate::robot::tests::robot;

    #[test]
    fn nominal_legs_have_no_stature_of_their_own() {
        let mut heavy = robot("tocabi");
        heavy.base.mass *= 1.3;
        assert!(Stature::of(&robot("tocabi"), &heavy).is_none());
    }

    #[test]
    fn a_squat_on_longer_legs_is_higher_by_what_its_bones_gain_in_that_pose() {
        let nominal = robot("tocabi");
        let squat = motion("squat", &nominal);
        let mut tall = nominal.clone();
        tall.stretch_legs(1.2);
        let mut stature = Stature::of(&nominal, &tall).unwrap();
        assert!((stature.ratio() - tall.standing_height / nominal.standing_height).abs() < 1e-15);
        let mut frame = Frame::default();
        // In the hold, thigh and shank of 0.35 m are inclined by 0.54 rad and 0.66 rad; at rest at 0.24 rad
        // and 0.36 rad.
        for (phase, angles) in [(0.5, [0.54, 0.66]), (0.0, [0.24, 0.36])] {
            squat.at(phase, &mut frame);
            let before = frame.base_height;
            stature.follow(&mut frame);
            let gain = 0.2 * 0.35 * (libm::cos(angles[0]) + libm::cos(angles[1]));
            assert!((frame.base_height - before - gain).abs() < 1e-9, "{}", frame.base_height - before);
        }
    }
}
