//! Reads text files for the front half: missing files (E0004), bytes that are not UTF-8 (E0005), folders and
//! unreasonably large files (E0006), pipes and devices (E0007) are diagnostics, not panics.

use std::path::Path;

use super::files::Files;
use crate::bounded::{ReadError, WRITTEN as LARGEST};
use crate::diag::Diagnostic;

/// Reads a text. The diagnostic has no place yet; the caller knows who asked for the file.
pub fn read(files: &dyn Files, path: &Path) -> Result<String, Diagnostic> {
    let bytes = files.bytes(path, LARGEST).map_err(|error| refused(files, path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        refused(files, path, &ReadError::NotUtf8 { at })
    })
}

/// The diagnostic for a text that was not read.
pub fn refused(files: &dyn Files, path: &Path, error: &ReadError) -> Diagnostic {
    let shown = path.display();
    let unreadable = |code| Diagnostic::error(code, format!("cannot read `{shown}`: {error}"));
    match error {
        ReadError::Folder => unreadable("E0006").help("name a .toml file in it"),
        ReadError::Special(_) => unreadable("E0007").help("name a regular file"),
        ReadError::NotUtf8 { at } => Diagnostic::error("E0005", format!("`{shown}` is not UTF-8 (byte {at})"))
            .help("save the file as UTF-8 text"),
        _ if error.is_absence() => {
            let diagnostic = Diagnostic::error("E0004", format!("file not found: `{shown}`"));
            match neighbour(files, path) {
                Some(name) if path.file_name().is_some_and(|own| *own == *name) => {
                    diagnostic.help("it is a link, and the file that it names is missing")
                }
                Some(name) => diagnostic.help(format!("there is a file `{name}` in that folder")),
                None => diagnostic.help(
                    "a path in a spec begins at the folder of that spec, one in a terminal at the current folder",
                ),
            }
        }
        _ => unreadable("E0006"),
    }
}

/// A file in the folder of a missing one whose name is close to it.
fn neighbour(files: &dyn Files, path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let distance = |other: &String| strsim::damerau_levenshtein(name, other);
    let near = |other: &String| name.len().abs_diff(other.len()) <= 12 && distance(other) <= 3;
    files.names(path.parent()?).into_iter().filter(near).min_by_key(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::Disk;

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
        assert_eq!(dangling.help, ["it is a link, and the file that it names is missing"]);
        let huge = read(&Disk, &path("huge.toml")).expect_err("too large");
        assert!(huge.code == "E0006" && huge.message.ends_with("it has 1048577 bytes, more than the 1 MiB allowed"));
        assert_eq!(read(&Disk, &path("latin.toml")).expect_err("bytes").code, "E0005");
    }
}
