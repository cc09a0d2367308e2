//! Lowering: arms in, graph out. Stages of equal fingerprint become one node that the arms share.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::fingerprint::{Fingerprint, Recipe};
use super::graph::{ArmRecord, Plan, Stage, User};
use super::stage::{self, StageKind};
use crate::spec::value::canonical_table;
use crate::spec::{Table, Value};

/// One arm of a comparison: a resolved spec and the contents of the files that it names.
#[derive(Clone, Debug)]
pub struct Arm {
    /// The arm's name, unique within a plan.
    pub name: String,
    /// The decoded spec.
    pub fields: Table,
    /// Where each value comes from, by dotted path: `specs/run.toml:12`, `--set`, `default`.
    pub origins: BTreeMap<String, String>,
    /// The resolved robot.
    pub robot: serde_json::Value,
    /// The decoded motion file, for tasks with a reference motion; the text of a clip stands under
    /// `clip`. It is the section `motion` of the motion stage, so origins under `motion.` belong to it.
    pub motion: Option<Table>,
    /// How the user asked for it.
    pub request: Request,
}

/// How the user asked for an arm, for the command that a report prints.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// The spec's file as the user named it.
    pub spec: String,
    /// The profile, when one was chosen.
    pub profile: Option<String>,
    /// Assignments given with `--set`, as written.
    pub assignments: Vec<String>,
}

/// What a report depends on beside the arms.
#[derive(Clone, Debug)]
pub struct ReportSource {
    /// Its name; `reports/NAME.md` is what it becomes.
    pub name: String,
    /// Digest of the templates that it is rendered with.
    pub templates: String,
}

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

/// Lowers arms to the graph. Without a [`ReportSource`] there is no report stage.
pub fn lower(arms: &[Arm], report: Option<&ReportSource>) -> Result<Plan, PlanError> {
    let mut nodes = Nodes::default();
    let mut records = Vec::new();
    for arm in arms {
        if records.iter().any(|record: &ArmRecord| record.name == arm.name) {
            return Err(PlanError::SameName { name: arm.name.clone() });
        }
        records.push(lower_arm(arm, &mut nodes)?);
    }
    if let (Some(source), Some(first)) = (report, arms.first()) {
        nodes.add(report_stage(source, first, &records), User { arm: source.name.clone(), stage: "report".into() });
    }
    Plan::new(records, nodes.stages)
}

/// Stages so far, each once.
#[derive(Default)]
struct Nodes {
    stages: Vec<Stage>,
}

impl Nodes {
    fn add(&mut self, stage: Stage, user: User) -> Fingerprint {
        let key = stage.fingerprint.clone();
        match self.stages.iter_mut().find(|known| known.fingerprint == key) {
            Some(known) => known.users.push(user),
            None => self.stages.push(Stage { users: vec![user], ..stage }),
        }
        key
    }
}

/// A stage before it knows its inputs.
struct Draft {
    kind: StageKind,
    name: String,
    fields: Table,
    origins: BTreeMap<String, String>,
    content: serde_json::Value,
}

fn lower_arm(arm: &Arm, nodes: &mut Nodes) -> Result<ArmRecord, PlanError> {
    let mut made: Vec<(StageKind, Fingerprint)> = Vec::new();
    let mut stages = BTreeMap::new();
    for draft in drafts(arm) {
        let mut inputs = BTreeMap::new();
        for input in draft.kind.facts().inputs {
            match made.iter().find(|(kind, _)| *kind == input.producer) {
                Some((_, key)) => {
                    inputs.insert(input.role.to_owned(), key.clone());
                }
                None if input.optional => {}
                None => {
                    let (arm, stage) = (arm.name.clone(), draft.name);
                    return Err(PlanError::MissingProducer { arm, stage, producer: input.producer.name() });
                }
            }
        }
        let (kind, name) = (draft.kind, draft.name.clone());
        let key = nodes.add(finish(draft, inputs), User { arm: arm.name.clone(), stage: name.clone() });
        stages.insert(name, key.clone());
        made.push((kind, key));
    }
    let (name, request) = (arm.name.clone(), arm.request.clone());
    Ok(ArmRecord { name, request, fields: arm.fields.clone(), origins: arm.origins.clone(), stages })
}

/// The stages of an arm in the order of the pipeline.
fn drafts(arm: &Arm) -> Vec<Draft> {
    let mut drafts = vec![plain(arm, StageKind::Robot, arm.robot.clone())];
    if let Some(motion) = &arm.motion {
        drafts.push(motion_draft(arm, motion));
    }
    drafts.push(plain(arm, StageKind::Env, json!(null)));
    drafts.push(plain(arm, StageKind::Controller, json!(null)));
    if arm.fields.contains_key("pretrain") {
        drafts.push(plain(arm, StageKind::Pretrain, json!(null)));
    }
    if arm.fields.contains_key("learn") {
        drafts.push(plain(arm, StageKind::Learner, json!(null)));
    }
    drafts.extend(terms(arm, "evaluate").map(|(name, table)| term(arm, StageKind::Evaluate, name, table)));
    let deploys = |transfer: bool| terms(arm, "deploy").filter(move |(_, table)| is_transfer(table) == transfer);
    drafts.extend(deploys(false).map(|(name, table)| term(arm, StageKind::Export, name, table)));
    drafts.extend(deploys(true).map(|(name, table)| term(arm, StageKind::Transfer, name, table)));
    drafts
}

fn terms<'a>(arm: &'a Arm, section: &str) -> impl Iterator<Item = (&'a str, &'a Table)> + use<'a> {
    let table = match arm.fields.get(section) {
        Some(Value::Table(table)) => Some(table),
        _ => None,
    };
    table.into_iter().flatten().filter_map(|(name, value)| match value {
        Value::Table(table) => Some((name.as_str(), table)),
        _ => None,
    })
}

fn is_transfer(table: &Table) -> bool {
    table.get("kind") == Some(&Value::Text("transfer".into()))
}

/// A stage that declares fixed paths.
fn plain(arm: &Arm, kind: StageKind, content: serde_json::Value) -> Draft {
    let mut fields = Table::new();
    for path in kind.facts().fields {
        copy_path(&arm.fields, path, &mut fields);
    }
    let declared = |path: &str| kind.facts().fields.iter().any(|field| covers(field, path));
    let origins = arm.origins.iter().filter(|(path, _)| declared(path));
    let origins = origins.map(|(path, origin)| (path.clone(), origin.clone())).collect();
    Draft { kind, name: kind.name().into(), fields, origins, content }
}

/// The motion stage: the spec says which, the motion's own file says what it is.
fn motion_draft(arm: &Arm, motion: &Table) -> Draft {
    let mut draft = plain(arm, StageKind::Motion, json!(null));
    draft.fields.insert("motion".into(), Value::Table(motion.clone()));
    let own = arm.origins.iter().filter(|(path, _)| path.starts_with("motion."));
    draft.origins.extend(own.map(|(path, origin)| (path.clone(), origin.clone())));
    draft
}

/// A stage made from the table `evaluate.NAME` or `deploy.NAME`.
fn term(arm: &Arm, kind: StageKind, name: &str, table: &Table) -> Draft {
    let section = kind.facts().fields[0];
    let path = format!("{section}.{name}");
    let origins = arm.origins.iter().filter_map(|(place, origin)| {
        let rest = place.strip_prefix(&path)?;
        (rest.is_empty() || rest.starts_with('.')).then(|| (format!("{section}{rest}"), origin.clone()))
    });
    let mut origins: BTreeMap<_, _> = origins.collect();
    let mut table = table.clone();
    if kind == StageKind::Transfer {
        inherit_protocol(arm, &mut table, &mut origins);
    }
    let fields = Table::from([(section.to_owned(), Value::Table(table))]);
    Draft { kind, name: path, fields, origins, content: json!(null) }
}

/// What a transfer and an evaluation can both say.
const PROTOCOL: [&str; 5] = ["command", "episodes", "perturbation", "seed", "time_limit"];

/// What a transfer does not say of its protocol it takes from `evaluate.nominal`, so that both engines
/// answer the same question.
fn inherit_protocol(arm: &Arm, table: &mut Table, origins: &mut BTreeMap<String, String>) {
    let Some((_, nominal)) = terms(arm, "evaluate").find(|(name, _)| *name == "nominal") else { return };
    for (key, value) in nominal.iter().filter(|(key, _)| PROTOCOL.contains(&key.as_str())) {
        if !table.contains_key(key) {
            table.insert(key.clone(), value.clone());
            let origin = arm.origins.get(&format!("evaluate.nominal.{key}"));
            origins.extend(origin.map(|origin| (format!("deploy.{key}"), origin.clone())));
        }
    }
}

fn report_stage(source: &ReportSource, first: &Arm, records: &[ArmRecord]) -> Stage {
    let Request { profile, assignments, .. } = &first.request;
    let content = json!({ "templates": source.templates, "profile": profile, "assignments": assignments });
    let mut draft = plain(first, StageKind::Report, content);
    draft.fields.insert("name".into(), Value::Text(source.name.clone()));
    // The other arms are inputs; under which paths they were found does not matter.
    if let Some(Value::Table(report)) = draft.fields.get_mut("report") {
        report.remove("compare");
    }
    // The order of the arms is the order of the report's columns.
    let arms = records.iter().map(|record| {
        let mut arm = Table::from([("name".into(), Value::Text(record.name.clone()))]);
        arm.extend(record.fields.get("summary").map(|summary| ("summary".into(), summary.clone())));
        Value::Table(arm)
    });
    draft.fields.insert("arms".into(), Value::List(arms.collect()));
    let inputs = records
        .iter()
        .flat_map(|record| record.stages.iter().map(|(stage, key)| (format!("{}/{stage}", record.name), key.clone())));
    finish(draft, inputs.collect())
}

fn finish(draft: Draft, inputs: BTreeMap<String, Fingerprint>) -> Stage {
    let Draft { kind, fields, origins, content, .. } = draft;
    let recipe = Recipe {
        stage: kind.name().into(),
        epoch: kind.facts().epoch,
        fields: canonical_table(&fields),
        content,
        inputs,
        numeric: stage::numeric_identity(kind, engine(kind, &fields)),
    };
    Stage { kind, fingerprint: recipe.fingerprint(), users: Vec::new(), fields, origins, recipe }
}

/// The engine that a stage chooses.
fn engine(kind: StageKind, fields: &Table) -> Option<&str> {
    let section = if kind == StageKind::Env { "physics" } else { "deploy" };
    match fields.get(section) {
        Some(Value::Table(table)) => match table.get("engine") {
            Some(Value::Text(engine)) => Some(engine),
            _ => None,
        },
        _ => None,
    }
}

/// Whether a declared field covers a path: it is the path or a table above it, or below it.
fn covers(field: &str, path: &str) -> bool {
    let below = |outer: &str, inner: &str| inner.strip_prefix(outer).is_some_and(|rest| rest.starts_with('.'));
    field == path || below(field, path)
}

/// Copies the value at a dotted path, if there is one.
fn copy_path(from: &Table, path: &str, to: &mut Table) {
    match path.split_once('.') {
        None => {
            if let Some(value) = from.get(path) {
                to.insert(path.into(), value.clone());
            }
        }
        Some((head, rest)) => {
            let Some(Value::Table(inner)) = from.get(head) else { return };
            let mut copied = match to.remove(head) {
                Some(Value::Table(table)) => table,
                _ => Table::new(),
            };
            copy_path(inner, rest, &mut copied);
            if !copied.is_empty() {
                to.insert(head.into(), Value::Table(copied));
            }
        }
    }
}
