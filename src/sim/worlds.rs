//! Numbered slots of worlds that an engine advances together.
//!
//! An engine that steps several worlds at once implements [`Worlds`] itself; `apart` does so for the others.
//! Slots are independent of each other.

use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use crate::robot::Robot;

/// A fixed number of slots, each with the world of one robot. A slot must be filled by [`Worlds::place`]
/// before use.
pub trait Worlds: Send {
    /// Puts a new world into a slot, as [`Engine::build`](super::Engine::build) makes it. After an error the
    /// slot is empty.
    fn place(
        &mut self,
        slot: usize,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError>;

    /// Sets the joint torques in N m of a world's next physics step (already within the effort limits).
    fn apply(&mut self, slot: usize, torque: &[f64]);

    /// Advances by one physics step each world whose torques were set since the last call; the others do not
    /// change.
    fn advance(&mut self);

    /// Writes the current state of a world.
    fn read(&self, slot: usize, state: &mut State);

    /// The contacts of a world's last physics step.
    fn contacts(&self, slot: usize) -> Contacts;

    /// Applies a force in N (world frame) at the base's centre of mass of one world, as
    /// [`World::push`](super::World::push) does.
    fn push(&mut self, slot: usize, force: [f64; 3]);

    /// Whether every number of a world's state is finite and within physical bounds.
    fn is_sane(&self, slot: usize) -> bool;
}

/// One slot, for an episode that is independent of the others.
pub struct Seat<'a> {
    /// All slots.
    pub worlds: &'a mut dyn Worlds,
    /// The slot.
    pub index: usize,
}

impl Seat<'_> {
    /// See [`Worlds::place`].
    pub fn place(
        &mut self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError> {
        self.worlds.place(self.index, robot, terrain, settings, state)
    }

    /// See [`Worlds::apply`].
    pub fn apply(&mut self, torque: &[f64]) {
        self.worlds.apply(self.index, torque);
    }

    /// See [`Worlds::read`].
    pub fn read(&self, state: &mut State) {
        self.worlds.read(self.index, state);
    }

    /// See [`Worlds::contacts`].
    pub fn contacts(&self) -> Contacts {
        self.worlds.contacts(self.index)
    }

    /// See [`Worlds::push`].
    pub fn push(&mut self, force: [f64; 3]) {
        self.worlds.push(self.index, force);
    }

    /// See [`Worlds::is_sane`].
    pub fn is_sane(&self) -> bool {
        self.worlds.is_sane(self.index)
    }
}
