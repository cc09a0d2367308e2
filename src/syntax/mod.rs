//! TOML to a spanned tree, inheritance, and assignments. Independent of robots.

pub mod assign;
pub mod file;
pub mod files;
pub mod merge;
pub mod parse;
pub mod snapshot;
pub mod tree;

pub use files::{Disk, Files, Nowhere, Overlay};
pub use merge::{Forms, merge};
pub use parse::{literal, parse, parse_value};
pub use snapshot::Snapshot;
pub use tree::{Entry, Item, Layer, Map, Node, Number};
