//! `show --origins`: every value with where it comes from, like `git blame`.

use serde_json::{Map, json};

use super::resolved::written;
use crate::check::Checked;
use crate::spec::marks::below;
use crate::spec::{Experiment, Table, Value};

/// Longest value that origins are aligned behind.
const WIDTH: usize = 58;

/// One line per value: path, value, origin.
pub fn show(checked: &Checked, as_json: bool) -> String {
    let Some(experiment) = &checked.experiment else { return String::new() };
    let mut rows = Vec::new();
    collect(experiment, &experiment.table, "", &mut rows);
    if as_json {
        let object: Map<_, _> = rows
            .iter()
            .map(|(path, value, origin)| (path.clone(), json!({ "value": value, "origin": origin })))
            .collect();
        return super::pretty(&object.into());
    }
    let assignment = |(path, value, _): &(String, String, String)| format!("{path} = {value}");
    let width =
        rows.iter().map(|row| assignment(row).chars().count()).filter(|width| *width <= WIDTH).max().unwrap_or(0);
    rows.iter().map(|row| format!("{:<width$}  {}\n", assignment(row), row.2)).collect()
}

/// The values below a table that are no tables themselves, as path, TOML and origin.
pub fn collect(experiment: &Experiment, table: &Table, path: &str, rows: &mut Vec<(String, String, String)>) {
    for (key, value) in table {
        let path = below(path, key);
        match value {
            Value::Table(table) => collect(experiment, table, &path, rows),
            _ => {
                let Some(origin) = experiment.origins.get(&path) else { continue };
                rows.push((path.clone(), written(experiment, &path, value), origin.to_string()));
            }
        }
    }
}
