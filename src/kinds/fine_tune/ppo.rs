//! The keys of `[fine_tune]` of kind `ppo`. `learn::Settings` reads them.

use crate::kinds::learn::ppo::LearningRate;
use crate::kinds::terrain::Ground;
use crate::sim::EngineName;
use crate::spec::typed::prelude::*;

reference! {
    /// Reference of the exploration.
    pub ActionStd = "what `action.std` is a share of" or Torque;
}

kind! {
    /// PPO that continues from an actor and a critic.
    pub struct Ppo in "fine_tune" = "ppo" {
        /// Control steps to learn from, over all environments, in addition to `learn.samples`.
        #[range(1.0, 1e12)]
        samples: u64,
        /// The ground of the fine-tuning, in place of `[terrain]`.
        terrain: RawKind<Ground>,
        /// Adam's step size of the actor; by default `learn.learning_rate`, whose schedule starts again.
        #[range(0.0, 1.0)]
        learning_rate: Option<LearningRate>,
        /// Number of first updates in which only the critic learns; by default `learn.warm_up`.
        #[range(0.0, 1e9)]
        warm_up: Option<u64>,
        /// The physics engine of the fine-tuning, at the rates of the training; by default `physics.engine`.
        engine: Option<EngineName>,
        /// Standard deviation of the exploration noise; by default `action.std`.
        #[range(1e-6, 10.0)]
        std: Option<Ratio<ActionStd>>,
        /// Weights of reward terms, by the name of the term; other terms keep their weight in `[reward]`.
        #[range(-1e6, 1e6)]
        weights: Option<Named<f64>>,
    }
}
