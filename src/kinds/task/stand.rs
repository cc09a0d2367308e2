//! The task kind `stand`.

use super::meaning::IN_PLACE;
use super::{Command, Evidence, Goal, Meaning};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Stand in "task" = "stand" {
        /// The reference motion: a file of `specs/motions/` without its extension.
        motion: Option<String>,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Option<Command>,
    }
}

/// The robot stays in place.
pub const MEANING: Meaning = Meaning {
    verb: "stands",
    travels: false,
    flies: false,
    default_pose: true,
    smooth: false,
    criteria: &[IN_PLACE],
    evidence: Evidence { words: "largest distance from its start", metric: "drift", second_half: None },
};

impl Goal for Stand {
    fn motion(&self) -> Option<&str> {
        self.motion.as_deref()
    }

    fn episode(&self) -> f64 {
        self.episode
    }

    fn command(&self) -> Option<&Command> {
        self.command.as_ref()
    }
}
