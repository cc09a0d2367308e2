//! The task kind `squat`.

use super::meaning::IN_PLACE;
use super::{Bound, Command, Criterion, Evidence, Goal, Meaning};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Squat in "task" = "squat", needs [Reference] {
        /// The reference motion: a file of `specs/motions/` without its extension.
        motion: String,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Option<Command>,
    }
}

/// The joints follow the reference, in place.
pub const MEANING: Meaning = Meaning {
    verb: "squats",
    travels: false,
    flies: false,
    default_pose: false,
    smooth: true,
    criteria: &[
        Criterion {
            metric: "joint_error",
            bound: Bound::AtMost(0.5),
            text: "stays within {} rad of the reference in every joint",
            optional: false,
        },
        // Records from versions without this metric are judged without it.
        Criterion { optional: true, ..IN_PLACE },
    ],
    evidence: Evidence {
        words: "largest joint distance from the reference",
        metric: "joint_error",
        second_half: None,
    },
};

impl Goal for Squat {
    fn motion(&self) -> Option<&str> {
        Some(&self.motion)
    }

    fn episode(&self) -> f64 {
        self.episode
    }

    fn command(&self) -> Option<&Command> {
        self.command.as_ref()
    }
}
