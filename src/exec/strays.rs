//! Files in an artefact's folder that its manifest does not list. Those that people and their programs leave
//! there (notes, `.DS_Store`, backups of an editor) are ignored; those with the name of a result are damage,
//! because a reader would take them for one.

use std::path::Path;

use super::manifest::{Manifest, list};
use crate::learn::beside;

/// The record of the training that a training continued.
pub const CONTINUES: &str = "continues.json";

/// File name extensions of results: weights, policies and TorchScript.
const ENDINGS: [&str; 2] = [".safetensors", ".pt"];

/// Names of other results.
const NAMES: [&str; 10] = [
    "contract.json",
    "controller.json",
    "env.json",
    "evaluation.json",
    "motion.json",
    "pretrain.json",
    "robot.json",
    "summary.json",
    CONTINUES,
    beside::METRICS,
];

/// The files of an artefact's folder that its manifest does not list and that are not named like a result,
/// as paths in the folder, sorted.
pub fn of(manifest: &Manifest, folder: &Path) -> Vec<String> {
    let mut found = unlisted(manifest, folder);
    found.retain(|path| !is_result(path));
    found
}

/// A file named like a result that the manifest does not list.
pub(super) fn false_result(manifest: &Manifest, folder: &Path) -> Option<String> {
    unlisted(manifest, folder).into_iter().find(|path| is_result(path))
}

/// The files that the manifest does not list. What cannot be listed is not a result either: no stage reads
/// folders.
fn unlisted(manifest: &Manifest, folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let _ = list(folder, folder, &mut found);
    found.retain(|path| manifest.files.iter().all(|file| file.path != *path));
    found.sort();
    found
}

/// Whether a file has the name of a result. Results lie in the artefact's folder itself.
fn is_result(path: &str) -> bool {
    !path.starts_with('.')
        && !path.contains('/')
        && (NAMES.contains(&path) || ENDINGS.iter().any(|ending| path.ends_with(ending)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_no_result_and_weights_are_one_under_any_name() {
        for path in ["notes.txt", ".DS_Store", "summary.json~", ".summary.json.swp", "old/actor.safetensors"]
        {
            assert!(!is_result(path), "{path}");
        }
        for path in ["summary.json", "actor.safetensors", "policy.pt", "metrics.jsonl", "continues.json"] {
            assert!(is_result(path), "{path}");
        }
    }
}
