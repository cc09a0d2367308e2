//! Reports: claims against what was measured, figures, tables, templates, provenance. Never simulates.

pub mod claim;
pub mod comparison;
pub mod crossing;
pub mod deviations;
pub mod estimate;
pub mod fields;
pub mod figure;
pub mod gather;
pub mod headline;
pub mod includes;
pub mod index;
pub mod limits;
pub mod measurable;
pub mod metric;
pub mod model;
pub mod page;
pub mod paper_reward;
pub mod paper_setting;
pub mod plot;
pub mod preflight;
pub mod publish;
pub mod render;
pub mod returns;
pub mod sidecar;
pub mod source;
pub mod suite;
pub mod table;
pub mod template;
pub mod verdict;
pub mod warning;
pub mod wording;
pub mod work;

pub use model::ReportInput;
pub use render::{ReportFile, check, render};
pub use template::Templates;
pub use work::ReportWork;
