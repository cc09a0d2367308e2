//! What a plan is made from: arms, with the contents of the files that they name.

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
    /// Where each value comes from, by dotted path: `specs/run.toml:12`, `--set`, `default`.
    pub origins: BTreeMap<String, String>,
    /// The resolved robot.
    pub robot: Shared<serde_json::Value>,
    /// The decoded motion file, for tasks with a reference motion; the text of a clip stands under
    /// `clip`. It is the section `motion` of the motion stage, so origins under `motion.` belong to it.
    pub motion: Option<Shared<Table>>,
    /// How the user asked for it.
    pub request: Request,
    /// The warnings that are meant, with their reasons.
    pub allow: BTreeMap<String, String>,
    /// Its runs, when it is an arm of a suite; otherwise it is one run by itself.
    pub runs: Option<Runs>,
}

/// How the user asked for an arm, for the command that a report prints.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The spec's file as the user named it.
    pub spec: String,
    /// Its path in the project, however the user named it; empty in plans of earlier versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub place: String,
    /// The profile, when one was chosen.
    pub profile: Option<String>,
    /// Assignments given with `--set`, as written.
    pub assignments: Vec<String>,
    /// Folders given with `--allow-outside`, as written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outside: Vec<String>,
}

/// The runs of an arm.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    /// The arm's points by axis.
    pub points: Vec<(String, String)>,
    /// The learning seeds, each a run.
    pub seeds: Vec<u64>,
    /// Where the seeds come from; absent when it is the spec's own.
    pub origin: Option<String>,
}
