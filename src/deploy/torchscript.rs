//! The export format `torchscript`: the actor as `policy.pt`, for programs that run policies with libtorch.
//! Needs a build with the feature `torch`. The contract is a separate file, because a TorchScript module
//! cannot hold it.

use std::path::Path;

use crate::learn::Network;

/// Name of the format in a spec.
pub const FORMAT: &str = "torchscript";
/// Name of the file.
pub const FILE: &str = "policy.pt";
/// Whether this build can write it.
pub const AVAILABLE: bool = cfg!(feature = "torch");

/// Writes the actor. The error is libtorch's, or says that this build lacks libtorch.
pub fn save(actor: &Network, path: &Path) -> Result<(), String> {
    #[cfg(feature = "torch")]
    return crate::learn::backend::torch::script::save(actor, path).map_err(|error| error.to_string());
    #[cfg(not(feature = "torch"))]
    {
        let _ = (actor, path);
        Err("this specforge was built without libtorch".to_owned())
    }
}
