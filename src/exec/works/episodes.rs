//! The stages that run or export a trained policy.

use std::path::Path;

use super::ledger::Ledger;
use super::{Job, Work, WorkError, blueprint, bytes, failed, section};
use crate::deploy::contract::Provenance;
use crate::deploy::policy::{self, Policy, PolicyError, Trust};
use crate::deploy::torchscript;
use crate::deploy::transfer::Transfer as Protocol;
use crate::env::BlueprintError;
use crate::evaluate::follower::Follower;
use crate::evaluate::{EvaluationError, Subject, followed, protocol};
use crate::finite;
use crate::kinds::deploy::{Deployment, export};
use crate::kinds::evaluate::Evaluation as Evaluations;
use crate::kinds::evaluate::Setting;
use crate::learn::Network;
use crate::outcome::Evaluation;
use crate::sim::{self, EngineName};
use crate::spec::typed::InSection;

/// `evaluation.json`: the deterministic policy in the engine of its training, unless the table names another
/// one.
pub struct Evaluate;

impl Work for Evaluate {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let blueprint = blueprint(job)?;
        let network = actor(job)?;
        let table = section(job, Evaluations::SECTION)?;
        let protocol = protocol::Protocol::new(table);
        let name = table.value(Setting::engine).map_or(blueprint.engine(), EngineName::word);
        let engine = sim::open(name)?;
        let blueprint = match table.value(Setting::rate) {
            Some(rate) => blueprint.with_physics(rate).map_err(|error| unfinished(error.into()))?,
            None => blueprint,
        };
        let contact_time = table.value(Setting::contact_time);
        let subject = Subject { network: &network, blueprint: &blueprint, engine, contact_time };
        let ledger = Ledger::open(job, protocol.conditions.len())?;
        let evaluation = followed(&subject, &protocol, job.threads.now(), &ledger);
        ledger.close()?;
        let evaluation = evaluation.map_err(unfinished)?;
        tell_diverged(job, &evaluation);
        job.write("evaluation.json", &evaluation)
    }
}

/// `policy.safetensors` and `contract.json`, and `policy.pt` on request: the policy in a form that needs no
/// spec.
pub struct Export;

impl Work for Export {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let learner = job.stage.recipe.inputs.get("learner").map(|key| key.as_str().to_owned());
        let provenance = Provenance::of_build(learner);
        let policy = Policy::new(actor(job)?, blueprint(job)?, provenance).map_err(unusable)?;
        let path = job.output.join(policy::FILE);
        std::fs::write(&path, policy.to_bytes()).map_err(|error| WorkError::io(&path, error))?;
        if section(job, Deployment::SECTION)?
            .value(export::Export::formats)
            .is_some_and(|formats| formats.contains(&export::Format::Torchscript))
        {
            torchscript::save(&policy.network, &job.output.join(torchscript::FILE)).map_err(failed)?;
        }
        job.write("contract.json", &policy.contract)
    }
}

/// `evaluation.json` and, for MuJoCo, `robot.xml`: the exported policy in another engine.
pub struct Transfer;

impl Work for Transfer {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let transfer = Protocol::new(section(job, Deployment::SECTION)?);
        let policy = read_policy(&job.input("policy", policy::FILE)?, Trust::Digest)?;
        let robot = blueprint(job)?.robot;
        policy.check_robot(&robot).map_err(unusable)?;
        let ledger = Ledger::open(job, transfer.protocol.conditions.len())?;
        let evaluation = transferred(&policy, &transfer, job.threads.now(), &ledger);
        ledger.close()?;
        if transfer.engine == EngineName::Mujoco.word() {
            job.write_text("robot.xml", &transfer.mjcf(&policy).map_err(failed)?)?;
        }
        let evaluation = evaluation?;
        tell_diverged(job, &evaluation);
        job.write("evaluation.json", &evaluation)
    }
}

/// Warns of episodes in which the simulation diverged. They do not fail the stage, because the other episodes
/// are sound.
fn tell_diverged(job: &Job, evaluation: &Evaluation) {
    if let Some(first) = evaluation.diverged().next() {
        let (count, all) = (evaluation.diverged().count(), evaluation.episodes.len());
        let message =
            format!("the physics diverged in {count} of {all} episodes, first in `{}`", first.stream);
        job.finding(
            "R0001",
            message,
            "raise the physics rate, or weaken what pushes the robot; the numbers of such episodes mean nothing",
        );
    }
}

/// The trained actor.
fn actor(job: &Job) -> Result<Network, WorkError> {
    Network::from_safetensors("actor", &bytes(&job.input("learner", "actor.safetensors")?)?).map_err(failed)
}

/// Reads an exported policy; `trust` is what vouches for its file.
pub fn read_policy(path: &Path, trust: Trust) -> Result<Policy, WorkError> {
    Policy::trusted(&bytes(path)?, trust).map_err(unusable)
}

/// Runs an exported policy in its own or another engine, on up to `threads` threads, with a follower.
pub fn transferred(
    policy: &Policy,
    transfer: &Protocol,
    threads: usize,
    follower: &dyn Follower,
) -> Result<Evaluation, WorkError> {
    let engine = sim::open(&transfer.engine)?;
    let evaluation = transfer.run(policy, engine, threads, follower).map_err(unfinished)?;
    finite::check(&evaluation).map_err(|found| WorkError::not_finite("evaluation", &found))?;
    Ok(evaluation)
}

fn unusable(error: PolicyError) -> WorkError {
    WorkError::coded(error.code(), error.to_string(), error.help())
}

fn unfinished(error: EvaluationError) -> WorkError {
    match error {
        EvaluationError::Interrupted => WorkError::Interrupted,
        EvaluationError::Shape { .. } => {
            WorkError::coded("E0502", error.to_string(), "train the policy for this environment")
        }
        EvaluationError::Blueprint(error @ BlueprintError::Rate { .. }) => {
            WorkError::coded("E0501", error.to_string(), "choose a physics rate that is a multiple of it")
        }
        EvaluationError::Blueprint(error) => failed(error),
    }
}
