//! Inheritance on trees: tables merge by key, arrays and scalars replace, and a changed `kind`
//! replaces the whole table.

use std::collections::btree_map::Entry as Place;

use super::tree::{Entry, Item, Map, Node};

/// Merges `child` over `parent`. Values of the child win.
pub fn merge(parent: &mut Map, child: &Map) {
    merge_at(parent, child, 0);
}

fn merge_at(parent: &mut Map, child: &Map, depth: usize) {
    for (key, entry) in &child.entries {
        match parent.entries.entry(key.clone()) {
            Place::Vacant(place) => {
                place.insert(entry.clone());
            }
            Place::Occupied(mut place) => merge_entry(place.get_mut(), key, entry, depth),
        }
    }
}

fn merge_entry(old: &mut Entry, key: &str, new: &Entry, depth: usize) {
    let same = old.node.span == new.node.span && old.node == new.node;
    if same {
        return;
    }
    match (&mut old.node.item, &new.node.item) {
        (Item::Table(below), Item::Table(above)) if !kind_changes(below, above, key, depth) => {
            merge_at(below, above, depth + 1);
            below.inherited = true;
            old.key = new.key;
            old.node.span = new.node.span;
            old.node.layer = new.node.layer;
        }
        _ => {
            let table = old.node.table().is_some();
            *old = new.clone();
            if let Some(map) = old.node.table_mut() {
                map.inherited = table;
            }
        }
    }
}

/// Whether a table says that it is of another kind than the one below it. Named terms (one level
/// below their section) are of the kind of their name unless they say otherwise.
fn kind_changes(below: &Map, above: &Map, key: &str, depth: usize) -> bool {
    let named = (depth == 1).then_some(key);
    let Some(above) = above.get("kind").and_then(Node::text) else {
        return false;
    };
    match below.get("kind").and_then(Node::text).or(named) {
        Some(below) => below != above,
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::diag::{Sink, Sources};
    use crate::syntax::parse;

    fn tree(sources: &mut Sources, text: &str) -> Map {
        let source = sources.add("a.toml", text);
        let node = parse(sources, source, &mut Sink::default()).expect("valid TOML");
        node.table().expect("a table").clone()
    }

    fn merged(texts: &[&str]) -> Map {
        let mut sources = Sources::default();
        let mut result = Map::default();
        texts.iter().for_each(|text| merge(&mut result, &tree(&mut sources, text)));
        result
    }

    /// The tree without places, for comparison.
    fn shape(map: &Map) -> String {
        fn show(node: &Node) -> String {
            match &node.item {
                Item::Text(text) => format!("{text:?}"),
                Item::Number(number) => number.text.clone(),
                Item::Flag(flag) => flag.to_string(),
                Item::Datetime => "date".to_owned(),
                Item::List(items) => format!("[{}]", items.iter().map(show).collect::<Vec<_>>().join(",")),
                Item::Table(map) => shape(map),
            }
        }
        let entries = map.entries.iter().map(|(key, entry)| format!("{key}={}", show(&entry.node)));
        format!("{{{}}}", entries.collect::<Vec<_>>().join(","))
    }

    #[test]
    fn tables_merge_and_lists_and_scalars_replace() {
        let result = merged(&["a = 1\n[t]\nx = [1, 2]\ny = 2", "[t]\nx = [3]\nz = 4"]);
        assert_eq!(shape(&result), "{a=1,t={x=[3],y=2,z=4}}");
    }

    #[test]
    fn a_changed_kind_replaces_the_whole_table() {
        let result = merged(&["[action]\nkind = \"position\"\nstiffness = 1", "[action]\nkind = \"torque\"\nstd = 2"]);
        assert_eq!(shape(&result), "{action={kind=\"torque\",std=2}}");
    }

    #[test]
    fn the_same_kind_merges_whether_it_is_said_or_is_the_terms_name() {
        let result = merged(&["[reward.torque]\nweight = 1\nk = 2", "[reward.torque]\nkind = \"torque\"\nweight = 3"]);
        assert_eq!(shape(&result), "{reward={torque={k=2,kind=\"torque\",weight=3}}}");
        let result = merged(&["[reward.torque]\nweight = 1\nk = 2", "[reward.torque]\nkind = \"speed\"\nweight = 3"]);
        assert_eq!(shape(&result), "{reward={torque={kind=\"speed\",weight=3}}}");
    }

    #[test]
    fn a_first_kind_completes_a_section_without_one() {
        let result = merged(&["[task]\nepisode = 1", "[task]\nkind = \"run\""]);
        assert_eq!(shape(&result), "{task={episode=1,kind=\"run\"}}");
    }

    #[test]
    fn only_tables_over_tables_are_inherited() {
        let result = merged(&["[reward.a]\nweight = 1", "[reward.a]\nenabled = false\n[reward.b]\nenabled = false"]);
        let reward = result.get("reward").and_then(Node::table).expect("a table");
        assert!(reward.get("a").and_then(Node::table).expect("a").inherited);
        assert!(!reward.get("b").and_then(Node::table).expect("b").inherited);
    }

    /// Small random documents over few keys, so that they collide.
    fn document() -> impl Strategy<Value = String> {
        proptest::collection::btree_map((0..3usize, 0..3usize), 0..9u8, 0..7).prop_map(|cells| {
            cells.iter().map(|((table, key), value)| format!("t{table}.k{key} = {value}\n")).collect()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn merging_is_idempotent_and_associative(a in document(), b in document(), c in document()) {
            prop_assert_eq!(shape(&merged(&[&a, &a])), shape(&merged(&[&a])));
            prop_assert_eq!(shape(&merged(&[&a, &b, &b])), shape(&merged(&[&a, &b])));
            let mut sources = Sources::default();
            let (mut right, above) = (tree(&mut sources, &b), tree(&mut sources, &c));
            merge(&mut right, &above);
            let mut left = tree(&mut sources, &a);
            merge(&mut left, &right);
            prop_assert_eq!(shape(&left), shape(&merged(&[&a, &b, &c])));
        }
    }
}
