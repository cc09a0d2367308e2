//! The files that a training writes next to its checkpoint: metrics, TensorBoard events, exploded episodes.
//! The checkpoint holds a digest of each, so that a resumed training detects changed files.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::bounded;

/// The metrics.
pub const METRICS: &str = "metrics.jsonl";
/// TensorBoard's events; TensorBoard looks for `tfevents` in the name.
pub const EVENTS: &str = "events.out.tfevents.specforge";
/// Beginning of the names of exploded episodes.
const EXPLODED: &str = "exploded_";

/// The digests of the files next to a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Beside {
    /// The metrics.
    metrics: Prefix,
    /// The events.
    events: Prefix,
    /// BLAKE3 of each exploded episode by its file.
    exploded: BTreeMap<String, String>,
}

/// The beginning of a growing file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Prefix {
    /// Length in bytes.
    bytes: u64,
    /// BLAKE3 of these bytes.
    blake3: String,
}

impl Prefix {
    fn of(path: &Path) -> io::Result<Self> {
        let bytes = bounded::bytes(path, bounded::ARTEFACT)?;
        Ok(Self { bytes: bytes.len() as u64, blake3: digest(&bytes) })
    }

    /// Whether the file begins with these bytes.
    fn fits(&self, path: &Path) -> bool {
        let bytes = bounded::bytes(path, bounded::ARTEFACT).unwrap_or_default();
        usize::try_from(self.bytes)
            .ok()
            .and_then(|end| bytes.get(..end))
            .is_some_and(|own| digest(own) == self.blake3)
    }
}

impl Beside {
    /// The digests of the files in a training's scratch folder.
    pub fn of(scratch: &Path) -> io::Result<Self> {
        let mut exploded = BTreeMap::new();
        for path in exploded_in(scratch)? {
            exploded.insert(name(&path), digest(&bounded::bytes(&path, bounded::ARTEFACT)?));
        }
        let prefix = |file: &str| Prefix::of(&scratch.join(file));
        Ok(Self { metrics: prefix(METRICS)?, events: prefix(EVENTS)?, exploded })
    }

    /// Checks the files that cannot be rebuilt: the metrics and the exploded episodes.
    pub fn check(&self, scratch: &Path) -> Result<(), String> {
        if !self.metrics.fits(&scratch.join(METRICS)) {
            return Err(format!("{METRICS} has changed since the checkpoint was written"));
        }
        let whole = |(file, known): &(&String, &String)| {
            bounded::bytes(&scratch.join(file), bounded::ARTEFACT)
                .is_ok_and(|bytes| digest(&bytes) == **known)
        };
        match self.exploded.iter().find(|entry| !whole(entry)) {
            Some((file, _)) => Err(format!("{file} has changed since the checkpoint was written")),
            None => Ok(()),
        }
    }

    /// Length in bytes of TensorBoard's events if they are unchanged; otherwise they are rebuilt from the
    /// metrics.
    pub fn events(&self, scratch: &Path) -> Option<u64> {
        self.events.fits(&scratch.join(EVENTS)).then_some(self.events.bytes)
    }

    /// Removes exploded episodes that the checkpoint does not list: those of later updates are written again.
    pub fn sweep(&self, scratch: &Path) -> io::Result<()> {
        let others =
            exploded_in(scratch)?.into_iter().filter(|path| !self.exploded.contains_key(&name(path)));
        others.into_iter().try_for_each(fs::remove_file)
    }
}

/// The file name of an exploded episode.
pub fn exploded_file(environment: usize, episode: u64) -> String {
    format!("{EXPLODED}{environment}_{episode}.json")
}

/// The exploded episodes in a folder, sorted by name.
pub fn exploded_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let paths = folder.read_dir()?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = paths.collect::<io::Result<Vec<_>>>()?;
    paths.retain(|path| name(path).starts_with(EXPLODED) && name(path).ends_with(".json"));
    paths.sort();
    Ok(paths)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beside_a_checkpoint_may_grow_and_may_not_change() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str| fs::write(path(name), text).expect("it can be written");
        let dump = exploded_file(3, 7);
        for (name, text) in [(METRICS, "{\"update\":0}\n"), (EVENTS, "abc"), (&dump, "{}")] {
            write(name, text);
        }
        let known = Beside::of(folder.path()).expect("all is there");
        let health = || (known.check(folder.path()).is_ok(), known.events(folder.path()).is_some());
        write(METRICS, "{\"update\":0}\n{\"update\":1}\n");
        write(EVENTS, "abcdef");
        assert_eq!(health(), (true, true), "a training continued after the checkpoint");
        for text in ["{\"update\":1}\n", "{\"update\":0}", ""] {
            write(METRICS, text);
            assert_eq!(health(), (false, true), "{text}");
        }
        write(METRICS, "{\"update\":0}\n");
        write(EVENTS, "ab");
        assert_eq!(health(), (true, false));
        write(&dump, "{ }");
        assert_eq!(health(), (false, false));
        write(&dump, "{}");
        write(&exploded_file(1, 9), "{}");
        known.sweep(folder.path()).expect("it can be removed");
        assert_eq!(exploded_in(folder.path()).expect("it can be read"), [path(&dump)]);
    }
}
