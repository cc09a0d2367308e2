//! Units: their dimensions and sizes, and the keys that use them.

use serde_json::json;

use super::Page;
use crate::kinds::keys::{Key, keys};
use crate::quantity::unit::{PREFIXES, UNITS, Unit, find};
use crate::quantity::{Dimension, quantity};

/// Maximum number of keys that a page lists.
const MOST: usize = 24;

/// The page of a unit in the notation of specs: `Hz`, `ms`, `rad/s`, `N*m`.
pub fn page(word: &str) -> Option<Page> {
    let parsed = quantity(&format!("1 {word}")).ok()?;
    let simple = find(word).and_then(|found| UNITS.iter().find(|unit| unit.symbol == found.symbol));
    let (size, dimension) = (parsed.si, parsed.dimension);
    let what = dimension.name();
    let mut text = match simple {
        Some(unit) => format!("# {word}\n\n{}, the unit of {what}.\n\n", unit.name),
        None => format!("# {word}\n\nA unit of {what}.\n\n"),
    };
    if dimension == Dimension::NONE {
        text = format!("# {word}\n\n{}.\n\n", simple.map_or("A pure number", |unit| unit.name));
        text += &format!("1 {word} is {size} of it.\n");
    } else if dimension.unit() == word {
        text += "It is the unit that specforge computes in.\n";
    } else {
        text += &format!("1 {word} is {size} {}.\n", dimension.unit());
    }
    if simple.is_some_and(|unit| unit.prefixed) {
        text += &format!("\nIt takes the prefixes {}.\n", prefixes());
    }
    let takers = takers(dimension);
    text += &list_of(&takers, &what);
    text += "\nQuantities are strings: a number, a space, units joined by `*` and `/`, integer powers after \
        `^`: `\"20 s^2/m^2\"`.\n";
    let paths: Vec<&str> = takers.iter().map(|key| key.path.as_str()).collect();
    let facts = json!({ "dimension": what, "si": dimension.unit(), "factor": size, "keys": paths });
    Some(Page { what: "unit", name: word.to_owned(), text, facts })
}

/// The keys whose values have this dimension.
fn takers(dimension: Dimension) -> Vec<Key> {
    let mut takers: Vec<Key> = keys().into_iter().filter(|key| key.has_dimension(dimension)).collect();
    takers.dedup_by(|key, before| key.path == before.path);
    takers
}

fn list_of(takers: &[Key], what: &str) -> String {
    if takers.is_empty() {
        return "\nNo key takes it by itself.\n".to_owned();
    }
    let shown: Vec<String> = takers.iter().take(MOST).map(|key| format!("  {}\n", key.path)).collect();
    let rest = takers.len() - shown.len();
    let more = if rest > 0 { format!("  and {rest} more: `specforge list keys`\n") } else { String::new() };
    let what = what.strip_prefix("an ").or(what.strip_prefix("a ")).unwrap_or(what);
    format!("\nKeys that take this dimension ({what}):\n{}{more}", shown.concat())
}

/// A unit in one line, for `list units`.
pub fn line(unit: &Unit) -> String {
    let si = unit.dimension.unit();
    let size = quantity(&format!("1 {}", unit.symbol)).map_or(unit.factor, |parsed| parsed.si);
    let is_coherent = si == unit.symbol;
    let size = if is_coherent { String::new() } else { format!(", 1 {} = {size} {si}", unit.symbol) };
    let prefixed = if unit.prefixed { ", takes prefixes" } else { "" };
    format!("{}: {}{}{prefixed}", unit.name, unit.dimension.name(), size.trim_end())
}

/// The prefixes with their powers of ten.
pub fn prefixes() -> String {
    PREFIXES.iter().map(|(prefix, power)| format!("{prefix} (1e{power})")).collect::<Vec<_>>().join(", ")
}
