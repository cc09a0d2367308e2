//! Selection of the stages that a run may execute: `--only`, `--from`, `--until`.

use std::collections::BTreeSet;

use petgraph::Direction;

use super::fingerprint::Fingerprint;
use super::graph::Plan;

/// The words of the command line; empty lists select everything.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// These stages.
    pub only: Vec<String>,
    /// These stages and all that depend on them.
    pub from: Vec<String>,
    /// These stages and all that they depend on.
    pub until: Vec<String>,
}

/// A word that matches no stage.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("no stage is called `{word}`; the stages are {}", known.join(", "))]
pub struct UnknownStage {
    /// The word.
    pub word: String,
    /// The valid words.
    pub known: Vec<String>,
}

impl Selection {
    /// The keys of the selected stages: the intersection of what the three options allow.
    pub fn apply(&self, plan: &Plan) -> Result<BTreeSet<Fingerprint>, UnknownStage> {
        let mut selected: BTreeSet<Fingerprint> =
            plan.stages().map(|stage| stage.fingerprint.clone()).collect();
        let options = [
            (&self.only, None),
            (&self.from, Some(Direction::Outgoing)),
            (&self.until, Some(Direction::Incoming)),
        ];
        for (words, direction) in options {
            if !words.is_empty() {
                let allowed = reach(plan, words, direction)?;
                selected.retain(|key| allowed.contains(key));
            }
        }
        Ok(selected)
    }
}

fn reach(
    plan: &Plan,
    words: &[String],
    direction: Option<Direction>,
) -> Result<BTreeSet<Fingerprint>, UnknownStage> {
    let mut keys = BTreeSet::new();
    for word in words {
        let stages = plan.find(word);
        if stages.is_empty() {
            return Err(UnknownStage { word: word.clone(), known: plan.words().into_iter().collect() });
        }
        for stage in stages {
            match direction {
                None => drop(keys.insert(stage.fingerprint.clone())),
                Some(direction) => keys.extend(plan.reachable(stage, direction)),
            }
        }
    }
    Ok(keys)
}
