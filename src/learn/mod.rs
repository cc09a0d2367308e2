//! Learning: rollouts, networks, PPO, pre-training, checkpoints, random streams.

pub mod network;
