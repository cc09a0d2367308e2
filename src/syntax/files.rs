//! Sources of texts: the disk, or an editor's buffers. The compiler's front end reads files only through
//! [`Files`], so that it also works on texts that are not saved.

use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::bounded::{self, ReadError};

/// What a path refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// Anything but a folder; whether it is readable shows only when it is read.
    File,
    /// A folder.
    Folder,
}

/// A source of files.
pub trait Files: Sync {
    /// What a path refers to.
    fn sort(&self, path: &Path) -> io::Result<Sort>;

    /// The bytes of a file, if these are no more than `limit`.
    fn bytes(&self, path: &Path, limit: u64) -> Result<Vec<u8>, ReadError>;

    /// The sorted names in a folder; empty if the folder does not exist.
    fn names(&self, folder: &Path) -> Vec<String>;

    /// The path from the root of the file system.
    fn absolute(&self, path: &Path) -> PathBuf;

    /// A key that is equal for paths to the same file.
    fn identity(&self, path: &Path) -> PathBuf;

    /// Whether there is a file.
    fn is_file(&self, path: &Path) -> bool {
        matches!(self.sort(path), Ok(Sort::File))
    }

    /// Whether there is a folder.
    fn is_folder(&self, path: &Path) -> bool {
        matches!(self.sort(path), Ok(Sort::Folder))
    }
}

/// The files on the disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn sort(&self, path: &Path) -> io::Result<Sort> {
        let metadata = std::fs::metadata(path)?;
        Ok(if metadata.is_dir() { Sort::Folder } else { Sort::File })
    }

    fn bytes(&self, path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
        bounded::bytes(path, limit)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
        names.sort();
        names
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
    }

    fn identity(&self, path: &Path) -> PathBuf {
        std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
    }
}

/// No files at all: with an [`Overlay`], a file system in memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nowhere;

impl Files for Nowhere {
    fn sort(&self, _path: &Path) -> io::Result<Sort> {
        Err(io::ErrorKind::NotFound.into())
    }

    fn bytes(&self, _path: &Path, _limit: u64) -> Result<Vec<u8>, ReadError> {
        Err(io::Error::from(io::ErrorKind::NotFound).into())
    }

    fn names(&self, _folder: &Path) -> Vec<String> {
        Vec::new()
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        Path::new("/").join(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        plain(&self.absolute(path))
    }
}

/// Texts that replace files, for example unsaved editor buffers.
#[derive(Clone, Debug)]
pub struct Overlay<F> {
    below: F,
    texts: BTreeMap<PathBuf, Arc<str>>,
}

impl<F: Files> Overlay<F> {
    /// An overlay without texts.
    pub fn new(below: F) -> Self {
        Self { below, texts: BTreeMap::new() }
    }

    /// Adds a text, which replaces the file at that path if there is one.
    pub fn hold(&mut self, path: &Path, text: impl Into<Arc<str>>) {
        self.texts.insert(self.key(path), text.into());
    }

    /// Removes the text of a path, so that its file is used again.
    pub fn release(&mut self, path: &Path) {
        self.texts.remove(&self.key(path));
    }

    fn key(&self, path: &Path) -> PathBuf {
        plain(&self.below.absolute(path))
    }

    /// The overlaid texts below a folder, as relative paths.
    fn inside(&self, folder: &Path) -> impl Iterator<Item = &Path> {
        let folder = self.key(folder);
        self.texts.keys().filter_map(move |path| path.strip_prefix(&folder).ok())
    }
}

impl<F: Files> Files for Overlay<F> {
    fn sort(&self, path: &Path) -> io::Result<Sort> {
        if self.texts.contains_key(&self.key(path)) {
            return Ok(Sort::File);
        }
        if self.inside(path).next().is_some() { Ok(Sort::Folder) } else { self.below.sort(path) }
    }

    fn bytes(&self, path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
        match self.texts.get(&self.key(path)) {
            Some(text) if text.len() as u64 > limit => {
                Err(ReadError::TooLarge { size: Some(text.len() as u64), limit })
            }
            Some(text) => Ok(text.as_bytes().to_vec()),
            None if self.inside(path).next().is_some() => Err(ReadError::Folder),
            None => self.below.bytes(path, limit),
        }
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let mut names = self.below.names(folder);
        let first = |path: &Path| {
            path.components().next().map(|part| part.as_os_str().to_string_lossy().into_owned())
        };
        names.extend(self.inside(folder).filter_map(first));
        names.sort();
        names.dedup();
        names
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        self.below.absolute(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        let key = self.key(path);
        if self.texts.contains_key(&key) { key } else { self.below.identity(path) }
    }
}

/// A path without `.` and, if possible, without `..`.
pub fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        let last = plain.components().next_back();
        match (part, last) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                plain.pop();
            }
            (part, _) => plain.push(part),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_text_lies_over_the_file_until_it_is_released() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("walk.toml");
        std::fs::write(&path, "saved").expect("written");
        let mut overlay = Overlay::new(Disk);
        overlay.hold(&folder.path().join("robots/../walk.toml"), "typed");
        assert_eq!(overlay.bytes(&path, 5).expect("held"), b"typed");
        assert!(overlay.bytes(&path, 4).is_err(), "larger than the limit");
        overlay.release(&path);
        assert_eq!(overlay.bytes(&path, 5).expect("on the disk"), b"saved");
    }

    #[test]
    fn folders_of_held_texts_are_there() {
        let mut overlay = Overlay::new(Nowhere);
        overlay.hold(Path::new("robots/mine.toml"), "");
        overlay.hold(Path::new("/specs/a.toml"), "");
        assert!(overlay.is_folder(Path::new("robots")) && overlay.is_folder(Path::new("/")));
        assert!(
            !overlay.is_folder(Path::new("specs/a.toml")) && overlay.is_file(Path::new("specs/./a.toml"))
        );
        assert_eq!(overlay.names(Path::new("/")), ["robots", "specs"]);
        assert!(overlay.bytes(Path::new("b.toml"), 5).is_err_and(|error| error.is_absence()));
    }
}
