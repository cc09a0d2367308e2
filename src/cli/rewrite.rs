//! What the commands that rewrite files share: writing in one step, and showing what would change.

use std::io::Write;
use std::path::Path;

use similar::TextDiff;

/// Writes a file in one step: whoever reads it sees the old text or the new. A link stays a link.
pub fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let target = std::fs::canonicalize(path)?;
    let permissions = std::fs::metadata(&target)?.permissions();
    let mut file = tempfile::NamedTempFile::new_in(folder(&target))?;
    file.write_all(text.as_bytes())?;
    file.as_file().set_permissions(permissions)?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    Ok(())
}

/// Writes a file that is not there yet; an error of the kind `AlreadyExists` when it is.
pub fn create(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = std::fs::OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(text.as_bytes())
}

/// What would change in a file, as `diff -u` prints it.
pub fn difference(path: &Path, before: &str, after: &str) -> String {
    let (old, new) = (path.display().to_string(), format!("{} (rewritten)", path.display()));
    TextDiff::from_lines(before, after).unified_diff().context_radius(2).header(&old, &new).to_string()
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
