//! `specforge evaluate POLICY`: what it refuses, and that its numbers are those of a run's own stages.

mod arms;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use specforge::check::checked;
use specforge::deploy::{Policy, Provenance};
use specforge::env::Blueprint;
use specforge::kinds::motion::shipped;
use specforge::learn::{Activation, Network};
use specforge::spec::LoadOptions;
use specforge::stream::Stream;
use specforge::study::{Log, Study};

fn evaluate(policy: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1").arg("evaluate").arg(policy);
    command.args(arguments).output().expect("the program can be started")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// An untrained policy for TOCABI's walk.
fn policy() -> Policy {
    policy_of("tocabi_walk_torque", &[])
}

/// An untrained policy for a spec of TOCABI's walk.
fn policy_of(spec: &str, sets: &[&str]) -> Policy {
    let spec = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("specs/{spec}.toml"));
    let sets = sets.iter().map(|set| (*set).to_owned()).collect();
    let options = LoadOptions { profile: Some("quick".into()), sets, ..LoadOptions::default() };
    let checked = checked(&spec, &options);
    let (experiment, robot) = checked.sound().expect("the spec is sound");
    let motion = shipped("walk", robot).expect("it is shipped").expect("it suits TOCABI");
    let blueprint = Blueprint::new(experiment.table.clone(), robot.clone(), Some(motion)).expect("it fits");
    let sizes = blueprint.sizes();
    let network = Network::orthogonal(
        &[sizes.observation, 8, sizes.action],
        Activation::Relu,
        &mut Stream::new("test"),
    );
    Policy::new(network, blueprint, Provenance::of_build(None)).expect("it agrees with itself")
}

struct File {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn file(bytes: &[u8]) -> File {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("policy.safetensors");
    std::fs::write(&path, bytes).expect("written");
    File { _folder: folder, path }
}

/// The bytes of a policy with another text of the same length in its header.
fn altered(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let place = bytes.windows(from.len()).position(|window| window == from.as_bytes());
    let place = place.unwrap_or_else(|| panic!("no `{from}` in the file"));
    [&bytes[..place], to.as_bytes(), &bytes[place + from.len()..]].concat()
}

#[test]
fn what_is_no_policy_is_refused_with_its_code_and_cure() {
    let bytes = policy().to_bytes();
    let mut flipped = bytes.clone();
    *flipped.last_mut().expect("it is not empty") ^= 1;
    // The header's texts stand in JSON within JSON.
    let quote = r#"\\\""#;
    let newer = altered(&bytes, &format!("{quote}version{quote}:1,"), &format!("{quote}version{quote}:7,"));
    let cases: [(&[u8], &str, &str); 5] = [
        (b"hello", "[R0002]", "not a safetensors file"),
        (&bytes[..bytes.len() / 2], "[R0002]", "not a safetensors file"),
        (&flipped, "[R0003]", "the file is damaged"),
        (&newer, "[R0002]", "layout version 7, this specforge supports version 1"),
        (
            &Network::orthogonal(&[3, 2], Activation::Relu, &mut Stream::new("test")).to_safetensors("actor"),
            "[R0002]",
            "its header lacks `contract`",
        ),
    ];
    for (bytes, code, words) in cases {
        let file = file(bytes);
        let output = evaluate(&file.path, &[]);
        let text = told(&output);
        assert_eq!(output.status.code(), Some(4), "{text}");
        assert!(text.contains(code) && text.contains(words) && text.contains("help: "), "{text}");
        let name = file.path.file_name().expect("a file").to_string_lossy().into_owned();
        assert!(text.contains(&name), "the file is named: {text}");
    }
}

#[test]
fn a_policy_of_another_robot_or_of_other_keys_is_refused() {
    let other_robot = {
        let mut policy = policy();
        policy.blueprint.robot.links[3].body.mass += 1.0;
        evaluate(&file(&policy.to_bytes()).path, &[])
    };
    assert!(
        told(&other_robot).contains("[R0002]")
            && told(&other_robot)
                .contains(": the policy's contract does not fit: it was made for robot `tocabi`")
    );
    let other_keys = {
        let mut policy = policy();
        if let Some(specforge::spec::Value::Table(action)) = policy.blueprint.fields.get_mut("action") {
            action.remove("delay");
        }
        evaluate(&file(&policy.to_bytes()).path, &[])
    };
    assert!(told(&other_keys).contains("[R0002]") && told(&other_keys).contains("`action.delay` is missing"));
    assert_eq!((other_robot.status.code(), other_keys.status.code()), (Some(4), Some(4)));
}

#[test]
fn every_option_is_checked_as_the_key_that_it_stands_for() {
    let file = file(&policy().to_bytes());
    let cases: [(&[&str], &str, &str); 16] = [
        (&["--terrain", "mud"], "E0301", "unknown terrain `mud`"),
        (&["--terrain", "slope"], "E0101", "`angle`"),
        (&["--terrain", "slope,angle=3 m"], "E0203", "--terrain"),
        (&["--terrain", "angle=3 deg"], "E0301", "does not begin with a kind"),
        (&["--terrain", "flat,height=1 cm"], "E0105", "`height`"),
        (&["--engine", "rapier,mujco"], "E0106", "did you mean `mujoco`?"),
        (&["--command", "fast"], "E0103", "--command"),
        (&["--command", "40"], "E0204", "--command"),
        (&["--command", "40 m/s"], "E0204", "--command"),
        (&["--command", "0.2 m"], "E0203", "--command"),
        (&["--episodes", "0"], "E0204", "--episodes"),
        (&["--seed", "-1"], "E0204", "--seed"),
        (&["--rate", "2000"], "E0201", "--rate"),
        (&["--push", "impulse=60 N*s"], "E0101", "`duration`"),
        (&["--push", "impulse=60 N,duration=0.1 s"], "E0203", "--push"),
        (&["--push", "hard"], "E0607", "--push"),
    ];
    for (arguments, code, words) in cases {
        let arguments: Vec<String> = match arguments {
            [option, value] => vec![format!("{option}={value}")],
            _ => unreachable!("an option and a value"),
        };
        let output = evaluate(&file.path, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let text = told(&output);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {text}");
        assert!(text.contains(&format!("error[{code}")) && text.contains(words), "{arguments:?}: {text}");
    }
    let both = evaluate(&file.path, &["--terrain", "mud", "--engine", "bullet"]);
    assert!(
        told(&both).contains("E0301") && told(&both).contains("E0106"),
        "all mistakes at once: {}",
        told(&both)
    );
}

#[test]
fn events_beyond_the_episode_are_refused_as_in_a_spec() {
    let file = file(&policy().to_bytes());
    let cases: [(&[&str], &str, &[&str]); 9] = [
        (
            &["--push", "impulse=60 N*s,duration=0.1 s,at=9 s", "--time-limit", "3 s"],
            "E0512",
            &[
                "`at` of `--push` (9 s) is not before the end of the episode (`--time-limit`, 3 s)",
                "never happens",
            ],
        ),
        (
            &["--push", "impulse=60 N*s,duration=0.1 s,at=2.95 s", "--time-limit", "3 s"],
            "E0512",
            &["part of the impulse is lost", "(`--time-limit`)"],
        ),
        (
            &["--push", "impulse=60 N*s,duration=0.1 s,every=5 s", "--time-limit", "3 s"],
            "E0512",
            &["`every` of `--push` (5 s) is longer than the episode (`--time-limit`, 3 s)"],
        ),
        // Without a time limit, the task's own duration is the bound.
        (
            &["--push", "impulse=60 N*s,duration=0.1 s,at=900 s"],
            "E0512",
            &["`at` of `--push` (900 s)", "(`task.episode`, "],
        ),
        (
            &["--terrain", "box_obstacle,height=1 cm,distance=60 m"],
            "E0512",
            &["`--terrain` is never reached"],
        ),
        (
            &["--terrain", "box_obstacle,height=1 cm,distance=60 cm", "--command", "0"],
            "E0512",
            &["`--terrain` is never reached"],
        ),
        (
            &["--terrain", "height_field,amplitude=1 cm,start=40 m", "--command", "0.1,0.3"],
            "E0512",
            &["`--terrain` is never reached"],
        ),
        (
            &["--engine", "batch", "--rate", "50 Hz"],
            "E0521",
            &["need a physics rate of 100 Hz or more", "raise `--rate` to"],
        ),
        (
            &["--time-limit", "2.004 s"],
            "E0506",
            &["`--time-limit` (2.004 s) is not a whole number", "\"2 s\" and \"2.008 s\""],
        ),
    ];
    for (arguments, code, words) in cases {
        let output = evaluate(&file.path, &[arguments, &["--episodes", "1"]].concat());
        let text = told(&output);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {text}");
        assert_eq!(text.matches("error[").count(), 1, "{arguments:?}: {text}");
        assert!(text.contains(&format!("error[{code}]")), "{arguments:?}: {text}");
        assert!(words.iter().all(|words| text.contains(words)), "{arguments:?}: {text}");
        assert!(!text.contains("evaluate."), "the option is named, not the key: {text}");
    }
}

#[test]
fn a_key_that_is_given_twice_is_refused() {
    let file = file(&policy().to_bytes());
    for (option, value, key) in [
        ("--terrain", "slope,angle=20 deg,angle=0 deg", "angle"),
        ("--terrain", "slope,kind=flat,angle=0 deg", "kind"),
        ("--push", "impulse=60 N*s,duration=0.1 s,at=1 s,at=2 s", "at"),
    ] {
        let output = evaluate(&file.path, &[option, value, "--episodes", "1", "--time-limit", "4 s"]);
        let text = told(&output);
        assert_eq!(output.status.code(), Some(3), "{value}: {text}");
        assert!(text.contains(&format!("error[E0104]: `{key}` is written twice")), "{text}");
        assert!(text.contains(&format!("--> {option}:1:")), "{text}");
    }
}

#[test]
fn an_invalid_assignment_of_an_option_is_told_how_to_write_that_option() {
    let file = file(&policy().to_bytes());
    for (option, value, advice) in [
        ("--push", "", "--push 'impulse="),
        ("--push", "hard", "--push 'impulse="),
        ("--push", "a b=1", "--push 'impulse="),
        ("--terrain", "flat,flat", "--terrain 'slope,angle="),
        ("--terrain", "slope,", "--terrain 'slope,angle="),
    ] {
        let output = evaluate(&file.path, &[&format!("{option}={value}")]);
        let text = told(&output);
        assert_eq!(output.status.code(), Some(3), "{value}: {text}");
        assert!(text.contains("error[E0607]") && text.contains(advice), "{option} {value}: {text}");
        assert!(!text.contains("--set"), "{option} {value}: {text}");
    }
}

#[test]
fn a_key_that_an_option_lacks_is_told_with_how_that_option_is_written() {
    let file = file(&policy().to_bytes());
    let output = evaluate(&file.path, &["--terrain", "slope", "--push", "impulse=60 N*s"]);
    let text = told(&output);
    assert_eq!((output.status.code(), text.matches("error[E0101]").count()), (Some(3), 2), "{text}");
    assert!(text.contains("write `--terrain kind") && text.contains("write `--push key"), "{text}");
}

#[test]
fn a_speed_for_a_policy_that_follows_none_is_refused() {
    let squat =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/policies/tocabi_squat_torque.safetensors");
    let output = evaluate(&squat, &["--speeds", "0.1,0.2"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(
        told(&output).contains("E0303]: --command asks for a speed, and this policy, which is to squat"),
        "{}",
        told(&output)
    );
}

#[test]
fn a_file_that_is_not_there_and_a_folder_are_named() {
    let missing = evaluate(Path::new("no/policy.safetensors"), &["--format", "json"]);
    let found: serde_json::Value = serde_json::from_slice(&missing.stdout).expect("a document");
    assert_eq!((missing.status.code(), &found["diagnostics"][0]["code"]), (Some(3), &"E0004".into()));
    let folder = evaluate(Path::new("robots"), &[]);
    assert_eq!(folder.status.code(), Some(3));
    assert!(told(&folder).contains("E0006") && told(&folder).contains(".safetensors"), "{}", told(&folder));
}

#[test]
fn a_spec_without_a_trained_policy_is_told_how_to_train_it() {
    let store = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("--store").arg(store.path()).arg("evaluate");
        command.args(arguments).output().expect("the program can be started")
    };
    let spec = "specs/tocabi_walk_torque.toml";
    let untrained = run(&[spec, "--profile", "quick", "--set", "learn.seed=2"]);
    assert_eq!(untrained.status.code(), Some(2));
    let advice = format!("specforge run {spec} --profile quick --set 'learn.seed=2'");
    assert!(told(&untrained).contains(&advice), "{}", told(&untrained));
    let elsewhere = told(&run(&[spec]));
    assert!(elsewhere.contains("train it first") && !elsewhere.contains("--profile"), "{elsewhere}");
    let options = LoadOptions { profile: Some("quick".into()), ..LoadOptions::default() };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(spec);
    let study = Study::read(&[path], &options, &mut Log::default()).expect("the spec is sound");
    arms::execute(&study.plan, store.path(), &arms::Fake::default(), 1).outcome.expect("the store works");
    let elsewhere = told(&run(&[spec]));
    let named = elsewhere.split("trained under: ").nth(1).map(str::trim);
    assert_eq!(named, Some("`--profile quick`"), "{elsewhere}");
    let suite = run(&["specs/studies/engines.toml", "--profile", "desk"]);
    assert_eq!(suite.status.code(), Some(2));
    assert!(told(&suite).contains("is a suite"), "{}", told(&suite));
    let policy = file(&policy().to_bytes());
    let varied = evaluate(&policy.path, &["--profile", "quick"]);
    assert_eq!(varied.status.code(), Some(2));
    assert!(told(&varied).contains("this is a policy"), "{}", told(&varied));
}

/// A machine without MuJoCo's library, or a build without the engine, checks a policy all the same and says
/// what is missing.
#[test]
fn without_the_engine_a_sound_policy_is_r0005() {
    let policy = file(&policy().to_bytes());
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.env("SPECFORGE_MUJOCO", "/nowhere/libmujoco.so.0");
    let output = command.arg("evaluate").arg(&policy.path).args(["--engine", "mujoco"]).output();
    let output = output.expect("the program can be started");
    assert_eq!(output.status.code(), Some(4));
    assert!(
        told(&output).contains("[R0005]") && told(&output).contains("specforge doctor"),
        "{}",
        told(&output)
    );
}

#[cfg(all(feature = "rapier", feature = "mujoco"))]
mod engines {
    use serde_json::Value;
    use specforge::evaluate::follower::{Follower, Lasting, Measured};
    use specforge::evaluate::{EvaluationError, Protocol, Subject, followed};
    use specforge::outcome::Evaluation;
    use specforge::report::metric::average;

    use super::*;

    /// A training of some seconds, evaluated at two commands, under noise and randomization, and in MuJoCo.
    const SMALL: &[&str] = &[
        "physics.engine=rapier",
        "pretrain.samples=2000",
        "pretrain.epochs=1",
        "learn.samples=512",
        "learn.rollout=256",
        "learn.environments=4",
        "learn.minibatch=64",
        "learn.warm_up=1",
        "fine_tune.samples=512",
        "fine_tune.warm_up=1",
        "evaluate.nominal.episodes=3",
        "evaluate.nominal.time_limit=\"1 s\"",
        "evaluate.shaken.kind=episodes",
        "evaluate.shaken.episodes=2",
        "evaluate.shaken.time_limit=\"1 s\"",
        "evaluate.shaken.seed=5",
        "evaluate.shaken.noise=true",
        "evaluate.shaken.explore=true",
        "evaluate.shaken.randomize=true",
        "evaluate.shaken.command={ speed = \"0.3 m/s\" }",
        "deploy.mujoco.episodes=3",
    ];

    /// Trains a small policy; returns what the run printed for people.
    fn trained(store: &Path) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1").arg("--store").arg(store);
        command.args(["run", "specs/tocabi_walk_torque.toml", "--profile", "desk"]);
        command.args(SMALL.iter().flat_map(|assignment| ["--set", assignment]));
        for stage in ["evaluate.nominal", "evaluate.shaken", "deploy.mujoco"] {
            command.args(["--until", &format!("tocabi_walk_torque/{stage}")]);
        }
        let output = command.output().expect("the program can be started");
        assert!(output.status.success(), "{}", told(&output));
        told(&output)
    }

    /// Interrupts the evaluation when it hears that an episode lasts.
    #[derive(Default)]
    struct Impatient {
        heard: std::sync::Mutex<Vec<String>>,
        interrupted: std::sync::atomic::AtomicBool,
    }

    impl Follower for Impatient {
        fn takes(&self, _: usize, _: &Measured, _: usize) -> bool {
            panic!("no episode ends")
        }

        fn is_interrupted(&self) -> bool {
            self.interrupted.load(std::sync::atomic::Ordering::SeqCst)
        }

        fn patience(&self) -> std::time::Duration {
            std::time::Duration::ZERO
        }

        fn lasts(&self, index: usize, course: Lasting) {
            self.heard.lock().expect("nobody panicked").push(course.sentence(index));
            self.interrupted.store(true, std::sync::atomic::Ordering::SeqCst);
        }
    }

    #[test]
    fn an_episode_without_an_end_is_told_once_and_ends_with_the_first_interruption() {
        let endless = [
            "task.episode=\"1e5 s\"",
            "terminate.ground_contact.enabled=false",
            "terminate.base_height.enabled=false",
            "terminate.base_tilt.enabled=false",
        ];
        let policy = policy_of("tocabi_walk_torque", &endless);
        let follower = Impatient::default();
        let subject = Subject {
            network: &policy.network,
            blueprint: &policy.blueprint,
            engine: specforge::sim::open("rapier").expect("it is built in"),
            contact_time: None,
        };
        let ended = followed(&subject, &Protocol::of(4), 2, &follower);
        assert!(matches!(ended, Err(EvaluationError::Interrupted)), "{ended:?}");
        let heard = follower.heard.lock().expect("nobody panicked");
        let [told] = heard.as_slice() else { panic!("{heard:?}") };
        assert!(told.contains("waiting for episode ") && told.contains("of at most 100000 s"), "{told}");
    }

    /// The files of this name in a folder of the store.
    fn files(folder: &Path, name: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).expect("the stage has run");
        entries.map(|entry| entry.expect("an entry").path().join(name)).collect()
    }

    fn evaluations(store: &Path) -> Vec<Evaluation> {
        let folders = ["evaluate", "transfer"].map(|stage| files(&store.join(stage), "evaluation.json"));
        let read = |path: &PathBuf| std::fs::read_to_string(path).expect("readable");
        folders
            .iter()
            .flatten()
            .map(|path| serde_json::from_str(&read(path)).expect("an evaluation"))
            .collect()
    }

    fn lines(output: &Output) -> Vec<Value> {
        assert_eq!(output.status.code(), Some(0), "{}", told(output));
        String::from_utf8_lossy(&output.stdout)
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect()
    }

    /// A line's numbers against those of the store, bit for bit.
    fn agrees(line: &Value, evaluation: &Evaluation) {
        assert_eq!(line["engine"].as_str(), Some(evaluation.engine.as_str()));
        assert_eq!(line["physics_rate"].as_f64(), Some(evaluation.physics_rate));
        assert_eq!(line["command"].as_f64(), evaluation.command);
        assert_eq!(line["episodes"].as_u64(), Some(evaluation.episodes.len() as u64));
        let keys = [
            ("survival", "survival"),
            ("mean_time_to_fall_s", "time_to_fall"),
            ("single_support", "single_support"),
            ("left_support", "left_support"),
            ("right_support", "right_support"),
            ("speed", "speed"),
            ("speed_error", "speed_error"),
            ("distance", "distance"),
            ("drift", "drift"),
            ("reward_per_s", "reward_per_s"),
            ("peak_foot_force", "peak_foot_force"),
            ("torque_rms", "torque_rms"),
        ];
        for (key, metric) in keys {
            assert_eq!(line[key].as_f64(), average(evaluation, metric), "{} {key}", evaluation.engine);
        }
        assert_eq!(line.as_object().expect("a table").len(), keys.len() + 4);
    }

    #[test]
    fn the_numbers_are_those_of_the_stages_in_both_engines_whatever_the_threads() {
        let store = tempfile::tempdir().expect("a folder");
        let run = trained(store.path());
        let policy = files(&store.path().join("export"), "policy.safetensors").remove(0);
        assert!(run.contains(&format!("policy of tocabi_walk_torque: {}", policy.display())), "{run}");
        // The command that the run proposes is one.
        let proposed = run.lines().find_map(|line| line.strip_prefix("try it on a slope: `specforge "));
        let proposed = proposed.and_then(|line| shlex::split(line.trim_end_matches('`'))).expect("a command");
        let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
        command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1").args(proposed);
        let output = command.args(["--episodes", "1", "--time-limit", "496 ms"]).output().expect("it starts");
        assert!(output.status.success() && !output.stdout.is_empty(), "{}", told(&output));
        let known = evaluations(store.path());
        let of = |engine: &str, command: f64| {
            known.iter().find(|one| one.engine == engine && one.command == Some(command)).expect("it was run")
        };
        let nominal =
            ["--engine", "rapier,mujoco", "--episodes", "3", "--time-limit", "1 s", "--command", "0.2"];
        let nominal = [&nominal[..], &["--format", "json", "--jobs"]].concat();
        let alone = lines(&evaluate(&policy, &[&nominal[..], &["1"]].concat()));
        assert_eq!(alone, lines(&evaluate(&policy, &[&nominal[..], &["3"]].concat())));
        assert_eq!(alone.len(), 2);
        agrees(&alone[0], of("rapier", 0.2));
        agrees(&alone[1], of("mujoco", 0.2));
        let shaken =
            ["--episodes", "2", "--time-limit", "1 s", "--seed", "5", "--noise", "--randomize", "--explore"];
        let shaken = [&shaken[..], &["--command", "0.3", "--format", "json"]].concat();
        agrees(&lines(&evaluate(&policy, &shaken))[0], of("rapier", 0.3));
        // The spec, with the options of its run, names the same policy.
        let sets: Vec<&str> = SMALL.iter().flat_map(|assignment| ["--set", assignment]).collect();
        let store = store.path().to_string_lossy().into_owned();
        let named = [&shaken[..], &["--profile", "desk", "--store", &store], &sets].concat();
        agrees(&lines(&evaluate(Path::new("specs/tocabi_walk_torque.toml"), &named))[0], of("rapier", 0.3));
        // Without its noise, its randomization or its exploration it is another evaluation.
        for at in [6, 7, 8] {
            let mut other = shaken.clone();
            other.remove(at);
            assert_ne!(
                lines(&evaluate(&policy, &other))[0]["torque_rms"].as_f64(),
                average(of("rapier", 0.3), "torque_rms")
            );
        }
    }

    #[test]
    fn another_ground_is_felt_and_the_table_has_the_rows_of_a_report() {
        let file = file(&policy().to_bytes());
        let short = ["--episodes", "2", "--time-limit", "496 ms", "--jobs", "1"];
        let on = |ground: &str| {
            lines(&evaluate(&file.path, &[&short[..], &["--format", "json", "--terrain", ground]].concat()))
        };
        let flat = on("flat");
        assert_eq!(flat, lines(&evaluate(&file.path, &[&short[..], &["--format", "json"]].concat())));
        // A rate applies to the engine of the training, too.
        let rated = |rate: &str| {
            lines(&evaluate(&file.path, &[&short[..], &["--format", "json", "--rate", rate]].concat()))
        };
        let own = policy().blueprint.physics_rate();
        assert_eq!(flat, rated(&format!("{own} Hz")));
        assert_ne!(flat, rated(&format!("{} Hz", 2.0 * own)));
        let refused = evaluate(&file.path, &[&short[..], &["--rate", "333 Hz"]].concat());
        assert!(refused.status.code() == Some(3) && told(&refused).contains("[E0501]"), "{}", told(&refused));
        let slope = on("slope,angle=5 deg");
        assert_ne!(flat[0]["distance"], slope[0]["distance"]);
        let both = evaluate(&file.path, &[&short[..], &["--speeds", "0.1,0.3"]].concat());
        let text = String::from_utf8_lossy(&both.stdout).into_owned();
        for words in [
            "2 episodes each, seed 1000, ground flat, physics 500 Hz in batch\n",
            "survival (%)",
            "batch, 0.1 m/s",
            "batch, 0.3 m/s",
            "steps of the left foot",
            "speed error (m/s)",
        ] {
            assert!(text.contains(words), "{text}");
        }
    }

    #[test]
    fn standing_still_is_no_walk_and_a_rate_that_does_not_divide_is_refused() {
        // A network of zeros holds the default pose under position control with the robot's own gains.
        let mut still = policy_of("tocabi_walk_position", &["action.stiffness=100 %"]);
        for layer in &mut still.network.layers {
            layer.weight.fill(0.0);
            layer.bias.fill(0.0);
        }
        let file = file(&still.to_bytes());
        let output = evaluate(&file.path, &["--episodes", "2", "--time-limit", "6 s", "--command", "0.2"]);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains("batch, 0.2 m/s: does not walk (not met: "), "{text}");
        // A second is less than a cycle of the walk, and a robot that falls may still be on its way.
        let brief = evaluate(&file.path, &["--episodes", "2", "--time-limit", "1 s", "--command", "0.2"]);
        let said = String::from_utf8_lossy(&brief.stdout).into_owned();
        assert!(said.contains("batch, 0.2 m/s: is not judged: its episodes end after 1 s"), "{said}");
        assert!(said.contains("1.8 s, one cycle of the reference motion"), "{said}");
        assert!(told(&brief).contains("the task is not judged: its episodes end"), "{}", told(&brief));
        assert!(!told(&brief).contains("trained speeds"), "{}", told(&brief));
        let fast = ["--episodes", "1", "--time-limit", "1 s", "--command", "2,0.2"];
        let fast = told(&evaluate(&file.path, &fast));
        assert!(fast.contains("warning: 2 m/s is outside of the trained speeds, 0 to "), "{fast}");
        let warning = "survives by standing still; that is not the task";
        assert!(told(&output).contains(warning), "{}\n{text}", told(&output));
        // A second remains after the push.
        let push = "impulse=1 N*s,duration=0.1 s,at=5 s";
        let late = ["--episodes", "2", "--time-limit", "6 s", "--command", "0.2", "--push", push];
        let late = evaluate(&file.path, &late);
        let said = String::from_utf8_lossy(&late.stdout).into_owned();
        let reason = "is not judged: its episodes end 1 s after the push at 5 s";
        assert!(said.contains(&format!("batch, 0.2 m/s: {reason}")), "{said}");
        let rate = evaluate(&file.path, &["--engine", "mujoco", "--rate", "333 Hz"]);
        assert_eq!(rate.status.code(), Some(3));
        assert!(
            told(&rate).contains("[E0501]") && told(&rate).contains("help: `--rate` can be "),
            "{}",
            told(&rate)
        );
    }
}
