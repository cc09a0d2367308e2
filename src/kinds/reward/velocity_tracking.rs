//! The reward term `velocity_tracking`.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::{kernel, squared_error};
use crate::kinds::{Entry, Reward, RewardKind, Signals};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: RewardKind = Entry {
    kind: Kind {
        name: "velocity_tracking",
        since: Edition::ONE,
        doc: include_str!("velocity_tracking.md"),
        params: &[
            Param::required("k", Ty::Quantity(Dimension::PER_VELOCITY_SQUARED))
                .range(1e-9, 1e9)
                .doc("Sharpness of the kernel."),
            Param::optional("frame", Ty::Choice(&["base", "heading"])).doc(
                "Whose x and y axes: those of the heading frame, which is also what is meant without this key, or of the \
                 base, which lean with it.",
            ),
        ],
        needs: &[Signal::BaseVelocity],
    },
    build: |section| Box::new(Term { k: section.si("k"), leans: section.text_if("frame") == Some("base") }),
};

struct Term {
    k: f64,
    /// Whether the axes are those of the base.
    leans: bool,
}

impl Reward for Term {
    fn value(&self, signals: &Signals) -> f64 {
        let velocity = if self.leans { leaning(signals) } else { signals.base_velocity };
        kernel(self.k, squared_error(&velocity, signals.command_speed))
    }
}

/// The velocity of the base origin in the frame of the base, in m/s.
fn leaning(signals: &Signals) -> [f64; 3] {
    let [w, x, y, z] = signals.base_orientation;
    let half_yaw = 0.5 * libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let heading = UnitQuaternion::new_unchecked(Quaternion::new(libm::cos(half_yaw), 0.0, 0.0, libm::sin(half_yaw)));
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
        assert!((Term { k: 3.0, leans: false }.value(&world.signals()) - libm::exp(-0.75)).abs() < 1e-12);
    }

    #[test]
    fn in_the_frame_of_a_base_that_leans_back_a_walk_also_rises() {
        let mut world = Sample::new(1);
        // Turned to the left by 0.8 rad, then pitched by -0.3 rad: the base's x axis points up by that much.
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.8);
        let turn = yaw * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -0.3);
        world.base_orientation = [turn.w, turn.i, turn.j, turn.k];
        world.base_velocity = [0.4, 0.1, 0.2];
        let ahead = 0.4 * libm::cos(0.3) + 0.2 * libm::sin(0.3);
        world.command_speed = 0.5;
        let expected = libm::exp(-3.0 * ((ahead - 0.5) * (ahead - 0.5) + 0.1 * 0.1));
        assert!((Term { k: 3.0, leans: true }.value(&world.signals()) - expected).abs() < 1e-12);
    }
}
