//! Every backend of this build is compared with finite differences, with plain inference and with the other
//! backends.

use super::native::{Native, NativeMlp};
use super::*;
use crate::learn::network::Activation;
use crate::learn::{Network, Scratch};
use crate::stream::Stream;

const WIDTHS: [usize; 4] = [5, 24, 17, 3];
const ACTIVATIONS: [Activation; 3] = [Activation::Relu, Activation::Tanh, Activation::Elu];

/// Access to a network's numbers, on whichever device they are.
trait Probe: TrainableMlp {
    fn write_inputs(space: &mut Self::Workspace, numbers: &[f32]);
    fn outputs(space: &mut Self::Workspace) -> Vec<f32>;
    fn write_slopes(space: &mut Self::Workspace, numbers: &[f32]);
    fn gradient(&self) -> Vec<f32>;
}

impl Probe for NativeMlp {
    fn write_inputs(space: &mut Self::Workspace, numbers: &[f32]) {
        space.inputs.copy_from_slice(numbers);
    }

    fn outputs(space: &mut Self::Workspace) -> Vec<f32> {
        space.slopes_mut().0.to_vec()
    }

    fn write_slopes(space: &mut Self::Workspace, numbers: &[f32]) {
        space.slopes_mut().1.copy_from_slice(numbers);
    }

    fn gradient(&self) -> Vec<f32> {
        self.gradient.to_vec()
    }
}

#[cfg(feature = "torch")]
impl Probe for torch::TorchMlp {
    fn write_inputs(space: &mut Self::Workspace, numbers: &[f32]) {
        let shape = space.inputs.size();
        space.inputs.copy_(&tch::Tensor::from_slice(numbers).view(shape.as_slice()));
    }

    fn outputs(space: &mut Self::Workspace) -> Vec<f32> {
        torch::numbers(space.slopes_mut().0)
    }

    fn write_slopes(space: &mut Self::Workspace, numbers: &[f32]) {
        let slopes = space.slopes_mut().1;
        let shape = slopes.size();
        slopes.copy_(&tch::Tensor::from_slice(numbers).view(shape.as_slice()));
    }

    fn gradient(&self) -> Vec<f32> {
        torch::numbers(&self.gradient)
    }
}

fn normal(count: usize) -> Vec<f32> {
    let mut stream = Stream::new("test/gradient/inputs");
    (0..count).map(|_| stream.normal() as f32).collect()
}

/// A network whose last layer is as large as the others, so that gradients are not tiny.
fn network(activation: Activation) -> Network {
    let mut network = Network::orthogonal(&WIDTHS, activation, &mut Stream::new("test/gradient"));
    network.layers[2].weight.iter_mut().for_each(|x| *x *= 100.0);
    network
        .layers
        .iter_mut()
        .for_each(|layer| layer.bias.iter_mut().enumerate().for_each(|(i, x)| *x = 0.01 * i as f32));
    network
}

/// The outputs for one row of inputs, in f64.
fn outputs(network: &Network, inputs: &[f32]) -> Vec<f64> {
    let mut row: Vec<f64> = inputs.iter().map(|x| f64::from(*x)).collect();
    let last = network.layers.len() - 1;
    for (index, layer) in network.layers.iter().enumerate() {
        let unit = |(weights, bias): (&[f32], &f32)| {
            let sum =
                f64::from(*bias) + weights.iter().zip(&row).map(|(w, x)| f64::from(*w) * x).sum::<f64>();
            match network.activation {
                _ if index == last => sum,
                Activation::Relu => sum.max(0.0),
                Activation::Tanh => libm::tanh(sum),
                Activation::Elu if sum > 0.0 => sum,
                Activation::Elu => libm::expm1(sum),
            }
        };
        row = layer.weight.chunks_exact(layer.inputs).zip(&layer.bias).map(unit).collect();
    }
    row
}

/// Half the squared sum of the outputs, weighted by their index, in f64.
fn loss(network: &Network, inputs: &[f32]) -> f64 {
    let rows = inputs.chunks_exact(WIDTHS[0]).flat_map(|row| outputs(network, row));
    rows.enumerate().map(|(place, y)| 0.5 * (1.0 + place as f64) * y * y).sum()
}

/// The gradient of [`loss`] over four rows: of three rows first, then accumulated with that of the fourth.
fn gradient<B: Backend<Mlp: Probe>>(backend: B, network: &Network, inputs: &[f32]) -> Vec<f32> {
    let mut trained = backend.mlp(network);
    let mut spaces = Workspaces::default();
    for (rows, beta) in [(0..3, Beta::Zero), (3..4, Beta::One)] {
        let space = spaces.of(&trained, rows.len());
        B::Mlp::write_inputs(space, &inputs[rows.start * WIDTHS[0]..rows.end * WIDTHS[0]]);
        trained.forward(space);
        let slope = |(place, y): (usize, f32)| (1.0 + (rows.start * WIDTHS[3] + place) as f32) * y;
        let slopes: Vec<f32> = B::Mlp::outputs(space).into_iter().enumerate().map(slope).collect();
        B::Mlp::write_slopes(space, &slopes);
        trained.backward(space, beta);
    }
    trained.gradient()
}

fn has_the_gradients_of_finite_differences<B: Backend<Mlp: Probe>>(backend: B) {
    for activation in ACTIVATIONS {
        let network = network(activation);
        let inputs = normal(4 * WIDTHS[0]);
        let gradient = gradient(backend, &network, &inputs);
        for (layer, place) in layout::Layout::new(&network).layers.iter().enumerate() {
            for probe in 0..7 {
                let weight = probe * 31 % network.layers[layer].weight.len();
                let bias = probe % network.layers[layer].bias.len();
                let nudged_loss = |amount: f32, in_bias: bool| {
                    let mut nudged = network.clone();
                    let layer = &mut nudged.layers[layer];
                    *(if in_bias { &mut layer.bias[bias] } else { &mut layer.weight[weight] }) += amount;
                    loss(&nudged, &inputs)
                };
                for (in_bias, at) in [(false, place.weight.start + weight), (true, place.bias.start + bias)] {
                    let expected = (nudged_loss(2e-3, in_bias) - nudged_loss(-2e-3, in_bias)) / 4e-3;
                    let found = gradient[at];
                    let error = (f64::from(found) - expected).abs();
                    assert!(
                        error < 2e-3 * (1.0 + expected.abs()),
                        "{activation:?}, {backend:?}, layer {layer}: {found} is not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn gradients_equal_finite_differences() {
    has_the_gradients_of_finite_differences(Native);
    #[cfg(feature = "torch")]
    torch::Torch::available().into_iter().for_each(has_the_gradients_of_finite_differences);
}

fn has_the_outputs_of_plain_inference<B: Backend<Mlp: Probe>>(backend: B) {
    let policy = |activation| {
        let mut network =
            Network::orthogonal(&[30, 256, 256, 13], activation, &mut Stream::new("test/gradient/policy"));
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 100.0);
        network
    };
    for network in ACTIVATIONS.into_iter().flat_map(|activation| [network(activation), policy(activation)]) {
        let trained = backend.mlp(&network);
        let mut space = trained.workspace(33);
        let inputs = normal(33 * network.inputs());
        B::Mlp::write_inputs(&mut space, &inputs);
        trained.forward(&mut space);
        let mut plain = vec![0.0; 33 * network.outputs()];
        network.forward(&inputs, &mut plain, &mut Scratch::default());
        let apart = |(a, b): (&f32, &f32)| (a - b).abs() / (1.0 + b.abs());
        let apart = plain.iter().zip(&B::Mlp::outputs(&mut space)).map(apart).fold(0.0, f32::max);
        assert!(apart < 1e-6, "{:?}, {backend:?}, {:?}: {apart:.1e}", network.activation, network.widths());
        assert_eq!(trained.network(), network);
    }
}

#[test]
fn outputs_equal_plain_inference() {
    has_the_outputs_of_plain_inference(Native);
    #[cfg(feature = "torch")]
    torch::Torch::available().into_iter().for_each(has_the_outputs_of_plain_inference);
}

fn takes_moments_of_its_own_layout_only<B: Backend>(backend: B) {
    let network = network(Activation::Relu);
    let mut trained = backend.mlp(&network);
    let fresh = trained.adam();
    let moved = Adam { first: vec![0.5; fresh.first.len()], steps: 3, ..fresh.clone() };
    assert!(trained.set_adam(&moved) && trained.adam() == moved);
    assert!(!trained.set_adam(&Adam::new(fresh.first.len() + 1)) && trained.adam() == moved);
}

#[test]
fn moments_of_another_network_are_refused() {
    takes_moments_of_its_own_layout_only(Native);
    #[cfg(feature = "torch")]
    torch::Torch::available().into_iter().for_each(takes_moments_of_its_own_layout_only);
}
