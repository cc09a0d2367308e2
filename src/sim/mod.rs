//! Physics engines behind one trait. Independent of rewards, policies and specs.
//!
//! Every engine builds the same robot: the links' collision shapes collide with the ground but not with each
//! other, and a foot's link has exactly one shape, the box of its sole. Joint limits, damping, friction and
//! armature are those of the [`crate::robot::Robot`].

mod apart;
pub mod catalogue;
pub mod engine;
pub mod engines;
pub mod error;
pub mod mjcf;
mod patch;
pub mod scene;
pub mod terrain;
pub mod worlds;

#[cfg(feature = "batch")]
pub mod batch;
#[cfg(feature = "mujoco")]
pub mod mujoco;
#[cfg(feature = "rapier")]
pub mod rapier;

use std::sync::Arc;

pub use apart::worlds;
pub use engine::{Engine, World};
pub use engines::{EngineFacts, EngineName};
pub use error::EngineError;
pub use scene::{Contacts, EngineSettings, State, Terrain};
pub use worlds::{Seat, Worlds};

/// Names of the engines in specs; a build may lack some.
pub const ENGINES: &[&str] = EngineName::WORDS;

/// The engine with this name, or R0005 if this build or machine lacks it.
pub fn open(name: &str) -> Result<Arc<dyn Engine>, EngineError> {
    let unknown =
        || EngineError::LibraryMissing { engine: "unknown", reason: format!("unknown engine `{name}`") };
    EngineName::named(name).ok_or_else(unknown)?.open()
}

/// Instruction sets of the batch engine.
pub const INSTRUCTIONS: &[&str] = &["scalar", "avx2", "avx512"];

/// The batch engine with one of these instruction sets, for benchmarks.
pub fn batch_under(instructions: &str) -> Result<Arc<dyn Engine>, EngineError> {
    #[cfg(feature = "batch")]
    return match batch::Set::named(instructions).and_then(batch::Batch::under) {
        Some(engine) => Ok(Arc::new(engine)),
        None => Err(EngineError::LibraryMissing {
            engine: "batch",
            reason: format!("this processor has no {instructions}"),
        }),
    };
    #[cfg(not(feature = "batch"))]
    return Err(EngineError::LibraryMissing {
        engine: "batch",
        reason: format!("this build lacks the feature `batch`, so {instructions} cannot be used"),
    });
}
