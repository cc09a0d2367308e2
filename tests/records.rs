//! Records of runs: a run outlives its store, for reports without its weights, for more evaluations with
//! them.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod sets;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value as Json;
use specforge::plan::fingerprint::canonical_json;

const SPEC: &str = "specs/tocabi_walk_torque.toml";

/// A training and two evaluations of some seconds.
const SMALL: &[&str] = &[
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=512",
    "learn.rollout=256",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "evaluate.nominal.episodes=2",
    "evaluate.nominal.time_limit=\"1 s\"",
    "deploy.mujoco.episodes=2",
    "deploy.rapier.episodes=2",
    "report.compare=[]",
];

fn specforge(store: &Path, words: &[&str], more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("--store").arg(store).env("OMP_NUM_THREADS", "1");
    command.args(words);
    if !matches!(words, ["cache", "import", ..]) {
        command.args([SPEC, "--profile", "quick"]);
        command.args(sets::usual(SMALL, more)).args(more.iter().flat_map(|set| ["--set", set]));
    }
    command.output().unwrap()
}

fn text_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", text_of(output));
    text_of(output)
}

/// Runs and gives the record beside the page, without what depends on the clock and on the folder.
fn page(store: &Path, more: &[&str]) -> (String, Json) {
    let reports = store.join("reports");
    let output = specforge(store, &["run", "--jobs", "2", "--reports", reports.to_str().unwrap()], more);
    let said = succeeds(&output);
    let record = fs::read_to_string(reports.join("tocabi_walk_torque.json")).unwrap();
    (said, serde_json::from_str(&record).unwrap())
}

fn records(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn names(paths: &[PathBuf]) -> Vec<&str> {
    paths.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect()
}

#[test]
fn a_run_outlives_its_store_for_reports_and_with_its_weights_for_evaluations() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (first, second, third) = (at("first"), at("second"), at("third"));
    let (_, expected) = page(&first, &[]);

    // Without weights: for a report all is there.
    let light = at("light");
    let said = succeeds(&specforge(&first, &["cache", "export", "--to", light.to_str().unwrap()], &[]));
    assert!(said.contains("1 record written, 0 there already, 0 runs not finished"), "{said}");
    assert_eq!(names(&records(&light)), ["tocabi_walk_torque.tocabi_walk_torque.json"]);
    let said = succeeds(&specforge(&first, &["cache", "export", "--to", light.to_str().unwrap()], &[]));
    assert!(said.contains("0 records written, 1 there already"), "{said}");
    let said = succeeds(&specforge(&second, &["cache", "import", light.to_str().unwrap()], &[]));
    assert!(said.contains("1 record: 6 stages restored, 0 in the store already"), "{said}");
    let (said, found) = page(&second, &[]);
    assert!(!said.contains("learner  done") && !said.contains("made anew"), "{said}");
    assert_eq!(found["arms"][0]["evaluations"], expected["arms"][0]["evaluations"]);
    assert!(
        Command::new(env!("CARGO_BIN_EXE_specforge"))
            .args(["--store", second.to_str().unwrap(), "cache", "verify"])
            .status()
            .unwrap()
            .success()
    );
    // Another evaluation needs the weights, so the policy is trained again, to the same bits.
    let more = ["evaluate.nominal.episodes=3"];
    let (said, remade) = page(&second, &more);
    assert!(said.contains("restored from a record without its weights"), "{said}");

    // Several imports at once restore each stage once, also in place of a damaged one.
    let shared = at("shared");
    let import = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.arg("--store").arg(&shared).args(["--format", "json", "cache", "import"]).arg(&light);
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap()
    };
    let restored: u64 = [import(), import(), import()]
        .into_iter()
        .map(|child| {
            let output = child.wait_with_output().unwrap();
            succeeds(&output);
            serde_json::from_slice::<Json>(&output.stdout).unwrap()["stages"].as_u64().unwrap()
        })
        .sum();
    assert_eq!(restored, 6);
    let learner = records(&shared.join("learner")).remove(0);
    fs::write(learner.join("summary.json"), "{}").unwrap();
    let said = succeeds(&specforge(&shared, &["cache", "import", light.to_str().unwrap()], &[]));
    assert!(said.contains("1 stage restored, 5 in the store already"), "{said}");
    assert_eq!(fs::read_dir(shared.join("damaged")).unwrap().count(), 1);

    // With weights it is not.
    let whole = at("whole");
    let export =
        || specforge(&first, &["cache", "export", "--weights", "--to", whole.to_str().unwrap()], &[]);
    fs::create_dir(&whole).unwrap();
    let mine = whole.join("tocabi_walk_torque.tocabi_walk_torque.learner.actor.safetensors");
    fs::write(&mine, "my own file").unwrap();
    let output = export();
    assert_eq!(output.status.code(), Some(4), "{}", text_of(&output));
    assert!(text_of(&output).contains("exists and is not a record of a run or its weights"), "{output:?}");
    assert_eq!(fs::read(&mine).unwrap(), b"my own file");
    assert_eq!(records(&whole), std::slice::from_ref(&mine));
    fs::remove_file(&mine).unwrap();
    succeeds(&export());
    // Its own files are replaced.
    fs::remove_file(whole.join("tocabi_walk_torque.tocabi_walk_torque.json")).unwrap();
    succeeds(&export());
    assert_eq!(
        names(&records(&whole)),
        [
            "tocabi_walk_torque.tocabi_walk_torque.json",
            "tocabi_walk_torque.tocabi_walk_torque.learner.actor.safetensors",
            "tocabi_walk_torque.tocabi_walk_torque.learner.critic.safetensors",
            "tocabi_walk_torque.tocabi_walk_torque.pretrain.actor.safetensors",
        ]
    );
    succeeds(&specforge(&third, &["cache", "import", whole.to_str().unwrap()], &[]));
    // A record without them is no reason not to write them, and one that was changed is written again.
    let export = |store: &Path| {
        specforge(store, &["cache", "export", "--weights", "--to", light.to_str().unwrap()], &[])
    };
    assert!(succeeds(&export(&first)).contains("1 record written"));
    assert!(succeeds(&export(&first)).contains("1 there already"));
    let path = light.join("tocabi_walk_torque.tocabi_walk_torque.json");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replacen("\"survived\":", "\"survived_too\":", 1)).unwrap();
    assert!(succeeds(&export(&first)).contains("1 record written"));
    assert_eq!(fs::read_to_string(&path).unwrap(), text);
    let bare = at("bare");
    let output = specforge(&shared, &["cache", "export", "--weights", "--to", bare.to_str().unwrap()], &[]);
    assert!(succeeds(&output).contains("1 record without weights"));
    let (said, other) = page(&third, &more);
    assert!(!said.contains("made anew"), "{said}");
    assert_eq!(other["arms"][0]["evaluations"], remade["arms"][0]["evaluations"]);
}

#[test]
fn a_report_from_imported_records_is_that_of_the_run_and_one_of_a_damaged_store_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (first, second, saved) = (at("first"), at("second"), at("records"));
    page(&first, &[]);
    succeeds(&specforge(&first, &["cache", "export", "--to", saved.to_str().unwrap()], &[]));
    // Files of another kind do not keep a record from being imported, and what may be one is named.
    let import = || specforge(&second, &["cache", "import", saved.to_str().unwrap()], &[]);
    fs::write(saved.join("a_notes.json"), "{\"mine\": 1}").unwrap();
    fs::write(saved.join("b_torn.json"), "{\"format\": 3, \"run\"").unwrap();
    fs::create_dir(saved.join("c.json")).unwrap();
    let output = import();
    let said = text_of(&output);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("a_notes.json is not the record of a run, and was skipped"), "{said}");
    assert!(
        said.contains("error: ") && said.contains("b_torn.json: it is not the record of a run"),
        "{said}"
    );
    assert!(said.contains("1 record: 6 stages restored, 0 in the store already"), "{said}");
    fs::remove_file(saved.join("b_torn.json")).unwrap();
    assert!(succeeds(&import()).contains("1 record: 0 stages restored, 6 in the store already"));

    // The robot and the motion are not in the records, and follow from the spec.
    let report =
        |reports: &Path| specforge(&second, &["report", "--reports", reports.to_str().unwrap()], &[]);
    let text = |folder: &Path| fs::read_to_string(folder.join("tocabi_walk_torque.md")).unwrap();
    let record = |folder: &Path| -> Json {
        let text = fs::read_to_string(folder.join("tocabi_walk_torque.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let (own, reports) = (first.join("reports"), at("reports"));
    succeeds(&report(&reports));
    assert!(!text(&reports).contains("has not been run"), "{}", text(&reports));
    let robot = |folder: &Path| text(folder).lines().find(|line| line.contains(" kg, ")).map(str::to_owned);
    assert!(robot(&own).is_some(), "{}", text(&own));
    assert_eq!(robot(&reports), robot(&own));
    let names = |folder: &Path| -> Vec<Json> {
        let stages = record(folder)["arms"][0]["stages"].as_array().unwrap().clone();
        stages.into_iter().map(|stage| stage["fingerprint"].clone()).collect()
    };
    assert_eq!(record(&reports)["facts"], record(&own)["facts"]);
    assert_eq!(names(&reports), names(&own));

    // A damaged result is left where it is, is not said to be made anew, and is missed.
    let evaluation = records(&second.join("evaluate")).remove(0).join("evaluation.json");
    let whole = fs::read(&evaluation).unwrap();
    fs::write(&evaluation, "{}").unwrap();
    let said = succeeds(&report(&at("rendered")));
    assert!(said.contains("is damaged (") && !said.contains("missing"), "the stored report has it: {said}");
    assert_eq!(names(&at("rendered")), names(&own));
    fs::remove_dir_all(second.join("report")).unwrap();
    let lacks = |reports: &Path| {
        let output = report(reports);
        let said = text_of(&output);
        assert_eq!(output.status.code(), Some(4), "{said}");
        assert!(said.contains("is damaged (") && said.contains("so it is not used"), "{said}");
        assert!(said.contains("error: results are missing from the report: 1 of 10 stages is"), "{said}");
        assert!(!said.contains("moved to"), "{said}");
        assert_eq!(fs::read(&evaluation).unwrap(), b"{}");
        assert_eq!(names(reports).len(), names(&own).len() - 1);
    };
    lacks(&at("lacking"));
    let before = text(&reports);
    assert_eq!(report(&reports).status.code(), Some(4));
    assert_eq!(text(&reports), before, "a page with more results is kept");
    // The same in a store that cannot be written.
    closed(&second);
    lacks(&at("lacking_too"));
    fs::write(&evaluation, whole).unwrap();
    let robot_file = records(&second.join("robot")).remove(0).join("robot.json");
    fs::write(&robot_file, "{}").unwrap();
    let said = succeeds(&report(&at("remade")));
    assert!(said.contains("made anew for this command only"), "{said}");
    assert_eq!(robot(&at("remade")), robot(&own));
    assert_eq!(fs::read(&robot_file).unwrap(), b"{}");
}

#[test]
fn a_longer_training_says_that_a_record_of_the_shorter_one_has_no_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (first, second, saved) = (at("first"), at("second"), at("records"));
    let stopped = ["learn.stop_at=256"];
    page(&first, &stopped);
    succeeds(&specforge(&first, &["cache", "export", "--to", saved.to_str().unwrap()], &stopped));
    succeeds(&specforge(&second, &["cache", "import", saved.to_str().unwrap()], &[]));
    let said = succeeds(&specforge(&second, &["run", "--until", "tocabi_walk_torque/learner"], &[]));
    let told = "of 256 samples cannot be continued: it was restored from a record, and records hold no \
        checkpoint; the training begins";
    assert!(said.contains(told), "{said}");
}

#[test]
fn what_cannot_be_imported_or_exported_is_said_and_makes_no_store() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (empty, photos, store) = (at("empty"), at("photos"), at("store"));
    fs::create_dir(&empty).unwrap();
    fs::create_dir(&photos).unwrap();
    fs::write(photos.join("a.json"), "{}").unwrap();
    let refused = |store: &Path, from: &Path, code: i32, reason: &str| {
        let output = specforge(store, &["cache", "import", from.to_str().unwrap()], &[]);
        assert_eq!(output.status.code(), Some(code), "{}", text_of(&output));
        assert!(text_of(&output).contains(reason), "{}", text_of(&output));
    };
    refused(&store, &empty, 4, "none of its files ends with `.json`");
    refused(&store, &at("none"), 4, "cannot be read");
    refused(&store, &photos, 4, "no records of runs in");
    refused(&store, &photos.join("a.json"), 2, "is a file, not a folder of records");
    assert!(!store.exists());
    refused(&photos, &photos, 4, "[E0813]");
    assert_eq!(names(&records(&photos)), ["a.json"]);
    let file = photos.join("a.json");
    let output = specforge(&store, &["cache", "export", "--to", file.to_str().unwrap()], &[]);
    assert_eq!(output.status.code(), Some(2), "{}", text_of(&output));
    assert!(
        text_of(&output).contains("`--to DIR`") && !text_of(&output).contains("--store DIR"),
        "{}",
        text_of(&output)
    );
}

/// Makes a store one that nobody can write, not even root: files stand where its folders for that would be.
fn closed(store: &Path) {
    for folder in ["tmp", "scratch", "locks", "leases"] {
        fs::remove_dir_all(store.join(folder)).unwrap();
        fs::write(store.join(folder), "").unwrap();
    }
}

fn content(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for path in records(folder) {
        match path.is_dir() {
            true => found.extend(content(&path)),
            false => found.push((path.clone(), fs::read(&path).unwrap())),
        }
    }
    found
}

#[test]
fn a_report_is_rendered_from_a_store_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (store, reports) = (at("store"), at("reports"));
    page(&store, &[]);
    let own = fs::read(store.join("reports/tocabi_walk_torque.json")).unwrap();
    closed(&store);
    let render = || specforge(&store, &["report", "--reports", reports.to_str().unwrap()], &[]);
    let before = content(&store);
    succeeds(&render());
    assert_eq!(fs::read(reports.join("tocabi_walk_torque.json")).unwrap(), own);
    // Without the rendered report, too: rendering only reads the results.
    fs::remove_dir_all(store.join("report")).unwrap();
    fs::remove_dir_all(&reports).unwrap();
    let rest: Vec<_> =
        before.into_iter().filter(|(path, _)| !path.starts_with(store.join("report"))).collect();
    succeeds(&render());
    assert!(reports.join("tocabi_walk_torque.md").is_file());
    assert!(content(&store) == rest, "the store is as it was");
    // What was written into a page by hand outlives it.
    let edited = reports.join("tocabi_walk_torque.md");
    let text = fs::read_to_string(&edited).unwrap() + "\nMy note.\n";
    fs::write(&edited, &text).unwrap();
    let told = succeeds(&render());
    assert!(told.contains("warning: ") && told.contains("was edited after it was rendered"), "{told}");
    assert_eq!(fs::read_to_string(reports.join("tocabi_walk_torque.md.edited")).unwrap(), text);
    assert!(!fs::read_to_string(&edited).unwrap().contains("My note."));
}

/// A record with one change, in the first of its stages that the change applies to.
fn changed(record: &Json, change: impl Fn(&mut Json) -> bool) -> String {
    let mut record = record.clone();
    let stages = record["stages"].as_array_mut().expect("stages");
    assert!(stages.iter_mut().any(change), "nothing was changed");
    record.to_string()
}

#[test]
fn a_record_with_other_numbers_or_without_a_part_is_refused_and_restores_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (store, saved) = (at("store"), at("records"));
    page(&store, &[]);
    succeeds(&specforge(&store, &["cache", "export", "--to", saved.to_str().unwrap()], &[]));
    let path = saved.join("tocabi_walk_torque.tocabi_walk_torque.json");
    // A record knows its file, so one under another name that ends in the same run is refused.
    let renamed = saved.join("other.tocabi_walk_torque.json");
    fs::rename(&path, &renamed).unwrap();
    let output = specforge(&at("none"), &["cache", "import", saved.to_str().unwrap()], &[]);
    assert_eq!(output.status.code(), Some(4), "{}", text_of(&output));
    assert!(text_of(&output).contains("it was renamed or copied"), "{}", text_of(&output));
    fs::rename(&renamed, &path).unwrap();
    let record: Json = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let evaluation = |stage: &mut Json, change: &dyn Fn(&mut serde_json::Map<String, Json>)| {
        let files = stage["files"].as_object_mut().expect("files");
        let is_there = files.contains_key("evaluation.json");
        is_there.then(|| change(files)).is_some()
    };
    // Without the digest of what was taken away the gap itself must be found.
    let sealed = |stage: &mut Json| {
        let curve = stage.get("curve").cloned().unwrap_or_default();
        let content = canonical_json(&serde_json::json!({ "files": stage["files"], "curve": curve }));
        stage["digest"] = blake3::hash(content.as_bytes()).to_hex().to_string().into();
    };
    let survives = changed(&record, |stage| {
        evaluation(stage, &|files| files["evaluation.json"]["episodes"][0]["survived"] = Json::Null)
    });
    let longer = changed(&record, |stage| {
        stage.get_mut("curve").is_some_and(|curve| {
            curve["return_mean"][0] = 1e9.into();
            true
        })
    });
    let without_evaluation = changed(&record, |stage| {
        let found = evaluation(stage, &|files| drop(files.remove("evaluation.json")));
        if found {
            sealed(stage);
        }
        found
    });
    let without_curve = changed(&record, |stage| {
        let found = stage.as_object_mut().expect("a stage").remove("curve").is_some();
        if found {
            sealed(stage);
        }
        found
    });
    let more = changed(&record, |stage| {
        let found = evaluation(stage, &|files| drop(files.insert("other.json".into(), Json::Null)));
        if found {
            sealed(stage);
        }
        found
    });
    for (text, reason) in [
        (survives, "are not as they were written"),
        (longer, "are not as they were written"),
        (without_evaluation, "`evaluation.json` is missing"),
        (without_curve, "`metrics.jsonl` is missing"),
        (more, "`other.json` is not a file of the stage"),
    ] {
        let import = |text: &str, reason: &str| {
            fs::write(&path, text).unwrap();
            let other = tempfile::tempdir().unwrap();
            let output = specforge(other.path(), &["cache", "import", saved.to_str().unwrap()], &[]);
            assert_eq!(output.status.code(), Some(4), "{}", text_of(&output));
            assert!(text_of(&output).contains(reason), "{}", text_of(&output));
            let kinds = ["pretrain", "learner", "evaluate", "export", "transfer"];
            let is_restored = |kind: &&str| other.path().join(kind).exists();
            assert!(!kinds.iter().any(is_restored), "{reason}: a part was restored");
        };
        import(&text, "it was changed after it was written: it does not have its own digest");
        // Sealed again it still contradicts itself.
        let mut json: Json = serde_json::from_str(&text).unwrap();
        json["seal"] = specforge::seal::of(&text).expect("an object").into();
        import(&json.to_string(), reason);
    }
}

#[test]
fn a_record_that_was_changed_or_is_none_is_refused_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (store, other, saved) = (at("store"), at("other"), at("records"));
    let output = specforge(&store, &["cache", "export", "--to", saved.to_str().unwrap()], &[]);
    assert!(succeeds(&output).contains("0 records written, 0 there already, 1 run not finished"));
    let path = saved.join("a.json");
    let import = || specforge(&other, &["cache", "import", saved.to_str().unwrap()], &[]);
    for (bytes, reason) in [
        ("{", "is not the record of a run"),
        (r#"{"format":1,"run":"a","stages":[]}"#, "its format is 1"),
        (r#"{"format":2,"run":"a","stages":[]}"#, "its format is 2"),
        (r#"{"format":3,"run":"a","stages":[]}"#, "missing field `file`"),
        (r#"{"format":3,"run":"a","file":"a","stages":[]}"#, "has no digest"),
    ] {
        fs::write(&path, bytes).unwrap();
        let output = import();
        assert_eq!(output.status.code(), Some(4), "{}", text_of(&output));
        assert!(
            text_of(&output).contains(reason) && text_of(&output).contains("a.json"),
            "{}",
            text_of(&output)
        );
    }
}
