//! The keys of `[pretrain]` of kind `gravity_compensation`: the paper's pre-training.

use super::{Lesson, PhaseLabel};
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the share of standing samples.
    pub AllSamples = "all samples";
}

kind! {
    pub struct GravityCompensation in "pretrain" = "gravity_compensation" {
        /// Share of the samples around the default pose; the others are around the reference motion.
        #[range(0.0, 1.0)]
        #[default("\"50 %\"")]
        standing_share: Ratio<AllSamples>,
        /// A foot is in contact if its sole is at most this far above the lower sole.
        #[range(0.0, 1.0)]
        #[default("\"0.02 m\"")]
        contact_height: Quantified<Metre>,
        /// Label of the phase action: masked in the loss, zero (the nominal cadence), or random from [0, 1]
        /// as printed in the paper, whose mean the actor learns.
        #[default("\"masked\"")]
        phase_label: PhaseLabel,
        ..lesson: Lesson,
    }
}
