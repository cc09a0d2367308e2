//! Networks laid out for inference in plain Rust.
//!
//! Rollouts, evaluations and deployed policies use this; it never calls libtorch.

use super::network::{Activation, Network};
use super::product::Panels;

/// Buffers of an inference, kept between calls so that it does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    source: Vec<f32>,
    target: Vec<f32>,
}

/// A network laid out for inference; valid as long as its parameters do not change.
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

    /// Number of hidden units that are zero in every row of a batch, and the number of all hidden units.
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

    /// Writes the outputs of a batch: `inputs` holds rows of [`Inference::inputs`] numbers, `outputs` as many
    /// rows of [`Inference::outputs`]. A row's result does not depend on the other rows nor on their number.
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

impl Network {
    /// Writes the outputs of a single batch; see [`Inference::forward`].
    pub fn forward(&self, inputs: &[f32], outputs: &mut [f32], scratch: &mut Scratch) {
        Inference::new(self).forward(inputs, outputs, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::Layer;
    use crate::stream::Stream;

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

    #[test]
    fn a_hand_computed_network_gives_its_numbers() {
        let hidden =
            Layer { weight: vec![1.0, -1.0, 2.0, 0.5], bias: vec![0.5, -3.0], inputs: 2, outputs: 2 };
        let head = Layer { weight: vec![2.0, -4.0], bias: vec![0.25], inputs: 2, outputs: 1 };
        let mut network = Network { layers: vec![hidden, head], activation: Activation::Relu };
        let mut output = [0.0; 2];
        // Rows (3, 1) and (0, 2): hidden sums (2.5, 3.5) and (-1.5, -2).
        network.forward(&[3.0, 1.0, 0.0, 2.0], &mut output, &mut Scratch::default());
        assert_eq!(output, [2.0 * 2.5 - 4.0 * 3.5 + 0.25, 0.25]);
        network.activation = Activation::Elu;
        network.forward(&[3.0, 1.0, 0.0, 2.0], &mut output, &mut Scratch::default());
        let expected = 2.0 * (libm::exp(-1.5) - 1.0) - 4.0 * (libm::exp(-2.0) - 1.0) + 0.25;
        assert!((f64::from(output[1]) - expected).abs() < 1e-6);
    }

    #[test]
    fn a_row_does_not_depend_on_the_batch_around_it() {
        let network =
            Network::orthogonal(&[30, 256, 256, 13], Activation::Relu, &mut Stream::new("test/rows"));
        let mut stream = Stream::new("test/rows/inputs");
        let inputs: Vec<f32> = (0..70 * 30).map(|_| stream.normal() as f32).collect();
        let mut scratch = Scratch::default();
        let mut all = vec![0.0; 70 * 13];
        network.forward(&inputs, &mut all, &mut scratch);
        for rows in [1, 2, 3, 5, 8, 17, 32, 33, 64] {
            for start in [0, 1, 6] {
                let mut some = vec![0.0; rows * 13];
                network.forward(&inputs[start * 30..(start + rows) * 30], &mut some, &mut scratch);
                let expected = &all[start * 13..(start + rows) * 13];
                assert!(
                    some.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()),
                    "{rows} rows from {start}"
                );
            }
        }
    }
}
