//! Pre-training: fits the actor to closed-form labels before any simulation.
//!
//! `teacher` draws states (`drawn`), some of them near a `reference` motion. `tracking` and gravity
//! compensation compute the torques for them, with `balance` for walks, and `fit` is the regression. No
//! simulator is used.

mod balance;
mod drawn;
mod fit;
mod reference;
pub mod residual;
#[cfg(test)]
mod specs;
pub mod teacher;
mod tracking;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use fit::{Lesson, Pretrained, pretrain};
pub use teacher::Teacher;

/// Report of a pre-training: `pretrain.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PretrainReport {
    /// The kind: `gravity_compensation` or `tracking`.
    pub kind: String,
    /// Number of fitted samples.
    pub samples: u64,
    /// Number of held-out samples.
    pub held_out: u64,
    /// Root mean square error of the torques on the held-out samples in N m, over all joints.
    pub rmse_nm: f64,
    /// Root mean square of the held-out labels in N m: the error of an actor whose output is zero.
    pub label_rms_nm: f64,
    /// The error of each joint in N m.
    pub rmse_by_joint_nm: BTreeMap<String, f64>,
    /// Wall time in s.
    pub wall_s: f64,
    /// CPU time in s, over all threads.
    pub cpu_s: f64,
}
