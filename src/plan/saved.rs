//! Saved plans, and the check that they do not contradict themselves.
//!
//! A saved plan contains most information twice: a stage's fields are in its arm, in the stage and,
//! canonical, in its recipe; edges, names and fingerprints follow from them. Readers of different copies must
//! not get different results. So the arms are lowered again from what only they contain, and the whole result
//! is compared with the file.

use std::collections::BTreeMap;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value as Json;

use super::arm::{Arm, Runs};
use super::digests::{self, Digests};
use super::draft::MOTION;
use super::error::PlanError;
use super::fingerprint::{Fingerprint, canonical_json};
use super::graph::{ArmRecord, Plan, Stage};
use super::lower::{ARMS, BASELINES};
use super::lower::{ReportSource, ReportedSuite, lower};
use super::stage::StageKind;
use super::suite::{RunRecord, SuiteRecord};
use super::{alike, revision, stage};
use crate::kinds::learn::Ppo;
use crate::spec::claim::keys::Claim as ClaimKeys;
use crate::spec::section::Header;
use crate::spec::suite::product::arm_name;
use crate::spec::typed::InSection as _;
use crate::spec::{Table, Value};

/// The code of the errors that name what was edited.
const EDITED: &str = "E0811";

/// The layout of a plan file.
#[derive(Serialize, Deserialize)]
struct PlanFile {
    #[serde(deserialize_with = "alike::list")]
    arms: Vec<ArmRecord>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    suite: Option<SuiteRecord>,
    #[serde(deserialize_with = "alike::list")]
    stages: Vec<Stage>,
    /// The digests of its parts, by which an edited file is told from one of another version.
    #[serde(default)]
    digests: Digests,
}

/// Why a file is not a plan.
#[derive(Debug, thiserror::Error)]
pub enum SavedError {
    /// Not a plan.
    #[error("not a plan: {0}")]
    Format(#[from] serde_json::Error),
    /// A plan that cannot be used.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Whether a text has the layout of a saved plan, of this version or of another; its content is not checked.
pub fn is_saved(text: &str) -> bool {
    let Ok(Json::Object(file)) = serde_json::from_str::<Json>(text) else { return false };
    let has_list = |key: &str| file.get(key).is_some_and(Json::is_array);
    has_list("arms")
        && has_list("stages")
        && file.keys().all(|key| matches!(key.as_str(), "arms" | "suite" | "stages" | "digests"))
}

impl Plan {
    /// Reads and checks a saved plan.
    pub fn from_json(text: &str) -> Result<Self, SavedError> {
        Ok(Self::try_from(serde_json::from_str::<PlanFile>(text)?)?)
    }
}

impl Serialize for Plan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PlanFile::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Plan {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::try_from(PlanFile::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl From<Plan> for PlanFile {
    fn from(plan: Plan) -> Self {
        let stages: Vec<Stage> = plan.stages().cloned().collect();
        let digests = digests::of(&plan.arms, plan.suite.as_ref(), &stages);
        Self { stages, suite: plan.suite, arms: plan.arms, digests }
    }
}

impl TryFrom<PlanFile> for Plan {
    type Error = PlanError;

    fn try_from(file: PlanFile) -> Result<Self, PlanError> {
        if file.digests.is_empty() {
            return Err(PlanError::Undigested);
        }
        let edited =
            digests::differing(&file.digests, &digests::of(&file.arms, file.suite.as_ref(), &file.stages));
        match derived(file) {
            Ok(plan) if edited.is_empty() => Ok(plan),
            Ok(_) => Err(PlanError::Edited { parts: edited.join(", "), found: String::new() }),
            // Only a file that is as it was saved tells of another version, or of a spec that is to blame.
            Err(error) if !edited.is_empty() && error.code() != EDITED => {
                Err(PlanError::Edited { parts: edited.join(", "), found: error.found() })
            }
            Err(error) => Err(error),
        }
    }
}

/// The plan that the arms of a file make, which is what the file says.
fn derived(file: PlanFile) -> Result<Plan, PlanError> {
    file.stages.iter().try_for_each(|stage| own_copies(stage, &file.arms))?;
    names(&file)?;
    if let Some(suite) = &file.suite {
        runs(suite, &file.arms)?;
    }
    for (arm, source) in file.arms.iter().flat_map(|arm| sources(&file, arm).map(move |source| (arm, source)))
    {
        texts(&source, "").map_err(|reason| contradiction(format!("arm `{}`", arm.name), reason))?;
    }
    let mut derived = lower(&arms(&file)?, report(&file)?.as_ref())?;
    derived.suite.clone_from(&file.suite);
    if let Some((place, reason)) = difference(&file, &derived) {
        return Err(contradiction(place, reason));
    }
    Ok(derived)
}

fn contradiction(place: String, reason: String) -> PlanError {
    PlanError::Contradiction { place, reason }
}

/// Checks the information that a stage contains twice.
fn own_copies(own: &Stage, arms: &[ArmRecord]) -> Result<(), PlanError> {
    if own.users.is_empty() {
        return Err(PlanError::Unused { key: own.fingerprint.clone() });
    }
    let stage = own.name().to_owned();
    if own.recipe.fingerprint() != own.fingerprint {
        return Err(PlanError::Tampered { stage });
    }
    if own.recipe.stage != own.kind.name() {
        let reason =
            format!("its kind is `{}`, its recipe is that of `{}`", own.kind.name(), own.recipe.stage);
        return Err(contradiction(format!("stage `{stage}`"), reason));
    }
    let mut numeric = stage::numeric_identity(own.kind, &own.fields);
    numeric.extend(revision::of(own.kind, &own.fields));
    let arm = arms.iter().find(|arm| arm.name == own.users[0].arm);
    numeric
        .extend(arm.map(|arm| revision::of_task(own.kind, &arm.fields.only(&["task"]))).unwrap_or_default());
    let (found, now) = (own.recipe.epoch, own.kind.facts().epoch);
    if found != now {
        return Err(PlanError::Version {
            stage,
            found: format!("epoch {found}"),
            now: format!("epoch {now}"),
        });
    }
    if own.recipe.numeric != numeric {
        let [found, now] = [&own.recipe.numeric, &numeric].map(|list| format!("[{}]", list.join("; ")));
        return Err(PlanError::Version { stage, found, now });
    }
    Ok(())
}

/// The report's name must be a valid file name, and an arm must have the name of its spec.
fn names(file: &PlanFile) -> Result<(), PlanError> {
    let plain = |name: &str| {
        let is_safe = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
        name.chars().all(is_safe) && name.chars().any(char::is_alphanumeric)
    };
    let mut reports =
        file.stages.iter().filter(|stage| stage.kind == StageKind::Report).flat_map(|stage| &stage.users);
    if let Some(user) = reports.find(|user| !plain(&user.arm)) {
        return Err(contradiction("the report".into(), format!("`{}` cannot be a file's name", user.arm)));
    }
    // The arms of a suite are named by their points.
    let called = |arm: &&ArmRecord| match arm.fields.get(Header::name.name) {
        Some(Value::Text(name)) if arm.run.is_none() => *name != arm.name,
        _ => false,
    };
    match file.arms.iter().find(called) {
        Some(arm) => Err(contradiction(format!("arm `{}`", arm.name), "its `name` is different".into())),
        None => Ok(()),
    }
}

/// The tables of an arm from which everything else follows.
fn sources(file: &PlanFile, arm: &ArmRecord) -> impl Iterator<Item = Table> {
    std::iter::once(arm.fields.table()).chain(stage(file, arm, "motion").and_then(motion).cloned())
}

/// Checks that every quantity's text matches its number: a report prints the text, a stage computes with the
/// number.
fn texts(table: &Table, above: &str) -> Result<(), String> {
    for (key, value) in table {
        text_of(value, &format!("{above}{key}"))?;
    }
    Ok(())
}

fn text_of(value: &Value, path: &str) -> Result<(), String> {
    match value {
        Value::Quantity(quantity) if !quantity.says_its_number() => {
            Err(format!("`{path}` reads {:?} and has the value {}", quantity.text, quantity.si))
        }
        Value::Table(table) => texts(table, &format!("{path}.")),
        Value::List(items) => items.iter().try_for_each(|item| text_of(item, path)),
        _ => Ok(()),
    }
}

/// Checks a suite's record against its runs.
fn runs(suite: &SuiteRecord, arms: &[ArmRecord]) -> Result<(), PlanError> {
    let wrong = |reason: String| contradiction(format!("suite `{}`", suite.name), reason);
    let runs: Vec<&RunRecord> = arms.iter().filter_map(|arm| arm.run.as_ref()).collect();
    if runs.len() != arms.len() {
        return Err(wrong("an arm is not a run of the suite".into()));
    }
    let groups: Vec<&[&RunRecord]> = runs.chunk_by(|one, next| one.arm == next.arm).collect();
    if groups.len() != suite.arms {
        return Err(wrong(format!("it has {} arms, its record says {}", groups.len(), suite.arms)));
    }
    for group in groups {
        let arm = &group[0].arm;
        let seeds: Vec<u64> = group.iter().map(|run| run.seed).collect();
        // An arm may leave out some of the seeds.
        let in_order: Vec<u64> = suite.seeds.iter().copied().filter(|seed| seeds.contains(seed)).collect();
        if !suite.seeds.is_empty() && seeds != in_order {
            return Err(wrong(format!(
                "the runs of `{arm}` have the seeds {seeds:?}, its record says {:?}",
                suite.seeds
            )));
        }
        let strays = group.iter().flat_map(|run| &run.points).find(|(name, point)| {
            !suite.axes.iter().any(|axis| axis.name == *name && axis.points.contains(point))
        });
        if let Some((axis, point)) = strays {
            return Err(wrong(format!("`{arm}` has the point `{axis}={point}`, which its record lacks")));
        }
        let name = arm_name(&group[0].points, &suite.name);
        if name != *arm {
            return Err(wrong(format!("the arm at `{name}` is called `{arm}`")));
        }
    }
    Ok(())
}

/// A stage of an arm by its name.
fn stage<'a>(file: &'a PlanFile, arm: &ArmRecord, name: &str) -> Option<&'a Stage> {
    let key = arm.stages.get(name)?;
    file.stages.iter().find(|stage| stage.fingerprint == *key)
}

/// The motion file in a motion stage.
fn motion(stage: &Stage) -> Option<&Table> {
    match stage.fields.get(MOTION) {
        Some(Value::Table(motion)) => Some(motion),
        _ => None,
    }
}

/// The arms that the plan was lowered from; the runs of a suite's arm become one arm again.
fn arms(file: &PlanFile) -> Result<Vec<Arm>, PlanError> {
    let by_key: BTreeMap<&Fingerprint, &Stage> =
        file.stages.iter().map(|stage| (&stage.fingerprint, stage)).collect();
    let stage = |arm: &ArmRecord, name: &str| by_key.get(arm.stages.get(name)?).copied();
    let same = |one: &ArmRecord, next: &ArmRecord| match (&one.run, &next.run) {
        (Some(one), Some(next)) => one.arm == next.arm,
        _ => false,
    };
    let groups = file.arms.chunk_by(same);
    let arm = |group: &[ArmRecord]| {
        let first = &group[0];
        let missing =
            || contradiction(format!("arm `{}`", first.name), "its stage `robot` is missing".into());
        let runs = first.run.as_ref().map(|run| Runs {
            points: run.points.clone(),
            seeds: group.iter().filter_map(|arm| arm.run.as_ref()).map(|run| run.seed).collect(),
            origin: first.origins.get(&Ppo::seed.path()).cloned(),
        });
        Ok(Arm {
            name: first.run.as_ref().map_or(&first.name, |run| &run.arm).clone(),
            fields: first.fields.table(),
            origins: (*first.origins).clone(),
            robot: stage(first, "robot").ok_or_else(missing)?.recipe.content.clone(),
            motion: stage(first, "motion").and_then(motion).map(|motion| motion.clone().into()),
            request: first.request.clone(),
            allow: first.allow.clone(),
            runs,
        })
    };
    groups.map(arm).collect()
}

/// The source of the plan's report, if it has one.
fn report(file: &PlanFile) -> Result<Option<ReportSource>, PlanError> {
    let Some(stage) = file.stages.iter().find(|stage| stage.kind == StageKind::Report) else {
        return Ok(None);
    };
    let templates = stage.recipe.content.get("templates").and_then(serde_json::Value::as_str);
    let unknown = || contradiction("the report".into(), "its templates are missing".into());
    let suite = file.suite.as_ref().map(|record| {
        let mut fields = (*stage.fields).clone();
        fields.remove(ARMS);
        fields.remove(BASELINES);
        fields.insert(Header::name.name.into(), Value::Text(record.name.clone()));
        if record.claims.is_empty() {
            fields.remove(ClaimKeys::SECTION);
        } else {
            let claims = record.claims.iter().map(|claim| Value::Table(claim.fields.clone())).collect();
            fields.insert(ClaimKeys::SECTION.into(), Value::List(claims));
        }
        ReportedSuite { record: record.clone(), fields }
    });
    let baselines = match stage.fields.get(BASELINES) {
        Some(Value::List(baselines)) => baselines.iter().filter_map(Value::as_table).cloned().collect(),
        _ => Vec::new(),
    };
    let (name, templates) = (stage.users[0].arm.clone(), templates.ok_or_else(unknown)?.to_owned());
    Ok(Some(ReportSource { name, templates, suite, baselines }))
}

/// The first difference between a file and the plan that its arms give.
fn difference(file: &PlanFile, derived: &Plan) -> Option<(String, String)> {
    let pairs = || file.stages.iter().zip(derived.stages());
    for (found, made) in pairs() {
        if let Some(reason) = stage_difference(found, made) {
            return Some((format!("stage `{}`", made.name()), reason));
        }
    }
    let (found, made) = (file.stages.len(), derived.stages().len());
    if found != made {
        return Some(("the stages".into(), format!("there are {found}, its arms make {made}")));
    }
    for (found, made) in file.arms.iter().zip(&derived.arms) {
        if let Some(reason) = arm_difference(found, made) {
            return Some((format!("arm `{}`", made.name), reason));
        }
    }
    let (found, made) = (file.arms.len(), derived.arms.len());
    (found != made).then(|| ("the arms".into(), format!("there are {found}, their runs make {made}")))
}

fn stage_difference(found: &Stage, made: &Stage) -> Option<String> {
    let differs = |what: &str| Some(format!("its {what} do not follow from its arm"));
    match () {
        () if found.kind != made.kind => differs("kind and place"),
        () if found.fields != made.fields => {
            Some(format!("`{}` has another value there than in its arm", field(&found.fields, &made.fields)))
        }
        () if found.recipe.fields != made.recipe.fields => {
            Some("the fields of its recipe are not those that it shows".into())
        }
        () if canonical_json(&found.recipe.content) != canonical_json(&made.recipe.content) => {
            differs("contents")
        }
        () if found.recipe.inputs != made.recipe.inputs => differs("inputs"),
        () if found.users != made.users => differs("users"),
        () if found.origins != made.origins => differs("origins"),
        () if found.fingerprint != made.fingerprint || found.recipe != made.recipe => {
            differs("recipe and fingerprint")
        }
        () => None,
    }
}

fn arm_difference(found: &ArmRecord, made: &ArmRecord) -> Option<String> {
    let differs = |what: &str| Some(format!("its {what} do not follow from its fields"));
    match () {
        () if found.name != made.name => Some(format!("it is called `{}` in one place", found.name)),
        () if found.fields != made.fields => {
            let differs = field(&found.fields.table(), &made.fields.table());
            Some(format!("`{differs}` has another value there than in its first run"))
        }
        () if found.stages != made.stages => differs("stages"),
        () if found.run != made.run => differs("run's id, points and seed"),
        () if found != made => differs("origins, request and allowances"),
        () => None,
    }
}

/// The path of the first value that differs.
fn field(one: &Table, other: &Table) -> String {
    let keys = one.keys().chain(other.keys());
    let Some(key) = keys.into_iter().find(|key| one.get(*key) != other.get(*key)) else {
        return String::new();
    };
    match (one.get(key), other.get(key)) {
        (Some(Value::Table(one)), Some(Value::Table(other))) => format!("{key}.{}", field(one, other)),
        _ => key.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::arm::Request;
    use super::*;
    use crate::plan::sections::Sections;

    /// The runs of an arm differ only in the learning seed: a plan of a thousand runs stores everything else
    /// once.
    #[test]
    fn what_runs_have_in_common_is_held_once_when_a_plan_is_read() {
        let section =
            |key: &str, value: u64| Value::Table(Table::from([(key.to_owned(), Value::Count(value))]));
        let arm = |seed: u64| {
            let fields = Table::from([
                ("action".into(), section("delay", 4)),
                ("learn".into(), section("seed", seed)),
            ]);
            let origins = BTreeMap::from([("action.delay".to_owned(), "walk.toml:3".to_owned())]);
            ArmRecord {
                name: format!("seed={seed}"),
                request: Request::default(),
                fields: Sections::from(&fields),
                origins: origins.into(),
                stages: BTreeMap::new(),
                allow: BTreeMap::new(),
                run: None,
            }
        };
        let arms: Vec<ArmRecord> = (1..=3).map(arm).collect();
        let file = PlanFile { arms: arms.clone(), suite: None, stages: Vec::new(), digests: Digests::new() };
        let text = serde_json::to_string(&file).expect("plain data");
        let read: PlanFile = serde_json::from_str(&text).expect("it was just written");
        assert_eq!(read.arms, arms);
        for pair in read.arms.windows(2) {
            let is_shared = |key: &str| {
                let [one, next] = [0, 1].map(|arm| pair[arm].fields.get(key).expect("it is there"));
                std::ptr::eq(one, next)
            };
            assert!(is_shared("action") && !is_shared("learn"));
            assert!(pair[0].origins.is_one_with(&pair[1].origins));
        }
    }
}
