//! Errors of plans.

use super::fingerprint::Fingerprint;
use crate::diag::{Diagnostic, Span};

/// Why a plan could not be made or read.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// A stage needs an input that no stage of its arm produces.
    #[error("{arm}: `{stage}` needs a stage of the kind `{producer}`, and the spec declares none")]
    MissingProducer {
        /// The arm.
        arm: String,
        /// The consumer.
        stage: String,
        /// The missing kind of stage.
        producer: &'static str,
    },
    /// Two arms with the same name.
    #[error("two arms are named `{name}`")]
    SameName {
        /// The name.
        name: String,
    },
    /// A stage of a plan file has an input that is not in the file.
    #[error("the input `{role}` of the stage `{stage}` is not in the plan")]
    MissingInput {
        /// The consumer.
        stage: String,
        /// The role of the input.
        role: String,
    },
    /// A plan file whose stages depend on each other in a cycle.
    #[error("the stage `{stage}` depends on itself")]
    Cycle {
        /// A stage of the cycle.
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
    /// A plan file that contradicts itself.
    #[error("the plan contradicts itself: {place}: {reason}")]
    Contradiction {
        /// The stage or arm.
        place: String,
        /// The contradiction.
        reason: String,
    },
    /// A plan file whose parts are not those that were saved.
    #[error("the plan was edited after it was saved: {parts} {}not what was saved{}", verb(.parts), reason(.found))]
    Edited {
        /// The places in the file, as code.
        parts: String,
        /// What else is known; may be empty.
        found: String,
    },
    /// A plan file without digests.
    #[error("the plan has no digests of its parts: they were removed, or it is of a version before them")]
    Undigested,
    /// A plan file of a version that computed a stage's numbers differently.
    #[error(
        "the plan was saved by another version of specforge: the stage `{stage}` has {found}, this version \
         {now}"
    )]
    Version {
        /// The stage.
        stage: String,
        /// Value in the file.
        found: String,
        /// Value in this version.
        now: String,
    },
}

fn verb(parts: &str) -> &'static str {
    if parts.contains(", ") { "are " } else { "is " }
}

fn reason(found: &str) -> String {
    if found.is_empty() { String::new() } else { format!(" ({found})") }
}

impl PlanError {
    /// What a file of another version says in the place of this one.
    pub(super) fn found(&self) -> String {
        match self {
            Self::Version { stage, found, now } => {
                format!("the stage `{stage}` has {found}, this version {now}")
            }
            other => other.to_string(),
        }
    }

    /// The affected arm and path in its spec, if the spec is the cause.
    pub fn place(&self) -> Option<(&str, &str)> {
        match self {
            Self::MissingProducer { arm, stage, .. } => Some((arm, stage)),
            Self::SameName { name } => Some((name, "name")),
            _ => None,
        }
    }

    /// The fix.
    fn help(&self) -> Option<&'static str> {
        match self {
            Self::MissingProducer { producer: "export", .. } => {
                Some("add `[deploy.policy]` with `kind = \"export\"`")
            }
            Self::MissingProducer { producer: "learner", .. } => Some("add the section `[learn]`"),
            Self::SameName { .. } => Some("give each spec its own `name`"),
            Self::Tampered { .. }
            | Self::Contradiction { .. }
            | Self::Edited { .. }
            | Self::Undigested
            | Self::Version { .. }
            | Self::Unused { .. } => Some("save the plan again: `specforge plan SPEC --save PLAN.json`"),
            _ => None,
        }
    }

    /// The diagnostic, with its location in the spec if the spec is the cause.
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
            Self::Tampered { .. }
            | Self::Contradiction { .. }
            | Self::Edited { .. }
            | Self::Undigested
            | Self::Unused { .. } => "E0811",
            Self::Version { .. } => "E0812",
            _ => "E0802",
        }
    }
}
