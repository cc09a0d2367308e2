//! Adam on a device.

use tch::{Device, Kind, Tensor};

use crate::learn::adam::{Adam, FIRST_DECAY, Factors, Rule, SECOND_DECAY};

/// Adam's state on a device.
pub struct TorchAdam {
    first: Tensor,
    second: Tensor,
    steps: u64,
}

impl TorchAdam {
    /// The same state on a device.
    pub fn new(adam: &Adam, device: Device) -> Self {
        let [first, second] = [&adam.first, &adam.second].map(|x| Tensor::from_slice(x).to_device(device));
        Self { first, second, steps: adam.steps }
    }

    /// The same state in plain numbers.
    pub fn adam(&self) -> Adam {
        let [first, second] = [&self.first, &self.second].map(numbers);
        Adam { first, second, steps: self.steps }
    }

    /// As [`Adam::step`].
    pub fn step(&mut self, parameters: &Tensor, gradient: &Tensor, norm: f64, last: usize, rule: Rule) {
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

/// The f32 numbers of a tensor, wherever it is.
pub fn numbers(tensor: &Tensor) -> Vec<f32> {
    let mut numbers = vec![0.0; tensor.numel()];
    tensor.to_device(Device::Cpu).to_kind(Kind::Float).contiguous().copy_data(&mut numbers, tensor.numel());
    numbers
}
