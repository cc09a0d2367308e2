//! The task kind `run`.

use super::{Bound, Command, Criterion, Evidence, Goal, Meaning};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Run in "task" = "run", needs [Reference] {
        /// The reference motion: a file of `specs/motions/` without its extension.
        motion: String,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Command,
    }
}

/// Every step has a flight phase, and the robot keeps running.
pub const MEANING: Meaning = Meaning {
    verb: "runs",
    travels: true,
    flies: true,
    default_pose: false,
    smooth: false,
    criteria: &[
        Criterion {
            metric: "flight_per_step",
            bound: Bound::AtLeast(0.9),
            text: "at least 90 % of the steps have a flight phase",
            optional: false,
        },
        Criterion {
            metric: "steady_flight_per_step",
            bound: Bound::AtLeast(1.0),
            text: "in the second half every step has a flight phase",
            optional: false,
        },
    ],
    evidence: Evidence {
        words: "steps with a flight phase",
        metric: "flight_per_step",
        second_half: Some("steady_flight_per_step"),
    },
};

impl Goal for Run {
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
