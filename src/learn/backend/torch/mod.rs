//! The torch backend: libtorch's operations without autograd, on the CPU or a CUDA device.
//!
//! The steps are those of the native backend; only the order of summation is libtorch's, so the last bits
//! differ. Within an update only a few numbers leave the device.

mod adam;
mod loss;
mod mlp;
pub mod script;

#[cfg(test)]
pub(super) use adam::numbers;
pub use loss::TorchLoss;
pub use mlp::TorchMlp;
use tch::{Cuda, utils};

use super::Backend;
use crate::learn::error::LearnError;
use crate::learn::lane::Records;
use crate::learn::network::Network;
use crate::learn::settings::{Device, Settings};

/// libtorch on one of its devices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torch(tch::Device);

impl Torch {
    /// libtorch on the CPU.
    pub const CPU: Self = Self(tch::Device::Cpu);

    /// libtorch on this device. Fails if this libtorch does not support the device or the machine lacks it.
    pub fn on(device: Device) -> Result<Self, LearnError> {
        match device {
            Device::Cpu => Ok(Self::CPU),
            Device::Cuda if Cuda::is_available() => Ok(Self(tch::Device::Cuda(0))),
            Device::Cuda => Err(LearnError::Device { linked: utils::has_cudart() }),
        }
    }

    /// Every device that libtorch finds here: the CPU, and a CUDA device if there is one.
    pub fn available() -> Vec<Self> {
        [Self::CPU].into_iter().chain(Self::on(Device::Cuda)).collect()
    }
}

impl Backend for Torch {
    type Mlp = TorchMlp;
    type Loss<'a> = TorchLoss;

    fn mlp(self, network: &Network) -> TorchMlp {
        TorchMlp::new(self.0, network)
    }

    fn actor_loss(self, records: &[&Records], settings: &Settings, width: usize) -> TorchLoss {
        TorchLoss::of_actor(self.0, records, settings, width)
    }

    fn critic_loss(self, records: &[&Records], settings: &Settings, width: usize) -> TorchLoss {
        TorchLoss::of_critic(self.0, records, settings, width)
    }
}
