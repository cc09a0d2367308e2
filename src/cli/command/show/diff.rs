//! `show --diff A B`: the values that differ between two resolved specs, and the tables that only one of them
//! has.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value as Json, json};

use super::origins::{Row, in_order, rows};
use crate::check::Checked;
use crate::diag::Sources;
use crate::escape::terminal::one_line;
use crate::spec::{Experiment, Value};

/// Maximum width of values after which origins are aligned.
const WIDTH: usize = 48;

/// The differences between two specs.
#[derive(Default)]
struct Difference {
    /// Different values of tables that both specs have.
    values: Vec<(String, Option<Row>, Option<Row>)>,
    /// Tables that only the first has, with their values.
    only_a: BTreeMap<String, Vec<Row>>,
    /// Tables that only the second has.
    only_b: BTreeMap<String, Vec<Row>>,
}

/// The differences, each with both values and both origins. Values are compared numerically, not as text.
pub fn show(first: &Checked, second: &Checked, as_json: bool) -> String {
    let (Some(a), Some(b)) = (&first.experiment, &second.experiment) else { return String::new() };
    let difference = difference(a, b, [&first.sources, &second.sources]);
    if as_json { super::pretty(&difference.json(a, b)) } else { difference.text(a, b) }
}

fn difference(a: &Experiment, b: &Experiment, texts: [&Sources; 2]) -> Difference {
    let mut difference = Difference::default();
    let (left, right) = (rows(a, texts[0]), rows(b, texts[1]));
    let by_path = |rows: &[Row]| -> BTreeMap<String, Row> {
        rows.iter().map(|row| (row.path.clone(), row.clone())).collect()
    };
    let (in_a, in_b) = (by_path(&left), by_path(&right));
    let mut seen = BTreeSet::new();
    let of_a_file = |path: &str| matches!(path, "name" | "summary");
    for row in left.iter().chain(&right).filter(|row| !of_a_file(&row.path)) {
        let path = &row.path;
        if !seen.insert(path) || value(a, path) == value(b, path) {
            continue;
        }
        match (missing_table(b, path), missing_table(a, path)) {
            (Some(table), _) => difference.only_a.entry(table).or_default().push(row.clone()),
            (_, Some(table)) => difference.only_b.entry(table).or_default().push(row.clone()),
            _ => difference.values.push((path.clone(), in_a.get(path).cloned(), in_b.get(path).cloned())),
        }
    }
    difference.values = in_order(difference.values, |(path, ..)| path);
    difference
}

impl Difference {
    fn is_empty(&self) -> bool {
        self.values.is_empty() && self.only_a.is_empty() && self.only_b.is_empty()
    }

    fn text(&self, a: &Experiment, b: &Experiment) -> String {
        if self.is_empty() {
            return "the two specs describe the same experiment\n".to_owned();
        }
        let all =
            self.values.iter().flat_map(|(_, a, b)| a.iter().chain(b)).map(|row| row.value.chars().count());
        let width = all.filter(|length| *length <= WIDTH).max().unwrap_or(0);
        let mut text =
            one_line(&format!("--- {}", a.path.display())) + &one_line(&format!("+++ {}", b.path.display()));
        for (path, left, right) in &self.values {
            text += &one_line(path);
            for (sign, row) in [('-', left), ('+', right)] {
                if let Some(row) = row {
                    text += &one_line(&format!("  {sign} {:<width$}  {}", row.value, row.origin));
                }
            }
        }
        for (sign, tables, file) in [('-', &self.only_a, &a.path), ('+', &self.only_b, &b.path)] {
            for (table, rows) in tables {
                text += &one_line(&format!("{table}: only in {}", file.display()));
                text += &only(sign, table, rows);
            }
        }
        text
    }

    fn json(&self, a: &Experiment, b: &Experiment) -> Json {
        let side = |row: &Option<Row>| row.as_ref().map(Row::json);
        let values: Vec<Json> = self
            .values
            .iter()
            .map(|(path, left, right)| json!({ "path": path, "a": side(left), "b": side(right) }))
            .collect();
        let tables = |tables: &BTreeMap<String, Vec<Row>>| -> serde_json::Map<String, Json> {
            let values = |rows: &Vec<Row>| {
                rows.iter().map(|row| (row.path.clone(), row.json())).collect::<serde_json::Map<_, _>>()
            };
            tables.iter().map(|(table, rows)| (table.clone(), values(rows).into())).collect()
        };
        json!({
            "a": a.path, "b": b.path, "values": values,
            "only_a": tables(&self.only_a), "only_b": tables(&self.only_b),
        })
    }
}

/// The values of a table that one spec lacks, with keys relative to the table.
fn only(sign: char, table: &str, rows: &[Row]) -> String {
    let assignment = |row: &Row| {
        let key = row.path.strip_prefix(table).map_or(row.path.as_str(), |key| key.trim_start_matches('.'));
        format!("{key} = {}", row.value)
    };
    let lengths = rows.iter().map(|row| assignment(row).chars().count());
    let width = lengths.filter(|length| *length <= WIDTH).max().unwrap_or(0);
    rows.iter()
        .map(|row| one_line(&format!("  {sign} {:<width$}  {}", assignment(row), row.origin)))
        .collect()
}

/// The section or term on a path that an experiment lacks entirely.
fn missing_table(experiment: &Experiment, path: &str) -> Option<String> {
    let steps: Vec<&str> = path.split('.').collect();
    (1..steps.len().min(3))
        .map(|depth| steps[..depth].join("."))
        .find(|table| value(experiment, table).is_none())
}

/// The canonical value at a path.
fn value(experiment: &Experiment, path: &str) -> Option<Json> {
    let mut table = &experiment.table;
    let mut keys = path.split('.').peekable();
    while let Some(key) = keys.next() {
        match table.get(key)? {
            Value::Table(below) if keys.peek().is_some() => table = below,
            value => return Some(value.canonical()),
        }
    }
    None
}
