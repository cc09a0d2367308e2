//! Libraries that end the process in the middle of a stage: the stage is named, the exit code is that of a
//! failed stage, and what else runs keeps its work. Each crash is real and happens in a process of its own.

#![cfg(feature = "mujoco")]

mod arms;

use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::Duration;

use arms::{Fake, arm, execute, options, plan};
use specforge::exec::events::{Event, JsonLines};
use specforge::exec::journal::Journal;
use specforge::exec::line_file::Health;
use specforge::exec::progress::Lines;
use specforge::exec::{self, Events, Interrupt, Job, Store, Work, WorkError, Works, Workshop, last_words};
use specforge::plan::{Plan, StageKind};

/// The variable that makes this binary a run of its own: what goes wrong, how it is told, and the store's
/// folder.
const CHILD: &str = "SPECFORGE_TEST_CRASH";

fn two() -> Plan {
    plan(&[arm("torque", "torque"), arm("position", "position")])
}

/// A work whose learner under torque ends the process once the other one has begun.
struct Crashing {
    fault: String,
    fake: Fake,
}

impl Work for Crashing {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        if job.stage.kind != StageKind::Learner || job.stage.users[0].arm != "torque" {
            return self.fake.run(job);
        }
        let scratch = job.scratch.parent().expect("the folder of all scratch folders");
        let begun = || {
            scratch
                .read_dir()
                .expect("a folder")
                .flatten()
                .any(|entry| entry.path().join("checkpoint").exists())
        };
        while !begun() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let part = specforge::crash::part();
        // As in a rollout: on a thread that the stage has started.
        std::thread::scope(|scope| {
            scope.spawn(move || {
                part.join();
                end(&self.fault);
            });
        });
        Ok(())
    }
}

/// Ends the process.
fn end(fault: &str) {
    match fault {
        "mujoco" => overflow_the_stack_of_mujoco(),
        "memory" => drop(std::hint::black_box(Vec::<u8>::with_capacity(1 << 46))),
        "abort" => std::process::abort(),
        "stack" => println!("{}", deep(std::hint::black_box(1))),
        "panic" => panic!("failed to spawn thread: Resource temporarily unavailable"),
        // SAFETY: raises a signal, as an access to memory that is not there does.
        _ => drop(unsafe { libc::raise(libc::SIGSEGV) }),
    }
}

#[allow(unconditional_recursion, reason = "the stack is to overflow")]
fn deep(depth: u64) -> u64 {
    let page = std::hint::black_box([depth; 512]);
    deep(depth.wrapping_add(page[7])).wrapping_add(page[9])
}

/// Asks a world for more memory than its arena has: MuJoCo calls `mju_error`.
fn overflow_the_stack_of_mujoco() {
    use mujoco_rs::prelude::{MjData, MjModel};
    let _engine = specforge::sim::open("mujoco").expect("it is linked");
    let model = MjModel::from_xml_string("<mujoco><worldbody/></mujoco>").expect("it compiles");
    let mut data = MjData::try_new(Box::new(model)).expect("it has data");
    // SAFETY: the data is whole, and the call does not return.
    unsafe {
        mujoco_rs::mujoco_c::mj_markStack(data.ffi_mut());
        mujoco_rs::mujoco_c::mj_stackAllocByte(data.ffi_mut(), 1 << 40, 8);
    }
}

/// Not a test by itself: the process that the tests below start.
#[test]
fn child() {
    let Ok(order) = std::env::var(CHILD) else { return };
    // Whatever goes wrong, nobody waits for it.
    std::thread::spawn(|| {
        std::thread::sleep(Duration::from_secs(45));
        std::process::exit(99);
    });
    let mut words = order.splitn(3, ':');
    let mut word = || words.next().expect("three words").to_owned();
    let (fault, form, store) = (word(), word(), Store::at(word()));
    let events: Arc<dyn Events> = match form.as_str() {
        "json" => Arc::new(JsonLines::new(std::io::stderr())),
        _ => Arc::new(Lines::new(std::io::stderr())),
    };
    let interrupt = Interrupt::default();
    last_words::listen(Some(store.root().to_owned()), events.clone(), &interrupt).expect("it can listen");
    let plan = two();
    let fake = Fake { interruptible: true, ..Fake::default() };
    let works: Works = StageKind::ALL
        .into_iter()
        .map(|kind| (kind, Box::new(Crashing { fault: fault.clone(), fake: fake.clone() }) as Box<dyn Work>))
        .collect();
    let workshop = Workshop {
        plan: &plan,
        store: &store,
        works: &works,
        events: events.as_ref(),
        interrupt: &interrupt,
    };
    let outcome = exec::run(&workshop, &options(&plan, 4)).expect("the store works");
    std::process::exit(if outcome.failures.is_empty() { 0 } else { 77 });
}

fn crash(fault: &str, form: &str, store: &Path) -> Output {
    let mut command = Command::new(std::env::current_exe().expect("this binary"));
    command
        .args(["--exact", "child", "--nocapture"])
        .env(CHILD, format!("{fault}:{form}:{}", store.display()));
    command.env("RUST_BACKTRACE", "0").output().expect("it starts")
}

/// The scratch folder of a learner.
fn scratch(store: &Path, arm: &str) -> std::path::PathBuf {
    store.join("scratch").join(arms::key(&two(), arm, "learner"))
}

/// The journal says what ended the learner's process, is whole, and stays so when a run adds to it.
#[track_caller]
fn assert_noted(store: &Path, words: &str) {
    let (plan, key) = (two(), arms::key(&two(), "torque", "learner"));
    let learner = plan.stages().find(|stage| stage.fingerprint.as_str() == key).expect("it learns");
    let read = || Journal::open(&Store::at(store)).expect("it can be read");
    let journal = read();
    let crashes: Vec<_> = journal.crashes(&learner.fingerprint).collect();
    let [crash] = crashes.as_slice() else { panic!("{crashes:?}") };
    assert!(
        crash.crash == "torque/learner" && crash.code == "R0010" && crash.message.contains(words),
        "{crash:?}"
    );
    assert_eq!(*journal.health(), Health::Whole);
    execute(&plan, store, &Fake::default(), 2).outcome.expect("the store works");
    assert_eq!((read().crashes(&learner.fingerprint).count(), read().health().clone()), (1, Health::Whole));
}

#[test]
fn an_error_of_mujoco_is_a_failed_stage_and_the_other_stages_write_their_checkpoints() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = crash("mujoco", "lines", folder.path());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(told.contains("error[R0010]: torque/learner: MuJoCo stopped with an error: "), "{told}");
    assert!(
        told.contains("stack overflow") && told.contains("help: finished stages are in the store"),
        "{told}"
    );
    assert!(scratch(folder.path(), "position").join("checkpoint").exists());
    assert!(folder.path().join("env").read_dir().expect("finished stages stay").count() > 0);
    let kept =
        std::fs::read_to_string(scratch(folder.path(), "torque").join("failure.json")).expect("the failure");
    assert!(kept.contains("R0010") && kept.contains("MuJoCo stopped"), "{kept}");
    // The next run says so, once, and goes on.
    for expected in [1, 0] {
        let fake = Fake { interruptible: true, ..Fake::default() };
        std::fs::write(scratch(folder.path(), "torque").join("checkpoint"), "half").ok();
        let ran = execute(&two(), folder.path(), &fake, 4);
        assert!(ran.outcome.expect("the store works").failures.is_empty());
        let of_last = |event: &Event| {
            matches!(event,
            Event::Warning { code: Some(code), message,
                .. } if code == "R0010" && message.contains("its last attempt failed: MuJoCo"))
        };
        assert_eq!(ran.record.events().iter().filter(|event| of_last(event)).count(), expected);
    }
    assert_noted(folder.path(), "MuJoCo stopped with an error");
}

#[test]
fn a_program_that_reads_events_hears_of_the_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = crash("mujoco", "json", folder.path());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let events = || told.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let last = events().next_back().expect("an event");
    assert_eq!((&last["event"], &last["outcome"]), (&"run_finished".into(), &"crashed".into()), "{told}");
    let failed = events().filter(|event| event["event"] == "stage_failed").collect::<Vec<_>>();
    assert_eq!(failed.len(), 1, "{told}");
    assert_eq!(
        (&failed[0]["code"], &failed[0]["stage"]),
        (&"R0010".into(), &"torque/learner".into()),
        "{told}"
    );
}

#[test]
fn whatever_else_ends_the_process_names_the_stage_and_keeps_what_is_finished() {
    let faults = [
        ("memory", "it was aborted (SIGABRT): memory ran out"),
        ("abort", "it was aborted (SIGABRT)"),
        ("stack", "stack overflow (SIGSEGV)"),
        ("segmentation", "invalid memory access"),
    ];
    for (fault, message) in faults {
        let folder = tempfile::tempdir().expect("a folder");
        let output = crash(fault, "lines", folder.path());
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(4), "{fault}: {told}");
        let expected = "error[R0010]: torque/learner: the process crashed: ";
        assert!(told.contains(expected) && told.contains(message), "{fault}: {told}");
        assert!(folder.path().join("env").read_dir().expect("finished stages stay").count() > 0, "{fault}");
        assert!(scratch(folder.path(), "position").join("checkpoint").exists(), "{fault}");
        assert_noted(folder.path(), message);
    }
}

#[test]
fn a_panic_for_want_of_threads_is_no_bug_and_stops_no_other_stage() {
    let folder = tempfile::tempdir().expect("a folder");
    struct Wanting;
    impl Work for Wanting {
        fn run(&self, job: &Job) -> Result<(), WorkError> {
            match job.stage.kind {
                StageKind::Learner => panic!("failed to spawn thread: Resource temporarily unavailable"),
                _ => Fake::default().run(job),
            }
        }
    }
    let (store, plan, record) = (Store::at(folder.path()), two(), specforge::exec::events::Record::default());
    let works: Works =
        StageKind::ALL.into_iter().map(|kind| (kind, Box::new(Wanting) as Box<dyn Work>)).collect();
    let interrupt = Interrupt::default();
    let workshop =
        Workshop { plan: &plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
    let outcome = exec::run(&workshop, &options(&plan, 2)).expect("the store works");
    let codes: Vec<_> = outcome.failures.iter().map(|failure| failure.code.as_deref()).collect();
    assert_eq!(codes, [Some("R0010"), Some("R0010")], "{:?}", outcome.failures);
}
