//! The task kind `walk`.

use super::{Bound, Command, Criterion, Evidence, Goal, Meaning};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Walk in "task" = "walk", needs [Reference] {
        /// The reference motion: a file of `specs/motions/` without its extension.
        motion: String,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Command,
    }
}

/// A foot is in single support for a share of the time.
const fn alone(metric: &'static str, text: &'static str) -> Criterion {
    Criterion { metric, bound: Bound::AtLeast(0.1), text, optional: false }
}

/// Each foot is in single support for some time, so that shuffling does not count as walking.
pub const MEANING: Meaning = Meaning {
    verb: "walks",
    travels: true,
    flies: false,
    default_pose: false,
    smooth: false,
    criteria: &[
        alone("left_support", "stands on the left foot alone at least 10 % of the time"),
        alone("right_support", "stands on the right foot alone at least 10 % of the time"),
    ],
    evidence: Evidence { words: "single support", metric: "single_support", second_half: None },
};

impl Goal for Walk {
    fn motion(&self) -> Option<&str> {
        Some(&self.motion)
    }

    fn episode(&self) -> f64 {
        self.episode
    }

    fn command(&self) -> Option<&Command> {
        Some(&self.command)
    }
}
