//! Deviations from the baseline: those that spec and baseline declare, and the keys whose values differ,
//! described by the keys' own documentation.

use std::collections::{BTreeMap, BTreeSet};

use super::model::ReportInput;
use super::wording;
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::Evaluation;
use crate::kinds::keys::{self, Key};
use crate::kinds::learn::Ppo;
use crate::kinds::reference;
use crate::kinds::vocabulary::vocabulary;
use crate::spec::section::{Header, Report};
use crate::spec::typed::InSection as _;
use crate::spec::{Section, Shape, Table, Ty, Value, Vocabulary};

/// Keys that do not define an experiment: names, pages, and evaluation and deployment, which have sections of
/// their own on a page.
const NOT_COMPARED: [&str; 7] = [
    Header::name.name,
    Header::summary.name,
    Header::spec.name,
    Report::SECTION,
    Header::allow.name,
    Evaluation::SECTION,
    Deployment::SECTION,
];

/// Sentences: what the spec declares, what its baselines declare, and the differences by key.
pub fn sentences(input: &ReportInput) -> Vec<String> {
    let own = input.deviations.iter().cloned();
    let declared = |baseline: &Table| Section::new(baseline).at(Report::deviations).unwrap_or_default();
    let declared = used(input).flat_map(declared);
    let mut said: Vec<String> = Vec::new();
    for text in own.chain(declared).map(|text| format!("{}.", text.trim_end_matches('.'))) {
        if !said.contains(&text) {
            said.push(text);
        }
    }
    said.extend(differences(input));
    said
}

/// The names of the baselines that arms are compared with.
pub fn baselines(input: &ReportInput) -> Vec<String> {
    used(input).map(|baseline| format!("`{}`", name(baseline))).collect()
}

/// The name of a spec.
fn name(spec: &Table) -> &str {
    spec.get(Header::name.name).and_then(Value::as_text).map_or("", String::as_str)
}

fn used(input: &ReportInput) -> impl Iterator<Item = &Table> {
    let all = input.baselines.iter().enumerate();
    let is_used = |place: usize| input.arms.iter().any(|arm| arm.baseline == Some(place));
    all.filter(move |(place, _)| is_used(*place)).map(|(_, baseline)| baseline)
}

/// A key, or a table as a whole, in which an arm differs from its baseline.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Difference {
    /// The path.
    path: String,
    /// The meaning, from the documentation.
    meaning: String,
    /// The baseline's value; `None` if it lacks the key.
    baseline: Option<String>,
    /// The arm's value.
    own: Option<String>,
}

/// One sentence for each key and baseline value from which some arms differ.
fn differences(input: &ReportInput) -> Vec<String> {
    let language = Language::new();
    // The arms' values, each with the number of arms, grouped by everything else.
    let mut found: BTreeMap<Difference, Vec<(Option<String>, usize)>> = BTreeMap::new();
    for arm in &input.arms {
        let Some(baseline) = arm.baseline.and_then(|place| input.baselines.get(place)) else { continue };
        for mut difference in language.differences(baseline, &arm.fields) {
            let own = difference.own.take();
            let values = found.entry(difference).or_default();
            match values.iter_mut().find(|(known, _)| *known == own) {
                Some((_, count)) => *count += 1,
                None => values.push((own, 1)),
            }
        }
    }
    found.iter().map(|(difference, values)| sentence(difference, values, input.arms.len())).collect()
}

/// `The rate of the policy (`action.rate`): 125 Hz in 3 of 6 runs; the baseline has 250 Hz.`
fn sentence(difference: &Difference, values: &[(Option<String>, usize)], arms: usize) -> String {
    let value = |(value, count): &(Option<String>, usize)| {
        let text = value.clone().unwrap_or_else(|| "absent".to_owned());
        if *count == arms { text } else { format!("{text} in {count} of {arms} runs") }
    };
    let own: Vec<String> = values.iter().map(value).collect();
    let Difference { path, meaning, baseline, .. } = difference;
    let key = if meaning.is_empty() { format!("`{path}`") } else { format!("{meaning} (`{path}`)") };
    let baseline = match baseline {
        Some(value) => format!("the baseline has {value}"),
        None => "the baseline has none".to_owned(),
    };
    format!("{key}: {}; {baseline}.", own.join(", "))
}

/// What the descriptors say about paths.
struct Language {
    vocabulary: Vocabulary,
    keys: BTreeMap<String, Vec<Key>>,
}

impl Language {
    fn new() -> Self {
        let mut by_path: BTreeMap<String, Vec<Key>> = BTreeMap::new();
        keys::keys().into_iter().for_each(|key| by_path.entry(key.path.clone()).or_default().push(key));
        Self { vocabulary: vocabulary(), keys: by_path }
    }

    /// All keys in which a spec differs from its baseline.
    fn differences(&self, baseline: &Table, own: &Table) -> Vec<Difference> {
        let mut comparison = Comparison { language: self, own, found: Vec::new() };
        comparison.compare("", Some(baseline), Some(own));
        comparison.found
    }
}

/// The comparison of a spec with its baseline.
struct Comparison<'a> {
    language: &'a Language,
    own: &'a Table,
    found: Vec<Difference>,
}

impl Comparison<'_> {
    /// Compares two tables at a path. One of them may be missing.
    fn compare(&mut self, path: &str, baseline: Option<&Table>, own: Option<&Table>) {
        let empty = Table::new();
        let (left, right) = (baseline.unwrap_or(&empty), own.unwrap_or(&empty));
        let kinds = [left, right].map(|table| Section::new(table).kind().map(str::to_owned));
        // If the kinds differ, keys that only one of them has are not listed.
        let same_kind = kinds[0] == kinds[1];
        let keys: BTreeSet<&String> = left.keys().chain(right.keys()).collect();
        for key in keys {
            let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            // The seed is not compared either: an experiment has several.
            if path.is_empty() && NOT_COMPARED.contains(&key.as_str()) || below == Ppo::seed.path() {
                continue;
            }
            match (left.get(key), right.get(key)) {
                (Some(Value::Table(left)), Some(Value::Table(right))) => {
                    self.compare(&below, Some(left), Some(right));
                }
                // A section of terms that is missing on one side is compared term by term.
                (Some(Value::Table(left)), None) if self.is_terms(&below) => {
                    self.compare(&below, Some(left), None);
                }
                (None, Some(Value::Table(right))) if self.is_terms(&below) => {
                    self.compare(&below, None, Some(right));
                }
                (one, other) => {
                    let goes_with_the_kind = !same_kind && (one.is_none() || other.is_none());
                    let is_same =
                        one.zip(other).is_some_and(|(one, other)| same(&one.canonical(), &other.canonical()));
                    if !goes_with_the_kind && !is_same {
                        let difference = self.difference(below, [one, other]);
                        self.found.push(difference);
                    }
                }
            }
        }
    }

    /// Whether a path is a section of named terms.
    fn is_terms(&self, path: &str) -> bool {
        self.language
            .vocabulary
            .section(path)
            .is_some_and(|section| matches!(section.shape, Shape::Terms(..)))
    }

    fn difference(&self, path: String, [baseline, own]: [Option<&Value>; 2]) -> Difference {
        let kind = [own, baseline].into_iter().flatten().find_map(|value| match value {
            Value::Table(table) => Section::new(table).kind().map(str::to_owned),
            _ => None,
        });
        let key = self.key(&path);
        let name = path.rsplit('.').next().unwrap_or_default();
        let written = |value: &Value| self.written(value, name, key);
        let meaning = match key {
            Some(key) => first_sentence(key.param.doc),
            None => self.kind_of(&path, kind.as_deref()),
        };
        let (baseline, own) = (baseline.map(written), own.map(written));
        Difference { path, meaning, baseline, own }
    }

    /// The key at a path; for a term, the key of its kind or one that all kinds of terms have.
    fn key(&self, path: &str) -> Option<&Key> {
        let mut steps = path.splitn(3, '.');
        let section = steps.next()?;
        let table = Section::new(self.own).section(section);
        let kind = table.as_ref().and_then(|table| table.kind());
        let of_kind = |path: &str| {
            let keys = self.language.keys.get(path)?;
            let fits = |key: &&Key| key.kinds.is_empty() || kind.is_none_or(|kind| key.kinds.contains(&kind));
            keys.iter().find(fits).or(keys.first())
        };
        let of_term = || {
            let (term, key) = (steps.next()?, steps.next()?);
            let kind = table.and_then(|table| table.section(term)?.kind()).unwrap_or(term);
            of_kind(&format!("{section}.{kind}.{key}")).or_else(|| of_kind(&format!("{section}.{key}")))
        };
        of_kind(path).or_else(of_term)
    }

    /// The meaning of a whole table: the title of its kind's page.
    fn kind_of(&self, path: &str, kind: Option<&str>) -> String {
        let (section, term) = path.split_once('.').unwrap_or((path, path));
        let kinds = self.language.vocabulary.kinds(section);
        let named = |name: &str| kinds.iter().find(|kind| kind.name == name);
        let kind = kind.and_then(named).or_else(|| named(term));
        kind.map_or(String::new(), |kind| first_sentence(reference::summary(kind)))
    }

    /// A value with its unit, as its author wrote it if known. The kind of a term is omitted if it equals the
    /// term's name.
    fn written(&self, value: &Value, name: &str, key: Option<&Key>) -> String {
        match value {
            Value::Table(table) => {
                let kind = Section::new(table).kind().filter(|kind| *kind != name).unwrap_or_default();
                let entries = table.iter().filter(|(key, _)| *key != "kind");
                let entries: Vec<String> =
                    entries.map(|(key, value)| format!("{key} {}", self.written(value, key, None))).collect();
                match (kind, entries.as_slice()) {
                    ("", []) => "present".to_owned(),
                    ("", entries) => entries.join(", "),
                    (kind, []) => kind.replace('_', " "),
                    (kind, entries) => format!("{} ({})", kind.replace('_', " "), entries.join(", ")),
                }
            }
            Value::Sampler(_) => {
                let unit = key.and_then(|key| unit(&key.param.ty)).unwrap_or_default();
                format!("{} {unit}", wording::value(value)).trim_end().to_owned()
            }
            _ => wording::value(value),
        }
    }
}

/// The unit in which the distribution of a key is printed.
fn unit(ty: &Ty) -> Option<String> {
    match ty {
        Ty::Sampler(dimension) => Some(dimension.unit()),
        Ty::OneOf(types) => types.iter().find_map(unit),
        _ => None,
    }
}

/// The first sentence of a documentation, without its full stop.
fn first_sentence(doc: &str) -> String {
    let first = doc.split(". ").next().unwrap_or_default().trim();
    first.trim_end_matches(['.', ':']).to_owned()
}

/// Whether two values are equal; a count may equal a number.
fn same(one: &serde_json::Value, other: &serde_json::Value) -> bool {
    use serde_json::Value as Json;
    match (one, other) {
        (Json::Array(one), Json::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| same(one, other))
        }
        (Json::Object(one), Json::Object(other)) => {
            one.len() == other.len()
                && one.iter().all(|(key, one)| other.get(key).is_some_and(|other| same(one, other)))
        }
        _ => match (one.as_f64(), other.as_f64()) {
            // Values written in different units differ by rounding.
            (Some(one), Some(other)) => (one - other).abs() <= 1e-9 * other.abs(),
            _ => one == other,
        },
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::report::baseline;
    use crate::report::model::Arm;
    use crate::spec::{LoadOptions, load};

    /// The values of a shipped spec under a profile; an empty string means no profile.
    fn spec(name: &str, profile: &str) -> Table {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs").join(name);
        let profile = (!profile.is_empty()).then(|| profile.to_owned());
        let loaded = load(&path, &LoadOptions { profile, ..LoadOptions::default() }, &vocabulary());
        loaded.experiment.unwrap_or_else(|| panic!("{name}: {:?}", loaded.sink.diagnostics)).table
    }

    fn page(baselines: &[Table], arms: &[Table]) -> Vec<String> {
        let arm = |fields: &Table| {
            let baseline = baseline::choice(baselines, fields);
            Arm { fields: fields.clone(), baseline, ..Arm::default() }
        };
        let arms = arms.iter().map(arm).collect();
        sentences(&ReportInput { arms, baselines: baselines.to_vec(), ..ReportInput::default() })
    }

    #[test]
    fn the_runs_of_the_papers_setting_differ_from_its_baseline_in_the_engine_alone() {
        for (task, baseline) in [("walk", "baseline"), ("squat", "baseline_squat"), ("run", "baseline_run")] {
            for (action, ending) in [("torque", ""), ("position", "_position")] {
                let baseline = spec(&format!("paper/{baseline}{ending}.toml"), "");
                let declared = page(std::slice::from_ref(&baseline), std::slice::from_ref(&baseline));
                assert!(declared.iter().all(|text| text.contains("the paper")), "{declared:?}");
                let said = page(&[baseline], &[spec(&format!("tocabi_{task}_{action}.toml"), "paper")]);
                let engine = "The physics engine of training and evaluation (`physics.engine`): batch; the \
                    baseline has mujoco.";
                assert_eq!(said[declared.len()..], [engine.to_owned()], "{task} {action}");
            }
        }
    }

    #[test]
    fn small_budgets_tell_keys_with_both_values_their_units_and_what_only_one_side_has() {
        let baselines = [spec("paper/baseline.toml", ""), spec("paper/baseline_run_position.toml", "")];
        let said = page(&baselines, &[spec("tocabi_run_position.toml", "quick")]).join("\n");
        for words in [
            "(`action.rate`): 125 Hz; the baseline has 250 Hz.",
            "(`action.servo_rate`): 500 Hz; the baseline has 2000 Hz.",
            "(`action.delay`): 0 ms; the baseline has 4 ms.",
            "(`randomize.link_mass`): absent; the baseline has per link, scale uniform [0.6, 1.4].",
            "(`task.motion`): run_gait; the baseline has run_clip.",
            "(`task.command.speed`): uniform [0.4, 1.2] m/s; the baseline has uniform [0, 1] m/s.",
            "(`learn.samples`): 3.0 M; the baseline has 80.0 M.",
            "(`learn.minibatch`): 1024; the baseline has 128.",
            "(`terminate.contact_schedule`): ",
            "; the baseline has none.",
        ] {
            assert!(said.contains(words), "{words} is not in\n{said}");
        }
        assert!(
            !said.contains("evaluate.") && !said.contains("deploy.") && !said.contains("(`learn.seed`)"),
            "{said}"
        );
    }

    #[test]
    fn a_key_in_which_some_arms_differ_is_told_once_with_their_numbers() {
        let baseline = spec("paper/baseline.toml", "");
        let with = |samples: u64| {
            let mut own = baseline.clone();
            let Some(Value::Table(learn)) = own.get_mut("learn") else { panic!("a section") };
            learn.insert("samples".into(), Value::Count(samples));
            own
        };
        let arms = [with(4_000_000), with(80_000_000), with(8_000_000), with(4_000_000)];
        let said = page(std::slice::from_ref(&baseline), &arms);
        let told: Vec<&String> = said.iter().filter(|text| text.contains("(`")).collect();
        let [told] = told.as_slice() else { panic!("one sentence: {told:?}") };
        let values =
            "(`learn.samples`): 4.0 M in 2 of 4 runs, 8.0 M in 1 of 4 runs; the baseline has 80.0 M.";
        assert!(told.ends_with(values), "{told}");
    }

    #[test]
    fn without_a_baseline_only_what_the_spec_declares_is_told() {
        let arm = Arm { fields: spec("tocabi_walk_torque.toml", "quick"), ..Arm::default() };
        let mut input = ReportInput { arms: vec![arm], ..ReportInput::default() };
        assert_eq!(sentences(&input), Vec::<String>::new());
        input.deviations = vec!["The robot is another".into()];
        assert_eq!(sentences(&input), ["The robot is another."]);
    }
}
