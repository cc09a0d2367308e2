//! The trainings by name, for TensorBoard: `tensorboard/ARM/seed_N/STAGE` in the store is a link to the folder
//! with the events of that stage, for a suite `tensorboard/SUITE/ARM/seed_N/STAGE`. TensorBoard takes a run's
//! name from its folder, and the folders of a store are named by fingerprints.

use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::{fs, process};

use super::store::Store;
use crate::kinds::learn::Ppo;
use crate::learn::tensorboard;
use crate::plan::graph::ArmRecord;
use crate::plan::{Plan, Stage, StageKind};
use crate::safe_fs;
use crate::spec::Section;

/// The folder of the links.
const FOLDER: &str = "tensorboard";

/// Links a running training under its names.
pub fn running(store: &Store, plan: &Plan, stage: &Stage) -> io::Result<()> {
    link(store, plan, stage, &Path::new("scratch").join(stage.fingerprint.as_str()))
}

/// Links a finished training under its names, if it has events: a restored one has none.
pub fn finished(store: &Store, plan: &Plan, stage: &Stage) -> io::Result<()> {
    let target = Path::new(stage.kind.name()).join(stage.fingerprint.as_str());
    match store.root().join(&target).join(tensorboard::NAME).is_file() {
        true => link(store, plan, stage, &target),
        false => Ok(()),
    }
}

/// Removes links whose trainings are gone, and folders that are empty then.
pub fn sweep(store: &Store) {
    let folder = store.root().join(FOLDER);
    if folder.symlink_metadata().is_ok_and(|found| found.is_dir()) {
        sweep_folder(&folder);
    }
}

fn sweep_folder(folder: &Path) {
    for entry in folder.read_dir().into_iter().flatten().flatten() {
        let path = entry.path();
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => sweep_folder(&path),
            Ok(kind) if kind.is_symlink() && !path.exists() => drop(fs::remove_file(&path)),
            _ => {}
        }
    }
    // Fails, as it should, unless the folder is empty.
    let _ = fs::remove_dir(folder);
}

fn link(store: &Store, plan: &Plan, stage: &Stage, target: &Path) -> io::Result<()> {
    if !matches!(stage.kind, StageKind::Learner | StageKind::FineTune) {
        return Ok(());
    }
    for user in &stage.users {
        let Some(arm) = plan.arms.iter().find(|arm| arm.name == user.arm) else { continue };
        let names = folders(plan, arm);
        let folder = safe_fs::inside(store.root(), &format!("{FOLDER}/{}", names.join("/")))?;
        fs::create_dir_all(&folder)?;
        let up: PathBuf = (0..=names.len()).map(|_| "..").collect();
        let (place, draft) =
            (folder.join(&user.stage), folder.join(format!(".{}.{}", user.stage, process::id())));
        if place.symlink_metadata().is_ok_and(|found| !found.is_symlink()) {
            return Err(io::Error::other(format!("{} is not a link", place.display())));
        }
        let _ = fs::remove_file(&draft);
        symlink(up.join(target), &draft).and_then(|()| fs::rename(&draft, &place))?;
    }
    Ok(())
}

/// The folders of an arm: its suite, its name and its seed.
fn folders(plan: &Plan, arm: &ArmRecord) -> Vec<String> {
    let suite = plan.suite.as_ref().map(|suite| suite.name.as_str());
    let name = arm.run.as_ref().map_or(&arm.name, |run| &run.arm);
    let seed = match &arm.run {
        Some(run) => Some(run.seed),
        None => Section::new(&arm.fields.table()).at(Ppo::seed),
    };
    let seed = seed.map(|seed| format!("seed_{seed}"));
    suite.into_iter().chain([name.as_str()]).map(plain).chain(seed).collect()
}

/// A name as that of a folder. One that has to be changed gets a digest, so that no two become the same.
fn plain(name: &str) -> String {
    let text: String = name.chars().map(|c| if c == '/' || c.is_control() { '_' } else { c }).collect();
    let text = if text.starts_with('.') { format!("_{text}") } else { text };
    match text == name {
        true => text,
        false => format!("{text}-{}", &blake3::hash(name.as_bytes()).to_hex()[..8]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_folders_of_their_own() {
        assert_eq!(plain("control=torque,stiffness=12.5 %"), "control=torque,stiffness=12.5 %");
        let changed = ["a/b", "a\tb", "..", "."].map(plain);
        assert!(changed.iter().all(|name| safe_fs::is_plain(name) && !name.contains('/')), "{changed:?}");
        assert_ne!(changed[0], changed[1]);
    }
}
