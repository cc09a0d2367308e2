//! A network under training as libtorch tensors: hand-written forward and backward passes, without autograd.

use tch::{Device, Kind, Tensor};

use super::adam::{TorchAdam, numbers};
use crate::learn::adam::{Adam, Rule};
use crate::learn::backend::layout::Layout;
use crate::learn::backend::{Beta, TrainableMlp};
use crate::learn::network::{Activation, Network};

/// A network with its gradient and Adam's moments, all flat, on a device.
pub struct TorchMlp {
    device: Device,
    layout: Layout,
    parameters: Tensor,
    pub(in crate::learn::backend) gradient: Tensor,
    layers: Vec<Views>,
    adam: TorchAdam,
}

/// One layer's views into the flat tensors.
struct Views {
    weight: Tensor,
    weight_transposed: Tensor,
    bias: Tensor,
    weight_gradient: Tensor,
    bias_gradient: Tensor,
}

/// Activations and their gradients for one number of rows.
pub struct Workspace {
    /// The network's inputs, `rows` x inputs.
    pub inputs: Tensor,
    /// The outputs of each layer, `rows` x outputs.
    outputs: Vec<Tensor>,
    /// Derivatives of the loss with respect to each layer's sums before the activation, `rows` x outputs.
    deltas: Vec<Tensor>,
    deltas_transposed: Vec<Tensor>,
}

/// Snapshot of a network's parameters and moments.
pub struct Snapshot {
    parameters: Tensor,
    adam: Adam,
}

impl TorchMlp {
    /// A copy of a network with fresh moments.
    pub fn new(device: Device, network: &Network) -> Self {
        let layout = Layout::new(network);
        let mut flat = vec![0.0; layout.len];
        layout.write(network, &mut flat);
        let parameters = Tensor::from_slice(&flat).to_device(device);
        let gradient = parameters.zeros_like();
        let narrow =
            |tensor: &Tensor, at: &std::ops::Range<usize>| tensor.narrow(0, at.start as i64, at.len() as i64);
        let views = |place: &crate::learn::backend::layout::Place| {
            let shape = [place.outputs as i64, place.inputs as i64];
            let weight = narrow(&parameters, &place.weight).view(shape);
            Views {
                weight_transposed: weight.tr(),
                weight,
                bias: narrow(&parameters, &place.bias),
                weight_gradient: narrow(&gradient, &place.weight).view(shape),
                bias_gradient: narrow(&gradient, &place.bias),
            }
        };
        let layers = layout.layers.iter().map(views).collect();
        let adam = TorchAdam::new(&Adam::new(layout.len), device);
        Self { device, layers, parameters, gradient, adam, layout }
    }
}

impl TrainableMlp for TorchMlp {
    type Workspace = Workspace;
    type Snapshot = Snapshot;

    /// Stops libtorch from starting its own threads: on matrices this small a second thread makes it ten
    /// times slower whenever a core is shared.
    fn prepare_thread() {
        tch::set_num_threads(1);
    }

    fn inputs(&self) -> usize {
        self.layout.inputs()
    }

    fn block_rows(&self, minibatch: usize) -> usize {
        minibatch
    }

    fn workspace(&self, rows: usize) -> Workspace {
        let zeros = |width: usize| Tensor::zeros([rows as i64, width as i64], (Kind::Float, self.device));
        let buffers =
            || -> Vec<Tensor> { self.layout.layers.iter().map(|place| zeros(place.outputs)).collect() };
        let deltas = buffers();
        Workspace {
            inputs: zeros(self.inputs()),
            outputs: buffers(),
            deltas_transposed: deltas.iter().map(Tensor::tr).collect(),
            deltas,
        }
    }

    fn forward(&self, space: &mut Workspace) {
        let last = self.layers.len() - 1;
        for (index, views) in self.layers.iter().enumerate() {
            let (done, rest) = space.outputs.split_at_mut(index);
            let input = done.last().unwrap_or(&space.inputs);
            let output = &mut rest[0];
            let _ = views.bias.addmm_out(output, input, &views.weight_transposed);
            if index < last {
                activate(self.layout.activation, output);
            }
        }
    }

    fn backward(&mut self, space: &mut Workspace, beta: Beta) {
        for (index, views) in self.layers.iter().enumerate().rev() {
            let input = if index == 0 { &space.inputs } else { &space.outputs[index - 1] };
            multiply(&views.weight_gradient, beta, &space.deltas_transposed[index], input);
            sum_rows(&space.deltas[index], beta, &views.bias_gradient);
            if index == 0 {
                continue;
            }
            let (below, rest) = space.deltas.split_at_mut(index);
            let slopes = &mut below[index - 1];
            let _ = rest[0].mm_out(slopes, &views.weight);
            multiply_by_derivative(self.layout.activation, &space.outputs[index - 1], slopes);
        }
    }

    fn gradient_norm(&self) -> f64 {
        self.gradient.square().sum(Kind::Double).double_value(&[]).sqrt()
    }

    fn step(&mut self, norm: f64, rule: Rule) {
        self.adam.step(&self.parameters, &self.gradient, norm, self.layout.last_layer(), rule);
    }

    fn network(&self) -> Network {
        self.layout.network(&numbers(&self.parameters))
    }

    fn adam(&self) -> Adam {
        self.adam.adam()
    }

    fn set_adam(&mut self, adam: &Adam) -> bool {
        let fits = adam.fits(self.layout.len);
        if fits {
            self.adam = TorchAdam::new(adam, self.device);
        }
        fits
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot { parameters: self.parameters.copy(), adam: self.adam() }
    }

    fn restore(&mut self, snapshot: &Snapshot) {
        self.parameters.copy_(&snapshot.parameters);
        self.adam = TorchAdam::new(&snapshot.adam, self.device);
    }
}

impl Workspace {
    /// The network's outputs, and the derivatives of the loss with respect to them, to be written.
    pub fn slopes_mut(&mut self) -> (&Tensor, &mut Tensor) {
        let slopes = self.deltas.last_mut().expect("a network has a layer");
        (self.outputs.last().expect("a network has a layer"), slopes)
    }
}

/// Applies an activation in place.
fn activate(activation: Activation, outputs: &mut Tensor) {
    let _ = match activation {
        Activation::Relu => outputs.relu_(),
        Activation::Tanh => outputs.tanh_(),
        Activation::Elu => outputs.elu_(),
    };
}

/// Multiplies slopes by the activation's derivative, known from its output.
fn multiply_by_derivative(activation: Activation, outputs: &Tensor, slopes: &mut Tensor) {
    let derivative = match activation {
        Activation::Relu => outputs.gt(0.0),
        Activation::Tanh => 1.0 - outputs.square(),
        // 1 where the output is positive, the output plus 1 elsewhere.
        Activation::Elu => outputs.clamp_max(0.0) + 1.0,
    };
    let _ = slopes.g_mul_(&derivative);
}

/// `target = a b + beta target`
fn multiply(target: &Tensor, beta: Beta, a: &Tensor, b: &Tensor) {
    let _ = match beta {
        Beta::Zero => a.mm_out(target, b),
        Beta::One => target.shallow_clone().addmm_(a, b),
    };
}

/// `sums = column sums of the rows + beta sums`
fn sum_rows(rows: &Tensor, beta: Beta, sums: &Tensor) {
    let _ = match beta {
        Beta::Zero => rows.sum_intlist_out(sums, 0i64, false, Kind::Float),
        Beta::One => sums.shallow_clone().g_add_(&rows.sum_dim_intlist(0i64, false, Kind::Float)),
    };
}
