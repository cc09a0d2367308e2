//! The labels of `tracking`: gravity compensation of the scheduled contacts and a soft PD to the reference
//! motion.

use nalgebra::{Isometry3, Vector3};

use super::balance::{Balance, Push};
use super::drawn::{Drawn, Drive};
use crate::kinds::motion::Frame;
use crate::kinds::pretrain::Tracking as Keys;
use crate::robot::{GRAVITY, GravityCompensation, Robot, felt_gravity};

/// The labels' settings in `[pretrain]`.
#[derive(Clone, Debug)]
pub struct Tracking {
    /// Factor on the robot's own proportional gain.
    stiffness: f64,
    /// Factor on the robot's own derivative gain.
    damping: f64,
    /// Whether inertial forces of the reference motion are added.
    inertial: bool,
    /// Whether gravity includes the acceleration of the reference motion's base.
    tilted_gravity: bool,
    /// Share of the sole within which the centre of pressure stays; without it a foot supports any moment.
    pressure_within: Option<f64>,
    /// Balance of the robot as a whole, if set.
    balance: Option<Balance>,
}

impl Tracking {
    /// The labels of `[pretrain]` for this robot.
    pub fn new(keys: &Keys, robot: &Robot) -> Self {
        let within = keys.pressure_within.unwrap_or(1.0);
        Self {
            stiffness: keys.stiffness,
            damping: keys.damping,
            inertial: keys.inertial,
            tilted_gravity: keys.tilted_gravity == Some(true),
            pressure_within: keys.pressure_within,
            balance: keys.balance.as_ref().map(|balance| Balance::new(balance, robot, within)),
        }
    }

    /// Appends the torques in N m, in joint order.
    pub fn torques(
        &mut self,
        gravity: &mut GravityCompensation,
        joints: &[Drive],
        drawn: &Drawn,
        frame: &Frame,
        torque: &mut Vec<f64>,
    ) {
        let push = match &mut self.balance {
            Some(balance) if frame.contact != [false, false] => balance.push(drawn, frame),
            _ => {
                let [x, y, _] = frame.base_acceleration;
                Push { acceleration: if self.tilted_gravity { [x, y] } else { [0.0; 2] }, ..Push::default() }
            }
        };
        let (upright, heavier) = felt_gravity(push.acceleration);
        let felt = Felt { base: upright * drawn.base, moment: upright * push.moment / heavier };
        self.hold(gravity, &felt, drawn.position, frame.contact, torque);
        let load =
            heavier * if self.inertial { (1.0 + frame.base_acceleration[2] / GRAVITY).max(0.0) } else { 1.0 };
        for (joint, drive) in joints.iter().enumerate() {
            let inertia = if self.inertial { drive.armature * frame.acceleration[joint] } else { 0.0 };
            let spring = self.stiffness * drive.stiffness * (frame.position[joint] - drawn.position[joint]);
            let damper = self.damping * drive.damping * drawn.swing[joint];
            torque[joint] = load * torque[joint] + inertia + spring - damper;
        }
    }

    /// Appends the torques that hold a pose on the feet in contact.
    fn hold(
        &self,
        gravity: &mut GravityCompensation,
        felt: &Felt,
        position: &[f64],
        contact: [bool; 2],
        torque: &mut Vec<f64>,
    ) {
        let held = gravity.hold_turning(&felt.base, position, contact, &felt.moment);
        let pulls = held.wrench.each_ref().map(|wrench| wrench[2] < 0.0);
        if self.balance.is_some() && pulls[0] != pulls[1] {
            gravity.hold_turning(&felt.base, position, pulls.map(|pulls| !pulls), &felt.moment);
        }
        match self.pressure_within.or(self.balance.as_ref().map(|_| 1.0)) {
            Some(share) => torque.extend(&gravity.keep_pressure_within(share).torque),
            None => torque.extend(&gravity.balance().torque),
        }
    }
}

/// Effective gravity at the base, and the moment in N m that rotates the base.
struct Felt {
    base: Isometry3<f64>,
    moment: Vector3<f64>,
}
