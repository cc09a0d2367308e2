//! `specforge new` from outside.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use specforge::scaffold::{actions, robots, tasks};

fn specforge(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command.current_dir(folder).args(arguments).output().expect("the program can be started")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ends by itself")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_new_spec_of_every_robot_task_and_action_passes_check() {
    let folder = tempfile::tempdir().expect("a folder");
    for robot in robots() {
        for task in tasks() {
            for action in actions() {
                let file = format!("{robot}_{task}_{action}.toml");
                let words = ["new", &file, "--robot", robot, "--task", task, "--action", action];
                let output = specforge(folder.path(), &words);
                assert_eq!(code(&output), 0, "{}", stderr(&output));
            }
        }
    }
    let output = specforge(folder.path(), &["check", ".", "--deny", "warnings"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("24 specs: no errors"), "{}", stderr(&output));
    assert_eq!(code(&specforge(folder.path(), &["fmt", "--check", "."])), 0);
}

#[test]
fn parents_and_schema_are_found_around_the_new_file() {
    let project = tempfile::tempdir().expect("a folder");
    let specs = project.path().join("specs");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    for folder in ["base", "base/task", "base/action", "base/budget", "schema", "mine"] {
        fs::create_dir_all(specs.join(folder)).expect("a folder");
        for entry in fs::read_dir(from.join(folder))
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.path().is_file())
        {
            fs::copy(entry.path(), specs.join(folder).join(entry.file_name())).expect("copied");
        }
    }
    for (file, base, schema) in [
        ("specs/a.toml", "base", "schema/spec-1.json"),
        ("specs/mine/b.toml", "../base", "../schema/spec-1.json"),
        ("c.toml", "specs/base", "specs/schema/spec-1.json"),
    ] {
        let output = specforge(project.path(), &["new", file, "--task", "walk"]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let text = fs::read_to_string(project.path().join(file)).expect("it was written");
        assert!(text.starts_with(&format!("#:schema {schema}\nspec ")), "{text}");
        let parents = ["task/walk", "action/torque"].map(|name| format!("\"{base}/{name}.toml\""));
        assert!(text.contains(&format!("extends = [{}]", parents.join(", "))), "{text}");
        assert_eq!(code(&specforge(project.path(), &["check", file])), 0);
    }
    // From a folder of the project, from one below it, and from outside.
    let outside = project.path().parent().expect("a parent").to_owned();
    let name = project.path().file_name().and_then(|name| name.to_str()).expect("a name");
    let from_outside = format!("{name}/specs/mine/d.toml");
    let around = format!("{name}/specs/mine/../../specs/e.toml");
    for (here, file, base) in [
        (specs.clone(), "f.toml", "base"),
        (specs.join("mine"), "g.toml", "../base"),
        (specs.join("mine"), "../h.toml", "base"),
        (specs.join("mine"), "../../i.toml", "specs/base"),
        (specs.join("base"), "../mine/j.toml", "../base"),
        (specs.clone(), "./mine/../k.toml", "base"),
        (outside.clone(), from_outside.as_str(), "../base"),
        (outside, around.as_str(), "base"),
    ] {
        let output = specforge(&here, &["new", file, "--task", "walk"]);
        assert_eq!(code(&output), 0, "{file}: {}", stderr(&output));
        let text = fs::read_to_string(here.join(file)).expect("it was written");
        assert!(text.contains(&format!("extends = [\"{base}/task/walk.toml\"")), "{file}: {text}");
        let schema = format!("#:schema {}schema/", base.strip_suffix("base").unwrap_or_default());
        assert!(text.starts_with(&schema), "{file}: {text}");
        assert_eq!(code(&specforge(&here, &["check", file])), 0, "{file}");
    }
    let output = specforge(project.path(), &["new", "specs/alone.toml", "--standalone"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let alone = fs::read_to_string(specs.join("alone.toml")).expect("it was written");
    assert!(!alone.lines().take_while(|line| !line.starts_with('[')).any(|line| line.starts_with("extends")));
}

#[test]
fn what_cannot_be_written_is_refused_with_a_cure() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("there.toml"), "mine").expect("written");
    let cases: [(&[&str], &str); 7] = [
        (&["new", "there.toml"], "`there.toml` is already there"),
        (&["new", "a.toml", "--robot", "atlass"], "did you mean `atlas`?"),
        (&["new", "a.toml", "--task", "fly"], "the tasks are `run`, `squat`, `stand` and `walk`"),
        (&["new", "a.toml", "--action", "torqe"], "did you mean `torque`?"),
        (&["new", "a.txt"], "ends in `.toml`"),
        (&["new", "nowhere/a.toml"], "there is no folder `nowhere`"),
        (&["new", "a.toml", "--extends"], "leave `--extends` out"),
    ];
    for (words, expected) in cases {
        let output = specforge(folder.path(), words);
        assert_eq!(code(&output), 2, "{words:?}");
        assert!(stderr(&output).contains(expected), "{words:?}: {}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(folder.path().join("there.toml")).expect("it is there"), "mine");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

#[test]
fn a_new_spec_says_how_it_is_tried_in_minutes() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = specforge(folder.path(), &["new", "a.toml"]);
    assert!(stderr(&output).contains("then specforge run a.toml --profile quick"), "{}", stderr(&output));
}

#[test]
fn a_robot_that_is_not_whole_gets_no_spec() {
    let folder = tempfile::tempdir().expect("a folder");
    let urdf = specforge(folder.path(), &["robot", "show", "g1", "--format", "urdf"]);
    fs::write(folder.path().join("mine.urdf"), urdf.stdout).expect("written");
    assert_eq!(code(&specforge(folder.path(), &["robot", "import", "mine.urdf"])), 0);
    let output = specforge(folder.path(), &["new", "squat.toml", "--robot", "mine", "--task", "squat"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let told = stderr(&output);
    assert!(
        told.contains("the robot cannot be used: ") && told.contains("robots/mine.toml` says what"),
        "{told}"
    );
    assert!(!folder.path().join("squat.toml").exists());
}

/// G1 under the name `mine`, whose joints with these words in their names have these limits.
fn mine(joints: &str, [lower, upper]: [&str; 2]) -> String {
    let robot =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/g1.toml")).expect("a robot");
    let robot = robot.replace("name = \"g1\"", "name = \"mine\"");
    let limited = |block: &str| {
        let lines = block.lines().map(|line| match line.split(' ').next() {
            Some("lower") => format!("lower = \"{lower}\""),
            Some("upper") => format!("upper = \"{upper}\""),
            _ => line.to_owned(),
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let blocks = robot.split("[[links]]").map(|block| match block.contains(joints) {
        true => limited(block),
        false => block.to_owned(),
    });
    blocks.collect::<Vec<_>>().join("[[links]]")
}

#[test]
fn a_robot_that_cannot_make_the_usual_motion_gets_a_smaller_one_that_it_can_make() {
    for (task, joints, limits) in [
        ("squat", "_knee_joint\"", ["0 rad", "0.62 rad"]),
        ("walk", "_knee_joint\"", ["0.2 rad", "0.62 rad"]),
        ("walk", "_hip_roll_joint\"", ["-0.05 rad", "0.05 rad"]),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("robots")).expect("made");
        fs::write(folder.path().join("robots/mine.toml"), mine(joints, limits)).expect("written");
        let words = ["new", "specs/a.toml", "--robot", "mine", "--task", task];
        fs::create_dir(folder.path().join("specs")).expect("made");
        let output = specforge(folder.path(), &words);
        assert_eq!(code(&output), 0, "{task} {joints}: {}", stderr(&output));
        let told = stderr(&output);
        assert!(told.contains("a motion in reach of its legs"), "{task} {joints}: {told}");
        let motion = folder.path().join(format!("specs/motions/mine_{task}.toml"));
        assert!(motion.exists(), "{told}");
        let spec = fs::read_to_string(folder.path().join("specs/a.toml")).expect("written");
        assert!(spec.contains(&format!("\"mine_{task}\"")), "{spec}");
        let check = specforge(folder.path(), &["check", "specs"]);
        assert_eq!(code(&check), 0, "{told}{}", stderr(&check));
        assert_eq!(code(&specforge(folder.path(), &["fmt", "--check", "specs"])), 0);
    }
}

/// The knees of the one bend too little for any squat, and for nothing else that is wrong with its file.
#[test]
fn a_new_spec_that_does_not_pass_check_is_told_with_its_error_and_not_as_a_success() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("robots")).expect("made");
    let stiff = mine("_knee_joint\"", ["0.29 rad", "0.31 rad"]);
    fs::write(folder.path().join("robots/mine.toml"), stiff).expect("written");
    let new = |file: &str, more: &[&str]| {
        let words = [&["new", file, "--robot", "mine", "--task", "squat"], more].concat();
        specforge(folder.path(), &words)
    };
    let output = new("squat.toml", &[]);
    let told = stderr(&output);
    assert_eq!(code(&output), 3, "{told}");
    assert!(
        told.contains("error[E0509]") && told.contains("help: ") && told.contains("squat.toml: written"),
        "{told}"
    );
    assert_eq!(code(&specforge(folder.path(), &["check", "squat.toml"])), 3, "as `check` does");
    let output = new("other.toml", &["--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one document");
    assert_eq!((code(&output), &json["diagnostics"][0]["code"]), (3, &"E0509".into()));
    // A suite over such a spec is no better.
    let output = specforge(folder.path(), &["new", "suite.toml", "--suite", "squat.toml"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    assert!(stderr(&output).contains("error[E0509]"), "{}", stderr(&output));
    // What the same robot can do is written as ever.
    let words = ["new", "stand.toml", "--robot", "mine", "--task", "stand"];
    assert_eq!(code(&specforge(folder.path(), &words)), 0);
}

#[test]
fn a_robot_of_ones_own_comes_from_urdf_to_a_suite_without_an_editor() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |words: &[&str]| {
        let output = specforge(folder.path(), words);
        assert_eq!(code(&output), 0, "{words:?}: {}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    fs::write(folder.path().join("mine.urdf"), run(&["robot", "show", "g1", "--format", "urdf"]))
        .expect("written");
    let fills = [
        "armature=0.02 kg*m^2",
        "stiffness_gain=100 N*m/rad",
        "damping_gain=3 N*m*s/rad",
        "default_position=0 rad",
        "hip_pitch:default_position=-0.1 rad",
        "knee:default_position=0.3 rad",
        "ankle_pitch:default_position=-0.2 rad",
    ];
    let words: Vec<&str> = ["robot", "import", "mine.urdf"]
        .into_iter()
        .chain(fills.into_iter().flat_map(|fill| ["--fill", fill]))
        .collect();
    let told = run(&words);
    assert!(told.contains("nothing is missing"), "{told}");
    let text = fs::read_to_string(folder.path().join("robots/mine.toml")).expect("it was written");
    for (value, count) in [("\"0.3 rad\"", 2), ("\"0 rad\"", 6), ("\"0.02 kg*m^2\"", 12)] {
        let given = |line: &&str| line.contains(value) && line.ends_with(" # given at the import");
        assert_eq!(text.lines().filter(given).count(), count, "{value}");
    }
    run(&["robot", "show", "mine"]);
    run(&["new", "squat.toml", "--robot", "mine", "--task", "squat"]);
    let spec = fs::read_to_string(folder.path().join("squat.toml")).expect("it was written");
    assert!(spec.contains("below = \"0.52 m\""), "{spec}");
    // Exploration and labels are relative to its weight and height, and amount to shares of its own figures.
    let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(joined(&spec).contains("low_pass = \"20 Hz\""), "{spec}");
    let resolved = run(&["show", "squat.toml", "--profile", "desk", "--resolved"]);
    for line in ["std = \"1.1 % mgh\" # 3.088 %", "mgh/rad\" # 30.97 %", "sqrt(h/g)/rad\" # 50.73 %"] {
        assert!(joined(&resolved).contains(line), "{line}: {resolved}");
    }
    run(&["new", "run.toml", "--robot", "mine", "--task", "run"]);
    let spec = fs::read_to_string(folder.path().join("run.toml")).expect("it was written");
    for line in ["action.std = \"4.8 % mgh\"", "low_pass = \"20 Hz\"", "std = \"1.2 % mgh\""] {
        assert!(joined(&spec).contains(line), "{line}: {spec}");
    }
    run(&["new", "weights.toml", "--suite", "squat.toml"]);
    run(&["check", ".", "--deny", "warnings"]);
    run(&["fmt", "--check", "squat.toml", "weights.toml", "robots"]);

    let refused = specforge(folder.path(), &["robot", "import", "mine.urdf", "--fill", "dampin=1 N*m*s/rad"]);
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("did you mean `damping`?"), "{}", stderr(&refused));
    let refused = specforge(folder.path(), &["new", "more.toml", "--suite", "absent.toml"]);
    assert_eq!(code(&refused), 2);
    assert!(stderr(&refused).contains("file not found: `absent.toml`"), "{}", stderr(&refused));
}

#[test]
fn a_suite_is_written_over_a_spec_that_can_be_varied_and_over_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |words: &[&str]| specforge(folder.path(), words);
    let spec = ["new", "one.toml", "--standalone"];
    assert_eq!(code(&run(&spec)), 0, "{}", stderr(&run(&spec)));
    let text = fs::read_to_string(folder.path().join("one.toml")).expect("it was written");
    assert_eq!(code(&run(&["new", "suite.toml", "--suite", "one.toml"])), 0);
    let parent = text.replacen("summary ", "abstract = true\nsummary ", 1);
    assert_ne!(parent, text);
    fs::write(folder.path().join("parent.toml"), parent).expect("written");
    fs::write(folder.path().join("broken.toml"), text.replacen("\"torque\"", "\"torqe\"", 1))
        .expect("written");
    let child = "spec = 1\nname = \"bare\"\nextends = \"one.toml\"\n[reward.torque]\nenabled = false\n";
    fs::write(folder.path().join("bare.toml"), child).expect("written");
    for (over, exit, words) in [
        ("suite.toml", 2, "`suite.toml` is a suite"),
        ("parent.toml", 2, "`parent.toml` is abstract"),
        ("broken.toml", 3, "`other.toml` is not written"),
    ] {
        let output = run(&["new", "other.toml", "--suite", over]);
        assert_eq!(code(&output), exit, "{over}: {}", stderr(&output));
        assert!(stderr(&output).contains(words) && stderr(&output).contains("help: "), "{}", stderr(&output));
        assert!(!folder.path().join("other.toml").exists(), "{over}");
    }
    // Whatever is written passes the check.
    let output = run(&["new", "weights.toml", "--suite", "bare.toml"]);
    let is_there = folder.path().join("weights.toml").exists();
    assert_eq!(is_there, code(&output) == 0, "{}", stderr(&output));
    let output = run(&["new", "other.toml", "--suite", "broken.toml", "--format", "json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one document");
    assert!(answer["errors"].as_u64() > Some(0), "{answer}");
}

#[test]
fn a_copy_of_a_shipped_robot_under_another_name_is_judged_like_the_original() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("robots")).expect("made");
    for robot in robots() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{robot}.toml"));
        let text = fs::read_to_string(file).expect("a robot");
        let copy = text.replace(&format!("name = \"{robot}\""), &format!("name = \"my_{robot}\""));
        let copy = format!("# My own.\n{}", copy.replace("licence = ", "licence   = "));
        fs::write(folder.path().join(format!("robots/my_{robot}.toml")), copy).expect("written");
        for task in tasks() {
            let file = format!("{robot}_{task}.toml");
            assert_eq!(code(&specforge(folder.path(), &["new", &file, "--robot", robot, "--task", task])), 0);
            let spec = fs::read_to_string(folder.path().join(&file)).expect("written");
            let own = spec.replace(&format!("model = \"{robot}\""), &format!("model = \"my_{robot}\""));
            assert_ne!(own, spec);
            fs::write(folder.path().join(format!("my_{file}")), own).expect("written");
        }
    }
    let output = specforge(folder.path(), &["check", ".", "--deny", "warnings"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}
