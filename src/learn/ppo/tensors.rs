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
    /// Samples of the minibatch.
    rows: usize,
    device: Device,
}

/// Whose loss it is, with what it is made of.
enum Role {
    Actor(Drawn),
    Critic {
        targets: Tensor,
        /// Slope of the loss over the mean error.
        factor: f64,
    },
}

/// What the policy did before the update.
struct Drawn {
    actions: Tensor,
    /// The actor's outputs.
    means: Tensor,
    advantages: Tensor,
    /// Inverse variance of each action.
    precisions: Tensor,
    /// Whether they are normalised over the rollout.
    over_rollout: bool,
    /// What advantages are normalised by, of the rollout or of the minibatch.
    mean: Tensor,
    deviation: Tensor,
    clip: f64,
}

impl Tensors {
    /// As [`super::Slices::of_actor`], for an actor with so many inputs.
    pub fn of_actor(records: &[&Records], settings: &Settings, (device, inputs): (Device, usize)) -> Self {
        let rows = |width, of| stacked(records, (settings.horizon(), width), of).to_device(device);
        let actions = settings.std.len();
        let whole = whole(records, settings);
        let (mean, deviation) = whole.unwrap_or_default();
        let drawn = Drawn {
            actions: rows(actions, |records| &records.actions).to_kind(Kind::Double),
            means: rows(actions, |records| &records.means).to_kind(Kind::Double),
            advantages: rows(1, |records| &records.advantages).to_kind(Kind::Double),
            precisions: Tensor::from_slice(&precisions(settings)).to_device(device),
            over_rollout: whole.is_some(),
            mean: Tensor::from(mean).to_device(device),
            deviation: Tensor::from(deviation).to_device(device),
            clip: settings.clip,
        };
        Self {
            inputs: rows(inputs, |records| &records.observations),
            role: Role::Actor(drawn),
            order: none(device),
            rows: 0,
            device,
        }
    }

    /// As [`super::Slices::of_critic`], for a critic with so many inputs.
    pub fn of_critic(records: &[&Records], settings: &Settings, (device, inputs): (Device, usize)) -> Self {
        let rows = |width, of| stacked(records, (settings.horizon(), width), of).to_device(device);
        let factor = 2.0 * settings.value_coefficient;
        let role = Role::Critic { targets: rows(1, |records| &records.targets), factor };
        Self { inputs: rows(inputs, |records| &records.states), role, order: none(device), rows: 0, device }
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

    fn begin(&mut self, minibatch: Range<usize>) {
        self.rows = minibatch.len();
        if let Role::Actor(drawn) = &mut self.role
            && !drawn.over_rollout
        {
            let samples = self.order.narrow(0, minibatch.start as i64, minibatch.len() as i64);
            drawn.normalise_over(&samples);
        }
    }

    fn slopes(&mut self, stretch: Range<usize>, network: &Trainee, space: &mut Workspace, sums: &mut Sums) {
        let samples = self.order.narrow(0, stretch.start as i64, stretch.len() as i64);
        let _ = self.inputs.index_select_out(&space.inputs, 0, &samples);
        network.forward(space);
        let (outputs, slopes) = space.slope_tensors();
        match &self.role {
            Role::Actor(drawn) => drawn.surrogate((&samples, self.rows), (outputs, slopes), sums),
            Role::Critic { targets, factor } => {
                let error = outputs - targets.index_select(0, &samples);
                slopes.copy_(&(&error * *factor / self.rows as f64));
                sums.error += error.to_kind(Kind::Double).square().sum(Kind::Double).double_value(&[]);
            }
        }
    }
}

impl Drawn {
    /// Takes mean and standard deviation of the advantages of these samples.
    fn normalise_over(&mut self, samples: &Tensor) {
        let advantages = self.advantages.index_select(0, samples);
        self.mean = advantages.mean(Kind::Double);
        let squares = (&advantages - &self.mean).square().sum(Kind::Double);
        self.deviation = (squares / f64::max(advantages.numel() as f64 - 1.0, 1.0)).sqrt();
    }

    /// Writes the slopes of the actor's loss over a minibatch of so many samples at some of them; the formulas are those
    /// of [`super::Slices`].
    fn surrogate(&self, (samples, rows): (&Tensor, usize), (outputs, slopes): (&Tensor, &mut Tensor), sums: &mut Sums) {
        let [actions, old, advantages] =
            [&self.actions, &self.means, &self.advantages].map(|rows| rows.index_select(0, samples));
        let outputs = outputs.to_kind(Kind::Double);
        let (moved, drawn): (Tensor, Tensor) = (&outputs - &old, &actions - &old);
        let half: Tensor = &self.precisions * 0.5;
        let pulled: Tensor = drawn * 2.0 - &moved;
        let log_ratio = (pulled * &moved * &half).sum_dim_intlist(1i64, true, Kind::Double);
        let ratio = log_ratio.exp();
        let advantages = (advantages - &self.mean) / (&self.deviation + 1e-8);
        let beyond = ratio.gt(1.0 + self.clip).where_self(&advantages.gt(0.0), &ratio.lt(1.0 - self.clip));
        let pull = (-advantages * &ratio / rows as f64).masked_fill(&beyond, 0.0);
        slopes.copy_(&(pull * &self.precisions * (actions - &outputs)));
        let divergence = (half * moved.square()).sum(Kind::Double);
        let clipped = (ratio - 1.0).abs().gt(self.clip).sum(Kind::Double);
        let mut found = [0.0; 2];
        Tensor::stack(&[divergence, clipped], 0).to_device(Device::Cpu).copy_data(&mut found, 2);
        sums.divergence += found[0];
        sums.clipped += found[1];
    }
}
