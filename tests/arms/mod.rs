//! Hand-built arms and works for the tests of the graph and its execution.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use serde_json::json;
use specforge::exec::events::Record;
use specforge::exec::{
    Interrupt, Job, Options, Outcome, Store, StoreError, Work, WorkError, Works, Workshop, run,
};
use specforge::plan::{Arm, Plan, ReportSource, Request, StageKind, lower};
use specforge::robot;
use specforge::spec::{Quantity, Table, Value};

/// A number with its author's text.
pub fn quantity(si: f64, text: &str) -> Value {
    Value::Quantity(Quantity { si, text: text.into() })
}

/// A word.
pub fn word(text: &str) -> Value {
    Value::Text(text.into())
}

/// A table from pairs.
pub fn table<const N: usize>(pairs: [(&str, Value); N]) -> Value {
    Value::Table(pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

/// An arm with every section.
pub fn arm(name: &str, control: &str) -> Arm {
    let fields: Table = [
        ("name", word(name)),
        ("summary", word("A robot runs")),
        ("robot", table([("model", word("atlas"))])),
        ("physics", table([("engine", word("rapier")), ("rate", quantity(500.0, "500 Hz"))])),
        ("terrain", table([("kind", word("flat"))])),
        (
            "task",
            table([("kind", word("run")), ("motion", word("run_gait")), ("episode", quantity(16.0, "16 s"))]),
        ),
        ("initial", table([("kind", word("default_pose"))])),
        ("action", table([("kind", word(control)), ("delay", quantity(0.004, "4 ms"))])),
        ("observe", table([("phase", table([("kind", word("phase"))]))])),
        (
            "reward",
            table([(
                "contact_force",
                table([("kind", word("contact_force")), ("weight", quantity(0.1, "0.1"))]),
            )]),
        ),
        ("terminate", table([])),
        ("pretrain", table([("kind", word("tracking")), ("samples", Value::Count(200_000))])),
        (
            "learn",
            table([
                ("kind", word("ppo")),
                ("samples", Value::Count(2_000_000)),
                ("seed", Value::Count(1)),
                ("policy", table([("hidden", Value::List(vec![Value::Count(256)]))])),
            ]),
        ),
        (
            "evaluate",
            table([("nominal", table([("kind", word("episodes")), ("episodes", Value::Count(32))]))]),
        ),
        (
            "deploy",
            table([
                ("policy", table([("kind", word("export"))])),
                ("mujoco", table([("kind", word("transfer")), ("engine", word("mujoco"))])),
            ]),
        ),
        ("report", table([("template", word("report.md.j2"))])),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect();
    let origins = BTreeMap::from([(
        "reward.contact_force.weight".to_owned(),
        "specs/base/task/run.toml:40".to_owned(),
    )]);
    let robot =
        serde_json::to_value(robot::shipped("atlas").expect("it is shipped")).expect("a robot is plain data");
    let motion = Some(Table::from([("period".to_owned(), quantity(0.66, "0.66 s"))]));
    let (robot, motion) = (robot.into(), motion.map(Into::into));
    Arm {
        name: name.into(),
        fields,
        origins,
        robot,
        motion,
        request: Request::default(),
        allow: BTreeMap::new(),
        runs: None,
    }
}

/// Sets the value at a dotted path.
pub fn set(arm: &mut Arm, path: &str, value: Value, origin: &str) {
    fn put(table: &mut Table, path: &str, value: Value) {
        match path.split_once('.') {
            None => drop(table.insert(path.into(), value)),
            Some((head, rest)) => match table.get_mut(head) {
                Some(Value::Table(inner)) => put(inner, rest, value),
                _ => panic!("no table at `{head}`"),
            },
        }
    }
    put(&mut arm.fields, path, value);
    arm.origins.insert(path.into(), origin.into());
}

/// The plan of these arms with a report.
pub fn plan(arms: &[Arm]) -> Plan {
    let (name, baselines) = (arms[0].name.clone(), Vec::new());
    let source = ReportSource { name, templates: "t1".into(), suite: None, baselines };
    lower(arms, Some(&source)).expect("the arms are whole")
}

/// The key of a stage of an arm.
pub fn key(plan: &Plan, arm: &str, stage: &str) -> String {
    let record = plan.arms.iter().find(|record| record.name == arm).expect("the arm is in the plan");
    record.stages[stage].to_string()
}

/// What a fake work does.
#[derive(Clone)]
pub struct Fake {
    /// How often it ran.
    pub runs: Arc<AtomicUsize>,
    /// How long it takes.
    pub takes: Duration,
    /// The stages (`ARM/STAGE`) that fail.
    pub fails: Vec<String>,
    /// Whether it waits for an interruption after writing a checkpoint.
    pub interruptible: bool,
}

impl Default for Fake {
    fn default() -> Self {
        Self { runs: Arc::default(), takes: Duration::ZERO, fails: Vec::new(), interruptible: false }
    }
}

impl Work for Fake {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        self.runs.fetch_add(1, Ordering::SeqCst);
        std::thread::sleep(self.takes);
        let user = &job.stage.users[0];
        if self.fails.contains(&format!("{}/{}", user.arm, user.stage)) {
            return Err(WorkError::coded("R0001", "the state became NaN", "lower the learning rate"));
        }
        let checkpoint = job.scratch.join("checkpoint");
        if self.interruptible && job.stage.kind == StageKind::Learner && !checkpoint.exists() {
            std::fs::write(&checkpoint, "half").map_err(|error| WorkError::io(&checkpoint, error))?;
            while !job.interrupt.is_set() {
                std::thread::sleep(Duration::from_millis(5));
            }
            return Err(WorkError::Interrupted);
        }
        let failures: Vec<&str> = job.failures.iter().map(|failure| failure.stage.as_str()).collect();
        job.write("made.json", &json!({"roles": job.inputs.keys().collect::<Vec<_>>(), "failures": failures}))
    }
}

/// One fake work for every kind.
pub fn works(fake: &Fake) -> Works {
    StageKind::ALL.into_iter().map(|kind| (kind, Box::new(fake.clone()) as Box<dyn Work>)).collect()
}

/// A run and what was told of it.
pub struct Ran {
    /// How it ended.
    pub outcome: Result<Outcome, StoreError>,
    /// What was told.
    pub record: Record,
}

/// Options for a run over everything.
pub fn options(plan: &Plan, jobs: usize) -> Options {
    let selected = plan.stages().map(|stage| stage.fingerprint.clone()).collect();
    Options { jobs, keep_going: true, selected, reasons: BTreeMap::new(), single: None }
}

/// Runs a plan with a fake work.
pub fn execute(plan: &Plan, store: &Path, fake: &Fake, jobs: usize) -> Ran {
    execute_with(plan, store, fake, &options(plan, jobs), &Interrupt::default())
}

/// Runs a plan with a fake work, options and an interrupt.
pub fn execute_with(plan: &Plan, store: &Path, fake: &Fake, options: &Options, interrupt: &Interrupt) -> Ran {
    let (store, record, works) = (Store::at(store), Record::default(), works(fake));
    let workshop = Workshop { plan, store: &store, works: &works, events: &record, interrupt };
    let outcome = run(&workshop, options);
    Ran { outcome, record }
}
