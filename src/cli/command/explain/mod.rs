//! `specforge explain WORD`: the page of a code, kind, registry, section, key, engine, unit or part of a
//! suite.

mod engines;
mod relative;
mod suites;
mod units;

use serde_json::{Value, json};

use crate::cli::{Exit, Format, Global, output};
use crate::diag::codes;
use crate::kinds::keys::{self, Key};
use crate::kinds::reference::{self, Registry, registries, summary};
use crate::kinds::vocabulary::vocabulary;
use crate::quantity::Measure;
use crate::quantity::unit::UNITS;
use crate::spec::synonyms::{self, PARTS};
use crate::spec::{Kind, Shape};

pub use units::line as unit_line;

/// Maximum number of pages printed in full; if there are more, only titles are printed.
const MOST: usize = 6;

/// Maximum number of suggestions for an unknown word.
const SUGGESTIONS: usize = 3;

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A code (E0203), a kind (velocity_tracking), a section (learn), a key (learn.samples) or a unit (rad/s)
    #[arg(value_name = "CODE|KIND|KEY|UNIT")]
    word: String,
}

/// A page about a word.
struct Page {
    what: &'static str,
    name: String,
    text: String,
    /// Additional data for programs.
    facts: Value,
}

/// Prints every page about the word. There may be several: a kind may be in two registries, for example.
pub fn run(options: &Options, global: &Global) -> Exit {
    let word = options.word.trim().trim_matches('`');
    let pages = pages(word);
    if pages.is_empty() {
        output::complain(global, &format!("nothing is called `{word}`"), Some(&advice(word)));
        return Exit::Usage;
    }
    match global.format {
        Format::Json => output::json(&json!(pages.iter().map(json_of).collect::<Vec<_>>())),
        _ if pages.len() > MOST => output::data(&titles(word, &pages)),
        _ => output::data(&pages.into_iter().map(|page| page.text).collect::<Vec<_>>().join("\n")),
    }
    Exit::Ok
}

fn json_of(page: &Page) -> Value {
    let mut object = json!({ "what": page.what, "name": page.name, "text": page.text });
    if let (Some(object), Value::Object(facts)) = (object.as_object_mut(), &page.facts) {
        object.extend(facts.clone());
    }
    object
}

/// The titles of many pages, for choosing one.
fn titles(word: &str, pages: &[Page]) -> String {
    let mut text =
        format!("`{word}` is {} things; `specforge explain` says more about each:\n\n", pages.len());
    for page in pages {
        let body = page.text.lines().skip(1).find(|line| !line.trim().is_empty()).unwrap_or_default();
        text += &format!("  {:<44} {body}\n", page.name);
    }
    text
}

fn pages(word: &str) -> Vec<Page> {
    let pages = pages_of(word);
    let joined = word.replace('-', "_");
    if pages.is_empty() && joined != word { pages_of(&joined) } else { pages }
}

fn pages_of(word: &str) -> Vec<Page> {
    let mut pages = Vec::new();
    if let Some(page) = codes::page(word) {
        let facts = json!({ "title": page.title() });
        pages.push(Page { what: "code", name: page.code.to_owned(), text: page.text.to_owned(), facts });
    }
    pages.extend(section_page(word));
    pages.extend(suites::page(word));
    for registry in registries() {
        for kind in
            registry.kinds.iter().filter(|kind| names(&registry, kind).iter().any(|name| name == word))
        {
            let name = format!("{}.{}", registry.name, kind.name);
            let facts = json!({ "summary": summary(kind), "since": kind.since.0, "place": registry.place });
            pages.push(Page { what: "kind", name, text: reference::page(&registry, kind), facts });
        }
    }
    // Do not search the keys for the name of a kind or section: `explain torque` means the kinds.
    if pages.is_empty() {
        let keys = keys::keys();
        let named: Vec<&Key> = keys.iter().filter(|key| key.is_called(word)).collect();
        pages.extend(if named.is_empty() { of_term(word, &keys) } else { named }.into_iter().map(key_page));
    }
    pages.extend(engines::page(word));
    pages.extend(units::page(word));
    pages.extend(relative::page(word));
    if pages.is_empty() {
        pages.extend(synonym_page(word));
    }
    pages
}

/// The page of a name used by other programs.
fn synonym_page(word: &str) -> Option<Page> {
    let row = synonyms::find(word)?;
    let paths: Vec<String> = row.ours.iter().map(|path| synonyms::shown(path)).collect();
    let mut text = format!("# {word}\n\nA name that other programs use. Here it is:\n\n");
    for path in &paths {
        let page = pages(path).into_iter().next();
        let about = page.as_ref().and_then(|page| page.text.lines().skip(1).find(|line| !line.is_empty()));
        text += &format!("  {path:<30} {}\n", about.unwrap_or_default());
    }
    if !row.note.is_empty() {
        text += &format!("\n{}\n", row.note);
    }
    text += &format!("\n`specforge explain {}` says more.\n", paths[0]);
    Some(Page { what: "synonym", name: word.to_owned(), text, facts: json!({ "ours": paths }) })
}

/// The keys for a path as printed by `plan`, `why` and `trace` (`evaluate.nominal.episodes`). The name of a
/// term stands for any of its possible kinds; keys shared by all kinds do not depend on it.
fn of_term<'a>(word: &str, keys: &'a [Key]) -> Vec<&'a Key> {
    let mut steps = word.splitn(3, '.');
    let (Some(section), Some(term), Some(key)) = (steps.next(), steps.next(), steps.next()) else {
        return Vec::new();
    };
    let vocabulary = vocabulary();
    let Some(Shape::Terms(kinds, _)) = vocabulary.section(section).map(|section| &section.shape) else {
        return Vec::new();
    };
    let shared: Vec<&Key> = keys.iter().filter(|known| known.path == format!("{section}.{key}")).collect();
    if !shared.is_empty() || kinds.iter().any(|kind| kind.name == term) {
        return shared;
    }
    let paths: Vec<String> = kinds.iter().map(|kind| format!("{section}.{}.{key}", kind.name)).collect();
    keys.iter().filter(|known| paths.contains(&known.path)).collect()
}

fn key_page(key: &Key) -> Page {
    let facts = json!({
        "takes": key.takes(), "presence": key.absent(), "kinds": key.kinds, "doc": key.param.doc,
        "range": key.param.range.map(|(low, high)| [low, high]),
    });
    Page { what: "key", name: key.path.clone(), text: key.page(), facts }
}

/// The page of a section or registry: its content.
fn section_page(word: &str) -> Option<Page> {
    if let Some(registry) = registries().into_iter().find(|registry| registry.name == word) {
        let mut text = format!("# {}\n\n{}: `{}`.\n\n", registry.name, registry.summary, registry.place);
        for kind in &registry.kinds {
            text += &format!("  {:<24} {}\n", kind.name, summary(kind));
        }
        let kinds: Vec<&str> = registry.kinds.iter().map(|kind| kind.name).collect();
        let facts = json!({ "place": registry.place, "kinds": kinds });
        return Some(Page { what: "registry", name: word.to_owned(), text, facts });
    }
    let vocabulary = vocabulary();
    let Shape::Plain(params) = vocabulary.section(word)?.shape else { return None };
    let mut text = format!("# {word}\n\nThe section `[{word}]`.\n\n");
    for param in params {
        text += &format!("  {:<24} {}\n", param.name, param.doc);
    }
    let keys: Vec<&str> = params.iter().map(|param| param.name).collect();
    Some(Page { what: "section", name: word.to_owned(), text, facts: json!({ "keys": keys }) })
}

fn names(registry: &Registry, kind: &Kind) -> [String; 2] {
    [kind.name.to_owned(), format!("{}.{}", registry.name, kind.name)]
}

/// Suggestions of similar words.
fn advice(word: &str) -> String {
    let mut known: Vec<String> = codes::PAGES.iter().map(|page| page.code.to_owned()).collect();
    for registry in registries() {
        known.push(registry.name.to_owned());
        known.extend(registry.kinds.iter().flat_map(|kind| names(&registry, kind)));
    }
    known.extend(vocabulary().sections.iter().map(|section| section.name.to_owned()));
    known.extend(keys::keys().into_iter().flat_map(|key| [key.name().to_owned(), key.path]));
    known.extend(suites::WORDS.map(str::to_owned));
    let names = PARTS.iter().flat_map(|part| part.rows).flat_map(|row| row.theirs);
    known.extend(names.map(|name| (*name).to_owned()));
    known.extend(Measure::ALL.map(|measure| measure.unit().to_owned()));
    known.extend(UNITS.iter().flat_map(|unit| [unit.symbol.to_owned(), unit.name.to_owned()]));
    known.sort();
    known.dedup();
    let distance = |name: &String| strsim::damerau_levenshtein(&word.to_lowercase(), &name.to_lowercase());
    let limit = (word.chars().count() / 4).clamp(1, 4);
    let mut near: Vec<(usize, String)> = known
        .into_iter()
        .map(|name| (distance(&name), name))
        .filter(|(distance, _)| *distance <= limit)
        .collect();
    near.sort();
    let near: Vec<String> = near.into_iter().take(SUGGESTIONS).map(|(_, name)| format!("`{name}`")).collect();
    match near.as_slice() {
        [] => "`specforge list` prints the kinds, `specforge list codes`, `keys` and `units` the rest"
            .to_owned(),
        near => format!("did you mean {}?", near.join(" or ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_programs_lead_to_pages_that_exist() {
        for row in PARTS.iter().flat_map(|part| part.rows) {
            for path in row.ours {
                assert!(!pages(&synonyms::shown(path)).is_empty(), "{path} does not exist");
            }
        }
    }

    #[test]
    fn words_that_people_look_for_are_explained() {
        for (word, path) in [
            ("pushes", "randomize.push"),
            ("curriculum", "fine_tune"),
            ("finetune", "fine_tune"),
            ("num_envs", "learn.environments"),
            ("entropy_coef", "action.std"),
            ("action_scale", "action.scale"),
        ] {
            let page = &pages(word)[0];
            assert!(page.what == "synonym" && page.text.contains(path), "{word}: {}", page.text);
        }
        assert_eq!(pages("fine-tune")[0].text, pages("fine_tune")[0].text);
    }
}
