//! `show --diff A B`: the values in which two resolved specs differ.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::origins::collect;
use crate::check::Checked;
use crate::spec::Value;

type Row = (String, String);

/// The differing values, each with both values and both origins. Values are compared as numbers, not as texts.
pub fn show(first: &Checked, second: &Checked, as_json: bool) -> String {
    let (a, b) = (rows(first), rows(second));
    let paths: BTreeSet<&String> =
        a.keys().chain(b.keys()).filter(|path| *path != "name" && *path != "summary").collect();
    let differing: Vec<&String> = paths.into_iter().filter(|path| value(first, path) != value(second, path)).collect();
    if as_json {
        let side = |rows: &BTreeMap<String, Row>, path: &str| {
            rows.get(path).map(|(value, origin)| json!({ "value": value, "origin": origin }))
        };
        let list: Vec<_> =
            differing.iter().map(|path| json!({ "path": path, "a": side(&a, path), "b": side(&b, path) })).collect();
        return super::pretty(&json!(list));
    }
    let mut text = String::new();
    for path in differing {
        text += &format!("{path}\n");
        for (sign, rows) in [('-', &a), ('+', &b)] {
            if let Some((value, origin)) = rows.get(path) {
                text += &format!("  {sign} {value:<40} {origin}\n");
            }
        }
    }
    if text.is_empty() { "the two specs describe the same experiment\n".to_owned() } else { text }
}

fn rows(checked: &Checked) -> BTreeMap<String, Row> {
    let mut rows = Vec::new();
    if let Some(experiment) = &checked.experiment {
        collect(experiment, &experiment.table, "", &mut rows);
    }
    rows.into_iter().map(|(path, value, origin)| (path, (value, origin))).collect()
}

/// The canonical value at a path.
fn value(checked: &Checked, path: &str) -> Option<serde_json::Value> {
    let mut table = &checked.experiment.as_ref()?.table;
    let mut keys = path.split('.').peekable();
    while let Some(key) = keys.next() {
        match table.get(key)? {
            Value::Table(below) if keys.peek().is_some() => table = below,
            value => return Some(value.canonical()),
        }
    }
    None
}
