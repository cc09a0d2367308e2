//! Samples on a device: the slopes of both losses as libtorch's operations, in double precision.
//!
//! The rollout goes to the device once per update, the order of the samples once per pass; of each minibatch three sums
//! come back, on which the update's end depends.

use std::ops::Range;

use tch::{Device, Kind, Tensor};

use super::slices::{precisions, whole};
use super::{Samples, Sums};
use crate::learn::gradient::{Trainee, Workspace};
use crate::learn::lane::Records;
use crate::learn::settings::Settings;

/// A rollout on a device, one row per sample.
pub struct Tensors {
    inputs: Tensor,
    role: Role,
    order: Tensor,
    device: Device,
}

/// Whose loss it is, with what it is made of.
enum Role {
    Actor(Drawn),
    Critic { targets: Tensor },
}

/// What the policy did before the update.
struct Drawn {
    actions: Tensor,
    /// The actor's outputs.
    means: Tensor,
    advantages: Tensor,
    /// Inverse variance of each action.
    precisions: Tensor,
    /// Mean and standard deviation of all advantages, where they are normalised over the rollout.
    whole: Option<(f64, f64)>,
    clip: f64,
}

impl Tensors {
    /// As [`super::Slices::of_actor`], for an actor with so many inputs.
    pub fn of_actor(records: &[&Records], settings: &Settings, (device, inputs): (Device, usize)) -> Self {
        let rows = |width, of| stacked(records, (settings.horizon(), width), of).to_device(device);
        let actions = settings.std.len();
        let drawn = Drawn {
            actions: rows(actions, |records| &records.actions).to_kind(Kind::Double),
            means: rows(actions, |records| &records.means).to_kind(Kind::Double),
            advantages: rows(1, |records| &records.advantages).to_kind(Kind::Double),
            precisions: Tensor::from_slice(&precisions(settings)).to_device(device),
            whole: whole(records, settings),
            clip: settings.clip,
        };
        Self {
            inputs: rows(inputs, |records| &records.observations),
            role: Role::Actor(drawn),
            order: none(device),
            device,
        }
    }

    /// As [`super::Slices::of_critic`], for a critic with so many inputs.
    pub fn of_critic(records: &[&Records], settings: &Settings, (device, inputs): (Device, usize)) -> Self {
        let rows = |width, of| stacked(records, (settings.horizon(), width), of).to_device(device);
        let role = Role::Critic { targets: rows(1, |records| &records.targets) };
        Self { inputs: rows(inputs, |records| &records.states), role, order: none(device), device }
    }
}

/// An order before there is one.
fn none(device: Device) -> Tensor {
    Tensor::zeros([0], (Kind::Int64, device))
}

/// The records of all environments below each other, one row of this width per control step.
fn stacked(records: &[&Records], (steps, width): (usize, usize), of: fn(&Records) -> &Vec<f32>) -> Tensor {
    // The states have a row more, that after the rollout.
    let numbers: Vec<f32> = records.iter().flat_map(|records| &of(records)[..steps * width]).copied().collect();
    Tensor::from_slice(&numbers).view([(records.len() * steps) as i64, width as i64])
}

impl Samples for Tensors {
    fn shuffle(&mut self, order: Vec<usize>) {
        let order: Vec<i64> = order.into_iter().map(|sample| sample as i64).collect();
        self.order = Tensor::from_slice(&order).to_device(self.device);
    }

    fn slopes(&mut self, minibatch: Range<usize>, network: &Trainee, space: &mut Workspace) -> Sums {
        let samples = self.order.narrow(0, minibatch.start as i64, minibatch.len() as i64);
        let _ = self.inputs.index_select_out(&space.inputs, 0, &samples);
        network.forward(space);
        let (outputs, slopes) = space.slope_tensors();
        match &self.role {
            Role::Actor(drawn) => drawn.surrogate(&samples, outputs, slopes),
            Role::Critic { targets } => {
                let error = outputs - targets.index_select(0, &samples);
                slopes.copy_(&(&error / minibatch.len() as f64));
                Sums {
                    error: error.to_kind(Kind::Double).square().sum(Kind::Double).double_value(&[]),
                    ..Sums::default()
                }
            }
        }
    }
}

impl Drawn {
    /// Writes the slopes of the actor's loss; the formulas are those of [`super::Slices`].
    fn surrogate(&self, samples: &Tensor, outputs: &Tensor, slopes: &mut Tensor) -> Sums {
        let [actions, old, advantages] =
            [&self.actions, &self.means, &self.advantages].map(|rows| rows.index_select(0, samples));
        let rows = samples.numel() as f64;
        let outputs = outputs.to_kind(Kind::Double);
        let (moved, drawn): (Tensor, Tensor) = (&outputs - &old, &actions - &old);
        let half: Tensor = &self.precisions * 0.5;
        let pulled: Tensor = drawn * 2.0 - &moved;
        let log_ratio = (pulled * &moved * &half).sum_dim_intlist(1i64, true, Kind::Double);
        let ratio = log_ratio.exp();
        let advantages = self.normalised(&advantages);
        let beyond = ratio.gt(1.0 + self.clip).where_self(&advantages.gt(0.0), &ratio.lt(1.0 - self.clip));
        let pull = (-advantages * &ratio / rows).masked_fill(&beyond, 0.0);
        slopes.copy_(&(pull * &self.precisions * (actions - &outputs)));
        let divergence = (half * moved.square()).sum(Kind::Double);
        let clipped = (ratio - 1.0).abs().gt(self.clip).sum(Kind::Double);
        let mut sums = [0.0; 2];
        Tensor::stack(&[divergence, clipped], 0).to_device(Device::Cpu).copy_data(&mut sums, 2);
        Sums { divergence: sums[0], clipped: sums[1], error: 0.0 }
    }

    /// Advantages with mean 0 and standard deviation 1, over the rollout or over these.
    fn normalised(&self, advantages: &Tensor) -> Tensor {
        if let Some((mean, deviation)) = self.whole {
            return (advantages - mean) / (deviation + 1e-8);
        }
        let centred = advantages - advantages.mean(Kind::Double);
        let variance = centred.square().sum(Kind::Double) / f64::max(advantages.numel() as f64 - 1.0, 1.0);
        centred / (variance.sqrt() + 1e-8)
    }
}
