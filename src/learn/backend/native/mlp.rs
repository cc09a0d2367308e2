//! A network under training: hand-written forward and backward passes on preallocated arrays. A pass over the
//! same numbers gives the same bits, whatever the number of threads.

use super::aligned::Aligned;
use super::matrix::{Matrix, multiply};
use crate::learn::adam::{self, Adam, Rule};
use crate::learn::backend::layout::Layout;
use crate::learn::backend::{Beta, TrainableMlp};
use crate::learn::network::{Activation, Network};

/// Number of rows whose activations and derivatives in two hidden layers of 256 units take 2 MB, which fits a
/// core's cache.
const BLOCK_ROWS: usize = 512;

/// A network with its gradient and Adam's moments, all flat.
#[derive(Clone, Debug)]
pub struct NativeMlp {
    layout: Layout,
    parameters: Aligned,
    pub(in crate::learn::backend) gradient: Aligned,
    adam: Adam,
}

/// Activations and their gradients for one number of rows.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The network's inputs, `rows` x inputs.
    pub inputs: Aligned,
    /// The outputs of each layer, `rows` x outputs.
    outputs: Vec<Aligned>,
    /// Derivatives of the loss with respect to each layer's sums before the activation, `rows` x outputs.
    deltas: Vec<Aligned>,
}

/// Snapshot of a network's parameters and moments.
#[derive(Clone, Debug)]
pub struct Snapshot {
    parameters: Aligned,
    adam: Adam,
}

impl NativeMlp {
    /// A copy of a network with fresh moments.
    pub fn new(network: &Network) -> Self {
        let layout = Layout::new(network);
        let mut parameters = Aligned::zeros(layout.len);
        layout.write(network, &mut parameters);
        Self { parameters, gradient: Aligned::zeros(layout.len), adam: Adam::new(layout.len), layout }
    }
}

impl TrainableMlp for NativeMlp {
    type Workspace = Workspace;
    type Snapshot = Snapshot;

    fn inputs(&self) -> usize {
        self.layout.inputs()
    }

    fn block_rows(&self, minibatch: usize) -> usize {
        minibatch.min(BLOCK_ROWS)
    }

    fn workspace(&self, rows: usize) -> Workspace {
        let buffers = || -> Vec<Aligned> {
            self.layout.layers.iter().map(|place| Aligned::zeros(rows * place.outputs)).collect()
        };
        Workspace { inputs: Aligned::zeros(rows * self.inputs()), outputs: buffers(), deltas: buffers() }
    }

    fn forward(&self, space: &mut Workspace) {
        let last = self.layout.layers.len() - 1;
        for (index, place) in self.layout.layers.iter().enumerate() {
            let (done, rest) = space.outputs.split_at_mut(index);
            let input = done.last().unwrap_or(&space.inputs);
            let output = &mut rest[0];
            let bias = &self.parameters[place.bias.clone()];
            output.chunks_exact_mut(bias.len()).for_each(|row| row.copy_from_slice(bias));
            let weight = Matrix::new(&self.parameters[place.weight.clone()], place.inputs);
            multiply(output, Beta::One, Matrix::new(input, place.inputs), weight.transposed());
            if index < last {
                self.layout.activation.apply(output);
            }
        }
    }

    fn backward(&mut self, space: &mut Workspace, beta: Beta) {
        for (index, place) in self.layout.layers.iter().enumerate().rev() {
            let input = if index == 0 { &space.inputs } else { &space.outputs[index - 1] };
            let deltas = &space.deltas[index];
            let columns = Matrix::new(deltas, place.outputs).transposed();
            multiply(
                &mut self.gradient[place.weight.clone()],
                beta,
                columns,
                Matrix::new(input, place.inputs),
            );
            sum_rows(deltas, beta, &mut self.gradient[place.bias.clone()]);
            if index == 0 {
                continue;
            }
            let (below, rest) = space.deltas.split_at_mut(index);
            let slopes = &mut below[index - 1];
            let weight = Matrix::new(&self.parameters[place.weight.clone()], place.inputs);
            multiply(slopes, Beta::Zero, Matrix::new(&rest[0], place.outputs), weight);
            self.layout.activation.multiply_by_derivative(&space.outputs[index - 1], slopes);
        }
    }

    fn gradient_norm(&self) -> f64 {
        adam::norm(&self.gradient)
    }

    fn step(&mut self, norm: f64, rule: Rule) {
        self.adam.step(&mut self.parameters, &self.gradient, norm, self.layout.last_layer(), rule);
    }

    fn network(&self) -> Network {
        self.layout.network(&self.parameters)
    }

    fn adam(&self) -> Adam {
        self.adam.clone()
    }

    fn set_adam(&mut self, adam: &Adam) -> bool {
        let fits = adam.fits(self.layout.len);
        if fits {
            self.adam = adam.clone();
        }
        fits
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot { parameters: self.parameters.clone(), adam: self.adam.clone() }
    }

    fn restore(&mut self, snapshot: &Snapshot) {
        self.parameters.copy_from_slice(&snapshot.parameters);
        self.adam = snapshot.adam.clone();
    }
}

/// `sums = column sums of the rows + beta sums`
fn sum_rows(rows: &[f32], beta: Beta, sums: &mut [f32]) {
    if beta == Beta::Zero {
        sums.fill(0.0);
    }
    for row in rows.chunks_exact(sums.len()) {
        sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
}

impl Workspace {
    /// The network's outputs, and the derivatives of the loss with respect to them, to be written.
    pub fn slopes_mut(&mut self) -> (&[f32], &mut [f32]) {
        let slopes = self.deltas.last_mut().expect("a network has a layer");
        (self.outputs.last().expect("a network has a layer"), slopes)
    }
}

impl Activation {
    /// Multiplies slopes by the activation's derivative, known from its output.
    fn multiply_by_derivative(self, outputs: &[f32], slopes: &mut [f32]) {
        let pairs = slopes.iter_mut().zip(outputs);
        match self {
            Self::Relu => pairs.for_each(|(slope, y)| *slope = if *y > 0.0 { *slope } else { 0.0 }),
            Self::Tanh => pairs.for_each(|(slope, y)| *slope *= 1.0 - y * y),
            Self::Elu => pairs.for_each(|(slope, y)| *slope *= if *y > 0.0 { 1.0 } else { y + 1.0 }),
        }
    }
}
