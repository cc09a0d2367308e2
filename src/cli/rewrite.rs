//! What the commands that rewrite files share: showing what would change.

use std::path::Path;

use similar::TextDiff;

/// What would change in a file, as `diff -u` prints it.
pub fn difference(path: &Path, before: &str, after: &str) -> String {
    let (old, new) = (path.display().to_string(), format!("{} (rewritten)", path.display()));
    TextDiff::from_lines(before, after).unified_diff().context_radius(2).header(&old, &new).to_string()
}
