//! Balance: returns the robot as a whole to its reference motion, while the joints' PD control returns single
//! joints.
//!
//! The robot is a pendulum on its soles. With its centre of mass c at a height h above the centre of pressure
//! p and a moment M about c it accelerates by a = w^2 (c - p - l), w^2 = g/h, where l = (M_y, -M_x) / (m g)
//! is the share of the moment. The desired acceleration is the reference's plus a spring and a damper to its
//! centre of mass; it is limited so that p stays on the soles in contact. Only joints, attitude and phase are
//! used, because the actor observes nothing else: velocities assume that the feet in contact rest on the
//! ground.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector2, Vector3};

use super::drawn::Drawn;
use crate::kinds::motion::Frame;
use crate::kinds::pretrain::tracking::Balance as Keys;
use crate::robot::{GRAVITY, Kinematics, Robot};

/// Step of the finite difference that gives velocities, in s.
const STEP: f64 = 1e-5;

/// Computes the balancing push for one robot; holds all buffers.
#[derive(Clone, Debug)]
pub struct Balance {
    kinematics: Kinematics,
    /// Gains on the centre of mass's position and velocity error, in units of w^2 and w.
    spring: [f64; 2],
    /// Gain on the base's angle in m g h per rad, and its damping relative to it in s.
    upright: [f64; 2],
    /// Loaded part of each sole: half extents in m.
    soles: [Vector2<f64>; 2],
    moved: Vec<f64>,
}

/// The force and moment that the ground should exert.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// Acceleration of the centre of mass in m/s^2, world frame, x and y.
    pub acceleration: [f64; 2],
    /// Moment about the centre of mass in N m, world frame.
    pub moment: Vector3<f64>,
}

/// The robot's state relative to the feet in contact according to the schedule.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// Vector from the middle of the feet to the centre of mass, in m.
    offset: Vector3<f64>,
    /// Velocity of the centre of mass in m/s.
    velocity: Vector3<f64>,
    /// Angular velocity of the base in rad/s.
    rate: Vector3<f64>,
}

impl Balance {
    /// From the keys of `pretrain.balance`; the centre of pressure stays within this share of the soles.
    pub fn new(keys: &Keys, robot: &Robot, pressure_within: f64) -> Self {
        Self {
            kinematics: Kinematics::new(robot),
            spring: [keys.stiffness, keys.damping],
            upright: [keys.upright, keys.upright_damping],
            soles: robot.feet.each_ref().map(|foot| pressure_within * foot.half_extents.xy()),
            moved: Vec::new(),
        }
    }

    /// The push that returns this state to the reference, with one or both feet on the ground.
    pub fn push(&mut self, drawn: &Drawn, frame: &Frame) -> Push {
        let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), drawn.yaw);
        let [w, x, y, z] = frame.base_orientation;
        let attitude = heading * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let reference = Isometry3::from_parts(drawn.base.translation, attitude);
        self.kinematics.place(&reference, &frame.position);
        let wanted = offset(&self.kinematics, frame.contact);
        let seen = self.seen(drawn, frame.contact);
        let off = seen.offset - wanted;

        let square = GRAVITY / wanted.z;
        let omega = libm::sqrt(square);
        let weight = self.kinematics.total_mass() * GRAVITY;
        let tilt = (drawn.base.rotation * attitude.inverse()).scaled_axis();
        let [upright, upright_damping] = self.upright;
        let mut moment = -(tilt + seen.rate * upright_damping) * (upright * weight * wanted.z);
        moment.z = 0.0;
        let lean = Vector3::new(moment.y, -moment.x, 0.0) / weight;
        let [ahead, aside, _] = frame.base_acceleration;
        let [stiffness, damping] = self.spring;
        let wish = heading * Vector3::new(ahead, aside, 0.0)
            - off * (stiffness * square)
            - seen.velocity * (damping * omega);

        let com = self.kinematics.com().coords - lean;
        let pressure = self.kept(&heading, &(com - wish / square), frame.contact);
        let acceleration = (com - pressure) * square;
        Push { acceleration: [acceleration.x, acceleration.y], moment }
    }

    /// The drawn state relative to the feet in contact; leaves the kinematics in that state.
    fn seen(&mut self, drawn: &Drawn, contact: [bool; 2]) -> Seen {
        let kinematics = &mut self.kinematics;
        self.moved.clear();
        self.moved
            .extend(drawn.position.iter().zip(drawn.swing).map(|(position, swing)| position + STEP * swing));
        // In the frame of a resting foot.
        let from_foot = |kinematics: &Kinematics, side: usize| {
            let sole = kinematics.sole(side);
            (
                sole.inverse_transform_point(&kinematics.com()),
                sole.rotation.inverse() * kinematics.base().rotation,
            )
        };
        kinematics.place(&drawn.base, &self.moved);
        let moved = [0, 1].map(|side| from_foot(kinematics, side));
        kinematics.place(&drawn.base, drawn.position);
        let mut seen =
            Seen { offset: offset(kinematics, contact), velocity: Vector3::zeros(), rate: Vector3::zeros() };
        for (side, share) in shares(contact).into_iter().enumerate() {
            let (com, base) = from_foot(kinematics, side);
            let sole = kinematics.sole(side).rotation;
            seen.velocity += sole * (moved[side].0 - com) * (share / STEP);
            seen.rate += sole * (moved[side].1 * base.inverse()).scaled_axis() * (share / STEP);
        }
        seen
    }

    /// The nearest point to `point` on the soles in contact (a box along the heading), at the soles' height.
    fn kept(&self, heading: &UnitQuaternion<f64>, point: &Vector3<f64>, contact: [bool; 2]) -> Vector3<f64> {
        let along = |point: &Vector3<f64>| (heading.inverse() * point).xy();
        let [left, right] = [0, 1].map(|side| {
            let centre = along(&self.kinematics.sole(side).translation.vector);
            [centre - self.soles[side], centre + self.soles[side]]
        });
        let [low, high] = match contact {
            [true, false] => left,
            [false, true] => right,
            _ => [left[0].inf(&right[0]), left[1].sup(&right[1])],
        };
        heading * along(point).sup(&low).inf(&high).push(0.0)
    }
}

/// The weight of each foot in the state relative to the feet in contact.
fn shares(contact: [bool; 2]) -> [f64; 2] {
    match contact {
        [true, false] => [1.0, 0.0],
        [false, true] => [0.0, 1.0],
        _ => [0.5, 0.5],
    }
}

/// From the middle of the feet in contact to the centre of mass, in m, world frame.
fn offset(kinematics: &Kinematics, contact: [bool; 2]) -> Vector3<f64> {
    let com = kinematics.com().coords;
    let feet = shares(contact).into_iter().enumerate();
    feet.map(|(side, share)| (com - kinematics.sole(side).translation.vector) * share).sum()
}

#[cfg(test)]
mod tests;
