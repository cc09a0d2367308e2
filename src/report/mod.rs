//! Reports: statistics, figures, tables, templates, provenance. Never simulates.

pub mod comparison;
pub mod estimate;
pub mod figure;
pub mod metric;
pub mod model;
pub mod plot;
pub mod statistics;
pub mod verdict;
pub mod wording;

pub use model::ReportInput;
