//! The deployment kind `export`.

use crate::kinds::fine_tune::Trained;
use crate::spec::typed::prelude::*;

choice! {
    /// A format of exported policies.
    pub enum Format {
        /// safetensors, with the contract as a separate JSON file; always written.
        Safetensors = "safetensors",
        /// A TorchScript module of the actor.
        Torchscript = "torchscript",
    }
}

kind! {
    pub struct Export in "deploy" = "export" {
        /// Formats of the artefact. `safetensors` is always written; `torchscript` needs a build with the
        /// feature `torch` (R0005).
        #[default("[\"safetensors\"]")]
        formats: Vec<Format>,
        /// The policy: that of `[learn]` (`learner`) or of `[fine_tune]` (default if the spec has one), each
        /// in its training environment.
        policy: Option<Trained>,
    }
}
