//! A suite from its plan to its report with made-up works: execution, going on, figures, tables, trace.

mod arms;
#[path = "report/made_up_claims.rs"]
mod made_up_claims;
#[path = "report/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::{Path, PathBuf};

use specforge::exec::events::Record;
use specforge::exec::{self, Interrupt, Job, Outcome, Store, Work, WorkError, Works, Workshop};
use specforge::plan::{AxisRecord, Plan, ReportSource, ReportedSuite, Runs, StageKind, SuiteRecord, lower};
use specforge::report::claim::{Evidence, Ruling};
use specforge::report::publish::publish;
use specforge::report::sidecar::{RULES, Sidecar};
use specforge::report::{ReportWork, Templates};
use specforge::spec::claim::Claim;
use specforge::spec::{Table, Value};

const CONTROLS: [&str; 2] = ["torque", "position"];
const STDS: [(&str, f64); 2] = [("10 %", 0.1), ("5 %", 0.05)];

/// What the suite is expected to show.
const CLAIMS: &str = r#"
[[claim]]
id     = "survives_sometimes"
text   = "The torque policy survives a fifth of its episodes"
metric = "evaluate.nominal.survival"
arm    = "control=torque,std=10 %"
expect = "a > 20 %"
alpha  = 0.5
paper  = { where = "Exp. 1", value = "it always survives" }

[[claim]]
id     = "survives_often"
text   = "The torque policy survives nine of ten episodes"
metric = "evaluate.nominal.survival"
arm    = "control=torque,std=10 %"
expect = "a > 90 %"
alpha  = 0.5

[[claim]]
id      = "torque_survives_more"
text    = "The torque policy survives more than the position policy"
metric  = "evaluate.nominal.survival"
compare = { a = "control=torque", b = "control=position" }
over    = "each"
expect  = "a > b"
"#;

fn claims() -> Vec<Claim> {
    made_up_claims::decoded(CLAIMS)
}

/// The plan of two controls, two standard deviations and three seeds.
fn plan() -> Plan {
    plan_of(&STDS)
}

/// The plan with these standard deviations; a claim that fails counts.
fn plan_of(stds: &[(&str, f64)]) -> Plan {
    let mut arms = Vec::new();
    for control in CONTROLS {
        for &(text, std) in stds {
            let mut arm = arms::arm(&format!("control={control},std={text}"), control);
            arms::set(&mut arm, "action.std", arms::quantity(std, text), "suite.toml:9");
            let points =
                vec![("control".to_owned(), control.to_owned()), ("std".to_owned(), text.to_owned())];
            arm.runs =
                Some(Runs { points, seeds: vec![1, 2, 3], origin: Some("sweep.seeds, suite.toml:5".into()) });
            arms.push(arm);
        }
    }
    let axis = |name: &str, points: &[&str]| AxisRecord {
        name: name.to_owned(),
        points: points.iter().map(|point| (*point).to_owned()).collect(),
    };
    let axes = vec![
        axis("control", &CONTROLS),
        axis("std", &stds.iter().map(|(text, _)| *text).collect::<Vec<_>>()),
    ];
    let (name, seeds) = ("exploration".into(), vec![1, 2, 3]);
    // As the program makes them: the record and the fields hold the same claims.
    let claim = claims().into_iter().map(|claim| Value::Table(claim.fields)).collect();
    let record = SuiteRecord { name, axes, arms: arms.len(), seeds, claims: claims(), claims_count: true };
    let report = Table::from([("template".to_owned(), arms::word("report.md.j2"))]);
    let fields = Table::from([
        ("name".to_owned(), arms::word("exploration")),
        ("summary".to_owned(), arms::word("Which exploration learns")),
        ("claim".to_owned(), Value::List(claim)),
        ("report".to_owned(), Value::Table(report)),
    ]);
    let suite = Some(ReportedSuite { record, fields });
    let baselines = Vec::new();
    let source = ReportSource { name: "exploration".into(), templates: "t1".into(), suite, baselines };
    lower(&arms, Some(&source)).expect("whole arms")
}

/// Works that make up what the stages would have measured: a seed's survival and return are its own, and the
/// second seed of one arm fails to learn.
struct MadeUp;

impl Work for MadeUp {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let user = &job.stage.users[0];
        let arm = &synthetic::input().arms[usize::from(user.arm.starts_with("control=position"))];
        let seed: usize =
            user.arm.rsplit('=').next().and_then(|seed| seed.parse().ok()).expect("a run ends in its seed");
        match job.stage.kind {
            // As the real work does: what is written must be the model of the recipe.
            StageKind::Robot => job.write("robot.json", &*job.stage.recipe.content),
            StageKind::Motion => job.write("motion.json", &arm.motion),
            StageKind::Pretrain => job.write("pretrain.json", &arm.pretrain),
            StageKind::Learner if user.arm == "control=position,std=5 %,seed=2" => {
                Err(WorkError::coded("R0001", "the state became NaN", "lower the learning rate"))
            }
            StageKind::Learner => {
                let mut updates = arm.updates.clone();
                let factor = 1.0 + 0.1 * seed as f64;
                updates
                    .iter_mut()
                    .for_each(|update| update.return_mean = update.return_mean.map(|mean| factor * mean));
                let lines =
                    updates.iter().map(|update| serde_json::to_string(update).expect("numbers") + "\n");
                job.write_text("metrics.jsonl", &lines.collect::<String>())
            }
            StageKind::Evaluate | StageKind::Transfer => {
                let mut evaluation = arm.evaluations[0].evaluation.clone();
                // Seed 1 loses 8 of 32 episodes, seed 2 16, seed 3 24.
                let count = evaluation.episodes.len();
                let lost = evaluation.episodes.iter_mut().take(count * seed / 4);
                lost.for_each(|episode| episode.survived = false);
                evaluation
                    .episodes
                    .iter_mut()
                    .skip(count * seed / 4)
                    .for_each(|episode| episode.survived = true);
                job.write("evaluation.json", &evaluation)
            }
            _ => job.write("made.json", &user.stage),
        }
    }
}

fn execute(plan: &Plan, folder: &Path) -> Outcome {
    let mut works: Works =
        StageKind::ALL.into_iter().map(|kind| (kind, Box::new(MadeUp) as Box<dyn Work>)).collect();
    let report = ReportWork::new(Templates::default(), |_| Some("tau = a".to_string()));
    works.insert(StageKind::Report, Box::new(report));
    let (store, record, interrupt) =
        (Store::at(folder.join("store")), Record::default(), Interrupt::default());
    let workshop = Workshop { plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
    exec::run(&workshop, &arms::options(plan, 4)).expect("the store works")
}

/// Runs the suite and publishes its report.
fn published(folder: &Path) -> PathBuf {
    let outcome = execute(&plan(), folder);
    let Some(artefact) = outcome.report else {
        panic!("a failed run leaves a report: {:?}", outcome.failures)
    };
    publish(&artefact, &folder.join("reports"), "exploration").expect("the report can be copied").page
}

#[test]
fn a_run_that_fails_keeps_none_of_the_others_from_ending_and_the_next_run_does_only_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = plan();
    let first = execute(&plan, folder.path());
    assert_eq!(first.failures.len(), 1);
    assert_eq!(plan.find("learner").len(), 12);
    let second = execute(&plan, folder.path());
    let mut again: Vec<&str> =
        second.worked.iter().map(|key| plan.stage(key).expect("planned").name()).collect();
    again.sort_unstable();
    assert!(again.iter().all(|name| *name == "report"), "{again:?}");
    assert_eq!(second.failures.len(), 1, "what failed is tried again");
}

#[test]
fn the_report_gathers_seeds_into_arms_with_intervals_and_says_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(published(folder.path())).expect("the report is there");
    assert!(
        text.contains(
            "4 arms over control (torque, position) and std (10 %, 5 %), 12 runs with the seeds 1, 2, 3."
        ),
        "{text}"
    );
    assert!(text.contains("11 of 12 runs in 4 arms have all their results."), "{text}");
    assert!(
        text.contains(
            "position, std 5 %, seed 2: stage `learner` has no result: [R0001] the state became NaN."
        ),
        "{text}"
    );
    // The mean of 75, 50 and 25 % over three seeds.
    let row = text.lines().find(|line| line.starts_with("| torque, std 10 % | 3 | 50 ["));
    assert!(row.is_some(), "{text}");
    let row = text.lines().find(|line| line.starts_with("| position, std 5 % | 2 | 50 ["));
    assert!(row.is_some(), "the seed that failed is not counted: {text}");
    let few = "the range of 3 seeds, which covers about 75 to 80 %, not 95 %";
    assert!(text.contains(&format!("3 seeds per arm: a bootstrap interval over them is {few}")), "{text}");
    assert!(text.contains(&format!("square brackets hold bootstrap intervals over seeds, {few}.")), "{text}");
    assert!(text.contains(&format!("Bands: bootstrap intervals over seeds, {few}; thin lines")), "{text}");
}

#[test]
fn curves_and_grid_are_drawn_and_trace_back_to_every_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = published(folder.path());
    let grid =
        fs::read_to_string(folder.path().join("reports/exploration/survival_grid.svg")).expect("two axes");
    assert!(grid.contains(">50 %<") && grid.contains(">25 to 75, n = 3<"), "{grid}");
    let curves = folder.path().join("reports/exploration/learning_curves.svg");
    assert!(curves.is_file());
    let sidecar = fs::read_to_string(report.with_extension("json")).expect("the sidecar is there");
    let sidecar: Sidecar = serde_json::from_str(&sidecar).expect("the sidecar can be read");
    let item = sidecar.items.iter().find(|item| item.id == "learning_curves").expect("the figure is traced");
    assert_eq!(item.sources.len(), 11);
    let last = sidecar.arms.last().expect("twelve runs");
    assert!(
        last.fields.len() < 10,
        "only what differs from the first run is written: {:?}",
        last.fields.keys()
    );
    assert_eq!(sidecar.fields(last).get(&"action.std".to_owned()).expect("a value").value, "5 %");
    assert_eq!(sidecar.fields(last).get(&"learn.samples".to_owned()).expect("a value").value, "2.0 M");
    let traced = |place: &str| {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        let output = command.current_dir(folder.path()).args(["trace", place]).assert().success();
        String::from_utf8_lossy(&output.get_output().stdout).into_owned()
    };
    let text = traced("reports/exploration/learning_curves.svg");
    assert_eq!(traced("exploration/learning_curves.svg"), text, "as the page prints the command");
    assert!(
        text.contains("control=position,std=10 %,seed=3 learner") && text.contains("learn.seed = 3"),
        "{text}"
    );
}

#[test]
fn a_claim_and_an_arms_number_trace_back_to_the_runs_that_they_were_computed_from() {
    let folder = tempfile::tempdir().expect("a folder");
    published(folder.path());
    let traced = |place: &str, format: &str| {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        let place = format!("reports/exploration.md#{place}");
        let output =
            command.current_dir(folder.path()).args(["--format", format, "trace", &place]).assert().success();
        String::from_utf8_lossy(&output.get_output().stdout).into_owned()
    };
    let claim = traced("claims.torque_survives_more/std=5 %", "json");
    let claim: serde_json::Value = serde_json::from_str(&claim).expect("JSON");
    let runs: Vec<&str> =
        claim["runs"].as_array().expect("runs").iter().filter_map(|run| run["arm"].as_str()).collect();
    assert_eq!(runs.len(), 5, "three torque policies and two position policies: {runs:?}");
    assert!(runs.iter().all(|run| run.contains("std=5 %")), "{runs:?}");
    assert!(claim["cells"].as_array().is_some_and(|cells| !cells.is_empty()), "{claim}");
    let whole: serde_json::Value =
        serde_json::from_str(&traced("claims.torque_survives_more", "json")).expect("JSON");
    let of_all = whole["runs"].as_array().map_or(0, Vec::len);
    assert!(of_all > runs.len(), "a claim over several arms is that of all its comparisons: {of_all}");
    let text = traced("claims.survives_often", "human");
    assert!(text.contains("control=torque,std=10 %,seed=3 evaluate.nominal"), "{text}");
    assert!(!text.contains("control=position"), "{text}");
    let number = traced("evaluate_nominal.control=position,std=10 %", "human");
    assert!(number.contains("seed=2 evaluate.nominal") && !number.contains("control=torque"), "{number}");
}

#[test]
fn stages_are_found_by_arm_by_run_and_by_id() {
    let plan = plan();
    assert_eq!(plan.find("control=torque,std=10 %/learner").len(), 3);
    assert_eq!(plan.find("control=torque,std=10 %,seed=2/learner").len(), 1);
    let id = plan.arms[1].run.as_ref().expect("a run").id.clone();
    assert_eq!(plan.find(&format!("{id}/learner"))[0].users[0].arm, "control=torque,std=10 %,seed=2");
}

#[test]
fn the_template_of_suites_passes_the_check_before_any_run() {
    let sources = &mut specforge::diag::Sources::default();
    assert_eq!(specforge::report::check("report.md.j2", &Templates::default(), sources), vec![]);
}

#[test]
fn claims_are_judged_on_the_runs_and_what_is_missing_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = published(folder.path());
    let sidecar = fs::read_to_string(report.with_extension("json")).expect("the sidecar is there");
    let sidecar: Sidecar = serde_json::from_str(&sidecar).expect("the sidecar can be read");
    let verdicts: Vec<Ruling> = sidecar.claims.iter().map(|claim| claim.verdict).collect();
    assert_eq!(verdicts, [Ruling::Pass, Ruling::Fail, Ruling::NotEstablished]);
    let each = &sidecar.claims[2];
    assert_eq!(
        each.cases.iter().map(|case| case.label.as_str()).collect::<Vec<_>>(),
        ["std=10 %", "std=5 %"]
    );
    assert_eq!(each.cases[1].n, [3, 2]);
    assert_eq!(each.missing, ["`control=position,std=5 %` with seed 2 has no result of `evaluate.nominal`"]);
    let text = fs::read_to_string(report).expect("the report is there");
    // 75, 50 and 25 % of the episodes.
    assert!(text.contains("* **PASS**: The torque policy survives a fifth of its episodes."), "{text}");
    assert!(text.contains("measured 50 % [38, 62] (n = 3 runs, welch)."), "{text}");
    let tail = "Its p, corrected over the claims by Holm's method, is 0.346. The paper (Exp. 1): it always \
        survives.";
    assert!(text.contains(tail), "{text}");
    assert!(text.contains("The p values are corrected for 3 claims by Holm's method."), "{text}");
    assert!(text.contains("| 50 % | 3 runs |") && text.contains("| 95 % | 3 and 2 runs |"), "{text}");
    assert!(text.contains("with seed 2 has no result of `evaluate.nominal`"), "{text}");
    assert!(text.contains("| `survives_often` | FAIL | evaluate.nominal.survival:"), "{text}");
}

#[test]
fn the_record_holds_the_value_of_every_metric_in_every_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = published(folder.path());
    let sidecar = Sidecar::read(&report.with_extension("json")).expect("the record can be read");
    assert_eq!((sidecar.rules, sidecar.runs.len()), (RULES, 12));
    let survival = |run: usize| sidecar.runs[run].stages["evaluate.nominal"].values["survival"];
    assert_eq!([0, 1, 2].map(survival), [0.75, 0.5, 0.25]);
    let first = &sidecar.runs[0];
    assert_eq!((first.arm.as_str(), first.seed), ("control=torque,std=10 %", 1));
    assert_eq!(first.stages["evaluate.nominal"].episodes, Some(32));
    assert!(first.stages["evaluate.nominal"].values.contains_key("torque_rms"));
    assert!(first.stages["learn"].values.contains_key("final_return"));
    let failed = sidecar.runs.iter().find(|run| run.run == "control=position,std=5 %,seed=2").expect("a run");
    assert!(!failed.stages.contains_key("evaluate.nominal"), "{failed:?}");
    let values = vec![vec![vec![Some(0.75), Some(0.5), Some(0.25)]]];
    assert_eq!(sidecar.claims[0].cases[0].evidence, Some(Evidence::Runs { values, episodes: Some(32) }));
}

/// Runs a plan from its file with the store of a folder, and writes the report into another folder.
fn run_saved(plan: &Plan, folder: &Path, arguments: &[&str]) -> assert_cmd::assert::Assert {
    let file = folder.join("plan.json");
    fs::write(&file, serde_json::to_string(plan).expect("a plan is plain data"))
        .expect("the folder is writable");
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(folder).args(["--store", "store", "run", "plan.json"]).args(arguments).assert()
}

#[test]
fn a_run_that_fails_keeps_a_page_that_knows_more_and_writes_one_where_there_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    execute(&plan(), folder.path());
    let run = |reports: &str| {
        run_saved(&plan(), folder.path(), &["--reports", reports]).code(4).get_output().clone()
    };
    let path = |file: &str| folder.path().join(file);
    let first = run("reports");
    assert!(String::from_utf8_lossy(&first.stdout).contains("exploration.md"), "{first:?}");
    let record = fs::read_to_string(path("reports/exploration.json")).expect("a record");
    let mut fuller: Sidecar = serde_json::from_str(&record).expect("the record can be read");
    let known = fuller.results();
    let (from, to) = (fuller.arms[0].stages.clone(), &mut fuller.arms[1].stages);
    to.extend(from);
    fs::write(path("reports/exploration.json"), fuller.to_json()).expect("it can be written");
    fs::write(path("reports/exploration.md"), "all that was measured").expect("it can be written");
    let told = String::from_utf8_lossy(&run("reports").stderr).into_owned();
    let expected = format!(
        "reports/exploration.md has {} results, and this report would have {known}",
        fuller.results()
    );
    assert!(
        told.contains(&expected) && told.contains("the page is kept") && told.contains("--reports DIR"),
        "{told}"
    );
    let kept = |file: &str| fs::read_to_string(path(file)).expect("the page is there");
    assert_eq!(kept("reports/exploration.md"), "all that was measured");
    assert_eq!(kept("reports/exploration.json"), fuller.to_json());
    fs::write(path("reports/exploration.json"), "{").expect("it can be written");
    let told = String::from_utf8_lossy(&run("reports").stderr).into_owned();
    let expected = "reports/exploration.md has a record that cannot be read, so this report is \
        reports/exploration.full.md";
    assert!(told.contains(expected), "{told}");
    assert_eq!(kept("reports/exploration.md"), "all that was measured");
    run("elsewhere");
    assert!(path("elsewhere/exploration.md").is_file());
}

#[test]
fn a_folder_of_reports_that_cannot_be_written_is_named_and_not_the_store() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = plan_of(&STDS[..1]);
    execute(&plan, folder.path());
    fs::write(folder.path().join("file"), "not a folder").expect("it can be written");
    let told = |reports: &str, code: i32| {
        let run = run_saved(&plan, folder.path(), &["--reports", reports]).code(code);
        String::from_utf8_lossy(&run.get_output().stderr).into_owned()
    };
    let at_once = told("file/reports", 2);
    assert!(at_once.contains("error: reports cannot be written into file/reports: "), "{at_once}");
    // Writing the figures finds that the name of their folder is taken.
    fs::create_dir(folder.path().join("own")).expect("a folder");
    fs::write(folder.path().join("own/exploration"), "not a folder").expect("it can be written");
    let late = told("own", 4);
    assert!(late.contains("error: [R0004] the report cannot be written: own/"), "{late}");
    for told in [at_once, late] {
        assert!(told.contains("with `--reports DIR`") && !told.contains("--store"), "{told}");
    }
}

#[test]
fn a_claim_that_fails_ends_the_run_with_exit_code_5_where_claims_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let plan = plan_of(&STDS[..1]);
    let outcome = execute(&plan, folder.path());
    assert!(outcome.failures.is_empty());
    let run =
        |format: &str| run_saved(&plan, folder.path(), &["--format", format]).code(5).get_output().clone();
    let events = String::from_utf8_lossy(&run("json").stdout).into_owned();
    let last: serde_json::Value = serde_json::from_str(events.lines().last().expect("events")).expect("JSON");
    assert_eq!(last["event"], "run_finished");
    let ids: Vec<_> = last["claims"].as_array().expect("claims").iter().map(|claim| &claim["id"]).collect();
    assert_eq!(ids, ["survives_sometimes", "survives_often", "torque_survives_more"]);
    assert_eq!((&last["claims"][1]["verdict"], &last["claims"][1]["n"][0]), (&"FAIL".into(), &3.into()));
    let notes = String::from_utf8_lossy(&run("human").stderr).into_owned();
    assert!(notes.contains("survives_often: FAIL"), "{notes}");
}
