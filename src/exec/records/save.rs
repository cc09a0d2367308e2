//! Writes the records of a plan's finished runs.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value as Json;

use super::{Curve, FORMAT, RecordError, RunRecord, StageRecord, names};
use crate::bounded;
use crate::exec::manifest::{self, Depth, Manifest};
use crate::exec::store::Store;
use crate::learn::file as weight_file;
use crate::plan::graph::ArmRecord;
use crate::plan::{Cached, Plan, Stage, StageKind};
use crate::seal::{self, Seal};
use crate::{finite, safe_fs};

/// The weight files.
const WEIGHTS: [&str; 2] = ["actor.safetensors", "critic.safetensors"];

/// The result of saving a plan's runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    /// Files that were written.
    pub written: Vec<PathBuf>,
    /// Runs whose record existed already.
    pub present: usize,
    /// Runs that are not finished.
    pub unfinished: usize,
    /// Records written without the requested weights, because their trainings were restored without weights.
    pub weightless: usize,
}

/// Writes a record for each finished run of the plan that has none in the folder yet, with the weights of its
/// trainings on request. File names begin with `name`.
pub fn save(
    plan: &Plan,
    store: &Store,
    name: &str,
    folder: &Path,
    weights: bool,
) -> Result<Saved, RecordError> {
    let mut saved = Saved::default();
    let mut known = BTreeSet::new();
    let stems: Vec<String> = plan.arms.iter().map(|arm| names::stem(name, &arm.name, &mut known)).collect();
    let place = |stem: &String| folder.join(format!("{stem}.json"));
    if let Some(path) = stems.iter().map(place).find(|path| is_of_another_kind(path)) {
        return Err(RecordError::Occupied { path });
    }
    for (arm, stem) in plan.arms.iter().zip(&stems).filter(|_| weights) {
        let kinds: BTreeSet<StageKind> = recorded(plan, arm).iter().map(|stage| stage.kind).collect();
        let files = kinds.into_iter().flat_map(|kind| WEIGHTS.map(|file| weights_name(stem, kind, file)));
        if let Some(path) = files.map(|file| folder.join(file)).find(|path| are_no_weights(path)) {
            return Err(RecordError::Occupied { path });
        }
    }
    for (arm, stem) in plan.arms.iter().zip(stems) {
        let path = place(&stem);
        let stages = recorded(plan, arm);
        if stages
            .iter()
            .any(|stage| store.inspect(stage.kind, &stage.fingerprint, Depth::Quick) != Cached::Yes)
        {
            saved.unfinished += 1;
        } else if is_record_of(&path, &stages, weights) {
            saved.present += 1;
        } else {
            let beside = weights.then_some(Beside { folder, stem: &stem });
            let stages =
                stages.iter().map(|stage| stage_record(store, stage, beside)).collect::<Result<_, _>>()?;
            let (run, seal) = (arm.name.clone(), String::new());
            let record = RunRecord { format: FORMAT, run, file: stem, stages, seal };
            let text =
                |record: &RunRecord| finite::to_string(record).map_err(|found| RecordError::at(&path, found));
            let record = RunRecord { seal: seal::of(&text(&record)?).unwrap_or_default(), ..record };
            let text = text(&record)?;
            write(&path, (text + "\n").as_bytes())?;
            saved.weightless +=
                usize::from(weights && record.stages.iter().any(|stage| !has_weights(stage, folder)));
            saved.written.push(path);
        }
    }
    Ok(saved)
}

/// Whether a file exists that is not a record of a run, whole or edited, and must not be replaced by one.
fn is_of_another_kind(path: &Path) -> bool {
    let is_file = fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0);
    let is_record = |text: String| {
        let found: Json = serde_json::from_str(&text).unwrap_or_default();
        found.get("format").is_some_and(Json::is_number) && found.get("stages").is_some_and(Json::is_array)
    };
    is_file && !bounded::text(path, bounded::RECORD).is_ok_and(is_record)
}

/// Whether a file exists that does not hold the weights of a training, and must not be replaced by some.
fn are_no_weights(path: &Path) -> bool {
    let is_file = fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0);
    let header = || bounded::bytes(path, bounded::ARTEFACT).map(|bytes| weight_file::header(&bytes));
    is_file && !header().is_ok_and(|header| header.is_ok_and(|texts| !texts.is_empty()))
}

/// The name of a file of weights beside a record: `NAME.RUN.learner.actor.safetensors`.
fn weights_name(stem: &str, kind: StageKind, file: &str) -> String {
    format!("{stem}.{}.{file}", kind.name())
}

/// The expensive stages of a run; all others are made again in seconds.
fn recorded<'a>(plan: &'a Plan, arm: &ArmRecord) -> Vec<&'a Stage> {
    let is_dear = |stage: &&Stage| !stage.kind.is_of_spec_alone() && stage.kind != StageKind::Report;
    let keys: BTreeSet<_> = arm.stages.values().collect();
    plan.stages().filter(|stage| keys.contains(&stage.fingerprint)).filter(is_dear).collect()
}

/// Whether a file is a complete record of these stages, with their weights on request.
fn is_record_of(path: &Path, stages: &[&Stage], weights: bool) -> bool {
    let Ok(text) = bounded::text(path, bounded::RECORD) else { return false };
    let Ok(record) = serde_json::from_str::<RunRecord>(&text) else { return false };
    if record.format != FORMAT || seal::state(&text) != Seal::Whole {
        return false;
    }
    if names::flaw(&record, path).is_some() {
        return false;
    }
    let found: Option<Vec<&str>> =
        record.stages.iter().map(|stage| stage.manifest.pointer("/stage/fingerprint")?.as_str()).collect();
    let is_whole = |stage: &StageRecord| {
        let is_as_written = StageRecord::digest_of(&stage.files, stage.curve.as_ref()) == stage.digest;
        is_as_written && (!weights || has_weights(stage, safe_fs::folder_of(path)))
    };
    found.is_some_and(|found| found.into_iter().eq(stages.iter().map(|stage| stage.fingerprint.as_str())))
        && record.stages.iter().all(is_whole)
}

/// Whether all weights that a stage had when it was made are next to its record.
fn has_weights(stage: &StageRecord, folder: &Path) -> bool {
    let Ok(manifest) = Manifest::from_text(&stage.manifest.to_string()) else { return false };
    let mut made = manifest.files.iter().chain(&manifest.originals).map(|file| file.path.as_str());
    made.all(|file| {
        !WEIGHTS.contains(&file) || stage.beside.get(file).is_some_and(|name| folder.join(name).is_file())
    })
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    safe_fs::replace(path, bytes).map_err(|source| RecordError::Unwritten { path: path.to_owned(), source })
}

/// Where the weights of a run are written.
#[derive(Clone, Copy)]
struct Beside<'a> {
    folder: &'a Path,
    /// The start of their file names.
    stem: &'a str,
}

fn stage_record(store: &Store, stage: &Stage, weights: Option<Beside>) -> Result<StageRecord, RecordError> {
    let folder = store.folder(stage.kind, &stage.fingerprint);
    let path = folder.join(manifest::FILE);
    let text = bounded::text(&path, bounded::RECORD).map_err(|error| RecordError::at(&path, error))?;
    let whole = Manifest::from_text(&text).map_err(|reason| RecordError::at(&path, reason))?;
    let manifest = serde_json::from_str(&text).map_err(|error| RecordError::at(&path, error))?;
    let (mut files, mut curve, mut beside) = (BTreeMap::new(), None, BTreeMap::new());
    for file in &whole.files {
        let path = folder.join(&file.path);
        let text = || bounded::text(&path, bounded::RECORD).map_err(|error| RecordError::at(&path, error));
        if file.path == "metrics.jsonl" {
            curve = Some(Curve::of(&text()?).map_err(|error| RecordError::at(&path, error))?);
        } else if file.path.ends_with(".json") {
            let mut value: Json =
                serde_json::from_str(&text()?).map_err(|error| RecordError::at(&path, error))?;
            // The trace of one episode is most of an evaluation, and only figures use it.
            if let Some(evaluation) = value.as_object_mut().filter(|_| file.path == "evaluation.json") {
                evaluation.shift_remove("trace");
            }
            files.insert(file.path.clone(), value);
        } else if let Some(Beside { folder: target, stem }) =
            weights.filter(|_| WEIGHTS.contains(&file.path.as_str()))
        {
            let name = weights_name(stem, stage.kind, &file.path);
            let bytes =
                bounded::bytes(&path, bounded::ARTEFACT).map_err(|error| RecordError::at(&path, error))?;
            let place = target.join(&name);
            write(&place, &bytes)?;
            beside.insert(file.path.clone(), name);
        }
    }
    let digest = StageRecord::digest_of(&files, curve.as_ref());
    Ok(StageRecord { manifest, files, curve, beside, digest })
}
