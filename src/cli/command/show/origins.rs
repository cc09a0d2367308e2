//! `show --origins`: every value with where it comes from, like `git blame`.

use serde_json::{Value as Json, json};

use super::resolved::written;
use crate::check::Checked;
use crate::cli::{Global, output};
use crate::diag::Sources;
use crate::escape::terminal::{Painted, Style, line};
use crate::kinds::vocabulary::vocabulary;
use crate::spec::{Experiment, Origin, Table, Value};

/// Maximum width of assignments after which origins are aligned if the output is not a terminal.
const WIDTH: usize = 58;

/// Minimum width that long assignments are cut to in a narrow terminal.
const LEAST: usize = 24;

/// A value and where it comes from.
#[derive(Clone, Debug)]
pub struct Row {
    /// The path of the value.
    pub path: String,
    /// The value as TOML, as its author wrote it.
    pub value: String,
    /// Its origin.
    pub origin: Origin,
}

impl Row {
    /// The value and its origin as JSON.
    pub fn json(&self) -> Json {
        let mut object =
            json!({ "value": self.value, "origin": self.origin.to_string(), "layer": layer(&self.origin) });
        if let Origin::File { file, line }
        | Origin::Profile { file, line, .. }
        | Origin::Point { file, line, .. } = &self.origin
        {
            object["file"] = json!(file);
            object["line"] = json!(line);
        }
        object
    }
}

/// The layer of an origin (rule 7 of the language).
fn layer(origin: &Origin) -> &'static str {
    match origin {
        Origin::Default => "default",
        Origin::File { .. } => "file",
        Origin::Profile { .. } => "profile",
        Origin::Point { .. } => "point",
        Origin::Set { .. } => "set",
    }
}

/// One line per value: path, value, origin.
pub fn show(checked: &Checked, as_json: bool, global: &Global) -> Painted {
    let Some(experiment) = &checked.experiment else { return Painted::default() };
    let rows = rows(experiment, &checked.sources);
    if as_json {
        let object: serde_json::Map<_, _> = rows.iter().map(|row| (row.path.clone(), row.json())).collect();
        return Painted::default().plain(&super::pretty(&object.into()));
    }
    text(&rows, output::width(), output::paints(global))
}

/// The lines, fitted to the terminal's width; without a terminal, long values push their origin to the right.
fn text(rows: &[Row], terminal: Option<usize>, paint: bool) -> Painted {
    let assignment = |row: &Row| line(&format!("{} = {}", row.path, row.value)).into_owned();
    let assignments: Vec<String> = rows.iter().map(assignment).collect();
    let longest_origin =
        rows.iter().map(|row| line(&row.origin.to_string()).chars().count()).max().unwrap_or(0);
    let limit = terminal.map_or(WIDTH, |width| width.saturating_sub(longest_origin + 2).max(LEAST));
    let lengths = assignments.iter().map(|assignment| assignment.chars().count());
    let width = match terminal {
        Some(_) => lengths.max().unwrap_or(0).min(limit),
        None => lengths.filter(|length| *length <= limit).max().unwrap_or(0),
    };
    let with = |text: Painted, (row, assignment): (&Row, &String)| {
        let shown = if terminal.is_some() { shortened(assignment, width) } else { assignment.clone() };
        with_origin(text.plain(&format!("{shown:<width$}  ")), &row.origin).plain("\n")
    };
    rows.iter().zip(&assignments).fold(Painted::new(paint), with)
}

/// A text cut to a width, with an ellipsis if anything was cut.
fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}

/// Adds an origin in the colour of its layer: defaults are dim, layers that override files stand out.
fn with_origin(text: Painted, origin: &Origin) -> Painted {
    let words = origin.to_string();
    let words = line(&words);
    match origin {
        Origin::Default => text.styled(Style::Dim, &words),
        Origin::File { .. } => text.plain(&words),
        Origin::Profile { .. } => text.styled(Style::Yellow, &words),
        Origin::Point { .. } => text.styled(Style::Magenta, &words),
        Origin::Set { .. } => text.styled(Style::Cyan, &words),
    }
}

/// The values of an experiment, in the usual order of a spec.
pub fn rows(experiment: &Experiment, sources: &Sources) -> Vec<Row> {
    let row = |(path, origin): (String, Origin)| {
        let value = written(experiment, &path, value_at(&experiment.table, &path)?);
        Some(Row { path, value, origin })
    };
    let rows = experiment.origins(sources).into_iter().filter_map(row).collect();
    in_order(rows, |row: &Row| &row.path)
}

/// Sorts by section; entries of the same table stay together, with its kind first.
pub fn in_order<T>(mut things: Vec<T>, path: impl Fn(&T) -> &str) -> Vec<T> {
    let sections = vocabulary().sections;
    things.sort_by_cached_key(|thing| {
        let path = path(thing);
        let section = path.split('.').next().unwrap_or_default();
        let order = sections.iter().position(|shape| shape.name == section).map_or(0, |at| at + 1);
        let table = path.rsplit_once('.').map_or("", |(table, _)| table);
        (order, table.to_owned(), !path.ends_with(".kind"), path.to_owned())
    });
    things
}

/// The value at a path.
fn value_at<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((key, rest)) => value_at(table.get(key)?.as_table()?, rest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(path: &str, value: &str, origin: Origin) -> Row {
        Row { path: path.to_owned(), value: value.to_owned(), origin }
    }

    #[test]
    fn a_long_value_is_cut_in_a_terminal_and_whole_in_a_pipe() {
        let rows = [
            row("a", "1", Origin::Default),
            row("task.command", &"9".repeat(80), Origin::File { file: "b.toml".into(), line: 12 }),
        ];
        let narrow = text(&rows, Some(40), false);
        let narrow = narrow.as_str();
        assert!(narrow.lines().all(|line| line.chars().count() <= 40), "{narrow}");
        assert!(narrow.contains("99…  b.toml:12"), "{narrow}");
        let piped = text(&rows, None, false);
        let piped = piped.as_str();
        assert!(piped.contains(&"9".repeat(80)) && piped.starts_with("a = 1  default\n"), "{piped}");
    }

    #[test]
    fn colours_are_written_only_where_they_are_wanted() {
        let rows = [row("a", "1", Origin::Set { assignment: "a=1".to_owned() })];
        assert_eq!(text(&rows, None, false).as_str(), "a = 1  --set a=1\n");
        assert_eq!(text(&rows, None, true).as_str(), "a = 1  \x1b[36m--set a=1\x1b[0m\n");
    }
}
