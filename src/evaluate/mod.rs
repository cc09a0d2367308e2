//! Evaluation protocols and what they measure.

pub mod episodes;
pub mod gait;
pub mod meter;
pub mod outcome;
pub mod protocol;

pub use episodes::{EvaluationError, Subject, episodes};
pub use outcome::{Episode, Evaluation, Trace};
pub use protocol::Protocol;
