//! The policy artefact: `policy.safetensors` with the actor's weights, its contract and its blueprint.
//!
//! The file stands for itself: weights, normalisation and law are read from it and from nowhere else.
//! What does not agree with itself or with the robot it meets is refused.

use super::contract::{Contract, Provenance, robot_digest};
use crate::env::Blueprint;
use crate::learn::file;
use crate::learn::network::{Activation, Network};
use crate::robot::Robot;

/// A policy with what is needed to run it.
#[derive(Clone, Debug)]
pub struct Policy {
    /// The actor.
    pub network: Network,
    /// Its contract.
    pub contract: Contract,
    /// The environment that it was trained in: robot, task, terms.
    pub blueprint: Blueprint,
}

/// Why a policy cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// The file is none of ours.
    #[error("the file is no policy of specforge: {0}")]
    Format(String),
    /// The network has other inputs or outputs than the contract (E0502).
    #[error("the contract lists {expected} {side}, the network has {found}")]
    Shape {
        /// `inputs` or `outputs`.
        side: &'static str,
        /// Entries of the contract.
        expected: usize,
        /// Width of the network.
        found: usize,
    },
    /// The contract and what it meets demand different things (R0002).
    #[error("the policy's contract does not fit: {0}")]
    Contract(String),
    /// A weight is not a number (R0001).
    #[error("a weight of the policy is not a finite number")]
    NotFinite,
}

impl PolicyError {
    /// The diagnostic's code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Shape { .. } => "E0502",
            Self::NotFinite => "R0001",
            Self::Format(_) | Self::Contract(_) => "R0002",
        }
    }

    /// What to do about it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Format(_) => "name a `policy.safetensors` that `deploy.policy` wrote",
            Self::Shape { .. } => "the policy was trained with other observations or actions: train it again",
            Self::Contract(_) => "run the policy on the robot and with the law it was trained for, or train it again",
            Self::NotFinite => "train it again with a smaller learning rate",
        }
    }
}

impl Policy {
    /// The policy of an actor that was trained in this environment.
    pub fn new(network: Network, blueprint: Blueprint, provenance: Provenance) -> Result<Self, PolicyError> {
        let contract = Contract::new(&blueprint.fields, &blueprint.robot, blueprint.motion.as_ref(), provenance);
        let policy = Self { network, contract, blueprint };
        policy.check()?;
        Ok(policy)
    }

    /// The artefact's bytes; equal policies have equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let contract = serde_json::to_string(&self.contract).expect("a contract is plain data");
        let blueprint = serde_json::to_string(&self.blueprint).expect("a blueprint is plain data");
        let mut tensors = file::Tensors::new();
        self.network.insert_into("actor", &mut tensors);
        let header = [
            ("actor.activation", self.network.activation.name()),
            ("blueprint", blueprint.as_str()),
            ("contract", contract.as_str()),
        ];
        file::write(&tensors, &header)
    }

    /// Reads an artefact and checks that it agrees with itself.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PolicyError> {
        let format = |error: &dyn std::fmt::Display| PolicyError::Format(error.to_string());
        let (tensors, header) = file::read(bytes).map_err(|error| format(&error))?;
        let text = |key: &str| {
            header.get(key).map(String::as_str).ok_or_else(|| PolicyError::Format(format!("its header lacks `{key}`")))
        };
        let activation = Activation::named(text("actor.activation")?)
            .ok_or_else(|| PolicyError::Format("its activation is unknown".into()))?;
        let contract = serde_json::from_str(text("contract")?).map_err(|error| format(&error))?;
        let blueprint = serde_json::from_str(text("blueprint")?).map_err(|error| format(&error))?;
        let network = Network::take_from("actor", &tensors, activation).map_err(|error| format(&error))?;
        let policy = Self { network, contract, blueprint };
        policy.check()?;
        Ok(policy)
    }

    /// Refuses a robot that is not the one the policy was trained on.
    pub fn check_robot(&self, robot: &Robot) -> Result<(), PolicyError> {
        let digest = robot_digest(robot);
        if digest == self.contract.robot.digest {
            return Ok(());
        }
        let (own, other) = (&self.contract.robot, &robot.name);
        let message =
            format!("it was made for robot `{}` ({:.12}), this is `{other}` ({digest:.12})", own.name, own.digest);
        Err(PolicyError::Contract(message))
    }

    fn check(&self) -> Result<(), PolicyError> {
        let (contract, blueprint) = (&self.contract, &self.blueprint);
        let shapes = [
            ("inputs", contract.inputs.len(), self.network.inputs()),
            ("outputs", contract.outputs.len(), self.network.outputs()),
        ];
        if let Some((side, expected, found)) = shapes.into_iter().find(|(_, expected, found)| expected != found) {
            return Err(PolicyError::Shape { side, expected, found });
        }
        if !self.network.is_finite() {
            return Err(PolicyError::NotFinite);
        }
        self.check_robot(&blueprint.robot)?;
        let provenance = contract.provenance.clone();
        let own = Contract::new(&blueprint.fields, &blueprint.robot, blueprint.motion.as_ref(), provenance);
        contract.difference(&own).map_or(Ok(()), |difference| Err(PolicyError::Contract(difference)))
    }
}
