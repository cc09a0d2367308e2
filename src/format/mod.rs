//! The canonical form of a file: the output of `specforge fmt`. Moves whole lines and aligns them; values and
//! comments keep their text.
//!
//! * The keys before the first table, the sections and the keys of a table are in the order of the
//!   registries; named terms keep their author's order. Keys are sorted only within adjacent lines: a blank
//!   line or a line of comment is never crossed.
//! * `=` is aligned within such a group, except in robot files, which programs write. Comments after code
//!   begin in column 47, or two spaces after longer code.
//! * A blank line separates a section from the previous one; several blank lines become one.
//! * Line endings are that of the file's first line, a file ends with one, and indentation is removed.

mod lines;
mod order;
mod print;

pub use order::Order;

use crate::syntax::{Map, Node};

/// What a file describes, which determines the order of its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    /// An experiment or a parent of experiments.
    Spec,
    /// A suite of experiments.
    Suite,
    /// A robot.
    Robot,
    /// A reference motion.
    Motion,
}

impl Sort {
    /// What a document describes, by its keys; `None` if it is not a file of specforge.
    pub fn of(document: &Map) -> Option<Self> {
        let has = |key: &str| document.get(key).is_some();
        match () {
            () if has("spec") && (has("suite") || has("sweep") || has("claim")) => Some(Self::Suite),
            () if has("spec") => Some(Self::Spec),
            () if has("links") && has("base") => Some(Self::Robot),
            () if document.get("kind").and_then(Node::text).is_some() => Some(Self::Motion),
            () => None,
        }
    }

    /// Whether `=` is aligned.
    fn aligns(self) -> bool {
        self != Self::Robot
    }
}

/// The canonical form of valid TOML.
pub fn format(text: &str, sort: Sort, order: &Order) -> String {
    let mut document = lines::read(text);
    document.arrange(&order.ranking(sort, &document));
    print::print(&document, sort.aligns())
}

#[cfg(test)]
mod tests;
