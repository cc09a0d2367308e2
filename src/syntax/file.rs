//! Reads text files for the compiler's front end: missing files (E0004), bytes that are not UTF-8 (E0005),
//! folders and unreasonably large files (E0006), pipes and devices (E0007) are diagnostics, not panics.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::files::Files;
use crate::bounded::{ReadError, WRITTEN as LARGEST};
use crate::diag::Diagnostic;
use crate::escape;

/// Reads a text. The diagnostic has no location yet; the caller knows where the file is named.
pub fn read(files: &dyn Files, path: &Path) -> Result<String, Diagnostic> {
    let bytes = files.bytes(path, LARGEST).map_err(|error| refused(files, path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        refused(files, path, &ReadError::NotUtf8 { at })
    })
}

/// The diagnostic for a text that could not be read.
pub fn refused(files: &dyn Files, path: &Path, error: &ReadError) -> Diagnostic {
    let shown = escape::file(path);
    let unreadable = |code| Diagnostic::error(code, format!("cannot read `{shown}`: {error}"));
    match error {
        ReadError::Folder => unreadable("E0006").help("name a .toml file in it"),
        ReadError::Special(_) => unreadable("E0007").help("name a regular file"),
        ReadError::NotUtf8 { at } => {
            Diagnostic::error("E0005", format!("`{shown}` is not UTF-8 (byte {at})"))
                .help("save the file as UTF-8 text")
        }
        _ if error.is_absence() => {
            let diagnostic = Diagnostic::error("E0004", format!("file not found: `{shown}`"));
            match neighbour(files, path) {
                Some(name) if path.file_name().is_some_and(|own| *own == *name) => {
                    diagnostic.help("it is a symlink to a missing file")
                }
                Some(name) => diagnostic
                    .help(format!("there is a file `{}` in that folder", escape::file(Path::new(&name)))),
                None => diagnostic.help(elsewhere(files, path).unwrap_or_else(|| {
                    "paths in a spec are relative to its folder, paths on the command line to the current \
                     folder"
                        .to_owned()
                })),
            }
        }
        ReadError::TooLarge { .. } => unreadable("E0006")
            .help("specs and robots have a few kilobytes: check that this is the right file"),
        ReadError::Io(error) if error.kind() == ErrorKind::PermissionDenied => {
            unreadable("E0006").help("change its permissions, or name another file")
        }
        _ => unreadable("E0006").help("name a regular file: this one may be a link that leads to itself"),
    }
}

/// The folder of all specs of a project.
const SPECS: &str = "specs";
/// Largest number of names that are searched for a file of the same name.
const MOST_NAMES: usize = 20_000;
/// Largest number of files of the same name that are listed.
const TOLD: usize = 3;

/// Files below the project's specs with the same name as a missing one, as advice.
pub fn elsewhere(files: &dyn Files, path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let missing = files.absolute(path);
    let around = || missing.ancestors().skip(1);
    let root = around()
        .find(|folder| folder.file_name().is_some_and(|name| name == SPECS) && files.is_folder(folder))
        .map(Path::to_owned)
        .or_else(|| around().map(|folder| folder.join(SPECS)).find(|folder| files.is_folder(folder)))?;
    let here = files.absolute(Path::new("."));
    let (mut found, mut folders, mut seen) = (Vec::new(), vec![root], 0);
    while let Some(folder) = folders.pop() {
        for other in files.names(&folder) {
            seen += 1;
            let place = folder.join(&other);
            if other == name && files.is_file(&place) {
                found.push(place);
            } else if !other.contains('.') && files.is_folder(&place) && seen < MOST_NAMES {
                folders.push(place);
            }
        }
    }
    found.sort();
    let shown = |place: &PathBuf| format!("`{}`", escape::file(place.strip_prefix(&here).unwrap_or(place)));
    let shown: Vec<String> = found.iter().take(TOLD).map(shown).collect();
    (!shown.is_empty()).then(|| format!("there is a file of that name: {}", shown.join(", ")))
}

/// A file with a similar name in the folder of a missing one.
fn neighbour(files: &dyn Files, path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let near = |other: String| slips(name, &other).map(|slips| (slips, other));
    files.names(path.parent()?).into_iter().filter_map(near).min().map(|(_, other)| other)
}

/// How many slips of the keyboard make one file's name of another; `None` where they are no more alike than names of
/// other things are. An ending that both have says nothing.
fn slips(name: &str, other: &str) -> Option<usize> {
    let ending = |name: &str| Path::new(name).extension().map(|ending| ending.len() + 1).unwrap_or(0);
    let is_shared = ending(name) > 0 && Path::new(name).extension() == Path::new(other).extension();
    let cut = if is_shared { ending(name) } else { 0 };
    let [name, other] = [name, other].map(|name| &name[..name.len() - cut]);
    let length = name.chars().count();
    let most = if name.eq_ignore_ascii_case(other) { length } else { (length / 3).min(3) };
    // The distance is at least the difference of the lengths, which costs nothing to compare.
    let is_long = length > 100 || other.chars().count().abs_diff(length) > most;
    let slips = (!is_long).then(|| strsim::damerau_levenshtein(name, other))?;
    (slips <= most).then_some(slips)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::Disk;

    #[test]
    fn a_missing_file_whose_name_is_elsewhere_below_the_specs_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        for place in ["specs/paper", "specs/studies/deep", "specs/.hidden"] {
            std::fs::create_dir_all(path(place)).expect("made");
            std::fs::write(path(place).join("walk.toml"), "a = 1").expect("written");
        }
        std::fs::write(path("specs/run.toml"), "a = 1").expect("written");
        let help = |name: &str| read(&Disk, &path(name)).expect_err("missing").help.remove(0);
        let both = format!(
            "there is a file of that name: `{}`, `{}`",
            path("specs/paper/walk.toml").display(),
            path("specs/studies/deep/walk.toml").display()
        );
        for missing in ["specs/suites/walk.toml", "specs/walk.toml", "suites/walk.toml", "walk.toml"] {
            assert_eq!(help(missing), both, "{missing}");
        }
        let run = format!("there is a file of that name: `{}`", path("specs/run.toml").display());
        assert_eq!(help("specs/paper/run.toml"), run);
        assert!(help("specs/suites/stand.toml").starts_with("paths in a spec are relative to"));
    }

    #[test]
    fn only_a_name_that_is_nearly_the_same_is_suggested_for_a_missing_file() {
        for (missing, other, slips) in [
            ("wlak.toml", "walk.toml", Some(1)),
            ("walk.tml", "walk.toml", Some(1)),
            ("tocabi_walk_torqe.toml", "tocabi_walk_torque.toml", Some(1)),
            ("Walk.toml", "walk.toml", Some(1)),
            ("sf7.toml", "r17.toml", None),
            ("a.toml", "b.toml", None),
            ("run.toml", "walk.toml", None),
            ("stand.toml", "squat.toml", None),
            ("run.urdf", "run.toml", None),
        ] {
            assert_eq!(super::slips(missing, other), slips, "{missing} and {other}");
        }
    }

    #[test]
    fn unreadable_files_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("walk.toml"), "a = 1").expect("written");
        std::fs::write(path("latin.toml"), [b'a', b'=', 0xe4]).expect("written");
        std::fs::write(path("huge.toml"), vec![b'#'; (LARGEST + 1) as usize]).expect("written");
        assert_eq!(read(&Disk, &path("walk.toml")).as_deref(), Ok("a = 1"));
        let missing = read(&Disk, &path("wlak.toml")).expect_err("missing");
        assert_eq!(missing.code, "E0004");
        assert_eq!(missing.help, ["there is a file `walk.toml` in that folder"]);
        assert_eq!(read(&Disk, folder.path()).expect_err("a folder").code, "E0006");
        std::os::unix::fs::symlink("nowhere.toml", path("link.toml")).expect("a link");
        let dangling = read(&Disk, &path("link.toml")).expect_err("it leads nowhere");
        assert_eq!(dangling.help, ["it is a symlink to a missing file"]);
        let huge = read(&Disk, &path("huge.toml")).expect_err("too large");
        assert!(
            huge.code == "E0006"
                && huge.message.ends_with("it has 1048577 bytes, more than the 1 MiB allowed")
        );
        assert_eq!(read(&Disk, &path("latin.toml")).expect_err("bytes").code, "E0005");
    }
}
