//! `specforge list [WHAT]`: the registries with their kinds, or codes, engines, keys, units, robots or
//! motions.

use std::path::Path;

use serde_json::{Value, json};

use super::explain::unit_line;
use crate::cli::{Exit, Format, Global, output};
use crate::diag::codes::PAGES;
use crate::escape::terminal::one_line;
use crate::kinds::keys::keys;
use crate::kinds::reference::{Registry, registries, summary};
use crate::kinds::vocabulary::vocabulary;
use crate::quantity::Measure;
use crate::quantity::unit::UNITS;
use crate::sim::catalogue::SUPPORTED;
use crate::sim::{EngineFacts, EngineName};
use crate::spec::project::Shelf;
use crate::spec::suggest::nearest;
use crate::spec::{folder, load};
use crate::syntax::{Disk, Files, file};

/// Lists other than registries.
pub const LISTS: [&str; 6] = ["codes", "engines", "keys", "motions", "robots", "units"];

/// Arguments of `list`.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// A registry such as `reward`, or `codes`, `engines`, `keys`, `motions`, `robots` or `units`; without
    /// it, all registries
    #[arg(value_name = "WHAT")]
    what: Option<String>,
}

/// One row of a list.
struct Row {
    name: String,
    text: String,
    facts: Value,
}

/// Prints one line per entry.
pub fn run(options: &Options, global: &Global) -> Exit {
    let Some(wanted) = options.what.as_deref() else {
        print_registries(&registries(), global);
        return Exit::Ok;
    };
    if let Some(registry) = registries().into_iter().find(|registry| registry.name == wanted) {
        print_registries(&[registry], global);
        return Exit::Ok;
    }
    match rows(wanted) {
        Some(rows) => {
            print_rows(&rows, global);
            Exit::Ok
        }
        None => {
            let registries = registries();
            let names: Vec<&str> = registries.iter().map(|registry| registry.name).chain(LISTS).collect();
            let advice = match nearest(wanted, names.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the lists are {}", names.join(", ")),
            };
            output::complain(global, &format!("there is no list of `{wanted}`"), Some(&advice));
            Exit::Usage
        }
    }
}

/// The rows of a list that is not a registry.
fn rows(wanted: &str) -> Option<Vec<Row>> {
    let row = |name: &str, text: String, facts: Value| Row { name: name.to_owned(), text, facts };
    let vocabulary = vocabulary();
    Some(match wanted {
        "codes" => PAGES.iter().map(|page| row(page.code, page.title().to_owned(), json!({}))).collect(),
        "engines" => EngineName::ALL.iter().map(|engine| engine_row(*engine)).collect(),
        "units" => UNITS
            .iter()
            .map(|unit| {
                let facts = json!({ "dimension": unit.dimension.name(), "prefixes": unit.prefixed });
                row(unit.symbol, unit_line(unit), facts)
            })
            .chain(Measure::ALL.map(|measure| {
                let facts = json!({ "dimension": measure.name(), "prefixes": false });
                row(measure.unit(), format!("{}: `specforge explain mgh`", measure.name()), facts)
            }))
            .collect(),
        "keys" => keys()
            .iter()
            .map(|key| {
                let facts = json!({ "takes": key.takes(), "presence": key.absent(), "kinds": key.kinds });
                row(&key.path, format!("{} ({}, {})", key.param.doc, key.takes(), key.absent()), facts)
            })
            .collect(),
        "robots" => shelf_rows(&load::robots(&vocabulary)),
        "motions" => shelf_rows(&load::motions(&vocabulary)),
        _ => return None,
    })
}

/// An engine and its contact model and, in the JSON form, its supported features.
fn engine_row(engine: EngineName) -> Row {
    let EngineFacts { summary, contacts, .. } = engine.facts();
    let mut facts = json!({ "contacts": contacts });
    if let Some(facts) = facts.as_object_mut() {
        facts.extend(SUPPORTED.map(|(what, names)| (what.to_owned(), json!(names))));
    }
    Row { name: engine.word().to_owned(), text: format!("{summary}; contacts: {contacts}"), facts }
}

/// The project's files and the built-in ones, as a spec in the working folder would name them.
fn shelf_rows(shelf: &Shelf) -> Vec<Row> {
    let folder = folder::folder(&Disk, Path::new("spec.toml"));
    let row = |name: String| {
        let path = shelf.path(&folder, &name);
        let shipped = shelf.shipped(&name).map(|file| file.text);
        if Disk.sort(&path).is_err() {
            let text = summary_of(shipped.unwrap_or_default());
            return Row { name, text, facts: json!({ "shipped": true }) };
        }
        let (summary, replaces) = match file::read(&Disk, &path) {
            Ok(text) => (summary_of(&text), shelf.replaces(&name, &text)),
            Err(error) => (error.message, shipped.is_some()),
        };
        let shown = path.display().to_string();
        let remark = match (shipped, replaces) {
            (_, true) => format!(" [{shown}, which replaces the {} that comes with specforge]", shelf.noun),
            (None, _) => format!(" [{shown}]"),
            (Some(_), false) => String::new(),
        };
        let facts =
            json!({ "shipped": shipped.is_some() && !replaces, "file": shown, "replaces_shipped": replaces });
        Row { name, text: summary + &remark, facts }
    };
    shelf.names(&Disk, Some(&folder)).into_iter().map(row).collect()
}

/// The description in a robot or motion file: its key `summary`, or its first comment.
fn summary_of(text: &str) -> String {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let summary = table.get("summary").and_then(toml::Value::as_str).map(str::to_owned);
    let comment = || text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or_default().to_owned();
    summary.unwrap_or_else(comment)
}

fn print_rows(rows: &[Row], global: &Global) {
    if global.format == Format::Json {
        let object = |row: &Row| {
            let mut object = json!({ "name": row.name, "summary": row.text });
            if let (Some(object), Value::Object(facts)) = (object.as_object_mut(), &row.facts) {
                object.extend(facts.clone());
            }
            object
        };
        return output::json(&rows.iter().map(object).collect());
    }
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    let line = |row: &Row| one_line(&format!("{:<width$}  {}", row.name, row.text));
    output::data(&rows.iter().map(line).collect::<String>());
}

fn print_registries(shown: &[Registry], global: &Global) {
    match global.format {
        Format::Json => output::json(&json!(shown.iter().map(json_of).collect::<Vec<_>>())),
        _ => {
            let text = shown.iter().map(text_of).collect::<Vec<_>>().join("\n");
            let more = format!("\nMore lists: {}.\n", LISTS.join(", "));
            output::data(&if shown.len() > 1 { text + &more } else { text });
        }
    }
}

fn text_of(registry: &Registry) -> String {
    let mut text = format!("{} {}: {}\n", registry.name, registry.place, registry.summary);
    for kind in &registry.kinds {
        text += &format!("  {:<24} {}\n", kind.name, summary(kind));
    }
    text
}

fn json_of(registry: &Registry) -> Value {
    let kinds: Vec<_> = registry
        .kinds
        .iter()
        .map(|kind| {
            let keys: Vec<&str> = kind.params.iter().map(|param| param.name).collect();
            json!({ "name": kind.name, "since": kind.since.0, "summary": summary(kind), "keys": keys })
        })
        .collect();
    json!({ "registry": registry.name, "place": registry.place, "summary": registry.summary, "kinds": kinds })
}
