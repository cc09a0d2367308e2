//! Samples in the processor's memory: the slopes of both losses in plain Rust, in double precision.

use std::ops::Range;

use super::{Samples, Sums};
use crate::learn::gradient::{Trainee, Workspace, numbers_mut};
use crate::learn::lane::Records;
use crate::learn::settings::{Normalisation, Settings};

/// A rollout as it was recorded, in the order of a pass.
#[derive(Clone)]
pub struct Slices<'a> {
    records: &'a [&'a Records],
    settings: &'a Settings,
    role: Role,
    order: Vec<usize>,
    /// Samples of the minibatch.
    rows: usize,
}

/// Whose loss it is.
#[derive(Clone)]
enum Role {
    Actor {
        /// Inverse variance of each action.
        precisions: Vec<f64>,
        /// Whether advantages are normalised over the rollout.
        over_rollout: bool,
        /// Their mean and standard deviation, of the rollout or of the minibatch.
        moments: (f64, f64),
    },
    Critic,
}

impl<'a> Slices<'a> {
    /// For the actor's loss, `-mean min(r A, clamp(r, 1 - clip, 1 + clip) A)`.
    pub fn of_actor(records: &'a [&'a Records], settings: &'a Settings) -> Self {
        let whole = whole(records, settings);
        let (over_rollout, moments) = (whole.is_some(), whole.unwrap_or_default());
        let role = Role::Actor { precisions: precisions(settings), over_rollout, moments };
        Self { records, settings, role, order: Vec::new(), rows: 0 }
    }

    /// For the critic's loss, `coefficient mean (v - target)^2`.
    pub fn of_critic(records: &'a [&'a Records], settings: &'a Settings) -> Self {
        Self { records, settings, role: Role::Critic, order: Vec::new(), rows: 0 }
    }

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

    fn surrogate(
        &self,
        samples: &[usize],
        space: &mut Workspace,
        (precisions, (mean, deviation)): (&[f64], (f64, f64)),
        sums: &mut Sums,
    ) {
        let (width, clip) = (precisions.len(), self.settings.clip);
        let (outputs, slopes) = space.slopes_mut();
        let rows = outputs.chunks_exact(width).zip(slopes.chunks_exact_mut(width));
        for (sample, (output, slope)) in samples.iter().zip(rows) {
            let (records, step) = self.at(*sample);
            let row = step * width..(step + 1) * width;
            let (action, old) = (&records.actions[row.clone()], &records.means[row]);
            // log r = sum of ((a - mu_old)^2 - (a - mu)^2) / (2 std^2); the normal density's constants cancel.
            let mut log_ratio = 0.0;
            for dimension in 0..width {
                let moved = f64::from(output[dimension]) - f64::from(old[dimension]);
                let drawn = f64::from(action[dimension]) - f64::from(old[dimension]);
                log_ratio += 0.5 * precisions[dimension] * moved * (2.0 * drawn - moved);
                sums.divergence += 0.5 * precisions[dimension] * moved * moved;
            }
            let ratio = libm::exp(log_ratio);
            let advantage = (f64::from(records.advantages[step]) - mean) / (deviation + 1e-8);
            sums.clipped += f64::from(u8::from((ratio - 1.0).abs() > clip));
            let beyond = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
            let pull = if beyond { 0.0 } else { -advantage * ratio / self.rows as f64 };
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
            *slope = factor * error / self.rows as f32;
            sums.error += f64::from(error) * f64::from(error);
        }
    }
}

impl Samples for Slices<'_> {
    fn shuffle(&mut self, order: Vec<usize>) {
        self.order = order;
    }

    fn begin(&mut self, minibatch: Range<usize>) {
        self.rows = minibatch.len();
        let (records, horizon) = (self.records, self.settings.horizon());
        if let Role::Actor { over_rollout: false, moments: of_minibatch, .. } = &mut self.role {
            let advantage = |sample: &usize| records[sample / horizon].advantages[sample % horizon];
            let found: Vec<f32> = self.order[minibatch].iter().map(advantage).collect();
            *of_minibatch = moments(&found);
        }
    }

    fn slopes(&mut self, stretch: Range<usize>, network: &Trainee, space: &mut Workspace, sums: &mut Sums) {
        let samples = &self.order[stretch];
        match &self.role {
            Role::Actor { precisions, moments, .. } => {
                self.gather(samples, numbers_mut(&mut space.inputs), |records| &records.observations);
                network.forward(space);
                self.surrogate(samples, space, (precisions, *moments), sums);
            }
            Role::Critic => {
                self.gather(samples, numbers_mut(&mut space.inputs), |records| &records.states);
                network.forward(space);
                self.squared_error(samples, space, sums);
            }
        }
    }
}

/// Inverse variance of each action.
pub fn precisions(settings: &Settings) -> Vec<f64> {
    settings.std.iter().map(|std| 1.0 / (std * std)).collect()
}

/// Mean and standard deviation of all advantages, where they are normalised over the rollout.
pub fn whole(records: &[&Records], settings: &Settings) -> Option<(f64, f64)> {
    (settings.advantages == Normalisation::Batch)
        .then(|| moments(&records.iter().flat_map(|records| records.advantages.iter().copied()).collect::<Vec<f32>>()))
}

/// Mean and standard deviation (with n - 1).
fn moments(values: &[f32]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().map(|x| f64::from(*x)).sum::<f64>() / count;
    let squares = values.iter().map(|x| (f64::from(*x) - mean) * (f64::from(*x) - mean)).sum::<f64>();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}
