//! What may be written in `[learn]` of kind `ppo`. `learn::Settings` reads it.

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
    /// Over which samples advantages get mean 0 and standard deviation 1.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Normalisation {
        /// The whole rollout.
        Batch = "batch",
        /// Each minibatch by itself (the paper's authors).
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
    /// Where the networks are while they learn. Rollouts run on the CPU either way.
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
    /// Whose step size the critic's hidden layers have.
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
    /// Whether the actor sees the second half of the cycle in the mirror.
    pub enum Symmetry {
        /// It does not.
        Off = "none",
        /// It sees and acts in the mirror.
        PhaseMirror = "phase_mirror",
    }
}

choice! {
    /// Whose gradient a norm is of.
    pub enum NormOf {
        /// Each network's by itself.
        Each = "each",
        /// Both as one.
        Both = "both",
    }
}

choice! {
    /// What follows an episode's time limit.
    pub enum TimeLimit {
        /// The critic's value of the last state.
        Bootstrap = "bootstrap",
        /// Nothing, as after a fall.
        Failure = "failure",
    }
}

reference! {
    /// What the exploration at the end of a decay is a share of.
    pub FirstStd = "`action.std`";
    /// What the duration of a decay is a share of.
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
        /// Whose step size the critic's hidden layers learn with: its own, which is also what is meant
        /// without this key, or the actor's at the beginning of the update, which leaves `learning_rate` to
        /// the last layer (the authors' code).
        hidden_learning_rate: Option<RateOf>,
        /// Factor of the mean squared error in the critic's loss; without it 0.5. Adam takes it out again,
        /// but for `adam_epsilon` and what `max_grad_norm` bounds.
        #[range(1e-6, 1e6)]
        coefficient: Option<f64>,
        /// Whether the critic also sees what the robot cannot measure: base velocity, height, contacts, foot
        /// loads.
        #[default("false")]
        privileged: bool,
    }
}

keys! {
    /// How the exploration falls.
    #[derive(Copy, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct Decay {
        /// The exploration at the end of the decay.
        #[range(1e-6, 100.0)]
        to: Ratio<FirstStd>,
        /// The first part of the samples, over which it falls linearly; then it stays.
        #[range(1e-6, 1.0)]
        over: Ratio<AllSamples>,
    }
}

keys! {
    /// A step size that falls linearly over the training.
    pub struct LinearRate {
        /// Step size at the first and at the last sample.
        #[range(0.0, 1.0)]
        #[length(Length::Each(&["first", "last"]))]
        linear: Vec<f64>,
    }
}

keys! {
    /// A step size that is steered.
    pub struct SteeredRate {
        /// KL divergence between the policy before and after an update that the step size is steered to.
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
        /// Falling linearly over the training.
        Linear(LinearRate),
        /// Steered by the KL divergence of an update.
        Steered(SteeredRate),
    }
}

kind! {
    /// Proximal policy optimisation with a Gaussian policy.
    pub struct Ppo in "learn" = "ppo" {
        /// Control steps to learn from, over all environments. The paper: 80 M. With 0 nothing is learned,
        /// and the policy is the pre-trained network alone.
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
        /// Environments that are stepped side by side; they divide `rollout`.
        #[range(1.0, 65536.0)]
        #[default("64")]
        environments: usize,
        /// Samples per gradient step.
        #[range(1.0, 1e8)]
        #[default("128")]
        minibatch: usize,
        /// Passes over a rollout.
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
        /// Time after which a reward counts 1/e: gamma = exp(-step / discount_time), the same horizon at
        /// every control rate.
        #[range(1e-6, 1e6)]
        discount_time: Option<Quantified<Second>>,
        /// Decay of generalised advantage estimation per control step.
        #[range(0.0, 1.0)]
        #[default("0.95")]
        lambda: f64,
        /// Probability ratios beyond 1 +- clip earn no gradient.
        #[range(1e-3, 10.0)]
        #[default("0.2")]
        clip: f64,
        /// Over which samples advantages are normalised to mean 0 and standard deviation 1.
        #[default("\"minibatch\"")]
        advantages: Normalisation,
        /// Factor on all rewards before learning; `one_minus_gamma` makes values as large as one step's
        /// reward.
        #[default("\"none\"")]
        reward_scale: RewardScale,
        /// First updates in which only the critic learns, so that a pre-trained actor survives them.
        #[range(0.0, 1e9)]
        #[default("0")]
        warm_up: u64,
        /// `phase_mirror`: in the second half of the cycle the actor sees and acts in the mirror.
        #[default("\"none\"")]
        symmetry: Symmetry,
        /// The actor's network.
        #[default("{}")]
        policy: Shape,
        /// The critic's network and its step size.
        #[default("{}")]
        value: Critic,
        /// Each network's gradient is shortened to this norm.
        #[range(1e-9, 1e9)]
        #[default("0.5")]
        max_grad_norm: f64,
        /// Whose gradient `max_grad_norm` bounds: each network's by itself, which is also what is meant
        /// without this key, or both as one (the authors' code), so that the critic's errors shorten the
        /// actor's steps.
        grad_norm_of: Option<NormOf>,
        /// Adam's epsilon.
        #[range(1e-12, 1.0)]
        #[default("1e-5")]
        adam_epsilon: f64,
        /// The exploration falls over the training. Without it, as printed, it stays what `action.std` says.
        std_decay: Option<Decay>,
        /// What follows an episode's time limit: the critic's value of its last state, which is also what is
        /// meant without this key, or nothing, as after a fall.
        time_limit: Option<TimeLimit>,
        /// Names all random streams of the run.
        #[default("1")]
        seed: u64,
        /// Updates between two checkpoints. It changes no result, so a training that was interrupted goes on
        /// with another value.
        #[range(1.0, 1e9)]
        #[default("10")]
        checkpoint_every: u64,
        /// What computes the updates: plain Rust, which is also what is meant without this key, or libtorch,
        /// which needs a build with the feature `torch` (R0005). They differ in the order of sums, so `torch`
        /// makes another policy.
        backend: Option<Backend>,
        /// Where the networks learn: `cuda` needs `backend = "torch"` and a libtorch for CUDA (R0006). Left
        /// out it is the CPU, whose last bits are others, so `cuda` makes another policy.
        device: Option<Device>,
    }
}
