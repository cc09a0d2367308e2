//! The deployment kind `transfer`.

use crate::kinds::evaluate::{Command, Drawn};
use crate::kinds::fine_tune::Trained;
use crate::kinds::physics::EngineName;
use crate::kinds::terrain::Ground;
use crate::spec::typed::prelude::*;

kind! {
    pub struct Transfer in "deploy" = "transfer" {
        /// The engine to run in.
        engine: EngineName,
        /// Physics rate; the rates of control must divide it.
        #[range(1.0, 1e6)]
        rate: Quantified<Hertz>,
        /// Number of episodes.
        #[range(1.0, 1e5)]
        episodes: Option<u64>,
        /// The command of every episode; without it the middle of the task's range.
        command: Option<Command>,
        /// Duration of an episode that nothing ends; without it `task.episode`.
        #[range(0.1, 3600.0)]
        time_limit: Option<Quantified<Second>>,
        /// Which policy: that of `[learn]` (`learner`) or that of `[fine_tune]`, each in the world that it
        /// was trained in. Without it the last one.
        policy: Option<Trained>,
        /// The ground of this evaluation, in place of the training's.
        terrain: Option<RawKind<Ground>>,
        /// Standard deviation of the joint positions about the default pose at the start.
        #[range(0.0, 1.0)]
        perturbation: Option<Quantified<Radian>>,
        /// What is drawn per episode: nothing, with `true` the training's randomization, or the rows of a
        /// table.
        randomize: Option<Drawn>,
        /// Whether the observation carries its noise.
        noise: Option<bool>,
        /// Whether the policy acts with the exploration of its training (`action.std`), not by its mean
        /// alone.
        explore: Option<bool>,
        /// Names the streams of all episodes.
        seed: Option<u64>,
        /// Time constant of soft contacts (MuJoCo's `solref`); without it the engine's own.
        #[range(1e-4, 1.0)]
        contact_time: Option<Quantified<Second>>,
    }
}
