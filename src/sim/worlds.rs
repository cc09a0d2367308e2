//! Worlds in numbered slots that an engine advances together.
//!
//! An engine that steps one world at a time is used through [`Apart`]; one that steps several at once implements
//! [`Worlds`] itself. What happens in one slot never depends on the others.

use std::sync::Arc;

use super::engine::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World};
use crate::robot::Robot;

/// A fixed number of slots, each with the world of one robot. A slot is used after [`Worlds::place`] only.
pub trait Worlds: Send {
    /// Puts a fresh world into a slot, as [`Engine::build`] makes it. After an error the slot holds no world.
    fn place(
        &mut self,
        slot: usize,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError>;

    /// Hands a world the joint torques in N m of the next physics step (already within the effort limits).
    fn apply(&mut self, slot: usize, torque: &[f64]);

    /// Advances one physics step each world that was handed torques since the last call; the others wait.
    fn advance(&mut self);

    /// Writes the current state of a world.
    fn read(&self, slot: usize, state: &mut State);

    /// The contacts of a world's last physics step.
    fn contacts(&self, slot: usize) -> Contacts;

    /// Applies a force in N (world frame) at the base's centre of mass of one world, as [`World::push`] does.
    fn push(&mut self, slot: usize, force: [f64; 3]);

    /// Whether every number of a world's state is finite and within physical reason.
    fn is_sane(&self, slot: usize) -> bool;
}

/// This many slots for worlds of an engine.
pub fn worlds(engine: &Arc<dyn Engine>, count: usize) -> Box<dyn Worlds> {
    engine.worlds(count).unwrap_or_else(|| Box::new(Apart::new(engine.clone(), count)))
}

/// One slot, for an episode that knows nothing of the others.
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

/// Worlds that know nothing of each other, advanced one after the other.
struct Apart {
    engine: Arc<dyn Engine>,
    slots: Vec<Slot>,
}

#[derive(Default)]
struct Slot {
    world: Option<Box<dyn World>>,
    /// Whether the world was handed torques since the last step.
    due: bool,
}

impl Apart {
    fn new(engine: Arc<dyn Engine>, count: usize) -> Self {
        Self { engine, slots: (0..count).map(|_| Slot::default()).collect() }
    }

    fn world(&self, slot: usize) -> &dyn World {
        self.slots[slot].world.as_deref().expect("a slot is used after `place` only")
    }

    fn world_mut(&mut self, slot: usize) -> &mut dyn World {
        self.slots[slot].world.as_deref_mut().expect("a slot is used after `place` only")
    }
}

impl Worlds for Apart {
    fn place(
        &mut self,
        slot: usize,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError> {
        self.slots[slot] = Slot::default();
        self.slots[slot].world = Some(self.engine.build(robot, terrain, settings, state)?);
        Ok(())
    }

    fn apply(&mut self, slot: usize, torque: &[f64]) {
        self.world_mut(slot).apply(torque);
        self.slots[slot].due = true;
    }

    fn advance(&mut self) {
        for slot in self.slots.iter_mut().filter(|slot| slot.due) {
            slot.due = false;
            slot.world.as_deref_mut().expect("a world that was handed torques is there").advance();
        }
    }

    fn read(&self, slot: usize, state: &mut State) {
        self.world(slot).read(state);
    }

    fn contacts(&self, slot: usize) -> Contacts {
        self.world(slot).contacts()
    }

    fn push(&mut self, slot: usize, force: [f64; 3]) {
        self.world_mut(slot).push(force);
    }

    fn is_sane(&self, slot: usize) -> bool {
        self.world(slot).is_sane()
    }
}
