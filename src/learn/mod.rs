//! Learning: rollouts, networks, PPO, pre-training, checkpoints.
//!
//! Knows environments only through [`crate::env::Crew`]. libtorch types do not leave this module.

pub mod adam;
pub mod advantage;
#[cfg(feature = "torch")]
pub mod bench;
pub mod beside;
pub mod checkpoint;
pub mod clock;
#[cfg(feature = "torch")]
pub mod device;
#[cfg(feature = "torch")]
mod dump;
pub mod error;
pub mod file;
#[cfg(feature = "torch")]
pub mod gradient;
pub mod health;
pub mod inference;
#[cfg(feature = "torch")]
mod journal;
pub mod lane;
#[cfg(feature = "torch")]
pub mod metrics;
#[cfg(feature = "torch")]
mod multiply;
pub mod network;
pub mod pace;
#[cfg(feature = "torch")]
pub mod ppo;
pub mod pretrain;
mod product;
pub mod rollout;
pub mod settings;
#[cfg(feature = "torch")]
pub mod tensorboard;
#[cfg(feature = "torch")]
pub mod train;

#[cfg(all(test, feature = "torch"))]
mod tests;
#[cfg(all(test, feature = "torch"))]
mod toy;

pub use error::LearnError;
pub use inference::{Inference, Scratch};
#[cfg(feature = "torch")]
pub use metrics::{Summary, UpdateMetrics};
pub use network::{Activation, Layer, Network};
pub use settings::{Round, Settings};
#[cfg(feature = "torch")]
pub use train::{Start, Trained, Training, Watch, train};
