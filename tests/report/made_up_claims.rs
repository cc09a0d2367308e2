//! The claims of a made-up suite.

use specforge::diag::{Sink, Sources};
use specforge::spec::claim::{self, Claim};
use specforge::syntax::{Item, parse};

/// Reads the `[[claim]]` tables of a text.
pub fn decoded(text: &str) -> Vec<Claim> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let document = parse(&sources, source, &mut sink).expect("TOML");
    let Some(Item::List(nodes)) = document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
    else {
        panic!("a list of claims");
    };
    nodes.iter().map(|node| claim::decode(node, &mut sink).expect("a sound claim")).collect()
}
