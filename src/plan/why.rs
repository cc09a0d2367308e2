//! Why a stage would run: compares its recipe with that of its nearest earlier result and follows the
//! differences upstream to the fields, files and versions that changed.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::fingerprint::{Fingerprint, Recipe, canonical_json};
use super::graph::{Plan, Stage};
use super::stage::StageKind;
use crate::spec::{Sampler, Table, Value};

/// Whether a result is in the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cached {
    /// It is in the store.
    Yes,
    /// It is not in the store.
    No,
    /// It is in the store but cannot be used, for this reason.
    Damaged(String),
}

/// An earlier result to compare with.
#[derive(Clone, Debug)]
pub struct Previous {
    /// The earlier stage.
    pub stage: Stage,
    /// Whether it had the same name; otherwise it is the most similar one of its kind.
    pub named: bool,
}

/// Access to earlier runs.
pub trait History {
    /// Whether the result of a stage is in the store.
    fn cached(&self, kind: StageKind, fingerprint: &Fingerprint) -> Cached;
    /// The stage that made a result.
    fn entry(&self, kind: StageKind, fingerprint: &Fingerprint) -> Option<Stage>;
    /// The latest result with another fingerprint that had one of this stage's names.
    fn earlier(&self, stage: &Stage) -> Option<Stage>;
    /// The nearest earlier result of a stage with another fingerprint: one with its name, or the most
    /// similar.
    fn previous(&self, stage: &Stage) -> Option<Previous>;
}

/// The cache state of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Its result is in the store.
    Cached,
    /// No earlier result exists.
    Missing,
    /// The earlier result has other inputs.
    Changed,
}

impl State {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cached => "cached",
            Self::Missing => "missing",
            Self::Changed => "changed",
        }
    }
}

/// One difference from the earlier result.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Change {
    /// A field of the spec, a place in the robot or motion file, `code` or `library`.
    pub field: String,
    /// The earlier value as its author wrote it; missing if there was none.
    pub from: Option<String>,
    /// The current value; missing if it was removed.
    pub to: Option<String>,
    /// The origin of the earlier value.
    pub from_origin: Option<String>,
    /// The origin of the current value.
    pub to_origin: Option<String>,
    /// The inputs through which the change propagates, nearest first; empty for the stage's own fields.
    pub through: Vec<String>,
}

/// A stage's cache state with the reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// The state.
    pub state: State,
    /// What changed since the earlier result.
    pub changes: Vec<Change>,
    /// Additional information: why an existing artefact cannot be used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The states of all stages.
pub fn statuses(plan: &Plan, history: &dyn History) -> BTreeMap<Fingerprint, Status> {
    plan.stages().map(|stage| (stage.fingerprint.clone(), status(plan, stage, history))).collect()
}

/// The state of one stage.
pub fn status(plan: &Plan, stage: &Stage, history: &dyn History) -> Status {
    match history.cached(stage.kind, &stage.fingerprint) {
        Cached::Yes => return Status { state: State::Cached, changes: Vec::new(), note: None },
        Cached::Damaged(reason) => {
            return Status {
                state: State::Missing,
                changes: Vec::new(),
                note: Some(format!("R0003: {reason}")),
            };
        }
        Cached::No => {}
    }
    match history.earlier(stage) {
        None => Status { state: State::Missing, changes: Vec::new(), note: None },
        Some(earlier) => {
            Status { state: State::Changed, changes: changes(plan, stage, &earlier, history), note: None }
        }
    }
}

/// The differences between a stage and an earlier one of its kind, each cause once.
pub fn changes(plan: &Plan, now: &Stage, before: &Stage, history: &dyn History) -> Vec<Change> {
    let mut all = Vec::new();
    collect(plan, now, before, history, &mut Vec::new(), &mut all);
    all.sort_by_key(|change| change.through.len());
    let mut seen = BTreeSet::new();
    all.retain(|change| seen.insert((change.field.clone(), change.from.clone(), change.to.clone())));
    all
}

fn collect(
    plan: &Plan,
    now: &Stage,
    before: &Stage,
    history: &dyn History,
    through: &mut Vec<String>,
    all: &mut Vec<Change>,
) {
    all.extend(
        own_changes(plan, now, before)
            .into_iter()
            .map(|change| Change { through: through.clone(), ..change }),
    );
    for role in keys(&now.recipe.inputs, &before.recipe.inputs) {
        let (new, old) = (now.recipe.inputs.get(&role), before.recipe.inputs.get(&role));
        if new == old {
            continue;
        }
        let new_stage = new.and_then(|key| plan.stage(key));
        let kind = new_stage.map(|stage| stage.kind);
        let old_stage = old.zip(kind).and_then(|(key, kind)| history.entry(kind, key));
        if let (Some(new_stage), Some(old_stage)) = (new_stage, old_stage) {
            through.push(role);
            collect(plan, new_stage, &old_stage, history, through, all);
            through.pop();
        } else {
            let short = |key: Option<&Fingerprint>| key.map(|key| key.short().to_owned());
            let field = format!("input {role}");
            let (from, to) = (short(old), short(new));
            all.push(Change {
                field,
                from,
                to,
                from_origin: None,
                to_origin: None,
                through: through.clone(),
            });
        }
    }
}

/// Differences of fields, file contents, code and libraries, without inputs.
fn own_changes(plan: &Plan, now: &Stage, before: &Stage) -> Vec<Change> {
    let (new, old) = (leaves(&now.fields), leaves(&before.fields));
    let mut changes = Vec::new();
    for path in keys(&new, &old) {
        let (to, from) = (new.get(&path), old.get(&path));
        if to.map(|value| canonical_json(&value.canonical()))
            == from.map(|value| canonical_json(&value.canonical()))
        {
            continue;
        }
        changes.push(Change {
            field: plan.spec_path(now, &path),
            from: from.map(|value| written(value)),
            to: to.map(|value| written(value)),
            from_origin: from.and_then(|_| origin(&before.origins, &path)),
            to_origin: to.and_then(|_| origin(&now.origins, &path)),
            through: Vec::new(),
        });
    }
    changes.extend(recipe_changes(&now.recipe, &before.recipe));
    changes
}

/// Differences of a recipe beyond fields and inputs.
fn recipe_changes(now: &Recipe, before: &Recipe) -> Vec<Change> {
    let change = |field: String, from: Option<String>, to: Option<String>| Change {
        field,
        from,
        to,
        from_origin: None,
        to_origin: None,
        through: Vec::new(),
    };
    let mut changes = Vec::new();
    let (mut new, mut old) = (BTreeMap::new(), BTreeMap::new());
    json_leaves(&now.content, String::new(), &mut new);
    json_leaves(&before.content, String::new(), &mut old);
    for path in keys(&new, &old).into_iter().filter(|path| new.get(path) != old.get(path)) {
        let place = format!("{} file: {path}", now.stage);
        changes.push(change(place, old.get(&path).cloned(), new.get(&path).cloned()));
    }
    if now.epoch != before.epoch {
        let field = format!("code of `{}` (epoch)", now.stage);
        changes.push(change(field, Some(before.epoch.to_string()), Some(now.epoch.to_string())));
    }
    if now.numeric != before.numeric {
        changes.push(change("library".into(), Some(before.numeric.join(", ")), Some(now.numeric.join(", "))));
    }
    changes
}

/// Number of differing leaves of two recipes: the distance for choosing the nearest earlier result.
pub fn distance(a: &Recipe, b: &Recipe) -> usize {
    let flat = |recipe: &Recipe| {
        let mut leaves = BTreeMap::new();
        json_leaves(
            &serde_json::to_value(recipe).expect("a recipe is plain data"),
            String::new(),
            &mut leaves,
        );
        leaves
    };
    let (a, b) = (flat(a), flat(b));
    keys(&a, &b).into_iter().filter(|path| a.get(path) != b.get(path)).count()
}

/// The origin of a path: its own, or that of the nearest table above.
fn origin(origins: &BTreeMap<String, String>, path: &str) -> Option<String> {
    let mut place = path;
    loop {
        if let Some(origin) = origins.get(place) {
            return Some(origin.clone());
        }
        place = place.rsplit_once('.')?.0;
    }
}

fn keys<A, B>(a: &BTreeMap<String, A>, b: &BTreeMap<String, B>) -> BTreeSet<String> {
    a.keys().chain(b.keys()).cloned().collect()
}

/// The values of a table except tables, by dotted path.
fn leaves(table: &Table) -> BTreeMap<String, &Value> {
    fn walk<'a>(table: &'a Table, path: &str, found: &mut BTreeMap<String, &'a Value>) {
        for (key, value) in table {
            let place = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            match value {
                Value::Table(inner) => walk(inner, &place, found),
                _ => {
                    found.insert(place, value);
                }
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(table, "", &mut found);
    found
}

fn json_leaves(value: &serde_json::Value, path: String, found: &mut BTreeMap<String, String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        serde_json::Value::Object(map) => {
            for (key, item) in map {
                json_leaves(item, below(key), found);
            }
        }
        serde_json::Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                json_leaves(item, below(&index.to_string()), found);
            }
        }
        serde_json::Value::Null => {}
        _ => {
            found.insert(path, canonical_json(value));
        }
    }
}

/// A value as its author wrote it.
pub fn written(value: &Value) -> String {
    let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    match value {
        Value::Flag(flag) => flag.to_string(),
        Value::Count(count) => count.to_string(),
        Value::Quantity(quantity) => quantity.text.clone(),
        Value::Text(text) => format!("\"{text}\""),
        Value::List(items) => format!("[{}]", items.iter().map(written).collect::<Vec<_>>().join(", ")),
        Value::Sampler(Sampler::Constant(value)) => value.to_string(),
        Value::Sampler(Sampler::Uniform(bounds)) => format!("uniform [{}]", numbers(bounds)),
        Value::Sampler(Sampler::Normal(moments)) => format!("normal [{}]", numbers(moments)),
        Value::Sampler(Sampler::LogUniform(bounds)) => format!("log_uniform [{}]", numbers(bounds)),
        Value::Sampler(Sampler::Choice(values)) => format!("choice [{}]", numbers(values)),
        Value::Table(table) => {
            let items: Vec<_> =
                table.iter().map(|(key, value)| format!("{key} = {}", written(value))).collect();
            format!("{{ {} }}", items.join(", "))
        }
    }
}
