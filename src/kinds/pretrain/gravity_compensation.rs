//! What may be written in `[pretrain]` of kind `gravity_compensation`: the paper's pre-training.

use super::{Lesson, PhaseLabel};
use crate::spec::typed::prelude::*;

reference! {
    /// What the standing samples are a share of.
    pub AllSamples = "all samples";
}

kind! {
    pub struct GravityCompensation in "pretrain" = "gravity_compensation" {
        /// Share of the samples about the default pose; the others are about the reference motion.
        #[range(0.0, 1.0)]
        #[default("\"50 %\"")]
        standing_share: Ratio<AllSamples>,
        /// A foot counts as standing when its sole is at most this far above the lower sole.
        #[range(0.0, 1.0)]
        #[default("\"0.02 m\"")]
        contact_height: Quantified<Metre>,
        /// Label of the phase action: left out of the loss, zero (the nominal cadence), or drawn from [0, 1]
        /// as printed, which teaches its mean.
        #[default("\"masked\"")]
        phase_label: PhaseLabel,
        ..lesson: Lesson,
    }
}
