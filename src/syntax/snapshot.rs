//! Files that are read once: a check of a spec asks for the same few files under every profile.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::files::{Files, Sort};
use crate::bounded::ReadError;

/// Other files as they were when they were first asked for. Failures are not kept.
#[derive(Debug, Default)]
pub struct Snapshot<F> {
    below: F,
    sorts: Known<Sort>,
    texts: Known<Arc<[u8]>>,
    absolutes: Known<PathBuf>,
    identities: Known<PathBuf>,
}

/// The answers so far. The key is the text of the path: texts compare faster than paths.
type Known<T> = Mutex<BTreeMap<OsString, T>>;

impl<F: Files> Snapshot<F> {
    /// A snapshot that nothing has been asked of yet.
    pub fn new(below: F) -> Self {
        Self {
            below,
            sorts: Known::default(),
            texts: Known::default(),
            absolutes: Known::default(),
            identities: Known::default(),
        }
    }
}

impl<F: Files> Files for Snapshot<F> {
    fn sort(&self, path: &Path) -> io::Result<Sort> {
        known(&self.sorts, path, || self.below.sort(path))
    }

    fn bytes(&self, path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
        let bytes = known(&self.texts, path, || self.below.bytes(path, limit).map(Arc::from))?;
        match bytes.len() as u64 {
            size if size > limit => Err(ReadError::TooLarge { size: Some(size), limit }),
            _ => Ok(bytes.to_vec()),
        }
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        self.below.names(folder)
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        certain(&self.absolutes, path, || self.below.absolute(path))
    }

    fn identity(&self, path: &Path) -> PathBuf {
        certain(&self.identities, path, || self.below.identity(path))
    }
}

/// The earlier answer for a path, or that of `ask`, which is kept unless it is an error. Of two threads that
/// ask at the same time, both get the answer of the first.
fn known<T: Clone, E>(known: &Known<T>, path: &Path, ask: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    let answers = || known.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(answer) = answers().get(path.as_os_str()).cloned() {
        return Ok(answer);
    }
    let answer = ask()?;
    Ok(answers().entry(path.as_os_str().to_owned()).or_insert(answer).clone())
}

/// The same for an answer that never fails.
fn certain<T: Clone>(answers: &Known<T>, path: &Path, ask: impl FnOnce() -> T) -> T {
    let Ok(answer) = known(answers, path, || Ok::<T, std::convert::Infallible>(ask()));
    answer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::Disk;

    #[test]
    fn a_file_stays_as_it_was_first_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let [path, other] = ["walk.toml", "run.toml"].map(|name| folder.path().join(name));
        std::fs::write(&path, "before").expect("written");
        let files = Snapshot::new(Disk);
        assert_eq!(files.bytes(&path, 6).expect("read"), b"before");
        assert!(files.is_file(&path) && !files.is_file(&other), "only one of them exists");
        std::fs::write(&path, "later").expect("written");
        std::fs::write(&other, "later").expect("written");
        assert_eq!(files.bytes(&path, 6).expect("remembered"), b"before");
        assert!(matches!(files.bytes(&path, 5), Err(ReadError::TooLarge { size: Some(6), limit: 5 })));
        assert!(files.is_file(&other), "that a file is missing is not remembered");
        std::fs::remove_file(&path).expect("removed");
        assert!(files.is_file(&path) && Snapshot::new(Disk).bytes(&path, 6).is_err());
    }
}
