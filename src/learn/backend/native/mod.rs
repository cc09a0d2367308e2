//! The native backend: plain Rust on the CPU, with `gemm` for the products. It is the default, and published
//! recipes reproduce bit for bit with it.

mod aligned;
mod loss;
mod matrix;
mod mlp;

pub use aligned::Aligned;
pub use loss::NativeLoss;
pub use matrix::check_processor;
pub use mlp::{NativeMlp, Snapshot, Workspace};

use super::Backend;
use crate::learn::lane::Records;
use crate::learn::network::Network;
use crate::learn::settings::Settings;

/// Plain Rust on the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Native;

impl Backend for Native {
    type Mlp = NativeMlp;
    type Loss<'a> = NativeLoss<'a>;

    fn mlp(self, network: &Network) -> NativeMlp {
        NativeMlp::new(network)
    }

    fn actor_loss<'a>(
        self,
        records: &'a [&'a Records],
        settings: &'a Settings,
        _width: usize,
    ) -> NativeLoss<'a> {
        NativeLoss::of_actor(records, settings)
    }

    fn critic_loss<'a>(
        self,
        records: &'a [&'a Records],
        settings: &'a Settings,
        _width: usize,
    ) -> NativeLoss<'a> {
        NativeLoss::of_critic(records, settings)
    }
}
