//! The arithmetic of learning: multilayer perceptrons under training and the losses of PPO, with one
//! implementation per library.
//!
//! [`native`] is plain Rust with `gemm` and always available; `torch` is libtorch, on the CPU or a CUDA
//! device, in builds with the feature `torch`. Both take the same steps and differ only in the order of
//! summation, so their results agree up to rounding but not bit for bit. PPO itself ([`super::ppo`]) is
//! written against the traits below.

mod layout;
pub mod native;
#[cfg(test)]
mod tests;
#[cfg(feature = "torch")]
pub mod torch;

use std::fmt::Debug;
use std::ops::Range;

use super::adam::{Adam, Rule};
use super::lane::Records;
use super::network::Network;
use super::settings::{Normalisation, Settings};

/// A library that trains networks.
pub trait Backend: Copy + Debug + Send + Sync {
    /// A network under training.
    type Mlp: TrainableMlp;
    /// The loss of a network over a rollout.
    type Loss<'a>: Loss<Self::Mlp>;

    /// A copy of a network with fresh moments of Adam.
    fn mlp(self, network: &Network) -> Self::Mlp;

    /// The actor's loss over a rollout, `-mean min(r A, clamp(r, 1 - clip, 1 + clip) A)`, for observations of
    /// this width.
    fn actor_loss<'a>(
        self,
        records: &'a [&'a Records],
        settings: &'a Settings,
        width: usize,
    ) -> Self::Loss<'a>;

    /// The critic's loss over a rollout, `coefficient mean (v - target)^2`, for states of this width.
    fn critic_loss<'a>(
        self,
        records: &'a [&'a Records],
        settings: &'a Settings,
        width: usize,
    ) -> Self::Loss<'a>;
}

/// A multilayer perceptron with the gradient of its parameters and Adam's moments.
pub trait TrainableMlp: Send {
    /// Activations and their gradients for one number of rows.
    type Workspace: Send;
    /// Parameters and moments at one moment.
    type Snapshot: Send;

    /// Prepares the calling thread. Each thread calls it before its first product.
    fn prepare_thread() {}

    /// Number of inputs.
    fn inputs(&self) -> usize;

    /// Rows of a minibatch that pass through the network together.
    fn block_rows(&self, minibatch: usize) -> usize;

    /// Buffers for a number of rows.
    fn workspace(&self, rows: usize) -> Self::Workspace;

    /// Computes the outputs of the workspace's inputs.
    fn forward(&self, space: &mut Self::Workspace);

    /// Computes the gradient of a loss from its derivatives with respect to the outputs, which are in the
    /// workspace after [`TrainableMlp::forward`]: `gradient = backpropagated + beta gradient`.
    fn backward(&mut self, space: &mut Self::Workspace, beta: Beta);

    /// Euclidean norm of the gradient; not finite where the gradient is not.
    fn gradient_norm(&self) -> f64;

    /// One step of Adam. The gradient is clipped as if it had this norm: its own, or the joint norm of
    /// several networks' gradients.
    fn step(&mut self, norm: f64, rule: Rule);

    /// The network with its current parameters.
    fn network(&self) -> Network;

    /// Adam's current state.
    fn adam(&self) -> Adam;

    /// Replaces Adam's state. Returns false and changes nothing if the state belongs to another number of
    /// parameters.
    #[must_use]
    fn set_adam(&mut self, adam: &Adam) -> bool;

    /// State that [`TrainableMlp::restore`] returns to.
    fn snapshot(&self) -> Self::Snapshot;

    /// Returns to a snapshot of this network.
    fn restore(&mut self, snapshot: &Self::Snapshot);
}

/// A network's inputs and its loss over a rollout: sample `i` is step `i % horizon` of environment
/// `i / horizon`.
pub trait Loss<M: TrainableMlp>: Send {
    /// Sets the order of the samples.
    fn shuffle(&mut self, order: Vec<usize>);

    /// Begins a minibatch, a range of the order.
    fn begin(&mut self, minibatch: Range<usize>);

    /// Runs the network on a block of the minibatch, writes the derivatives of the loss over the whole
    /// minibatch with respect to the block's outputs into the workspace, and adds to the sums.
    fn differentiate(&mut self, block: Range<usize>, network: &M, space: &mut M::Workspace, sums: &mut Sums);
}

/// Sums over a minibatch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Actor only: KL divergence from the policy before the update, summed over the samples.
    pub divergence: f64,
    /// Actor only: number of samples whose probability ratio is outside the clip range.
    pub clipped: f64,
    /// Critic only: sum of squared errors.
    pub error: f64,
}

/// Factor on the previous content of a product's target, as in BLAS: `C = A B + beta C`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beta {
    /// The target is overwritten.
    Zero,
    /// The product is added to the target.
    One,
}

/// Workspaces of one network by their number of rows, each made on first use.
pub struct Workspaces<M: TrainableMlp>(Vec<(usize, M::Workspace)>);

impl<M: TrainableMlp> Default for Workspaces<M> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<M: TrainableMlp> Workspaces<M> {
    /// The workspace of this network for this number of rows.
    pub fn of(&mut self, network: &M, rows: usize) -> &mut M::Workspace {
        let known = self.0.iter().position(|(size, _)| *size == rows);
        let index = known.unwrap_or_else(|| {
            self.0.push((rows, network.workspace(rows)));
            self.0.len() - 1
        });
        &mut self.0[index].1
    }
}

/// Mean and standard deviation of advantages.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    mean: f64,
    /// With the divisor n - 1.
    deviation: f64,
}

impl Moments {
    fn of(advantages: &[f32]) -> Self {
        let count = advantages.len() as f64;
        let mean = advantages.iter().map(|x| f64::from(*x)).sum::<f64>() / count;
        let squares = advantages.iter().map(|x| (f64::from(*x) - mean) * (f64::from(*x) - mean)).sum::<f64>();
        Self { mean, deviation: (squares / (count - 1.0).max(1.0)).sqrt() }
    }

    /// Mean and standard deviation over all samples if advantages are normalised over the rollout.
    fn of_rollout(records: &[&Records], settings: &Settings) -> Option<Self> {
        let advantages = || records.iter().flat_map(|records| records.advantages.iter().copied());
        (settings.advantages == Normalisation::Batch).then(|| Self::of(&advantages().collect::<Vec<f32>>()))
    }
}

/// Added to the standard deviation that divides the advantages, against division by zero (as in the original
/// implementation of PPO, openai/baselines).
const ADVANTAGE_EPSILON: f64 = 1e-8;

/// Inverse variance of each action.
fn precisions(settings: &Settings) -> Vec<f64> {
    settings.std.iter().map(|std| 1.0 / (std * std)).collect()
}
