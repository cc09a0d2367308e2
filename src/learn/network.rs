//! Networks of the actor and the critic in plain Rust: layout and initial values.
//!
//! `learn::inference` runs them, `learn::backend` trains them.

use serde::{Deserialize, Serialize};

pub use crate::kinds::learn::ppo::Activation;
use crate::stream::Stream;

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

/// A multilayer perceptron; the activation is applied between layers, not after the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// The layers.
    pub layers: Vec<Layer>,
    /// The activation between layers.
    pub activation: Activation,
}

impl Activation {
    /// Applies it to every number.
    pub fn apply(self, values: &mut [f32]) {
        match self {
            Self::Relu => values.iter_mut().for_each(|x| *x = x.max(0.0)),
            Self::Tanh => values.iter_mut().for_each(|x| *x = libm::tanhf(*x)),
            Self::Elu => values.iter_mut().for_each(|x| {
                if *x < 0.0 {
                    *x = libm::expm1f(*x);
                }
            }),
        }
    }
}

/// The gain of the hidden layers' orthogonal initial weights (Saxe et al. 2014, for ReLU).
const HIDDEN_GAIN: f64 = std::f64::consts::SQRT_2;
/// The gain of the last layer: the first actions are nearly zero.
const HEAD_GAIN: f64 = 0.01;

impl Network {
    /// A network with these layer widths (inputs first) and orthogonal initial weights: gain sqrt 2 in the
    /// hidden layers, 0.01 in the last, biases zero.
    pub fn orthogonal(widths: &[usize], activation: Activation, stream: &mut Stream) -> Self {
        let count = widths.len() - 1;
        let layers = widths
            .windows(2)
            .enumerate()
            .map(|(index, pair)| {
                let gain = if index + 1 == count { HEAD_GAIN } else { HIDDEN_GAIN };
                let weight = orthogonal(pair[1], pair[0], stream).iter().map(|x| (gain * x) as f32).collect();
                Layer { weight, bias: vec![0.0; pair[1]], inputs: pair[0], outputs: pair[1] }
            })
            .collect();
        Self { layers, activation }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.inputs)
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.outputs)
    }

    /// The widths, inputs first.
    pub fn widths(&self) -> Vec<usize> {
        self.layers.iter().map(|layer| layer.inputs).chain([self.outputs()]).collect()
    }

    /// Whether all parameters are finite.
    pub fn is_finite(&self) -> bool {
        self.layers.iter().all(|layer| layer.weight.iter().chain(&layer.bias).all(|x| x.is_finite()))
    }
}

/// A random matrix, row-major, whose rows (or columns, if there are fewer of them) are orthonormal and
/// uniformly distributed: Gram-Schmidt applied twice to normal vectors.
fn orthogonal(rows: usize, columns: usize, stream: &mut Stream) -> Vec<f64> {
    let (count, length) = (rows.min(columns), rows.max(columns));
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
    for _ in 0..count {
        let mut vector: Vec<f64> = (0..length).map(|_| stream.normal()).collect();
        for _ in 0..2 {
            for other in &basis {
                let share: f64 = other.iter().zip(&vector).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(other).for_each(|(x, y)| *x -= share * y);
            }
        }
        let norm = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        vector.iter_mut().for_each(|x| *x /= norm);
        basis.push(vector);
    }
    let entry =
        |row: usize, column: usize| if rows <= columns { basis[row][column] } else { basis[column][row] };
    (0..rows * columns).map(|index| entry(index / columns, index % columns)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn initial_weights_are_orthogonal_with_their_gain() {
        let network =
            Network::orthogonal(&[7, 12, 12, 3], Activation::Relu, &mut Stream::new("test/orthogonal"));
        for (layer, gain) in network.layers.iter().zip([2.0, 2.0, 1e-4]) {
            let (rows, columns) = (layer.outputs, layer.inputs);
            let row_wise = rows <= columns;
            let count = rows.min(columns);
            let at = |vector: usize, place: usize| {
                f64::from(if row_wise {
                    layer.weight[vector * columns + place]
                } else {
                    layer.weight[place * columns + vector]
                })
            };
            for a in 0..count {
                for b in 0..count {
                    let dot: f64 = (0..rows.max(columns)).map(|place| at(a, place) * at(b, place)).sum();
                    let expected = if a == b { gain } else { 0.0 };
                    assert!((dot - expected).abs() < 1e-5 * gain, "{a} {b}: {dot} is not {expected}");
                }
            }
            assert!(layer.bias.iter().all(|x| *x == 0.0));
        }
    }
}
