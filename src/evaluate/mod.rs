//! Evaluation protocols and what they measure.

pub mod episodes;
pub mod gait;
pub mod meter;
pub mod protocol;

pub use crate::outcome::{self, Episode, Evaluation, Trace};
pub use episodes::{EvaluationError, Subject, episodes};
pub use protocol::Protocol;
