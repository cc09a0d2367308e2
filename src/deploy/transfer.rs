//! Transfer: an exported policy in another engine, under the protocol of an evaluation.

use std::sync::Arc;

use super::policy::Policy;
use crate::env::BlueprintError;
use crate::evaluate::follower::Follower;
use crate::evaluate::{Evaluation, EvaluationError, Protocol, Subject, followed};
use crate::kinds;
use crate::kinds::terrain::Ground;
use crate::sim::{Engine, EngineSettings, mjcf};
use crate::spec::Section;

/// The conditions of a transfer.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// Name of the engine.
    pub engine: String,
    /// Physics rate in Hz.
    pub rate: f64,
    /// Time constant of soft contacts in s; `None` is the engine's default.
    pub contact_time: Option<f64>,
    /// The protocol of the evaluation.
    pub protocol: Protocol,
}

impl Transfer {
    /// The transfer of a decoded `[deploy.NAME]` table of kind `transfer`.
    pub fn new(section: Section) -> Self {
        let keys: kinds::deploy::Transfer = section.read();
        let (engine, protocol) = (keys.engine.word().to_owned(), Protocol::new(section));
        Self { engine, rate: keys.rate, contact_time: keys.contact_time, protocol }
    }

    /// Runs the policy in the engine on up to `threads` threads. Weights, normalisation, law and robot come
    /// from the artefact alone.
    pub fn run(
        &self,
        policy: &Policy,
        engine: Arc<dyn Engine>,
        threads: usize,
        follower: &dyn Follower,
    ) -> Result<Evaluation, EvaluationError> {
        let blueprint = policy.blueprint.with_physics(self.rate)?;
        let subject = Subject {
            network: &policy.network,
            blueprint: &blueprint,
            engine,
            contact_time: self.contact_time,
        };
        followed(&subject, &self.protocol, threads, follower)
    }

    /// The robot on its terrain as MJCF, with the settings of this transfer (`robot.xml`).
    pub fn mjcf(&self, policy: &Policy) -> Result<String, BlueprintError> {
        let blueprint = policy.blueprint.with_physics(self.rate)?;
        let blueprint = self.protocol.ground(&blueprint)?;
        let ground: Ground = blueprint.part();
        let settings = EngineSettings {
            step: 1.0 / self.rate,
            friction: ground.friction(),
            contact_time: self.contact_time,
        };
        Ok(mjcf::document(&blueprint.robot, &crate::env::ground::terrain(&ground), &settings))
    }
}
