//! `specforge explain WORD`: the page of a code, of a kind or of a unit.

use serde_json::json;

use super::{Exit, Format, Global, output};
use crate::diag::codes;
use crate::kinds::reference::{self, Registry, registries};
use crate::quantity::unit;
use crate::spec::Kind;

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A code (E0203), a kind (velocity_tracking or reward.velocity_tracking) or a unit (rpm)
    #[arg(value_name = "CODE|KIND|UNIT")]
    word: String,
}

/// A page about a word.
struct Page {
    what: &'static str,
    name: String,
    text: String,
}

/// Prints every page about the word: one kind may be in two registries.
pub fn run(options: &Options, global: &Global) -> Exit {
    let word = options.word.trim();
    let pages = pages(word);
    if pages.is_empty() {
        output::complain(global, &format!("nothing is called `{word}`"), Some(&advice(word)));
        return Exit::Usage;
    }
    match global.format {
        Format::Json => {
            let page = |page: &Page| json!({ "what": page.what, "name": page.name, "text": page.text });
            output::json(&json!(pages.iter().map(page).collect::<Vec<_>>()));
        }
        _ => {
            output::data(&pages.into_iter().map(|page| page.text).collect::<Vec<_>>().join("\n"));
        }
    }
    Exit::Ok
}

fn pages(word: &str) -> Vec<Page> {
    let mut pages = Vec::new();
    if let Some(page) = codes::page(word) {
        pages.push(Page { what: "code", name: page.code.to_owned(), text: page.text.to_owned() });
    }
    for registry in registries() {
        for kind in registry.kinds.iter().filter(|kind| names(&registry, kind).iter().any(|name| name == word)) {
            let name = format!("{}.{}", registry.name, kind.name);
            pages.push(Page { what: "kind", name, text: reference::page(&registry, kind) });
        }
    }
    if let Some(unit) = unit::find(word) {
        pages.push(Page { what: "unit", name: word.to_owned(), text: unit_page(word, &unit) });
    }
    pages
}

fn names(registry: &Registry, kind: &Kind) -> [String; 2] {
    [kind.name.to_owned(), format!("{}.{}", registry.name, kind.name)]
}

fn unit_page(symbol: &str, found: &unit::Unit) -> String {
    // As the user would compute it, so that 1e-3 prints as 0.001.
    let size: f64 = format!("{}e{}", found.factor, found.exponent).parse().unwrap_or(found.factor);
    let si = found.dimension.unit();
    let unit = unit::UNITS.iter().find(|unit| unit.symbol == found.symbol).unwrap_or(found);
    let mut text = format!("# {symbol}\n\n{}, {}.\n\n", unit.name, unit.dimension.name());
    if si.is_empty() {
        text += &format!("1 {symbol} is {size} of the reference.\n");
    } else {
        text += &format!("1 {symbol} is {size} {si}.\n");
    }
    if unit.prefixed {
        let prefixes: Vec<&str> = unit::PREFIXES.iter().map(|(prefix, _)| *prefix).collect();
        text += &format!("\nIt takes the prefixes {}.\n", prefixes.join(", "));
    }
    text + "\nQuantities are strings: a number, a space, units joined by `*` and `/`, integer powers after `^`: `\"20 s^2/m^2\"`.\n"
}

/// The word that was probably meant.
fn advice(word: &str) -> String {
    let mut known: Vec<String> = codes::PAGES.iter().map(|page| page.code.to_owned()).collect();
    for registry in registries() {
        known.extend(registry.kinds.iter().flat_map(|kind| names(&registry, kind)));
    }
    let distance = |name: &String| strsim::damerau_levenshtein(&word.to_lowercase(), &name.to_lowercase());
    match known.iter().min_by_key(|name| distance(name)).filter(|name| distance(name) <= 2 + word.len() / 8) {
        Some(near) => format!("did you mean `{near}`?"),
        None => "`specforge list` prints the kinds; docs/codes.md holds the codes".to_owned(),
    }
}
