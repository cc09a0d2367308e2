//! Any number of world slots, in groups that the instruction set can step at once.

use std::sync::Arc;

use super::super::error::EngineError;
use super::super::scene::{Contacts, EngineSettings, State, Terrain};
use super::super::worlds::Worlds;
use super::compile::Compiled;
use super::group::{Group, Set, group};
use super::model::Ground;
use super::{Batch, compiled, refused};
use crate::robot::Robot;

/// Slots in groups. Worlds share a group if their robots have the same tree and the same shapes, on the same
/// ground; a slot that receives another robot moves to another group.
pub(super) struct Slots {
    engine: Batch,
    set: Set,
    halls: Vec<Hall>,
    /// Group and lane of each slot.
    places: Vec<Option<(usize, usize)>>,
}

/// A group and its occupied lanes.
struct Hall {
    group: Box<dyn Group>,
    model: Compiled,
    ground: Arc<Ground>,
    taken: Vec<bool>,
}

impl Hall {
    fn fits(&self, model: &Compiled, ground: &Arc<Ground>) -> bool {
        let same_ground = Arc::ptr_eq(&self.ground, ground) || *self.ground == **ground;
        same_ground && self.model.fits(model)
    }

    fn free(&self) -> Option<usize> {
        self.taken.iter().position(|taken| !taken)
    }
}

impl Slots {
    /// `count` slots, in the lanes of this instruction set.
    pub fn new(set: Set, count: usize) -> Self {
        Self { engine: Batch::default(), set, halls: Vec::new(), places: vec![None; count] }
    }

    /// A lane for a world: its current one if it fits, otherwise a free one, otherwise one of a new group.
    fn lane(
        &mut self,
        old: Option<(usize, usize)>,
        model: &Compiled,
        ground: &Arc<Ground>,
    ) -> Result<(usize, usize), EngineError> {
        if let Some((hall, lane)) = old.filter(|(hall, _)| self.halls[*hall].fits(model, ground)) {
            return Ok((hall, lane));
        }
        for (index, hall) in self.halls.iter().enumerate() {
            if let Some(lane) = hall.free().filter(|_| hall.fits(model, ground)) {
                return Ok((index, lane));
            }
        }
        let lanes = group(self.set, model, ground);
        let group = lanes.ok_or_else(|| refused(format!("this processor has no {:?}", self.set)))?;
        let taken = vec![false; group.lanes()];
        let hall = Hall { group, model: model.clone(), ground: ground.clone(), taken };
        match self.halls.iter().position(|hall| hall.taken.iter().all(|taken| !taken)) {
            Some(empty) => {
                self.halls[empty] = hall;
                Ok((empty, 0))
            }
            None => {
                self.halls.push(hall);
                Ok((self.halls.len() - 1, 0))
            }
        }
    }

    fn at(&self, slot: usize) -> (&dyn Group, usize) {
        let (hall, lane) = self.places[slot].expect("a slot is used after `place` only");
        (&*self.halls[hall].group, lane)
    }

    fn at_mut(&mut self, slot: usize) -> (&mut dyn Group, usize) {
        let (hall, lane) = self.places[slot].expect("a slot is used after `place` only");
        (&mut *self.halls[hall].group, lane)
    }
}

impl Worlds for Slots {
    fn place(
        &mut self,
        slot: usize,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError> {
        let old = self.places[slot].take();
        if let Some((hall, lane)) = old {
            self.halls[hall].taken[lane] = false;
        }
        let model = compiled(robot, settings)?;
        let ground = self.engine.ground(terrain);
        let (hall, lane) = self.lane(old, &model, &ground)?;
        self.halls[hall].taken[lane] = true;
        self.halls[hall].group.load(lane, &model, state);
        self.places[slot] = Some((hall, lane));
        Ok(())
    }

    fn apply(&mut self, slot: usize, torque: &[f64]) {
        let (group, lane) = self.at_mut(slot);
        group.apply(lane, torque);
    }

    fn advance(&mut self) {
        self.halls.iter_mut().for_each(|hall| hall.group.advance());
    }

    fn read(&self, slot: usize, state: &mut State) {
        let (group, lane) = self.at(slot);
        group.read(lane, state);
    }

    fn contacts(&self, slot: usize) -> Contacts {
        let (group, lane) = self.at(slot);
        group.contacts(lane)
    }

    fn push(&mut self, slot: usize, force: [f64; 3]) {
        let (group, lane) = self.at_mut(slot);
        group.push(lane, force);
    }

    fn is_sane(&self, slot: usize) -> bool {
        let (group, lane) = self.at(slot);
        group.is_sane(lane)
    }
}
