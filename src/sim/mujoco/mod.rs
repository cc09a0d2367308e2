//! The MuJoCo engine, double precision: the usual target of sim-to-sim transfer.
//!
//! It loads the MJCF of [`super::mjcf`]; every world has its own `mjModel` and `mjData`, and worlds of one
//! geometry share its compilation. libmujoco is loaded when the engine is opened ([`library`]); a missing
//! library, or one of another version than the bindings, is an error (R0005) rather than a crash.

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
mod library;
mod skeleton;

use std::sync::{Arc, Mutex, Once};

use mujoco_rs::mujoco_c::{mj_version, mjVERSION_HEADER};
use mujoco_rs::prelude::{MjData, MjLogMessage, MjModel, MjtLogLevel, set_log_handler};

use super::engine::{Engine, World};
use super::error::EngineError;
use super::scene::{Contacts, EngineSettings, State, Terrain};
use crate::crash;
use crate::robot::Robot;
use skeleton::Skeleton;

/// Joint speed in rad/s above which a state counts as diverged.
const MAX_RATE: f64 = 1000.0;
/// Distance in m from the origin above which a state counts as diverged.
const MAX_DISTANCE: f64 = 1000.0;

/// The MuJoCo engine.
#[derive(Debug)]
pub struct Mujoco {
    /// The last compiled geometry; worlds with the same geometry share it.
    last: Mutex<Option<Arc<Skeleton>>>,
}

impl Mujoco {
    /// The engine, if the library can be loaded and matches the bindings.
    pub fn new() -> Result<Self, EngineError> {
        static LOG: Once = Once::new();
        #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
        library::load().map_err(|reason| EngineError::LibraryMissing { engine: "mujoco", reason })?;
        // SAFETY: only reads a number from the library.
        let linked = unsafe { mj_version() } as u32;
        if linked != mjVERSION_HEADER {
            let reason = format!("its version number is {linked}, but {mjVERSION_HEADER} is required");
            return Err(EngineError::LibraryMissing { engine: "mujoco", reason });
        }
        // SAFETY: models and worlds come from an engine, and no engine exists before this has run.
        LOG.call_once(|| unsafe { set_log_handler(hear) });
        Ok(Self { last: Mutex::new(None) })
    }

    /// The compiled geometry of a robot on its terrain.
    fn skeleton(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
    ) -> Result<Arc<Skeleton>, EngineError> {
        let last = || self.last.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let known = last().clone();
        if let Some(known) = known.filter(|known| known.fits(robot, terrain, settings)) {
            return Ok(known);
        }
        let skeleton = Arc::new(Skeleton::compile(robot, terrain, settings)?);
        // The previous geometry is dropped after the lock is released.
        let outgoing = last().replace(skeleton.clone());
        drop(outgoing);
        Ok(skeleton)
    }
}

fn refused(error: &dyn std::fmt::Display) -> EngineError {
    EngineError::Model { engine: "mujoco", reason: error.to_string() }
}

/// Handles MuJoCo's messages. Its errors must not return, so they end the process; other messages are
/// dropped, because MuJoCo's handler would write them to files in the working folder. The states that they
/// warn of are detected by [`World::is_sane`].
fn hear(message: &MjLogMessage) {
    if message.level() == MjtLogLevel::mjLOG_ERROR {
        crash::fatal("MuJoCo", message.subject());
    }
}

impl Engine for Mujoco {
    fn name(&self) -> &'static str {
        "mujoco"
    }

    fn identity(&self) -> String {
        format!("mujoco {} f64", mujoco_rs::mujoco_version())
    }

    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        let skeleton = self.skeleton(robot, terrain, settings)?;
        let data = skeleton.with_figures(robot, settings.friction)?;
        let mut world = MujocoWorld { data, skeleton };
        world.place(state);
        Ok(Box::new(world))
    }
}

/// One robot in one MuJoCo world. The free joint comes first: seven positions, six velocities, the
/// angular ones in the base frame.
struct MujocoWorld {
    data: MjData<Box<MjModel>>,
    skeleton: Arc<Skeleton>,
}

/// Body 1 is the base: the world is body 0 and the base comes first.
const BASE: usize = 1;

impl MujocoWorld {
    fn place(&mut self, state: &State) {
        let positions = self.data.qpos_mut();
        positions[..3].copy_from_slice(&state.base_position);
        positions[3..7].copy_from_slice(&state.base_orientation);
        for (slot, value) in self.skeleton.slots.iter().zip(&state.position) {
            positions[slot.position] = *value;
        }
        let local = turned(conjugate(state.base_orientation), state.base_rate);
        let velocities = self.data.qvel_mut();
        velocities[..3].copy_from_slice(&state.base_velocity);
        velocities[3..6].copy_from_slice(&local);
        for (slot, value) in self.skeleton.slots.iter().zip(&state.velocity) {
            velocities[slot.velocity] = *value;
        }
    }
}

impl World for MujocoWorld {
    fn apply(&mut self, torque: &[f64]) {
        self.data.ctrl_mut().copy_from_slice(torque);
    }

    fn advance(&mut self) {
        self.data.step();
    }

    fn read(&self, state: &mut State) {
        let (positions, velocities) = (self.data.qpos(), self.data.qvel());
        let three = |from: &[f64]| [from[0], from[1], from[2]];
        state.base_position = three(positions);
        state.base_orientation = [positions[3], positions[4], positions[5], positions[6]];
        state.base_velocity = three(velocities);
        state.base_rate = turned(state.base_orientation, three(&velocities[3..]));
        state.position.clear();
        state.position.extend(self.skeleton.slots.iter().map(|slot| positions[slot.position]));
        state.velocity.clear();
        state.velocity.extend(self.skeleton.slots.iter().map(|slot| velocities[slot.velocity]));
    }

    fn contacts(&self) -> Contacts {
        let mut contacts = Contacts::default();
        for (index, contact) in self.data.contact().iter().enumerate() {
            if contact.efc_address < 0 {
                continue;
            }
            let geoms = contact.geom.map(|geom| geom as usize);
            // The force acts on the second geom; the robot may be either.
            match self.skeleton.soles.iter().position(|sole| geoms.contains(sole)) {
                Some(side) => {
                    let sign = if geoms[1] == self.skeleton.soles[side] { 1.0 } else { -1.0 };
                    let force = self.data.contact_force(index);
                    for axis in 0..3 {
                        let sum: f64 = (0..3).map(|row| contact.frame[3 * row + axis] * force[row]).sum();
                        contacts.foot_force[side][axis] += sign * sum;
                    }
                }
                None => contacts.body = true,
            }
        }
        contacts
    }

    fn push(&mut self, force: [f64; 3]) {
        self.data.xfrc_applied_mut()[BASE][..3].copy_from_slice(&force);
    }

    fn is_sane(&self) -> bool {
        // Comparisons with NaN are false, so NaN is caught, too.
        let near = self.data.qpos().iter().all(|value| value.abs() < MAX_DISTANCE);
        near && self.data.qvel().iter().all(|rate| rate.abs() < MAX_RATE)
    }
}

fn conjugate([w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [w, -x, -y, -z]
}

/// A vector rotated by a unit quaternion w x y z.
fn turned([w, x, y, z]: [f64; 4], [a, b, c]: [f64; 3]) -> [f64; 3] {
    let (i, j, k) = (2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a));
    [a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i]
}
