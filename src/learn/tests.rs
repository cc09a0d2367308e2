//! The learner on the toy: learning, resuming, and failures.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use super::checkpoint::Checkpoint;
use super::settings::{Backend, Decay, Device, Rate};
use super::toy::{Toy, settings};
use super::*;
use crate::env::{Crew, End};
use crate::stream::Stream;

/// Interrupts or panics after this many updates.
struct Observer {
    stop_after: u64,
    die: bool,
    seen: AtomicU64,
}

impl Observer {
    fn patient() -> Self {
        Self { stop_after: u64::MAX, die: false, seen: AtomicU64::new(0) }
    }

    fn stopping_after(stop_after: u64) -> Self {
        Self { stop_after, ..Self::patient() }
    }
}

impl Watch for Observer {
    fn update(&self, _: &UpdateMetrics) {
        let seen = self.seen.fetch_add(1, Ordering::Relaxed) + 1;
        if self.die && seen == self.stop_after {
            std::panic::resume_unwind(Box::new("killed"));
        }
    }

    fn interrupted(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.stop_after
    }
}

/// A training from random networks on one thread.
fn plain<'a>(settings: &'a Settings, scratch: &'a Path, watch: &'a dyn Watch) -> Training<'a> {
    Training { settings, start: Start::default(), scratch, threads: &|| 1, watch }
}

fn run(
    settings: &Settings,
    scratch: &Path,
    threads: usize,
    watch: &dyn Watch,
) -> Result<Trained, LearnError> {
    let training = Training { threads: &|| threads, ..plain(settings, scratch, watch) };
    train(training, Toy::crews(settings.environments))
}

fn fresh_run(settings: &Settings, threads: usize) -> (Trained, Vec<serde_json::Value>) {
    let scratch = tempfile::tempdir().unwrap();
    let trained = run(settings, scratch.path(), threads, &Observer::patient()).unwrap();
    let metrics = timeless_metrics(scratch.path());
    (trained, metrics)
}

/// The lines of the metrics without what depends on the clock.
fn timeless_metrics(scratch: &Path) -> Vec<serde_json::Value> {
    let text = std::fs::read_to_string(scratch.join("metrics.jsonl")).unwrap();
    let timeless = |line: &str| {
        let mut line: BTreeMap<String, serde_json::Value> = serde_json::from_str(line).unwrap();
        line.retain(|key, _| !["wall_s", "cpu_s", "learner_cpu_s", "samples_per_s"].contains(&key.as_str()));
        serde_json::to_value(line).unwrap()
    };
    text.lines().map(timeless).collect()
}

#[test]
fn the_known_optimum_is_learned() {
    let rate = Rate::Linear([3e-3, 1e-4]);
    let settings = Settings { samples: 60_000, rollout: 500, epochs: 6, rate, std: vec![0.25], ..settings() };
    let (trained, metrics) = fresh_run(&settings, 1);
    let mut action = [0.0];
    for x in [-1.2f32, -0.6, 0.0, 0.6] {
        trained.actor.forward(&[x, 1.0], &mut action, &mut Scratch::default());
        let best = 0.5 * x - 0.3;
        assert!((action[0] - best).abs() < 0.1, "{} instead of {best} at {x}", action[0]);
    }
    // Only the policy's noise remains: 1 - 0.25^2 = 0.9375 per step.
    let last = metrics.last().unwrap();
    let reward = last["reward_mean"].as_f64().unwrap();
    assert!((0.925..0.95).contains(&reward), "{reward}");
    assert!((last["terms"]["accuracy"].as_f64().unwrap() - reward).abs() < 1e-12);
    assert!(last["ends"]["time_out"].as_u64().unwrap() > 0);
    assert_eq!(trained.summary.samples, 60_000);
}

#[test]
fn exploration_that_falls_ends_where_it_is_told() {
    let decay = |to: f64| Some(Decay { to, over: 0.5 });
    let settings = Settings { samples: 30_000, rollout: 500, epochs: 6, std: vec![0.5], ..settings() };
    let rate = Rate::Linear([3e-3, 1e-4]);
    let (_, metrics) = fresh_run(&Settings { rate, std_decay: decay(0.2), ..settings.clone() }, 1);
    let reward = |update: usize| metrics[update]["reward_mean"].as_f64().unwrap();
    // Noise costs its variance: 0.25 a step at first, 0.01 in the second half, where the policy is nearly
    // optimal.
    assert!(reward(0) < 0.75, "{}", reward(0));
    let second_half = (30..60).map(reward).sum::<f64>() / 30.0;
    assert!((0.97..0.992).contains(&second_half), "{second_half}");
    // A schedule that does not fall gives the same training as none, bit for bit.
    let short = Settings { samples: 2_000, ..settings };
    let (plain, constant) =
        (fresh_run(&short, 1), fresh_run(&Settings { std_decay: decay(1.0), ..short.clone() }, 1));
    assert_eq!(
        (&plain.0.actor, &plain.0.critic, &plain.1),
        (&constant.0.actor, &constant.0.critic, &constant.1)
    );
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let settings = settings();
    let (one, metrics) = fresh_run(&settings, 1);
    for threads in [2, 3, 8] {
        let (many, many_metrics) = fresh_run(&settings, threads);
        assert_eq!((&one.actor, &one.critic), (&many.actor, &many.critic), "{threads} threads");
        assert_eq!(metrics, many_metrics);
    }
}

#[test]
fn an_interrupted_training_goes_on_to_the_same_bits() {
    goes_on(settings());
    goes_on(Settings {
        std_decay: Some(Decay { to: 0.3, over: 0.8 }),
        limits_are_failures: true,
        ..settings()
    });
}

fn goes_on(settings: Settings) {
    let (whole, metrics) = fresh_run(&settings, 1);
    for (threads, stop_after) in [(1, 1), (2, 3), (1, 7)] {
        let scratch = tempfile::tempdir().unwrap();
        let interrupted = run(&settings, scratch.path(), threads, &Observer::stopping_after(stop_after));
        assert!(matches!(interrupted, Err(LearnError::Interrupted)));
        let checkpoint = std::fs::read(Checkpoint::path(scratch.path())).unwrap();
        let at_once = run(&settings, scratch.path(), threads, &Observer::stopping_after(0));
        assert!(matches!(at_once, Err(LearnError::Interrupted)), "before its first update");
        assert_eq!(checkpoint, std::fs::read(Checkpoint::path(scratch.path())).unwrap());
        let resumed = run(&settings, scratch.path(), 3 - threads, &Observer::patient()).unwrap();
        assert_eq!(
            (&whole.actor, &whole.critic),
            (&resumed.actor, &resumed.critic),
            "stopped after {stop_after}"
        );
        assert_eq!(metrics, timeless_metrics(scratch.path()));
    }
}

/// Interrupts at the given call, in the middle of a rollout or of the learning from it.
struct Impatient {
    asked: AtomicU64,
    stop_at: u64,
    /// Updates that have ended.
    updates: AtomicU64,
}

impl Watch for Impatient {
    fn update(&self, _: &UpdateMetrics) {
        self.updates.fetch_add(1, Ordering::Relaxed);
    }

    fn interrupted(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) + 1 >= self.stop_at
    }
}

#[test]
fn an_interruption_in_the_middle_of_an_update_goes_back_to_the_one_before_it() {
    // Rollouts so long that many episodes begin and end in one.
    let settings =
        Settings { samples: 5 * 2000, rollout: 2000, checkpoint_every: 100, warm_up: 0, ..settings() };
    for settings in [settings.clone(), Settings { norm_of_both: true, ..settings }] {
        let (whole, metrics) = fresh_run(&settings, 1);
        let mut seen = Vec::new();
        // One thread calls 1200 times in a rollout, two 2000 times, then 10 times for the values, about a
        // hundred times for each network that learns, and once at the end.
        for (threads, stop_at) in
            [(1, 900), (1, 1205), (1, 1300), (2, 2100), (1, 2300), (1, 2600), (2, 4300), (2, 5000)]
        {
            let scratch = tempfile::tempdir().unwrap();
            let watch = Impatient { asked: AtomicU64::new(0), stop_at, updates: AtomicU64::new(0) };
            let interrupted = run(&settings, scratch.path(), threads, &watch);
            assert!(matches!(interrupted, Err(LearnError::Interrupted)));
            // Every thread takes the next answer.
            assert!(watch.asked.load(Ordering::Relaxed) < stop_at + 10);
            let ended = watch.updates.load(Ordering::Relaxed);
            seen.push(ended);
            assert_eq!(Checkpoint::path(scratch.path()).is_file(), ended > 0, "asked {stop_at} times");
            assert_eq!(timeless_metrics(scratch.path()), metrics[..ended as usize], "asked {stop_at} times");
            let resumed = run(&settings, scratch.path(), 3 - threads, &Observer::patient()).unwrap();
            assert_eq!(
                (&whole.actor, &whole.critic),
                (&resumed.actor, &resumed.critic),
                "asked {stop_at} times"
            );
            assert_eq!(metrics, timeless_metrics(scratch.path()));
        }
        assert!(seen.contains(&0) && seen.contains(&1) && seen.contains(&2), "{seen:?}");
    }
}

#[test]
fn a_training_that_dies_between_checkpoints_goes_on_to_the_same_bits() {
    let settings = settings();
    let (whole, metrics) = fresh_run(&settings, 1);
    for threads in [1, 2] {
        let scratch = tempfile::tempdir().unwrap();
        let died = std::panic::catch_unwind(|| {
            let killer = Observer { die: true, ..Observer::stopping_after(5) };
            let _ = run(&settings, scratch.path(), threads, &killer);
        });
        assert!(died.is_err());
        assert_eq!(timeless_metrics(scratch.path()).len(), 5);
        let resumed = run(&settings, scratch.path(), threads, &Observer::patient()).unwrap();
        assert_eq!((&whole.actor, &whole.critic), (&resumed.actor, &resumed.critic));
        assert_eq!(metrics, timeless_metrics(scratch.path()));
    }
}

/// Slow, so that the process can be killed during the training.
struct Slow;

impl Watch for Slow {
    fn update(&self, _: &UpdateMetrics) {
        std::thread::sleep(std::time::Duration::from_millis(40));
    }

    fn interrupted(&self) -> bool {
        false
    }
}

/// Names the scratch folder of a training in a process of its own.
const SCRATCH: &str = "SPECFORGE_TEST_SCRATCH";

#[test]
fn a_training_of_its_own_process_ends_with_a_policy() {
    let own = tempfile::tempdir().unwrap();
    let scratch = std::env::var_os(SCRATCH).map_or(own.path().to_owned(), Into::into);
    let threads = if scratch.ends_with("2") { 2 } else { 1 };
    let trained = run(&settings(), &scratch, threads, &Slow).unwrap();
    assert!(trained.actor.is_finite());
}

#[test]
fn a_killed_process_is_resumed_to_the_same_bits() {
    let settings = settings();
    let (whole, metrics) = fresh_run(&settings, 1);
    for threads in ["1", "2"] {
        let folder = tempfile::tempdir().unwrap();
        let scratch = folder.path().join(threads);
        std::fs::create_dir(&scratch).unwrap();
        let mut child = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "learn::tests::a_training_of_its_own_process_ends_with_a_policy"])
            .env(SCRATCH, &scratch)
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let lines =
            || std::fs::read_to_string(scratch.join("metrics.jsonl")).map_or(0, |text| text.lines().count());
        while lines() < 3 && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!((3..8).contains(&lines()), "{} updates before the kill", lines());
        assert!(checkpoint::Checkpoint::path(&scratch).exists());
        let resumed = run(&settings, &scratch, 1, &Observer::patient()).unwrap();
        assert_eq!((&whole.actor, &whole.critic), (&resumed.actor, &resumed.critic));
        assert_eq!(metrics, timeless_metrics(&scratch));
        let events = tensorboard::tests::timeless(&scratch.join(tensorboard::NAME));
        assert_eq!(events.len(), 1 + metrics.len());
        for ((step, numbers), line) in events[1..].iter().zip(&metrics) {
            assert_eq!(
                (Some(*step), numbers["kl"]),
                (line["samples"].as_i64(), line["kl"].as_f64().unwrap() as f32)
            );
        }
    }
}

#[test]
fn a_reward_that_is_no_number_ends_the_training_with_its_episode() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let mut crew = Toy::crews(4);
    crew.insert(3, Box::new(Toy { broken_step: Some(12), ..Toy::new() }));
    let watch = Observer::patient();
    let training = Training { threads: &|| 2, ..plain(&settings, scratch.path(), &watch) };
    let error = train(training, crew).unwrap_err();
    assert_eq!(error.code(), Some("R0001"));
    let LearnError::Reward { environment: 3, step: 11, dump, .. } = error else { panic!("{error}") };
    let dump: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(dump).unwrap()).unwrap();
    assert!(dump["stream"].as_str().unwrap().starts_with("1/train/env/3/episode/"));
    assert_eq!(dump["actions"].as_array().unwrap().len(), 12);
    assert!(dump["term_values"]["accuracy"].is_string());
}

#[test]
fn an_exploded_episode_is_counted_kept_and_can_be_played_again() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let crew = || (0..5).map(|_| Box::new(Toy { limit: 1.2, ..Toy::new() }) as Box<dyn Crew>).collect();
    let watch = Observer::patient();
    let training = Training { threads: &|| 2, ..plain(&settings, scratch.path(), &watch) };
    let trained = train(training, crew()).unwrap();
    let metrics = timeless_metrics(scratch.path());
    let counted: u64 = metrics.iter().filter_map(|line| line["ends"]["exploded"].as_u64()).sum();
    assert!(counted > 10 && trained.exploded.len() == 10, "{counted} exploded, {:?}", trained.exploded);
    for path in &trained.exploded {
        let dump: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let mut toy = Toy { limit: 1.2, ..Toy::new() };
        toy.begin(0, dump["stream"].as_str().unwrap());
        let actions = dump["actions"].as_array().unwrap();
        let ends = actions.iter().map(|action| {
            toy.act(0, &[action[0].as_f64().unwrap() as f32]);
            toy.step();
            toy.outcome(0).end
        });
        let ends: Vec<_> = ends.collect();
        assert_eq!(ends.iter().position(|end| *end == Some(End::Exploded)), Some(actions.len() - 1));
    }
    let output = tempfile::tempdir().unwrap();
    trained.save(output.path()).unwrap();
    assert_eq!(dump::kept(output.path()).unwrap().len(), 10);
}

#[test]
fn a_training_in_which_every_episode_explodes_ends_and_names_one() {
    let settings = settings();
    for kept_before in [0, 10] {
        let scratch = tempfile::tempdir().unwrap();
        for number in 0..kept_before {
            std::fs::write(scratch.path().join(format!("exploded_7_{number}.json")), "{}").unwrap();
        }
        let crew = (0..5).map(|_| Box::new(Toy { limit: -9.0, ..Toy::new() }) as Box<dyn Crew>).collect();
        let watch = Observer::patient();
        let error = train(plain(&settings, scratch.path(), &watch), crew).unwrap_err();
        assert_eq!(error.code(), Some("R0001"));
        let LearnError::Exploded { update: 0, dump, .. } = error else { panic!("{error}") };
        let dump: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(dump).unwrap()).unwrap();
        assert_eq!((&dump["stream"], &dump["step"]), (&"1/train/env/0/episode/0".into(), &1.into()));
    }
}

#[test]
fn a_gradient_that_is_no_number_ends_the_training() {
    let settings = Settings { reward_scale: 1e30, value_rate: 1e30, ..settings() };
    let scratch = tempfile::tempdir().unwrap();
    let error = run(&settings, scratch.path(), 1, &Observer::patient()).unwrap_err();
    assert!(matches!(error, LearnError::Gradient { .. }), "{error}");
    assert_eq!(error.code(), Some("R0001"));
}

/// A training on libtorch, which is repeated and resumed with the same bits.
#[cfg(feature = "torch")]
fn learns_on_libtorch(settings: &Settings) {
    let trained = fresh_run(settings, 1).0;
    let scratch = tempfile::tempdir().unwrap();
    let stopped = run(settings, scratch.path(), 1, &Observer::stopping_after(3));
    assert!(matches!(stopped, Err(LearnError::Interrupted)));
    let resumed = run(settings, scratch.path(), 1, &Observer::patient()).unwrap();
    for other in [fresh_run(settings, 2).0, resumed] {
        assert_eq!(
            (&other.actor, &other.critic),
            (&trained.actor, &trained.critic),
            "one device, the same bits"
        );
    }
}

#[cfg(feature = "torch")]
#[test]
fn a_training_on_libtorch_is_made_again_and_resumed_with_the_same_bits() {
    learns_on_libtorch(&Settings { backend: Backend::Torch, ..settings() });
}

#[cfg(feature = "torch")]
#[test]
fn a_training_on_cuda_learns_or_says_what_is_missing() {
    let settings = Settings { backend: Backend::Torch, device: Device::Cuda, ..settings() };
    if tch::Cuda::is_available() {
        return learns_on_libtorch(&settings);
    }
    let scratch = tempfile::tempdir().unwrap();
    let error = run(&settings, scratch.path(), 1, &Observer::patient()).unwrap_err();
    assert_eq!(error.code(), Some("R0006"), "{error}");
    // With a libtorch for CUDA the advice is a different one.
    assert!(error.help().is_some_and(|help| help.contains("LIBTORCH") != tch::utils::has_cudart()));
}

#[cfg(not(feature = "torch"))]
#[test]
fn a_training_on_libtorch_says_how_to_build_with_it() {
    let scratch = tempfile::tempdir().unwrap();
    let settings = Settings { backend: Backend::Torch, ..settings() };
    let error = run(&settings, scratch.path(), 1, &Observer::patient()).unwrap_err();
    assert_eq!(error.code(), Some("R0005"), "{error}");
    assert!(error.help().is_some_and(|help| help.contains("torch")));
}

#[test]
fn a_checkpoint_says_the_backend_and_the_device_only_where_they_are_others() {
    let text = |backend, device| serde_json::to_string(&Settings { backend, device, ..settings() }).unwrap();
    let usual = text(Backend::Native, Device::Cpu);
    assert!(!usual.contains("device") && !usual.contains("backend"));
    let other = text(Backend::Torch, Device::Cuda);
    assert!(other.contains(r#""device":"cuda""#) && other.contains(r#""backend":"torch""#));
    let parsed: Settings = serde_json::from_str(&usual).unwrap();
    assert_eq!(parsed, settings(), "a checkpoint of a version without backends is resumed");
}

#[test]
fn a_checkpoint_of_other_settings_or_with_a_hole_is_refused() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let stop = || Observer::stopping_after(2);
    assert!(matches!(run(&settings, scratch.path(), 1, &stop()), Err(LearnError::Interrupted)));
    let other = Settings { gamma: 0.91, ..settings.clone() };
    let error = run(&other, scratch.path(), 1, &stop()).unwrap_err();
    assert_eq!(error.code(), Some("R0002"));
    let elsewhere = Settings { backend: Backend::Torch, ..settings.clone() };
    let error = run(&elsewhere, scratch.path(), 1, &stop()).unwrap_err();
    let refused = if cfg!(feature = "torch") { "R0002" } else { "R0005" };
    assert_eq!(error.code(), Some(refused));
    let path = checkpoint::Checkpoint::path(scratch.path());
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(run(&settings, scratch.path(), 1, &stop()).unwrap_err().code(), Some("R0002"));
    std::fs::write(&path, &bytes).unwrap();
    std::fs::write(scratch.path().join("metrics.jsonl"), "").unwrap();
    assert_eq!(run(&settings, scratch.path(), 1, &stop()).unwrap_err().code(), Some("R0002"));
}

/// Records which files were rebuilt.
#[derive(Default)]
struct Rebuilt(Mutex<Vec<String>>);

impl Watch for Rebuilt {
    fn update(&self, _: &UpdateMetrics) {}

    fn rebuilt(&self, file: &str) {
        self.0.lock().unwrap().push(file.to_owned());
    }

    fn interrupted(&self) -> bool {
        false
    }
}

#[test]
fn metrics_that_were_changed_beside_their_checkpoint_are_refused() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let _ = run(&settings, scratch.path(), 1, &Observer::stopping_after(4));
    assert_eq!(Checkpoint::fault(scratch.path()), None);
    let path = scratch.path().join("metrics.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.lines().count(), 4);
    let first = text.lines().next().unwrap();
    let changes = [
        text.replacen("\"episodes\":", "\"episodes\":1", 1),
        text.replacen(&format!("{first}\n"), "", 1) + first + "\n",
        text.replacen('\n', "\n\n", 1),
    ];
    for changed in changes {
        std::fs::write(&path, changed).unwrap();
        assert!(Checkpoint::fault(scratch.path()).unwrap().contains("metrics.jsonl"));
        let error = run(&settings, scratch.path(), 1, &Observer::patient()).unwrap_err();
        assert!(
            error.code() == Some("R0002") && error.to_string().contains("metrics.jsonl has changed"),
            "{error}"
        );
    }
    std::fs::write(&path, &text).unwrap();
    assert!(run(&settings, scratch.path(), 1, &Observer::patient()).is_ok());
}

#[test]
fn events_that_were_changed_beside_their_checkpoint_are_found_and_made_again_of_the_metrics() {
    let settings = settings();
    for changed in [b"".as_slice(), b"something else"] {
        let scratch = tempfile::tempdir().unwrap();
        let _ = run(&settings, scratch.path(), 1, &Observer::stopping_after(4));
        let path = scratch.path().join(tensorboard::NAME);
        std::fs::write(&path, changed).unwrap();
        assert!(Checkpoint::fault(scratch.path()).unwrap().contains(tensorboard::NAME));
        let watch = Rebuilt::default();
        run(&settings, scratch.path(), 1, &watch).unwrap();
        assert_eq!(watch.0.into_inner().unwrap(), [tensorboard::NAME]);
        assert_eq!(tensorboard::tests::timeless(&path).len(), 9);
    }
}

#[test]
fn a_training_that_dies_after_it_was_resumed_leaves_what_its_checkpoint_knows() {
    let settings = Settings { checkpoint_every: 100, ..settings() };
    let scratch = tempfile::tempdir().unwrap();
    let _ = run(&settings, scratch.path(), 1, &Observer::stopping_after(2));
    let dying = Observer { die: true, ..Observer::stopping_after(2) };
    let died = std::panic::AssertUnwindSafe(|| run(&settings, scratch.path(), 1, &dying));
    assert!(std::panic::catch_unwind(died).is_err());
    assert_eq!(Checkpoint::fault(scratch.path()), None);
    let watch = Rebuilt::default();
    run(&settings, scratch.path(), 1, &watch).unwrap();
    assert!(watch.0.into_inner().unwrap().is_empty(), "nothing had changed");
    assert_eq!(tensorboard::tests::timeless(&scratch.path().join(tensorboard::NAME)).len(), 9);
}

#[test]
fn an_exploded_episode_that_a_checkpoint_does_not_know_is_not_kept() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let _ = run(&settings, scratch.path(), 1, &Observer::stopping_after(2));
    std::fs::write(scratch.path().join("exploded_9_9.json"), "{}").unwrap();
    assert!(run(&settings, scratch.path(), 1, &Observer::patient()).unwrap().exploded.is_empty());
}

#[test]
fn a_checkpoint_that_cannot_be_written_leaves_the_previous_one() {
    let settings = settings();
    let scratch = tempfile::tempdir().unwrap();
    let _ = run(&settings, scratch.path(), 1, &Observer::stopping_after(2));
    let path = checkpoint::Checkpoint::path(scratch.path());
    let before = std::fs::read(&path).unwrap();
    // A folder in place of the draft, which can be neither created nor renamed.
    std::fs::create_dir(path.with_extension("draft")).unwrap();
    let error = run(&settings, scratch.path(), 1, &Observer::patient()).unwrap_err();
    assert!(matches!(error, LearnError::File { .. }), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
    std::fs::remove_dir(path.with_extension("draft")).unwrap();
    assert!(run(&settings, scratch.path(), 1, &Observer::patient()).is_ok());
}

#[test]
fn the_warm_up_leaves_the_actor_as_it_was() {
    let settings = Settings { samples: 600, warm_up: 2, ..settings() };
    let start = Network::orthogonal(&[2, 24, 24, 1], Activation::Relu, &mut Stream::new("test/warm_up"));
    let scratch = tempfile::tempdir().unwrap();
    let watch = Observer::patient();
    let training = Training {
        start: Start { actor: Some(&start), ..Start::default() },
        ..plain(&settings, scratch.path(), &watch)
    };
    let trained = train(training, Toy::crews(5)).unwrap();
    assert_eq!(trained.actor, start);
    let metrics = timeless_metrics(scratch.path());
    assert!(metrics.iter().all(|line| line["epochs"] == 0 && line["kl"] == 0.0));
    assert!(metrics[1]["explained_variance"].as_f64().unwrap() > -1.0);
}

#[test]
fn without_samples_nothing_is_learned_and_the_pre_trained_actor_comes_out() {
    assert_eq!([0, 1, 300, 301].map(|samples| Settings { samples, ..settings() }.updates()), [0, 1, 1, 2]);
    let settings = Settings { samples: 0, ..settings() };
    let start = Network::orthogonal(&[2, 24, 24, 1], Activation::Relu, &mut Stream::new("test/none"));
    let (scratch, output) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let watch = Observer::patient();
    let training = Training {
        start: Start { actor: Some(&start), ..Start::default() },
        ..plain(&settings, scratch.path(), &watch)
    };
    let trained = train(training, Toy::crews(5)).unwrap();
    trained.save(output.path()).unwrap();
    assert_eq!((trained.actor, trained.summary.samples, watch.seen.load(Ordering::Relaxed)), (start, 0, 0));
    assert_eq!(std::fs::read_to_string(output.path().join("metrics.jsonl")).unwrap(), "");
}

#[test]
fn a_fine_tuning_begins_with_both_networks_and_has_random_streams_of_its_own() {
    let settings = Settings { samples: 600, ..settings() };
    let (first, lines) = fresh_run(&settings, 1);
    let tuning = |samples: u64, round: Round| {
        let settings = Settings { samples, round, ..settings.clone() };
        let (scratch, watch) = (tempfile::tempdir().unwrap(), Observer::patient());
        let start = Start { actor: Some(&first.actor), critic: Some(&first.critic) };
        let training = Training { start, ..plain(&settings, scratch.path(), &watch) };
        let trained = train(training, Toy::crews(5)).unwrap();
        (trained, timeless_metrics(scratch.path()))
    };
    let (unchanged, _) = tuning(0, Round::FineTuning);
    assert_eq!((unchanged.actor, unchanged.critic), (first.actor.clone(), first.critic.clone()));
    let (tuned, after) = tuning(600, Round::FineTuning);
    assert_ne!(tuned.actor, first.actor);
    // The same episodes would have the same lengths in the first update, in which the actor does not learn.
    assert_ne!(after[0]["ends"], lines[0]["ends"]);
    let other = Network::orthogonal(&[2, 24, 1], Activation::Relu, &mut Stream::new("test/other"));
    let start = Start { actor: None, critic: Some(&other) };
    let (scratch, watch) = (tempfile::tempdir().unwrap(), Observer::patient());
    let training = Training { start, ..plain(&settings, scratch.path(), &watch) };
    let error = train(training, Toy::crews(5)).unwrap_err();
    assert!(error.to_string().contains("the critic to begin with has layers [2, 24, 1]"), "{error}");
}
