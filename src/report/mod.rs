//! Reports: statistics, figures, tables, templates, provenance. Never simulates.

pub mod comparison;
pub mod estimate;
pub mod fields;
pub mod figure;
pub mod metric;
pub mod model;
pub mod plot;
pub mod statistics;
pub mod table;
pub mod verdict;
pub mod warning;
pub mod wording;

pub use model::ReportInput;
