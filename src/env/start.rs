//! Initial states of episodes: the standing pose, or any phase of the reference motion.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::attitude;
use super::stature::Stature;
use crate::kinds::initial::Initial;
use crate::kinds::initial::reference::Velocities;
use crate::kinds::motion::{Frame, Motion};
use crate::robot::{Kinematics, Robot};
use crate::sim::{State, Terrain};
use crate::spec::Sampler;
use crate::stream::Stream;

/// Height in m of the lowest sole above the ground at a start on the reference.
const CLEARANCE: f64 = 5e-4;

/// Distribution of initial states.
#[derive(Clone, Debug, PartialEq)]
pub struct StartPlan {
    standing_share: f64,
    phases: Vec<f64>,
    at_rest: bool,
    standing_noise: Sampler,
    joint_noise: Sampler,
    rate_noise: Sampler,
    base_velocity_noise: Sampler,
    base_rate_noise: Sampler,
}

/// The start of one episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// State of the robot.
    pub state: State,
    /// Phase of the motion.
    pub phase: f64,
    /// Whether the start is the default pose.
    pub standing: bool,
    /// Whether the robot has been at rest, rather than moving along the reference.
    pub at_rest: bool,
}

/// The world that a start is placed in.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The robot of this episode.
    pub robot: &'a Robot,
    /// The robot that the reference motion was made for.
    pub nominal: &'a Robot,
    /// The reference motion.
    pub motion: &'a Motion,
    /// The ground.
    pub terrain: &'a Terrain,
}

impl StartPlan {
    /// The plan of `[initial]`.
    pub fn new(initial: &Initial) -> Self {
        let none = || Sampler::Constant(0.0);
        match initial {
            Initial::DefaultPose(pose) => Self {
                standing_noise: pose.standing_noise.clone().unwrap_or_else(none),
                ..Self::standing(pose.phases.clone(), 0.0)
            },
            Initial::OnReference(start) => Self {
                standing_share: start.standing_share,
                phases: start.phases.clone(),
                standing_noise: start.standing_noise.clone().unwrap_or_else(none),
                at_rest: start.velocities == Some(Velocities::Rest),
                joint_noise: start.position_noise.clone(),
                rate_noise: start.velocity_noise.clone(),
                base_velocity_noise: start.base_velocity_noise.clone(),
                base_rate_noise: start.base_rate_noise.clone(),
            },
        }
    }

    /// Always the default pose at rest, at one of these phases, with the joints perturbed by normal noise of
    /// this standard deviation in rad.
    pub fn standing(phases: Vec<f64>, perturbation: f64) -> Self {
        let none = Sampler::Constant(0.0);
        Self {
            standing_share: 1.0,
            phases,
            at_rest: true,
            standing_noise: if perturbation > 0.0 {
                Sampler::Normal([0.0, perturbation])
            } else {
                none.clone()
            },
            joint_noise: none.clone(),
            rate_noise: none.clone(),
            base_velocity_noise: none.clone(),
            base_rate_noise: none,
        }
    }

    /// Draws a start.
    pub fn draw(&self, place: &Place, stream: &mut Stream) -> Start {
        if stream.uniform() < self.standing_share {
            self.stand(place, stream)
        } else {
            self.join(place, stream)
        }
    }

    /// The default pose at rest, perturbed as in evaluations or as `[initial]` allows in training.
    fn stand(&self, place: &Place, stream: &mut Stream) -> Start {
        let phase = if self.phases.is_empty() { 0.0 } else { self.phases[stream.below(self.phases.len())] };
        let mut position = place.robot.default_pose();
        shake(&mut position, &self.standing_noise, place.robot, stream);
        let mut kinematics = Kinematics::new(place.robot);
        kinematics.place(&Isometry3::identity(), &position);
        let height = grounded(&kinematics, place);
        let state = State {
            base_position: [0.0, 0.0, height],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            velocity: vec![0.0; position.len()],
            position,
            ..State::default()
        };
        Start { state, phase, standing: true, at_rest: true }
    }

    /// A state of the reference, with its velocities or at rest, with noise. The stance foot keeps the
    /// attitude and the velocity that it has in the reference: noise in its joints, or longer legs, move the
    /// base.
    fn join(&self, place: &Place, stream: &mut Stream) -> Start {
        let phase = stream.uniform();
        let mut frame = Frame::default();
        place.motion.state_at(phase, &mut frame);
        if self.at_rest {
            frame.velocity.fill(0.0);
            (frame.base_velocity, frame.base_rate) = ([0.0; 3], [0.0; 3]);
        }
        let mut position = frame.position.clone();
        shake(&mut position, &self.joint_noise, place.robot, stream);
        let mut velocity = frame.velocity.clone();
        velocity.iter_mut().for_each(|velocity| *velocity += stream.draw(&self.rate_noise));

        let mut reference = Kinematics::new(place.nominal);
        reference.place(
            &Isometry3::from_parts(Translation3::identity(), quaternion(frame.base_orientation)),
            &frame.position,
        );
        let coin = usize::from(stream.uniform() < 0.5);
        let stance = [coin, 1 - coin].into_iter().find(|side| frame.contact[*side]);
        let mut base = *reference.base();
        let mut kinematics = Kinematics::new(place.robot);
        kinematics.place(&base, &position);
        let yaw = attitude::yaw(frame.base_orientation);
        let mut linear = Vector3::from(attitude::turned(frame.base_velocity, yaw));
        let mut angular = Vector3::from(attitude::turned(frame.base_rate, yaw));
        if let Some(side) = stance {
            let link = reference.foot_link(side);
            base.rotation =
                reference.pose(link).rotation * kinematics.pose(link).rotation.inverse() * base.rotation;
            let (foot, turn) = twist(&reference, side, &frame.velocity);
            let lever = reference.sole(side).translation.vector;
            let foot = foot + linear + angular.cross(&lever);
            let turn = turn + angular;
            kinematics.place(&base, &position);
            let (by_joints, turn_by_joints) = twist(&kinematics, side, &velocity);
            angular = turn - turn_by_joints;
            linear = foot - by_joints - angular.cross(&kinematics.sole(side).translation.vector);
        }
        let floor = grounded(&kinematics, place);
        let height = match stance {
            Some(_) => floor,
            None => {
                if let Some(mut stature) = Stature::of(place.nominal, place.robot) {
                    stature.follow(&mut frame);
                }
                floor.max(frame.base_height + place.terrain.height(0.0, 0.0))
            }
        };
        let rotation = base.rotation.quaternion();
        let mut noisy = |vector: Vector3<f64>, noise: &Sampler| {
            [vector.x + stream.draw(noise), vector.y + stream.draw(noise), vector.z + stream.draw(noise)]
        };
        let state = State {
            base_position: [0.0, 0.0, height + CLEARANCE],
            base_orientation: [rotation.w, rotation.i, rotation.j, rotation.k],
            base_velocity: noisy(linear, &self.base_velocity_noise),
            base_rate: noisy(angular, &self.base_rate_noise),
            position,
            velocity,
        };
        Start { state, phase, standing: false, at_rest: self.at_rest }
    }
}

/// Adds noise to joint positions, within the joints' ranges.
fn shake(position: &mut [f64], noise: &Sampler, robot: &Robot, stream: &mut Stream) {
    for (position, link) in position.iter_mut().zip(&robot.links) {
        let shaken = *position + stream.draw(noise);
        *position = shaken.clamp(link.joint.lower, link.joint.upper);
    }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// Velocity in m/s of a sole's centre and angular velocity in rad/s of the foot due to the joints alone, with
/// the base at rest.
fn twist(kinematics: &Kinematics, side: usize, velocity: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let sole = kinematics.sole(side).translation.vector;
    let mut linear = Vector3::zeros();
    let mut angular = Vector3::zeros();
    for joint in kinematics.chain(kinematics.foot_link(side)) {
        let rate = kinematics.axis(joint) * velocity[joint];
        linear += rate.cross(&(sole - kinematics.pose(joint).translation.vector));
        angular += rate;
    }
    (linear, angular)
}

/// Height in m of the base origin at which both soles just touch the ground without penetrating it, for
/// kinematics whose base is at the origin. Considers corners and anything that protrudes below the middle of
/// a sole.
fn grounded(kinematics: &Kinematics, place: &Place) -> f64 {
    let mut height = f64::NEG_INFINITY;
    for side in 0..2 {
        let sole = kinematics.sole(side);
        let half = place.robot.feet[side].half_extents;
        for face in FACES {
            let corners =
                face.map(|[x, y, z]| sole * Point3::new(x * half.x, y * half.y, (z + 1.0) * half.z));
            height = height.max(place.terrain.above(&corners.map(|corner| corner.coords.into())));
        }
    }
    height
}

/// The faces of the sole's box, corners in units of its half extents; the sole itself comes first.
const FACES: [[[f64; 3]; 4]; 6] = {
    const fn turned(axis: usize, side: f64) -> [[f64; 3]; 4] {
        let mut corners = [[side; 3]; 4];
        let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let mut corner = 0;
        while corner < 4 {
            corners[corner][(axis + 1) % 3] = signs[corner][0];
            corners[corner][(axis + 2) % 3] = signs[corner][1];
            corner += 1;
        }
        corners
    }
    [turned(2, -1.0), turned(2, 1.0), turned(0, -1.0), turned(0, 1.0), turned(1, -1.0), turned(1, 1.0)]
};
