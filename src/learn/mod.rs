//! Learning: rollouts, networks, PPO, pre-training, checkpoints.
//!
//! Environments are known only through [`crate::env::Crew`]. libtorch's types stay in `backend/torch/`.

pub mod adam;
pub mod advantage;
pub mod backend;
pub mod bench;
pub mod beside;
pub mod checkpoint;
pub mod clock;
mod dump;
pub mod error;
pub mod file;
pub mod finding;
pub mod health;
pub mod inference;
mod journal;
pub mod lane;
pub mod metrics;
pub mod network;
pub mod pace;
pub mod ppo;
pub mod pretrain;
mod product;
pub mod rollout;
pub mod settings;
pub mod tensorboard;
pub mod train;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod toy;

pub use error::LearnError;
pub use inference::{Inference, Scratch};
pub use metrics::{Summary, UpdateMetrics};
pub use network::{Activation, Layer, Network};
pub use settings::{Round, Settings};
pub use train::{Start, Trained, Training, Watch, train};
