//! Broken episodes on the disk: the name of an episode's random stream and all its actions, from which the
//! same environment plays it again bit for bit.

use std::path::{Path, PathBuf};

use super::beside::{exploded_file, exploded_in};
use super::checkpoint::replace;
use super::error::LearnError;
use super::lane::Episode;

/// How many exploded episodes of a training are kept; all are counted.
const KEPT: usize = 10;

/// An episode as it is written.
pub struct Broken<'a> {
    /// Name of its random stream.
    pub stream: String,
    /// The episode with its actions, the last of which broke it.
    pub episode: &'a Episode,
    /// Length of an action.
    pub width: usize,
    /// Names and values of the reward terms in the last step, where there were any.
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
            // As text, because JSON has no word for what is not a number.
            let values = values.iter().map(|value| value.to_string().into());
            let values: serde_json::Map<_, _> = names.iter().cloned().zip(values).collect();
            document["term_values"] = values.into();
        }
        replace(path, document.to_string().as_bytes())
    }

    /// Keeps it among the first exploded episodes of a training and gives the file, or `None` when there are
    /// enough. An episode that comes again after a resumption replaces itself.
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

/// The exploded episodes that were kept in a folder, sorted by name.
pub fn kept(folder: &Path) -> Result<Vec<PathBuf>, LearnError> {
    exploded_in(folder).map_err(LearnError::at(folder))
}
