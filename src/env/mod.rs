//! Environments: an episode of one robot under one policy.
//!
//! A [`Blueprint`] is the environment of a spec, a [`Scene`] is a blueprint compiled for one engine, a
//! [`RobotEnvironment`] is one running robot in it, and a [`RobotCrew`] is several that step together.

pub mod attitude;
pub mod blueprint;
pub mod command;
pub mod crew;
pub mod encoder;
mod episode;
pub mod ground;
pub mod interface;
pub mod observation;
pub mod privileged;
pub mod scene;
mod standing;
pub mod start;
pub mod stature;
pub mod tally;
pub mod trial;

pub use crate::kinds::Signals;
pub use blueprint::{Blueprint, BlueprintError};
pub use crew::{RobotCrew, RobotEnvironment};
pub use interface::{Crew, End, Output, Sizes, Stance, Step, View};
pub use observation::Observation;
pub use scene::Scene;
pub use trial::{Mode, Randomized, Trial};

#[cfg(test)]
pub(crate) mod tests;
