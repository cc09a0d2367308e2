//! The store and the scheduler: nothing is done twice, nothing is lost, nothing damaged is believed.

mod arms;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use arms::{Fake, Ran, arm, execute, execute_with, options, plan};
use specforge::exec::lock::{self, Wait};
use specforge::exec::{Event, Interrupt, Store};
use specforge::plan::{Plan, Selection, StageKind};

/// What the works wrote, by path in the store.
fn content(root: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { walk(&path, found) } else { found.push(path) }
        }
    }
    let mut paths = Vec::new();
    walk(root, &mut paths);
    paths.sort();
    let artefact = |path: &PathBuf| path.ends_with("made.json");
    let relative = |path: &PathBuf| path.strip_prefix(root).expect("below the root").to_owned();
    paths
        .iter()
        .filter(|path| artefact(path))
        .map(|path| (relative(path), fs::read(path).expect("a file")))
        .collect()
}

fn two_arms() -> Plan {
    plan(&[arm("torque", "torque"), arm("position", "position")])
}

fn counts(ran: &Ran) -> (usize, usize, usize, usize) {
    let outcome = ran.outcome.as_ref().expect("the store works");
    (outcome.worked.len(), outcome.cached.len(), outcome.failures.len(), outcome.skipped.len())
}

#[test]
fn a_second_run_does_no_work() {
    let (store, fake, plan) = (tempfile::tempdir().expect("a folder"), Fake::default(), two_arms());
    assert_eq!(counts(&execute(&plan, store.path(), &fake, 2)), (17, 0, 0, 0));
    assert_eq!(counts(&execute(&plan, store.path(), &fake, 2)), (0, 17, 0, 0));
    assert_eq!(fake.runs.load(Ordering::SeqCst), 17);
    let left: Vec<_> = fs::read_dir(store.path().join("tmp")).expect("a folder").collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn artefacts_do_not_depend_on_the_number_of_jobs() {
    let (one, four, plan) =
        (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"), two_arms());
    execute(&plan, one.path(), &Fake::default(), 1).outcome.expect("the store works");
    execute(&plan, four.path(), &Fake::default(), 4).outcome.expect("the store works");
    let (one, four) = (content(one.path()), content(four.path()));
    assert_eq!(one.len(), 17);
    assert_eq!(one, four);
}

#[test]
fn a_changed_byte_is_found_and_the_artefact_is_made_anew() {
    let (store, fake, plan) = (tempfile::tempdir().expect("a folder"), Fake::default(), two_arms());
    execute(&plan, store.path(), &fake, 2).outcome.expect("the store works");
    let learner = plan.find("torque/learner")[0];
    let file = store.path().join("learner").join(learner.fingerprint.as_str()).join("made.json");
    let mut bytes = fs::read(&file).expect("a file");
    bytes[5] ^= 1;
    fs::write(&file, &bytes).expect("it can be written");
    let ran = execute(&plan, store.path(), &fake, 2);
    assert_eq!(counts(&ran), (1, 16, 0, 0));
    let warned = ran.record.events().into_iter().find_map(|event| match event {
        Event::Warning { stage, code, message, .. } => Some((stage, code, message)),
        _ => None,
    });
    let (stage, code, message) = warned.expect("a warning");
    assert_eq!(code.as_deref(), Some("R0003"));
    assert_eq!(stage.as_deref(), Some("torque/learner"));
    assert!(message.contains("do not match their digest"), "{message}");
    assert!(store.path().join("damaged").is_dir());
    assert_eq!(counts(&execute(&plan, store.path(), &fake, 2)), (0, 17, 0, 0));
}

#[test]
fn a_damaged_manifest_and_a_missing_file_are_found_too() {
    let (store, fake, plan) = (tempfile::tempdir().expect("a folder"), Fake::default(), two_arms());
    execute(&plan, store.path(), &fake, 2).outcome.expect("the store works");
    let folder =
        |kind: &str, word: &str| store.path().join(kind).join(plan.find(word)[0].fingerprint.as_str());
    let manifest = folder("robot", "robot").join("manifest.json");
    let text = fs::read_to_string(&manifest).expect("a file");
    fs::write(&manifest, text.replace("\"cores\": ", "\"cores\": 1")).expect("it can be written");
    fs::remove_file(folder("env", "torque/env").join("made.json")).expect("it is there");
    assert_eq!(counts(&execute(&plan, store.path(), &fake, 2)), (2, 15, 0, 0));
}

#[test]
fn of_two_runs_at_once_one_works_and_the_other_waits() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), two_arms());
    let fake = Fake { takes: Duration::from_millis(20), ..Fake::default() };
    let both: Vec<_> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..2).map(|_| scope.spawn(|| execute(&plan, store.path(), &fake, 2))).collect();
        runs.into_iter().map(|run| counts(&run.join().expect("no panic"))).collect()
    });
    assert_eq!(fake.runs.load(Ordering::SeqCst), 17, "{both:?}");
    assert_eq!(both[0].0 + both[1].0, 17, "{both:?}");
    assert_eq!(both[0].1 + both[1].1, 17, "{both:?}");
}

#[test]
fn a_failed_arm_leaves_the_other_arm_and_a_report_that_says_so() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), two_arms());
    let fake = Fake { fails: vec!["position/learner".into()], ..Fake::default() };
    let ran = execute(&plan, store.path(), &fake, 2);
    // The learner fails; evaluation, export and transfer of that arm cannot start.
    assert_eq!(counts(&ran), (13, 0, 1, 3));
    let outcome = ran.outcome.expect("the store works");
    assert_eq!(outcome.failures[0].code.as_deref(), Some("R0001"));
    assert_eq!(outcome.failures[0].stage, "position/learner");
    let report = fs::read_to_string(outcome.report.expect("a report").join("made.json")).expect("a file");
    assert!(
        report.contains("\"position/learner\"") && !report.contains("position/evaluate.nominal"),
        "{report}"
    );
    // The report of a failed run is not the report of the plan.
    let whole = execute(&plan, store.path(), &Fake::default(), 2);
    assert_eq!(counts(&whole), (5, 12, 0, 0));
}

#[test]
fn fail_fast_starts_nothing_after_a_failure() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), two_arms());
    let fake = Fake { fails: vec!["torque/motion".into()], ..Fake::default() };
    let options = specforge::exec::Options { keep_going: false, ..options(&plan, 1) };
    let ran = execute_with(&plan, store.path(), &fake, &options, &Interrupt::default());
    assert_eq!(ran.outcome.expect("the store works").worked.len(), 1);
    assert_eq!(fake.runs.load(Ordering::SeqCst), 2);
}

#[test]
fn an_interrupted_learner_keeps_its_checkpoint_and_goes_on_from_it() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let takes = Duration::from_millis(40);
    let fake = Fake { interruptible: true, takes, ..Fake::default() };
    let interrupt = Interrupt::default();
    let learner = &plan.find("learner")[0].fingerprint;
    let scratch = store.path().join("scratch").join(learner.as_str());
    let ran = std::thread::scope(|scope| {
        let run = scope.spawn(|| execute_with(&plan, store.path(), &fake, &options(&plan, 2), &interrupt));
        wait_for(&scratch.join("checkpoint"), || {
            assert!(!run.is_finished(), "the run ended before it was stopped")
        });
        interrupt.set();
        run.join().expect("no panic")
    });
    let outcome = ran.outcome.expect("the store works");
    assert!(outcome.interrupted && outcome.failures.is_empty() && outcome.report.is_none());
    assert!(scratch.join("checkpoint").exists());
    let again = execute(&plan, store.path(), &fake, 2).outcome.expect("the store works");
    assert!(again.report.is_some() && !again.interrupted);
    assert!(!scratch.exists(), "a finished stage leaves no checkpoint");
    let manifest = Store::at(store.path()).manifest(StageKind::Learner, learner).expect("it can be read");
    let wall = manifest.expect("it is there").provenance.wall_s;
    assert!(wall >= 2.0 * takes.as_secs_f64(), "both attempts count: {wall} s");
}

#[test]
fn what_a_killed_run_left_behind_is_swept() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let left = store.path().join("tmp").join(format!("{}.99999", plan.find("learner")[0].fingerprint));
    fs::create_dir_all(&left).expect("it can be created");
    execute(&plan, store.path(), &Fake::default(), 1).outcome.expect("the store works");
    assert!(!left.exists());
}

#[test]
fn a_stage_whose_input_was_not_selected_says_so() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let selection = Selection { only: vec!["learner".into()], ..Selection::default() };
    let options =
        specforge::exec::Options { selected: selection.apply(&plan).expect("a stage"), ..options(&plan, 1) };
    let ran = execute_with(&plan, store.path(), &Fake::default(), &options, &Interrupt::default());
    let outcome = ran.outcome.expect("the store works");
    assert_eq!(outcome.failures.len(), 1);
    assert!(outcome.failures[0].message.contains("is not in the store and was not selected"));
}

#[test]
fn a_store_that_cannot_be_written_is_r0004() {
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let file = folder.path().join("file");
    fs::write(&file, "not a folder").expect("it can be written");
    let error =
        execute(&plan, &file.join("store"), &Fake::default(), 1).outcome.expect_err("no store can be there");
    assert_eq!(error.code(), Some("R0004"), "{error}");
    assert!(error.help().expect("advice").contains("--store"));
}

#[test]
fn a_panicking_work_is_a_failed_stage() {
    struct Bug;
    impl specforge::exec::Work for Bug {
        fn run(&self, _: &specforge::exec::Job) -> Result<(), specforge::exec::WorkError> {
            panic!("index out of bounds")
        }
    }
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let mut works = arms::works(&Fake::default());
    works.insert(specforge::plan::StageKind::Learner, Box::new(Bug));
    let (store, record) =
        (specforge::exec::Store::at(folder.path()), specforge::exec::events::Record::default());
    let interrupt = Interrupt::default();
    let workshop = specforge::exec::Workshop {
        plan: &plan,
        store: &store,
        works: &works,
        events: &record,
        interrupt: &interrupt,
    };
    let outcome = specforge::exec::run(&workshop, &options(&plan, 2)).expect("the store works");
    assert!(outcome.failures[0].message.contains("index out of bounds"));
}

#[test]
fn tensorboard_finds_a_training_by_arm_and_seed_while_it_runs_and_afterwards() {
    use specforge::exec::{Job, Work, WorkError, Workshop, events::Record, gc};
    const EVENTS: &str = specforge::learn::tensorboard::NAME;
    struct Training(PathBuf);
    impl Work for Training {
        fn run(&self, job: &Job) -> Result<(), WorkError> {
            fs::write(job.scratch.join(EVENTS), "half").expect("it can be written");
            assert_eq!(fs::read_to_string(self.0.join(EVENTS)).expect("found by name"), "half");
            job.write_text(EVENTS, "whole")
        }
    }
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let named = folder.path().join("tensorboard/torque/seed_1/learner");
    let mut works = arms::works(&Fake::default());
    works.insert(StageKind::Learner, Box::new(Training(named.clone())));
    let (store, record, interrupt) = (Store::at(folder.path()), Record::default(), Interrupt::default());
    let workshop =
        Workshop { plan: &plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
    let outcome = specforge::exec::run(&workshop, &options(&plan, 2)).expect("the store works");
    assert!(outcome.failures.is_empty(), "{:?}", outcome.failures);
    drop(outcome);
    assert_eq!(fs::read_to_string(named.join(EVENTS)).expect("found by name"), "whole");
    // Without the training there is nothing to name.
    fs::remove_dir_all(folder.path().join("learner")).expect("it is there");
    let waste = gc::waste(&store, &rules(Duration::MAX), &Wait::default()).expect("the journal can be read");
    gc::remove(&store, &waste, &Wait::default()).expect("it can be removed");
    assert!(named.symlink_metadata().is_err() && !folder.path().join("tensorboard").exists());
}

#[test]
fn a_published_report_is_a_copy_that_is_left_alone_when_nothing_changed() {
    let (store, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let outcome = execute(&plan, store.path(), &Fake::default(), 2).outcome.expect("the store works");
    let (artefact, reports) = (outcome.report.expect("a report"), store.path().join("reports"));
    let made = specforge::report::publish::publish(&artefact, &reports, "made").expect("it can be written");
    assert_eq!(made.page, reports.join("made.md"));
    assert_eq!(
        fs::read(reports.join("made.json")).expect("a copy"),
        fs::read(artefact.join("made.json")).expect("it")
    );
    assert!(!reports.join("manifest.json").exists());
    let before = fs::metadata(reports.join("made.json")).and_then(|file| file.modified()).expect("a time");
    specforge::report::publish::publish(&artefact, &reports, "made").expect("nothing to do");
    assert_eq!(
        fs::metadata(reports.join("made.json")).and_then(|file| file.modified()).expect("a time"),
        before
    );
}

/// Everything of this age.
fn rules(age: Duration) -> specforge::exec::gc::Rules {
    specforge::exec::gc::Rules { age, ..Default::default() }
}

/// What can go, whatever its age.
fn waste(store: &Store) -> Vec<specforge::exec::gc::Waste> {
    specforge::exec::gc::waste(store, &rules(Duration::ZERO), &Wait::default())
        .expect("the journal can be read")
        .waste
}

#[test]
fn cleaning_removes_what_no_named_stage_uses_and_keeps_the_rest() {
    use specforge::exec::{Store, gc};
    let folder = tempfile::tempdir().expect("a folder");
    let mut other = arm("torque", "torque");
    arms::set(&mut other, "reward.contact_force.weight", arms::quantity(0.2, "0.2"), "--set");
    for arm in [arm("torque", "torque"), other.clone()] {
        execute(&plan(&[arm]), folder.path(), &Fake::default(), 2).outcome.expect("the store works");
    }
    let store = Store::at(folder.path());
    let waste = |age| gc::waste(&store, &rules(age), &Wait::default()).expect("the journal can be read");
    for age in [Duration::from_secs(3600), Duration::MAX] {
        assert!(waste(age).waste.is_empty(), "young artefacts stay");
    }
    let waste = waste(Duration::ZERO);
    let kinds: Vec<&str> =
        waste.waste.iter().map(|entry| entry.what.split(' ').next().expect("a word")).collect();
    assert_eq!(kinds, ["env", "learner", "evaluate", "export", "transfer", "report"]);
    gc::remove(&store, &waste, &Wait::default()).expect("they can be removed");
    drop(waste);
    assert_eq!(counts(&execute(&plan(&[other]), folder.path(), &Fake::default(), 2)), (0, 10, 0, 0));
}

#[test]
fn suites_with_arms_of_the_same_names_and_profiles_keep_what_is_theirs() {
    use specforge::exec::journal::Past;
    use specforge::plan::{Plan, State, SuiteRecord, why};
    let folder = tempfile::tempdir().expect("a folder");
    let within = |suite: &str, profile: Option<&str>, weight: f64| -> Plan {
        let mut one = arm("seed=1", "torque");
        one.request.profile = profile.map(str::to_owned);
        arms::set(
            &mut one,
            "reward.contact_force.weight",
            arms::quantity(weight, &weight.to_string()),
            "--set",
        );
        let (axes, seeds, claims) = (Vec::new(), Vec::new(), Vec::new());
        let suite = SuiteRecord { name: suite.into(), axes, arms: 1, seeds, claims, claims_count: false };
        let mut plan = plan(&[one]);
        plan.suite = Some(suite);
        plan
    };
    let all = [("running", None, 0.1), ("walking", None, 0.2), ("walking", Some("desk"), 0.3)];
    for (suite, profile, weight) in all {
        execute(&within(suite, profile, weight), folder.path(), &Fake::default(), 2)
            .outcome
            .expect("the store works");
    }
    let store = Store::at(folder.path());
    assert!(waste(&store).is_empty());
    // A stage that changed is compared with the one of its own suite, although another has its name since
    // then.
    let edited = within("running", None, 0.15);
    let learner = edited.find("learner")[0];
    let status = why::status(&edited, learner, &Past::of(&store, &edited));
    let change = &status.changes[0];
    assert_eq!((change.from.as_deref(), change.to.as_deref()), (Some("0.1"), Some("0.15")));
    let stranger = within("squatting", None, 0.4);
    let status = why::status(&stranger, stranger.find("learner")[0], &Past::of(&store, &stranger));
    assert_eq!(status.state, State::Missing);
    execute(&edited, folder.path(), &Fake::default(), 2).outcome.expect("the store works");
    assert!(!waste(&store).is_empty(), "the edited one");
}

#[test]
fn a_journal_torn_in_mid_character_keeps_everything_and_takes_lines() {
    use specforge::exec::gc;
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    execute(&plan, folder.path(), &Fake::default(), 2).outcome.expect("the store works");
    let journal = folder.path().join("journal.jsonl");
    let mut bytes = fs::read(&journal).expect("a journal");
    bytes.extend(b"{\"run\":\"caf\xc3");
    fs::write(&journal, bytes).expect("it can be written");
    let store = Store::at(folder.path());
    let error = gc::waste(&store, &rules(Duration::ZERO), &Wait::default()).expect_err("a line is lost");
    assert!(error.to_string().contains("its last line is cut off"), "{error}");
    let mut other = arm("torque", "torque");
    arms::set(&mut other, "reward.contact_force.weight", arms::quantity(0.2, "0.2"), "--set");
    execute(&self::plan(&[other]), folder.path(), &Fake::default(), 2).outcome.expect("the store works");
    let text = fs::read_to_string(&journal).expect("a journal");
    let broken = text.lines().filter(|line| serde_json::from_str::<serde_json::Value>(line).is_err()).count();
    assert_eq!(broken, 0, "the next line took the place of the torn one: {text}");
    assert_eq!(waste(&store).len(), 6);
}

#[test]
fn a_journal_that_cannot_be_read_keeps_everything() {
    use specforge::exec::gc;
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    execute(&plan, folder.path(), &Fake::default(), 2).outcome.expect("the store works");
    spoil_journal(folder.path());
    let error = gc::waste(&Store::at(folder.path()), &rules(Duration::ZERO), &Wait::default())
        .expect_err("a folder cannot be read");
    assert!(error.to_string().starts_with("the store cannot be read"), "{error}");
}

/// Puts a folder in the journal's place, which can neither be read nor written.
fn spoil_journal(store: &Path) {
    let journal = store.join("journal.jsonl");
    let _ = fs::remove_file(&journal);
    fs::create_dir(journal).expect("it can be created");
}

#[test]
fn a_checkpoint_that_is_cleaned_away_is_locked_until_it_is_gone() {
    use specforge::exec::{StoreError, gc};
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), plan(&[arm("torque", "torque")]));
    let (store, learner) = (Store::at(folder.path()), &plan.find("learner")[0].fingerprint);
    store.prepare().expect("it can be written");
    let scratch = store.scratch(learner).expect("it can be written");
    let rules = gc::Rules { scratch: true, ..rules(Duration::ZERO) };
    let waste = gc::waste(&store, &rules, &Wait::default()).expect("the journal can be read");
    assert_eq!(waste.waste.iter().map(|entry| &entry.path).collect::<Vec<_>>(), [&scratch]);
    let impatient = Interrupt::default();
    impatient.set();
    let wait = Wait { interrupt: Some(&impatient), ..Wait::default() };
    let locked = || matches!(store.lock(learner, &wait), Err(StoreError::Interrupted));
    assert!(locked(), "a run could take it up");
    gc::remove(&store, &waste, &Wait::default()).expect("it can be removed");
    assert!(locked() && !scratch.exists());
    drop(waste);
    assert!(!locked());
}

#[test]
fn a_journal_that_cannot_be_written_stops_the_trainings_that_run() {
    /// One arm's learner spoils the journal, the other's waits to be interrupted.
    struct Spoiler(PathBuf);
    impl specforge::exec::Work for Spoiler {
        fn run(&self, job: &specforge::exec::Job) -> Result<(), specforge::exec::WorkError> {
            if job.stage.users[0].arm == "torque" {
                std::thread::sleep(Duration::from_millis(200));
                spoil_journal(&self.0);
                return Ok(());
            }
            let start = Instant::now();
            while !job.interrupt.is_set() && start.elapsed() < Duration::from_secs(60) {
                std::thread::sleep(Duration::from_millis(5));
            }
            Err(specforge::exec::WorkError::Interrupted)
        }
    }
    let (folder, plan) = (tempfile::tempdir().expect("a folder"), two_arms());
    let mut works = arms::works(&Fake::default());
    works.insert(StageKind::Learner, Box::new(Spoiler(folder.path().to_owned())));
    let (store, record) = (Store::at(folder.path()), specforge::exec::events::Record::default());
    let interrupt = Interrupt::default();
    let workshop = specforge::exec::Workshop {
        plan: &plan,
        store: &store,
        works: &works,
        events: &record,
        interrupt: &interrupt,
    };
    let start = Instant::now();
    specforge::exec::run(&workshop, &options(&plan, 2)).expect_err("the journal cannot be written");
    assert!(start.elapsed() < Duration::from_secs(30), "it waited for the training");
}

/// The variable that makes a test binary a run of its own: the store's folder and what it does.
const CHILD: &str = "SPECFORGE_TEST_CHILD";

/// Not a test by itself: the process that the tests below start.
#[test]
fn child() {
    let Ok(order) = std::env::var(CHILD) else { return };
    let (role, store) = order.split_once(':').expect("a role and a folder");
    let plan = plan(&[arm("torque", "torque")]);
    match role {
        "slow" => {
            let fake = Fake { takes: Duration::from_millis(30), ..Fake::default() };
            execute(&plan, Path::new(store), &fake, 2).outcome.expect("the store works");
            println!("runs={}", fake.runs.load(Ordering::SeqCst));
        }
        "waiting" => {
            let interrupt = Interrupt::listen(|| {}).expect("signals can be heard");
            interrupt.work();
            let (store, works) = (Store::at(store), arms::works(&Fake::default()));
            let events = specforge::exec::progress::Lines::new(std::io::stdout());
            let workshop = specforge::exec::Workshop {
                plan: &plan,
                store: &store,
                works: &works,
                events: &events,
                interrupt: &interrupt,
            };
            let outcome = specforge::exec::run(&workshop, &options(&plan, 2)).expect("the store works");
            std::process::exit(if outcome.interrupted { 6 } else { 0 });
        }
        _ => {
            let interrupt = Interrupt::listen(|| {}).expect("signals can be heard");
            interrupt.work();
            let fake = Fake { interruptible: true, ..Fake::default() };
            // The deaf one never looks at the interrupt that it has heard.
            let seen = if role == "deaf" { Interrupt::default() } else { interrupt };
            let ran = execute_with(&plan, Path::new(store), &fake, &options(&plan, 2), &seen);
            std::process::exit(if ran.outcome.expect("the store works").interrupted { 6 } else { 0 });
        }
    }
}

fn spawn(role: &str, store: &Path) -> std::process::Child {
    std::process::Command::new(std::env::current_exe().expect("this binary"))
        .args(["--exact", "child", "--nocapture"])
        .env(CHILD, format!("{role}:{}", store.display()))
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("it can be started")
}

/// Waits until a file is there; `alive` looks at whoever writes it.
fn wait_for(file: &Path, mut alive: impl FnMut()) {
    let start = Instant::now();
    while !file.exists() {
        alive();
        assert!(start.elapsed() < Duration::from_secs(60), "{} was not written", file.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn wait_for_checkpoint(store: &Path, child: &mut std::process::Child) {
    let plan = plan(&[arm("torque", "torque")]);
    let scratch = store.join("scratch").join(plan.find("learner")[0].fingerprint.as_str());
    let alive = || {
        assert!(child.try_wait().expect("it can be asked").is_none(), "the run ended before it was stopped")
    };
    wait_for(&scratch.join("checkpoint"), alive);
}

/// The exit code of a child that is about to end.
fn ended(child: &mut std::process::Child) -> Option<i32> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("it can be asked") {
            return status.code();
        }
        assert!(start.elapsed() < Duration::from_secs(60), "it does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn interrupt(child: &std::process::Child) {
    let pid = rustix::process::Pid::from_child(child);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("it runs");
}

#[test]
fn two_processes_share_the_work() {
    let store = tempfile::tempdir().expect("a folder");
    let children: Vec<_> = (0..2).map(|_| spawn("slow", store.path())).collect();
    let runs = children.into_iter().map(|child| {
        let output = child.wait_with_output().expect("it ends");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let count =
            text.split("runs=").nth(1).and_then(|rest| rest.lines().next()).expect("a count").to_owned();
        count.parse::<usize>().expect("a number")
    });
    assert_eq!(runs.sum::<usize>(), 10);
}

#[test]
fn the_first_interrupt_ends_with_a_checkpoint_and_exit_code_6() {
    let store = tempfile::tempdir().expect("a folder");
    let mut child = spawn("polite", store.path());
    wait_for_checkpoint(store.path(), &mut child);
    interrupt(&child);
    assert_eq!(ended(&mut child), Some(6));
    let again = execute(&plan(&[arm("torque", "torque")]), store.path(), &Fake::default(), 2);
    assert!(again.outcome.expect("the store works").report.is_some());
}

#[test]
fn the_second_interrupt_ends_a_deaf_run_at_once_and_leaves_the_store_usable() {
    let store = tempfile::tempdir().expect("a folder");
    let mut child = spawn("deaf", store.path());
    wait_for_checkpoint(store.path(), &mut child);
    // With its echo.
    interrupt(&child);
    interrupt(&child);
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().expect("it can be asked").is_none(), "one interrupt does not end it");
    interrupt(&child);
    assert_eq!(ended(&mut child), Some(6));
    let again = execute(&plan(&[arm("torque", "torque")]), store.path(), &Fake::default(), 2);
    assert!(again.outcome.expect("the store works").report.is_some());
}

#[test]
fn a_killed_run_frees_its_locks_and_the_next_goes_on_from_its_checkpoint() {
    let store = tempfile::tempdir().expect("a folder");
    let mut child = spawn("polite", store.path());
    wait_for_checkpoint(store.path(), &mut child);
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    let fake = Fake { interruptible: true, ..Fake::default() };
    let again =
        execute(&plan(&[arm("torque", "torque")]), store.path(), &fake, 2).outcome.expect("the store works");
    assert!(again.report.is_some(), "the learner found the checkpoint and finished");
}

#[test]
fn a_wait_for_another_process_names_it_and_ends_with_the_first_interrupt() {
    use std::io::BufRead;
    let learner = plan(&[arm("torque", "torque")]).find("learner")[0].fingerprint.to_string();
    for (name, words) in [
        ("store", "has locked the store"),
        ("journal", "has locked the store"),
        (learner.as_str(), "learner: process"),
    ] {
        let store = tempfile::tempdir().expect("a folder");
        fs::create_dir(store.path().join("locks")).expect("a folder");
        let held =
            lock::attempt(&store.path().join("locks").join(name)).expect("writable").expect("it is free");
        let mut child = spawn("waiting", store.path());
        let lines = std::io::BufReader::new(child.stdout.take().expect("it is piped")).lines();
        let told = lines.map(|line| line.expect("text")).find(|line| line.contains("waiting for"));
        let told = told.expect("the wait is told before the run ends");
        let own = format!("process {}", std::process::id());
        assert!(told.contains(&own) && told.contains(words), "{told}");
        interrupt(&child);
        assert_eq!(ended(&mut child), Some(6), "{name}");
        drop(held);
        let again = execute(&plan(&[arm("torque", "torque")]), store.path(), &Fake::default(), 2);
        assert!(again.outcome.expect("the store works").report.is_some());
    }
}
