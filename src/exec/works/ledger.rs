//! The episodes of a running evaluation, saved in its stage's scratch folder as they are measured, so that an
//! interrupted evaluation continues where it stopped.
//!
//! The file has a header line with the build and the stage, then one line with a digest per episode. Files of
//! another build are ignored, and everything after a changed or incomplete line is measured again.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::bounded;
use crate::evaluate::follower::{Follower, LONG_EPISODE, Lasting, Measured};
use crate::exec::events::Event;
use crate::exec::lines;
use crate::exec::work::{Job, WorkError};
use crate::finite;
use crate::outcome::{Episode, Trace};
use crate::safe_fs;

/// The file's name in the scratch folder.
const NAME: &str = "episodes.jsonl";

/// One episode.
#[derive(Serialize, Deserialize)]
struct Line {
    index: usize,
    episode: Episode,
    trace: Option<Trace>,
}

/// The saved episodes of a stage; also reports its progress.
pub struct Ledger<'a> {
    job: &'a Job<'a>,
    total: usize,
    path: PathBuf,
    known: BTreeMap<usize, Measured>,
    file: Mutex<Result<Record, io::Error>>,
}

impl<'a> Ledger<'a> {
    /// Opens the file of a stage with this many episodes.
    pub fn open(job: &'a Job, total: usize) -> Result<Self, WorkError> {
        let path = job.scratch.join(NAME);
        let heading = heading(job.stage.fingerprint.as_str());
        let known =
            bounded::text(&path, bounded::RECORD).map(|text| read(&text, &heading)).unwrap_or_default();
        let file = begin(&path, &heading, &known).map_err(|error| WorkError::io(&path, error))?;
        Ok(Self { job, total, path, known, file: Mutex::new(Ok(file)) })
    }

    /// Closes the file; fails if episodes could not be saved.
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
            Ok(record) => record.append(index, measured),
            Err(_) => return false,
        };
        if let Err(error) = written {
            *file = Err(error);
            return false;
        }
        !self.job.interrupt.is_set()
    }

    fn is_interrupted(&self) -> bool {
        self.job.interrupt.is_set()
    }

    fn lasts(&self, index: usize, course: Lasting) {
        let (stage, help) = (Some(self.job.label.clone()), Some(LONG_EPISODE.to_owned()));
        self.job.events.emit(Event::Warning { stage, code: None, message: course.sentence(index), help });
    }
}

/// The header line: build and stage.
fn heading(key: &str) -> String {
    format!("specforge {} {} {key}", env!("CARGO_PKG_VERSION"), env!("SPECFORGE_COMMIT"))
}

/// The open file, and what the next line's digest covers.
struct Record {
    file: File,
    chain: String,
}

/// Reads the episodes up to the first invalid line.
fn read(text: &str, heading: &str) -> BTreeMap<usize, Measured> {
    let mut all = text.lines();
    if all.next() != Some(heading) {
        return BTreeMap::new();
    }
    let mut chain = lines::begin(heading.as_bytes());
    let lines = all.map_while(|line| {
        let (body, digest) = lines::open(&chain, line)?;
        chain = digest.to_owned();
        serde_json::from_str::<Line>(&body).ok()
    });
    lines.map(|line| (line.index, (line.episode, line.trace))).collect()
}

/// Replaces the file by one with the known episodes, and leaves it open.
fn begin(path: &Path, heading: &str, known: &BTreeMap<usize, Measured>) -> io::Result<Record> {
    let draft = path.with_extension("new");
    let file = safe_fs::no_follow().write(true).create(true).truncate(true).open(&draft)?;
    let mut record = Record { file, chain: lines::begin(heading.as_bytes()) };
    writeln!(record.file, "{heading}")?;
    known.iter().try_for_each(|(index, measured)| record.append(*index, measured))?;
    record.file.sync_all()?;
    fs::rename(&draft, path)?;
    Ok(record)
}

impl Record {
    /// Appends a line in one write. Episodes with non-finite numbers make the evaluation fail and are not
    /// saved.
    fn append(&mut self, index: usize, (episode, trace): &Measured) -> io::Result<()> {
        let line = Line { index, episode: episode.clone(), trace: trace.clone() };
        let Ok(body) = finite::to_string(&line) else { return Ok(()) };
        let (mut text, digest) = lines::seal(&self.chain, &body);
        text.push('\n');
        self.file.write_all(text.as_bytes())?;
        self.chain = digest;
        Ok(())
    }
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
        let heading = heading("key");
        let mut record = begin(&path, &heading, &BTreeMap::new()).unwrap();
        for index in [2, 0, 5] {
            record.append(index, &measured(index)).unwrap();
        }
        let text = fs::read_to_string(&path).unwrap();
        let expected = BTreeMap::from([2, 0, 5].map(|index| (index, measured(index))));
        assert_eq!(read(&text, &heading), expected);
        let cut = read(&text[..text.len() - 5], &heading);
        assert_eq!(cut.keys().copied().collect::<Vec<_>>(), [0, 2]);
        drop(begin(&path, &heading, &cut).unwrap());
        assert_eq!(read(&fs::read_to_string(&path).unwrap(), &heading), cut);
    }

    #[test]
    fn an_episode_that_was_changed_is_measured_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        let heading = heading("key");
        drop(
            begin(&path, &heading, &BTreeMap::from([0, 1, 2].map(|index| (index, measured(index))))).unwrap(),
        );
        let text = fs::read_to_string(&path).unwrap();
        let edited = text.replacen("\"survived\":false", "\"survived\":true", 2).replacen("true", "false", 1);
        assert_eq!(read(&text, &heading).len(), 3);
        assert_eq!(read(&edited, &heading).into_keys().collect::<Vec<_>>(), [0]);
        assert!(read(&text, &super::heading("another stage")).is_empty());
    }

    #[test]
    fn the_record_of_another_build_is_not_taken_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        let heading = heading("key");
        drop(begin(&path, &heading, &BTreeMap::from([(0, measured(0))])).unwrap());
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(read(&text, &heading).len(), 1);
        assert!(read(&text.replacen("specforge ", "specforge 9", 1), &heading).is_empty());
        assert!(read("", &heading).is_empty());
    }
}
