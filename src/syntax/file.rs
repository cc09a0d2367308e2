//! Reads text files for the front half: missing (E0004), not UTF-8 (E0005) and unreasonably large
//! files are diagnostics, not panics.

use std::path::Path;

use crate::diag::Diagnostic;

/// Specs and robots are a few kilobytes; a file beyond this is something else.
pub const LARGEST: u64 = 1 << 20;

/// Reads a text. The diagnostic has no place yet; the caller knows who asked for the file.
pub fn read(path: &Path) -> Result<String, Diagnostic> {
    let shown = path.display();
    let missing = |why: &str| Diagnostic::error("E0004", format!("cannot read `{shown}`: {why}"));
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let diagnostic = Diagnostic::error("E0004", format!("file not found: `{shown}`"));
            return Err(match neighbour(path) {
                Some(name) => diagnostic.help(format!("there is a file `{name}` in that folder")),
                None => diagnostic,
            });
        }
        Err(error) => return Err(missing(&error.to_string())),
    };
    if metadata.is_dir() {
        return Err(missing("it is a folder").help("name a .toml file in it"));
    }
    if metadata.len() > LARGEST {
        let size = metadata.len() as f64 / (1 << 20) as f64;
        return Err(missing(&format!("it has {size:.1} MiB; a spec has at most 1 MiB")));
    }
    let bytes = std::fs::read(path).map_err(|error| missing(&error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Diagnostic::error("E0005", format!("`{shown}` is not UTF-8 (byte {at})")).help("save the file as UTF-8 text")
    })
}

/// A file in the folder of a missing one whose name is close to it.
fn neighbour(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut names: Vec<String> =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let distance = |other: &String| strsim::damerau_levenshtein(name, other);
    let near = names.into_iter().min_by_key(distance)?;
    (distance(&near) <= 3).then_some(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unreadable_files_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("walk.toml"), "a = 1").expect("written");
        std::fs::write(path("latin.toml"), [b'a', b'=', 0xe4]).expect("written");
        std::fs::write(path("huge.toml"), vec![b'#'; (LARGEST + 1) as usize]).expect("written");
        assert_eq!(read(&path("walk.toml")).as_deref(), Ok("a = 1"));
        let missing = read(&path("wlak.toml")).expect_err("missing");
        assert_eq!(missing.code, "E0004");
        assert_eq!(missing.help, ["there is a file `walk.toml` in that folder"]);
        assert_eq!(read(folder.path()).expect_err("a folder").code, "E0004");
        assert!(read(&path("huge.toml")).expect_err("too large").message.contains("at most 1 MiB"));
        assert_eq!(read(&path("latin.toml")).expect_err("bytes").code, "E0005");
    }
}
