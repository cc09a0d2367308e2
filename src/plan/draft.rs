//! The stages of an arm before their inputs are known: which stages there are, what each reads from the spec,
//! and to which of the arm's trainings it belongs.

use std::collections::BTreeMap;

use serde_json::json;

use super::arm::Arm;
use super::field::Field;
use super::shared::Shared;
use super::stage::StageKind;
use crate::kinds::action::Torque;
use crate::kinds::deploy::{Deployment, Transfer};
use crate::kinds::evaluate::{self, Episodes, Evaluation, NOMINAL, Setting, Spread};
use crate::kinds::fine_tune::{self, FineTuning, Trained};
use crate::kinds::learn::Learner;
use crate::kinds::physics::Physics;
use crate::kinds::pretrain::Pretraining;
use crate::kinds::reward::Rewards;
use crate::kinds::terrain::Ground;
use crate::spec::marks::below;
use crate::spec::section::RewardTerm;
use crate::spec::typed::InSection;
use crate::spec::{Section, Table, Value};

/// The field of a motion's stage with the values of its file.
pub const MOTION: &str = "motion";

/// Name of the environment stage of a fine-tuning.
pub const TUNED_ENV: &str = "fine_tune.env";

/// The trainings of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Training {
    /// `[learn]`.
    First,
    /// `[fine_tune]`.
    FineTuning,
}

impl Training {
    /// Name of its stage.
    pub fn stage(self) -> &'static str {
        match self {
            Self::First => StageKind::Learner.name(),
            Self::FineTuning => StageKind::FineTune.name(),
        }
    }

    /// The section of the spec that configures it, which is also its name in claims.
    pub fn section(self) -> &'static str {
        match self {
            Self::First => Learner::SECTION,
            Self::FineTuning => FineTuning::SECTION,
        }
    }
}

/// A stage whose inputs are not yet known.
#[derive(Clone, Debug)]
pub struct Draft {
    /// What it does.
    pub kind: StageKind,
    /// Its name in the arm.
    pub name: String,
    /// The training whose environment and policy it uses; the first for stages before any training.
    pub training: Training,
    /// The declared fields.
    pub fields: Shared<Table>,
    /// The origins of the fields.
    pub origins: Shared<BTreeMap<String, String>>,
    /// The contents of files.
    pub content: Shared<serde_json::Value>,
}

impl Draft {
    /// The producer that replaces `producer` for this stage, and the training that it belongs to.
    pub fn source(&self, producer: StageKind) -> (StageKind, Training) {
        match (self.training, producer) {
            (Training::FineTuning, StageKind::Env | StageKind::Export) => (producer, Training::FineTuning),
            (Training::FineTuning, StageKind::Learner) if self.kind != StageKind::FineTune => {
                (StageKind::FineTune, Training::FineTuning)
            }
            _ => (producer, Training::First),
        }
    }
}

/// The stages of an arm in the order of the pipeline.
pub fn drafts(arm: &Arm, origins: &BTreeMap<String, String>) -> Vec<Draft> {
    let plain = |kind| plain(arm, origins, kind, json!(null).into());
    let mut drafts = vec![self::plain(arm, origins, StageKind::Robot, arm.robot.clone())];
    if let Some(motion) = &arm.motion {
        drafts.push(motion_draft(arm, origins, motion));
    }
    drafts.push(plain(StageKind::Env));
    drafts.push(plain(StageKind::Controller));
    if arm.fields.contains_key(Pretraining::SECTION) {
        drafts.push(plain(StageKind::Pretrain));
    }
    if arm.fields.contains_key(Learner::SECTION) {
        drafts.push(plain(StageKind::Learner));
    }
    if let Some(tuning) = Section::new(&arm.fields).within::<FineTuning>() {
        drafts.push(tuned_env(arm, origins, tuning));
        drafts.push(Draft { training: Training::FineTuning, ..plain(StageKind::FineTune) });
    }
    drafts.extend(terms(arm, "evaluate").map(|(name, table)| term(arm, StageKind::Evaluate, name, table)));
    let deploys =
        |transfer: bool| terms(arm, "deploy").filter(move |(_, table)| is_transfer(table) == transfer);
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
    Section::new(table).is::<Transfer>()
}

/// A stage with fixed declared paths.
pub fn plain(
    arm: &Arm,
    origins: &BTreeMap<String, String>,
    kind: StageKind,
    content: Shared<serde_json::Value>,
) -> Draft {
    let mut fields = Table::new();
    let declared = kind.facts().fields;
    for field in declared {
        field.copy(&arm.fields, &mut fields);
    }
    let origins = origins.iter().filter(|(path, _)| declared.iter().any(|field| field.covers(path)));
    let origins: BTreeMap<_, _> = origins.map(|(path, origin)| (path.clone(), origin.clone())).collect();
    let (name, training) = (kind.name().into(), Training::First);
    Draft { kind, name, training, fields: fields.into(), origins: origins.into(), content }
}

/// Keys of `[fine_tune]` and the fields that they set in its environment; `weights.TERM` sets
/// `reward.TERM.weight`.
const MOVES: [(Field, Field); 3] = [
    (Field::key(fine_tune::Ppo::terrain), Field::section::<Ground>()),
    (Field::key(fine_tune::Ppo::std), Field::key(Torque::std)),
    (Field::key(fine_tune::Ppo::engine), Field::key(Physics::engine)),
];

/// The path of a reward term's weight.
fn weight(term: &str) -> String {
    RewardTerm::weight.below(&below(Rewards::SECTION, term))
}

/// The path of its weight in a fine-tuning.
fn tuned_weight(term: &str) -> String {
    below(&fine_tune::Ppo::weights.path(), term)
}

/// The key of `[fine_tune]` that can set a path of that environment.
fn moved_from(path: &str) -> Option<String> {
    let parts: Vec<&str> = path.split('.').collect();
    if let [section, term, key] = parts[..]
        && section == Rewards::SECTION
        && key == RewardTerm::weight.name
    {
        return Some(tuned_weight(term));
    }
    let (own, place) = MOVES.into_iter().find(|(_, place)| place.covers(path))?;
    Some(format!("{}{}", own.path(), &path[place.path().len()..]))
}

/// The paths of the training's environment that a `[fine_tune]` replaces, with the keys that do so.
pub fn replaced(tuning: Section) -> Vec<(String, String)> {
    let fixed = MOVES.into_iter().filter(|(own, _)| tuning.get(own.name()).is_some());
    let fixed = fixed.map(|(own, place)| (place.path(), own.path()));
    let terms = tuning.below(fine_tune::Ppo::weights).into_iter().flat_map(|weights| weights.table().keys());
    let weights = terms.map(|term| (weight(term), tuned_weight(term)));
    fixed.chain(weights).collect()
}

/// The fields of a spec with the values that its fine-tuning puts in place of the training's.
pub fn tuned(fields: &Table) -> Table {
    let mut tuned = fields.clone();
    for (place, own) in Section::new(fields).within::<FineTuning>().map(replaced).into_iter().flatten() {
        if let Some(value) = at(fields, &own) {
            replace(&mut tuned, &place, value.clone());
        }
    }
    tuned
}

/// The path in the spec with these fields, or in the motion's file, of a path in a stage's fields:
/// `evaluate.episodes` is `evaluate.nominal.episodes`. Without fields every possible key counts as set.
pub fn spec_path(kind: StageKind, name: &str, path: &str, spec: Option<&Table>) -> String {
    let is_written = |own: &String| spec.is_none_or(|spec| at(spec, own).is_some());
    let Some((head, rest)) = path.split_once('.') else { return path.to_owned() };
    match kind {
        StageKind::Evaluate | StageKind::Export => below(name, rest),
        StageKind::Transfer => {
            let (own, nominal) = (below(name, rest), below(&evaluate::nominal(), rest));
            if !is_written(&own) && is_written(&nominal) { nominal } else { own }
        }
        StageKind::Env if name == TUNED_ENV => {
            moved_from(path).filter(is_written).unwrap_or_else(|| path.to_owned())
        }
        StageKind::Motion if head == "motion" => format!("motion file: {rest}"),
        _ => path.to_owned(),
    }
}

/// The environment of a fine-tuning: that of the training with another ground and, if given, another
/// exploration, engine and reward weights. It is the same stage as for a spec with these values in
/// `[terrain]`, `[action]`, `[physics]` and `[reward]`.
fn tuned_env(arm: &Arm, origins: &BTreeMap<String, String>, tuning: Section) -> Draft {
    let mut draft = plain(arm, origins, StageKind::Env, json!(null).into());
    for (place, own) in replaced(tuning) {
        if let Some(value) = at(&arm.fields, &own) {
            replace(&mut draft.fields, &place, value.clone());
            draft.origins.retain(|path, _| !covers(&place, path));
            let moved = moved(origins, &own, &place);
            draft.origins.extend(moved);
        }
    }
    Draft { name: TUNED_ENV.into(), training: Training::FineTuning, ..draft }
}

/// The value at a path of a table.
fn at<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((head, rest)) => match table.get(head)? {
            Value::Table(inner) => at(inner, rest),
            _ => None,
        },
    }
}

/// Replaces the value at an existing path of a table.
fn replace(table: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => drop(table.insert(path.to_owned(), value)),
        Some((head, rest)) => {
            if let Some(Value::Table(inner)) = table.get_mut(head) {
                replace(inner, rest, value);
            }
        }
    }
}

/// The origins of a path and of the paths below it, under another path.
fn moved(origins: &BTreeMap<String, String>, from: &str, to: &str) -> BTreeMap<String, String> {
    let moved = origins.iter().filter(|(path, _)| covers(from, path));
    moved.map(|(path, origin)| (format!("{to}{}", &path[from.len()..]), origin.clone())).collect()
}

/// The motion stage: the spec names the motion, and its file defines it.
fn motion_draft(arm: &Arm, origins: &BTreeMap<String, String>, motion: &Table) -> Draft {
    let mut draft = plain(arm, origins, StageKind::Motion, json!(null).into());
    draft.fields.insert(MOTION.into(), Value::Table(motion.clone()));
    let own = origins.iter().filter(|(path, _)| path.starts_with("motion."));
    draft.origins.extend(own.map(|(path, origin)| (path.clone(), origin.clone())));
    draft
}

/// A stage made from the table `evaluate.NAME` or `deploy.NAME`.
fn term(arm: &Arm, kind: StageKind, name: &str, table: &Table) -> Draft {
    let section = kind.facts().fields[0].name();
    let path = below(section, name);
    let mut origins = moved(&arm.origins, &path, section);
    let mut table = table.clone();
    // The inputs determine the policy: the same work on the same policy is one stage.
    let policy = Section::new(&table).value(Setting::policy);
    table.remove(Setting::policy.name);
    origins.remove(&Setting::policy.below(section));
    let training = match policy {
        Some(Trained::Learner) => Training::First,
        _ if arm.fields.contains_key(FineTuning::SECTION) => Training::FineTuning,
        _ => Training::First,
    };
    if kind == StageKind::Transfer {
        inherit_protocol(arm, &mut table, &mut origins);
    }
    let fields = Table::from([(section.to_owned(), Value::Table(table))]);
    let (fields, origins) = (fields.into(), origins.into());
    Draft { kind, name: path, training, fields, origins, content: json!(null).into() }
}

/// Keys that a transfer and an evaluation have in common.
const PROTOCOL: [&str; 6] = [
    Episodes::command.name,
    Episodes::episodes.name,
    Spread::perturbation.name,
    Setting::seed.name,
    Setting::terrain.name,
    Setting::time_limit.name,
];

/// A transfer takes the protocol keys that it does not set from `evaluate.nominal`, so that both engines
/// answer the same question.
fn inherit_protocol(arm: &Arm, table: &mut Table, origins: &mut BTreeMap<String, String>) {
    let nominal = terms(arm, Evaluation::SECTION).find(|(name, _)| *name == NOMINAL);
    let Some((_, nominal)) = nominal else { return };
    for (key, value) in nominal.iter().filter(|(key, _)| PROTOCOL.contains(&key.as_str())) {
        if !table.contains_key(key) {
            table.insert(key.clone(), value.clone());
            let (from, to) = (below(&evaluate::nominal(), key), below(Deployment::SECTION, key));
            origins.extend(moved(&arm.origins, &from, &to));
        }
    }
}

/// Whether a declared field covers a path: it is equal, above or below.
fn covers(field: &str, path: &str) -> bool {
    let below =
        |outer: &str, inner: &str| inner.strip_prefix(outer).is_some_and(|rest| rest.starts_with('.'));
    field == path || below(field, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> Table {
        let table = |pairs: Vec<(&str, Value)>| {
            Value::Table(pairs.into_iter().map(|(k, v)| (k.to_owned(), v)).collect())
        };
        let count = Value::Count(1);
        let ground = table(vec![("height", count.clone())]);
        let weights = table(vec![("torque", count.clone())]);
        let tuning = table(vec![("std", count.clone()), ("terrain", ground), ("weights", weights)]);
        let nominal = table(vec![("episodes", count.clone()), ("seed", count.clone())]);
        let mujoco = table(vec![("seed", count)]);
        Table::from([
            ("fine_tune".to_owned(), tuning),
            ("evaluate".to_owned(), table(vec![("nominal", nominal)])),
            ("deploy".to_owned(), table(vec![("mujoco", mujoco)])),
        ])
    }

    #[test]
    fn a_path_of_a_stage_is_called_as_the_spec_writes_it() {
        let spec = spec();
        for (kind, name, path, written) in [
            (StageKind::Env, TUNED_ENV, "terrain.height", "fine_tune.terrain.height"),
            (StageKind::Env, TUNED_ENV, "action.std", "fine_tune.std"),
            (StageKind::Env, TUNED_ENV, "reward.torque.weight", "fine_tune.weights.torque"),
            // Keys that the fine-tuning does not set are the training's.
            (StageKind::Env, TUNED_ENV, "reward.speed.weight", "reward.speed.weight"),
            (StageKind::Env, TUNED_ENV, "physics.engine", "physics.engine"),
            (StageKind::Env, "env", "reward.torque.weight", "reward.torque.weight"),
            (StageKind::Evaluate, "evaluate.nominal", "evaluate.episodes", "evaluate.nominal.episodes"),
            (StageKind::Transfer, "deploy.mujoco", "deploy.seed", "deploy.mujoco.seed"),
            (StageKind::Transfer, "deploy.mujoco", "deploy.episodes", "evaluate.nominal.episodes"),
            (StageKind::Motion, "motion", "motion.period", "motion file: period"),
        ] {
            assert_eq!(spec_path(kind, name, path, Some(&spec)), written);
        }
    }
}
