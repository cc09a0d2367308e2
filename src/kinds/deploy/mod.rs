//! Deployments of a trained policy. What they do stands in `deploy/`.

pub mod export;
pub mod transfer;

pub use export::Export;
pub use transfer::Transfer;

use crate::spec::typed::prelude::*;

section! {
    /// What becomes of a trained policy.
    pub enum Deployment in "deploy", "deployment" { export: Export, transfer: Transfer }
}
