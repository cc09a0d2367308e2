//! The journal's file: lines with chained digests, and a seal that records how far it was written. Together
//! they reveal whether anything was edited, removed or cut off.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::fault::StoreError;
use super::lines;
use super::lock::{self, Wait};
use crate::{bounded, safe_fs};

/// The journal.
const JOURNAL: &str = "journal.jsonl";
/// Its seal.
const SEAL: &str = "journal.seal";

/// Whether a journal is complete and unchanged.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Health {
    /// It is.
    Whole,
    /// Both the journal and its seal are missing, as in a store without artefacts.
    #[default]
    Absent,
    /// It is not, for this reason.
    Damaged(String),
}

/// What a journal holds.
#[derive(Debug, Default)]
pub struct Contents {
    /// The lines without their digests, whether or not the digests match.
    pub lines: Vec<String>,
    /// Whether the journal is complete.
    pub health: Health,
    /// Length of the complete lines in bytes.
    end: usize,
    /// What the next line's digest covers.
    chain: String,
}

/// How far the journal was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Seal {
    /// Length in bytes.
    bytes: usize,
    /// The digest of the last line, or the start of the chain in an empty journal.
    check: String,
}

/// The files of a journal.
#[derive(Clone, Debug, Default)]
pub struct LineFile {
    root: PathBuf,
}

impl LineFile {
    /// The files of the store in this folder.
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    fn path(&self) -> PathBuf {
        self.root.join(JOURNAL)
    }

    /// Seals the journal of a store that has no artefacts yet.
    pub fn begin(&self) -> Result<(), StoreError> {
        let path = self.root.join(SEAL);
        let seal = Seal { bytes: 0, check: lines::begin(b"") };
        let text = serde_json::to_string(&seal).expect("a seal is plain data");
        match safe_fs::create(&path, text.as_bytes()) {
            // Another process is creating the same store.
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
            written => written.map_err(|error| StoreError::writing(&path, error)),
        }
    }

    /// Reads everything in it.
    pub fn read(&self) -> Result<Contents, StoreError> {
        let path = self.path();
        for own in [&path, &self.root.join(SEAL)] {
            safe_fs::refuse_link(own).map_err(|error| StoreError::writing(own, error))?;
        }
        let bytes = match bounded::bytes(&path, bounded::RECORD) {
            Err(error) if error.is_absence() => None,
            bytes => Some(bytes.map_err(|error| StoreError::reading(&path, error.into()))?),
        };
        let seal = match bounded::text(&self.root.join(SEAL), bounded::WRITTEN) {
            Err(error) if error.is_absence() => None,
            text => Some(text.ok().and_then(|text| serde_json::from_str::<Seal>(&text).ok())),
        };
        if bytes.is_none() && seal.is_none() {
            return Ok(Contents { chain: lines::begin(b""), ..Contents::default() });
        }
        Ok(contents(&bytes.unwrap_or_default(), seal))
    }

    /// Appends lines in one write, overwriting a last line that a crash left incomplete. The seal of a
    /// damaged journal is not updated, so that the damage stays visible.
    pub fn append(&self, news: &[String], wait: &Wait) -> Result<(), StoreError> {
        let (path, locks) = (self.path(), self.root.join("locks"));
        let fault = |error| StoreError::writing(&path, error);
        fs::create_dir_all(&locks).map_err(|error| StoreError::writing(&locks, error))?;
        let _lock = lock::exclusive(&locks.join("journal"), wait)?;
        let Contents { health, end, mut chain, .. } = self.read()?;
        let mut text = String::new();
        for body in news {
            let (line, digest) = lines::seal(&chain, body);
            text += &line;
            text.push('\n');
            chain = digest;
        }
        let mut file = safe_fs::no_follow().create(true).append(true).open(&path).map_err(fault)?;
        let is_torn = file.metadata().map_err(fault)?.len() > end as u64;
        if is_torn {
            file.set_len(end as u64).map_err(fault)?;
        }
        file.write_all(text.as_bytes()).and_then(|()| file.sync_data()).map_err(fault)?;
        let may_seal = health == Health::Whole || health == torn();
        if may_seal { self.seal(end + text.len(), chain) } else { Ok(()) }
    }

    fn seal(&self, bytes: usize, check: String) -> Result<(), StoreError> {
        let (path, draft) = (self.root.join(SEAL), self.root.join("locks").join(SEAL));
        let text = serde_json::to_string(&Seal { bytes, check }).expect("a seal is plain data");
        let written = safe_fs::replace_through(&draft, &path, text.as_bytes());
        written.map_err(|error| StoreError::writing(&path, error))
    }

    /// Moves the journal aside and writes these lines in its place.
    pub fn replace(&self, aside: &Path, bodies: &[String], wait: &Wait) -> Result<(), StoreError> {
        let path = self.path();
        let fault = |error| StoreError::writing(&path, error);
        if path.exists() {
            fs::rename(&path, aside).map_err(fault)?;
        }
        let seal = self.root.join(SEAL);
        if seal.exists() {
            fs::remove_file(&seal).map_err(|error| StoreError::writing(&seal, error))?;
        }
        self.begin()?;
        self.append(bodies, wait)
    }
}

fn torn() -> Health {
    Health::Damaged("its last line is cut off".into())
}

/// Parses a journal. `seal` is `None` if missing, `Some(None)` if unreadable.
fn contents(bytes: &[u8], seal: Option<Option<Seal>>) -> Contents {
    let mut found = Contents { chain: lines::begin(b""), ..Contents::default() };
    let mut damage = None;
    let mut sealed = seal.as_ref().is_some_and(|seal| seal.as_ref().is_some_and(|seal| found.is_at(seal)));
    for (index, line) in bytes.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let mut wrong = |reason: &str| {
            damage.get_or_insert_with(|| format!("line {} {reason}", index + 1));
        };
        let Some(text) = line.strip_suffix(b"\n") else { break };
        let Ok(text) = std::str::from_utf8(text) else {
            wrong("is not text");
            found.end += line.len();
            continue;
        };
        match lines::split(text) {
            Some((body, digest)) => {
                if lines::open(&found.chain, text).is_none() {
                    wrong("does not fit its digest and the lines before it");
                }
                found.chain = digest.to_owned();
                found.lines.push(body);
            }
            None => wrong("has no digest"),
        }
        found.end += line.len();
        sealed |= matches!(&seal, Some(Some(seal)) if found.is_at(seal));
    }
    let is_torn = found.end < bytes.len();
    found.health = match (damage, &seal) {
        (Some(reason), _) => Health::Damaged(reason),
        (None, Some(None)) => Health::Damaged(format!("`{SEAL}` cannot be read")),
        (None, None) if bytes.is_empty() => Health::Damaged("it is empty".into()),
        (None, None) => Health::Damaged(format!("`{SEAL}` is missing")),
        (None, Some(Some(_))) if !sealed => {
            Health::Damaged("it is not as long as it was, or begins otherwise".into())
        }
        _ if is_torn => torn(),
        _ => Health::Whole,
    };
    found
}

impl Contents {
    fn is_at(&self, seal: &Seal) -> bool {
        self.end == seal.bytes && self.chain == seal.check
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODIES: [&str; 3] = [r#"{"n":1}"#, r#"{"n":2}"#, r#"{"n":3}"#];

    fn file(folder: &Path) -> LineFile {
        let file = LineFile::new(folder);
        file.begin().expect("it can be written");
        BODIES.iter().for_each(|body| {
            file.append(&[(*body).to_owned()], &Wait::default()).expect("it can be written")
        });
        file
    }

    fn read(file: &LineFile) -> (Vec<String>, Health) {
        let Contents { lines, health, .. } = file.read().expect("it can be read");
        (lines, health)
    }

    #[test]
    fn lines_are_read_back_and_whatever_is_changed_is_found_and_stays_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let (whole, journal) = (file(folder.path()), folder.path().join(JOURNAL));
        assert_eq!(read(&whole), (BODIES.map(str::to_owned).to_vec(), Health::Whole));
        let text = fs::read_to_string(&journal).expect("written");
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        let changes: [(&str, String); 8] = [
            ("edited", text.replace("\"n\":2", "\"n\":4")),
            ("removed", [lines[0], lines[2]].concat()),
            ("first removed", lines[1..].concat()),
            ("last removed", lines[..2].concat()),
            ("moved", [lines[1], lines[0], lines[2]].concat()),
            ("doubled", [lines[0], lines[1], lines[1], lines[2]].concat()),
            ("empty", String::new()),
            ("unreadable", text.replacen('{', "\u{0}", 1)),
        ];
        for (what, changed) in changes {
            fs::write(&journal, &changed).expect("it can be written");
            assert!(matches!(read(&whole).1, Health::Damaged(_)), "{what}");
            // Lines added later do not repair it.
            whole.append(&[BODIES[0].to_owned()], &Wait::default()).expect("it can be written");
            assert!(matches!(read(&whole).1, Health::Damaged(_)), "{what}, with a line more");
        }
        fs::remove_file(&journal).expect("it is there");
        assert!(matches!(read(&whole).1, Health::Damaged(_)), "missing");
        fs::remove_file(folder.path().join(SEAL)).expect("it is there");
        assert_eq!(read(&whole).1, Health::Absent);
        whole.append(&[BODIES[0].to_owned()], &Wait::default()).expect("it can be written");
        assert!(matches!(read(&whole).1, Health::Damaged(_)), "what was before is lost");
        whole
            .replace(&folder.path().join("aside"), &BODIES.map(str::to_owned), &Wait::default())
            .expect("it can be written");
        assert_eq!(read(&whole), (BODIES.map(str::to_owned).to_vec(), Health::Whole));
        assert!(folder.path().join("aside").is_file());
    }

    #[test]
    fn a_torn_line_is_damage_until_the_next_takes_its_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let (torn, journal) = (file(folder.path()), folder.path().join(JOURNAL));
        let mut bytes = fs::read(&journal).expect("written");
        bytes.extend(b"{\"run\":\"caf\xc3");
        fs::write(&journal, bytes).expect("it can be written");
        assert_eq!(read(&torn), (BODIES.map(str::to_owned).to_vec(), super::torn()));
        torn.append(&[BODIES[0].to_owned()], &Wait::default()).expect("it can be written");
        assert_eq!(read(&torn).1, Health::Whole);
        assert_eq!(read(&torn).0.len(), 4);
    }

    #[test]
    fn a_line_without_a_digest_is_damage() {
        let folder = tempfile::tempdir().expect("a folder");
        let (file, journal) = (file(folder.path()), folder.path().join(JOURNAL));
        let text = fs::read_to_string(&journal).expect("written");
        fs::write(&journal, text + BODIES[0] + "\n").expect("it can be written");
        assert_eq!(
            read(&file),
            (BODIES.map(str::to_owned).to_vec(), Health::Damaged("line 4 has no digest".into()))
        );
    }
}
