//! Both losses of PPO with libtorch's operations, in double precision.
//!
//! The rollout is copied to the device once per update and the order of the samples once per pass. For each
//! minibatch three sums come back, which decide when the update ends.

use std::ops::Range;

use tch::{Device, Kind, Tensor};

use super::mlp::{TorchMlp, Workspace};
use crate::learn::backend::{ADVANTAGE_EPSILON, Loss, Moments, Sums, TrainableMlp, precisions};
use crate::learn::lane::Records;
use crate::learn::settings::Settings;

/// A loss over a rollout on a device, one row per sample.
pub struct TorchLoss {
    inputs: Tensor,
    role: Role,
    /// Order of the samples in a pass.
    order: Tensor,
    /// Samples of the minibatch.
    minibatch: usize,
    device: Device,
}

/// Which network the loss is for, with its inputs.
enum Role {
    Actor(Surrogate),
    Critic {
        targets: Tensor,
        /// Derivative of the loss with respect to the mean error.
        factor: f64,
    },
}

/// Inputs of the actor's loss.
struct Surrogate {
    actions: Tensor,
    /// The actor's outputs before the update.
    means: Tensor,
    advantages: Tensor,
    /// Inverse variance of each action.
    precisions: Tensor,
    /// Whether advantages are normalised over the rollout.
    over_rollout: bool,
    /// Mean of the advantages, of the rollout or of the minibatch.
    mean: Tensor,
    /// Their standard deviation.
    deviation: Tensor,
    clip: f64,
}

impl TorchLoss {
    /// The actor's loss, for observations of this width.
    pub fn of_actor(device: Device, records: &[&Records], settings: &Settings, width: usize) -> Self {
        let rows = |width, of| stacked(records, settings.horizon(), width, of).to_device(device);
        let actions = settings.std.len();
        let of_rollout = Moments::of_rollout(records, settings);
        let Moments { mean, deviation } = of_rollout.unwrap_or_default();
        let surrogate = Surrogate {
            actions: rows(actions, |records| &records.actions).to_kind(Kind::Double),
            means: rows(actions, |records| &records.means).to_kind(Kind::Double),
            advantages: rows(1, |records| &records.advantages).to_kind(Kind::Double),
            precisions: Tensor::from_slice(&precisions(settings)).to_device(device),
            over_rollout: of_rollout.is_some(),
            mean: Tensor::from(mean).to_device(device),
            deviation: Tensor::from(deviation).to_device(device),
            clip: settings.clip,
        };
        Self::new(device, rows(width, |records| &records.observations), Role::Actor(surrogate))
    }

    /// The critic's loss, for states of this width.
    pub fn of_critic(device: Device, records: &[&Records], settings: &Settings, width: usize) -> Self {
        let rows = |width, of| stacked(records, settings.horizon(), width, of).to_device(device);
        let factor = 2.0 * settings.value_coefficient;
        let role = Role::Critic { targets: rows(1, |records| &records.targets), factor };
        Self::new(device, rows(width, |records| &records.states), role)
    }

    fn new(device: Device, inputs: Tensor, role: Role) -> Self {
        Self { inputs, role, order: Tensor::zeros([0], (Kind::Int64, device)), minibatch: 0, device }
    }
}

/// The records of all environments stacked, one row of this width per control step.
fn stacked(records: &[&Records], steps: usize, width: usize, of: fn(&Records) -> &Vec<f32>) -> Tensor {
    // The states have one more row: the state after the rollout.
    let numbers: Vec<f32> =
        records.iter().flat_map(|records| &of(records)[..steps * width]).copied().collect();
    Tensor::from_slice(&numbers).view([(records.len() * steps) as i64, width as i64])
}

impl Loss<TorchMlp> for TorchLoss {
    fn shuffle(&mut self, order: Vec<usize>) {
        let order: Vec<i64> = order.into_iter().map(|sample| sample as i64).collect();
        self.order = Tensor::from_slice(&order).to_device(self.device);
    }

    fn begin(&mut self, minibatch: Range<usize>) {
        self.minibatch = minibatch.len();
        if let Role::Actor(surrogate) = &mut self.role
            && !surrogate.over_rollout
        {
            let samples = self.order.narrow(0, minibatch.start as i64, minibatch.len() as i64);
            surrogate.normalise_over(&samples);
        }
    }

    fn differentiate(
        &mut self,
        block: Range<usize>,
        network: &TorchMlp,
        space: &mut Workspace,
        sums: &mut Sums,
    ) {
        let samples = self.order.narrow(0, block.start as i64, block.len() as i64);
        let _ = self.inputs.index_select_out(&space.inputs, 0, &samples);
        network.forward(space);
        match &self.role {
            Role::Actor(surrogate) => surrogate.differentiate(&samples, self.minibatch, space, sums),
            Role::Critic { targets, factor } => {
                let (outputs, slopes) = space.slopes_mut();
                let error = outputs - targets.index_select(0, &samples);
                slopes.copy_(&(&error * *factor / self.minibatch as f64));
                sums.error += error.to_kind(Kind::Double).square().sum(Kind::Double).double_value(&[]);
            }
        }
    }
}

impl Surrogate {
    /// Computes mean and standard deviation of the advantages of these samples.
    fn normalise_over(&mut self, samples: &Tensor) {
        let advantages = self.advantages.index_select(0, samples);
        self.mean = advantages.mean(Kind::Double);
        let squares = (&advantages - &self.mean).square().sum(Kind::Double);
        self.deviation = (squares / f64::max(advantages.numel() as f64 - 1.0, 1.0)).sqrt();
    }

    /// Writes the derivatives of the actor's loss over a minibatch of `minibatch` samples at some of them, by
    /// the formulas of the native backend.
    fn differentiate(&self, samples: &Tensor, minibatch: usize, space: &mut Workspace, sums: &mut Sums) {
        let (outputs, slopes) = space.slopes_mut();
        let [actions, old, advantages] =
            [&self.actions, &self.means, &self.advantages].map(|rows| rows.index_select(0, samples));
        let outputs = outputs.to_kind(Kind::Double);
        let (moved, drawn): (Tensor, Tensor) = (&outputs - &old, &actions - &old);
        let half: Tensor = &self.precisions * 0.5;
        let pulled: Tensor = drawn * 2.0 - &moved;
        let log_ratio = (pulled * &moved * &half).sum_dim_intlist(1i64, true, Kind::Double);
        let ratio = log_ratio.exp();
        let advantages = (advantages - &self.mean) / (&self.deviation + ADVANTAGE_EPSILON);
        let is_clipped =
            ratio.gt(1.0 + self.clip).where_self(&advantages.gt(0.0), &ratio.lt(1.0 - self.clip));
        let pull = (-advantages * &ratio / minibatch as f64).masked_fill(&is_clipped, 0.0);
        slopes.copy_(&(pull * &self.precisions * (actions - &outputs)));
        let divergence = (half * moved.square()).sum(Kind::Double);
        let clipped = (ratio - 1.0).abs().gt(self.clip).sum(Kind::Double);
        let mut found = [0.0; 2];
        Tensor::stack(&[divergence, clipped], 0).to_device(Device::Cpu).copy_data(&mut found, 2);
        sums.divergence += found[0];
        sums.clipped += found[1];
    }
}
