//! The reward term `velocity_tracking`.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{kernel, squared_error};
use crate::kinds::{Reward, Signals};
use crate::spec::typed::prelude::*;

choice! {
    /// Frame of the velocity's x and y axes.
    pub enum Frame {
        /// The base, which tilts.
        Base = "base",
        /// The heading frame.
        Heading = "heading",
    }
}

kind! {
    pub struct VelocityTracking = "velocity_tracking", needs [BaseVelocity] {
        /// Sharpness of the kernel.
        #[range(1e-9, 1e9)]
        k: Quantified<PerSquareVelocity>,
        /// Frame of the velocity's x and y axes: the heading frame (default), or the base, which tilts.
        frame: Option<Frame>,
    }
}

impl Reward for VelocityTracking {
    fn value(&self, signals: &Signals) -> f64 {
        let velocity = if self.frame == Some(Frame::Base) { leaning(signals) } else { signals.base_velocity };
        kernel(self.k, squared_error(&velocity, signals.command_speed))
    }
}

/// The velocity of the base origin in the frame of the base, in m/s.
fn leaning(signals: &Signals) -> [f64; 3] {
    let [w, x, y, z] = signals.base_orientation;
    let half_yaw = 0.5 * libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let heading =
        UnitQuaternion::new_unchecked(Quaternion::new(libm::cos(half_yaw), 0.0, 0.0, libm::sin(half_yaw)));
    let base = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    (base.inverse() * (heading * Vector3::from(signals.base_velocity))).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::signals::sample::Sample;

    #[test]
    fn forward_error_and_side_speed_add_up_in_square() {
        let mut world = Sample::new(1);
        world.command_speed = 0.5;
        world.base_velocity = [0.2, -0.4, 9.0];
        assert!(
            (VelocityTracking { k: 3.0, frame: None }.value(&world.signals()) - libm::exp(-0.75)).abs()
                < 1e-12
        );
    }

    #[test]
    fn in_the_frame_of_a_base_that_leans_back_a_walk_also_rises() {
        let mut world = Sample::new(1);
        // Rotated to the left by 0.8 rad, then pitched by -0.3 rad: the base's x axis points up by that much.
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.8);
        let turn = yaw * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -0.3);
        world.base_orientation = [turn.w, turn.i, turn.j, turn.k];
        world.base_velocity = [0.4, 0.1, 0.2];
        let ahead = 0.4 * libm::cos(0.3) + 0.2 * libm::sin(0.3);
        world.command_speed = 0.5;
        let expected = libm::exp(-3.0 * ((ahead - 0.5) * (ahead - 0.5) + 0.1 * 0.1));
        assert!(
            (VelocityTracking { k: 3.0, frame: Some(Frame::Base) }.value(&world.signals()) - expected).abs()
                < 1e-12
        );
    }
}
