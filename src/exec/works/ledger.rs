//! The episodes of a running evaluation, kept in the scratch folder of its stage as they are measured, so that an evaluation
//! that was interrupted goes on where it stopped.
//!
//! A file of lines: a heading that says which build wrote it, then an episode each. What another build has written is not
//! taken up, and a last line that was cut off is measured again.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::bounded;
use crate::evaluate::follower::{Follower, Measured};
use crate::exec::work::{Job, WorkError};
use crate::outcome::{Episode, Trace};
use crate::safe_fs;

/// The file's name in the scratch folder.
const NAME: &str = "episodes.jsonl";

/// A line.
#[derive(Serialize, Deserialize)]
struct Line {
    index: usize,
    episode: Episode,
    trace: Option<Trace>,
}

/// The record of a stage's episodes, which also tells of its progress.
pub struct Ledger<'a> {
    job: &'a Job<'a>,
    total: usize,
    path: PathBuf,
    known: BTreeMap<usize, Measured>,
    file: Mutex<Result<File, io::Error>>,
}

impl<'a> Ledger<'a> {
    /// Opens the record of a stage with this many episodes.
    pub fn open(job: &'a Job, total: usize) -> Result<Self, WorkError> {
        let path = job.scratch.join(NAME);
        let known = bounded::text(&path, bounded::RECORD).map(|text| read(&text)).unwrap_or_default();
        let file = begin(&path, &known).map_err(|error| WorkError::io(&path, error))?;
        Ok(Self { job, total, path, known, file: Mutex::new(Ok(file)) })
    }

    /// Why the record could not be kept, if it could not.
    pub fn close(self) -> Result<(), WorkError> {
        let file = self.file.into_inner().unwrap_or_else(PoisonError::into_inner);
        file.map(drop).map_err(|error| WorkError::io(&self.path, error))
    }
}

impl Follower for Ledger<'_> {
    fn known(&self) -> BTreeMap<usize, Measured> {
        self.known.clone()
    }

    fn takes(&self, index: usize, measured: &Measured, done: usize) -> bool {
        self.job.progress(done as u64, self.total as u64, "episodes", "");
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = match file.as_mut() {
            Ok(file) => append(file, index, measured),
            Err(_) => return false,
        };
        if let Err(error) = written {
            *file = Err(error);
            return false;
        }
        !self.job.interrupt.is_set()
    }
}

/// Which build writes and reads.
fn heading() -> String {
    format!("specforge {} {}", env!("CARGO_PKG_VERSION"), env!("SPECFORGE_COMMIT"))
}

/// The episodes of a record, up to the first line that is none.
fn read(text: &str) -> BTreeMap<usize, Measured> {
    let mut lines = text.lines();
    if lines.next() != Some(&heading()) {
        return BTreeMap::new();
    }
    let lines = lines.map_while(|line| serde_json::from_str::<Line>(line).ok());
    lines.map(|line| (line.index, (line.episode, line.trace))).collect()
}

/// Writes the record anew with what is known, in place of the old one, and leaves it open.
fn begin(path: &Path, known: &BTreeMap<usize, Measured>) -> io::Result<File> {
    let draft = path.with_extension("new");
    let mut file = safe_fs::no_follow().write(true).create(true).truncate(true).open(&draft)?;
    writeln!(file, "{}", heading())?;
    known.iter().try_for_each(|(index, measured)| append(&mut file, *index, measured))?;
    file.sync_all()?;
    fs::rename(&draft, path)?;
    Ok(file)
}

/// Adds a line, in one piece.
fn append(file: &mut File, index: usize, (episode, trace): &Measured) -> io::Result<()> {
    let line = Line { index, episode: episode.clone(), trace: trace.clone() };
    let mut text = serde_json::to_string(&line)?;
    text.push('\n');
    file.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(number: usize) -> Measured {
        let speed = 0.1 + 1.0 / (3.0 + number as f64);
        let trace = (number == 0).then(|| Trace { time: vec![0.004, speed], ..Trace::default() });
        (Episode { stream: format!("1/{number}"), speed, ..Episode::default() }, trace)
    }

    #[test]
    fn what_was_recorded_is_read_back_to_the_last_bit_up_to_a_line_that_was_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        let mut file = begin(&path, &BTreeMap::new()).unwrap();
        for index in [2, 0, 5] {
            append(&mut file, index, &measured(index)).unwrap();
        }
        let text = fs::read_to_string(&path).unwrap();
        let expected = BTreeMap::from([2, 0, 5].map(|index| (index, measured(index))));
        assert_eq!(read(&text), expected);
        let cut = read(&text[..text.len() - 5]);
        assert_eq!(cut.keys().copied().collect::<Vec<_>>(), [0, 2]);
        drop(begin(&path, &cut).unwrap());
        assert_eq!(read(&fs::read_to_string(&path).unwrap()), cut);
    }

    #[test]
    fn the_record_of_another_build_is_not_taken_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        drop(begin(&path, &BTreeMap::from([(0, measured(0))])).unwrap());
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(read(&text).len(), 1);
        assert!(read(&text.replacen("specforge ", "specforge 9", 1)).is_empty());
        assert!(read("").is_empty());
    }
}
