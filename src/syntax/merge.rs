//! Inheritance on trees: tables merge by key, arrays and scalars replace, and a changed `kind` replaces the
//! whole table.

use super::tree::{Entry, Item, Map, Node};

/// Key sets of tables that are alternative forms of one value, such as `{ uniform = ... }` and `{ normal =
/// ... }`. A form replaces another form instead of merging with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forms {
    /// For each value, the keys of each of its forms.
    pub values: Vec<Vec<Vec<&'static str>>>,
    /// Keys inside sections that contain named terms, as a section does: `evaluate.NAME.randomize`.
    pub terms: Vec<&'static str>,
}

impl Forms {
    /// Whether both tables are forms of the same value, and different ones.
    fn differ(&self, below: &Map, above: &Map) -> bool {
        let form = |forms: &[Vec<&str>], map: &Map| {
            let holds = |form: &Vec<&str>| map.entries.keys().all(|key| form.contains(&key.as_str()));
            (!map.entries.is_empty()).then(|| forms.iter().position(holds)).flatten()
        };
        self.values.iter().any(|forms| match (form(forms, below), form(forms, above)) {
            (Some(below), Some(above)) => below != above,
            _ => false,
        })
    }
}

/// Merges `child` over `parent`. Values of the child win.
pub fn merge(parent: &mut Map, child: &Map, forms: &Forms) {
    merge_at(parent, child, forms, Place { depth: 0, terms: false });
}

/// Position of the tables that are merged.
#[derive(Clone, Copy)]
struct Place {
    /// Sections have depth 0, named terms 1. The tables of a profile have the depth of the tables that they
    /// overlay.
    depth: i32,
    /// Whether the tables here are named terms inside a section.
    terms: bool,
}

fn merge_at(parent: &mut Map, child: &Map, forms: &Forms, place: Place) {
    for (key, entry) in &child.entries {
        match parent.entries.get_mut(key) {
            None => {
                parent.entries.insert(key.clone(), entry.clone());
            }
            Some(old) => merge_entry(old, key, entry, forms, place),
        }
    }
}

fn merge_entry(old: &mut Entry, key: &str, new: &Entry, forms: &Forms, place: Place) {
    let same = old.node.span == new.node.span && old.node == new.node;
    if same {
        return;
    }
    match (&mut old.node.item, &new.node.item) {
        (Item::Table(below), Item::Table(above))
            if !kind_changes(below, above, key, place) && !forms.differ(below, above) =>
        {
            let depth = if place.depth == 0 && key == "profile" { -1 } else { place.depth + 1 };
            let terms = place.depth > 0 && forms.terms.contains(&key);
            merge_at(below, above, forms, Place { depth, terms });
            below.inherited = true;
            old.key = new.key;
            old.node.span = new.node.span;
            old.node.layer = new.node.layer;
        }
        _ => {
            let replaced = old.node.table().map(|below| {
                let keys =
                    below.entries.iter().map(|(key, entry)| (key.clone(), (entry.key, entry.node.toml())));
                keys.chain(below.replaced.clone()).collect()
            });
            *old = new.clone();
            if let (Some(map), Some(replaced)) = (old.node.table_mut(), replaced) {
                map.inherited = true;
                map.replaced = replaced;
            }
        }
    }
}

/// Whether a table has another kind than the one below it. The kind of a named term (one level below its
/// section, or below a key that contains terms) is its name unless it sets `kind`.
fn kind_changes(below: &Map, above: &Map, key: &str, place: Place) -> bool {
    let named = (place.depth == 1 || place.terms).then_some(key);
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

    fn forms() -> Forms {
        let values =
            vec![vec![vec!["uniform"], vec!["normal"]], vec![vec!["linear"], vec!["target", "start"]]];
        Forms { values, terms: vec!["randomize"] }
    }

    fn merged(texts: &[&str]) -> Map {
        let mut sources = Sources::default();
        let mut result = Map::default();
        texts.iter().for_each(|text| merge(&mut result, &tree(&mut sources, text), &forms()));
        result
    }

    /// The tree without locations, for comparison.
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
        let result =
            merged(&["[action]\nkind = \"position\"\nstiffness = 1", "[action]\nkind = \"torque\"\nstd = 2"]);
        assert_eq!(shape(&result), "{action={kind=\"torque\",std=2}}");
    }

    #[test]
    fn the_same_kind_merges_whether_it_is_said_or_is_the_terms_name() {
        let result =
            merged(&["[reward.torque]\nweight = 1\nk = 2", "[reward.torque]\nkind = \"torque\"\nweight = 3"]);
        assert_eq!(shape(&result), "{reward={torque={k=2,kind=\"torque\",weight=3}}}");
        let result =
            merged(&["[reward.torque]\nweight = 1\nk = 2", "[reward.torque]\nkind = \"speed\"\nweight = 3"]);
        assert_eq!(shape(&result), "{reward={torque={kind=\"speed\",weight=3}}}");
    }

    #[test]
    fn terms_inside_a_section_are_of_the_kind_of_their_name_too() {
        let parent = "[evaluate.box.randomize.push]\nimpulse = 1";
        let result = merged(&[parent, "[evaluate.box.randomize.push]\nkind = \"payload\"\nmass = 2"]);
        assert_eq!(shape(&result), "{evaluate={box={randomize={push={kind=\"payload\",mass=2}}}}}");
        let result = merged(&[parent, "[evaluate.box.randomize.push]\nkind = \"push\"\nat = 2"]);
        assert_eq!(shape(&result), "{evaluate={box={randomize={push={at=2,impulse=1,kind=\"push\"}}}}}");
        let result = merged(&[
            "[profile.a.evaluate.box.randomize.push]\nimpulse = 1",
            "[profile.a.evaluate.box.randomize.push]\nkind = \"payload\"",
        ]);
        assert_eq!(shape(&result), "{profile={a={evaluate={box={randomize={push={kind=\"payload\"}}}}}}}");
    }

    #[test]
    fn a_first_kind_completes_a_section_without_one() {
        let result = merged(&["[task]\nepisode = 1", "[task]\nkind = \"run\""]);
        assert_eq!(shape(&result), "{task={episode=1,kind=\"run\"}}");
    }

    #[test]
    fn another_form_of_a_value_replaces_and_the_same_form_merges() {
        let result = merged(&["x.noise = { uniform = 1 }", "x.noise = { normal = 2 }"]);
        assert_eq!(shape(&result), "{x={noise={normal=2}}}");
        let result =
            merged(&["x.rate = { linear = 1 }", "x.rate = { target = 1, start = 2 }", "x.rate.start = 3"]);
        assert_eq!(shape(&result), "{x={rate={start=3,target=1}}}");
    }

    #[test]
    fn sections_of_a_profile_merge_as_sections_do() {
        let result = merged(&["[profile.a.pretrain]\nx = 1", "[profile.a.pretrain]\nkind = \"tracking\""]);
        assert_eq!(shape(&result), "{profile={a={pretrain={kind=\"tracking\",x=1}}}}");
    }

    #[test]
    fn only_tables_over_tables_are_inherited() {
        let result =
            merged(&["[reward.a]\nweight = 1", "[reward.a]\nenabled = false\n[reward.b]\nenabled = false"]);
        let reward = result.get("reward").and_then(Node::table).expect("a table");
        assert!(reward.get("a").and_then(Node::table).expect("a").inherited);
        assert!(!reward.get("b").and_then(Node::table).expect("b").inherited);
    }

    /// Small random documents over few keys, so that keys collide.
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
            merge(&mut right, &above, &forms());
            let mut left = tree(&mut sources, &a);
            merge(&mut left, &right, &forms());
            prop_assert_eq!(shape(&left), shape(&merged(&[&a, &b, &c])));
        }
    }
}
