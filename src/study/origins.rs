//! Which project the pages in a folder outside of any project are of. Their records name specs by the place in
//! the project, and two projects may have a spec of the same name at the same place.
//!
//! The hidden file `.projects` in the folder has a line `DIGEST NAME` per page, with a digest of the project's
//! path, which only serves to tell projects on one machine apart. Folders inside a project have no such file.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use super::files::identity;
use crate::{bounded, safe_fs};

/// The name of the file.
const FILE: &str = ".projects";

/// Whether a page in a folder outside of the project is of another one: of that which contains the folder, or
/// of one that the file names. False for folders inside the project.
pub fn is_of_another(folder: &Path, name: &str, project: &Path) -> bool {
    let Some(own) = project_outside(folder, project) else { return false };
    read(folder).get(name) != Some(&own)
}

/// Notes that a page is of this project, if the folder is outside of it.
pub fn note(folder: &Path, name: &str, project: &Path) -> io::Result<()> {
    let Some(own) = project_outside(folder, project) else { return Ok(()) };
    let mut known = read(folder);
    if known.insert(name.to_owned(), own.clone()) == Some(own) {
        return Ok(());
    }
    let text: String = known.iter().map(|(name, project)| format!("{project} {name}\n")).collect();
    safe_fs::replace_inside(folder, FILE, text.as_bytes())
}

/// The digest of a project that does not contain the folder.
fn project_outside(folder: &Path, project: &Path) -> Option<String> {
    let real = |path: &Path| identity(if path.as_os_str().is_empty() { Path::new(".") } else { path });
    let project: PathBuf = real(project);
    let is_outside = !real(folder).starts_with(&project);
    is_outside.then(|| blake3::hash(project.as_os_str().as_encoded_bytes()).to_hex()[..16].to_owned())
}

/// The project of each page; empty without a readable file.
fn read(folder: &Path) -> BTreeMap<String, String> {
    let text = safe_fs::inside(folder, FILE).ok().and_then(|path| bounded::text(&path, bounded::RECORD).ok());
    let text = text.unwrap_or_default();
    let pair = |line: &str| line.split_once(' ').map(|(project, name)| (name.to_owned(), project.to_owned()));
    text.lines().filter_map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_outside_of_its_project_belongs_to_that_project() {
        let outer = tempfile::tempdir().expect("a folder");
        let [a, b, shared, inside] = ["a", "b", "shared", "a/reports"].map(|name| outer.path().join(name));
        for folder in [&a, &b, &shared, &inside] {
            std::fs::create_dir_all(folder).expect("a folder");
        }
        for (folder, name) in [(&shared, "walk"), (&shared, "a b"), (&inside, "walk")] {
            note(folder, name, &a).expect("it can be written");
        }
        note(&shared, "run", &b).expect("it can be written");
        let theirs = |name: &str, project: &Path| is_of_another(&shared, name, project);
        assert_eq!([theirs("walk", &a), theirs("walk", &b)], [false, true]);
        assert_eq!([theirs("run", &a), theirs("run", &b)], [true, false]);
        assert_eq!([theirs("a b", &b), theirs("none", &b)], [true, true]);
        assert!(is_of_another(&inside, "walk", &b), "project A does not note its own pages");
        assert!(!inside.join(FILE).exists(), "its record says enough");
        assert!(!is_of_another(&inside, "walk", &a));
    }
}
