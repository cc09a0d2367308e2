//! `docs/reference/files.md` describes every field of the files that specforge writes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value as Json;
use specforge::deploy::Policy;
use specforge::learn::pretrain::PretrainReport;
use specforge::learn::{Summary, UpdateMetrics};
use specforge::outcome::{Episode, Evaluation, Trace};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A chapter of the page, up to the next one.
fn chapter(title: &str) -> String {
    let page = fs::read_to_string(root().join("docs/reference/files.md")).expect("the page is there");
    let (_, rest) =
        page.split_once(&format!("\n## {title}\n")).unwrap_or_else(|| panic!("no chapter {title}"));
    rest.split("\n## ").next().unwrap_or_default().to_owned()
}

/// The words in back quotes of a text.
fn words(text: &str) -> BTreeSet<&str> {
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.flat_map(|word| word.split([' ', '.', ':'])).collect()
}

/// The keys of a value, and of the values below the keys in `deep`.
fn keys(value: &Json, deep: &[&str]) -> BTreeSet<String> {
    match value {
        Json::Object(map) => {
            let below = map.iter().filter(|(key, _)| deep.contains(&key.as_str()));
            let below: Vec<String> = below.flat_map(|(_, value)| keys(value, deep)).collect();
            map.keys().cloned().chain(below).collect()
        }
        Json::Array(items) => items.iter().flat_map(|item| keys(item, deep)).collect(),
        _ => BTreeSet::new(),
    }
}

fn json(value: &impl Serialize) -> Json {
    serde_json::to_value(value).expect("plain data")
}

fn read(path: &Path) -> Json {
    serde_json::from_str(&fs::read_to_string(path).expect("readable")).expect("JSON")
}

/// The keys that the chapter does not describe.
fn missing(title: &str, value: &Json, deep: &[&str]) -> Vec<String> {
    let text = chapter(title);
    let known = words(&text);
    keys(value, deep).into_iter().filter(|key| !known.contains(key.as_str())).collect()
}

/// The committed files of a folder with this ending, at least one.
fn committed(folder: &str, ending: &str) -> Vec<PathBuf> {
    let paths = files(folder, ending);
    assert!(!paths.is_empty(), "{folder}");
    paths
}

/// The files of a folder with this ending.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).expect("the folder is there");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(ending));
    paths.sort();
    paths
}

#[test]
fn the_contract_is_described() {
    for path in committed("reports/policies", ".safetensors") {
        let policy = Policy::from_bytes(&fs::read(&path).expect("readable")).expect("a committed policy");
        let deep = [
            "robot",
            "rates",
            "inputs",
            "outputs",
            "law",
            "filter",
            "phase",
            "symmetry",
            "mirror",
            "provenance",
        ];
        assert_eq!(missing("contract.json", &json(&policy.contract), &deep), [""; 0], "{}", path.display());
        let text = chapter("contract.json");
        let known = words(&text);
        for input in &policy.contract.inputs {
            assert!(known.contains(input.signal.as_str()), "{}", input.signal);
        }
    }
}

#[test]
fn the_tensors_and_texts_of_a_policy_are_described() {
    let text = chapter("policy.safetensors");
    for path in committed("reports/policies", ".safetensors") {
        let bytes = fs::read(&path).expect("readable");
        let (tensors, motion, header) = specforge::learn::file::read_with(&bytes).expect("a policy");
        let layer = |name: &String| {
            let mut parts = name.split('.');
            format!("{}.K.{}", parts.next().unwrap_or_default(), parts.next_back().unwrap_or_default())
        };
        let names = tensors.keys().map(layer).chain(motion.into_keys()).chain(header.into_keys());
        for name in names {
            assert!(text.contains(&format!("`{name}`")), "{name} of {}", path.display());
        }
    }
}

#[test]
fn the_metrics_of_a_training_are_described() {
    assert_eq!(missing("metrics.jsonl", &json(&UpdateMetrics::default()), &[]), [""; 0]);
    assert_eq!(missing("summary.json", &json(&Summary::default()), &[]), [""; 0]);
    assert_eq!(missing("summary.json", &json(&PretrainReport::default()), &[]), [""; 0]);
}

#[test]
fn evaluations_are_described() {
    let episode = Episode {
        drift: Some(0.0),
        crossed: Some(true),
        peak_ankle_torque: Some(0.0),
        self_collision: Some(0.0),
        parameters: [("link_mass".to_owned(), 1.0)].into(),
        command: Some(0.0),
        ..Episode::default()
    };
    let trace = Trace { foot_position: vec![[[0.0; 3]; 2]], ..Trace::default() };
    let evaluation =
        Evaluation { obstacle: Some([0.0; 2]), episodes: vec![episode], trace, ..Evaluation::default() };
    assert_eq!(missing("evaluation.json", &json(&evaluation), &["episodes", "trace"]), [""; 0]);
}

#[test]
fn records_are_described() {
    for path in committed("reports/studies/runs", ".json") {
        let record = read(&path);
        assert_eq!(missing("Records of runs", &record, &["stages", "curve"]), [""; 0], "{}", path.display());
        for stage in record["stages"].as_array().expect("a list") {
            let deep = ["stage", "recipe", "provenance", "users"];
            assert_eq!(missing("The store", &stage["manifest"], &deep), [""; 0], "{}", path.display());
        }
    }
    // Which suites have a page changes; the main job always has one.
    let suites = ["reports/paper", "reports/studies"].into_iter().flat_map(|folder| files(folder, ".json"));
    for path in committed("reports", ".json").into_iter().chain(suites) {
        let deep = ["facts", "items"];
        assert_eq!(missing("Records of reports", &read(&path), &deep), [""; 0], "{}", path.display());
    }
}
