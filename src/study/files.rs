//! Collects TOML files: files are taken directly, folders are searched recursively.

use std::collections::BTreeSet;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::bounded;
use crate::diag::Diagnostic;
use crate::spec::suite;

/// Most files and folders below the arguments.
const MOST: usize = 100_000;
/// Deepest nesting of folders.
const DEEPEST: usize = 64;

/// The TOML files for these arguments, sorted within each. Hidden folders and `target` are skipped. E0008 for
/// a folder that is too large.
pub fn toml_files(arguments: &[PathBuf]) -> Result<Vec<PathBuf>, Diagnostic> {
    let mut walk = Walk::default();
    for argument in arguments {
        if argument.is_dir() {
            walk.named = identity(argument);
            walk.below(argument, 0)?;
        } else {
            walk.found.push(argument.clone());
        }
    }
    Ok(walk.found)
}

#[derive(Default)]
struct Walk {
    /// The real path of the named folder; links that lead out of it are skipped.
    named: PathBuf,
    found: Vec<PathBuf>,
    entries: usize,
    /// Device and inode of all folders visited so far: a symlink can lead back to one.
    visited: BTreeSet<(u64, u64)>,
}

impl Walk {
    fn below(&mut self, folder: &Path, depth: usize) -> Result<(), Diagnostic> {
        let first = folder.metadata().is_ok_and(|found| self.visited.insert((found.dev(), found.ino())));
        if !first {
            return Ok(());
        }
        if depth > DEEPEST {
            return Err(too_large(folder, &format!("it is nested more than {DEEPEST} levels deep")));
        }
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            self.entries += 1;
            if self.entries > MOST {
                return Err(too_large(folder, &format!("there are more than {MOST} files and folders")));
            }
            paths.push(entry.path());
        }
        paths.sort();
        // A link to something other than a file or folder is reported when it is read.
        let leads_out = |path: &PathBuf| {
            path.is_symlink() && (path.is_file() || path.is_dir()) && !identity(path).starts_with(&self.named)
        };
        let inside = |path: &PathBuf| !leads_out(path);
        paths.retain(inside);
        for path in paths {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() {
                if !name.starts_with('.') && name != "target" {
                    self.below(&path, depth + 1)?;
                }
            } else if path.extension().is_some_and(|ending| ending == "toml") {
                self.found.push(path);
            }
        }
        Ok(())
    }
}

/// The canonical path of a file.
pub fn identity(file: &Path) -> PathBuf {
    file.canonicalize().unwrap_or_else(|_| file.to_owned())
}

fn too_large(folder: &Path, why: &str) -> Diagnostic {
    let message = format!("cannot search `{}`: {why}", crate::escape::file(folder));
    Diagnostic::error("E0008", message).help("name the folder that holds the specs, such as `specs`")
}

/// Whether a file is a suite; `false` if it cannot be read.
pub fn is_suite(path: &Path) -> bool {
    bounded::text(path, bounded::WRITTEN).is_ok_and(|text| suite::is_suite(&text))
}

/// The specs and suites for these paths: files are taken directly, folders are searched for TOML files with
/// an edition, sorted. Motions and robots have no edition. E0008 for a folder that is too large.
pub fn specs(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Diagnostic> {
    let is_spec = |path: &PathBuf| paths.contains(path) || may_be_spec(path);
    Ok(toml_files(paths)?.into_iter().filter(is_spec).collect())
}

/// Whether a file has an edition. True for an existing file that cannot be read, as reading it later reports
/// the error.
fn may_be_spec(path: &Path) -> bool {
    match bounded::head(path, bounded::WRITTEN) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).lines().any(says_edition),
        Err(error) => !error.is_absence(),
    }
}

fn says_edition(line: &str) -> bool {
    line.trim_start().strip_prefix("spec").is_some_and(|rest| rest.trim_start().starts_with('='))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    fn names(folder: &Path) -> Result<Vec<String>, &'static str> {
        let relative = |path: PathBuf| path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
        let found = toml_files(&[folder.to_owned()]).map_err(|error| error.code)?;
        Ok(found.into_iter().map(relative).collect())
    }

    #[test]
    fn each_folder_is_visited_once_however_symlinks_lead_to_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("a/b")).unwrap();
        fs::write(path("a/b/x.toml"), "").unwrap();
        // Two loops in one folder: following them would double the paths on every level.
        symlink("../..", path("a/b/up")).unwrap();
        symlink(".", path("a/here")).unwrap();
        symlink("loop", path("loop")).unwrap();
        assert_eq!(names(folder.path()).unwrap(), ["a/b/x.toml"]);
    }

    #[test]
    fn a_folder_that_is_too_deep_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("d/".repeat(DEEPEST));
        fs::create_dir_all(&deep).unwrap();
        fs::write(deep.join("x.toml"), "").unwrap();
        assert_eq!(names(folder.path()).unwrap().len(), 1);
        fs::create_dir(deep.join("d")).unwrap();
        assert_eq!(names(folder.path()), Err("E0008"));
    }
}
