//! The inspecting commands from outside: exit codes, standard output and standard error.

mod folders;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use self::folders::copy;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn specforge(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(root()).args(arguments).output().expect("the program can be started")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ends by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The specs of the project, without their parents.
fn specs() -> Vec<PathBuf> {
    let entries =
        fs::read_dir(root().join("specs")).expect("specs/ is there").flatten().map(|entry| entry.path());
    entries.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect()
}

#[test]
fn every_spec_of_the_project_is_in_order() {
    let output = specforge(&["check", "specs", "--deny", "warnings"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(stdout(&output), "", "messages are no data");
}

#[test]
fn a_profile_over_many_files_passes_over_those_that_lack_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let parent = root().join("specs/tocabi_walk_torque.toml");
    let with = format!(
        "spec = 1\nname = \"with\"\nextends = {parent:?}\n[profile.tiny]\nlearn.samples = \"x\"\n\
         [report]\ncompare = []\n"
    );
    let without = format!("spec = 1\nname = \"without\"\nextends = {parent:?}\n");
    let plain = without.replace("without", "plain");
    for (name, text) in [("with.toml", with), ("without.toml", without), ("plain.toml", plain)] {
        fs::write(folder.path().join(name), text).expect("files can be written");
    }
    let place = folder.path().to_string_lossy().into_owned();
    let output = specforge(&["check", &place, "--profile", "tiny", "--allow-outside", "specs"]);
    let told = stderr(&output);
    assert_eq!(code(&output), 3, "the mistake in the profile is found: {told}");
    assert!(told.contains("with.toml:5:17") && !told.contains("E0706"), "{told}");
    assert!(told.contains("2 specs have no profile `tiny`, checked as they stand:"), "{told}");
    assert!(told.contains("/plain.toml\n") && told.contains("/without.toml\n"), "{told}");
    let output = specforge(&["check", &place, "--profile", "tyni", "--allow-outside", "specs"]);
    assert_eq!(code(&output), 3);
    assert!(stderr(&output).contains("error[E0706]: unknown profile `tyni`"), "{}", stderr(&output));
}

#[test]
fn a_key_of_a_kind_that_only_a_profile_has_names_the_profile() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let parent = root().join("specs/tocabi_walk_torque.toml");
    let head = format!("spec = 1\nname = \"mine\"\nextends = {parent:?}\n");
    let path = folder.path().join("mine.toml");
    let told = |lines: &str, arguments: &[&str]| {
        fs::write(&path, format!("{head}{lines}")).expect("files can be written");
        let output =
            specforge(&[&["check", "--allow-outside", "specs", &path.to_string_lossy()], arguments].concat());
        (code(&output), stderr(&output))
    };
    // As it stands the spec has labels of gravity compensation, in its profiles those of a tracking
    // controller.
    let (code, text) = told("[pretrain]\nstiffness = \"25 %\"\n", &[]);
    assert_eq!(code, 3, "{text}");
    assert!(text.contains("E0105") && text.contains("mine.toml: 1 error"), "{text}");
    assert!(
        text.contains(
            "help: there are no errors with `--profile desk` or `--profile quick` or `--profile small`"
        ),
        "{text}"
    );
    assert_eq!(told("[pretrain]\nstiffness = \"25 %\"\n", &["--profile", "desk"]).0, 0);
    // Of another mistake it would be no cure that a profile happens not to have it.
    let (code, text) = told("[action]\ndelay = 0.004\n", &[]);
    assert!(code == 3 && text.contains("E0201") && !text.contains("there are no errors with"), "{text}");
}

#[test]
fn what_is_wrong_with_a_file_has_a_code_and_ends_with_3() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| {
        fs::write(folder.path().join(name), bytes).expect("files can be written");
        folder.path().join(name)
    };
    let cases = [
        (folder.path().join("absent.toml"), "E0004"),
        (write("empty.toml", b""), "E0002"),
        (write("binary.toml", &[0xff, 0xfe, 0x00, 0x80]), "E0005"),
        (write("huge.toml", &vec![b'#'; 10 << 20]), "E0006"),
        (write("broken.toml", b"spec = 1\n[action\n"), "E0001"),
    ];
    for (path, expected) in cases {
        let output = specforge(&["check", "--format", "json", &path.to_string_lossy()]);
        assert_eq!(code(&output), 3, "{}", path.display());
        let document: serde_json::Value =
            serde_json::from_str(&stdout(&output)).expect("the document is JSON");
        assert_eq!(document["errors"], 1, "{document}");
        assert_eq!(document["diagnostics"][0]["code"], expected, "{document}");
    }
}

#[test]
fn a_folder_without_specs_and_wrong_arguments_end_with_2() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_eq!(code(&specforge(&["check", &folder.path().to_string_lossy()])), 2);
    assert_eq!(code(&specforge(&["check"])), 2);
    assert_eq!(code(&specforge(&["chek", "specs"])), 2);
    assert_eq!(code(&specforge(&["show", "--diff", "specs/atlas_run_torque.toml"])), 2);
    assert_eq!(code(&specforge(&["explain", "E9999"])), 2);
    assert_eq!(code(&specforge(&["--help"])), 0);
}

#[test]
fn codes_kinds_and_units_are_explained() {
    assert!(stdout(&specforge(&["explain", "e0203"])).starts_with("# E0203: wrong dimension"));
    let torque = stdout(&specforge(&["explain", "torque"]));
    assert!(torque.contains("# action.torque") && torque.contains("# reward.torque"), "one word, two kinds");
    assert!(stdout(&specforge(&["explain", "ms"])).contains("1 ms is 0.001 s."));
    let relative = stdout(&specforge(&["explain", "mgh/rad"]));
    assert!(relative.contains("  tocabi ") && relative.contains("  pretrain.stiffness\n"), "{relative}");
    assert!(stdout(&specforge(&["list", "units"])).contains("mgh*sqrt(h/g)/rad"));
    assert!(
        stderr(&specforge(&["explain", "velocity_trackin"])).contains("did you mean `velocity_tracking`?")
    );
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let started = command.arg("list").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = started.expect("the program can be started");
    drop(child.stdout.take());
    let mut complaints = String::new();
    child.stderr.take().expect("stderr is piped").read_to_string(&mut complaints).expect("messages are text");
    assert!(child.wait().expect("the program ends").success(), "{complaints}");
    assert_eq!(complaints, "");
}

#[test]
fn a_resolved_spec_describes_the_same_experiment() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy(&root().join("specs"), folder.path());
    for spec in specs() {
        let name = spec.file_name().expect("a spec has a name");
        let original = folder.path().join(name);
        for variant in [&["--set", "learn.seed=7"][..], &["--profile", "quick"][..]] {
            let file = original.to_string_lossy();
            let shown = [&["show", "--resolved", &file][..], variant].concat();
            let resolved = folder.path().join(format!("resolved_{}", name.to_string_lossy()));
            fs::write(&resolved, stdout(&specforge(&shown))).expect("files can be written");
            let values = |path: &Path, variant: &[&str]| {
                let file = path.to_string_lossy();
                let arguments = ["show", "--resolved", "--format", "json", &file];
                let output = specforge(&[&arguments[..], variant].concat());
                assert_eq!(code(&output), 0, "{}", stderr(&output));
                stdout(&output)
            };
            assert_eq!(values(&resolved, &[]), values(&original, variant), "{}", spec.display());
        }
    }
}

#[test]
fn origins_name_file_profile_argument_and_default() {
    let arguments =
        ["show", "--origins", "specs/atlas_run_torque.toml", "--profile", "quick", "--set", "learn.seed=3"];
    let shown = stdout(&specforge(&arguments));
    let origin = |path: &str| {
        let line =
            shown.lines().find(|line| line.starts_with(&format!("{path} = "))).expect("the value is shown");
        line.rsplit_once("  ").expect("an origin stands behind two spaces").1.to_owned()
    };
    assert!(origin("action.kind").starts_with("specs/base/action/torque.toml:"));
    assert!(origin("action.delay").starts_with("profile quick, specs/base/budget/small.toml:"));
    assert_eq!(origin("learn.seed"), "--set learn.seed=3");
    assert_eq!(origin("learn.max_grad_norm"), "default");
}

#[test]
fn signals_are_thirty_inputs_and_thirteen_outputs_in_joint_order() {
    let output = specforge(&["show", "--signals", "--format", "json", "specs/tocabi_walk_torque.toml"]);
    let document: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("the document is JSON");
    let (inputs, outputs) = (&document["inputs"], &document["outputs"]);
    assert_eq!(inputs.as_array().map(Vec::len), Some(30));
    assert_eq!(outputs.as_array().map(Vec::len), Some(13));
    assert_eq!(
        (&inputs[3]["signal"], &inputs[3]["joint"]),
        (&"joint_position".into(), &"L_HipYaw_Joint".into())
    );
    assert_eq!((&inputs[29]["signal"], &inputs[29]["unit"]), (&"command_speed".into(), &"m/s".into()));
    assert_eq!(outputs[3]["range"], serde_json::json!([-289.0, 289.0]));
    assert_eq!(
        document["law"],
        "tau = clamp(effort_limit * a, +-effort_limit), held for 4 ms, delayed 2..6 ms"
    );
}

#[test]
fn a_diff_names_the_values_in_which_two_specs_differ() {
    let shown = stdout(&specforge(&[
        "show",
        "--diff",
        "specs/atlas_run_torque.toml",
        "specs/atlas_run_position.toml",
    ]));
    assert!(shown.contains("action.kind\n  - \"torque\""), "{shown}");
    assert!(!shown.contains("physics"), "what is shared is not shown: {shown}");
}

#[test]
fn a_diff_lists_tables_that_only_one_of_two_specs_has() {
    let specs = ["specs/atlas_run_torque.toml", "specs/atlas_run_position.toml"];
    let output = specforge(&["show", "--diff", specs[0], specs[1]]);
    assert_eq!(code(&output), 0, "a difference is no failure");
    let shown = stdout(&output);
    assert!(shown.contains("pretrain: only in specs/atlas_run_torque.toml\n  - kind = "), "{shown}");
    let json: serde_json::Value = serde_json::from_str(&stdout(&specforge(&[
        "show", "--diff", specs[0], specs[1], "--format", "json",
    ])))
    .expect("JSON");
    assert!(json["only_a"]["pretrain"]["pretrain.samples"]["origin"].is_string(), "{json}");
    let kind = json["values"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|row| row["path"] == "action.kind")
        .expect("it differs");
    assert_eq!((&kind["a"]["value"], &kind["b"]["layer"]), (&"\"torque\"".into(), &"file".into()));
    let same = stdout(&specforge(&["show", "--diff", specs[0], specs[0]]));
    assert_eq!(same, "the two specs describe the same experiment\n");
}

#[test]
fn origins_follow_the_order_of_a_spec_and_have_file_and_line_for_programs() {
    let arguments = ["show", "--origins", "specs/atlas_run_torque.toml", "--profile", "quick"];
    let shown = stdout(&specforge(&arguments));
    let place = |path: &str| shown.find(&format!("\n{path} = ")).unwrap_or_else(|| panic!("{path}: {shown}"));
    assert!(place("physics.rate") < place("action.kind") && place("action.kind") < place("action.delay"));
    assert!(place("action.delay") < place("learn.kind") && place("learn.kind") < place("learn.clip"));
    let output = specforge(&[&arguments[..], &["--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let delay = &json["action.delay"];
    assert_eq!((&delay["value"], &delay["layer"]), (&"\"0 ms\"".into(), &"profile".into()));
    let (file, line) = (delay["file"].as_str().expect("a file"), delay["line"].as_u64().expect("a line"));
    let text = fs::read_to_string(root().join(file)).expect("the file is there");
    assert_eq!(text.lines().nth(line as usize - 1), Some("action.delay  = \"0 ms\""));
}

#[test]
fn keys_sections_registries_and_composed_units_are_explained() {
    let explained = |word: &str| stdout(&specforge(&["explain", word]));
    let samples = explained("learn.samples");
    assert!(
        samples.starts_with("# learn.samples\n")
            && samples.contains("* takes a count")
            && samples.contains("* required")
    );
    let rate = explained("action.rate");
    assert!(
        rate.contains("* takes a rate (`Hz`)") && rate.contains("* of kind `position`, `torque`"),
        "{rate}"
    );
    assert!(explained("physics").contains("  engine "));
    assert!(explained("reward").contains("  velocity_tracking "));
    let speed = explained("rad/s");
    assert!(
        speed.contains("specforge computes in") && speed.contains("  robots.links.joint.velocity_limit\n"),
        "{speed}"
    );
    assert!(explained("km/h").contains("1 km/h is 0.27777"));
    let hertz = explained("Hz");
    assert!(hertz.contains("  physics.rate\n") && hertz.contains("prefixes"), "{hertz}");
    let json: serde_json::Value =
        serde_json::from_str(&stdout(&specforge(&["explain", "kHz", "--format", "json"]))).expect("JSON");
    assert_eq!((&json[0]["dimension"], &json[0]["factor"]), (&"a rate".into(), &1000.0.into()));
}

#[test]
fn a_slip_gets_the_names_that_are_near() {
    let advice = |word: &str| stderr(&specforge(&["explain", word]));
    assert!(advice("learn.sampels").contains("did you mean `learn.samples`"), "{}", advice("learn.sampels"));
    assert!(advice("E0230").contains("`E0203`"), "{}", advice("E0230"));
    assert!(advice("zzzzzzzzzz").contains("specforge list"));
    assert!(stderr(&specforge(&["list", "rewards"])).contains("did you mean `reward`?"));
}

#[test]
fn lists_have_a_line_per_entry_and_a_form_for_programs() {
    for what in ["codes", "engines", "keys", "motions", "robots", "units"] {
        let lines = stdout(&specforge(&["list", what])).lines().count();
        let json: serde_json::Value =
            serde_json::from_str(&stdout(&specforge(&["list", what, "--format", "json"]))).expect("JSON");
        let entries = json.as_array().expect("a list");
        assert_eq!(entries.len(), lines, "{what}");
        assert!(
            entries.iter().all(|entry| entry["summary"].as_str().is_some_and(|text| !text.is_empty())),
            "{what}"
        );
    }
    let engines = stdout(&specforge(&["list", "engines", "--format", "json"]));
    assert!(engines.contains("height_field") && engines.contains("cylinder"), "{engines}");
    let keys = stdout(&specforge(&["list", "keys"]));
    assert!(keys.lines().any(|line| line.starts_with("learn.samples ")), "{keys}");
}

#[test]
fn the_whole_text_of_a_diff_is_as_a_user_reads_it() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::copy(root().join("tests/language/whole.toml"), folder.path().join("whole.toml")).expect("copied");
    let spec = |name: &str, lines: &str| {
        let text = format!("spec = 1\nextends = \"whole.toml\"\n{lines}");
        fs::write(folder.path().join(name), text).expect("written");
    };
    spec("a.toml", "[learn]\nseed = 2\n");
    spec("b.toml", "[reward.torque_change]\nweight = 0.05\nk = \"0.01 /N/m\"\n");
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let output = command
        .current_dir(folder.path())
        .args(["show", "--diff", "a.toml", "b.toml"])
        .output()
        .expect("started");
    let expected = "--- a.toml\n+++ b.toml\nlearn.seed\n  - 2  a.toml:4\n  + 1  \
        default\nreward.torque_change: only in b.toml\n  \
         + kind = \"torque_change\"  b.toml:3\n  + k = \"0.01 /N/m\"         b.toml:5\n  + weight = \
         0.05           b.toml:4\n";
    assert_eq!(stdout(&output), expected);
}

/// A store in which the robot and the controller of a spec are.
fn begun(spec: &str) -> tempfile::TempDir {
    let store = tempfile::tempdir().expect("a temporary folder");
    let place = store.path().to_string_lossy().into_owned();
    let output = specforge(&["run", spec, "--profile", "quick", "--until", "controller", "--store", &place]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    store
}

/// Runs in a store, and gives the exit code and everything that was said.
fn within(store: &Path, arguments: &[&str]) -> (i32, String) {
    let output = specforge(&[arguments, &["--store", &store.to_string_lossy()]].concat());
    (code(&output), stdout(&output) + &stderr(&output))
}

#[test]
fn an_age_that_is_none_is_refused_and_one_without_end_keeps_everything() {
    let store = begun("specs/tocabi_squat_torque.toml");
    for age in ["nan", "-1", "soon"] {
        assert_eq!(within(store.path(), &["cache", "gc", "--older-than", age]).0, 2, "{age}");
    }
    for age in ["inf", "1e20", "1"] {
        let (code, told) = within(store.path(), &["cache", "gc", "--older-than", age]);
        assert!(code == 0 && told.contains("0 entries"), "{age}: {told}");
    }
    fs::write(store.path().join("journal.jsonl"), "").expect("files can be written");
    let (code, told) = within(store.path(), &["cache", "gc", "--older-than", "0", "--dry-run"]);
    assert!(code == 4 && told.contains("[E0814]"), "{told}");
    let (_, told) = within(store.path(), &["cache", "gc", "--older-than", "0", "--dry-run", "--force"]);
    assert!(told.contains("3 entries of "), "{told}");
}

#[test]
fn a_report_without_results_is_refused_and_leaves_the_page() {
    let store = begun("specs/tocabi_squat_torque.toml");
    let reports = store.path().join("reports");
    fs::create_dir(&reports).expect("a folder");
    fs::write(reports.join("tocabi_squat_torque.md"), "complete").expect("files can be written");
    let place = reports.to_string_lossy().into_owned();
    for variant in [&["--profile", "quick"][..], &[]] {
        let words = [&["report", "specs/tocabi_squat_torque.toml", "--reports", &place], variant].concat();
        let (code, told) = within(store.path(), &words);
        assert!(code == 4 && told.contains("no result of this run is in the store: "), "{told}");
        assert!(told.contains("`--profile`"), "{told}");
    }
    assert_eq!(fs::read_to_string(reports.join("tocabi_squat_torque.md")).expect("it is there"), "complete");
    assert_eq!(fs::read_dir(&reports).expect("a folder").count(), 1);
}

#[test]
fn a_saved_plan_and_a_single_spec_refuse_options_that_they_would_ignore() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plan = folder.path().join("plan.json").to_string_lossy().into_owned();
    let spec = "specs/tocabi_squat_torque.toml";
    let store = folder.path().join("store");
    assert_eq!(within(&store, &["plan", spec, "--save", &plan]).0, 0);
    assert_eq!(within(&store, &["plan", &plan]).0, 0);
    for (command, option, value) in [("plan", "--set", "learn.seed=2"), ("run", "--profile", "quick")] {
        let (code, told) = within(&store, &[command, &plan, option, value]);
        assert!(code == 2 && told.contains("is a plan"), "{told}");
    }
    let (code, told) = within(&store, &["show", spec, "--arm", "control=torque"]);
    assert!(code == 2 && told.contains("is a single spec"), "{told}");
}

/// A child of a spec of the project with other lines of its own, beside others.
fn children(specs: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let parent = root().join("specs/tocabi_squat_torque.toml");
    for (name, lines) in specs {
        let text = format!("spec = 1\nextends = {parent:?}\n{lines}");
        fs::write(folder.path().join(format!("{name}.toml")), text).expect("files can be written");
    }
    folder
}

#[test]
fn what_keeps_specs_from_being_run_together_has_a_code_and_a_place_when_checked_and_when_planned() {
    let compare = |other: &str| format!("[report]\ncompare = [\"{other}\"]\n");
    let folder = children(&[
        ("suite", ""),
        ("plain", "name = \"twin\"\n"),
        ("parent", "abstract = true\n"),
        ("of_suite", &compare("suite.toml")),
        ("of_parent", &compare("parent.toml")),
        ("of_twin", &format!("name = \"twin\"\n{}", compare("plain.toml"))),
        ("broken", "[lern]\nseed = 1\n"),
        ("of_broken", &compare("broken.toml")),
        ("of_nothing", "[deploy.policy]\nenabled = false\n"),
    ]);
    fs::write(folder.path().join("suite.toml"), "spec = 1\nsuite = \"suite\"\nextends = \"plain.toml\"\n")
        .expect("it");
    for (name, expected, file, line) in [
        ("of_suite", "E0606", "of_suite", Some(4)),
        ("of_parent", "E0606", "of_parent", Some(4)),
        ("of_twin", "E0802", "plain", Some(3)),
        ("of_broken", "E0102", "broken", Some(3)),
        ("of_nothing", "E0802", "tocabi_squat_torque", None),
    ] {
        let path = folder.path().join(format!("{name}.toml")).to_string_lossy().into_owned();
        let [planned, checked] = ["plan", "check"].map(|command| {
            let output = specforge(&[command, &path, "--allow-outside", "specs", "--format", "json"]);
            let found: serde_json::Value =
                serde_json::from_slice(&output.stdout).expect("the document is JSON");
            assert_eq!((code(&output), &found["errors"]), (3, &1.into()), "{command} {name}: {found}");
            let first = &found["diagnostics"][0];
            ["code", "file", "line"].map(|key| first[key].clone())
        });
        assert_eq!(planned, checked, "{name}");
        let [found, place, at] = planned;
        assert_eq!(found, expected, "{name}");
        let place = place.as_str().unwrap_or_default();
        assert!(name == "of_nothing" || place.ends_with(&format!("{file}.toml")), "{name}: {place}");
        assert!(at.as_u64().is_some_and(|at| line.is_none_or(|line| at == line)), "{name}: {at}");
    }
}

#[test]
fn programs_get_warnings_and_the_name_of_a_file_that_is_not_there() {
    let folder = children(&[("light", "[reward.torque]\nweight = 0\n")]);
    let path = folder.path().join("light.toml").to_string_lossy().into_owned();
    for command in ["plan", "show"] {
        let output = specforge(&[command, &path, "--allow-outside", "specs", "--format", "json"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let told: serde_json::Value = serde_json::from_str(&stderr(&output)).expect("warnings are JSON");
        assert_eq!(
            (&told["diagnostics"][0]["code"], &told["errors"]),
            (&"W0501".into(), &0.into()),
            "{told}"
        );
    }
    for command in ["check", "plan"] {
        let output = specforge(&[command, "nowhere.toml", "--format", "json"]);
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).expect("the document is JSON");
        assert_eq!(told["diagnostics"][0]["file"], "nowhere.toml", "{told}");
    }
}

#[test]
fn data_that_a_full_disk_loses_is_a_failure() {
    let full = fs::File::options().write(true).open("/dev/full").expect("the device is there");
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    let output = command.arg("list").stdout(full).output().expect("the program can be started");
    assert_eq!(code(&output), 4);
    assert!(stderr(&output).contains("standard output cannot be written"), "{}", stderr(&output));
}

#[test]
fn a_file_in_the_place_of_a_folder_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("files can be written");
    for words in [&["cache", "verify"][..], &["cache", "gc"]] {
        let (code, told) = within(&file, words);
        assert!(code == 2 && told.contains("is a file, not a store"), "{told}");
    }
    assert!(within(&file, &["doctor"]).1.contains("is a file, not a folder"));
    let place = file.to_string_lossy().into_owned();
    for command in ["run", "report"] {
        let (code, told) =
            within(folder.path(), &[command, "specs/tocabi_squat_torque.toml", "--reports", &place]);
        assert!(code == 2 && told.contains("reports cannot be written into"), "{told}");
    }
    let (code, told) = within(folder.path(), &["trace", "nothing.svg"]);
    assert!(
        code == 3
            && told.contains("E0004")
            && told.contains("nothing.svg")
            && !told.contains("Is a directory"),
        "{told}"
    );
}

#[test]
fn another_robot_is_one_difference() {
    let store = begun("specs/tocabi_squat_torque.toml");
    let (code, told) =
        within(store.path(), &["why", "specs/atlas_run_torque.toml", "atlas_run_torque/controller"]);
    assert!(code == 0 && told.contains("figures are others"), "{told}");
    assert!(told.lines().count() < 90, "{told}");
    let (_, json) =
        within(store.path(), &["why", "specs/atlas_run_torque.toml", "robot", "--format", "json"]);
    assert!(json.lines().count() > 300, "programs get every figure");
}

#[test]
fn ranges_are_those_of_the_law() {
    let ranges = |targets: &str| {
        let assignment = format!("action.targets={targets}");
        let words = [
            "show",
            "--signals",
            "--format",
            "json",
            "specs/tocabi_walk_position.toml",
            "--set",
            &assignment,
        ];
        let document: serde_json::Value = serde_json::from_str(&stdout(&specforge(&words))).expect("JSON");
        [0, 1].map(|end| document["outputs"][3]["range"][end].as_f64().expect("a bound"))
    };
    let (positions, efforts) = (ranges("joint_limits"), ranges("effort_limits"));
    assert!(efforts[0] < positions[0] && efforts[1] > positions[1], "{positions:?} {efforts:?}");
}

#[test]
fn paths_that_other_commands_print_are_explained() {
    for (path, key) in [
        ("reward.velocity_tracking.weight", "# reward.weight"),
        ("evaluate.nominal.episodes", "# evaluate.episodes.episodes"),
    ] {
        let output = specforge(&["explain", path]);
        assert!(stdout(&output).contains(key), "{path}: {}{}", stdout(&output), stderr(&output));
    }
    assert_eq!(code(&specforge(&["explain", "reward.velocity_tracking.wait"])), 2);
}

#[test]
fn the_help_says_when_a_claim_decides_the_exit_code() {
    for words in [&["--help"][..], &["run", "--help"]] {
        assert!(stdout(&specforge(words)).contains("claims = \"count\""), "{words:?}");
    }
}

/// A spec and the spec that it compares itself with take the same wrong budget from the command line.
#[test]
fn a_warning_that_the_arms_of_a_comparison_share_is_told_once() {
    let store = tempfile::tempdir().expect("a folder");
    let place = store.path().to_string_lossy().into_owned();
    let spec = "specs/tocabi_squat_torque.toml";
    let words = ["plan", spec, "--profile", "desk", "--set", "learn.samples=40k", "--store", &place];
    for (format, code) in [("human", "warning[W0508]"), ("json", "\"W0508\"")] {
        let output = specforge(&[&words[..], &["--format", format]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(told.matches(code).count(), 1, "{format}: {told}");
    }
}

#[test]
fn an_assignment_means_the_named_spec_and_reaches_only_compared_specs_with_its_key() {
    let spec = "specs/tocabi_walk_position.toml";
    let keys = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> = ["plan", spec, "--format", "json"].into_iter().chain(sets).collect();
        let output = specforge(&arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let plan: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a document");
        let stages = plan["stages"].as_array().expect("stages").clone();
        let of = |label: &str| {
            let stage = stages.iter().find(|stage| stage["name"] == label);
            stage.map(|stage| stage["key"].to_string()).expect(label)
        };
        let learners = ["tocabi_walk_position/learner", "tocabi_walk_torque/learner"].map(of);
        (learners, stderr(&output))
    };
    let ([position, torque], told) = keys(&[]);
    assert_eq!(told, "");
    let foreign = ["action.stiffness=50 %", "action.damping=30 %", "action.scale=90 %"];
    for set in foreign {
        let ([own, compared], told) = keys(&[set]);
        assert!(own != position && compared == torque, "{set}: {told}");
        assert!(told.contains(&format!("--set '{set}'")), "{told}");
        assert!(told.contains("reaches `tocabi_walk_position` and not `tocabi_walk_torque`"), "{told}");
        let output = specforge(&["check", spec, "--set", set]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    // What both have reaches both.
    let ([own, compared], told) = keys(&["learn.samples=2 M", foreign[0]]);
    assert!(own != position && compared != torque, "{told}");
    assert!(!told.contains("learn.samples"), "{told}");
    assert_eq!(keys(&["learn.samples=2 M"]).1, "");
    // A key that the named spec lacks is an error, also where the compared spec has it.
    for (spec, set) in
        [(spec, "action.stiffnes=50 %"), ("specs/tocabi_walk_torque.toml", "action.stiffness=50 %")]
    {
        let output = specforge(&["plan", spec, "--set", set]);
        assert_eq!(code(&output), 3, "{set}");
    }
    // A value that is wrong for both kinds is reported once, for the named spec.
    let output = specforge(&["plan", spec, "--set", "action.rate=300 Hz"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
}
