//! Escaping of untrusted text: a summary, joint name or manifest may contain terminal controls, markup or
//! bidirectional text. There is one file per output format. Text is escaped where it leaves the program, not
//! where it is composed.

pub mod graph;
mod hidden;
pub mod markdown;
pub mod shell;
pub mod terminal;
pub mod toml;
pub mod xml;

use std::path::Path;

pub use hidden::is_hidden;

/// A file name for use between backquotes in a message; escapes backquotes in the name.
pub fn file(path: &Path) -> String {
    path.display().to_string().replace('`', "\\u0060")
}
