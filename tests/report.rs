//! Reports from made-up input: figures, tables, templates and their errors.

mod arms;
#[path = "report/made_up_work.rs"]
mod made_up_work;
#[path = "report/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::{Path, PathBuf};

use specforge::diag::{Diagnostic, Sources};
use specforge::exec::events::Record;
use specforge::exec::{self, Interrupt, Store, Work, Works, Workshop};
use specforge::plan::{StageKind, Training};
use specforge::report::model::ReportInput;
use specforge::report::plot::Anchor;
use specforge::report::plot::drawing::{Item, Words, text_width};
use specforge::report::publish::publish;
use specforge::report::sidecar::Sidecar;
use specforge::report::{ReportFile, ReportWork, Templates, figure, render};
use specforge::spec::Value;

#[test]
fn every_figure_is_drawn_and_the_same_each_time() {
    let input = synthetic::input();
    let figures = figure::all(&input);
    let again = figure::all(&input);
    for (figure, twin) in figures.iter().zip(&again) {
        assert_eq!(figure.drawing.to_svg(), twin.drawing.to_svg(), "{}", figure.id);
    }
    let ids: Vec<&str> = figures.iter().map(|figure| figure.id.as_str()).collect();
    let lapses = ["time_lapse_atlas_run_torque", "time_lapse_atlas_run_position"];
    assert_eq!(
        ids,
        ["learning_curves", "endings", "speed", lapses[0], lapses[1], "torques", "contact_forces"]
    );
}

/// What the texts of a figure cover, estimated, as left and right end.
fn overhanging(figure: &figure::Figure) -> Vec<&str> {
    let outside = |words: &&Words| {
        let width = text_width(&words.text, words.size);
        let left = match words.anchor {
            Anchor::Start => words.at[0],
            Anchor::Middle => words.at[0] - 0.5 * width,
            Anchor::End => words.at[0] - width,
        };
        !words.upwards && (left < 0.0 || left + width > figure.drawing.width)
    };
    let words = figure.drawing.items.iter().filter_map(|item| match item {
        Item::Words(words) => Some(words),
        _ => None,
    });
    words.filter(outside).map(|words| words.text.as_str()).collect()
}

#[test]
fn no_text_is_cut_at_the_edge_of_a_page_however_long_the_names_are() {
    let mut alone = synthetic::input();
    alone.arms.truncate(1);
    let mut long = synthetic::input();
    for arm in &mut long.arms {
        arm.name = format!("a_robot_of_a_rather_long_name_{}", arm.name.replace('_', "-"));
    }
    for input in [synthetic::input(), alone, long] {
        for figure in figure::all(&input) {
            assert_eq!(overhanging(&figure), Vec::<&str>::new(), "{}", figure.id);
        }
    }
}

#[test]
fn one_arm_is_named_in_the_caption_of_its_learning_curves_and_not_beside_its_line() {
    let mut input = synthetic::input();
    input.arms.truncate(1);
    let curves = figure::learning_curves::figure(&input, Training::First).expect("it has learned");
    assert!(curves.caption.contains("atlas_run_torque: 183 updates"), "{}", curves.caption);
    assert!(!curves.drawing.to_svg().contains(">atlas_run_torque<"));
}

#[test]
fn trainings_that_did_not_measure_single_support_have_no_panel_of_it() {
    let mut input = synthetic::input();
    let titles = |input: &ReportInput| {
        let curves = figure::learning_curves::figure(input, Training::First).expect("they have learned");
        (curves.drawing.to_svg().contains("single support"), curves.caption.contains("Single support"))
    };
    assert_eq!(titles(&input), (true, true));
    for update in input.arms.iter_mut().flat_map(|arm| &mut arm.updates) {
        update.single_support = None;
    }
    assert_eq!(titles(&input), (false, false));
}

/// Renders the made-up report into the target folder, for people to look at.
fn rendered() -> Vec<ReportFile> {
    let files = render(&synthetic::input(), &Templates::default(), &mut Sources::default())
        .unwrap_or_else(|diagnostics| panic!("the template that comes along has mistakes: {diagnostics:#?}"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reports");
    for file in &files {
        let path = folder.join(&file.path);
        fs::create_dir_all(path.parent().expect("files lie in a folder")).expect("the folder can be made");
        fs::write(path, &file.text).expect("the file can be written");
    }
    files
}

/// Deviations are the keys in which an arm differs from the baseline; a page without baseline has no such
/// section.
#[test]
fn a_page_with_a_baseline_has_the_keys_that_differ_with_both_values_and_one_without_has_none() {
    let mut input = synthetic::input();
    let page = |input: &ReportInput| {
        render(input, &Templates::default(), &mut Sources::default()).expect("the template has no mistake")[0]
            .text
            .clone()
    };
    assert!(!page(&input).contains("<summary>Deviations"));
    let mut baseline = input.arms[0].fields.clone();
    baseline.insert("name".into(), Value::Text("usual_run".into()));
    let Some(Value::Table(learn)) = baseline.get_mut("learn") else { panic!("it learns") };
    learn.insert("samples".into(), Value::Count(6_000_000));
    input.baselines = vec![baseline];
    for arm in &mut input.arms {
        (arm.baseline, arm.budget_share) = (Some(0), Some(0.5));
    }
    let text = page(&input);
    assert!(
        text.contains(
            "<summary>Deviations from the baseline</summary>\n\nCompared with the baseline `usual_run`.\n\n* "
        ),
        "{text}"
    );
    assert!(text.contains("(`learn.samples`): 3.0 M; the baseline has 6.0 M.\n"), "{text}");
    assert!(text.contains("(`action.kind`): position in 1 of 2 runs; the baseline has torque.\n"), "{text}");
    assert!(text.contains("| share of the baseline's samples | 50 % | 50 % |"), "{text}");
    assert!(text.contains("* The budget is below the baseline's: torque 3.0 M samples, 50 %"), "{text}");
}

#[test]
fn the_report_is_what_the_golden_says() {
    let files = rendered();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/report");
    for name in ["atlas_run_torque.md", "atlas_run_torque/speed.svg"] {
        let file = files.iter().find(|file| file.path == Path::new(name)).expect("the file was rendered");
        let path = golden.join(Path::new(name).file_name().expect("a file has a name"));
        if std::env::var_os("SPECFORGE_BLESS").is_some() {
            fs::create_dir_all(&golden).expect("the folder can be made");
            fs::write(&path, &file.text).expect("the golden can be written");
        }
        let expected = fs::read_to_string(&path).expect("the golden is there; SPECFORGE_BLESS=1 writes it");
        assert_eq!(file.text, expected, "{name}: if the change is meant, bless it with SPECFORGE_BLESS=1");
    }
}

/// The words of a page outside its folded parts.
fn unfolded(page: &str) -> usize {
    let mut depth = 0;
    let mut words = 0;
    for line in page.lines() {
        depth += line.matches("<details>").count();
        words += if depth == 0 { line.split_whitespace().filter(|word| *word != "|").count() } else { 0 };
        depth -= line.matches("</details>").count();
    }
    assert_eq!(depth, 0, "every folded part ends");
    words
}

/// A reader has the question, the answer and its certainty within a minute.
#[test]
fn a_page_has_at_most_800_words_that_are_not_folded_and_its_question_and_answer_come_first() {
    let reports = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports");
    let mut pages = vec![("the made-up page".to_owned(), rendered().remove(0).text)];
    for folder in ["", "paper", "studies"] {
        let files = fs::read_dir(reports.join(folder)).expect("the reports are there").flatten();
        let files =
            files.map(|file| file.path()).filter(|path| path.extension().is_some_and(|end| end == "md"));
        let files = files.filter(|path| path.with_extension("json").is_file());
        pages.extend(files.map(|path| {
            (path.display().to_string(), fs::read_to_string(&path).expect("the page can be read"))
        }));
    }
    assert!(pages.len() > 1, "there are committed pages");
    for (name, text) in pages {
        let words = unfolded(&text);
        assert!(words <= 800, "{name}: {words} words are not folded");
        let [question, answer] = ["**Question.**", "**Answer.**"].map(|mark| text.find(mark));
        assert!(question.is_some() && question < answer, "{name}");
    }
}

/// The diagnostics of a report with this template, and the texts that they point into.
fn mistakes(template: &str) -> (Vec<Diagnostic>, Sources) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("mine.md.j2"), template).expect("the folder can be written");
    let mut sources = Sources::default();
    let input = ReportInput { template: "mine.md.j2".to_string(), ..synthetic::input() };
    let templates = Templates::new(Some(folder.path().to_path_buf()));
    let found = render(&input, &templates, &mut sources).expect_err("the template has a mistake");
    (found, sources)
}

/// The code of a diagnostic, the line of its place and the text there.
fn place(diagnostic: &Diagnostic, sources: &Sources) -> (&'static str, usize, String) {
    let span = diagnostic.labels.first().expect("the mistake has a place").span;
    let text = &sources.get(span.source).text;
    let line = text[..span.start].matches('\n').count() + 1;
    (diagnostic.code, line, text[span.start..span.end].to_string())
}

#[test]
fn undefined_variables_and_unknown_filters_are_all_named_with_their_lines() {
    let (found, sources) = mistakes("# {{ name }}\n{{ sumary }}\n{{ figures.torqes }}\n{{ name | shout }}\n");
    let places: Vec<_> = found.iter().map(|diagnostic| place(diagnostic, &sources)).collect();
    let expected = [("E0902", 2, "sumary"), ("E0902", 3, "figures.torqes"), ("E0903", 4, "shout")];
    assert_eq!(places, expected.map(|(code, line, text)| (code, line, text.to_string())));
    assert_eq!(found[0].help, ["did you mean `summary`?"]);
    assert_eq!(found[1].help, ["did you mean `torques`?"]);
}

#[test]
fn an_undefined_attribute_in_a_loop_is_named_with_its_line() {
    let (found, sources) = mistakes("{% for arm in arms %}\n{{ arm.survivall }}\n{% endfor %}\n");
    let (code, line, text) = place(&found[0], &sources);
    assert_eq!((code, line), ("E0902", 2));
    assert!(text.contains("survivall"), "{text}");
}

#[test]
fn a_syntax_error_is_placed_and_a_missing_template_named() {
    let (found, sources) = mistakes("fine\n{{ name\n");
    let (code, line, _) = place(&found[0], &sources);
    assert_eq!(code, "E0904");
    assert!(line == 2 || line == 3, "{line}");
    let input = ReportInput { template: "runs.md.j2".to_string(), ..synthetic::input() };
    let found = render(&input, &Templates::default(), &mut Sources::default())
        .expect_err("there is no such template");
    assert_eq!(found[0].code, "E0901");
}

#[test]
fn a_template_is_stopped_at_its_limits_of_steps_output_and_recursion() {
    let loops = "{% for a in range(100000) %}{% for b in range(100000) %}{% for c in range(100000) %}\
                 {% endfor %}{% endfor %}{% endfor %}";
    let cases = [
        ("steps", loops.to_string()),
        ("output", "{% for a in range(1000) %}{{ 'x' * 90000000 }}{% endfor %}".to_string()),
        ("repetition", "{{ 'x' * 1000000000000 }}".to_string()),
        ("range", "{{ range(1000000000000)|length }}".to_string()),
        ("macro", "{% macro m(x) %}{{ m(x) }}{% endmacro %}{{ m(1) }}".to_string()),
        ("include", "{% include 'mine.md.j2' %}".to_string()),
    ];
    for (name, template) in cases {
        let (found, _) = mistakes(&template);
        assert_eq!(found[0].code, "E0905", "{name}: {found:?}");
    }
}

#[test]
fn a_template_that_takes_all_memory_is_left_to_itself() {
    const CHILD: &str = "SPECFORGE_TEST_DOUBLING";
    if std::env::var_os(CHILD).is_some() {
        let (found, _) = mistakes(&format!("{{% set a = 'aaaaaaaa' %}}{}", "{% set a = a ~ a %}".repeat(60)));
        // The rendering goes on in its thread, which ends with the process.
        std::process::exit(if found[0].code == "E0905" && found[0].message.contains("memory") {
            0
        } else {
            1
        });
    }
    let name = "a_template_that_takes_all_memory_is_left_to_itself";
    let child = std::process::Command::new(std::env::current_exe().expect("this test has a path"))
        .args(["--exact", name, "--nocapture"])
        .env(CHILD, "1")
        .output()
        .expect("this test can be started");
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stderr));
}

#[test]
fn the_templates_that_come_along_pass_the_check_before_any_run() {
    assert_eq!(
        specforge::report::check("report.md.j2", &Templates::default(), &mut Sources::default()),
        vec![]
    );
}

#[test]
fn two_evaluations_in_one_engine_are_compared_in_tables_of_their_own() {
    let mut input = synthetic::input();
    for arm in &mut input.arms {
        let mut second = arm.evaluations[0].clone();
        second.stage = "evaluate.box".to_owned();
        arm.evaluations.push(second);
    }
    let tables = specforge::report::table::evaluation::comparisons(&input);
    let ids: Vec<&str> = tables.iter().map(|table| table.id.as_str()).collect();
    let own = ["evaluate_nominal", "evaluate_box"].map(|stage| format!("comparison_position_rapier_{stage}"));
    assert_eq!(ids, own);
    assert!(
        tables[1].title.starts_with("torque minus position in rapier (evaluate.box) ("),
        "{}",
        tables[1].title
    );
}

#[test]
fn one_number_has_one_interval_wherever_it_stands() {
    let text = rendered().remove(0).text;
    let row = text
        .lines()
        .find(|line| line.starts_with("| mean forward speed (m/s) |"))
        .expect("the speed was measured");
    let number = row.split('|').nth(2).expect("a first column").trim().to_owned();
    let (mean, interval) = number.split_once(' ').expect("a mean with its interval");
    let elsewhere = text.matches(&format!("{mean} m/s {interval}")).count();
    assert_eq!(elsewhere, 3, "at a glance, in the result and in its criteria: {number}\n{text}");
}

#[test]
fn a_spec_without_a_summary_has_no_lone_full_stop() {
    for (summary, second) in [("", "Profile: quick."), ("It runs", "It runs. Profile: quick.")] {
        let input = ReportInput { summary: summary.to_owned(), ..synthetic::input() };
        let text = render(&input, &Templates::default(), &mut Sources::default())
            .expect("no mistake")
            .remove(0)
            .text;
        assert_eq!(text.lines().nth(2), Some(second));
    }
}

#[test]
fn an_arm_without_any_result_still_gets_an_honest_report() {
    let mut input = synthetic::input();
    for arm in &mut input.arms {
        (arm.robot, arm.motion, arm.pretrain) = (None, None, None);
        (arm.updates, arm.evaluations, arm.stages) = (vec![], vec![], vec![]);
    }
    let files =
        render(&input, &Templates::default(), &mut Sources::default()).expect("the template has no mistake");
    assert_eq!(files.len(), 2, "a report without figures, and its sidecar");
    assert!(files[0].text.contains("**torque** was not evaluated."), "{}", files[0].text);
    assert!(files[0].text.contains("torque: nothing was evaluated"), "{}", files[0].text);
}

#[test]
fn figures_and_cells_name_the_stages_that_they_come_from() {
    let files = rendered();
    let svg = files
        .iter()
        .find(|file| file.path.ends_with("learning_curves.svg"))
        .expect("there are learning curves");
    assert!(svg.text.contains("<metadata>{\"report\":\"atlas_run_torque\",\"figure\":\"learning_curves\""));
    let json =
        files.iter().find(|file| file.path.ends_with("atlas_run_torque.json")).expect("there is a sidecar");
    let sidecar: Sidecar = serde_json::from_str(&json.text).expect("the sidecar can be read");
    let table = sidecar.items.iter().find(|item| item.id == "evaluation").expect("there is an evaluation");
    let cell = table.cells.iter().find(|cell| cell.row == "survival").expect("survival was measured");
    let source = cell.source.as_ref().expect("the column has one source");
    assert_eq!((source.arm.as_str(), source.stage.as_str()), ("atlas_run_torque", "evaluate.nominal"));
    assert_eq!(sidecar.record(source).expect("the stage is recorded").fields, ["evaluate.nominal"]);
}

/// Runs a plan of the two made-up arms, of which the second fails to learn, and publishes the report.
fn run_and_publish(folder: &Path) -> PathBuf {
    let plan =
        arms::plan(&[arms::arm("atlas_run_torque", "torque"), arms::arm("atlas_run_position", "position")]);
    let mut works: Works = StageKind::ALL
        .into_iter()
        .map(|kind| (kind, Box::new(made_up_work::MadeUp) as Box<dyn Work>))
        .collect();
    let report = ReportWork::new(Templates::default(), |_| Some("tau = a".to_string()));
    works.insert(StageKind::Report, Box::new(report));
    let (store, record, interrupt) =
        (Store::at(folder.join("store")), Record::default(), Interrupt::default());
    let workshop =
        Workshop { plan: &plan, store: &store, works: &works, events: &record, interrupt: &interrupt };
    let outcome = exec::run(&workshop, &arms::options(&plan, 2)).expect("the store works");
    let Some(artefact) = outcome.report else {
        panic!("a failed arm leaves a report: {:?}", outcome.failures)
    };
    publish(&artefact, &folder.join("reports"), "atlas_run_torque").expect("the report can be copied").page
}

#[test]
fn a_report_gathered_from_the_store_has_both_arms_and_says_what_failed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = fs::read_to_string(run_and_publish(folder.path())).expect("the report is there");
    assert!(text.contains("**torque** runs."), "{text}");
    assert!(text.contains("**position** was not evaluated."), "{text}");
    assert!(text.contains("[R0001] the state became NaN"), "{text}");
    assert!(text.contains("`tau = a`"), "{text}");
    assert!(folder.path().join("reports/atlas_run_torque/contact_forces.svg").is_file());
}

#[test]
fn trace_names_stage_values_and_commit_behind_a_figure_and_a_cell() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_and_publish(folder.path());
    let trace = |target: &str| {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        command.current_dir(folder.path()).args(["trace", target]).assert()
    };
    let figure = trace("reports/atlas_run_torque/learning_curves.svg").success();
    let text = String::from_utf8_lossy(&figure.get_output().stdout).into_owned();
    assert!(text.contains("atlas_run_torque learner") && text.contains("learn.samples = 2.0 M"), "{text}");
    assert!(text.contains("commit ") && text.contains("pretrain  "), "{text}");
    let cell = trace("reports/atlas_run_torque.md#evaluation.survival").success();
    let text = String::from_utf8_lossy(&cell.get_output().stdout).into_owned();
    assert!(text.contains("survival of torque, rapier, n = 32: 100 % [89, 100], n = 32"), "{text}");
    let unknown = trace("reports/atlas_run_torque.md#evaluation.survivall").code(2);
    let text = String::from_utf8_lossy(&unknown.get_output().stderr).into_owned();
    assert!(text.contains("has no row `survivall`") && text.contains("single_support"), "{text}");
    trace("reports/nothing.md").code(3);
}

#[test]
fn a_page_or_figure_that_was_edited_is_found_by_the_digests_of_its_record() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = run_and_publish(folder.path());
    let figure = folder.path().join("reports/atlas_run_torque/speed.svg");
    let check = || {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        command.current_dir(folder.path()).args(["report", "--check"]);
        let output = command.output().expect("it runs");
        let told =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        (output.status.code(), told)
    };
    let (code, told) = check();
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("unchanged since they were rendered: 1; changed: 0"), "{told}");
    let text = fs::read_to_string(&page).expect("the report is there");
    let edited = text.replacen("was not evaluated", "was evaluated", 1);
    assert_ne!(edited, text);
    fs::write(&page, edited).expect("it can be written");
    let drawing = fs::read_to_string(&figure).expect("the figure is there");
    fs::write(&figure, drawing.clone() + "<!-- -->").expect("it can be written");
    let (code, told) = check();
    assert_eq!(code, Some(4), "{told}");
    for file in ["atlas_run_torque.md", "atlas_run_torque/speed.svg"] {
        assert!(
            told.contains(&format!("[R0013] reports/{file}: it was changed after it was rendered")),
            "{told}"
        );
    }
    fs::write(&page, text).expect("it can be written");
    fs::remove_file(&figure).expect("it is there");
    let (code, told) = check();
    assert!(
        code == Some(4) && told.contains("speed.svg: it is missing") && !told.contains(".md: it was"),
        "{told}"
    );
    fs::write(&figure, drawing).expect("it can be written");
    // The record itself has a digest, too, and whoever reads it asks for it.
    let record = page.with_extension("json");
    let text = fs::read_to_string(&record).expect("it is there");
    fs::write(&record, text.replacen("Forward speed", "Backward speed", 1)).expect("it can be written");
    let (code, told) = check();
    assert!(
        code == Some(4) && told.contains("[R0013] reports/atlas_run_torque.json: it was changed"),
        "{told}"
    );
    let mut trace = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    let refused = trace
        .current_dir(folder.path())
        .args(["trace", "reports/atlas_run_torque/speed.svg"])
        .assert()
        .code(4);
    let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(told.contains("[R0013]") && told.contains("atlas_run_torque.json was changed"), "{told}");
    // Publishing again puts it right.
    run_and_publish(folder.path());
    assert_eq!(fs::read_to_string(&record).expect("it is there"), text);
    assert_eq!(check().0, Some(0));
    // Digests that were removed are missing ones.
    let mut old = Sidecar::read(&record).expect("it is there");
    old.digests.clear();
    old.seal.clear();
    fs::write(&record, old.to_json()).expect("it can be written");
    let (code, told) = check();
    assert!(code == Some(4) && told.contains("unchanged since they were rendered: 0; changed: 1"), "{told}");
    assert!(told.contains("it has no digest of itself") && !told.contains("cannot be verified"), "{told}");
}

#[test]
fn exported_policies_are_copied_beside_the_page_that_links_them_and_tracked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = run_and_publish(folder.path());
    let text = fs::read_to_string(&page).expect("the report is there");
    let file = "atlas_run_torque/policies/atlas_run_torque.safetensors";
    // The other arm failed to learn.
    assert!(text.contains(&format!("[atlas_run_torque]({file}).")), "{text}");
    let copy = page.with_file_name(file);
    assert_eq!(fs::read_to_string(&copy).expect("the copy is there"), "weights of atlas_run_torque");
    let specforge = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
        let output = command.current_dir(folder.path()).args(arguments).output().expect("it runs");
        let told =
            [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        (output.status.code(), told)
    };
    let check = || specforge(&["report", "--check"]);
    assert_eq!(check().0, Some(0), "{}", check().1);
    let trace = specforge(&["trace", &format!("reports/{file}")]).1;
    assert!(trace.contains("atlas_run_torque deploy.policy"), "{trace}");
    fs::write(&copy, "other weights").expect("it can be written");
    let stray = copy.with_file_name("other.safetensors");
    fs::write(&stray, "weights").expect("it can be written");
    let (code, told) = check();
    assert_eq!(code, Some(4), "{told}");
    assert!(told.contains("atlas_run_torque.safetensors: it was changed after it was rendered"), "{told}");
    assert!(told.contains("other.safetensors: it is not a policy of this report"), "{told}");
    // A page may be passed on without its policies, and rendering it again writes them.
    fs::remove_file(&stray).and_then(|()| fs::remove_file(&copy)).expect("they are there");
    assert_eq!(check().0, Some(0), "{}", check().1);
    run_and_publish(folder.path());
    assert_eq!(fs::read_to_string(&copy).expect("the copy is there"), "weights of atlas_run_torque");
}

#[test]
fn a_page_and_its_record_repeat_the_permission_for_folders_outside_of_the_project() {
    let mut input = synthetic::input();
    input.request.allow_outside = vec!["../shared".into()];
    let files = render(&input, &Templates::default(), &mut Sources::default()).expect("no mistake");
    let [page, record] = [&files[0].text, &files[1].text];
    assert!(page.contains("--allow-outside ../shared"), "{page}");
    let record: Sidecar = serde_json::from_str(record).expect("a record");
    assert!(record.command().ends_with(" --allow-outside ../shared"), "{}", record.command());
}

#[test]
fn a_division_by_zero_in_a_template_is_an_error_at_its_line_and_no_number_on_a_page() {
    for expression in ["1 // 0", "1 % 0", "(1 / 0)|number"] {
        let (found, sources) = mistakes(&format!("# Title\n\n{{{{ {expression} }}}}\n"));
        assert_eq!((found[0].code, place(&found[0], &sources).1), ("E0904", 3), "{expression}: {found:?}");
    }
}
