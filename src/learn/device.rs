//! The learner on another device than the processor: what lies between the products, as libtorch's operations.
//!
//! The steps are those of [`super::gradient`] and [`super::adam`], number by number; only sums are taken in libtorch's
//! order, so the last bits differ. Nothing larger than a few numbers leaves the device inside an update.

use tch::{Cuda, Device, Kind, Tensor, utils};

use super::adam::{Adam, FIRST_DECAY, Factors, Rule, SECOND_DECAY};
use super::error::LearnError;
use super::multiply::Before;
use super::network::Activation;
use super::settings;

/// Rows whose activations and slopes in two hidden layers of 256 take 2 MB.
const STRETCH: usize = 512;

/// Where the networks are while they learn, and so who does the arithmetic between the products.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// Plain Rust on slices in the processor's memory.
    Slices,
    /// libtorch on the tensors of a device.
    Tensors(Device),
}

impl Arithmetic {
    /// That of a training's device. It fails where libtorch has no such device.
    pub fn of(device: settings::Device) -> Result<Self, LearnError> {
        match device {
            settings::Device::Cpu => Ok(Self::Slices),
            settings::Device::Cuda if Cuda::is_available() => Ok(Self::Tensors(Device::Cuda(0))),
            settings::Device::Cuda => Err(LearnError::Device { linked: utils::has_cudart() }),
        }
    }

    /// All that can be done here: the processor's, that of other devices done by the processor, and a CUDA device's
    /// where libtorch finds one. What holds of one holds of each.
    pub fn here() -> Vec<Self> {
        let device = Cuda::is_available().then_some(Device::Cuda(0));
        [Self::Slices, Self::Tensors(Device::Cpu)].into_iter().chain(device.map(Self::Tensors)).collect()
    }

    /// Rows of a minibatch that pass through a network together: on the processor as many as leave their activations in
    /// its cache.
    pub fn stretch(self, minibatch: usize) -> usize {
        match self {
            Self::Slices => minibatch.min(STRETCH),
            Self::Tensors(_) => minibatch,
        }
    }

    /// Where the tensors are.
    pub fn device(self) -> Device {
        match self {
            Self::Slices => Device::Cpu,
            Self::Tensors(device) => device,
        }
    }
}

/// Applies an activation in place.
pub fn activate(activation: Activation, outputs: &mut Tensor) {
    let _ = match activation {
        Activation::Relu => outputs.relu_(),
        Activation::Tanh => outputs.tanh_(),
        Activation::Elu => outputs.elu_(),
    };
}

/// Multiplies slopes by the activation's derivative, known from its output.
pub fn slope(activation: Activation, outputs: &Tensor, slopes: &mut Tensor) {
    let derivative = match activation {
        Activation::Relu => outputs.gt(0.0),
        Activation::Tanh => 1.0 - outputs.square(),
        // 1 where the output is positive, the output plus 1 elsewhere.
        Activation::Elu => outputs.clamp_max(0.0) + 1.0,
    };
    let _ = slopes.g_mul_(&derivative);
}

/// Writes a product of matrices, or adds it to what stands there.
pub fn multiply(target: &Tensor, before: Before, a: &Tensor, b: &Tensor) {
    let _ = match before {
        Before::Nothing => a.mm_out(target, b),
        Before::Sum => target.shallow_clone().addmm_(a, b),
    };
}

/// Writes the sum of all rows, or adds it to what stands there.
pub fn add_up_rows(rows: &Tensor, before: Before, sums: &Tensor) {
    let _ = match before {
        Before::Nothing => rows.sum_intlist_out(sums, 0i64, false, Kind::Float),
        Before::Sum => sums.shallow_clone().g_add_(&rows.sum_dim_intlist(0i64, false, Kind::Float)),
    };
}

/// Adam's state on a device.
pub struct Moments {
    first: Tensor,
    second: Tensor,
    steps: u64,
}

impl Moments {
    /// The same state on a device.
    pub fn new(adam: &Adam, device: Device) -> Self {
        let [first, second] = [&adam.first, &adam.second].map(|x| Tensor::from_slice(x).to_device(device));
        Self { first, second, steps: adam.steps }
    }

    /// The same state in the processor's memory.
    pub fn adam(&self) -> Adam {
        let [first, second] = [&self.first, &self.second].map(|tensor| {
            let mut numbers = vec![0.0; tensor.numel()];
            tensor.to_device(Device::Cpu).copy_data(&mut numbers, tensor.numel());
            numbers
        });
        Adam { first, second, steps: self.steps }
    }

    /// As [`Adam::step`].
    pub fn step(&mut self, parameters: &Tensor, gradient: &Tensor, (norm, last): (f64, usize), rule: Rule) {
        self.steps += 1;
        let Factors { shrink, rates, correction, epsilon } = Factors::new(norm, rule, self.steps);
        let slope = gradient * f64::from(shrink);
        let _ = self.first.g_mul_scalar_(FIRST_DECAY);
        let _ = self.first.g_add_(&(&slope * (1.0 - FIRST_DECAY)));
        let _ = self.second.g_mul_scalar_(SECOND_DECAY);
        let _ = self.second.g_add_(&(slope.square() * (1.0 - SECOND_DECAY)));
        let root = self.second.sqrt() / f64::from(correction) + f64::from(epsilon);
        let whole = parameters.numel();
        for (rate, range) in rates.into_iter().zip([0..last, last..whole]) {
            let part = |tensor: &Tensor| tensor.narrow(0, range.start as i64, range.len() as i64);
            let _ = part(parameters).g_sub_(&(part(&self.first) * f64::from(rate) / part(&root)));
        }
    }
}

/// Euclidean norm.
pub fn norm(gradient: &Tensor) -> f64 {
    gradient.square().sum(Kind::Double).double_value(&[]).sqrt()
}
