//! Settings of the learner: `[learn]` of a spec, read once into plain numbers.

use serde::{Deserialize, Serialize};

use crate::kinds::fine_tune;
use crate::kinds::learn::Ppo;
pub use crate::kinds::learn::ppo::{Backend, Decay, Device, Normalisation, Shape};
use crate::kinds::learn::ppo::{LearningRate, LinearRate, NormOf, RateOf, RewardScale, TimeLimit};
use crate::spec::Section;

/// All settings of a PPO training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Control steps to learn from.
    pub samples: u64,
    /// Samples after which the training ends early; its schedules still refer to all `samples`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop_at: Option<u64>,
    /// Samples per update, over all environments.
    pub rollout: usize,
    /// Environments stepped side by side; they divide `rollout`.
    pub environments: usize,
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Passes over a rollout.
    pub epochs: usize,
    /// Step size of the actor.
    pub rate: Rate,
    /// Discount per control step.
    pub gamma: f64,
    /// Decay of the advantage estimate per control step.
    pub lambda: f64,
    /// Clip range of the probability ratio, for example 0.2.
    pub clip: f64,
    /// Samples over which advantages are normalised.
    pub advantages: Normalisation,
    /// Factor on all rewards before learning.
    pub reward_scale: f64,
    /// First updates in which only the critic learns.
    pub warm_up: u64,
    /// The actor's hidden layers.
    pub policy: Shape,
    /// The critic's hidden layers.
    pub value: Shape,
    /// Step size of the critic.
    pub value_rate: f64,
    /// Whether the critic's hidden layers have the actor's step size.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub critic_hidden_follows: bool,
    /// Coefficient of the critic's mean squared error in its loss.
    #[serde(default = "half", skip_serializing_if = "is_half")]
    pub value_coefficient: f64,
    /// Whether the critic sees the privileged inputs.
    pub privileged: bool,
    /// Bound on each network's gradient norm.
    pub max_grad_norm: f64,
    /// Whether the bound applies to the joint norm of both gradients.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub norm_of_both: bool,
    /// Adam's epsilon.
    pub adam_epsilon: f64,
    /// The run's seed: the first part of every stream's name.
    pub seed: u64,
    /// Updates between two checkpoints.
    pub checkpoint_every: u64,
    /// Standard deviation of each action.
    pub std: Vec<f64>,
    /// How the standard deviations change over the training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_decay: Option<Decay>,
    /// Whether a time limit ends the return, as a fall does.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub limits_are_failures: bool,
    /// Duration of a control step in s.
    pub step: f64,
    /// Whether this is the training of `[learn]` or of `[fine_tune]`.
    #[serde(default, skip_serializing_if = "Round::is_first")]
    pub round: Round,
    /// The library that computes the updates.
    #[serde(default, skip_serializing_if = "Backend::is_native")]
    pub backend: Backend,
    /// The device on which the networks are trained.
    #[serde(default, skip_serializing_if = "Device::is_cpu")]
    pub device: Device,
}

fn half() -> f64 {
    0.5
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it with a reference")]
fn is_half(coefficient: &f64) -> bool {
    *coefficient == 0.5
}

/// The trainings of a policy; each has its own random streams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Round {
    /// `[learn]`.
    #[default]
    First,
    /// `[fine_tune]`.
    FineTuning,
}

impl Round {
    fn is_first(&self) -> bool {
        *self == Self::First
    }

    /// The second part of its streams' names.
    fn word(self) -> &'static str {
        match self {
            Self::First => "train",
            Self::FineTuning => "fine_tune",
        }
    }
}

/// Schedule of the actor's step size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rate {
    /// Constant.
    Constant(f64),
    /// Linear from the first sample to the last.
    Linear([f64; 2]),
    /// Adapted to a KL divergence per update, from a first value.
    Steered {
        /// Target KL divergence.
        target: f64,
        /// Step size of the first update.
        start: f64,
    },
}

impl Decay {
    /// Factor on the exploration after this share of all samples.
    fn factor(self, share: f64) -> f64 {
        1.0 + (self.to - 1.0) * (share / self.over).min(1.0)
    }
}

impl Settings {
    /// The settings of `[learn]`. `std` is the standard deviation of each action, `step` the control step in
    /// s.
    pub fn new(learn: &Ppo, std: Vec<f64>, step: f64) -> Self {
        let gamma = learn.discount_time.map_or(learn.gamma, |time| libm::exp(-step / time));
        let critic = &learn.value;
        Self {
            samples: learn.samples,
            stop_at: learn.stop_at,
            rollout: learn.rollout,
            environments: learn.environments,
            minibatch: learn.minibatch,
            epochs: learn.epochs,
            rate: Rate::new(&learn.learning_rate),
            gamma,
            lambda: learn.lambda,
            clip: learn.clip,
            advantages: learn.advantages,
            reward_scale: match learn.reward_scale {
                RewardScale::One => 1.0,
                RewardScale::OneMinusGamma => 1.0 - gamma,
            },
            warm_up: learn.warm_up,
            policy: learn.policy.clone(),
            value: critic.shape.clone(),
            value_rate: critic.learning_rate,
            critic_hidden_follows: critic.hidden_learning_rate == Some(RateOf::Policy),
            value_coefficient: critic.coefficient.unwrap_or_else(half),
            privileged: critic.privileged,
            max_grad_norm: learn.max_grad_norm,
            norm_of_both: learn.grad_norm_of == Some(NormOf::Both),
            adam_epsilon: learn.adam_epsilon,
            seed: learn.seed,
            checkpoint_every: learn.checkpoint_every,
            std,
            std_decay: learn.std_decay,
            limits_are_failures: learn.time_limit == Some(TimeLimit::Failure),
            step,
            round: Round::First,
            backend: learn.backend.unwrap_or_default(),
            device: learn.device.unwrap_or_default(),
        }
    }

    /// The settings of the part of `[fine_tune]` that its stage declares. Keys that are not set there are
    /// those of `[learn]`, except that exploration is constant.
    pub fn fine_tuning(learn: &Ppo, tuning: Section, std: Vec<f64>, step: f64) -> Self {
        let changed = Ppo {
            samples: tuning.value(fine_tune::Ppo::samples).unwrap_or(learn.samples),
            learning_rate: tuning
                .value(fine_tune::Ppo::learning_rate)
                .unwrap_or_else(|| learn.learning_rate.clone()),
            warm_up: tuning.value(fine_tune::Ppo::warm_up).unwrap_or(learn.warm_up),
            stop_at: None,
            std_decay: None,
            ..learn.clone()
        };
        Self { round: Round::FineTuning, ..Self::new(&changed, std, step) }
    }

    /// Name of a random stream of the training: `1/train/shuffle/0/2`.
    pub fn stream(&self, rest: &str) -> String {
        format!("{}/{}/{rest}", self.seed, self.round.word())
    }

    /// The settings with the standard deviations of the update after this share of all samples.
    pub fn exploring(&self, share: f64) -> Self {
        let factor = self.std_decay.map_or(1.0, |decay| decay.factor(share));
        Self { std: self.std.iter().map(|std| factor * std).collect(), ..self.clone() }
    }

    /// Control steps of each environment per update; at least one.
    pub fn horizon(&self) -> usize {
        (self.rollout / self.environments).max(1)
    }

    /// Samples of one update.
    pub fn batch(&self) -> usize {
        self.horizon() * self.environments
    }

    /// Number of updates of the whole schedule: enough for all samples; zero without samples.
    pub fn updates(&self) -> u64 {
        self.samples.div_ceil(self.batch() as u64)
    }

    /// The update before which the training ends: the end of the schedule, or of `stop_at` if that comes
    /// first.
    pub fn end(&self) -> u64 {
        let stop = self.stop_at.map(|samples| samples.div_ceil(self.batch() as u64));
        stop.unwrap_or(u64::MAX).min(self.updates())
    }

    /// Whether a training with other settings gives the same results up to where the shorter one ends: the
    /// settings differ only in what changes no number.
    pub fn agrees_with(&self, other: &Self) -> bool {
        Self { stop_at: other.stop_at, checkpoint_every: other.checkpoint_every, ..self.clone() } == *other
    }
}

impl Backend {
    fn is_native(&self) -> bool {
        *self == Self::Native
    }
}

impl Device {
    fn is_cpu(&self) -> bool {
        *self == Self::Cpu
    }
}

impl Shape {
    /// Widths of the whole network, inputs first.
    pub fn widths(&self, inputs: usize, outputs: usize) -> Vec<usize> {
        [inputs].into_iter().chain(self.hidden.iter().copied()).chain([outputs]).collect()
    }
}

/// An update is undone if a minibatch finds the policy this many KL targets away from the old one. Healthy
/// updates stay below twice the target.
const OVERRUN: f64 = 5.0;

/// Bounds of an adapted step size.
const RATE_BOUNDS: [f64; 2] = [1e-6, 1e-3];

impl Rate {
    fn new(written: &LearningRate) -> Self {
        match written {
            LearningRate::Constant(rate) => Self::Constant(*rate),
            LearningRate::Linear(LinearRate { linear }) => {
                let first = linear.first().copied().unwrap_or_default();
                Self::Linear([first, linear.last().copied().unwrap_or(first)])
            }
            LearningRate::Steered(rate) => Self::Steered { target: rate.kl_target, start: rate.start },
        }
    }

    /// Step size of the update that begins after this share of all samples; `steered` is the last result of
    /// [`Rate::steer`].
    pub fn at(&self, share: f64, steered: f64) -> f64 {
        match self {
            Self::Constant(rate) => *rate,
            Self::Linear([first, last]) => first + (last - first) * share,
            Self::Steered { .. } => steered,
        }
    }

    /// Step size of the first update.
    pub fn start(&self) -> f64 {
        match self {
            Self::Constant(rate) | Self::Linear([rate, _]) | Self::Steered { start: rate, .. } => *rate,
        }
    }

    /// Whether the step size follows the KL divergence.
    pub fn is_steered(&self) -> bool {
        matches!(self, Self::Steered { .. })
    }

    /// The next step size, after an update with this step size moved the policy by this KL divergence.
    pub fn steer(&self, rate: f64, divergence: f64) -> f64 {
        let Self::Steered { target, .. } = self else { return rate };
        let factor = match divergence / target {
            ratio if ratio > OVERRUN => 0.5,
            ratio if ratio > 2.0 => 1.0 / 1.5,
            ratio if ratio > 1.3 => 1.0 / 1.1,
            ratio if ratio < 0.5 => 1.2,
            ratio if ratio < 0.8 => 1.05,
            _ => 1.0,
        };
        (rate * factor).clamp(RATE_BOUNDS[0], RATE_BOUNDS[1])
    }

    /// Whether a policy that has moved by this KL divergence, over one minibatch, returns to the start of the
    /// update: the step size is far too large.
    pub fn overrun(&self, divergence: f64) -> bool {
        matches!(self, Self::Steered { target, .. } if divergence > OVERRUN * target)
    }

    /// Whether the passes over the rollout end at this KL divergence.
    pub fn exhausted(&self, divergence: f64) -> bool {
        matches!(self, Self::Steered { target, .. } if divergence > 1.5 * target)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steered_rate_moves_by_its_six_factors() {
        let rate = Rate::Steered { target: 0.01, start: 5e-5 };
        let factors = [
            (0.004, 1.2),
            (0.007, 1.05),
            (0.01, 1.0),
            (0.014, 1.0 / 1.1),
            (0.021, 1.0 / 1.5),
            (0.051, 1.0 / 2.0),
        ];
        for (divergence, factor) in factors {
            assert!((rate.steer(5e-5, divergence) / 5e-5 - factor).abs() < 1e-12, "{divergence}");
        }
        assert_eq!(rate.steer(1e-3, 0.0), 1e-3);
        assert!(rate.exhausted(0.0151) && !rate.exhausted(0.0149));
        assert!(rate.overrun(0.051) && !rate.overrun(0.049));
    }

    #[test]
    fn a_linear_rate_goes_from_its_first_to_its_last_value() {
        let rate = Rate::Linear([5e-5, 1e-6]);
        assert_eq!(rate.at(0.0, 1.0), 5e-5);
        assert!((rate.at(0.5, 1.0) - 2.55e-5).abs() < 1e-12);
        assert!((rate.at(1.0, 1.0) - 1e-6).abs() < 1e-18);
        assert!(!rate.exhausted(1.0) && !rate.overrun(1.0));
    }

    #[test]
    fn exploration_falls_linearly_over_the_first_part_and_stays() {
        let decay = Decay { to: 0.5, over: 0.4 };
        let left = [0.0, 0.1, 0.4, 1.0].map(|share| decay.factor(share));
        assert!(
            left.iter().zip([1.0, 0.875, 0.5, 0.5]).all(|(found, expected)| (found - expected).abs() < 1e-12)
        );
    }
}
