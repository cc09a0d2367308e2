//! Both losses of PPO in plain Rust, in double precision.

use std::ops::Range;

use super::mlp::{NativeMlp, Workspace};
use crate::learn::backend::{ADVANTAGE_EPSILON, Loss, Moments, Sums, TrainableMlp, precisions};
use crate::learn::lane::Records;
use crate::learn::settings::Settings;

/// A loss over a recorded rollout.
#[derive(Clone, Debug)]
pub struct NativeLoss<'a> {
    records: &'a [&'a Records],
    settings: &'a Settings,
    role: Role,
    /// Order of the samples in a pass.
    order: Vec<usize>,
    /// Samples of the minibatch.
    minibatch: usize,
}

/// Which network the loss is for.
#[derive(Clone, Debug)]
enum Role {
    Actor(Surrogate),
    Critic,
}

/// Inputs of the actor's loss other than the records.
#[derive(Clone, Debug)]
struct Surrogate {
    /// Inverse variance of each action.
    precisions: Vec<f64>,
    /// Whether advantages are normalised over the rollout.
    over_rollout: bool,
    /// Mean and standard deviation of the advantages, over the rollout or the minibatch.
    advantages: Moments,
}

impl<'a> NativeLoss<'a> {
    /// The actor's loss.
    pub fn of_actor(records: &'a [&'a Records], settings: &'a Settings) -> Self {
        let of_rollout = Moments::of_rollout(records, settings);
        let surrogate = Surrogate {
            precisions: precisions(settings),
            over_rollout: of_rollout.is_some(),
            advantages: of_rollout.unwrap_or_default(),
        };
        Self { records, settings, role: Role::Actor(surrogate), order: Vec::new(), minibatch: 0 }
    }

    /// The critic's loss.
    pub fn of_critic(records: &'a [&'a Records], settings: &'a Settings) -> Self {
        Self { records, settings, role: Role::Critic, order: Vec::new(), minibatch: 0 }
    }

    /// The records and the step of a sample.
    fn at(&self, sample: usize) -> (&'a Records, usize) {
        let horizon = self.settings.horizon();
        (self.records[sample / horizon], sample % horizon)
    }

    /// Copies the rows of these samples.
    fn gather(&self, samples: &[usize], rows: &mut [f32], of: impl Fn(&Records) -> &Vec<f32>) {
        let width = rows.len() / samples.len();
        for (sample, row) in samples.iter().zip(rows.chunks_exact_mut(width)) {
            let (records, step) = self.at(*sample);
            row.copy_from_slice(&of(records)[step * width..(step + 1) * width]);
        }
    }

    fn surrogate(&self, samples: &[usize], surrogate: &Surrogate, space: &mut Workspace, sums: &mut Sums) {
        let Surrogate { precisions, advantages: Moments { mean, deviation }, .. } = surrogate;
        let (width, clip) = (precisions.len(), self.settings.clip);
        let (outputs, slopes) = space.slopes_mut();
        let rows = outputs.chunks_exact(width).zip(slopes.chunks_exact_mut(width));
        for (sample, (output, slope)) in samples.iter().zip(rows) {
            let (records, step) = self.at(*sample);
            let row = step * width..(step + 1) * width;
            let (action, old) = (&records.actions[row.clone()], &records.means[row]);
            // log r = sum of ((a - mu_old)^2 - (a - mu)^2) / (2 std^2); the normal density's constants
            // cancel.
            let mut log_ratio = 0.0;
            for dimension in 0..width {
                let moved = f64::from(output[dimension]) - f64::from(old[dimension]);
                let drawn = f64::from(action[dimension]) - f64::from(old[dimension]);
                log_ratio += 0.5 * precisions[dimension] * moved * (2.0 * drawn - moved);
                sums.divergence += 0.5 * precisions[dimension] * moved * moved;
            }
            let ratio = libm::exp(log_ratio);
            let advantage = (f64::from(records.advantages[step]) - mean) / (deviation + ADVANTAGE_EPSILON);
            sums.clipped += f64::from(u8::from((ratio - 1.0).abs() > clip));
            let is_clipped = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
            let pull = if is_clipped { 0.0 } else { -advantage * ratio / self.minibatch as f64 };
            for dimension in 0..width {
                let distance = f64::from(action[dimension]) - f64::from(output[dimension]);
                slope[dimension] = (pull * precisions[dimension] * distance) as f32;
            }
        }
    }

    fn squared_error(&self, samples: &[usize], space: &mut Workspace, sums: &mut Sums) {
        let (values, slopes) = space.slopes_mut();
        let factor = (2.0 * self.settings.value_coefficient) as f32;
        for ((sample, value), slope) in samples.iter().zip(values).zip(slopes) {
            let (records, step) = self.at(*sample);
            let error = value - records.targets[step];
            *slope = factor * error / self.minibatch as f32;
            sums.error += f64::from(error) * f64::from(error);
        }
    }
}

impl Loss<NativeMlp> for NativeLoss<'_> {
    fn shuffle(&mut self, order: Vec<usize>) {
        self.order = order;
    }

    fn begin(&mut self, minibatch: Range<usize>) {
        self.minibatch = minibatch.len();
        let (records, horizon) = (self.records, self.settings.horizon());
        if let Role::Actor(surrogate) = &mut self.role
            && !surrogate.over_rollout
        {
            let advantage = |sample: &usize| records[sample / horizon].advantages[sample % horizon];
            let found: Vec<f32> = self.order[minibatch].iter().map(advantage).collect();
            surrogate.advantages = Moments::of(&found);
        }
    }

    fn differentiate(
        &mut self,
        block: Range<usize>,
        network: &NativeMlp,
        space: &mut Workspace,
        sums: &mut Sums,
    ) {
        let samples = &self.order[block];
        match &self.role {
            Role::Actor(surrogate) => {
                self.gather(samples, &mut space.inputs, |records| &records.observations);
                network.forward(space);
                self.surrogate(samples, surrogate, space, sums);
            }
            Role::Critic => {
                self.gather(samples, &mut space.inputs, |records| &records.states);
                network.forward(space);
                self.squared_error(samples, space, sums);
            }
        }
    }
}
