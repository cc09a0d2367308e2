//! Why there is no graph.

use super::fingerprint::Fingerprint;
use crate::diag::{Diagnostic, Span};

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
    #[error("two arms are named `{name}`")]
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
    #[error("the key of the stage `{stage}` is not the fingerprint of its recipe")]
    Tampered {
        /// The stage.
        stage: String,
    },
    /// A plan file one part of which denies another.
    #[error("the plan contradicts itself: {place}: {reason}")]
    Contradiction {
        /// The stage or arm.
        place: String,
        /// What does not agree.
        reason: String,
    },
    /// A plan file of a version that made a stage's numbers in another way.
    #[error(
        "the plan was saved by another version of specforge: the stage `{stage}` has {found}, this version \
         {now}"
    )]
    Version {
        /// The stage.
        stage: String,
        /// What the file says.
        found: String,
        /// What this version says.
        now: String,
    },
}

impl PlanError {
    /// The arm that it is about and the path in its spec, when a spec is to blame.
    pub fn place(&self) -> Option<(&str, &str)> {
        match self {
            Self::MissingProducer { arm, stage, .. } => Some((arm, stage)),
            Self::SameName { name } => Some((name, "name")),
            _ => None,
        }
    }

    /// What to write.
    fn help(&self) -> Option<&'static str> {
        match self {
            Self::MissingProducer { producer: "export", .. } => {
                Some("add the stage that exports the policy: `[deploy.policy]` with `kind = \"export\"`")
            }
            Self::MissingProducer { producer: "learner", .. } => Some("add the section `[learn]`"),
            Self::SameName { .. } => Some("give each spec its own `name`"),
            Self::Tampered { .. }
            | Self::Contradiction { .. }
            | Self::Version { .. }
            | Self::Unused { .. } => Some("save the plan again: `specforge plan SPEC --save PLAN.json`"),
            _ => None,
        }
    }

    /// The same for people and programs; with the place in the spec that is to blame, where there is one.
    pub fn diagnostic(&self, place: Option<Span>) -> Diagnostic {
        let plain = Diagnostic::error(self.code(), self.to_string());
        let placed = match place {
            Some(place) => plain.at(place, ""),
            None => plain,
        };
        self.help().into_iter().fold(placed, Diagnostic::help)
    }

    /// The diagnostic's code.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Cycle { .. } => "E0801",
            Self::Tampered { .. } | Self::Contradiction { .. } | Self::Unused { .. } => "E0811",
            Self::Version { .. } => "E0812",
            _ => "E0802",
        }
    }
}
