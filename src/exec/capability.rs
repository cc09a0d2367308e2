//! Checks, before a run starts, whether this build can do a stage on this machine, so that a missing library
//! is reported at once and not after an hour.

use super::work::WorkError;
use crate::deploy::torchscript;
use crate::kinds::deploy::export::Format;
use crate::kinds::deploy::{Export, Transfer};
use crate::kinds::evaluate::Setting;
use crate::kinds::learn::Ppo;
use crate::kinds::physics::Physics;
use crate::learn::ppo::check_backend;
use crate::plan::{Plan, Stage, StageKind};
use crate::sim::{self, EngineName};
use crate::spec::Section;

/// Fails if a stage needs a simulator or a library (R0005) or a device (R0006) that is not available.
pub fn check(plan: &Plan, stage: &Stage) -> Result<(), WorkError> {
    let fields = Section::new(&stage.fields);
    if let StageKind::Learner | StageKind::FineTune = stage.kind {
        check_backend(
            fields.at(Ppo::backend).unwrap_or_default(),
            fields.at(Ppo::device).unwrap_or_default(),
        )?;
    }
    let formats = fields.at(Export::formats).unwrap_or_default();
    if stage.kind == StageKind::Export && !torchscript::AVAILABLE && formats.contains(&Format::Torchscript) {
        let message =
            "the format `torchscript` is written by libtorch, and this specforge was built without it";
        let help = "build with `make build FEATURES=torch`, or leave the format out; `specforge explain \
            R0005` says more";
        return Err(WorkError::coded("R0005", message, help));
    }
    if let Some(engine) = engine(plan, stage) {
        sim::open(engine.word())?;
    }
    Ok(())
}

/// The simulator that the stage runs: its own, or else that of its environment.
fn engine(plan: &Plan, stage: &Stage) -> Option<EngineName> {
    let fields = Section::new(&stage.fields);
    let own = match stage.kind {
        StageKind::Evaluate => fields.at(Setting::engine),
        StageKind::Transfer => fields.at(Transfer::engine),
        StageKind::Learner | StageKind::FineTune => None,
        _ => return None,
    };
    own.or_else(|| Section::new(&plan.stage(stage.recipe.inputs.get("env")?)?.fields).at(Physics::engine))
}
