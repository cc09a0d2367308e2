//! Lowers checked experiments to the dataflow graph, and analyses the graph without running it: fingerprints,
//! cache states, reasons. Uses neither simulators nor libtorch nor files.

mod alike;
mod arm;
pub mod budgets;
mod defaults;
pub mod digests;
mod draft;
mod error;
pub mod expected;
mod field;
pub mod fingerprint;
pub mod graph;
mod idle_axes;
pub mod lower;
pub mod neutral;
pub mod render;
pub mod revision;
pub mod same_results;
mod saved;
pub mod sections;
pub mod selection;
pub mod shared;
pub mod stage;
pub mod suite;
pub mod summary;
pub mod why;

pub use arm::{Arm, Request, Runs};
pub use draft::{TUNED_ENV, Training, replaced, tuned};
pub use error::PlanError;
pub use fingerprint::{Fingerprint, Recipe};
pub use graph::{ArmRecord, Edge, Plan, Stage, User};
pub use idle_axes::idle_axes;
pub use lower::{BASELINES, ReportSource, ReportedSuite, lower};
pub use saved::{SavedError, is_saved};
pub use selection::Selection;
pub use shared::Shared;
pub use stage::StageKind;
pub use suite::{AxisRecord, RunRecord, SuiteRecord};
pub use why::{Cached, Change, History, State, Status};
