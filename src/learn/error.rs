//! What can go wrong in a training, with the run-time code that the user sees.

use std::io;
use std::path::{Path, PathBuf};

use crate::finite::NotFinite;

/// Reasons why a training ended without a policy.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// A reward became NaN or infinite.
    #[error(
        "the reward of environment {environment} is not a number in step {step} of episode {episode}; \
         the episode's actions are in {dump}"
    )]
    Reward {
        /// Index of the environment.
        environment: usize,
        /// Number of its episode.
        episode: u64,
        /// Control step in the episode.
        step: u64,
        /// File with the name of the random stream and the actions.
        dump: PathBuf,
    },
    /// The simulation diverged (NaN or infinity) in every episode of an update.
    #[error(
        "the simulation diverged in all {episodes} episodes that ended in update {update}; \
         one of them is in {dump}"
    )]
    Exploded {
        /// Index of the update.
        update: u64,
        /// How many episodes there were.
        episodes: u64,
        /// File with the name of the random stream and the actions.
        dump: PathBuf,
    },
    /// A gradient became NaN or infinite.
    #[error("a gradient is not a number in update {update}: the learning rate or the rewards are too large")]
    Gradient {
        /// Index of the update.
        update: u64,
    },
    /// A gradient became NaN or infinite in a pre-training.
    #[error(
        "a gradient is not a number in step {step} of the pre-training: the samples, their labels or \
         `pretrain.learning_rate` are too large"
    )]
    Lesson {
        /// Index of the step.
        step: u64,
    },
    /// A number of an update, or a weight after it, became NaN or infinite.
    #[error(
        "the training diverged in update {update}: {what}: the learning rate or the rewards are too large"
    )]
    Diverged {
        /// Index of the update.
        update: u64,
        /// Which number, and its value.
        what: String,
    },
    /// A result of a pre-training became NaN or infinite.
    #[error(
        "the pre-training diverged: {what}: the samples, their labels or `pretrain.learning_rate` are too \
         large"
    )]
    Unfit {
        /// Which number, and its value.
        what: String,
    },
    /// A number in an output file would be NaN or infinite.
    #[error("{file}: {found}")]
    NotFinite {
        /// The file that was not written.
        file: String,
        /// The number and its place.
        found: NotFinite,
    },
    /// The spec requires libtorch, and this build has none.
    #[error("`learn.backend` is \"torch\", and this specforge was built without libtorch")]
    Backend,
    /// The spec requires CUDA, and libtorch lacks it or finds no such device.
    #[error(
        "`learn.device` is \"cuda\", and {}",
        if *linked { "libtorch finds no CUDA device here" } else { "this libtorch has no CUDA" }
    )]
    Device {
        /// Whether this libtorch supports CUDA.
        linked: bool,
    },
    /// The processor lacks the instructions that give a training its reproducible bits.
    #[error(
        "this processor has no AVX2 and FMA instructions, without which trainings would have other numbers"
    )]
    Processor,
    /// The checkpoint does not belong to this training or is damaged.
    #[error("the checkpoint {path} does not fit this training: {reason}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// The pre-trained actor or the environments do not fit the settings.
    #[error("{0}")]
    Shape(String),
    /// A file could not be read or written. The last checkpoint remains.
    #[error("{path}: {error}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
    /// The training was interrupted and can be resumed.
    #[error("interrupted; the next run resumes from the checkpoint")]
    Interrupted,
}

impl LearnError {
    /// The run-time code for `specforge explain`, if the error has one.
    pub fn code(&self) -> Option<&'static str> {
        match self {
            Self::Reward { .. }
            | Self::Exploded { .. }
            | Self::Gradient { .. }
            | Self::Lesson { .. }
            | Self::Diverged { .. }
            | Self::Unfit { .. } => Some("R0001"),
            Self::NotFinite { .. } => Some("R0007"),
            Self::Checkpoint { .. } | Self::Shape(_) => Some("R0002"),
            Self::Backend => Some("R0005"),
            Self::Device { .. } | Self::Processor => Some("R0006"),
            Self::File { error, .. } if is_full(error.kind()) => Some("R0004"),
            Self::File { .. } | Self::Interrupted => None,
        }
    }

    /// How to fix it, if there is general advice.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Backend => Some(
                "build with `make build FEATURES=torch`, or leave `backend` out; `specforge explain R0005` \
                 says more"
                    .into(),
            ),
            Self::Device { linked } => Some(format!(
                "{}, or leave `device` out; `specforge explain R0006` says more",
                if *linked {
                    "run on a machine with such a device, whose driver is recent enough for libtorch \
                     (`nvidia-smi` shows both)"
                } else {
                    "build with LIBTORCH set to a libtorch for CUDA"
                }
            )),
            Self::Processor => Some(
                "run on a processor of 2013 or later (x86-64-v3), or on an ARM \
                processor"
                    .into(),
            ),
            Self::Checkpoint { path, .. } => Some(format!(
                "delete {} to train from the beginning, or continue with the version that wrote it; \
                 `specforge explain R0002` says more",
                path.display()
            )),
            _ => self.code().map(|code| format!("see `specforge explain {code}`")),
        }
    }

    /// The error for a file that would contain such a number.
    pub(super) fn not_finite(file: &str, found: NotFinite) -> Self {
        Self::NotFinite { file: file.to_owned(), found }
    }

    /// For `map_err` of an operation on a file.
    pub(super) fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::File { path, error }
    }
}

/// Whether a write failed for lack of space: on the disk, in a quota or under `ulimit -f`.
fn is_full(kind: io::ErrorKind) -> bool {
    matches!(kind, io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_device_has_a_code_and_a_cure() {
        for (linked, cure) in [(false, "LIBTORCH"), (true, "driver")] {
            let error = LearnError::Device { linked };
            assert_eq!(error.code(), Some("R0006"));
            let help = error.help().unwrap_or_default();
            assert!(help.contains(cure) && help.contains("`specforge explain R0006`"), "{help}");
        }
    }
}
