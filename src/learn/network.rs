//! Plain-Rust inference of the actor and the critic: the rollout never calls libtorch.

use serde::{Deserialize, Serialize};

/// A fully connected layer: `output = weight * input + bias`, then the activation of its network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// Row-major, `outputs` rows of `inputs` numbers (the layout of torch's `Linear`).
    pub weight: Vec<f32>,
    /// One number per output.
    pub bias: Vec<f32>,
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
}

/// A multilayer perceptron; the activation stands between layers, not after the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// The layers.
    pub layers: Vec<Layer>,
    /// The activation between layers.
    pub activation: Activation,
}

/// The activations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(0, x)
    Relu,
    /// Hyperbolic tangent.
    Tanh,
    /// Exponential linear unit.
    Elu,
}
