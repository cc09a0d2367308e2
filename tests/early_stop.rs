//! Trainings that end early under a longer schedule, and those that continue them (`learn.stop_at`).

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod sets;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A training of some seconds: 8 updates of 256 samples, whose step size falls over all of them.
const SMALL: &[&str] = &[
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=2048",
    "learn.rollout=256",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "learn.learning_rate={ linear = [1e-4, 1e-6] }",
];

fn train(store: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("--store").arg(store).env("OMP_NUM_THREADS", "1");
    command.args(["run", "specs/tocabi_walk_torque.toml", "--profile", "quick", "--jobs", "1"]);
    command.args(sets::usual(SMALL, more)).args(more.iter().flat_map(|set| ["--set", set]));
    command.args(["--until", "tocabi_walk_torque/learner"]).arg("--reports").arg(store.join("reports"));
    let output = command.stdout(Stdio::piped()).stderr(Stdio::piped()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// The trainings in a store by their number of samples.
fn trainings(store: &Path) -> Vec<(u64, PathBuf)> {
    let folders = fs::read_dir(store.join("learner")).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<_> =
        folders.map(|path| (json(&path, "summary.json")["samples"].as_u64().unwrap(), path)).collect();
    found.sort();
    found
}

fn json(folder: &Path, name: &str) -> serde_json::Value {
    serde_json::from_slice(&fs::read(folder.join(name)).unwrap()).unwrap()
}

/// The metrics of a training without what depends on the clock.
fn metrics(folder: &Path) -> Vec<serde_json::Value> {
    let text = fs::read_to_string(folder.join("metrics.jsonl")).unwrap();
    let timeless = |line: &str| {
        let mut line: serde_json::Map<String, serde_json::Value> = serde_json::from_str(line).unwrap();
        ["wall_s", "cpu_s", "learner_cpu_s", "samples_per_s"].iter().for_each(|key| drop(line.remove(*key)));
        line.into()
    };
    text.lines().map(timeless).collect()
}

fn name(folder: &Path) -> &str {
    folder.file_name().unwrap().to_str().unwrap()
}

#[test]
fn a_longer_training_continues_a_shorter_one_to_the_bits_of_an_uninterrupted_one() {
    let [whole, chain] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    train(whole.path(), &[]);
    let (_, expected) = trainings(whole.path()).remove(0);
    assert!(!expected.join("checkpoint.safetensors").exists() && !expected.join("continues.json").exists());

    train(chain.path(), &["learn.stop_at=512"]);
    // Rounded up to whole updates.
    let second = train(chain.path(), &["learn.stop_at=1000"]);
    let third = train(chain.path(), &[]);
    let found = trainings(chain.path());
    assert_eq!(found.iter().map(|(samples, _)| *samples).collect::<Vec<_>>(), [512, 1024, 2048]);
    let [(_, first), (_, middle), (_, last)] = <[_; 3]>::try_from(found).unwrap();
    for (longer, shorter, samples, output) in [(&middle, &first, 512, second), (&last, &middle, 1000, third)]
    {
        let record = json(longer, "continues.json");
        assert_eq!((&record["fingerprint"], &record["samples"]), (&name(shorter).into(), &samples.into()));
        let told = format!("continues training {} from {samples} samples", &name(shorter)[..12]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(text.contains(&format!("note: tocabi_walk_torque/learner: {told}")), "{text}");
        assert!(!text.lines().any(|line| line.contains("warning") && line.contains("continue")), "{text}");
    }
    assert_eq!(name(&last), name(&expected), "its fingerprint is that of the uninterrupted training");
    for file in ["actor.safetensors", "critic.safetensors"] {
        assert!(fs::read(last.join(file)).unwrap() == fs::read(expected.join(file)).unwrap(), "{file}");
    }
    assert_eq!(metrics(&last), metrics(&expected));
    assert_eq!(metrics(&middle), metrics(&expected)[..4], "its schedule is the whole one's");
}

#[test]
fn only_a_whole_beginning_of_the_same_training_is_continued() {
    let store = tempfile::tempdir().unwrap();
    train(store.path(), &["learn.stop_at=512"]);
    let (_, first) = trainings(store.path()).remove(0);
    let continued = |output: &Output| String::from_utf8_lossy(&output.stderr).contains("continues training");
    // Another seed, another schedule, less than what there is.
    for other in ["learn.seed=2", "learn.samples=1024", "learn.stop_at=256"] {
        assert!(!continued(&train(store.path(), &[other])), "{other}");
    }
    let checkpoint = first.join("checkpoint.safetensors");
    let mut bytes = fs::read(&checkpoint).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&checkpoint, bytes).unwrap();
    // That of 256 samples is whole.
    let output = train(store.path(), &[]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("from 256 samples"), "{text}");
    let told = format!("of 512 samples cannot be continued: {} is damaged", first.display());
    assert!(text.contains("warning[R0003]") && text.contains(&told), "{text}");
}

/// Whether a training whose manifest cannot be read is the beginning of another one is known where its recipe
/// is left, and is told either way.
#[test]
fn a_shorter_training_with_a_damaged_manifest_is_named() {
    let store = tempfile::tempdir().unwrap();
    train(store.path(), &["learn.stop_at=512"]);
    let (_, shorter) = trainings(store.path()).remove(0);
    let (short, manifest) = (&name(&shorter)[..12], shorter.join("manifest.json"));
    let whole = fs::read_to_string(&manifest).unwrap();
    let told = |damaged: Option<&str>, stop_at: &str| {
        match damaged {
            Some(text) => fs::write(&manifest, text).unwrap(),
            None => fs::remove_file(&manifest).unwrap(),
        }
        String::from_utf8_lossy(&train(store.path(), &[stop_at]).stderr).into_owned()
    };
    let begins = "the training begins at its first sample";
    // The recipe is left: another digest, and the rest of the manifest gone.
    let other = whole.replace("\"digest\": \"", "\"digest\": \"0");
    let text = told(Some(&other), "learn.stop_at=768");
    let expected = format!(
        "training {short} of 512 samples cannot be continued: {} is damaged (manifest.json does not match \
         its digest); {begins}",
        shorter.display()
    );
    assert!(text.contains("warning[R0003]") && text.contains(&expected), "{text}");
    // Nothing is left of it.
    for (damaged, reason) in
        [(Some(&whole[..whole.len() / 2]), "is not JSON"), (Some("{}"), "has no digest"), (None, "")]
    {
        let _ = fs::remove_dir_all(store.path().join("learner").join(trainings_but(store.path(), &shorter)));
        let text = told(damaged, "learn.stop_at=768");
        let expected = format!(
            "whether training {short} is the beginning of this one cannot be said: {}",
            shorter.display()
        );
        assert!(
            text.contains("warning[R0003]") && text.contains(&expected) && text.contains(reason),
            "{text}"
        );
        assert!(text.contains(begins), "{text}");
    }
}

/// The folder of the training that is not this one.
fn trainings_but(store: &Path, folder: &Path) -> PathBuf {
    let mut found = trainings(store).into_iter().map(|(_, path)| path);
    found.find(|path| path != folder).expect("a second training")
}
