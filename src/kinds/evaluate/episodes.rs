//! The evaluation protocol `episodes`.

use super::{Command, Setting, Spread};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Episodes in "evaluate" = "episodes" {
        /// Number of episodes.
        #[range(1.0, 1e5)]
        #[default("32")]
        episodes: u64,
        /// The command of every episode; by default the middle of the task's range.
        command: Option<Command>,
        ..spread: Spread,
        ..setting: Setting,
    }
}
