//! Deployment: the exported policy with its contract, and transfer to another engine.
//!
//! A policy leaves the program as one file that stands for itself ([`policy`]); whoever runs it obeys the
//! [`contract`] in it.

pub mod contract;
mod fields;
mod frames;
pub mod law;
pub mod policy;
pub mod torchscript;
pub mod transfer;

pub use contract::{Contract, Provenance};
pub use policy::{Policy, PolicyError, Trust};
pub use transfer::Transfer;
