//! The task kind `squat`.

use super::Command;
use crate::spec::typed::prelude::*;

kind! {
    pub struct Squat = "squat", needs [Reference] {
        /// The reference motion: a file of `specs/motions/` without its ending.
        motion: String,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Option<Command>,
    }
}
