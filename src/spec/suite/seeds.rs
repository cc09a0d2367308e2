//! `sweep.seeds`: the learning seeds of every arm, a count or a list.

use super::wrong_type;
use crate::diag::{Diagnostic, Sink, Span};
use crate::syntax::{Item, Node, Number};

/// Maximum number of seeds.
const MOST: i64 = 1000;

/// A learning seed and its place.
pub type Seed = (u64, Span);

/// Decodes the seeds: `3` is 1, 2, 3.
pub fn decode(node: &Node, sink: &mut Sink) -> Option<Vec<Seed>> {
    match &node.item {
        Item::Number(Number { whole: Some(0), .. }) => {
            sink.emit(empty(node.span));
            None
        }
        Item::Number(Number { whole: Some(count @ 1..=MOST), .. }) => {
            Some((1..=*count as u64).map(|seed| (seed, node.span)).collect())
        }
        Item::Number(Number { whole: Some(count), .. }) => {
            let error = Diagnostic::error("E0204", format!("`sweep.seeds` is out of range: {count}"));
            sink.emit(
                error
                    .at(node.span, format!("from 1 to {MOST}"))
                    .help("for particular seeds write a list: `[7]`"),
            );
            None
        }
        Item::List(items) if items.is_empty() => {
            sink.emit(empty(node.span));
            None
        }
        Item::List(items) if items.len() as i64 > MOST => {
            let error = Diagnostic::error("E0204", format!("`sweep.seeds` has {} seeds", items.len()));
            sink.emit(error.at(node.span, format!("at most {MOST}")).help("split the suite"));
            None
        }
        Item::List(items) => list(items, sink),
        _ => {
            let error = wrong_type("sweep.seeds", "a number of seeds or a list of seeds", node);
            sink.emit(error.help("write `seeds = 3` for the seeds 1, 2 and 3, or `seeds = [1, 5, 7]`"));
            None
        }
    }
}

fn empty(place: Span) -> Diagnostic {
    let error =
        Diagnostic::error("E0703", "the sweep has no seeds").at(place, "at least one seed is required");
    error.help("write `seeds = 1`, or leave `seeds` out for the seed of each spec")
}

fn list(items: &[Node], sink: &mut Sink) -> Option<Vec<Seed>> {
    let mut seeds: Vec<Seed> = Vec::new();
    let mut sound = true;
    for item in items {
        let Item::Number(Number { whole: Some(seed @ 0..), .. }) = item.item else {
            sink.emit(wrong_type("sweep.seeds", "whole numbers from 0", item));
            sound = false;
            continue;
        };
        let seed = seed as u64;
        if let Some((_, first)) = seeds.iter().find(|(known, _)| *known == seed) {
            let error = Diagnostic::error("E0705", format!("duplicate learning seed {seed}"));
            let error = error.at(item.span, "again here").note(*first, "first here");
            sink.emit(error.help("use another seed: a repeated seed gives the same run"));
            sound = false;
        }
        seeds.push((seed, item.span));
    }
    sound.then_some(seeds)
}
