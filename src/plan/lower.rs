//! Lowering: from arms to the graph. Stages with the same fingerprint become one node that the arms share.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::arm::{Arm, Request};
use super::draft::{Draft, Training, drafts, plain};
use super::error::PlanError;
use super::fingerprint::{Fingerprint, Recipe, Texts};
use super::graph::{ArmRecord, Plan, Stage, User};
use super::sections::Sections;
use super::shared::Shared;
use super::stage::{self, StageKind};
use super::suite::{self, SuiteRecord};
use super::{neutral, revision};
use crate::kinds::learn::Ppo;
use crate::spec::section::{Header, Report};
use crate::spec::typed::section_mut;
use crate::spec::{Table, Value};

/// The field of the report's stage with the arms, in the order of its columns.
pub const ARMS: &str = "arms";
/// The field of the report's stage with the values of the baselines.
pub const BASELINES: &str = "baselines";

/// Inputs of a report other than the arms.
#[derive(Clone, Debug)]
pub struct ReportSource {
    /// Its name; the page is `reports/NAME.md`.
    pub name: String,
    /// Digest of its templates.
    pub templates: String,
    /// Its suite, if any.
    pub suite: Option<ReportedSuite>,
    /// The specs with which its arms are compared, resolved.
    pub baselines: Vec<Table>,
}

/// Inputs of a suite's report other than its runs.
#[derive(Clone, Debug)]
pub struct ReportedSuite {
    /// Its axes and seeds.
    pub record: SuiteRecord,
    /// The sections `report`, `name`, `summary` and other settings of the suite for its report.
    pub fields: Table,
}

/// Lowers arms to the graph. The report stage is made only from a [`ReportSource`].
pub fn lower(arms: &[Arm], report: Option<&ReportSource>) -> Result<Plan, PlanError> {
    let mut nodes = Nodes::default();
    let mut records: Vec<ArmRecord> = Vec::new();
    let mut names = BTreeSet::new();
    for arm in arms {
        if !names.insert(&arm.name) {
            return Err(PlanError::SameName { name: arm.name.clone() });
        }
        lower_arm(arm, &mut nodes, &mut records)?;
    }
    if let (Some(source), Some(first)) = (report, arms.first()) {
        let user = User { arm: source.name.clone(), stage: "report".into() };
        nodes.add(report_stage(source, first, &records), user);
    }
    let suite = report.and_then(|source| source.suite.as_ref()).map(|suite| suite.record.clone());
    let mut plan = Plan::new(records, nodes.stages)?;
    plan.suite = suite;
    Ok(plan)
}

/// Distinct stages so far.
#[derive(Default)]
struct Nodes {
    stages: Vec<Stage>,
    places: BTreeMap<Fingerprint, usize>,
}

impl Nodes {
    fn add(&mut self, stage: Stage, user: User) -> Fingerprint {
        let key = stage.fingerprint.clone();
        match self.places.get(&key) {
            Some(place) => self.stages[*place].users.push(user),
            None => {
                self.places.insert(key.clone(), self.stages.len());
                self.stages.push(Stage { users: vec![user], ..stage });
            }
        }
        key
    }

    /// Adds a user to a known stage.
    fn reuse(&mut self, key: &Fingerprint, user: User) {
        if let Some(place) = self.places.get(key) {
            self.stages[*place].users.push(user);
        }
    }
}

/// A draft with the parts that all runs of an arm share: its canonical texts, and the last stage made from
/// it.
struct Form {
    draft: Draft,
    /// The revisions of the arm's task.
    task: Vec<String>,
    json: Shared<serde_json::Value>,
    texts: Texts,
    last: Option<(BTreeMap<String, Fingerprint>, Fingerprint)>,
}

impl Form {
    fn new(draft: Draft, task: Vec<String>) -> Self {
        let json = Shared::from(neutral::fields(&draft.fields));
        let texts = Texts::of(&json, &draft.content);
        Self { draft, task, json, texts, last: None }
    }

    /// The form of a stage of an arm.
    fn of(arm: &Arm, draft: Draft) -> Self {
        let task = revision::of_task(draft.kind, &arm.fields);
        Self::new(draft, task)
    }

    /// The same form under another learning seed.
    fn seeded(&self, seed: u64) -> Self {
        let fields = suite::seeded(&self.draft.fields, seed).into();
        Self::new(Draft { fields, ..self.draft.clone() }, self.task.clone())
    }

    fn stage(&self, inputs: BTreeMap<String, Fingerprint>) -> Stage {
        let Draft { kind, fields, origins, content, .. } = &self.draft;
        let mut numeric = stage::numeric_identity(*kind, fields);
        numeric.extend(revision::of(*kind, fields));
        numeric.extend(self.task.iter().cloned());
        let recipe = Recipe {
            stage: kind.name().into(),
            epoch: kind.facts().epoch,
            fields: self.json.clone(),
            content: content.clone(),
            inputs,
            numeric,
        };
        let fingerprint = recipe.fingerprint_of(&self.texts);
        let (fields, origins) = (fields.clone(), origins.clone());
        Stage { kind: *kind, fingerprint, users: Vec::new(), fields, origins, recipe }
    }
}

/// Lowers an arm, or each of its runs; stages that do not read the learning seed are made once.
fn lower_arm(arm: &Arm, nodes: &mut Nodes, records: &mut Vec<ArmRecord>) -> Result<(), PlanError> {
    let mut origins = arm.origins.clone();
    if let Some(origin) = arm.runs.as_ref().and_then(|runs| runs.origin.clone()) {
        origins.insert(Ppo::seed.path(), origin);
    }
    let origins = Shared::from(origins);
    let mut forms: Vec<Form> = drafts(arm, &origins).into_iter().map(|draft| Form::of(arm, draft)).collect();
    let Some(runs) = &arm.runs else {
        let stages = lower_run(arm, &arm.name, &mut forms, nodes)?;
        let (name, request, fields) = (arm.name.clone(), arm.request.clone(), Sections::from(&arm.fields));
        let allow = arm.allow.clone();
        records.push(ArmRecord { name, request, fields, origins, stages, allow, run: None });
        return Ok(());
    };
    let sections = Sections::from(&arm.fields);
    for run in suite::records(arm, runs) {
        for form in forms.iter_mut().filter(|form| suite::reads_the_seed(&form.draft.fields)) {
            *form = form.seeded(run.seed);
        }
        let name = format!("{},seed={}", arm.name, run.seed);
        let stages = lower_run(arm, &name, &mut forms, nodes)?;
        let (request, fields) = (arm.request.clone(), sections.seeded(run.seed));
        let (origins, allow) = (origins.clone(), arm.allow.clone());
        records.push(ArmRecord { name, request, fields, origins, stages, allow, run: Some(run) });
    }
    Ok(())
}

/// The stages of one run by name.
fn lower_run(
    arm: &Arm,
    name: &str,
    forms: &mut [Form],
    nodes: &mut Nodes,
) -> Result<BTreeMap<String, Fingerprint>, PlanError> {
    let mut made: Vec<Made> = Vec::new();
    let mut stages = BTreeMap::new();
    for form in forms {
        let (kind, training, stage) = (form.draft.kind, form.draft.training, form.draft.name.clone());
        let inputs = inputs(arm, &form.draft, &made)?;
        let user = User { arm: name.to_owned(), stage: stage.clone() };
        let key = match &form.last {
            Some((known, key)) if *known == inputs => {
                nodes.reuse(key, user);
                key.clone()
            }
            _ => {
                let key = nodes.add(form.stage(inputs.clone()), user);
                form.last = Some((inputs, key.clone()));
                key
            }
        };
        stages.insert(stage, key.clone());
        made.push(((kind, training), key));
    }
    Ok(stages)
}

/// A stage of an arm: its kind, its training, and its key.
type Made = ((StageKind, Training), Fingerprint);

/// The inputs of a stage among the stages made before it.
fn inputs(arm: &Arm, draft: &Draft, made: &[Made]) -> Result<BTreeMap<String, Fingerprint>, PlanError> {
    let mut inputs = BTreeMap::new();
    for input in draft.kind.facts().inputs {
        let source = draft.source(input.producer);
        match made.iter().find(|(own, _)| *own == source) {
            Some((_, key)) => {
                inputs.insert(input.role.to_owned(), key.clone());
            }
            None if input.optional => {}
            None => {
                let (arm, stage) = (arm.name.clone(), draft.name.clone());
                return Err(PlanError::MissingProducer { arm, stage, producer: input.producer.name() });
            }
        }
    }
    Ok(inputs)
}

fn report_stage(source: &ReportSource, first: &Arm, records: &[ArmRecord]) -> Stage {
    let Request { profile, assignments, outside, .. } = &first.request;
    let mut content =
        json!({ "templates": source.templates, "profile": profile, "assignments": assignments });
    if !outside.is_empty() {
        content["outside"] = json!(outside);
    }
    if let Some(suite) = &source.suite {
        content["suite"] = serde_json::to_value(&suite.record).expect("a suite's record is plain data");
    }
    let mut draft = plain(first, &first.origins, StageKind::Report, content.into());
    draft.fields.insert(Header::name.name.into(), Value::Text(source.name.clone()));
    if let Some(suite) = &source.suite {
        draft.fields = suite.fields.clone().into();
        draft.origins = BTreeMap::new().into();
    }
    // The other arms are inputs. Of baselines only the values count, not the paths at which they were found.
    if let Some(report) = section_mut::<Report>(&mut draft.fields) {
        report.remove(Report::compare.name);
        report.remove(Report::baseline.name);
    }
    if !source.baselines.is_empty() {
        let baselines = source.baselines.iter().cloned().map(Value::Table).collect();
        draft.fields.insert(BASELINES.into(), Value::List(baselines));
    }
    // The order of the arms determines the order of the report's columns.
    draft.fields.insert(
        ARMS.into(),
        Value::List(records.iter().map(|record| Value::Table(column(record))).collect()),
    );
    let inputs = records.iter().flat_map(|record| {
        record.stages.iter().map(|(stage, key)| (format!("{}/{stage}", record.name), key.clone()))
    });
    Form::new(draft, Vec::new()).stage(inputs.collect())
}

/// The properties of an arm that a report shows.
fn column(record: &ArmRecord) -> Table {
    let mut column = Table::from([(Header::name.name.to_owned(), Value::Text(record.name.clone()))]);
    match &record.run {
        Some(run) => drop(column.insert("run".into(), Value::Text(run.id.clone()))),
        None => {
            let summary = Header::summary.name;
            column.extend(record.fields.get(summary).map(|text| (summary.into(), text.clone())))
        }
    }
    if !record.allow.is_empty() {
        let codes = record.allow.keys().map(|code| Value::Text(code.clone()));
        column.insert(Header::allow.name.into(), Value::List(codes.collect()));
    }
    column
}
