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

    /// How many hidden units are zero in every row of a batch, and how many there are.
    pub fn idle_units(&self, inputs: &[f32]) -> [usize; 2] {
        let (mut source, mut idle, mut units) = (inputs.to_vec(), 0, 0);
        let hidden = &self.layers[..self.layers.len() - 1];
        for layer in hidden {
            let mut target = vec![0.0; source.len() / layer.inputs * layer.outputs];
            layer.apply(&source, &mut target);
            self.activation.apply(&mut target);
            let is_idle = |unit: &usize| target.iter().skip(*unit).step_by(layer.outputs).all(|x| *x == 0.0);
            idle += (0..layer.outputs).filter(is_idle).count();
            units += layer.outputs;
            source = target;
        }
        [idle, units]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::Layer;

    #[test]
    fn units_that_are_zero_in_every_row_are_idle() {
        // One input; units x, -x, x - 3 and one that is always off.
        let weight = vec![1.0, -1.0, 1.0, 0.0];
        let first = Layer { weight, bias: vec![0.0, 0.0, -3.0, -1.0], inputs: 1, outputs: 4 };
        let last = Layer { weight: vec![1.0; 4], bias: vec![0.0], inputs: 4, outputs: 1 };
        let network = Network { layers: vec![first, last], activation: Activation::Relu };
        let of = |inputs: &[f32]| Inference::new(&network).idle_units(inputs);
        assert_eq!([of(&[2.0]), of(&[2.0, -1.0]), of(&[4.0, -1.0])], [[3, 4], [2, 4], [1, 4]]);
        let smooth = Network { activation: Activation::Tanh, ..network.clone() };
        assert_eq!(Inference::new(&smooth).idle_units(&[2.0]), [0, 4]);
    }
}
