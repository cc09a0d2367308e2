//! Environments: an episode of one robot under one policy.
//!
//! A [`Blueprint`] is what the spec says, a [`Scene`] that compiled for one engine, a [`RobotEnvironment`]
//! one running robot in it.

pub mod attitude;
pub mod blueprint;
pub mod command;
pub mod encoder;
pub mod episode;
pub mod ground;
pub mod interface;
pub mod observation;
pub mod privileged;
pub mod scene;
pub mod start;
pub mod stature;
pub mod tally;
pub mod trial;

pub use crate::kinds::Signals;
pub use blueprint::{Blueprint, BlueprintError};
pub use episode::RobotEnvironment;
pub use interface::{End, Environment, Output, Sizes, Stance, Step};
pub use observation::Observation;
pub use scene::Scene;
pub use trial::{Mode, Randomized, Trial};

#[cfg(test)]
pub(crate) mod tests;
