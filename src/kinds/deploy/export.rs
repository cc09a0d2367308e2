//! The deployment kind `export`.

use crate::kinds::fine_tune::Trained;
use crate::spec::typed::prelude::*;

choice! {
    /// A format of exported policies.
    pub enum Format {
        /// safetensors, with the contract as JSON beside it; always written.
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
        /// Which policy: that of `[learn]` (`learner`) or that of `[fine_tune]`, each in the world that it
        /// was trained in. Without it the last one.
        policy: Option<Trained>,
    }
}
