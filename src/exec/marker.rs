//! Tells whether a folder is a store. New stores have a marker file; older ones are recognised by their
//! content. Commands that delete only touch stores.

use std::fs;
use std::path::{Path, PathBuf};

use super::fault::StoreError;
use super::manifest;
use super::mark::{FILE, Flaw, LAYOUT};
use crate::plan::{Fingerprint, StageKind};
use crate::{bounded, safe_fs};

/// Start of the marker's first line; the layout number follows.
const TITLE: &str = "A store of specforge, layout ";
/// Folders of a store besides those of the stage kinds.
pub const FOLDERS: [&str; 6] = ["tmp", "scratch", "locks", "leases", "damaged", "tensorboard"];
/// Files of a store.
pub const FILES: [&str; 4] = [FILE, ".gitignore", "journal.jsonl", "journal.seal"];

/// What a folder is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identity {
    /// It does not exist.
    Absent,
    /// It was created as a store.
    Marked,
    /// A store of a version without marker files: everything in it belongs to a store.
    Unmarked,
    /// It contains something else, or nothing.
    Other {
        /// Why it is not a store.
        reason: String,
        /// Whether it contains nothing foreign: an empty folder, or a store that is being created.
        vacant: bool,
    },
}

/// Whether the folder is marked as a store. E0815 if the marker is damaged or names another layout, whatever
/// else is in the folder.
pub fn is_marked(root: &Path) -> Result<bool, StoreError> {
    let path = root.join(FILE);
    if !is_real(&path, fs::Metadata::is_file) {
        return Ok(false);
    }
    let text = bounded::text(&path, bounded::WRITTEN).map_err(|error| Flaw::Damaged(error.to_string()));
    match text.and_then(|text| layout(&text)) {
        Ok(LAYOUT) => Ok(true),
        Ok(other) => Err(StoreError::Mark { path: root.to_owned(), flaw: Flaw::Layout(other) }),
        Err(flaw) => Err(StoreError::Mark { path: root.to_owned(), flaw }),
    }
}

/// Reads the layout from a marker's first line, which ends with a full stop and a line break.
fn layout(text: &str) -> Result<u32, Flaw> {
    let damaged = |reason: &str| Flaw::Damaged(reason.to_owned());
    let (first, _) = text.split_once('\n').ok_or_else(|| damaged("its first line is cut off"))?;
    let number = first.strip_prefix(TITLE).and_then(|rest| rest.strip_suffix('.'));
    let number = number.ok_or_else(|| damaged("its first line names no layout"))?;
    let is_plain = number.bytes().all(|byte| byte.is_ascii_digit()) && !number.starts_with('0');
    number.parse().ok().filter(|_| is_plain).ok_or_else(|| damaged("its layout is not a number"))
}

/// What the folder is. E0815 if its marker is damaged or names another layout.
pub fn identity(root: &Path) -> Result<Identity, StoreError> {
    let entries = match root.read_dir() {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Identity::Absent),
        Err(error) => return Err(StoreError::reading(root, error)),
    };
    if is_marked(root)? {
        return Ok(Identity::Marked);
    }
    let (mut strange, mut wrong, mut artefacts) = (None, None, 0);
    for entry in entries {
        let path = entry.map_err(|error| StoreError::reading(root, error))?.path();
        match part(&path) {
            Part::Artefacts(count) => artefacts += count,
            Part::Known => {}
            Part::Strange => strange = strange.or(Some(path)),
            Part::Wrong(inner) => wrong = wrong.or(Some(inner)),
        }
    }
    Ok(match wrong.or(strange) {
        None if artefacts > 0 => Identity::Unmarked,
        None => Identity::Other { reason: "it holds no artefact".into(), vacant: true },
        Some(path) => {
            let path = path.strip_prefix(root).unwrap_or(&path).display().to_string();
            Identity::Other { reason: format!("`{path}` does not belong to a store"), vacant: false }
        }
    })
}

/// Marks a folder as a store.
pub fn mark(root: &Path) -> Result<(), StoreError> {
    let path = root.join(FILE);
    let text = format!(
        "{TITLE}{LAYOUT}.\n`specforge cache` lists, verifies and cleans it; delete it as a whole or not at \
         all.\n"
    );
    safe_fs::replace_inside(root, FILE, text.as_bytes()).map_err(|error| StoreError::writing(&path, error))
}

/// Whether a path is of the expected type, file or folder, and not a symlink to one.
pub fn is_real(path: &Path, kind: fn(&fs::Metadata) -> bool) -> bool {
    path.symlink_metadata().is_ok_and(|found| kind(&found))
}

/// What an entry of a folder would be in a store.
enum Part {
    /// A folder with this many artefacts.
    Artefacts(usize),
    /// Another part of a store.
    Known,
    /// Not part of a store.
    Strange,
    /// Named like a part of a store but of the wrong type.
    Wrong(PathBuf),
}

fn part(path: &Path) -> Part {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_folder = is_real(path, fs::Metadata::is_dir);
    if StageKind::ALL.iter().any(|kind| kind.name() == name) {
        if !is_folder {
            return Part::Wrong(path.to_owned());
        }
        let children = children(path);
        return match children.iter().find(|child| !is_artefact(child)) {
            Some(child) => Part::Wrong(child.clone()),
            None => Part::Artefacts(children.len()),
        };
    }
    if FOLDERS.contains(&name.as_str()) {
        return match is_folder {
            false => Part::Wrong(path.to_owned()),
            true => children(path)
                .into_iter()
                .find(|child| !is_part_of(&name, child))
                .map_or(Part::Known, Part::Wrong),
        };
    }
    match FILES.contains(&name.as_str()) {
        true if is_real(path, fs::Metadata::is_file) => Part::Known,
        true => Part::Wrong(path.to_owned()),
        // The marker of a store that another process is creating.
        false if safe_fs::is_draft(&name) && is_real(path, fs::Metadata::is_file) => Part::Known,
        false => Part::Strange,
    }
}

fn is_artefact(path: &Path) -> bool {
    is_key(path)
        && is_real(path, fs::Metadata::is_dir)
        && is_real(&path.join(manifest::FILE), fs::Metadata::is_file)
}

/// Whether an entry of one of [`FOLDERS`] is what a store would put there.
fn is_part_of(folder: &str, path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match folder {
        "tmp" => {
            name.split_once('.').is_some_and(|(key, _)| key == "probe" || Fingerprint::parse(key).is_some())
        }
        "scratch" => is_key(path),
        "damaged" => is_damaged(path),
        "tensorboard" => is_real(path, fs::Metadata::is_dir),
        // Empty files that processes lock.
        _ => is_real(path, fs::Metadata::is_file),
    }
}

/// Whether a path is named by a fingerprint.
pub fn is_key(path: &Path) -> bool {
    path.file_name().is_some_and(|name| Fingerprint::parse(&name.to_string_lossy()).is_some())
}

/// Whether an entry of `damaged/` was moved there by a store: `KIND-DIGITS-NUMBER`, or a journal.
pub fn is_damaged(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut parts = name.split('-');
    let [kind, key, number] = [parts.next(), parts.next(), parts.next()].map(Option::unwrap_or_default);
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let is_short = key.len() == 12 && key.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_entry = StageKind::ALL.iter().any(|own| own.name() == kind) && is_short && is_number;
    parts.next().is_none() && (is_entry || (kind == "journal" && number.is_empty()))
}

fn children(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> =
        folder.read_dir().into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: PathBuf) {
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, "x").expect("a file");
    }

    #[test]
    fn a_folder_is_a_store_when_it_is_marked_or_holds_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let (root, key) = (folder.path(), "0123456789abcdef".repeat(4));
        assert_eq!(identity(&root.join("none")).expect("readable"), Identity::Absent);
        let other = |is_vacant: bool| match identity(root).expect("readable") {
            Identity::Other { vacant, reason } => assert_eq!(vacant, is_vacant, "{reason}"),
            found => panic!("{found:?}"),
        };
        other(true);
        write(root.join("locks").join(&key));
        write(root.join("journal.jsonl"));
        other(true);
        write(root.join("learner").join(&key).join("manifest.json"));
        assert_eq!(identity(root).expect("readable"), Identity::Unmarked);
        // None of these belongs to a store.
        for path in [
            "holiday.jpg",
            "damaged/holiday.jpg",
            "damaged/learner-x-1",
            "scratch/notes",
            "tmp/holiday.jpg",
            "robot/holiday.jpg",
            "journal.seal/page",
        ] {
            write(root.join(path));
            other(false);
            let top = root.join(path.split('/').next().expect("a name"));
            let removed = if top.is_dir() { fs::remove_dir_all(&top) } else { fs::remove_file(&top) };
            removed.expect("it was just written");
        }
        write(root.join("damaged/learner-0123456789ab-1"));
        assert_eq!(identity(root).expect("readable"), Identity::Unmarked);
        std::os::unix::fs::symlink(root, root.join("scratch")).expect("a link");
        other(false);
        mark(root).expect("it can be written");
        assert_eq!(identity(root).expect("readable"), Identity::Marked);
    }

    #[test]
    fn a_mark_that_was_cut_off_edited_or_is_of_another_layout_is_no_mark_and_no_folder_without_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        mark(root).expect("it can be written");
        let whole = fs::read_to_string(root.join(FILE)).expect("it was just written");
        assert_eq!(layout(&whole), Ok(LAYOUT));
        let flaw = |text: &str| {
            fs::write(root.join(FILE), text).expect("it can be written");
            match identity(root) {
                Err(StoreError::Mark { flaw, .. }) => flaw,
                found => panic!("{text:?}: {found:?}"),
            }
        };
        assert_eq!(flaw(&whole.replace("layout 1", "layout 2")), Flaw::Layout(2));
        assert_eq!(flaw(&whole.replace("layout 1", "layout 10")), Flaw::Layout(10));
        let first = whole.split('\n').next().expect("a line");
        for text in ["", "x", first, &first[..first.len() - 1], &whole.replace("layout 1", "layout 01")] {
            assert!(matches!(flaw(text), Flaw::Damaged(_)), "{text:?}");
        }
        for text in [
            whole.replace("layout 1", "layout -1"),
            whole.replace("layout 1", "layout 99999999999"),
            whole[1..].into(),
        ] {
            assert!(matches!(flaw(&text), Flaw::Damaged(_)), "{text:?}");
        }
        fs::remove_file(root.join(FILE)).expect("it is there");
        assert!(matches!(identity(root), Ok(Identity::Other { .. })));
    }
}
