//! The sources of the numbers in a figure or table.

use serde::{Deserialize, Serialize};

use super::model::{Arm, ReportInput};

/// A stage that a figure or table is made from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Source {
    /// Name of the arm's spec.
    pub arm: String,
    /// The stage.
    pub stage: String,
}

/// The sources of one stage in every arm that has it.
pub fn sources(input: &ReportInput, stage_of: impl Fn(&Arm) -> Vec<String>) -> Vec<Source> {
    let of_arm = |arm: &Arm| -> Vec<Source> {
        stage_of(arm).into_iter().map(|stage| Source { arm: arm.name.clone(), stage }).collect()
    };
    input.arms.iter().flat_map(of_arm).collect()
}
