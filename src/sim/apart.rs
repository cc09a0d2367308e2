//! Slots of an engine that steps one world at a time.

use std::sync::Arc;

use super::engine::{Engine, World};
use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use super::worlds::Worlds;
use crate::robot::Robot;

/// `count` slots for worlds of an engine.
pub fn worlds(engine: &Arc<dyn Engine>, count: usize) -> Box<dyn Worlds> {
    engine.worlds(count).unwrap_or_else(|| Box::new(Apart::new(engine.clone(), count)))
}

/// Independent worlds, advanced one after the other.
struct Apart {
    engine: Arc<dyn Engine>,
    slots: Vec<Slot>,
}

#[derive(Default)]
struct Slot {
    world: Option<Box<dyn World>>,
    /// Whether torques were applied to the world since the last step.
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
