//! The task kind `stand`.

use super::Command;
use crate::spec::typed::prelude::*;

kind! {
    pub struct Stand = "stand" {
        /// The reference motion: a file of `specs/motions/` without its ending.
        motion: Option<String>,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Option<Command>,
    }
}
