//! Networks laid out for inference in plain Rust.
//!
//! The rollout, the evaluation and the deployed policy use this and never call libtorch.

use super::network::{Activation, Network};
use super::product::Panels;

/// Buffers of an inference, kept between calls so that it does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    source: Vec<f32>,
    target: Vec<f32>,
}

/// A network laid out for inference: made once for as long as its parameters stay as they are.
#[derive(Clone, Debug)]
pub struct Inference {
    layers: Vec<Panels>,
    activation: Activation,
}

impl Inference {
    /// Lays a network out.
    pub fn new(network: &Network) -> Self {
        Self { layers: network.layers.iter().map(Panels::new).collect(), activation: network.activation }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.inputs)
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.outputs)
    }

    /// Writes the outputs of a batch: `inputs` holds rows of [`Inference::inputs`] numbers, `outputs` as many rows
    /// of [`Inference::outputs`]. A row's result does not depend on the other rows nor on their number.
    pub fn forward(&self, inputs: &[f32], outputs: &mut [f32], scratch: &mut Scratch) {
        let rows = inputs.len() / self.inputs();
        let last = self.layers.len() - 1;
        scratch.source.clear();
        scratch.source.extend_from_slice(inputs);
        for (index, layer) in self.layers.iter().enumerate() {
            if index == last {
                layer.apply(&scratch.source, &mut outputs[..rows * layer.outputs]);
            } else {
                scratch.target.resize(rows * layer.outputs, 0.0);
                layer.apply(&scratch.source, &mut scratch.target);
                self.activation.apply(&mut scratch.target);
                std::mem::swap(&mut scratch.source, &mut scratch.target);
            }
        }
    }
}
