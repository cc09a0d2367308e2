//! Real trainings through the command line that are killed, run out of disk or meet a foreign checkpoint.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

mod folders;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use self::folders::copy;
use specforge::stream::Stream;

const SPEC: &str = "specs/tocabi_walk_torque.toml";

/// 32 updates of 128 samples, a checkpoint after every third, in MuJoCo, which is the faster one.
const SMALL: &[&str] = &[
    "physics.engine=\"mujoco\"",
    "deploy.mujoco.engine=\"rapier\"",
    "pretrain.samples=2000",
    "pretrain.epochs=1",
    "learn.samples=4096",
    "learn.rollout=128",
    "learn.environments=4",
    "learn.minibatch=64",
    "learn.warm_up=1",
    "learn.checkpoint_every=3",
];

/// The words of a run of one stage.
fn words(store: &Path, until: &str) -> Vec<String> {
    let mut words: Vec<String> =
        ["--store", &store.display().to_string(), "--color", "never", "run", SPEC, "--profile", "quick"]
            .map(String::from)
            .into();
    words.extend(SMALL.iter().flat_map(|assignment| ["--set".to_owned(), (*assignment).to_owned()]));
    words.extend(["--jobs", "2", "--until", &format!("tocabi_walk_torque/{until}")].map(String::from));
    words
}

fn specforge() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1");
    command
}

/// Runs to the end of a stage.
fn run(store: &Path, until: &str) -> Output {
    let output = specforge().args(words(store, until)).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// What a training comes to: its networks, and its metrics without what depends on the clock.
#[derive(PartialEq)]
struct Outcome {
    networks: [Vec<u8>; 2],
    metrics: Vec<serde_json::Value>,
}

/// A store with everything up to the training, and the result of a training that nothing happened to.
fn whole() -> &'static (tempfile::TempDir, Outcome) {
    static WHOLE: OnceLock<(tempfile::TempDir, Outcome)> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let store = tempfile::tempdir().unwrap();
        let outcome = outcome(store.path());
        assert_eq!(outcome.metrics.len(), 32);
        std::fs::remove_dir_all(store.path().join("learner")).unwrap();
        (store, outcome)
    })
}

/// A store in which everything is ready for the training.
fn store() -> tempfile::TempDir {
    let store = tempfile::tempdir().unwrap();
    copy(whole().0.path(), store.path());
    store
}

/// Begins the training.
fn begin(store: &Path) -> Child {
    specforge().args(words(store, "learner")).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Runs the training to its end.
fn outcome(store: &Path) -> Outcome {
    run(store, "learner");
    let folder = only(&store.join("learner"));
    let networks =
        ["actor.safetensors", "critic.safetensors"].map(|name| std::fs::read(folder.join(name)).unwrap());
    let timeless = |line: &str| {
        let mut line: serde_json::Map<_, _> = serde_json::from_str(line).unwrap();
        line.retain(|key, _| !["wall_s", "cpu_s", "learner_cpu_s", "samples_per_s"].contains(&key.as_str()));
        line.into()
    };
    let metrics = std::fs::read_to_string(folder.join("metrics.jsonl")).unwrap();
    Outcome { networks, metrics: metrics.lines().map(timeless).collect() }
}

/// The one entry of a folder.
fn only(folder: &Path) -> PathBuf {
    let entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(entries.len(), 1, "{entries:?}");
    entries[0].clone()
}

/// A file of the training's scratch folder, which need not be there yet.
fn scratch(store: &Path, file: &str) -> PathBuf {
    let folders = std::fs::read_dir(store.join("scratch")).into_iter().flatten().flatten();
    let checkpointed = |folder: &PathBuf| folder.join("metrics.jsonl").exists();
    let folder = folders.map(|folder| folder.path()).find(checkpointed);
    folder.unwrap_or_else(|| store.join("scratch/none")).join(file)
}

fn updates(store: &Path) -> usize {
    std::fs::read_to_string(scratch(store, "metrics.jsonl")).map_or(0, |text| text.lines().count())
}

/// Whether a training has written a checkpoint.
fn has_checkpoint(store: &Path) -> bool {
    scratch(store, "checkpoint.safetensors").exists()
}

/// Leaves the draft of a checkpoint as a kill in the middle of its writing does, unless there is one.
fn tear(store: &Path) {
    let draft = scratch(store, "checkpoint.draft");
    if !draft.exists() && has_checkpoint(store) {
        let bytes = std::fs::read(scratch(store, "checkpoint.safetensors")).unwrap();
        std::fs::write(draft, &bytes[..bytes.len() / 2]).unwrap();
    }
}

/// Waits for something of a training that runs; false when the training ended before.
fn wait_for(child: &mut Child, happened: impl Fn() -> bool) -> bool {
    let start = Instant::now();
    while !happened() {
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        assert!(start.elapsed() < Duration::from_secs(300), "nothing happened");
        // A draft is there for some milliseconds.
        std::thread::sleep(Duration::from_micros(200));
    }
    true
}

/// Kills with SIGKILL.
fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// When to kill a training.
#[derive(Debug)]
enum Moment {
    /// This time after its start: often before its first update.
    Early(Duration),
    /// This time after this many more updates.
    Later(usize, Duration),
    /// While the checkpoint's draft is there, or as if.
    Writing,
}

/// Moments of every sort, without end.
fn moments() -> impl Iterator<Item = Moment> {
    let mut stream = Stream::new("test/recovery/moments");
    (0..).map(move |index| {
        let mut within = |milliseconds: usize| Duration::from_millis(stream.below(milliseconds) as u64);
        match index % 4 {
            0 => Moment::Writing,
            1 => Moment::Early(within(400)),
            more => Moment::Later(more - 1, within(60)),
        }
    })
}

/// Waits for the moment; false when the training ended before.
fn reach(moment: &Moment, child: &mut Child, store: &Path) -> bool {
    match moment {
        Moment::Early(pause) => std::thread::sleep(*pause),
        Moment::Later(more, pause) => {
            let before = updates(store);
            wait_for(child, || updates(store) >= before + more);
            std::thread::sleep(*pause);
        }
        Moment::Writing => drop(wait_for(child, || scratch(store, "checkpoint.draft").exists())),
    }
    child.try_wait().unwrap().is_none()
}

#[test]
fn a_training_that_is_killed_at_twenty_random_moments_ends_with_the_bits_of_one_that_is_not() {
    let killed = store();
    let mut kills = 0;
    for moment in moments() {
        let mut child = begin(killed.path());
        let in_time = reach(&moment, &mut child, killed.path());
        kill(child);
        if killed.path().join("learner").exists() {
            // It was over before: the next one begins anew.
            assert!(outcome(killed.path()) == whole().1, "other bits after {kills} kills");
            std::fs::remove_dir_all(killed.path().join("learner")).unwrap();
        }
        kills += u32::from(in_time);
        if matches!(moment, Moment::Writing) {
            tear(killed.path());
        }
        if kills == 20 {
            break;
        }
    }
    assert!(outcome(killed.path()) == whole().1, "other bits after {kills} kills");
}

/// Two signals at once are one Ctrl-C: `timeout` sends one to the process and one to its group.
#[cfg(unix)]
#[test]
fn an_interruption_that_arrives_twice_still_writes_its_checkpoint() {
    use rustix::process::{Pid, Signal, kill_process};
    let store = store();
    let mut command = specforge();
    let mut child = command
        .args(words(store.path(), "learner"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert!(wait_for(&mut child, || updates(store.path()) > 0), "it was over before it was interrupted");
    for signal in [Signal::INT, Signal::INT, Signal::TERM] {
        kill_process(Pid::from_child(&child), signal).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(6), "{said}");
    assert!(said.contains("resume from the checkpoints") && has_checkpoint(store.path()), "{said}");
    assert!(outcome(store.path()) == whole().1, "other bits");
}

/// A terminal that closes, a batch system's warning, a limit of CPU time: each writes a checkpoint however
/// often it comes, and a SIGTERM after it is the first of its kind.
#[cfg(unix)]
#[test]
fn signals_of_terminals_and_batch_systems_write_a_checkpoint_that_the_next_run_goes_on_from() {
    use rustix::process::{Pid, Signal, kill_process};
    let store = store();
    for signals in [
        vec![Signal::HUP, Signal::HUP, Signal::TERM],
        vec![Signal::QUIT],
        vec![Signal::XCPU, Signal::XCPU],
        vec![Signal::USR1],
    ] {
        let before = updates(store.path());
        let mut command = specforge();
        let mut child = command
            .args(words(store.path(), "learner"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        assert!(wait_for(&mut child, || updates(store.path()) > before), "it was over before {signals:?}");
        for signal in &signals {
            kill_process(Pid::from_child(&child), *signal).unwrap();
            std::thread::sleep(Duration::from_millis(2));
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(6), "{signals:?}: {said}");
        assert!(
            said.contains("resume from the checkpoints") && has_checkpoint(store.path()),
            "{signals:?}: {said}"
        );
    }
    assert!(outcome(store.path()) == whole().1, "other bits");
}

/// `nohup` has SIGHUP ignored, and it stays so.
#[cfg(unix)]
#[test]
fn a_training_under_nohup_outlives_its_terminal() {
    use rustix::process::{Pid, Signal, kill_process};
    let store = store();
    let mut command = Command::new("sh");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("OMP_NUM_THREADS", "1");
    command.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_specforge")]);
    let mut child = command
        .args(words(store.path(), "learner"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    assert!(wait_for(&mut child, || updates(store.path()) > 0));
    kill_process(Pid::from_child(&child), Signal::HUP).unwrap();
    assert!(child.wait().unwrap().success());
    assert!(outcome(store.path()) == whole().1, "other bits");
}

#[test]
fn a_disk_that_is_full_keeps_the_previous_checkpoint_and_the_run_goes_on_when_there_is_room() {
    let store = store();
    let mut child = begin(store.path());
    assert!(wait_for(&mut child, || has_checkpoint(store.path())));
    kill(child);
    let path = scratch(store.path(), "checkpoint.safetensors");
    let before = std::fs::read(&path).unwrap();
    // Files of a megabyte at most: the metrics fit, the checkpoint of two megabytes does not.
    let command = "trap '' XFSZ; ulimit -f 2048; exec \"$0\" \"$@\"";
    let mut full = Command::new("sh");
    full.current_dir(env!("CARGO_MANIFEST_DIR")).args(["-c", command, env!("CARGO_BIN_EXE_specforge")]);
    let output = full.args(words(store.path(), "learner")).env("OMP_NUM_THREADS", "1").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{said}");
    let reason = "the limit on the size of a file is reached: cannot write";
    let error = format!("error[R0004]: tocabi_walk_torque/learner: {reason} {}", path.display());
    assert!(said.contains(&error) && said.contains("help: raise the limit (`ulimit -f`)"), "{said}");
    assert!(std::fs::read(&path).unwrap() == before, "the previous checkpoint is as it was");
    assert!(!scratch(store.path(), "checkpoint.draft").exists(), "a draft takes room");
    let verified = specforge().arg("--store").arg(store.path()).args(["cache", "verify"]).output().unwrap();
    assert!(verified.status.success(), "{}", String::from_utf8_lossy(&verified.stderr));
    assert!(outcome(store.path()) == whole().1, "other bits");
}

#[test]
fn a_checkpoint_of_another_version_is_refused_and_the_message_says_what_to_do() {
    let store = store();
    let mut child = begin(store.path());
    assert!(wait_for(&mut child, || has_checkpoint(store.path())));
    kill(child);
    let path = scratch(store.path(), "checkpoint.safetensors");
    let mut bytes = std::fs::read(&path).unwrap();
    // Texts within texts: between the word and the number stand back slashes and quotation marks.
    let place =
        bytes.windows(7).position(|window| window == b"version").expect("the header says its version");
    let digit = place + bytes[place..].iter().position(u8::is_ascii_digit).expect("a number");
    assert_eq!([bytes[digit], bytes[digit + 1]], *b"3,");
    bytes[digit] = b'7';
    std::fs::write(&path, &bytes).unwrap();
    let output = specforge().args(words(store.path(), "learner")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{said}");
    let reason = "it was written by another version of specforge (its format is 7, this version reads 3)";
    assert!(
        said.contains("error[R0002]: tocabi_walk_torque/learner: the checkpoint ") && said.contains(reason),
        "{said}"
    );
    assert!(said.contains(&format!("help: delete {} to train from the beginning", path.display())), "{said}");
    assert_eq!(std::fs::read(&path).unwrap(), bytes, "it is left for the version that wrote it");
    std::fs::remove_file(&path).unwrap();
    assert!(outcome(store.path()) == whole().1, "the advice works");
}
