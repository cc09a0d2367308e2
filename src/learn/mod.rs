//! Learning: rollouts, networks, PPO, pre-training, checkpoints.
//!
//! Knows environments only through [`crate::env::Environment`]. libtorch types do not leave this module.

pub mod adam;
pub mod advantage;
pub mod clock;
pub mod file;
#[cfg(feature = "torch")]
pub mod gradient;
pub mod lane;
pub mod network;
#[cfg(feature = "torch")]
pub mod ppo;
pub mod rollout;
pub mod settings;

pub use network::{Activation, Layer, Network, Scratch};
pub use settings::Settings;
