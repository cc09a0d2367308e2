//! From one edition of the language to the next: a list of steps, each of which rewrites a document and says
//! what it did.
//!
//! Steps work on documents that keep comments, order and spelling, so a migrated file is its author's file.
//! Edition 1 is the first, so there is no step yet; the list is given as an argument, and the tests give one
//! of their own.

use toml_edit::{DocumentMut, Item, Value};

use crate::diag::{Diagnostic, Sink, SourceId, Sources, Span};
use crate::spec::Edition;
use crate::syntax::{self, Node};

/// The way from one edition to the next.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The edition that it takes; it leaves the next one.
    pub from: Edition,
    /// Rewrites a document and returns what it did, in the order of the file.
    pub apply: fn(&mut DocumentMut) -> Vec<Change>,
}

/// Something that a step did.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Change {
    /// The key or table, as it was named before.
    pub path: String,
    /// What became of it: `is now called stiffness`.
    pub what: String,
}

/// The steps of the language, oldest first.
pub static STEPS: &[Step] = &[];

/// A document in the newest edition.
#[derive(Clone, Debug, PartialEq)]
pub struct Migrated {
    /// The edition that the document was written in.
    pub from: Edition,
    /// The newest edition.
    pub to: Edition,
    /// The text.
    pub text: String,
    /// What was done.
    pub changes: Vec<Change>,
}

/// The edition that steps lead to.
pub fn newest(steps: &[Step]) -> Edition {
    steps.last().map_or(Edition::ONE, |step| Edition(step.from.0 + 1))
}

/// Brings a text that was added to the sources to the newest edition. `None` when it is not TOML (E0001) or
/// of no known edition (E0002, E0003); the diagnostics are in the sink then.
pub fn migrate(sources: &Sources, source: SourceId, steps: &[Step], sink: &mut Sink) -> Option<Migrated> {
    let node = syntax::parse(sources, source, sink)?;
    let to = newest(steps);
    let from = edition(&node, source, to).map_err(|error| sink.emit(*error)).ok()?;
    let text = &*sources.get(source).text;
    let mut changes = Vec::new();
    if from == to {
        return Some(Migrated { from, to, text: text.to_owned(), changes });
    }
    let mut document: DocumentMut = text.parse().ok()?;
    for step in steps.iter().filter(|step| step.from >= from) {
        changes.extend((step.apply)(&mut document));
        set_edition(&mut document, Edition(step.from.0 + 1));
    }
    Some(Migrated { from, to, text: document.to_string(), changes })
}

/// The edition of a document.
fn edition(node: &Node, source: SourceId, newest: Edition) -> Result<Edition, Box<Diagnostic>> {
    let top = Span { source, start: 0, end: 0 };
    let Some(written) = node.table().and_then(|map| map.get("spec")) else {
        let error = Diagnostic::error("E0002", "the edition is missing").at(top, "every spec begins with it");
        return Err(Box::new(error.help("add a first line `spec = 1`").fix(top, "spec = 1\n")));
    };
    let number = match &written.item {
        syntax::Item::Number(number) => number.whole.and_then(|whole| u32::try_from(whole).ok()),
        _ => None,
    };
    number.map(Edition).filter(|edition| *edition >= Edition::ONE && *edition <= newest).ok_or_else(|| {
        let error = Diagnostic::error("E0003", format!("unsupported edition {}", written.toml()));
        let known = format!("this program knows the editions up to {}", newest.0);
        Box::new(error.at(written.span, known).help("a newer specforge knows newer editions"))
    })
}

/// Writes the edition; the comment behind it stays.
fn set_edition(document: &mut DocumentMut, edition: Edition) {
    if let Some(Item::Value(value)) = document.get_mut("spec") {
        let decor = value.decor().clone();
        *value = Value::from(i64::from(edition.0));
        *value.decor_mut() = decor;
    }
}

#[cfg(test)]
mod tests;
