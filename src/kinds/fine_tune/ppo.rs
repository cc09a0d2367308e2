//! What may be written in `[fine_tune]` of kind `ppo`. `learn::Settings` reads it.

use crate::kinds::learn::ppo::LearningRate;
use crate::kinds::physics::EngineName;
use crate::kinds::terrain::Ground;
use crate::spec::typed::prelude::*;

reference! {
    /// What the exploration is a share of.
    pub ActionStd = "what `action.std` is a share of";
}

kind! {
    /// PPO that goes on from actor and critic.
    pub struct Ppo in "fine_tune" = "ppo" {
        /// Control steps to learn from, over all environments, beside those of `learn.samples`.
        #[range(1.0, 1e12)]
        samples: u64,
        /// The ground to learn on, in place of `[terrain]`.
        terrain: RawKind<Ground>,
        /// Adam's step size of the actor; without it `learn.learning_rate`, which begins anew.
        #[range(0.0, 1.0)]
        learning_rate: Option<LearningRate>,
        /// First updates in which only the critic learns; without it `learn.warm_up`.
        #[range(0.0, 1e9)]
        warm_up: Option<u64>,
        /// The physics engine to learn in, at the rates of the training; without it `physics.engine`.
        engine: Option<EngineName>,
        /// Standard deviation of the exploration noise; without it `action.std`.
        #[range(1e-6, 10.0)]
        std: Option<Ratio<ActionStd>>,
        /// Weights of reward terms, by the name of the term; the other terms keep that of `[reward]`.
        #[range(-1e6, 1e6)]
        weights: Option<Named<f64>>,
    }
}
