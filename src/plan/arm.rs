//! Inputs of a plan: arms, with the contents of the files that they name.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::shared::Shared;
use crate::spec::Table;

/// One arm of a comparison: a resolved spec and the contents of the files that it names.
#[derive(Clone, Debug)]
pub struct Arm {
    /// The arm's name, unique within a plan.
    pub name: String,
    /// The decoded spec.
    pub fields: Table,
    /// Origin of each value, by dotted path: `specs/run.toml:12`, `--set`, `default`.
    pub origins: BTreeMap<String, String>,
    /// The resolved robot.
    pub robot: Shared<serde_json::Value>,
    /// The decoded motion file, for tasks with a reference motion; the text of a clip is under `clip`. It is
    /// the section `motion` of the motion stage, so origins under `motion.` belong to it.
    pub motion: Option<Shared<Table>>,
    /// The command-line arguments that selected it.
    pub request: Request,
    /// The accepted warnings, with their reasons.
    pub allow: BTreeMap<String, String>,
    /// Its runs if it is an arm of a suite; otherwise it is a single run.
    pub runs: Option<Runs>,
}

/// The command-line arguments of an arm, from which a report prints its command.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The spec's path as given.
    pub spec: String,
    /// Its path relative to the project, however it was given.
    pub place: String,
    /// The profile, if any.
    pub profile: Option<String>,
    /// Assignments from `--set`, verbatim.
    pub assignments: Vec<String>,
    /// Folders from `--allow-outside`, verbatim.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outside: Vec<String>,
}

/// The runs of an arm.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    /// The arm's points by axis.
    pub points: Vec<(String, String)>,
    /// The learning seeds, one per run.
    pub seeds: Vec<u64>,
    /// Origin of the seeds; missing if the seed is the spec's own.
    pub origin: Option<String>,
}
