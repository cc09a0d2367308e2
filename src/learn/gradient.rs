//! A network under training: forward and backward passes by hand on preallocated tensors.
//!
//! The numbers lie in libtorch's tensors, without autograd: aligned to 64 bytes, in fixed shapes, so a pass over the
//! same numbers gives the same bits. On the processor the products are those of [`super::multiply`] and what lies
//! between them is plain Rust on slices; where the processor cannot read the numbers, both are libtorch's own
//! operations ([`super::device`]). libtorch must run on one intra-op thread ([`use_one_thread`]): on matrices this
//! small a second one makes it ten times slower whenever a core is shared.

use tch::{Kind, Tensor};

use super::adam::{self, Adam, Rule};
use super::device::{self, Arithmetic, Moments};
use super::multiply::{Before, Matrix, multiply};
use super::network::{Activation, Layer, Network};

/// Parameters start at multiples of this many numbers: 64 bytes.
const ALIGNMENT: usize = 16;

/// A network with its gradient and Adam's moments, all flat.
pub struct Trainee {
    widths: Vec<usize>,
    activation: Activation,
    parameters: Tensor,
    gradient: Tensor,
    layers: Vec<Views>,
    arithmetic: Arithmetic,
    optimiser: Optimiser,
}

/// Adam's state where the parameters are.
enum Optimiser {
    Slices(Adam),
    Tensors(Moments),
}

/// Parameters and optimiser of a network at one moment.
pub struct State {
    parameters: Tensor,
    adam: Adam,
}

/// One layer's views into the flat tensors.
struct Views {
    weight: Tensor,
    weight_transposed: Tensor,
    bias: Tensor,
    weight_gradient: Tensor,
    bias_gradient: Tensor,
    /// Where weight and bias lie.
    weight_at: std::ops::Range<usize>,
    bias_at: std::ops::Range<usize>,
}

/// Workspaces by their number of rows, each made when it is first asked for.
#[derive(Default)]
pub struct Workspaces(Vec<Workspace>);

/// Activations and their gradients for one number of rows.
pub struct Workspace {
    /// The network's inputs, `rows` x inputs.
    pub inputs: Tensor,
    outputs: Vec<Tensor>,
    deltas: Vec<Tensor>,
    deltas_transposed: Vec<Tensor>,
}

/// Keeps libtorch from starting threads of its own. To be called by each thread before its first product.
pub fn use_one_thread() {
    tch::set_num_threads(1);
}

/// The numbers of a contiguous f32 tensor on the CPU.
pub(super) fn numbers(tensor: &Tensor) -> &[f32] {
    assert_readable(tensor);
    // SAFETY: the tensor owns this many f32 at its address, and nothing writes while `tensor` is borrowed.
    unsafe { std::slice::from_raw_parts(tensor.data_ptr().cast::<f32>(), tensor.numel()) }
}

/// The numbers of a contiguous f32 tensor on the CPU, to be written.
pub(super) fn numbers_mut(tensor: &mut Tensor) -> &mut [f32] {
    assert_readable(tensor);
    // SAFETY: as in `numbers`; views of the same memory are not read while `tensor` is borrowed mutably.
    unsafe { std::slice::from_raw_parts_mut(tensor.data_ptr().cast::<f32>(), tensor.numel()) }
}

/// Whether the processor can read a tensor as a slice of f32.
fn assert_readable(tensor: &Tensor) {
    assert!(tensor.device() == tch::Device::Cpu, "the numbers are on {:?}", tensor.device());
    assert!(tensor.is_contiguous() && tensor.kind() == Kind::Float, "the numbers are no slice of f32");
}

fn zeros(shape: &[usize], arithmetic: Arithmetic) -> Tensor {
    let shape: Vec<i64> = shape.iter().map(|size| *size as i64).collect();
    Tensor::zeros(shape, (Kind::Float, arithmetic.device()))
}

impl Trainee {
    /// A network in the processor's memory with fresh moments.
    pub fn new(network: &Network) -> Self {
        Self::on(Arithmetic::Slices, network)
    }

    /// A network with fresh moments where that arithmetic is done.
    pub fn on(arithmetic: Arithmetic, network: &Network) -> Self {
        let widths = network.widths();
        let mut end = 0;
        let places: Vec<_> = widths
            .windows(2)
            .map(|pair| {
                let mut take = |size: usize| {
                    let start = end;
                    end += size.next_multiple_of(ALIGNMENT);
                    start..start + size
                };
                (take(pair[0] * pair[1]), take(pair[1]))
            })
            .collect();
        let gradient = zeros(&[end], arithmetic);
        let mut parameters = zeros(&[end], Arithmetic::Slices);
        let flat = numbers_mut(&mut parameters);
        for (layer, (weight, bias)) in network.layers.iter().zip(&places) {
            flat[weight.clone()].copy_from_slice(&layer.weight);
            flat[bias.clone()].copy_from_slice(&layer.bias);
        }
        let parameters = parameters.to_device(arithmetic.device());
        let view = |tensor: &Tensor, at: &std::ops::Range<usize>| tensor.narrow(0, at.start as i64, at.len() as i64);
        let layers = widths
            .windows(2)
            .zip(places)
            .map(|(pair, (weight_at, bias_at))| {
                let shape = [pair[1] as i64, pair[0] as i64];
                let weight = view(&parameters, &weight_at).view(shape);
                Views {
                    weight_transposed: weight.tr(),
                    weight,
                    bias: view(&parameters, &bias_at),
                    weight_gradient: view(&gradient, &weight_at).view(shape),
                    bias_gradient: view(&gradient, &bias_at),
                    weight_at,
                    bias_at,
                }
            })
            .collect();
        let optimiser = Optimiser::at(arithmetic, &Adam::new(end));
        Self { widths, activation: network.activation, parameters, gradient, layers, arithmetic, optimiser }
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.widths[0]
    }

    /// How its arithmetic is done.
    pub fn arithmetic(&self) -> Arithmetic {
        self.arithmetic
    }

    /// Adam's state as it is now.
    pub fn adam(&self) -> Adam {
        match &self.optimiser {
            Optimiser::Slices(adam) => adam.clone(),
            Optimiser::Tensors(moments) => moments.adam(),
        }
    }

    /// What [`Trainee::restore`] comes back to.
    pub fn state(&self) -> State {
        State { parameters: self.parameters.copy(), adam: self.adam() }
    }

    /// Comes back to a state of this network.
    pub fn restore(&mut self, state: &State) {
        self.parameters.copy_(&state.parameters);
        self.optimiser = Optimiser::at(self.arithmetic, &state.adam);
    }

    /// The same with another state of Adam; none where that is of another number of parameters.
    pub fn with_adam(self, adam: &Adam) -> Option<Self> {
        let parameters = self.parameters.numel();
        let fits = adam.first.len() == parameters && adam.second.len() == parameters;
        fits.then(|| Self { optimiser: Optimiser::at(self.arithmetic, adam), ..self })
    }

    /// The network as it is now.
    pub fn network(&self) -> Network {
        let parameters = self.parameters.to_device(tch::Device::Cpu);
        let flat = numbers(&parameters);
        let layers = self.layers.iter().zip(self.widths.windows(2)).map(|(views, pair)| Layer {
            weight: flat[views.weight_at.clone()].to_vec(),
            bias: flat[views.bias_at.clone()].to_vec(),
            inputs: pair[0],
            outputs: pair[1],
        });
        Network { layers: layers.collect(), activation: self.activation }
    }

    /// Buffers for a number of rows.
    pub fn workspace(&self, rows: usize) -> Workspace {
        let zeros = |width: &usize| zeros(&[rows, *width], self.arithmetic);
        let buffers = || -> Vec<Tensor> { self.widths[1..].iter().map(zeros).collect() };
        let deltas = buffers();
        Workspace {
            inputs: zeros(&self.widths[0]),
            outputs: buffers(),
            deltas_transposed: deltas.iter().map(Tensor::tr).collect(),
            deltas,
        }
    }

    /// Computes the outputs of the workspace's inputs.
    pub fn forward(&self, space: &mut Workspace) {
        let last = self.layers.len() - 1;
        for (index, views) in self.layers.iter().enumerate() {
            let (before, rest) = space.outputs.split_at_mut(index);
            let input = before.last().unwrap_or(&space.inputs);
            let output = &mut rest[0];
            match self.arithmetic {
                Arithmetic::Slices => {
                    let (output, bias) = (numbers_mut(output), numbers(&views.bias));
                    output.chunks_exact_mut(bias.len()).for_each(|row| row.copy_from_slice(bias));
                    let inputs = self.widths[index];
                    let weight = Matrix::new(numbers(&views.weight), inputs);
                    multiply(output, Before::Sum, Matrix::new(numbers(input), inputs), weight.transposed());
                    if index < last {
                        self.activation.apply(output);
                    }
                }
                Arithmetic::Tensors(_) => {
                    let _ = views.bias.addmm_out(output, input, &views.weight_transposed);
                    if index < last {
                        device::activate(self.activation, output);
                    }
                }
            }
        }
    }

    /// Computes the gradient of a loss whose slope with respect to the outputs stands in
    /// [`Workspace::slopes_mut`], after [`Trainee::forward`], or adds it to the gradient over other rows.
    pub fn backward(&mut self, space: &mut Workspace, before: Before) {
        for (index, views) in self.layers.iter().enumerate().rev() {
            let input = if index == 0 { &space.inputs } else { &space.outputs[index - 1] };
            let [inputs, outputs] = [self.widths[index], self.widths[index + 1]];
            match self.arithmetic {
                Arithmetic::Slices => {
                    let (deltas, gradient) = (numbers(&space.deltas[index]), numbers_mut(&mut self.gradient));
                    let weight = &mut gradient[views.weight_at.clone()];
                    let columns = Matrix::new(deltas, outputs).transposed();
                    multiply(weight, before, columns, Matrix::new(numbers(input), inputs));
                    add_up_rows(deltas, before, &mut gradient[views.bias_at.clone()]);
                }
                Arithmetic::Tensors(_) => {
                    device::multiply(&views.weight_gradient, before, &space.deltas_transposed[index], input);
                    device::add_up_rows(&space.deltas[index], before, &views.bias_gradient);
                }
            }
            if index == 0 {
                continue;
            }
            let (before, rest) = space.deltas.split_at_mut(index);
            let (deltas, slopes) = (&rest[0], &mut before[index - 1]);
            match self.arithmetic {
                Arithmetic::Slices => {
                    let weight = Matrix::new(numbers(&views.weight), inputs);
                    let slopes = numbers_mut(slopes);
                    multiply(slopes, Before::Nothing, Matrix::new(numbers(deltas), outputs), weight);
                    self.activation.slope(numbers(&space.outputs[index - 1]), slopes);
                }
                Arithmetic::Tensors(_) => {
                    let _ = deltas.mm_out(slopes, &views.weight);
                    device::slope(self.activation, &space.outputs[index - 1], slopes);
                }
            }
        }
    }

    /// Euclidean norm of the gradient; no number where the gradient is none.
    pub fn gradient_norm(&self) -> f64 {
        match self.arithmetic {
            Arithmetic::Slices => adam::norm(numbers(&self.gradient)),
            Arithmetic::Tensors(_) => device::norm(&self.gradient),
        }
    }

    /// One step of Adam, for a gradient that counts as one of this norm: its own, or that of a longer one that it is
    /// part of.
    pub fn step(&mut self, norm: f64, rule: Rule) {
        let last = self.layers.last().map_or(0, |views| views.weight_at.start);
        let place = (norm, last);
        match &mut self.optimiser {
            Optimiser::Slices(adam) => {
                adam.step(numbers_mut(&mut self.parameters), numbers(&self.gradient), place, rule);
            }
            Optimiser::Tensors(moments) => moments.step(&self.parameters, &self.gradient, place, rule),
        }
    }
}

impl Optimiser {
    fn at(arithmetic: Arithmetic, adam: &Adam) -> Self {
        match arithmetic {
            Arithmetic::Slices => Self::Slices(adam.clone()),
            Arithmetic::Tensors(device) => Self::Tensors(Moments::new(adam, device)),
        }
    }
}

/// Writes the sum of all rows, or adds them to what stands there.
fn add_up_rows(rows: &[f32], before: Before, sums: &mut [f32]) {
    if before == Before::Nothing {
        sums.fill(0.0);
    }
    for row in rows.chunks_exact(sums.len()) {
        sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
    }
}

impl Workspaces {
    /// Buffers of this network for this number of rows.
    pub fn of(&mut self, trainee: &Trainee, rows: usize) -> &mut Workspace {
        let known = self.0.iter().position(|space| space.rows() == rows);
        let index = known.unwrap_or_else(|| {
            self.0.push(trainee.workspace(rows));
            self.0.len() - 1
        });
        &mut self.0[index]
    }
}

impl Workspace {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.inputs.size()[0] as usize
    }

    /// The network's outputs and, to be written, the slope of the loss with respect to them.
    pub fn slopes_mut(&mut self) -> (&[f32], &mut [f32]) {
        let slopes = self.deltas.last_mut().expect("a network has a layer");
        (numbers(self.outputs.last().expect("a network has a layer")), numbers_mut(slopes))
    }

    /// The same as tensors: what [`Workspace::slopes_mut`] gives where the processor cannot read the numbers.
    pub fn slope_tensors(&mut self) -> (&Tensor, &mut Tensor) {
        let slopes = self.deltas.last_mut().expect("a network has a layer");
        (self.outputs.last().expect("a network has a layer"), slopes)
    }
}

impl Activation {
    /// Multiplies slopes by the activation's derivative, known from its output.
    fn slope(self, outputs: &[f32], slopes: &mut [f32]) {
        let pairs = slopes.iter_mut().zip(outputs);
        match self {
            Self::Relu => pairs.for_each(|(slope, y)| *slope = if *y > 0.0 { *slope } else { 0.0 }),
            Self::Tanh => pairs.for_each(|(slope, y)| *slope *= 1.0 - y * y),
            Self::Elu => pairs.for_each(|(slope, y)| *slope *= if *y > 0.0 { 1.0 } else { y + 1.0 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::Scratch;
    use crate::stream::Stream;

    const WIDTHS: [usize; 4] = [5, 24, 17, 3];

    /// Writes numbers into a tensor, wherever it is.
    fn write(tensor: &mut Tensor, numbers: &[f32]) {
        let shape = tensor.size();
        tensor.copy_(&Tensor::from_slice(numbers).view(shape.as_slice()));
    }

    /// The numbers of a tensor, wherever it is.
    fn read(tensor: &Tensor) -> Vec<f32> {
        Vec::try_from(tensor.to_device(tch::Device::Cpu).flatten(0, -1)).unwrap()
    }

    fn normal(count: usize) -> Vec<f32> {
        let mut stream = Stream::new("test/gradient/inputs");
        (0..count).map(|_| stream.normal() as f32).collect()
    }

    /// The network's parameters with the last layer as large as the others, so that gradients are not tiny.
    fn network(activation: Activation) -> Network {
        let mut network = Network::orthogonal(&WIDTHS, activation, &mut Stream::new("test/gradient"));
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 100.0);
        network
            .layers
            .iter_mut()
            .for_each(|layer| layer.bias.iter_mut().enumerate().for_each(|(i, x)| *x = 0.01 * i as f32));
        network
    }

    /// Half the squared sum of the outputs, weighted by their place, in f64.
    fn loss(network: &Network, inputs: &[f32]) -> f64 {
        let forward = |mut row: Vec<f64>| {
            for (index, layer) in network.layers.iter().enumerate() {
                row = (0..layer.outputs)
                    .map(|o| {
                        let weights = &layer.weight[o * layer.inputs..(o + 1) * layer.inputs];
                        let sum = f64::from(layer.bias[o])
                            + weights.iter().zip(&row).map(|(w, x)| f64::from(*w) * x).sum::<f64>();
                        match network.activation {
                            _ if index == 2 => sum,
                            Activation::Relu => sum.max(0.0),
                            Activation::Tanh => libm::tanh(sum),
                            Activation::Elu => {
                                if sum > 0.0 {
                                    sum
                                } else {
                                    libm::expm1(sum)
                                }
                            }
                        }
                    })
                    .collect();
            }
            row
        };
        let rows = inputs.chunks_exact(WIDTHS[0]).map(|row| forward(row.iter().map(|x| f64::from(*x)).collect()));
        rows.flatten().enumerate().map(|(place, y)| 0.5 * (1.0 + place as f64) * y * y).sum()
    }

    #[test]
    fn gradients_equal_finite_differences() {
        use_one_thread();
        let activations = [Activation::Relu, Activation::Tanh, Activation::Elu];
        for (activation, arithmetic) in
            activations.into_iter().flat_map(|of| Arithmetic::here().into_iter().map(move |by| (of, by)))
        {
            let network = network(activation);
            let mut trainee = Trainee::on(arithmetic, &network);
            let (inputs, mut spaces) = (normal(4 * WIDTHS[0]), Workspaces::default());
            // Three rows, and to their gradient that of the fourth.
            for (rows, before) in [(0..3, Before::Nothing), (3..4, Before::Sum)] {
                let space = spaces.of(&trainee, rows.len());
                write(&mut space.inputs, &inputs[rows.start * WIDTHS[0]..rows.end * WIDTHS[0]]);
                trainee.forward(space);
                let (outputs, slopes) = space.slope_tensors();
                let slope = |(place, y): (usize, f32)| (1.0 + (rows.start * WIDTHS[3] + place) as f32) * y;
                write(slopes, &read(outputs).into_iter().enumerate().map(slope).collect::<Vec<_>>());
                trainee.backward(space, before);
            }
            let gradient = read(&trainee.gradient);
            for (layer, views) in trainee.layers.iter().enumerate() {
                for probe in 0..7 {
                    let place = probe * 31 % network.layers[layer].weight.len();
                    let bias = probe % network.layers[layer].bias.len();
                    let nudge = |amount: f32, in_bias: bool| {
                        let mut nudged = network.clone();
                        let layer = &mut nudged.layers[layer];
                        *(if in_bias { &mut layer.bias[bias] } else { &mut layer.weight[place] }) += amount;
                        loss(&nudged, &inputs)
                    };
                    for (in_bias, at) in [(false, views.weight_at.start + place), (true, views.bias_at.start + bias)] {
                        let expected = (nudge(2e-3, in_bias) - nudge(-2e-3, in_bias)) / 4e-3;
                        let error = (f64::from(gradient[at]) - expected).abs();
                        assert!(
                            error < 2e-3 * (1.0 + expected.abs()),
                            "{activation:?}, {arithmetic:?}, layer {layer}: {} is not {expected}",
                            gradient[at]
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn plain_inference_equals_libtorch() {
        use_one_thread();
        let policy = |activation| {
            let mut network =
                Network::orthogonal(&[30, 256, 256, 13], activation, &mut Stream::new("test/gradient/policy"));
            network.layers[2].weight.iter_mut().for_each(|x| *x *= 100.0);
            network
        };
        for activation in [Activation::Relu, Activation::Tanh, Activation::Elu] {
            for (network, arithmetic) in [network(activation), policy(activation)]
                .iter()
                .flat_map(|of| Arithmetic::here().into_iter().map(move |by| (of, by)))
            {
                let trainee = Trainee::on(arithmetic, network);
                let mut space = trainee.workspace(33);
                let inputs = normal(33 * network.inputs());
                write(&mut space.inputs, &inputs);
                trainee.forward(&mut space);
                let mut plain = vec![0.0; 33 * network.outputs()];
                network.forward(&inputs, &mut plain, &mut Scratch::default());
                let apart = |(a, b): (&f32, &f32)| (a - b).abs() / (1.0 + b.abs());
                let apart = plain.iter().zip(&read(space.slope_tensors().0)).map(apart).fold(0.0, f32::max);
                println!("{activation:?}, {arithmetic:?}, {:?}: {apart:.1e}", network.widths());
                assert!(apart < 1e-6, "{activation:?}, {arithmetic:?}, {:?}: {apart:.1e}", network.widths());
                assert_eq!(trainee.network(), *network);
            }
        }
    }

    #[test]
    fn only_whole_f32_tensors_of_the_processor_are_read_as_slices() {
        use_one_thread();
        let square = Tensor::zeros([2, 2], (Kind::Float, tch::Device::Cpu));
        assert_eq!(numbers(&square), [0.0; 4]);
        let elsewhere = tch::Cuda::is_available().then(|| square.to_device(tch::Device::Cuda(0)));
        for other in [square.narrow(1, 0, 1), square.to_kind(Kind::Double)].into_iter().chain(elsewhere) {
            let read = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| numbers(&other).len()));
            assert!(read.is_err(), "{other:?}");
        }
    }
}
