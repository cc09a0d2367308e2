//! The deployment kind `transfer`.

use crate::kinds::evaluate::{Command, Drawn};
use crate::kinds::fine_tune::Trained;
use crate::kinds::terrain::Ground;
use crate::sim::EngineName;
use crate::spec::typed::prelude::*;

kind! {
    pub struct Transfer in "deploy" = "transfer" {
        /// The engine.
        engine: EngineName,
        /// Physics rate; the rates of control must divide it.
        #[range(1.0, 1e6)]
        rate: Quantified<Hertz>,
        /// Number of episodes.
        #[range(1.0, 1e5)]
        episodes: Option<u64>,
        /// The command of every episode; by default the middle of the task's range.
        command: Option<Command>,
        /// Time limit of an episode; by default `task.episode`.
        #[range(0.1, 3600.0)]
        time_limit: Option<Quantified<Second>>,
        /// The policy: that of `[learn]` (`learner`) or of `[fine_tune]` (default if the spec has one), each
        /// in its training environment.
        policy: Option<Trained>,
        /// The ground of this evaluation; by default the training's.
        terrain: Option<RawKind<Ground>>,
        /// Standard deviation of the joint positions around the default pose at the start.
        #[range(0.0, 1.0)]
        perturbation: Option<Quantified<Radian>>,
        /// Randomization per episode: none, the training's (`true`), or the rows of a table.
        randomize: Option<Drawn>,
        /// Whether the observation is noisy.
        noise: Option<bool>,
        /// Whether the policy acts with the exploration of its training (`action.std`) rather than by its
        /// mean.
        explore: Option<bool>,
        /// Seed of the random streams of all episodes.
        seed: Option<u64>,
        /// Time constant of soft contacts (MuJoCo's `solref`); by default the engine's.
        #[range(1e-4, 1.0)]
        contact_time: Option<Quantified<Second>>,
    }
}
