//! Reports: statistics, figures, tables, templates, provenance. Never simulates.

pub mod model;
pub mod plot;
pub mod statistics;

pub use model::ReportInput;
