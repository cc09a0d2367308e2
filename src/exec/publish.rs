//! Publishing a report: copies the artefact's files out of the store to where people read them.

use std::fs;
use std::path::{Path, PathBuf};

use super::fault::StoreError;
use super::manifest::{self, Manifest};

/// Copies a report's files into a folder (`reports/`) and gives the path of its text, `NAME.md`. Files that
/// are as they should be are left alone; those that another report had stay.
pub fn publish(artefact: &Path, folder: &Path, name: &str) -> Result<PathBuf, StoreError> {
    let path = artefact.join(manifest::FILE);
    let text = fs::read_to_string(&path).map_err(|source| StoreError::Io { path: path.clone(), source })?;
    let manifest = Manifest::from_text(&text).map_err(|reason| StoreError::Damaged { path, reason })?;
    for record in &manifest.files {
        copy(&artefact.join(&record.path), &folder.join(&record.path))?;
    }
    Ok(folder.join(format!("{name}.md")))
}

fn copy(from: &Path, to: &Path) -> Result<(), StoreError> {
    let content = fs::read(from).map_err(|source| StoreError::Io { path: from.into(), source })?;
    if fs::read(to).is_ok_and(|present| present == content) {
        return Ok(());
    }
    let unpublished = |path: &Path, source| StoreError::Unpublished { path: path.into(), source };
    let parent = to.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(|error| unpublished(parent, error))?;
    fs::write(to, content).map_err(|error| unpublished(to, error))
}
