//! Laws of the language, on random inputs: what is printed is read again, units multiply as dimensions do,
//! values survive TOML, and the order of keys and the comments of a spec mean nothing.

use std::path::Path;

use proptest::prelude::*;
use specforge::check::checked_in;
use specforge::diag::{Sink, SourceId};
use specforge::quantity::{Dimension, parse, print, print_ratio, quantity_of, unit};
use specforge::spec::LoadOptions;
use specforge::spec::value::canonical_table;
use specforge::syntax::{Forms, Item, Node, Nowhere, Overlay, merge, parse_value};

/// A table as it is drawn: its section, its kind and its keys with their values.
type Drawn = (usize, Option<usize>, std::collections::BTreeMap<usize, u8>);

fn close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}

/// A unit with a power, as text, and what it should mean.
fn factor() -> impl Strategy<Value = (String, Dimension, f64)> {
    let symbols = prop::sample::select(vec![
        "m", "kg", "ms", "N", "rad", "deg", "Hz", "rpm", "W", "cm", "kN", "V", "A", "min",
    ]);
    (symbols, 1i8..4).prop_map(|(symbol, power)| {
        let one = parse::quantity(&format!("1 {symbol}")).expect("a unit of the list");
        let text = if power == 1 { symbol.to_owned() } else { format!("{symbol}^{power}") };
        let dimension = Dimension::NONE.times(one.dimension, power).expect("small powers");
        (text, dimension, one.si.powi(i32::from(power)))
    })
}

/// A TOML value of limited depth, without dates.
fn value() -> impl Strategy<Value = toml::Value> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(toml::Value::Boolean),
        any::<i64>().prop_map(toml::Value::Integer),
        any::<f64>()
            .prop_filter("TOML's own nan has no sign to compare", |x| !x.is_nan())
            .prop_map(toml::Value::Float),
        ".*".prop_map(toml::Value::String),
    ];
    leaf.prop_recursive(3, 24, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(toml::Value::Array),
            prop::collection::btree_map("[a-z ._\"é-]{0,6}", inner, 0..4)
                .prop_map(|map| toml::Value::Table(map.into_iter().collect())),
        ]
    })
}

/// The value of a node, without places.
fn bare(node: &Node) -> toml::Value {
    match &node.item {
        Item::Text(text) => toml::Value::String(text.clone()),
        Item::Number(number) => number.whole.map_or(toml::Value::Float(number.value), toml::Value::Integer),
        Item::Flag(flag) => toml::Value::Boolean(*flag),
        Item::Datetime => unreachable!("the values have no dates"),
        Item::List(items) => toml::Value::Array(items.iter().map(bare).collect()),
        Item::Table(map) => toml::Value::Table(
            map.entries.iter().map(|(key, entry)| (key.clone(), bare(&entry.node))).collect(),
        ),
    }
}

fn read(text: &str) -> Node {
    parse_value(text, SourceId(0), 0).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// A small tree with kinds and terms, as TOML.
fn document() -> impl Strategy<Value = String> {
    let term = (0..3usize, prop::option::of(0..3usize), prop::collection::btree_map(0..3usize, 0..9u8, 0..3));
    prop::collection::btree_map(0..3usize, term, 0..4).prop_map(|terms| {
        let one = |(name, (section, kind, keys)): (usize, Drawn)| {
            let kind = kind.map(|kind| format!("kind = \"n{kind}\"\n")).unwrap_or_default();
            let keys: String = keys.into_iter().map(|(key, value)| format!("k{key} = {value}\n")).collect();
            format!("[s{section}.n{name}]\n{kind}{keys}")
        };
        terms.into_iter().map(one).collect()
    })
}

fn tree(text: &str) -> specforge::syntax::Map {
    let (mut sources, mut sink) = (specforge::diag::Sources::default(), Sink::default());
    let source = sources.add("a.toml", text);
    let node = specforge::syntax::parse(&sources, source, &mut sink).expect("valid TOML");
    node.table().expect("a document is a table").clone()
}

fn merged(texts: &[&str]) -> toml::Value {
    let mut result = specforge::syntax::Map::default();
    texts.iter().for_each(|text| merge(&mut result, &tree(text), &Forms::default()));
    let span = specforge::diag::Span { source: SourceId(0), start: 0, end: 0 };
    bare(&Node { span, layer: specforge::syntax::Layer::File, item: Item::Table(result) })
}

/// The blocks of the complete spec: a header line and its keys; profiles and comments are left out.
fn blocks() -> Vec<(String, Vec<String>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language/whole.toml");
    let text = std::fs::read_to_string(path).expect("whole.toml is readable");
    let mut blocks = vec![(String::new(), Vec::new())];
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        match line.strip_prefix('[') {
            Some(_) => blocks.push((line.to_owned(), Vec::new())),
            None => blocks.last_mut().expect("there is one").1.push(line.to_owned()),
        }
    }
    blocks
}

/// The canonical form of a spec that stands alone, from which fingerprints are made.
fn canonical(text: &str) -> String {
    let mut files = Overlay::new(Nowhere);
    files.hold(Path::new("spec.toml"), text);
    let checked = checked_in(&files, Path::new("spec.toml"), &LoadOptions::default());
    let (experiment, _) =
        checked.sound().unwrap_or_else(|| panic!("{:#?}\n{text}", checked.sink.diagnostics));
    canonical_table(&experiment.table).to_string()
}

proptest! {
    #[test]
    fn a_printed_quantity_is_read_as_the_same_number(
        si in any::<f64>().prop_filter("finite", |x| x.is_finite()),
        length in -3i8..4, mass in -2i8..3, time in -3i8..4, angle in -2i8..3,
    ) {
        let dimension = Dimension::new(length, mass, time, 0, angle);
        prop_assume!(dimension != Dimension::NONE);
        let text = print(si, dimension);
        match quantity_of(&text, dimension) {
            // A unit with a factor of its own (kg from g) may round once.
            Ok(read) => prop_assert!(close(read, si), "{text} is read as {read}"),
            Err(error) => prop_assert!(si.abs() > 1e300 || si.abs() < 1e-300, "{text}: {error}"),
        }
    }

    #[test]
    fn a_printed_ratio_is_read_as_the_same_ratio(ratio in -1e6f64..1e6) {
        let read = quantity_of(&print_ratio(ratio), Dimension::NONE).expect("a percentage");
        prop_assert!((read - ratio).abs() <= 1e-11 + 1e-12 * ratio.abs(), "{ratio} is read as {read}");
    }

    #[test]
    fn units_multiply_and_divide_as_their_dimensions_do((a, da, fa) in factor(), (b, db, fb) in factor()) {
        let product = parse::quantity(&format!("2 {a}*{b}")).expect("a product");
        prop_assert_eq!(Some(product.dimension), da.times(db, 1));
        prop_assert!(close(product.si, 2.0 * fa * fb));
        let quotient = parse::quantity(&format!("2 {a}/{b}")).expect("a quotient");
        prop_assert_eq!(Some(quotient.dimension), da.times(db, -1));
        prop_assert!(close(quotient.si, 2.0 * fa / fb));
        let swapped = parse::quantity(&format!("2 {b}*{a}")).expect("a product");
        prop_assert!(swapped.dimension == product.dimension && close(swapped.si, product.si));
        let inverse = parse::quantity(&format!("2 /{a}")).expect("an inverse");
        prop_assert_eq!(Some(inverse.dimension), Dimension::NONE.times(da, -1));
        let one = parse::quantity(&format!("2 {a}/{a}")).expect("a pure number");
        prop_assert!(one.dimension == Dimension::NONE && close(one.si, 2.0));
    }

    #[test]
    fn a_value_printed_as_toml_is_read_as_the_same_value(value in value()) {
        let node = read(&value.to_string());
        prop_assert_eq!(bare(&read(&node.toml())), bare(&node));
        prop_assert_eq!(bare(&node), value);
    }

    #[test]
    fn merging_twice_is_merging_once(a in document(), b in document()) {
        prop_assert_eq!(merged(&[&a, &b, &b]), merged(&[&a, &b]));
        prop_assert_eq!(merged(&[&a, &a]), merged(&[&a]));
        prop_assert_eq!(merged(&["", &a]), merged(&[&a, ""]));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_order_of_keys_and_tables_and_the_comments_mean_nothing(
        tables in Just(blocks()).prop_shuffle(), turn in 0usize..8, comment in "[ -~]{0,20}",
    ) {
        let tables: Vec<_> = tables.into_iter().filter(|(header,
                _)| !header.starts_with("[profile")).collect();
        let block = |(header, keys): &(String, Vec<String>)| {
            let turned = keys.iter().cycle().skip(turn).take(keys.len());
            let lines: String = turned.map(|line| format!("{line} # {comment}\n")).collect();
            format!("# {comment}\n{header}\n{lines}")
        };
        let (head, rest): (Vec<_>, Vec<_>) = tables.iter().partition(|(header, _)| header.is_empty());
        let text: String = head.into_iter().chain(rest).map(block).collect();
        let plain: String = blocks().iter().filter(|(header, _)| !header.starts_with("[profile"))
            .map(|(header, keys)| format!("{header}\n{}\n", keys.join("\n"))).collect();
        prop_assert_eq!(canonical(&text), canonical(&plain));
    }
}

#[test]
fn every_unit_of_the_list_is_read_with_its_dimension() {
    for unit in unit::UNITS {
        let parsed = parse::quantity(&format!("1 {}", unit.symbol)).expect("a unit of the list");
        assert_eq!(parsed.dimension, unit.dimension, "{}", unit.symbol);
    }
}
