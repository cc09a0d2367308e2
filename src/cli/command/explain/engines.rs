//! Physics engines: what `list engines` says of one, and how a spec names it.

use serde_json::json;

use super::Page;
use crate::sim::EngineName;

/// The page of an engine: `batch`.
pub fn page(word: &str) -> Option<Page> {
    let engine = EngineName::named(word)?;
    let facts = engine.facts();
    let text = format!(
        "# {word}\n\nA physics engine: {}.\n\nContacts: {}.\n\nIts numbers are those of {}.\n\nSet with \
         `physics.engine = \"{word}\"` for the training, `fine_tune.engine` for a fine-tuning, and `engine` \
         in a table of `[evaluate]` or `[deploy]`. `specforge evaluate POLICY --engine {word}` evaluates a \
         policy in it.\n",
        facts.summary, facts.contacts, facts.numbers
    );
    Some(Page { what: "engine", name: word.to_owned(), text, facts: json!({ "contacts": facts.contacts }) })
}
