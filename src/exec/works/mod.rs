//! The implementation of each kind of stage: reads inputs, calls the layer that does the work, writes files.
//!
//! The report's is in `cli` instead, because `report` comes after this module in the layer order.

mod blueprints;
pub mod episodes;
mod learning;
mod ledger;
mod motion;
pub mod robot;

use std::path::Path;

use super::work::{Job, Work, WorkError, Works};
use crate::bounded;
use crate::env::Blueprint;
use crate::plan::StageKind;
use crate::spec::Section;
use crate::spec::typed::Part;

/// The implementations of all stages except the report.
pub fn works() -> Works {
    let mut works = Works::new();
    works.insert(StageKind::Robot, Box::new(robot::RobotWork));
    works.insert(StageKind::Motion, Box::new(motion::MotionWork));
    works.insert(StageKind::Env, Box::new(blueprints::Env));
    works.insert(StageKind::Controller, Box::new(blueprints::Controller));
    works.insert(StageKind::Pretrain, Box::new(learning::Pretrain));
    works.insert(StageKind::Learner, Box::new(learning::Learner));
    works.insert(StageKind::FineTune, Box::new(learning::FineTune));
    works.insert(StageKind::Evaluate, Box::new(episodes::Evaluate));
    works.insert(StageKind::Export, Box::new(episodes::Export));
    works.insert(StageKind::Transfer, Box::new(episodes::Transfer));
    works
}

/// The environment's blueprint among a job's inputs.
fn blueprint(job: &Job) -> Result<Blueprint, WorkError> {
    job.read("env", "env.json")
}

/// A section that the stage declares.
fn section<'a>(job: &'a Job, name: &str) -> Result<Section<'a>, WorkError> {
    job.section(name).ok_or_else(|| WorkError::failed(format!("the spec has no section [{name}]")))
}

/// A section that the stage declares, decoded.
fn part<P: Part>(job: &Job) -> Result<P, WorkError> {
    let part = Section::new(job.fields).part();
    part.ok_or_else(|| WorkError::failed(format!("the spec has no section [{}]", P::SECTION)))
}

/// The bytes of a file.
fn bytes(path: &Path) -> Result<Vec<u8>, WorkError> {
    bounded::bytes(path, bounded::ARTEFACT).map_err(|error| WorkError::io(path, error.into()))
}

/// Converts any error of a lower layer to a failure without a code.
fn failed(error: impl std::fmt::Display) -> WorkError {
    WorkError::failed(error.to_string())
}
