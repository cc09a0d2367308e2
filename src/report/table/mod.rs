//! The tables of a report as data; templates define their appearance.

pub mod conditions;
pub mod endings;
pub mod evaluation;
pub mod health;
pub mod learning;
mod page;
pub mod setup;

use serde::{Deserialize, Serialize};

use super::estimate::Estimate;
use super::source::Source;

pub use page::{Tables, with_rows};

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Its name in `specforge trace`.
    pub id: String,
    /// Its title.
    pub title: String,
    /// A sentence above it, about the whole table.
    #[serde(default)]
    pub note: String,
    /// Headings of the columns, starting with that of the row labels.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
    /// The stages it is made from.
    pub sources: Vec<Source>,
    /// The source index of each column after the first, if it has exactly one.
    pub column_sources: Vec<Option<usize>>,
}

/// A row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Its name in `specforge trace`; empty if its cells cannot be traced individually.
    pub name: String,
    /// What it shows.
    pub label: String,
    /// The values.
    pub cells: Vec<Cell>,
    /// The stages it is made from, if its columns have no source of their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<Source>,
}

/// A cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number with unit, n and interval.
    Number(Estimate),
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_string())
    }
}

impl From<Estimate> for Cell {
    fn from(estimate: Estimate) -> Self {
        Self::Number(estimate)
    }
}

impl Table {
    /// An empty table with these columns.
    pub fn new(id: &str, title: &str, columns: impl IntoIterator<Item = String>) -> Self {
        let columns = columns.into_iter().collect();
        Self { id: id.to_string(), title: title.to_string(), columns, ..Self::default() }
    }

    /// Adds a row.
    pub fn row(&mut self, name: &str, label: &str, cells: impl IntoIterator<Item = Cell>) {
        let cells = cells.into_iter().collect();
        self.rows.push(Row { name: name.to_string(), label: label.to_string(), cells, sources: Vec::new() });
    }

    /// Adds a row with the stages it is made from.
    pub fn row_from(
        &mut self,
        name: &str,
        label: &str,
        cells: impl IntoIterator<Item = Cell>,
        sources: Vec<Source>,
    ) {
        self.row(name, label, cells);
        self.rows.iter_mut().next_back().into_iter().for_each(|row| row.sources.clone_from(&sources));
    }
}
