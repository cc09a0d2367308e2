//! Why there is no graph.

use super::fingerprint::Fingerprint;

/// Why there is no graph.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// A stage takes in something that no stage of its arm makes.
    #[error("{arm}: `{stage}` needs a stage of the kind `{producer}`, and the spec declares none")]
    MissingProducer {
        /// The arm.
        arm: String,
        /// The consumer.
        stage: String,
        /// What it lacks.
        producer: &'static str,
    },
    /// Two arms with one name.
    #[error("two arms are named `{name}`; give each spec its own `name`")]
    SameName {
        /// The name.
        name: String,
    },
    /// A plan file names an input that it does not hold.
    #[error("the input `{role}` of the stage `{stage}` is not in the plan")]
    MissingInput {
        /// The consumer.
        stage: String,
        /// The role of the input.
        role: String,
    },
    /// A plan file whose stages depend on each other in a circle.
    #[error("the stage `{stage}` depends on itself")]
    Cycle {
        /// A stage of the circle.
        stage: String,
    },
    /// A plan file with a stage that no arm uses.
    #[error("no arm uses the stage with the key {key}")]
    Unused {
        /// Its key.
        key: Fingerprint,
    },
    /// A plan file that was edited.
    #[error("the key of the stage `{stage}` is not the fingerprint of its recipe; write the plan again")]
    Tampered {
        /// The stage.
        stage: String,
    },
}

impl PlanError {
    /// The diagnostic's code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Cycle { .. } => "E0801",
            _ => "E0802",
        }
    }
}
