//! The folder of a spec's project.

use std::path::{Path, PathBuf};

use crate::syntax::Files;

/// The nearest ancestor folder of a spec that contains `robots/`.
pub fn root(files: &dyn Files, spec: &Path) -> Option<PathBuf> {
    around(files, spec, "robots")
}

/// The folder of a spec's project: the nearest ancestor that contains `robots/`, else `specs/base/` (where
/// `new` finds parents), else the spec's own folder.
pub fn folder(files: &dyn Files, spec: &Path) -> PathBuf {
    let own = || spec.parent().map(Path::to_owned).unwrap_or_default();
    root(files, spec).or_else(|| around(files, spec, "specs/base")).unwrap_or_else(own)
}

/// The nearest ancestor of a spec that contains this folder.
pub fn around(files: &dyn Files, spec: &Path, held: &str) -> Option<PathBuf> {
    let here = files.absolute(spec);
    let found = here.ancestors().skip(1).find(|folder| files.is_folder(&folder.join(held)))?;
    let depth = here.ancestors().skip(1).position(|folder| folder == found)?;
    let mut shown: Option<&Path> = Some(spec);
    for _ in 0..=depth {
        shown = shown.and_then(Path::parent);
    }
    Some(shown.map_or_else(|| found.to_owned(), Path::to_owned))
}
