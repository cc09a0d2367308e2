//! `metrics.jsonl`: one line per update, cut back to the checkpoint when a training is resumed.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::checkpoint::Checkpoint;
use super::error::LearnError;
use super::metrics::UpdateMetrics;
use crate::bounded;
use crate::safe_fs;

/// The open file.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Lines in the file.
    pub lines: u64,
}

impl Journal {
    /// Opens the file and truncates it to its first `lines` lines. Fails if there are fewer.
    pub fn open(path: PathBuf, lines: u64) -> Result<Self, LearnError> {
        let text = match bounded::text(&path, bounded::RECORD) {
            Ok(text) => text,
            Err(error) if error.is_absence() => String::new(),
            Err(error) => return Err(LearnError::at(&path)(error.into())),
        };
        let kept: usize = text.split_inclusive('\n').take(lines as usize).map(str::len).sum();
        let whole = text[..kept].matches('\n').count() as u64;
        if whole < lines {
            let reason = format!("it follows {lines} lines of metrics, and {} has {whole}", path.display());
            let folder = path.parent().unwrap_or(Path::new("."));
            return Err(LearnError::Checkpoint { path: Checkpoint::path(folder), reason });
        }
        let file =
            safe_fs::no_follow().create(true).append(true).open(&path).map_err(LearnError::at(&path))?;
        file.set_len(kept as u64).map_err(LearnError::at(&path))?;
        Ok(Self { path, file, lines })
    }

    /// Adds a line.
    pub fn add(&mut self, metrics: &UpdateMetrics) -> Result<(), LearnError> {
        self.lines += 1;
        self.file.write_all(metrics.line().as_bytes()).map_err(LearnError::at(&self.path))
    }

    /// Makes sure that all lines are on the disk.
    pub fn sync(&self) -> Result<(), LearnError> {
        self.file.sync_data().map_err(LearnError::at(&self.path))
    }

    /// All lines of the file.
    pub fn all(&self) -> Result<Vec<UpdateMetrics>, LearnError> {
        let text = bounded::text(&self.path, bounded::RECORD)
            .map_err(|error| LearnError::at(&self.path)(error.into()))?;
        let read = |line| serde_json::from_str(line).map_err(std::io::Error::from);
        text.lines().map(read).collect::<Result<_, _>>().map_err(LearnError::at(&self.path))
    }

    /// The last line that satisfies a condition.
    pub fn last(path: &Path, condition: impl Fn(&UpdateMetrics) -> bool) -> Option<UpdateMetrics> {
        let text = bounded::text(path, bounded::RECORD).ok()?;
        text.lines().rev().filter_map(|line| serde_json::from_str(line).ok()).find(condition)
    }
}
