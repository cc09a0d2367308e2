//! Tests of the whole environment on real robots and motions.

mod engine;
mod episode;
#[cfg(feature = "rapier")]
mod playback;
mod recipe;
mod reference;
#[cfg(feature = "rapier")]
mod running;
mod shown;

pub(crate) use recipe::{Recipe, motion};
