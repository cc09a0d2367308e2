//! Inputs and outputs of a world in plain numbers: the ground, settings, states, contacts.

use serde::{Deserialize, Serialize};

use crate::robot::Robot;

/// Settings of an engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineSettings {
    /// Physics step in s.
    pub step: f64,
    /// Friction coefficient of the ground.
    pub friction: f64,
    /// Time constant of soft contacts in s (MuJoCo's `solref`); `None` is the engine's default.
    pub contact_time: Option<f64>,
}

/// The ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Terrain {
    /// The plane z = 0.
    Flat,
    /// The plane z = 0 and a box on it: centre x, half extents x, y and height above ground, in m.
    BoxObstacle {
        /// x of the centre in m.
        centre: f64,
        /// Half length along x in m.
        half_length: f64,
        /// Half width along y in m.
        half_width: f64,
        /// Height in m.
        height: f64,
    },
    /// A height field around the origin: heights in m in row-major order (x outer, y inner), square cells.
    HeightField {
        /// Side of a cell in m.
        cell: f64,
        /// Number of samples along x and along y.
        counts: [usize; 2],
        /// Heights in m, `counts[0] * counts[1]` of them, centred on the origin.
        heights: Vec<f64>,
    },
    /// An inclined plane through the origin, rising along x at this angle in rad.
    Slope {
        /// Angle in rad.
        angle: f64,
    },
}

/// The state of a robot. World frame z up; joint vectors in joint order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Position of the base origin in m.
    pub base_position: [f64; 3],
    /// Orientation of the base, unit quaternion w x y z, world from base.
    pub base_orientation: [f64; 4],
    /// Velocity of the base *origin* in the world frame in m/s.
    pub base_velocity: [f64; 3],
    /// Angular velocity of the base in the world frame in rad/s.
    pub base_rate: [f64; 3],
    /// Joint positions in rad.
    pub position: Vec<f64>,
    /// Joint velocities in rad/s.
    pub velocity: Vec<f64>,
}

impl State {
    /// A robot at rest in its default pose, standing on level ground.
    pub fn of(robot: &Robot) -> Self {
        Self {
            base_position: [0.0, 0.0, robot.standing_height],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            position: robot.default_pose(),
            velocity: vec![0.0; robot.joints()],
            ..Self::default()
        }
    }
}

/// Contacts of one physics step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Force of the ground on the left and the right foot in N, world frame.
    pub foot_force: [[f64; 3]; 2],
    /// Whether any other link touches the ground.
    pub body: bool,
}
