//! Texts of unknown origin, written so that they do nothing where they are shown: a summary, a joint's name
//! or a manifest may hold terminal controls, markup or text that runs backwards. One file per outlet; each is
//! applied where text leaves the program, not where it is composed.

pub mod graph;
mod hidden;
pub mod markdown;
pub mod shell;
pub mod terminal;
pub mod toml;
pub mod xml;

use std::path::Path;

pub use hidden::is_hidden;

/// A file's name as it stands between backquotes in a message: a backquote of its own does not end it there.
pub fn file(path: &Path) -> String {
    path.display().to_string().replace('`', "\\u0060")
}
