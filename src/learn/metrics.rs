//! Metrics of a training: after each update a line of `metrics.jsonl`, at the end `summary.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::finding::Finding;
use super::lane::{Records, Tally};
use super::settings::Settings;

/// The metrics of one update. Means over episodes cover those that ended in it. Fields that files of earlier
/// versions lack are empty or `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct UpdateMetrics {
    /// Index of the update, from 0.
    pub update: u64,
    /// Samples so far.
    pub samples: u64,
    /// Samples of the whole training.
    pub samples_total: u64,
    /// Simulated time so far in s.
    pub simulated_s: f64,
    /// Wall time so far in s.
    pub wall_s: f64,
    /// CPU time so far in s, over all threads.
    pub cpu_s: f64,
    /// CPU time in s of this update's passes over the rollout, both networks.
    pub learner_cpu_s: f64,
    /// Samples per second of wall time in this update.
    pub samples_per_s: f64,
    /// Number of episodes that ended in this update.
    pub episodes: u64,
    /// Their mean return (undiscounted, unscaled sum of rewards).
    pub return_mean: Option<f64>,
    /// Their mean length in s.
    pub length_mean_s: Option<f64>,
    /// Mean reward per control step.
    pub reward_mean: f64,
    /// Mean of each weighted reward term per control step.
    pub terms: BTreeMap<String, f64>,
    /// Number of episodes that ended by each cause, `time_out` and `exploded` among them.
    pub ends: BTreeMap<String, u64>,
    /// KL divergence of the update; 0 in the warm-up.
    pub kl: f64,
    /// Share of the samples whose probability ratio was beyond the clip.
    pub clip_fraction: f64,
    /// Share of the variance of the critic's targets that its values before the update explain.
    pub explained_variance: f64,
    /// Mean squared error of the critic.
    pub value_loss: f64,
    /// The actor's step size.
    pub learning_rate: f64,
    /// Passes of the actor over the rollout; 0 in the warm-up.
    pub epochs: u64,
    /// Mean norm of the actor's gradient before clipping.
    pub actor_gradient_norm: f64,
    /// Mean norm of the critic's gradient before clipping.
    pub critic_gradient_norm: f64,
    /// Standard deviation of each weighted reward term over the control steps that did not end in a failure.
    pub term_spread: BTreeMap<String, f64>,
    /// Share of the samples in which the policy's mean is beyond the range of each action, where it is
    /// clipped.
    pub action_saturation: BTreeMap<String, f64>,
    /// Standard deviation of the policy's mean over the samples, in standard deviations of the exploration.
    pub action_spread: BTreeMap<String, f64>,
    /// Share of the actor's hidden units that are zero in all of 256 states of the rollout.
    pub dead_units: Option<f64>,
    /// Share of the control steps in which exactly one foot touches the ground.
    pub single_support: Option<f64>,
    /// Share of the control steps in which the reference motion is in single support.
    pub reference_single_support: Option<f64>,
    /// The least of the critic's targets.
    pub target_min: Option<f64>,
    /// The greatest of the critic's targets.
    pub target_max: Option<f64>,
    /// The least of the critic's values before the update.
    pub value_min: Option<f64>,
    /// The greatest of the critic's values before the update.
    pub value_max: Option<f64>,
    /// New findings of the run-time checks in this update.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Finding>,
}

impl UpdateMetrics {
    /// The metrics that follow from the rollout's sums, with the names of the reward terms and of the causes
    /// of an end.
    pub(super) fn of_rollout(tally: &Tally, names: &Names, settings: &Settings) -> Self {
        let mean = |sum: f64, count: u64| (count > 0).then(|| sum / count as f64);
        let steps = tally.steps.max(1) as f64;
        Self {
            episodes: tally.episodes,
            return_mean: mean(tally.episode_reward, tally.episodes),
            length_mean_s: mean(settings.step * tally.episode_steps as f64, tally.episodes),
            reward_mean: tally.reward / steps,
            terms: names.terms.iter().cloned().zip(tally.terms.iter().map(|sum| sum / steps)).collect(),
            ends: names.ends.iter().cloned().zip(tally.ends.iter().copied()).collect(),
            term_spread: names.terms.iter().cloned().zip(tally.term_deviations()).collect(),
            single_support: mean(tally.single_support[0] as f64, tally.stances),
            reference_single_support: mean(tally.single_support[1] as f64, tally.stances),
            ..Self::default()
        }
    }

    /// The metrics as a line of `metrics.jsonl`, with its line break. The caller has checked that all numbers
    /// are finite.
    pub(super) fn line(&self) -> String {
        serde_json::to_string(self).expect("metrics are plain numbers and names") + "\n"
    }
}

/// Names of the reward terms and of the causes of an end.
#[derive(Clone, Debug)]
pub(super) struct Names {
    pub terms: Vec<String>,
    pub ends: Vec<String>,
}

/// Summary of a whole training: `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of samples used for learning.
    pub samples: u64,
    /// Updates.
    pub updates: u64,
    /// Simulated time in s.
    pub simulated_s: f64,
    /// Wall time in s.
    pub wall_s: f64,
    /// CPU time in s, over all threads.
    pub cpu_s: f64,
    /// CPU time per sample in microseconds.
    pub cpu_us_per_sample: f64,
    /// Samples per second of wall time.
    pub samples_per_s: f64,
    /// Mean return of the episodes of the last update in which any ended.
    pub return_mean: Option<f64>,
    /// Their mean length in s.
    pub length_mean_s: Option<f64>,
    /// Findings of the run-time checks; `None` in files of versions without checks.
    #[serde(default)]
    pub warnings: Option<Vec<Finding>>,
}

impl Summary {
    /// Summarizes a training from its clock and the last metrics with a finished episode.
    pub(super) fn new(
        samples: u64,
        clock: &Clock,
        settings: &Settings,
        last: Option<&UpdateMetrics>,
    ) -> Self {
        let wall_s = clock.wall();
        Self {
            samples,
            updates: settings.end(),
            simulated_s: samples as f64 * settings.step,
            wall_s,
            cpu_s: clock.cpu,
            cpu_us_per_sample: 1e6 * clock.cpu / samples.max(1) as f64,
            samples_per_s: samples as f64 / wall_s.max(1e-9),
            return_mean: last.and_then(|metrics| metrics.return_mean),
            length_mean_s: last.and_then(|metrics| metrics.length_mean_s),
            warnings: None,
        }
    }
}

/// `1 - variance(targets - values) / variance(targets)`; 0 when the targets do not vary.
pub(super) fn explained_variance(records: &[&Records]) -> f64 {
    let pairs = || {
        records
            .iter()
            .flat_map(|r| r.targets.iter().zip(&r.values))
            .map(|(t, v)| (f64::from(*t), f64::from(*v)))
    };
    let variance = |of: fn((f64, f64)) -> f64| {
        let count = pairs().count() as f64;
        let mean = pairs().map(of).sum::<f64>() / count;
        pairs().map(|pair| (of(pair) - mean) * (of(pair) - mean)).sum::<f64>() / count
    };
    let total = variance(|(target, _)| target);
    if total > 0.0 { 1.0 - variance(|(target, value)| target - value) / total } else { 0.0 }
}
