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

pub use hidden::is_hidden;
