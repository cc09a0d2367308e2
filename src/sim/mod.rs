//! Physics engines behind one trait. Engines only: nothing here knows rewards, policies or specs.

pub mod engine;

pub use engine::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World};
