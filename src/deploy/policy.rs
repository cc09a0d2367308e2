//! The policy artefact: `policy.safetensors` with the actor's weights, its contract and its blueprint.
//!
//! The file is self-contained: weights, normalisation and law are read from it alone. A file that contradicts
//! itself, this version's keys or the given robot is refused. The blueprint is in the header, and the samples
//! of its motion are stored next to the weights as `motion.*` in f64.

use super::contract::{Contract, Provenance, VERSION, robot_digest};
use super::{fields, frames};
use crate::env::{Blueprint, BlueprintError};
use crate::finite::{self, NotFinite};
use crate::kinds::motion::Motion;
use crate::learn::file::{self, Doubles, Tensors};
use crate::learn::network::{Activation, Network};
use crate::robot::Robot;

/// Name of the file in the artefact of an export.
pub const FILE: &str = "policy.safetensors";

/// A policy with everything that is needed to run it.
#[derive(Clone, Debug)]
pub struct Policy {
    /// The actor.
    pub network: Network,
    /// Its contract.
    pub contract: Contract,
    /// The environment that it was trained in: robot, task, terms.
    pub blueprint: Blueprint,
}

/// What guarantees that a policy's file is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// Its own digest, over its whole content.
    Digest,
    /// The user.
    User,
}

/// Why a policy cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// Not a policy of specforge.
    #[error("the file is not a policy of specforge: {0}")]
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
    /// The contract does not fit the robot or environment (R0002).
    #[error("the policy's contract does not fit: {0}")]
    Contract(String),
    /// A weight is NaN or infinite (R0001).
    #[error("a weight of the policy is not a finite number")]
    NotFinite,
    /// The file was changed after the export (R0003).
    #[error("the file is damaged: its content does not match its digest")]
    Digest,
    /// Nothing in the file shows whether it was changed after the export (R0008).
    #[error("it has no digest, so it is unknown whether it was changed after the export")]
    Unsealed,
    /// A number of its contract or environment is not finite (R0007).
    #[error("the policy cannot be written: {0}")]
    Number(#[from] NotFinite),
    /// The contract has another layout version than this specforge supports (R0002).
    #[error("its contract has layout version {found}, this specforge supports version {VERSION}")]
    Version {
        /// Version in the file.
        found: u64,
    },
    /// Its environment has other keys than this version (R0002).
    #[error("it was exported by another version of specforge: in its environment, {0}")]
    Fields(String),
    /// The environment in it cannot be built (R0002).
    #[error("the environment in it cannot be built: {0}")]
    Blueprint(#[from] BlueprintError),
}

impl PolicyError {
    /// The diagnostic's code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Shape { .. } => "E0502",
            Self::NotFinite => "R0001",
            Self::Digest => "R0003",
            Self::Unsealed => "R0008",
            Self::Number(_) => "R0007",
            Self::Format(_)
            | Self::Contract(_)
            | Self::Version { .. }
            | Self::Fields(_)
            | Self::Blueprint(_) => "R0002",
        }
    }

    /// How to fix it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Format(_) => "name a `policy.safetensors` that `deploy.policy` wrote",
            Self::Shape { .. } => "the policy was trained with other observations or actions: train it again",
            Self::Contract(_) => {
                "run the policy on the robot and with the law it was trained for, or train it again"
            }
            Self::NotFinite => "train it again with a smaller learning rate",
            Self::Digest => {
                "copy or check it out again, or export it with `specforge run SPEC`; `evaluate --trust` \
                 runs it as it is"
            }
            Self::Unsealed => {
                "export it again with `specforge run SPEC`; `evaluate --trust` runs it nevertheless"
            }
            Self::Number(_) => "see `specforge explain R0007`",
            Self::Version { .. } | Self::Fields(_) | Self::Blueprint(_) => {
                "export it again with this specforge (`specforge run SPEC`), or use the version that wrote it"
            }
        }
    }
}

impl Policy {
    /// The policy of an actor that was trained in this environment.
    pub fn new(network: Network, blueprint: Blueprint, provenance: Provenance) -> Result<Self, PolicyError> {
        let contract =
            Contract::new(&blueprint.fields, &blueprint.robot, blueprint.motion.as_ref(), provenance);
        let policy = Self { network, contract, blueprint };
        policy.check()?;
        Ok(policy)
    }

    /// The artefact's bytes; equal policies have equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let contract = serde_json::to_string(&self.contract).expect("a contract is plain data");
        let samples = self.blueprint.motion.as_ref().map(frames::tensors).unwrap_or_default();
        let motion =
            self.blueprint.motion.as_ref().map(|motion| Motion { samples: Vec::new(), ..motion.clone() });
        let (fields, robot) = (self.blueprint.fields.clone(), self.blueprint.robot.clone());
        let blueprint = serde_json::to_string(&Blueprint { fields, robot, motion });
        let blueprint = blueprint.expect("a blueprint is plain data");
        let mut tensors = Tensors::new();
        self.network.insert_into("actor", &mut tensors);
        let texts = [
            ("actor.activation", self.network.activation.word()),
            ("blueprint", blueprint.as_str()),
            ("contract", contract.as_str()),
        ];
        let digest = file::digest(&tensors, &samples, &texts);
        file::write_with(&tensors, &samples, &[&texts[..], &[("digest", digest.as_str())]].concat())
    }

    /// Reads an artefact and checks that its digest fits and that it agrees with itself and with this
    /// version.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PolicyError> {
        Self::trusted(bytes, Trust::Digest)
    }

    /// As [`Policy::from_bytes`], with another guarantee for the bytes.
    pub fn trusted(bytes: &[u8], trust: Trust) -> Result<Self, PolicyError> {
        let format = |error: &dyn std::fmt::Display| PolicyError::Format(error.to_string());
        let (tensors, samples, header) = file::read_with(bytes).map_err(|error| format(&error))?;
        let text = |key: &str| {
            header
                .get(key)
                .map(String::as_str)
                .ok_or_else(|| PolicyError::Format(format!("its header lacks `{key}`")))
        };
        let (activation, contract, blueprint) =
            (text("actor.activation")?, text("contract")?, text("blueprint")?);
        check_version(contract)?;
        let texts = [("actor.activation", activation), ("blueprint", blueprint), ("contract", contract)];
        if trust == Trust::Digest {
            let known = header.get("digest").ok_or(PolicyError::Unsealed)?;
            if *known != file::digest(&tensors, &samples, &texts) {
                return Err(PolicyError::Digest);
            }
        }
        let activation = Activation::named(activation)
            .ok_or_else(|| PolicyError::Format("its activation is unknown".into()))?;
        let contract: Contract = serde_json::from_str(contract).map_err(|error| format(&error))?;
        let blueprint = read_blueprint(blueprint, &samples)?;
        let network = Network::take_from("actor", &tensors, activation).map_err(|error| format(&error))?;
        let policy = Self { network, contract, blueprint };
        policy.check()?;
        Ok(policy)
    }

    /// Refuses a robot other than the one that the policy was trained on.
    pub fn check_robot(&self, robot: &Robot) -> Result<(), PolicyError> {
        let digest = robot_digest(robot);
        if digest == self.contract.robot.digest {
            return Ok(());
        }
        let (own, other) = (&self.contract.robot, &robot.name);
        let message = format!(
            "it was made for robot `{}` ({:.12}), this is `{other}` ({digest:.12})",
            own.name, own.digest
        );
        Err(PolicyError::Contract(message))
    }

    fn check(&self) -> Result<(), PolicyError> {
        let (contract, blueprint) = (&self.contract, &self.blueprint);
        let shapes = [
            ("inputs", contract.inputs.len(), self.network.inputs()),
            ("outputs", contract.outputs.len(), self.network.outputs()),
        ];
        if let Some((side, expected, found)) =
            shapes.into_iter().find(|(_, expected, found)| expected != found)
        {
            return Err(PolicyError::Shape { side, expected, found });
        }
        if !self.network.is_finite() {
            return Err(PolicyError::NotFinite);
        }
        finite::check(contract)?;
        finite::check(blueprint)?;
        self.check_robot(&blueprint.robot)?;
        let provenance = contract.provenance.clone();
        let own = Contract::new(&blueprint.fields, &blueprint.robot, blueprint.motion.as_ref(), provenance);
        contract.difference(&own).map_or(Ok(()), |difference| Err(PolicyError::Contract(difference)))
    }
}

/// Refuses a contract with another layout before reading anything else of it.
fn check_version(contract: &str) -> Result<(), PolicyError> {
    let value: serde_json::Value =
        serde_json::from_str(contract).map_err(|error| PolicyError::Format(error.to_string()))?;
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(found) if found == u64::from(VERSION) => Ok(()),
        Some(found) => Err(PolicyError::Version { found }),
        None => Err(PolicyError::Format("its contract has no version".into())),
    }
}

/// The environment of a file.
fn read_blueprint(text: &str, samples: &Doubles) -> Result<Blueprint, PolicyError> {
    let format = |error: &dyn std::fmt::Display| PolicyError::Format(error.to_string());
    let mut blueprint: Blueprint = serde_json::from_str(text).map_err(|error| format(&error))?;
    if let Some(misfit) = fields::misfit(&blueprint.fields) {
        return Err(PolicyError::Fields(misfit));
    }
    let joints = blueprint.robot.joints();
    if let Some(motion) = blueprint.motion.as_mut().filter(|motion| motion.samples.is_empty()) {
        motion.samples = frames::samples(samples, joints).map_err(PolicyError::Format)?;
    }
    Ok(Blueprint::new(blueprint.fields, blueprint.robot, blueprint.motion)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Quantity, Value};

    /// The policies next to the reports.
    fn committed() -> Vec<Vec<u8>> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/reports/policies");
        let mut paths: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.retain(|path| path.extension().is_some_and(|end| end == "safetensors"));
        paths.sort();
        paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
    }

    /// The file with a replaced text in its header.
    fn changed(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
        let place = bytes
            .windows(from.len())
            .position(|window| window == from.as_bytes())
            .expect("it is in the file");
        let mut changed = [&bytes[..place], to.as_bytes(), &bytes[place + from.len()..]].concat();
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) + (to.len() - from.len()) as u64;
        changed[..8].copy_from_slice(&length.to_le_bytes());
        changed
    }

    #[test]
    fn the_committed_policies_are_read() {
        let committed = committed();
        assert!(committed.len() > 10, "{}", committed.len());
        committed.iter().for_each(|bytes| drop(Policy::from_bytes(bytes).unwrap()));
    }

    /// The file with changed header texts and a matching digest.
    fn resealed(bytes: &[u8], change: impl Fn(&mut std::collections::BTreeMap<String, String>)) -> Vec<u8> {
        let (tensors, samples, mut header) = file::read_with(bytes).unwrap();
        change(&mut header);
        let texts: Vec<(&str, &str)> =
            header.iter().map(|(key, text)| (key.as_str(), text.as_str())).collect();
        file::write_with(&tensors, &samples, &texts)
    }

    #[test]
    fn a_policy_without_a_digest_that_fits_is_read_only_when_the_user_trusts_it() {
        for bytes in committed() {
            let refused = |bytes: &[u8], code: &str| {
                assert_eq!(Policy::from_bytes(bytes).unwrap_err().code(), code);
                assert!(Policy::trusted(bytes, Trust::User).is_ok());
            };
            let bare = resealed(&bytes, |header| drop(header.remove("digest")));
            refused(&bare, "R0008");
            let other = resealed(&bytes, |header| drop(header.insert("digest".into(), "0".repeat(64))));
            refused(&other, "R0003");
            let empty = resealed(&bytes, |header| drop(header.insert("digest".into(), String::new())));
            refused(&empty, "R0003");
            let tanh =
                resealed(&bytes, |header| drop(header.insert("actor.activation".into(), "tanh".into())));
            refused(&tanh, "R0003");
        }
    }

    #[test]
    fn what_the_user_trusts_must_still_agree_with_itself() {
        let bytes = &committed()[0];
        let broken = resealed(bytes, |header| {
            let contract = header["contract"].replacen("\"control\":", "\"control\":1", 1);
            header.insert("contract".into(), contract);
        });
        assert_eq!(Policy::trusted(&broken, Trust::User).unwrap_err().code(), "R0002");
    }

    #[test]
    fn an_environment_that_no_spec_could_describe_is_refused_even_when_trusted() {
        let policy = Policy::from_bytes(&committed()[0]).unwrap();
        let refused = |change: &dyn Fn(&mut Blueprint)| {
            let mut changed = policy.clone();
            change(&mut changed.blueprint);
            let error = Policy::trusted(&changed.to_bytes(), Trust::User).unwrap_err();
            assert_eq!(error.code(), "R0002", "{error}");
            error.to_string()
        };
        let number = |blueprint: &mut Blueprint, section: &str, key: &str, si: f64| {
            let Some(Value::Table(table)) = blueprint.fields.get_mut(section) else {
                unreachable!("it is a table")
            };
            table.insert(key.into(), Value::Quantity(Quantity { si, text: String::new() }));
        };
        let said = refused(&|blueprint| number(blueprint, "terrain", "friction", -1.0));
        assert!(said.contains("`terrain.friction` is -1, not between 0 and 10"), "{said}");
        refused(&|blueprint| number(blueprint, "task", "episode", 0.0));
        refused(&|blueprint| number(blueprint, "task", "episode", 1e300));
        let said = refused(&|blueprint| {
            let Some(Value::Table(ground)) = blueprint.fields.get_mut("terrain") else {
                unreachable!("it is a table")
            };
            ground.extend([
                ("kind".into(), Value::Text("height_field".into())),
                ("seed".into(), Value::Count(1)),
            ]);
            for (key, si) in
                [("amplitude", 0.02), ("cell", 0.01), ("length", 1e3), ("width", 1e3), ("start", 0.4)]
            {
                number(blueprint, "terrain", key, si);
            }
        });
        assert!(said.contains("a field of 100001 by 100001 points is too large"), "{said}");
        let motion = |change: fn(&mut Motion)| {
            refused(&|blueprint| change(blueprint.motion.as_mut().expect("it has a motion")));
        };
        motion(|motion| motion.speed = 1e300);
        motion(|motion| motion.samples[0].base_height = -1e308);
        motion(|motion| motion.samples[0].base_orientation = [0.0; 4]);
        motion(|motion| motion.samples[0].position[0] = 1e308);
    }

    #[test]
    fn a_changed_activation_or_shape_is_refused() {
        let policy = Policy::from_bytes(&committed()[0]).unwrap();
        let bytes = policy.to_bytes();
        assert_eq!(Policy::from_bytes(&bytes).unwrap().network, policy.network);
        let activation = |name: &str| format!(r#"\"actor.activation\":\"{name}\""#);
        let tanh = changed(&bytes, &activation("relu"), &activation("tanh"));
        let error = Policy::from_bytes(&tanh).unwrap_err();
        assert!(matches!(error, PolicyError::Digest) && error.code() == "R0003", "{error}");
        // The same numbers, with the biases of a layer as a row.
        let width = policy.network.layers[0].outputs;
        let row = changed(&bytes, &format!("\"shape\":[{width}]"), &format!("\"shape\":[1,{width}]"));
        assert!(matches!(Policy::from_bytes(&row), Err(PolicyError::Digest)));
    }
}
