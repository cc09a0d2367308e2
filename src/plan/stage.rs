//! The stage kinds: the spec fields, inputs and artefact of each.
//!
//! A stage reads only the fields declared here, and its fingerprint covers exactly those.

use serde::{Deserialize, Serialize};

use super::field::Field;
use crate::kinds::action::Action;
use crate::kinds::deploy::{Deployment, Transfer};
use crate::kinds::evaluate::{Evaluation, Setting};
use crate::kinds::fine_tune;
use crate::kinds::initial::Initial;
use crate::kinds::learn::ppo::{Backend, Critic};
use crate::kinds::learn::{Learner, Ppo};
use crate::kinds::observe::Observations;
use crate::kinds::physics::Physics;
use crate::kinds::pretrain::Pretraining;
use crate::kinds::randomize::Rows;
use crate::kinds::reward::Rewards;
use crate::kinds::task::{Task, Walk};
use crate::kinds::terminate::Terminations;
use crate::kinds::terrain::Ground;
use crate::sim::EngineName;
use crate::spec::section::{Header, Report, Robot};
use crate::spec::{Section, Table};

/// A kind of stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StageKind {
    /// The checked robot model.
    Robot,
    /// The reference motion on that robot.
    Motion,
    /// The environment blueprint.
    Env,
    /// The low-level control law.
    Controller,
    /// Pre-training of the actor by regression.
    Pretrain,
    /// Reinforcement learning.
    Learner,
    /// Reinforcement learning that continues from a policy in a changed environment.
    FineTune,
    /// Evaluation of a policy in its training engine.
    Evaluate,
    /// The policy as an artefact with its contract.
    Export,
    /// Evaluation of the exported policy in another engine.
    Transfer,
    /// The report over all arms.
    Report,
}

/// Number of threads that a stage can use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    /// One.
    One,
    /// All available ones.
    Max,
}

/// An input that a stage takes from another stage of its arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// The role: the consumer's name for the artefact.
    pub role: &'static str,
    /// The kind of the producer.
    pub producer: StageKind,
    /// Whether an arm may lack the producer.
    pub optional: bool,
}

/// Constant properties of a stage kind.
#[derive(Clone, Copy, Debug)]
pub struct Facts {
    /// Its name, also its folder in the store.
    pub name: &'static str,
    /// The spec fields it declares. `evaluate` and `deploy` stand for the one table `evaluate.NAME` or
    /// `deploy.NAME` that the stage was made from; NAME itself is not read.
    pub fields: &'static [Field],
    /// Its inputs. A report takes all other stages as inputs.
    pub inputs: &'static [Input],
    /// Raised when the code gives another result for the same input; if only specs with one kind are
    /// affected, that kind gets a revision instead ([`super::revision`]).
    pub epoch: u32,
    /// How many threads it can use.
    pub threads: Threads,
    /// Its artefact, for labels of edges.
    pub artefact: &'static str,
}

const fn needs(role: &'static str, producer: StageKind) -> Input {
    Input { role, producer, optional: false }
}

const fn takes(role: &'static str, producer: StageKind) -> Input {
    Input { role, producer, optional: true }
}

/// Inputs of stages that run episodes of a policy. [`super::draft`] decides which of an arm's trainings
/// provides the environment and the policy.
const POLICY_INPUTS: &[Input] = &[
    needs("env", StageKind::Env),
    needs("controller", StageKind::Controller),
    needs("learner", StageKind::Learner),
];

const ROBOT: Facts = Facts {
    name: "robot",
    fields: &[Field::section::<Robot>()],
    inputs: &[],
    epoch: 1,
    threads: Threads::One,
    artefact: "robot model",
};

const MOTION: Facts = Facts {
    name: "motion",
    fields: &[Field::key(Walk::motion)],
    inputs: &[needs("robot", StageKind::Robot)],
    epoch: 1,
    threads: Threads::One,
    artefact: "reference motion",
};

const ENV: Facts = Facts {
    name: "env",
    fields: &[
        Field::section::<Physics>(),
        Field::section::<Ground>(),
        Field::section::<Task>(),
        Field::section::<Initial>(),
        Field::section::<Observations>(),
        Field::section::<Rewards>(),
        Field::section::<Terminations>(),
        Field::section::<Rows>(),
        Field::section::<Action>(),
        Field::key(Ppo::symmetry),
        Field::within(Ppo::value, Critic::privileged),
    ],
    inputs: &[needs("robot", StageKind::Robot), takes("motion", StageKind::Motion)],
    epoch: 1,
    threads: Threads::One,
    artefact: "environment blueprint",
};

const CONTROLLER: Facts = Facts {
    name: "controller",
    fields: &[Field::section::<Action>()],
    inputs: &[needs("robot", StageKind::Robot)],
    epoch: 1,
    threads: Threads::One,
    artefact: "control law",
};

const PRETRAIN: Facts = Facts {
    name: "pretrain",
    fields: &[
        Field::section::<Pretraining>(),
        Field::section::<Observations>(),
        Field::section::<Action>(),
        Field::key(Physics::rate),
        Field::kind::<Task>(),
        Field::key(Walk::command),
        Field::key(Ppo::policy),
        Field::key(Ppo::seed),
        Field::key(Ppo::symmetry),
    ],
    inputs: &[
        needs("robot", StageKind::Robot),
        takes("motion", StageKind::Motion),
        needs("controller", StageKind::Controller),
    ],
    epoch: 3,
    threads: Threads::Max,
    artefact: "pre-trained actor",
};

const LEARNER: Facts = Facts {
    name: "learner",
    fields: &[Field::section::<Learner>()],
    inputs: &[
        needs("env", StageKind::Env),
        needs("controller", StageKind::Controller),
        takes("pretrain", StageKind::Pretrain),
    ],
    epoch: 5,
    threads: Threads::Max,
    artefact: "policy",
};

const FINE_TUNE: Facts = Facts {
    name: "fine_tune",
    fields: &[
        Field::section::<Learner>(),
        Field::key(fine_tune::Ppo::samples),
        Field::key(fine_tune::Ppo::learning_rate),
        Field::key(fine_tune::Ppo::warm_up),
    ],
    inputs: POLICY_INPUTS,
    epoch: 3,
    threads: Threads::Max,
    artefact: "policy",
};

const EVALUATE: Facts = Facts {
    name: "evaluate",
    fields: &[Field::section::<Evaluation>()],
    inputs: POLICY_INPUTS,
    epoch: 4,
    threads: Threads::Max,
    artefact: "evaluation",
};

const EXPORT: Facts = Facts {
    name: "export",
    fields: &[Field::section::<Deployment>()],
    inputs: POLICY_INPUTS,
    epoch: 2,
    threads: Threads::One,
    artefact: "policy artefact",
};

const TRANSFER: Facts = Facts {
    name: "transfer",
    fields: &[Field::section::<Deployment>()],
    inputs: &[needs("env", StageKind::Env), needs("policy", StageKind::Export)],
    epoch: 4,
    threads: Threads::Max,
    artefact: "evaluation",
};

const REPORT: Facts = Facts {
    name: "report",
    fields: &[Field::section::<Report>(), Field::header(Header::name), Field::header(Header::summary)],
    inputs: &[],
    epoch: 2,
    threads: Threads::One,
    artefact: "report",
};

impl StageKind {
    /// All kinds in the order of the pipeline.
    pub const ALL: [Self; 11] = [
        Self::Robot,
        Self::Motion,
        Self::Env,
        Self::Controller,
        Self::Pretrain,
        Self::Learner,
        Self::FineTune,
        Self::Evaluate,
        Self::Export,
        Self::Transfer,
        Self::Report,
    ];

    /// Its name, also its folder in the store.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Whether its artefact follows from the spec alone, without training or simulation, within a second.
    pub fn is_of_spec_alone(self) -> bool {
        matches!(self, Self::Robot | Self::Motion | Self::Env | Self::Controller)
    }

    /// The static facts.
    pub const fn facts(self) -> Facts {
        match self {
            Self::Robot => ROBOT,
            Self::Motion => MOTION,
            Self::Env => ENV,
            Self::Controller => CONTROLLER,
            Self::Pretrain => PRETRAIN,
            Self::Learner => LEARNER,
            Self::FineTune => FINE_TUNE,
            Self::Evaluate => EVALUATE,
            Self::Export => EXPORT,
            Self::Transfer => TRANSFER,
            Self::Report => REPORT,
        }
    }
}

/// The versions that numbers depend on, in addition to the code's epoch. An engine counts where it is chosen;
/// later stages depend on it through their inputs.
pub fn numeric_identity(kind: StageKind, fields: &Table) -> Vec<String> {
    let fields = Section::new(fields);
    let library = match kind {
        StageKind::Env => engine_identity(fields.at(Physics::engine)),
        StageKind::Evaluate => engine_identity(fields.at(Setting::engine)),
        StageKind::Transfer => engine_identity(fields.at(Transfer::engine)),
        StageKind::Pretrain => Some("gemm 0.19.0, f32"),
        StageKind::Learner | StageKind::FineTune => match fields.at(Ppo::backend) {
            Some(Backend::Torch) => Some("libtorch 2.13.0, f32"),
            _ => Some("gemm 0.19.0, f32"),
        },
        StageKind::Robot
        | StageKind::Motion
        | StageKind::Controller
        | StageKind::Export
        | StageKind::Report => None,
    };
    library.map(str::to_owned).into_iter().collect()
}

fn engine_identity(engine: Option<EngineName>) -> Option<&'static str> {
    Some(engine?.facts().numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Value;

    #[test]
    fn the_learners_identity_is_that_of_its_backend() {
        let identity = |backend: Option<&str>| {
            let backend = backend.map(|name| ("backend".to_owned(), Value::Text(name.into())));
            let learn = Value::Table(backend.into_iter().collect());
            numeric_identity(StageKind::Learner, &Table::from([("learn".to_owned(), learn)]))
        };
        assert_eq!(identity(None), ["gemm 0.19.0, f32"]);
        assert_eq!(identity(Some("native")), identity(None));
        assert_eq!(identity(Some("torch")), ["libtorch 2.13.0, f32"]);
    }

    #[test]
    fn producers_stand_before_their_consumers() {
        for kind in StageKind::ALL {
            for input in kind.facts().inputs {
                assert!(input.producer < kind, "{} takes {}", kind.name(), input.producer.name());
            }
        }
    }

    #[test]
    fn the_serialised_name_is_the_folder() {
        for kind in StageKind::ALL {
            assert_eq!(serde_json::to_value(kind).expect("a word"), kind.name());
        }
    }
}
