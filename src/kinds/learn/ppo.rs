//! The keys of `[learn]` of kind `ppo`. `learn::Settings` reads them.

use serde::{Deserialize, Serialize};

use crate::spec::typed::prelude::*;

choice! {
    /// The activations.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Activation {
        /// Exponential linear unit.
        Elu = "elu",
        /// max(0, x)
        Relu = "relu",
        /// Hyperbolic tangent.
        Tanh = "tanh",
    }
}

choice! {
    /// Samples over which advantages are normalised to mean 0 and standard deviation 1.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Normalisation {
        /// The whole rollout.
        Batch = "batch",
        /// Each minibatch separately (the paper's authors).
        Minibatch = "minibatch",
    }
}

choice! {
    /// The library that computes the updates ([`crate::learn::backend`]).
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Backend {
        /// Plain Rust with `gemm`.
        #[default]
        Native = "native",
        /// libtorch.
        Torch = "torch",
    }
}

choice! {
    /// Device of the networks during training. Rollouts always run on the CPU.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Device {
        /// The CPU.
        #[default]
        Cpu = "cpu",
        /// The first CUDA device; only with [`Backend::Torch`].
        Cuda = "cuda",
    }
}

choice! {
    /// Step size of the critic's hidden layers.
    pub enum RateOf {
        /// The critic's.
        Value = "value",
        /// The actor's.
        Policy = "policy",
    }
}

choice! {
    /// Factor on all rewards.
    pub enum RewardScale {
        /// None.
        One = "none",
        /// 1 - gamma.
        OneMinusGamma = "one_minus_gamma",
    }
}

choice! {
    /// Mirroring of the second half of the cycle for the actor.
    pub enum Symmetry {
        /// None.
        Off = "none",
        /// Observations and actions are mirrored.
        PhaseMirror = "phase_mirror",
    }
}

choice! {
    /// Scope of the gradient norm.
    pub enum NormOf {
        /// Each network separately.
        Each = "each",
        /// Both networks together.
        Both = "both",
    }
}

choice! {
    /// Value after an episode's time limit.
    pub enum TimeLimit {
        /// The critic's value of the last state.
        Bootstrap = "bootstrap",
        /// Zero, as after a fall.
        Failure = "failure",
    }
}

reference! {
    /// Reference of the exploration at the end of a decay.
    pub FirstStd = "`action.std`";
    /// Reference of the duration of a decay.
    pub AllSamples = "`learn.samples`";
}

keys! {
    /// Hidden layers of a network.
    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct Shape {
        /// Width of each hidden layer. The paper: two layers of 256.
        #[range(1.0, 8192.0)]
        #[default("[256, 256]")]
        hidden: Vec<usize>,
        /// The activation after each hidden layer.
        #[default("\"relu\"")]
        activation: Activation,
    }
}

keys! {
    /// The critic's network and its loss.
    pub struct Critic {
        + shape: Shape,
        /// Adam's step size of the critic, constant.
        #[range(0.0, 1.0)]
        #[default("5e-4")]
        learning_rate: f64,
        /// Step size of the critic's hidden layers: the critic's (default), or the actor's at the beginning
        /// of the update, so that `learning_rate` applies only to the last layer (the authors' code).
        hidden_learning_rate: Option<RateOf>,
        /// Coefficient of the mean squared error in the critic's loss; 0.5 by default. Adam cancels it,
        /// except for `adam_epsilon` and `max_grad_norm`.
        #[range(1e-6, 1e6)]
        coefficient: Option<f64>,
        /// Whether the critic gets inputs that the robot cannot measure: base velocity, height, contacts,
        /// foot loads.
        #[default("false")]
        privileged: bool,
    }
}

keys! {
    /// Decay of the exploration.
    #[derive(Copy, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct Decay {
        /// The exploration at the end of the decay.
        #[range(1e-6, 100.0)]
        to: Ratio<FirstStd>,
        /// Share of the samples over which it falls linearly; afterwards it is constant.
        #[range(1e-6, 1.0)]
        over: Ratio<AllSamples>,
    }
}

keys! {
    /// A step size that decreases linearly over the training.
    pub struct LinearRate {
        /// Step size at the first and at the last sample.
        #[range(0.0, 1.0)]
        #[length(Length::Each(&["first", "last"]))]
        linear: Vec<f64>,
    }
}

keys! {
    /// A step size that adapts to the KL divergence.
    pub struct SteeredRate {
        /// Target KL divergence between the policy before and after an update.
        #[range(1e-6, 1.0)]
        kl_target: f64,
        /// Step size of the first update.
        #[range(0.0, 1.0)]
        start: f64,
    }
}

either! {
    /// A step size.
    pub enum LearningRate {
        /// Constant.
        Constant(f64),
        /// Decreasing linearly over the training.
        Linear(LinearRate),
        /// Adapted to the KL divergence of an update.
        Steered(SteeredRate),
    }
}

kind! {
    /// Proximal policy optimisation with a Gaussian policy.
    pub struct Ppo in "learn" = "ppo" {
        /// Control steps to learn from, over all environments. The paper: 80 M. With 0 the policy is the
        /// pre-trained network.
        #[range(0.0, 1e12)]
        samples: u64,
        /// Ends the training after this many samples, rounded up to whole updates, while step size and
        /// exploration follow the schedule of all `samples`. A longer training with otherwise equal keys
        /// continues from its end.
        #[range(1.0, 1e12)]
        stop_at: Option<u64>,
        /// Samples per update, over all environments.
        #[range(1.0, 1e8)]
        #[default("16384")]
        rollout: usize,
        /// Number of parallel environments; it divides `rollout`.
        #[range(1.0, 65536.0)]
        #[default("64")]
        environments: usize,
        /// Samples per gradient step.
        #[range(1.0, 1e8)]
        #[default("128")]
        minibatch: usize,
        /// Passes over a rollout per update.
        #[range(1.0, 1000.0)]
        #[default("3")]
        epochs: usize,
        /// Adam's step size of the actor: a number, `{ linear = [first, last] }`, or
        /// `{ kl_target = ..., start = ... }`.
        #[range(0.0, 1.0)]
        #[default("{ linear = [5e-5, 1e-6] }")]
        learning_rate: LearningRate,
        /// Discount per control step; `discount_time` overrides it.
        #[range(0.0, 1.0)]
        #[default("0.99")]
        gamma: f64,
        /// Time after which a reward is discounted to 1/e: gamma = exp(-step / discount_time), the same
        /// horizon at every control rate.
        #[range(1e-6, 1e6)]
        discount_time: Option<Quantified<Second>>,
        /// Decay of generalised advantage estimation per control step.
        #[range(0.0, 1.0)]
        #[default("0.95")]
        lambda: f64,
        /// Probability ratios beyond 1 +- clip have zero gradient.
        #[range(1e-3, 10.0)]
        #[default("0.2")]
        clip: f64,
        /// Samples over which advantages are normalised to mean 0 and standard deviation 1.
        #[default("\"minibatch\"")]
        advantages: Normalisation,
        /// Factor on all rewards before learning; with `one_minus_gamma` values have the size of one step's
        /// reward.
        #[default("\"none\"")]
        reward_scale: RewardScale,
        /// Number of first updates in which only the critic learns, so that an untrained critic does not
        /// destroy a pre-trained actor.
        #[range(0.0, 1e9)]
        #[default("0")]
        warm_up: u64,
        /// `phase_mirror`: in the second half of the cycle the actor's observations and actions are mirrored.
        #[default("\"none\"")]
        symmetry: Symmetry,
        /// The actor's network.
        #[default("{}")]
        policy: Shape,
        /// The critic's network and its step size.
        #[default("{}")]
        value: Critic,
        /// Bound to which each network's gradient is clipped.
        #[range(1e-9, 1e9)]
        #[default("0.5")]
        max_grad_norm: f64,
        /// Gradient that `max_grad_norm` bounds: each network's separately (default), or both together (the
        /// authors' code), so that a large critic gradient reduces the actor's step.
        grad_norm_of: Option<NormOf>,
        /// Adam's epsilon.
        #[range(1e-12, 1.0)]
        #[default("1e-5")]
        adam_epsilon: f64,
        /// Decay of the exploration over the training. Without it `action.std` is constant, as printed in the
        /// paper.
        std_decay: Option<Decay>,
        /// Value after an episode's time limit: the critic's value of its last state (default), or zero, as
        /// after a fall.
        time_limit: Option<TimeLimit>,
        /// Seed of all random streams of the run.
        #[default("1")]
        seed: u64,
        /// Updates between two checkpoints. It does not affect results, so an interrupted training can be
        /// resumed with another value.
        #[range(1.0, 1e9)]
        #[default("10")]
        checkpoint_every: u64,
        /// Library that computes the updates: plain Rust (default), or libtorch, which needs a build with the
        /// feature `torch` (R0005). The order of summation differs, so `torch` gives another policy.
        backend: Option<Backend>,
        /// Device of the networks during training: the CPU (default), or `cuda`, which needs `backend =
        /// "torch"` and a libtorch for CUDA (R0006). The last bits differ, so `cuda` gives another policy.
        device: Option<Device>,
    }
}

/// The samples of a training that takes whole updates of `rollout` samples until it has `samples`.
pub fn in_whole_updates(samples: u64, rollout: u64) -> u64 {
    let rollout = rollout.max(1);
    samples.div_ceil(rollout).saturating_mul(rollout)
}

#[cfg(test)]
mod tests {
    use super::in_whole_updates;

    #[test]
    fn a_training_ends_after_a_whole_update() {
        assert_eq!([0, 1, 8192, 8193].map(|samples| in_whole_updates(samples, 8192)), [0, 8192, 8192, 16384]);
        assert_eq!(in_whole_updates(u64::MAX, 0), u64::MAX);
    }
}
