//! Environments: an episode of one robot under one policy.

pub mod interface;

pub use crate::kinds::Signals;
pub use interface::{End, Environment, Sizes, Step};
