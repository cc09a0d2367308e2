//! Shared by the commands that rewrite files: displays the changes.

use std::path::Path;

use similar::TextDiff;

/// The changes to a file in the format of `diff -u`.
pub fn difference(path: &Path, before: &str, after: &str) -> String {
    let (old, new) = (path.display().to_string(), format!("{} (rewritten)", path.display()));
    TextDiff::from_lines(before, after).unified_diff().context_radius(2).header(&old, &new).to_string()
}
