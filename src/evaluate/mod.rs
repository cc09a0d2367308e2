//! Evaluation protocols and what they measure.

pub mod conditions;
pub mod episodes;
pub mod follower;
pub mod gait;
pub mod meter;
pub mod protocol;

pub use crate::outcome::{self, Episode, Evaluation, Trace};
pub use conditions::Condition;
pub use episodes::{EvaluationError, Subject, episodes, followed};
pub use protocol::Protocol;
