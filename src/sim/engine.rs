//! The trait that every engine implements, and the plain data that crosses it.

use serde::{Deserialize, Serialize};

use super::worlds::Worlds;
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

/// Contacts of one physics step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Force of the ground on the left and the right foot in N, world frame.
    pub foot_force: [[f64; 3]; 2],
    /// Whether any other link touches the ground.
    pub body: bool,
}

/// Something is wrong with an engine.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The engine's library cannot be loaded (R0005).
    #[error("the library of engine `{engine}` cannot be used: {reason}")]
    LibraryMissing {
        /// The engine.
        engine: &'static str,
        /// What the loader said.
        reason: String,
    },
    /// The engine refused the model.
    #[error("engine `{engine}` refused the robot model: {reason}")]
    Model {
        /// The engine.
        engine: &'static str,
        /// What it said.
        reason: String,
    },
}

/// A physics engine: builds worlds.
pub trait Engine: Send + Sync {
    /// Its name in specs.
    fn name(&self) -> &'static str;

    /// Name and version, for the numeric identity of a run.
    fn identity(&self) -> String;

    /// A fresh world that holds this robot on this terrain in this state. The robot's own figures are
    /// the physics: randomization scales them before it comes here. Worlds built from equal arguments
    /// and stepped with equal torques have bit-identical states.
    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError>;

    /// How many worlds it advances together at best. Results do not depend on how many there are.
    fn width(&self) -> usize {
        1
    }

    /// This many slots for worlds that are advanced together; `None` from an engine that steps one world at a time.
    fn worlds(&self, count: usize) -> Option<Box<dyn Worlds>> {
        let _ = count;
        None
    }
}

/// One robot in one world.
pub trait World: Send {
    /// Advances one physics step under these joint torques in N m (already within the effort limits).
    fn step(&mut self, torque: &[f64]) {
        self.apply(torque);
        self.advance();
    }

    /// Hands the engine the joint torques in N m of the next step.
    fn apply(&mut self, torque: &[f64]);

    /// The engine's own step and nothing else, what a program that calls the engine directly pays.
    fn advance(&mut self);

    /// Writes the current state.
    fn read(&self, state: &mut State);

    /// The contacts of the last physics step.
    fn contacts(&self) -> Contacts;

    /// Applies a force in N (world frame) at the base's centre of mass during the following steps; zero
    /// ends it.
    fn push(&mut self, force: [f64; 3]);

    /// Whether every number of the state is finite and within physical reason.
    fn is_sane(&self) -> bool;
}
