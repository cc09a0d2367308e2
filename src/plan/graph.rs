//! The dataflow graph: stages and the artefacts between them.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::Direction;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;
use serde::{Deserialize, Serialize};

use super::arm::Request;
use super::error::PlanError;
use super::fingerprint::{Fingerprint, Recipe, canonical_json};
use super::sections::Sections;
use super::shared::Shared;
use super::stage::StageKind;
use super::suite::{RunRecord, SuiteRecord};
use super::{draft, neutral};
use crate::spec::{Table, Value};

/// One use of a stage: an arm and the stage's name in it (`learner`, `evaluate.nominal`).
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct User {
    /// The arm; the report's name for a report.
    pub arm: String,
    /// The name of the stage in that arm.
    pub stage: String,
}

/// A node of the graph: one unit of work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// What it does.
    pub kind: StageKind,
    /// Its key: the fingerprint of its recipe.
    pub fingerprint: Fingerprint,
    /// Its uses, in the order of the arms. Stages with the same fingerprint are one node.
    pub users: Vec<User>,
    /// The declared fields, decoded, with the author's texts. An `evaluate.NAME` or `deploy.NAME` table is
    /// stored as `evaluate` or `deploy`.
    pub fields: Shared<Table>,
    /// The origins of the fields' values, by dotted path as in `fields`.
    pub origins: Shared<BTreeMap<String, String>>,
    /// The content of the fingerprint.
    pub recipe: Recipe,
}

impl Stage {
    /// The stage's name, as in the first arm that uses it.
    pub fn name(&self) -> &str {
        &self.users[0].stage
    }

    /// The path of a value in the recipe that differs from the fields. Values that affect no result are
    /// ignored: later versions leave more of them out of a recipe.
    pub fn hidden_field(&self) -> Option<String> {
        difference(&neutral::fields(&self.fields), &neutral::stripped(&self.recipe.fields))
    }
}

/// The path of the first value in which two trees differ.
fn difference(one: &serde_json::Value, other: &serde_json::Value) -> Option<String> {
    match (one.as_object(), other.as_object()) {
        (Some(own), Some(others)) => own.keys().chain(others.keys()).find_map(|key| {
            let [one, other] = [own, others].map(|map| map.get(key).unwrap_or(&serde_json::Value::Null));
            let below = difference(one, other)?;
            Some(if below.is_empty() { key.clone() } else { format!("{key}.{below}") })
        }),
        _ => (canonical_json(one) != canonical_json(other)).then(String::new),
    }
}

/// An artefact that one stage passes to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// The consumer's name for it.
    pub role: String,
    /// Its kind.
    pub artefact: String,
}

/// What a report needs of an arm in addition to its artefacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmRecord {
    /// Its name.
    pub name: String,
    /// The command-line arguments that selected it.
    pub request: Request,
    /// All its decoded fields.
    pub fields: Sections,
    /// The origin of each value.
    pub origins: Shared<BTreeMap<String, String>>,
    /// Its stages by name.
    pub stages: BTreeMap<String, Fingerprint>,
    /// The accepted warnings, with their reasons.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub allow: BTreeMap<String, String>,
    /// Its position in its suite, if it is a run of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<RunRecord>,
}

/// The graph of a run. Serialised, it is the file that `specforge stage --plan` reads (`saved`).
#[derive(Clone, Debug)]
pub struct Plan {
    /// The arms in the order of the command line; for a suite, its runs in the order of arms and seeds.
    pub arms: Vec<ArmRecord>,
    /// The suite, if the plan is of one.
    pub suite: Option<SuiteRecord>,
    graph: DiGraph<Stage, Edge>,
    index: BTreeMap<Fingerprint, NodeIndex>,
    order: Vec<NodeIndex>,
}

impl Plan {
    /// The graph of these stages, each after its inputs.
    pub fn new(arms: Vec<ArmRecord>, stages: Vec<Stage>) -> Result<Self, PlanError> {
        let mut graph = DiGraph::new();
        let mut index = BTreeMap::new();
        for stage in stages {
            let key = stage.fingerprint.clone();
            index.insert(key, graph.add_node(stage));
        }
        for consumer in graph.node_indices().collect::<Vec<_>>() {
            let inputs = graph[consumer].recipe.inputs.clone();
            for (role, fingerprint) in inputs {
                let missing =
                    || PlanError::MissingInput { stage: graph[consumer].name().into(), role: role.clone() };
                let producer = *index.get(&fingerprint).ok_or_else(missing)?;
                let artefact = graph[producer].kind.facts().artefact.into();
                graph.add_edge(producer, consumer, Edge { role, artefact });
            }
        }
        if let Err(cycle) = petgraph::algo::toposort(&graph, None) {
            return Err(PlanError::Cycle { stage: graph[cycle.node_id()].name().into() });
        }
        let order = graph.node_indices().collect();
        Ok(Self { arms, suite: None, graph, index, order })
    }

    /// The scope of its arms' names: the suite, if there is one, and the profile. Arms of different suites
    /// may have the same names.
    pub fn scope(&self) -> String {
        let suite = self.suite.as_ref().map_or("", |suite| suite.name.as_str());
        let profile = self.arms.first().and_then(|arm| arm.request.profile.as_deref()).unwrap_or_default();
        format!("{suite}/{profile}")
    }

    /// The same plan with another name of the report.
    pub fn reported_as(mut self, name: &str) -> Result<Self, PlanError> {
        let suite = self.suite.take();
        let mut stages: Vec<Stage> = self.stages().cloned().collect();
        for stage in stages.iter_mut().filter(|stage| stage.kind == StageKind::Report) {
            stage.users.iter_mut().for_each(|user| user.arm = name.to_owned());
            stage.fields.insert("name".into(), Value::Text(name.to_owned()));
            stage.recipe.fields = neutral::fields(&stage.fields).into();
            stage.fingerprint = stage.recipe.fingerprint();
        }
        let plan = Self::new(self.arms, stages)?;
        Ok(Self { suite, ..plan })
    }

    /// All stages, producers before consumers, in the order of arms and pipeline.
    pub fn stages(&self) -> impl DoubleEndedIterator<Item = &Stage> + ExactSizeIterator {
        self.order.iter().map(|node| &self.graph[*node])
    }

    /// Whether every arm that uses a stage accepts a warning with this code.
    pub fn allows(&self, stage: &Stage, code: &str) -> bool {
        let mut users =
            self.arms.iter().filter(|arm| stage.users.iter().any(|user| user.arm == arm.name)).peekable();
        users.peek().is_some() && users.all(|arm| arm.allow.contains_key(code))
    }

    /// The stage with this key.
    pub fn stage(&self, fingerprint: &Fingerprint) -> Option<&Stage> {
        self.index.get(fingerprint).map(|node| &self.graph[*node])
    }

    /// The path in the spec's file of a path in a stage's `fields` (`evaluate.episodes` is
    /// `evaluate.nominal.episodes`).
    pub fn spec_path(&self, stage: &Stage, path: &str) -> String {
        let arm = self.arms.iter().find(|arm| arm.name == stage.users[0].arm);
        let written = arm.map(|arm| arm.fields.only(&["deploy", "evaluate", "fine_tune"]));
        draft::spec_path(stage.kind, stage.name(), path, written.as_ref())
    }

    /// The inputs of a stage: producers and edges in the order of their roles.
    pub fn inputs(&self, stage: &Stage) -> Vec<(&Stage, &Edge)> {
        let node = self.index[&stage.fingerprint];
        let mut inputs: Vec<_> = self
            .graph
            .edges_directed(node, Direction::Incoming)
            .map(|edge| (&self.graph[edge.source()], edge.weight()))
            .collect();
        inputs.sort_by(|a, b| a.1.role.cmp(&b.1.role));
        inputs
    }

    /// The stages that use this stage's artefact.
    pub fn consumers(&self, stage: &Stage) -> BTreeSet<Fingerprint> {
        let node = self.index[&stage.fingerprint];
        self.graph
            .neighbors_directed(node, Direction::Outgoing)
            .map(|consumer| self.graph[consumer].fingerprint.clone())
            .collect()
    }

    /// All stages upstream or downstream of a stage, including itself.
    pub fn reachable(&self, stage: &Stage, direction: Direction) -> BTreeSet<Fingerprint> {
        let mut found = BTreeSet::new();
        let mut open = vec![self.index[&stage.fingerprint]];
        while let Some(node) = open.pop() {
            if found.insert(self.graph[node].fingerprint.clone()) {
                open.extend(self.graph.neighbors_directed(node, direction));
            }
        }
        found
    }

    /// A stage's name for display, unique in the plan: `learner` if all arms share it, otherwise `ARM/learner`
    /// with the first arm; if it belongs to all runs of a suite's arm and to no others, without the seed.
    pub fn label(&self, stage: &Stage) -> String {
        let arms: BTreeSet<&str> = stage.users.iter().map(|user| user.arm.as_str()).collect();
        if arms.len() >= self.arms.len().max(1) || stage.kind == StageKind::Report {
            return stage.name().to_owned();
        }
        let first = stage.users[0].arm.as_str();
        let arm_of = |record: &ArmRecord| record.run.as_ref().map(|run| run.arm.clone());
        let arm = self.arms.iter().find(|record| record.name == first).and_then(arm_of);
        let shared = arm.filter(|arm| {
            let runs = self.arms.iter().filter(|record| arm_of(record).as_ref() == Some(arm));
            arms.len() > 1 && runs.map(|run| run.name.as_str()).collect::<BTreeSet<_>>() == arms
        });
        format!("{}/{}", shared.as_deref().unwrap_or(first), stage.name())
    }

    /// The stages that match a user's word: `ARM/STAGE`, a stage's name, a kind, or at least six digits of a
    /// key. The arm may be a run of a suite, all runs of one of its arms, or a run's id.
    pub fn find(&self, word: &str) -> Vec<&Stage> {
        let (arm, stage) = word.rsplit_once('/').unwrap_or_default();
        let runs = self.arms.iter().filter_map(|record| Some((record.run.as_ref()?, record)));
        let runs = runs.filter(|(run, _)| !arm.is_empty() && (run.arm == arm || run.id == arm));
        let keys: BTreeSet<&Fingerprint> = runs.filter_map(|(_, record)| record.stages.get(stage)).collect();
        if !keys.is_empty() {
            return self.stages().filter(|stage| keys.contains(&stage.fingerprint)).collect();
        }
        self.stages()
            .filter(|stage| {
                stage.kind.name() == word
                    || (word.len() >= 6 && stage.fingerprint.as_str().starts_with(word))
                    || stage
                        .users
                        .iter()
                        .any(|user| user.stage == word || format!("{}/{}", user.arm, user.stage) == word)
            })
            .collect()
    }

    /// All words that [`Plan::find`] understands, except keys; for a suite, without those of single runs.
    pub fn words(&self) -> BTreeSet<String> {
        if self.suite.is_some() {
            let of_arm = |record: &ArmRecord| record.run.as_ref().map(|run| format!("{}/learner", run.arm));
            let names = self.stages().map(|stage| stage.name().to_owned());
            return names.chain(self.arms.iter().filter_map(of_arm)).collect();
        }
        self.stages()
            .flat_map(|stage| &stage.users)
            .flat_map(|user| [user.stage.clone(), format!("{}/{}", user.arm, user.stage)])
            .collect()
    }
}
