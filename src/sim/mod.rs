//! Physics engines behind one trait. Engines only: nothing here knows rewards, policies or specs.
//!
//! Every engine builds the same robot: the links' collision shapes touch the ground only, never each
//! other, and a foot's link has exactly one shape, the box of its sole. Joint limits, damping,
//! friction and armature are those of the [`crate::robot::Robot`].

pub mod engine;
pub mod terrain;

#[cfg(feature = "rapier")]
pub mod rapier;

pub use engine::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World};
