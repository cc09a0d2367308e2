//! The deployment kind `export`.

use crate::kinds::fine_tune::Trained;
use crate::spec::typed::prelude::*;

choice! {
    /// A format of exported policies.
    pub enum Format {
        /// safetensors, with the contract as JSON beside it.
        Safetensors = "safetensors",
    }
}

kind! {
    pub struct Export in "deploy" = "export" {
        /// Formats of the artefact.
        #[default("[\"safetensors\"]")]
        formats: Vec<Format>,
        /// Which policy: that of `[learn]` (`learner`) or that of `[fine_tune]`, each in the world that it was trained
        /// in. Without it the last one.
        policy: Option<Trained>,
    }
}
