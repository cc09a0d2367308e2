//! Deployment: the exported policy with its contract, and transfer to another engine.
//!
//! An exported policy is one self-contained file ([`policy`]); programs that run it must follow the
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
