//! Execution: the store, the scheduler, events, interruption and resume.
//!
//! Only [`store`] writes artefacts. What a stage does is a [`Work`], registered by its kind.

pub mod bars;
pub mod capability;
mod copies;
pub mod curve;
pub mod effort;
pub mod events;
mod evidence;
pub mod fault;
pub mod forecast;
pub mod gc;
pub mod interrupt;
pub mod journal;
pub mod last_words;
pub mod lease;
pub mod line_file;
mod lines;
pub mod lock;
pub mod manifest;
pub mod mark;
pub mod marker;
pub mod meter;
mod numbers;
mod pace;
pub mod perform;
pub mod progress;
pub mod records;
pub mod scheduler;
mod shorter;
pub mod speed;
pub mod store;
mod strays;
mod tensorboard;
mod verify;
pub mod work;
pub mod works;

pub use events::{Event, Events};
pub use fault::StoreError;
pub use interrupt::Interrupt;
pub use perform::{Ending, Order, Workshop};
pub use scheduler::{Options, Outcome, run};
pub use store::Store;
pub use work::{Failure, Job, Threads, Work, WorkError, Works};
