//! Which existing files a command may replace: those that it wrote itself, earlier.

use std::fs;
use std::path::Path;

use super::{Exit, Global, output};
use crate::{bounded, escape};

/// Refuses a file that exists and is not what the command writes (`what`: `a saved plan`), so that a mistyped
/// name costs nothing. Empty files and pipes are accepted. Reports the error; `Err` is the exit code.
pub fn allowed(
    path: &Path,
    what: &str,
    is_own: impl FnOnce(&str) -> bool,
    advice: &str,
    global: &Global,
) -> Result<(), Exit> {
    if is_free(path, is_own) {
        return Ok(());
    }
    let message = format!("`{}` exists and is not {what}; nothing was written", escape::file(path));
    output::complain(global, &message, Some(advice));
    Err(Exit::Usage)
}

/// Whether writing to a path loses no work: nothing is there, or a file that the command wrote.
fn is_free(path: &Path, is_own: impl FnOnce(&str) -> bool) -> bool {
    match fs::metadata(path) {
        Ok(found) if found.is_file() && found.len() > 0 => {
            bounded::text(path, bounded::RECORD).is_ok_and(|text| is_own(&text))
        }
        // The writing itself reports folders, dangling links and folders without permission.
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_command_wrote_is_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        let is_own = |text: &str| text == "own";
        assert!(is_free(&path, is_own), "nothing is there");
        for (content, free) in [(&b"own"[..], true), (b"", true), (b"other", false), (b"\xff", false)] {
            fs::write(&path, content).expect("it can be written");
            assert_eq!(is_free(&path, is_own), free, "{content:?}");
        }
        assert!(is_free(Path::new("/dev/null"), is_own));
    }
}
