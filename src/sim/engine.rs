//! The trait that every engine implements.

use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use super::worlds::Worlds;
use crate::robot::Robot;

/// A physics engine: builds worlds.
pub trait Engine: Send + Sync {
    /// Its name in specs.
    fn name(&self) -> &'static str;

    /// Name and version, part of the numeric identity of a run.
    fn identity(&self) -> String;

    /// A new world with this robot on this terrain in this state. The robot's parameters are used as they
    /// are: randomization has already scaled them. Worlds built from equal arguments and stepped with equal
    /// torques have bit-identical states.
    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError>;

    /// Number of worlds that it advances together most efficiently. Results do not depend on how many there
    /// are.
    fn width(&self) -> usize {
        1
    }

    /// `count` slots for worlds that are advanced together; `None` for an engine that steps one world at a
    /// time.
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

    /// Sets the joint torques in N m of the next step.
    fn apply(&mut self, torque: &[f64]);

    /// The engine's own step without anything else, as in a program that calls the engine directly.
    fn advance(&mut self);

    /// Writes the current state.
    fn read(&self, state: &mut State);

    /// The contacts of the last physics step.
    fn contacts(&self) -> Contacts;

    /// Applies a force in N (world frame) at the base's centre of mass during the following steps; zero
    /// ends it.
    fn push(&mut self, force: [f64; 3]);

    /// Whether every number of the state is finite and within physical bounds.
    fn is_sane(&self) -> bool;
}
