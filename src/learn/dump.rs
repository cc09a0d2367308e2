//! Broken episodes on disk: the name of an episode's random stream and all its actions, with which the same
//! environment replays it bit for bit.

use std::path::{Path, PathBuf};

use super::beside::{exploded_file, exploded_in};
use super::checkpoint::replace;
use super::error::LearnError;
use super::lane::Episode;

/// Number of exploded episodes of a training that are stored; all are counted.
const KEPT: usize = 10;

/// A broken episode to be stored.
pub struct Broken<'a> {
    /// Name of its random stream.
    pub stream: String,
    /// The episode with its actions, the last of which broke it.
    pub episode: &'a Episode,
    /// Length of an action.
    pub width: usize,
    /// Names and values of the reward terms in the last step, if any.
    pub terms: Option<(&'a [String], &'a [f64])>,
}

impl Broken<'_> {
    /// Writes it to this file.
    pub fn write(&self, path: &Path) -> Result<(), LearnError> {
        let actions: Vec<&[f32]> = self.episode.actions.chunks_exact(self.width).collect();
        let mut document = serde_json::json!({
            "stream": self.stream,
            "step": self.episode.steps,
            "actions": actions,
        });
        if let Some((names, values)) = self.terms {
            // As text, because JSON cannot represent NaN or infinity.
            let values = values.iter().map(|value| value.to_string().into());
            let values: serde_json::Map<_, _> = names.iter().cloned().zip(values).collect();
            document["term_values"] = values.into();
        }
        replace(path, document.to_string().as_bytes())
    }

    /// Stores the episode if it is among the first exploded ones of a training and returns its file, or
    /// `None` if enough are stored. After a resumption the same episode replaces its own file.
    pub fn keep(&self, folder: &Path, environment: usize) -> Result<Option<PathBuf>, LearnError> {
        let path = folder.join(exploded_file(environment, self.episode.number));
        let known = kept(folder)?;
        if known.len() >= KEPT && !known.contains(&path) {
            return Ok(None);
        }
        self.write(&path)?;
        Ok(Some(path))
    }
}

/// The exploded episodes in a folder, sorted by name.
pub fn kept(folder: &Path) -> Result<Vec<PathBuf>, LearnError> {
    exploded_in(folder).map_err(LearnError::at(folder))
}
