//! The canonical form of a file: what `specforge fmt` writes. Moves whole lines and aligns them; knows
//! nothing of what a value means, and leaves the text of every value and comment as it is.
//!
//! * The keys before the first table, the sections and the keys of a table stand in the order of the
//!   registries; named terms stay in their author's order. Keys change places only within lines that stand
//!   directly below each other: a blank line or a line of comment is never crossed.
//! * `=` is aligned within such a group, but for robot files, which programs write. Comments behind code
//!   begin in column 47, or two spaces behind longer code.
//! * A section is set off from the one before by a blank line; several blank lines become one.
//! * Line ends are those of the file's first line, a file ends with one of them, and indentation goes.

mod lines;
mod order;
mod print;

pub use order::Order;

use crate::syntax::{Map, Node};

/// What a file describes, which decides the order of its keys.
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
    /// What a document describes, by its keys; `None` for a file of someone else.
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

/// The canonical form of a text that is TOML.
pub fn format(text: &str, sort: Sort, order: &Order) -> String {
    let mut document = lines::read(text);
    document.arrange(&order.ranking(sort, &document));
    print::print(&document, sort.aligns())
}

#[cfg(test)]
mod tests;
