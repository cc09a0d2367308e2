//! `show --resolved`: the spec after inheritance, as a self-contained spec in its author's units.

use crate::check::Checked;
use crate::format::{Order, Sort, format};
use crate::kinds::vocabulary::vocabulary;
use crate::spec::marks::below;
use crate::spec::{Experiment, Sampler, Shape, Table, Value};

/// The text of the resolved spec.
pub fn show(checked: &Checked, json: bool) -> String {
    let Some(experiment) = &checked.experiment else { return String::new() };
    if json {
        return super::pretty(&crate::spec::value::canonical_table(&experiment.table));
    }
    let mut text = format!("spec    = 1\nname    = {}\n", quoted(&experiment.name));
    if !experiment.summary.is_empty() {
        text += &format!("summary = {}\n", quoted(&experiment.summary));
    }
    if experiment.is_abstract {
        text += "abstract = true\n";
    }
    for section in &vocabulary().sections {
        let Some(Value::Table(table)) = experiment.table.get(section.name) else { continue };
        match section.shape {
            Shape::Terms(..) if table.is_empty() => text += &format!("\n[{}]\n", section.name),
            Shape::Terms(..) => {
                for (name, term) in table {
                    if let Value::Table(term) = term {
                        text += &block(experiment, &below(section.name, name), term);
                    }
                }
            }
            Shape::Plain(_) | Shape::Kind(_) => text += &block(experiment, section.name, table),
        }
    }
    if !experiment.allow.is_empty() {
        text += "\n[allow]\n";
        text.extend(experiment.allow.iter().map(|(code, reason)| format!("{code} = {}\n", quoted(reason))));
    }
    format(&text, Sort::Spec, &Order::of_this_edition())
}

/// A table with its header; the kind comes first, and is omitted if the table has the same name.
fn block(experiment: &Experiment, path: &str, table: &Table) -> String {
    let named = path.rsplit_once('.').map(|(_, name)| name);
    let kind = table
        .get("kind")
        .filter(|kind| !matches!((kind, named), (Value::Text(kind), Some(name)) if kind == name));
    let rest = table.iter().filter(|(key, _)| *key != "kind");
    let entries: Vec<(&str, &Value)> = kind
        .map(|kind| ("kind", kind))
        .into_iter()
        .chain(rest.map(|(key, value)| (key.as_str(), value)))
        .collect();
    let width = entries.iter().map(|(key, _)| key.len()).max().unwrap_or(0);
    let mut text = format!("\n[{path}]\n");
    for (key, value) in entries {
        let share = match value {
            Value::Quantity(quantity) => quantity.share(),
            _ => None,
        };
        let note = share.map(|share| format!(" # {share}")).unwrap_or_default();
        text += &format!("{key:<width$} = {}{note}\n", written(experiment, &below(path, key), value));
    }
    text
}

/// A value as TOML on one line, as its author wrote it.
pub fn written(experiment: &Experiment, path: &str, value: &Value) -> String {
    if let Value::Table(table) = value {
        let entry = |(key, value): (&String, &Value)| {
            format!("{key} = {}", written(experiment, &below(path, key), value))
        };
        let entries: Vec<String> = table.iter().map(entry).collect();
        return if entries.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", entries.join(", ")) };
    }
    match experiment.marks.get(path) {
        Some(mark) if !mark.text.is_empty() => mark.text.clone(),
        _ => plain(value),
    }
}

/// A value without a source location, in SI units.
fn plain(value: &Value) -> String {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    match value {
        Value::Flag(flag) => flag.to_string(),
        Value::Count(count) => count.to_string(),
        Value::Quantity(quantity) if quantity.text.parse::<f64>().is_ok() => quantity.text.clone(),
        Value::Quantity(quantity) => quoted(&quantity.text),
        Value::Text(text) => quoted(text),
        Value::List(items) => format!("[{}]", items.iter().map(plain).collect::<Vec<_>>().join(", ")),
        Value::Sampler(Sampler::Constant(number)) => number.to_string(),
        Value::Sampler(Sampler::Uniform(ends)) => format!("{{ uniform = [{}] }}", list(ends)),
        Value::Sampler(Sampler::LogUniform(ends)) => format!("{{ log_uniform = [{}] }}", list(ends)),
        Value::Sampler(Sampler::Normal(shape)) => format!("{{ normal = [{}] }}", list(shape)),
        Value::Sampler(Sampler::Choice(values)) => format!("{{ choice = [{}] }}", list(values)),
        Value::Table(_) => "{}".to_owned(),
    }
}

fn quoted(text: &str) -> String {
    crate::escape::toml::string(text)
}
