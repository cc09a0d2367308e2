//! Execution: the store, the scheduler, events, interruption and resume.
//!
//! Only [`store`] writes artefacts. What a stage does is a [`Work`], registered by kind; this module
//! knows none of them.

pub mod events;
pub mod interrupt;
pub mod work;

pub use events::{Event, Events};
pub use interrupt::Interrupt;
pub use work::{Failure, Job, Threads, Work, WorkError, Works};
