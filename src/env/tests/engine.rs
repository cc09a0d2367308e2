//! An engine without physics: the robot stays where it is placed, and all calls are recorded.

use std::sync::{Arc, Mutex};

use crate::robot::Robot;
use crate::sim::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World};

/// The recorded calls.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Torques of every physics step.
    pub torques: Vec<Vec<f64>>,
    /// Forces of pushes.
    pub pushes: Vec<[f64; 3]>,
    /// Robots of the built worlds.
    pub robots: Vec<Robot>,
    /// Friction coefficients.
    pub frictions: Vec<f64>,
}

/// The engine; `drift` (rad) is added to every joint in every physics step, and `speed` is the base's
/// reported velocity.
#[derive(Clone, Debug, Default)]
pub struct Still {
    /// Change of every joint per physics step in rad.
    pub drift: f64,
    /// Forward velocity of the base in m/s after every physics step; 0 leaves it unchanged.
    pub speed: f64,
    /// Contacts reported by every step.
    pub contacts: Contacts,
    /// Physics steps after which the world reports a diverged state; 0 is never.
    pub insane: usize,
    /// Why it refuses every robot; empty if it does not.
    pub refusal: &'static str,
    /// The recorded calls.
    pub record: Arc<Mutex<Record>>,
}

struct StillWorld {
    engine: Still,
    state: State,
    steps: usize,
}

impl Engine for Still {
    fn name(&self) -> &'static str {
        "still"
    }

    fn identity(&self) -> String {
        "still".into()
    }

    fn build(
        &self,
        robot: &Robot,
        _terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        if !self.refusal.is_empty() {
            return Err(EngineError::Model { engine: "still", reason: self.refusal.to_owned() });
        }
        let mut record = self.record.lock().unwrap();
        record.robots.push(robot.clone());
        record.frictions.push(settings.friction);
        Ok(Box::new(StillWorld { engine: self.clone(), state: state.clone(), steps: 0 }))
    }
}

impl World for StillWorld {
    fn apply(&mut self, torque: &[f64]) {
        self.engine.record.lock().unwrap().torques.push(torque.to_vec());
    }

    fn advance(&mut self) {
        self.steps += 1;
        self.state.position.iter_mut().for_each(|position| *position += self.engine.drift);
        if self.engine.speed != 0.0 {
            self.state.base_velocity = [self.engine.speed, 0.0, 0.0];
        }
    }

    fn read(&self, state: &mut State) {
        state.clone_from(&self.state);
    }

    fn contacts(&self) -> Contacts {
        self.engine.contacts
    }

    fn push(&mut self, force: [f64; 3]) {
        self.engine.record.lock().unwrap().pushes.push(force);
    }

    fn is_sane(&self) -> bool {
        self.engine.insane == 0 || self.steps < self.engine.insane
    }
}
