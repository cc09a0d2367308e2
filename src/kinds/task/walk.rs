//! The task kind `walk`.

use super::Command;
use crate::spec::typed::prelude::*;

kind! {
    pub struct Walk = "walk", needs [Reference] {
        /// The reference motion: a file of `specs/motions/` without its ending.
        motion: String,
        /// Time limit of an episode.
        #[range(0.01, 1e5)]
        episode: Quantified<Second>,
        /// The commanded speed.
        command: Command,
    }
}
