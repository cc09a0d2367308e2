//! Randomizations: differences between episodes other than the policy's own noise.

pub mod action_delay;
pub mod foot_friction;
pub mod ground_friction;
pub mod joint_damping;
pub mod joint_friction;
pub mod joint_offset;
pub mod leg_length;
pub mod link_com;
pub mod link_inertia;
pub mod link_mass;
pub mod motor_constant;
pub mod payload;
pub mod push;

use super::Entry;
use crate::robot::Robot;
use crate::robot::model::Body;
use crate::spec::typed::prelude::*;
use crate::spec::{Kind, Sampler};
use crate::stream::Stream;

/// The physics of one episode while it is being drawn.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The robot.
    pub robot: Robot,
    /// Friction coefficient of the ground.
    pub friction: f64,
    /// Factor on the nominal action delay.
    pub delay: f64,
    /// Factor on each joint's torque.
    pub motor: Vec<f64>,
    /// Offset of each joint's measured position in rad.
    pub joint_offset: Vec<f64>,
    /// The pushes of the episode.
    pub pushes: Vec<Push>,
    /// Time limit of the episode in s.
    pub episode: f64,
}

/// A constant force on the base for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Begin in s since the start of the episode.
    pub start: f64,
    /// End in s.
    pub end: f64,
    /// Force in N, world frame.
    pub force: [f64; 3],
}

/// A row of the randomization table.
pub trait Randomization: Send + Sync {
    /// Draws from the row's own stream and changes the draft.
    fn apply(&self, draft: &mut Draft, stream: &mut Stream);
}

/// An entry of the randomization registry.
pub type RandomizationKind = Entry<dyn Randomization>;

impl RandomizationKind {
    const fn of<Row: Declared + Randomization + 'static>() -> Self {
        Self { kind: Row::KIND, build: |section| Box::new(section.read::<Row>()) }
    }
}

/// Every randomization kind, sorted by name; they are applied in this order.
pub static KINDS: &[&RandomizationKind] = &[
    &RandomizationKind::of::<action_delay::ActionDelay>(),
    &RandomizationKind::of::<foot_friction::FootFriction>(),
    &RandomizationKind::of::<ground_friction::GroundFriction>(),
    &RandomizationKind::of::<joint_damping::JointDamping>(),
    &RandomizationKind::of::<joint_friction::JointFriction>(),
    &RandomizationKind::of::<joint_offset::JointOffset>(),
    &RandomizationKind::of::<leg_length::LegLength>(),
    &RandomizationKind::of::<link_com::LinkCom>(),
    &RandomizationKind::of::<link_inertia::LinkInertia>(),
    &RandomizationKind::of::<link_mass::LinkMass>(),
    &RandomizationKind::of::<motor_constant::MotorConstant>(),
    &RandomizationKind::of::<payload::Payload>(),
    &RandomizationKind::of::<push::Pushes>(),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

terms! {
    /// Randomized properties of episodes.
    pub struct Rows in "randomize", "randomization";
}

impl Draft {
    /// The nominal physics.
    pub fn new(robot: Robot, friction: f64, episode: f64) -> Self {
        let joints = robot.joints();
        Self {
            robot,
            friction,
            delay: 1.0,
            motor: vec![1.0; joints],
            joint_offset: vec![0.0; joints],
            pushes: Vec::new(),
            episode,
        }
    }

    /// The rigid bodies: the base, then the links.
    fn bodies(&mut self) -> impl Iterator<Item = &mut Body> {
        std::iter::once(&mut self.robot.base).chain(self.robot.links.iter_mut().map(|link| &mut link.body))
    }
}

/// The key that says whether factors are drawn apart or one for the robot.
pub const PER: &str = joint_friction::JointFriction::per.name;
/// Its word for one factor for the robot.
pub const ONE_FOR_ALL: &str = PerJoint::Robot.word();

choice! {
    /// Whether factors are drawn per joint or per robot.
    pub enum PerJoint {
        /// Every joint has its own factor.
        Joint = "joint",
        /// All joints share one factor.
        Robot = "robot",
    }
}

choice! {
    /// Whether factors are drawn per link or per robot.
    pub enum PerLink {
        /// Every link has its own factor.
        Link = "link",
        /// All links share one factor.
        Robot = "robot",
    }
}

choice! {
    /// Whether factors are drawn per foot or per robot.
    pub enum PerFoot {
        /// Each foot has its own factor.
        Foot = "foot",
        /// Both feet share one factor.
        Robot = "robot",
    }
}

/// `count` factors, drawn separately or, if shared, all equal.
fn factors(scale: &Sampler, shared: bool, count: usize, stream: &mut Stream) -> Vec<f64> {
    if shared { vec![stream.draw(scale); count] } else { (0..count).map(|_| stream.draw(scale)).collect() }
}

#[cfg(test)]
mod sample {
    //! A robot with a base and two links.

    use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

    use super::Draft;
    use crate::robot::model::{Body, Foot, Joint, Link, Robot};

    fn body(name: &str, mass: f64) -> Body {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.15));
        Body { name: name.into(), mass, com: Point3::new(0.01, 0.0, -0.1), inertia, collisions: Vec::new() }
    }

    fn link(name: &str, parent: Option<usize>) -> Link {
        let joint = Joint {
            name: name.into(),
            origin: Isometry3::translation(0.0, 0.0, -0.4),
            axis: Vector3::y_axis(),
            lower: -1.0,
            upper: 1.0,
            effort_limit: 100.0,
            velocity_limit: 10.0,
            damping: 2.0,
            friction: 4.0,
            armature: 0.1,
            stiffness_gain: 1000.0,
            damping_gain: 10.0,
            default_position: 0.0,
        };
        Link { body: body(name, 5.0), parent, joint }
    }

    /// The nominal physics of that robot for 16 s.
    pub fn draft() -> Draft {
        let foot = Foot {
            link: 1,
            half_extents: Vector3::new(0.1, 0.05, 0.01),
            centre: Point3::new(0.0, 0.0, -0.1),
            friction: 1.0,
        };
        let robot = Robot {
            name: "test".into(),
            base: body("base", 40.0),
            links: vec![link("thigh", None), link("shank", Some(0))],
            feet: [foot.clone(), foot],
            mirror: vec![(0, 1.0), (1, 1.0)],
            standing_height: 0.91,
        };
        Draft::new(robot, 1.0, 16.0)
    }
}
