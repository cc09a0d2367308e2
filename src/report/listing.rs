//! Lists folders and files, without hidden folders and links.

use std::fs::DirEntry;
use std::path::{Path, PathBuf};

/// A folder and all its subfolders, without hidden ones and links.
pub fn folders(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![folder.to_owned()];
    let mut next = 0;
    while let Some(folder) = found.get(next) {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let is_folder = |entry: &DirEntry| {
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            !is_hidden && entry.file_type().is_ok_and(|kind| kind.is_dir())
        };
        let below: Vec<PathBuf> = entries.filter(is_folder).map(|entry| entry.path()).collect();
        found.extend(below);
        next += 1;
    }
    found
}

/// The files in a folder with this extension, sorted.
pub fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|own| own == ending)).collect();
    files.sort();
    files
}
