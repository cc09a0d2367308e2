//! Reads text files for the front half: missing files (E0004), bytes that are not UTF-8 (E0005), folders and
//! unreasonably large files (E0006) are diagnostics, not panics.

use std::path::Path;

use super::files::{Files, Sort};
use crate::diag::Diagnostic;

/// Specs and robots are a few kilobytes; a file beyond this is something else.
pub const LARGEST: u64 = 1 << 20;

/// Reads a text. The diagnostic has no place yet; the caller knows who asked for the file.
pub fn read(files: &dyn Files, path: &Path) -> Result<String, Diagnostic> {
    let shown = path.display();
    let unreadable = |why: &str| Diagnostic::error("E0006", format!("cannot read `{shown}`: {why}"));
    let size = match files.sort(path) {
        Ok(Sort::File(size)) => size,
        Ok(Sort::Folder) => return Err(unreadable("it is a folder").help("name a .toml file in it")),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let diagnostic = Diagnostic::error("E0004", format!("file not found: `{shown}`"));
            return Err(match neighbour(files, path) {
                Some(name) => diagnostic.help(format!("there is a file `{name}` in that folder")),
                None => diagnostic.help(
                    "a path in a spec begins at the folder of that spec, one in a terminal at the current folder",
                ),
            });
        }
        Err(error) => return Err(unreadable(&error.to_string())),
    };
    if size > LARGEST {
        let size = size as f64 / (1 << 20) as f64;
        return Err(unreadable(&format!("it has {size:.1} MiB; a spec has at most 1 MiB")));
    }
    let bytes = files.bytes(path).map_err(|error| unreadable(&error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Diagnostic::error("E0005", format!("`{shown}` is not UTF-8 (byte {at})")).help("save the file as UTF-8 text")
    })
}

/// A file in the folder of a missing one whose name is close to it.
fn neighbour(files: &dyn Files, path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let distance = |other: &String| strsim::damerau_levenshtein(name, other);
    let near = files.names(path.parent()?).into_iter().min_by_key(distance)?;
    (distance(&near) <= 3).then_some(near)
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
        let huge = read(&Disk, &path("huge.toml")).expect_err("too large");
        assert!(huge.code == "E0006" && huge.message.contains("at most 1 MiB"));
        assert_eq!(read(&Disk, &path("latin.toml")).expect_err("bytes").code, "E0005");
    }
}
