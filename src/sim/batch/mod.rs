//! The batch engine: MuJoCo's constraint model in Rust, `f64`, with one environment in each lane of a SIMD
//! value.
//!
//! A robot is a tree of revolute joints under a floating base; its shapes collide with planes, boxes and
//! height fields, but not with each other. The same robot in the same state gives the same bits under every
//! instruction set and in every lane, whatever the other lanes hold: all instruction sets use the same IEEE
//! operations and fused multiply-adds in the same order, and none across lanes.
//!
//! What runs in every physics step is `#[inline(always)]` and loops over indices: iterators such as `zip` and
//! `array::from_fn` are compiled in another part of the crate, without the instruction set, and are not
//! inlined without link-time optimisation.

mod compile;
mod constraint;
mod contact;
mod convex;
mod cylinder;
mod dynamics;
mod figures;
mod group;
mod lane;
mod math;
mod model;
mod newton;
mod scratch;
mod slots;
mod solid;
mod stiffness;
mod translate;
mod tree;
mod work;

use std::sync::{Arc, Mutex};

pub use group::Set;

use super::engine::{Engine, World};
use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use super::worlds::Worlds;
use crate::robot::Robot;
use compile::Compiled;
use model::Ground;
use slots::Slots;

/// Version of the numerics: raise it when a world's numbers change.
pub const REVISION: u32 = 2;

/// The batch engine.
#[derive(Debug, Default)]
pub struct Batch {
    /// The last ground that was built; worlds on equal terrain share it.
    last: Mutex<Option<(Terrain, Arc<Ground>)>>,
    /// The only instruction set to use, for benchmarks; `None` selects one by the number of worlds.
    only: Option<Set>,
}

impl Batch {
    fn ground(&self, terrain: &Terrain) -> Arc<Ground> {
        let mut last = self.last.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match &*last {
            Some((known, ground)) if known == terrain => ground.clone(),
            _ => {
                let ground = Arc::new(translate::ground(terrain));
                *last = Some((terrain.clone(), ground.clone()));
                ground
            }
        }
    }

    /// The engine with one instruction set, or `None` if the processor lacks it. Results do not depend on the
    /// set.
    pub fn under(set: Set) -> Option<Self> {
        Set::available().contains(&set).then(|| Self { only: Some(set), ..Self::default() })
    }

    /// Slots in the lanes of an instruction set, which must be one of [`Set::available`].
    pub fn slots(set: Set, count: usize) -> Box<dyn Worlds> {
        Box::new(Slots::new(set, count))
    }
}

fn refused(reason: impl Into<String>) -> EngineError {
    EngineError::Model { engine: "batch", reason: reason.into() }
}

fn compiled(robot: &Robot, settings: &EngineSettings) -> Result<Compiled, EngineError> {
    Ok(Compiled::new(&translate::model(robot, settings.friction)?, &translate::settings(settings)))
}

/// Inverse weights as MuJoCo defines them in the zero pose: of each joint (`dof_invweight0`) and, for
/// translation, of the base and each link (`body_invweight0`).
pub fn inverse_weights(robot: &Robot) -> Result<(Vec<f64>, Vec<f64>), EngineError> {
    let settings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
    Ok(compiled(robot, &settings)?.inverse_weights())
}

impl Engine for Batch {
    fn name(&self) -> &'static str {
        "batch"
    }

    fn identity(&self) -> String {
        format!("batch {REVISION} f64")
    }

    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        let mut worlds = Slots::new(Set::Scalar, 1);
        worlds.place(0, robot, terrain, settings, state)?;
        Ok(Box::new(Alone(worlds)))
    }

    fn width(&self) -> usize {
        let sets = self.only.map_or_else(Set::available, |set| vec![set]);
        sets.into_iter().map(Set::lanes).max().unwrap_or(1)
    }

    fn worlds(&self, count: usize) -> Option<Box<dyn Worlds>> {
        let sets = self.only.map_or_else(Set::available, |set| vec![set]);
        // The narrowest set that takes all worlds, or the widest available one.
        let set =
            sets.iter().find(|set| set.lanes() >= count).or(sets.last()).copied().unwrap_or(Set::Scalar);
        Some(Self::slots(set, count))
    }
}

/// A single slot.
struct Alone(Slots);

impl World for Alone {
    fn apply(&mut self, torque: &[f64]) {
        self.0.apply(0, torque);
    }

    fn advance(&mut self) {
        self.0.advance();
    }

    fn read(&self, state: &mut State) {
        self.0.read(0, state);
    }

    fn contacts(&self) -> Contacts {
        self.0.contacts(0)
    }

    fn push(&mut self, force: [f64; 3]) {
        self.0.push(0, force);
    }

    fn is_sane(&self) -> bool {
        self.0.is_sane(0)
    }
}
