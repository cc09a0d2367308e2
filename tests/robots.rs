//! What the checks of a robot find is told by every command that uses it: figures in wrong units, and robots
//! that cannot stand.

#[path = "robots/findings.rs"]
mod findings;

use std::fs;
use std::path::Path;
use std::process::Output;

const CRANE: &str = include_str!("robots/crane.urdf");

/// What the description does not say; the pose is a knee-bent stand.
const FILLS: [&str; 7] = [
    "armature=0.02 kg*m^2",
    "velocity_limit=14 rad/s",
    "stiffness_gain=250 N*m/rad",
    "damping_gain=5 N*m*s/rad",
    "hip:default_position=-0.3 rad",
    "knee:default_position=0.6 rad",
    "ankle:default_position=-0.3 rad",
];

fn specforge(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = assert_cmd::Command::cargo_bin("specforge").expect("the program was built");
    command.current_dir(folder).args(arguments).output().expect("it runs")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it ended by itself")
}

fn told(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Imports a description with everything filled in, the last of several fills for a figure counts.
fn import(folder: &Path, urdf: &str, fills: &[&str]) -> Output {
    fs::write(folder.join("crane.urdf"), urdf).expect("written");
    let _ = fs::remove_file(folder.join("robots/crane.toml"));
    let mut arguments = vec!["robot", "import", "crane.urdf"];
    FILLS.iter().chain(fills).for_each(|fill| arguments.extend(["--fill", fill]));
    specforge(folder, &arguments)
}

/// Every number of an attribute, times a factor.
fn times(text: &str, attribute: &str, factor: f64) -> String {
    let mark = format!(" {attribute}=\"");
    let mut pieces = text.split(&mark);
    let mut result = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (numbers, rest) = piece.split_once('"').expect("an attribute ends");
        let number = |word: &str| (word.parse::<f64>().expect("a number") * factor).to_string();
        let numbers: Vec<String> = numbers.split_whitespace().map(number).collect();
        result += &format!("{mark}{}\"{rest}", numbers.join(" "));
    }
    result
}

#[test]
fn a_robot_in_its_own_units_is_quiet_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let imported = import(folder.path(), CRANE, &[]);
    assert!(code(&imported) == 0 && !told(&imported).contains("findings:"), "{}", told(&imported));
    let shown = specforge(folder.path(), &["robot", "show", "crane"]);
    assert!(
        code(&shown) == 0 && !told(&shown).contains("FAIL") && !told(&shown).contains("warn"),
        "{}",
        told(&shown)
    );
    let new = specforge(folder.path(), &["new", "squat.toml", "--robot", "crane", "--task", "squat"]);
    assert_eq!(code(&new), 0, "{}", told(&new));
    let checked = specforge(folder.path(), &["check", "squat.toml"]);
    assert!(code(&checked) == 0 && told(&checked).contains("no errors, no warnings"), "{}", told(&checked));
}

#[test]
fn figures_in_other_units_are_told_at_the_import_in_show_and_in_check() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    assert_eq!(
        code(&specforge(folder.path(), &["new", "squat.toml", "--robot", "crane", "--task", "squat"])),
        0
    );
    let inertia =
        |factor| ["ixx", "iyy", "izz"].iter().fold(CRANE.to_owned(), |text, key| times(&text, key, factor));
    let of_trunk = |factor: f64| {
        let (trunk, rest) = CRANE.split_once("</link>").expect("the first link");
        ["ixx", "iyy", "izz"].iter().fold(trunk.to_owned(), |text, key| times(&text, key, factor))
            + "</link>"
            + rest
    };
    let millimetres = times(&times(CRANE, "xyz", 1e3), "size", 1e3);
    // Axes are directions, however long.
    for (name, urdf, expected) in [
        ("the trunk in kg mm^2", of_trunk(1e6), "W0410"),
        ("the trunk in t m^2", of_trunk(1e-6), "W0410"),
        ("all inertias in kg cm^2", inertia(1e4), "W0410"),
        ("all inertias a thousandth", inertia(1e-3), "W0410"),
        ("masses in grams", times(CRANE, "value", 1e3), "W0411"),
        ("lengths in millimetres", millimetres, "E0424"),
        ("shapes in centimetres", times(CRANE, "size", 1e2), "W0412"),
        ("a centre of mass 60 m away", CRANE.replacen("0 0 0.15", "0 0 60", 1), "W0413"),
        ("efforts of a viewer", CRANE.replace("effort=\"60\"", "effort=\"1000\""), "W0414"),
        ("one knee weaker than the other", CRANE.replacen("effort=\"60\"", "effort=\"25\"", 1), "W0417"),
        ("one leg faster than the other", CRANE.replacen("damping=\"0.2\"", "damping=\"2\"", 1), "W0417"),
        ("an endless effort", CRANE.replace("effort=\"60\"", "effort=\"1e300\""), "E0424"),
        ("an endless damping", CRANE.replace("damping=\"0.2\"", "damping=\"1e300\""), "E0424"),
        ("an endless friction", CRANE.replace("friction=\"0.1\"", "friction=\"1e300\""), "E0424"),
        ("a friction beyond the motor", CRANE.replace("friction=\"0.1\"", "friction=\"70\""), "E0425"),
        ("a servo's gain as damping", CRANE.replace("damping=\"0.2\"", "damping=\"90\""), "W0415"),
    ] {
        let imported = import(folder.path(), &urdf, &[]);
        assert!(told(&imported).contains(&format!("[{expected}]")), "{name}: {}", told(&imported));
        assert!(told(&imported).contains("    help: "), "{name}: {}", told(&imported));
        let failure = if expected.starts_with('E') { 3 } else { 0 };
        for arguments in [["robot", "show", "crane"].as_slice(), &["check", "squat.toml"]] {
            let output = specforge(folder.path(), arguments);
            assert!(
                told(&output).contains(&format!("[{expected}]")),
                "{name}, {arguments:?}: {}",
                told(&output)
            );
            assert!(
                code(&output) == failure || told(&output).contains("error["),
                "{name}, {arguments:?}: {}",
                code(&output)
            );
        }
    }
    let endless = import(folder.path(), CRANE, &["armature=1e300 kg*m^2"]);
    assert!(told(&endless).contains("[E0424]"), "{}", told(&endless));
}

#[test]
fn a_link_to_nothing_and_a_folder_are_no_robots() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    let robots = folder.path().join("robots");
    std::os::unix::fs::symlink("nowhere.toml", robots.join("ghost.toml")).expect("a link");
    std::os::unix::fs::symlink("crane.toml", robots.join("heron.toml")).expect("a link");
    fs::create_dir(robots.join("attic.toml")).expect("a folder");
    let listed = told(&specforge(folder.path(), &["list", "robots"]));
    assert!(listed.contains("crane") && listed.contains("heron"), "{listed}");
    assert!(!listed.contains("ghost") && !listed.contains("attic"), "{listed}");
    let new = told(&specforge(folder.path(), &["new", "walk.toml", "--robot", "gost"]));
    assert!(!new.contains("ghost"), "{new}");
}

#[test]
fn a_robot_that_cannot_stand_is_refused_by_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    for (file, task) in [("squat.toml", "squat"), ("stand.toml", "stand")] {
        let new = specforge(folder.path(), &["new", file, "--robot", "crane", "--task", task]);
        assert_eq!(code(&new), 0, "{}", told(&new));
    }
    let suite = specforge(folder.path(), &["new", "suite.toml", "--suite", "squat.toml"]);
    assert_eq!(code(&suite), 0, "{}", told(&suite));
    let wide = CRANE.replace("0.2 0.09 0.02", "0.2 0.19 0.02");
    let ball = "<collision><origin xyz=\"0 0 -0.5\"/><geometry><sphere \
        radius=\"0.3\"/></geometry></collision>\n  </link>";
    for (name, urdf, fills, expected) in [
        ("tilted soles", CRANE.to_owned(), ["ankle:default_position=-0.2 rad"].as_slice(), "E0420"),
        ("one sole lower", CRANE.replacen("0.03 0 -0.045", "0.03 0 -0.055", 1), &[], "E0420"),
        ("a centre of mass in front", CRANE.replacen("0 0 0.15", "0.4 0 0.15", 1), &[], "E0421"),
        (
            "a leaning pose",
            CRANE.to_owned(),
            &["hip:default_position=0.3 rad", "ankle:default_position=-0.9 rad"],
            "E0421",
        ),
        ("a trunk below the ground", CRANE.replacen("</link>", ball, 1), &[], "E0422"),
        ("feet inside each other", wide, &[], "E0423"),
        ("motors of toys", CRANE.replace("effort=\"60\"", "effort=\"0.6\""), &[], "E0428"),
    ] {
        let imported = import(folder.path(), &urdf, fills);
        let mark = format!("error[{expected}]");
        assert!(code(&imported) == 3 && told(&imported).contains(&mark), "{name}: {}", told(&imported));
        let few: [&[&str]; 2] = [&["robot", "show", "crane"], &["check", "squat.toml"]];
        let more: [&[&str]; 6] = [
            &["check", "suite.toml"],
            &["plan", "stand.toml"],
            &["plan", "suite.toml"],
            &["run", "stand.toml", "--dry-run"],
            &["why", "stand.toml", "learner"],
            &["bench", "stand.toml"],
        ];
        // One finding is enough to see that a command reads them.
        let all = few.into_iter().chain(more.into_iter().filter(|_| expected == "E0421"));
        for arguments in all {
            let output = specforge(folder.path(), arguments);
            assert!(
                code(&output) == 3 && told(&output).contains(&mark),
                "{name}, {arguments:?}: {}",
                told(&output)
            );
        }
        let new = specforge(folder.path(), &["new", "other.toml", "--robot", "crane", "--task", "stand"]);
        assert!(code(&new) == 3 && told(&new).contains(&format!("[{expected}]")), "{name}: {}", told(&new));
        assert!(!folder.path().join("other.toml").exists());
        let json = specforge(folder.path(), &["robot", "show", "crane", "--format", "json"]);
        assert_eq!(code(&json), 3, "{name}");
        let summary: serde_json::Value = serde_json::from_slice(&json.stdout).expect("one document");
        let checks = summary["checks"].as_array().expect("checks");
        let failed: Vec<_> = checks.iter().filter(|check| check["passed"] == false).collect();
        assert!(failed.iter().any(|check| check["findings"][0]["code"] == expected), "{name}: {failed:?}");
    }
}

#[test]
fn feet_that_a_robot_file_exchanges_are_told_with_the_cause_and_the_fix() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    // The crane's walk has errors of its own, and is written all the same.
    for (task, expected) in [("squat", 0), ("walk", 3)] {
        let file = format!("{task}.toml");
        let made = specforge(folder.path(), &["new", &file, "--robot", "crane", "--task", task]);
        assert_eq!(code(&made), expected, "{}", told(&made));
    }
    let path = folder.path().join("robots/crane.toml");
    let text = fs::read_to_string(&path).expect("written");
    let exchanged = text.replace("[feet.left]", "[feet.x]").replace("[feet.right]", "[feet.left]");
    fs::write(&path, exchanged.replace("[feet.x]", "[feet.right]")).expect("written");
    for arguments in
        [["robot", "show", "crane"].as_slice(), &["check", "squat.toml"], &["check", "walk.toml"]]
    {
        let output = specforge(folder.path(), arguments);
        assert!(
            code(&output) == 3 && told(&output).contains("error[E0426]"),
            "{arguments:?}: {}",
            told(&output)
        );
        assert!(told(&output).contains("in [feet.left] and `link = "), "{arguments:?}: {}", told(&output));
    }
    // A base turned by a quarter: the legs lie one behind the other, and each would be its own image.
    fs::write(
        &path,
        text.replace("[\"0 m\", \"0.09 m\", \"0 m\"]", "[\"0.09 m\", \"0 m\", \"0 m\"]")
            .replace("[\"0 m\", \"-0.09 m\", \"0 m\"]", "[\"-0.09 m\", \"0 m\", \"0 m\"]"),
    )
    .expect("written");
    let aside = specforge(folder.path(), &["robot", "show", "crane"]);
    assert!(code(&aside) == 3 && told(&aside).contains("y does not point to the left"), "{}", told(&aside));
}

#[test]
fn the_fix_that_is_printed_levels_the_soles() {
    let folder = tempfile::tempdir().expect("a folder");
    let imported = told(&import(folder.path(), CRANE, &["ankle:default_position=-0.2 rad"]));
    let line =
        imported.lines().find(|line| line.contains("help: write `default_position")).expect("a position");
    let position = line.split('"').nth(1).expect("in quotes");
    let fixed = import(folder.path(), CRANE, &[&format!("ankle:default_position={position}")]);
    assert!(!told(&fixed).contains("findings:"), "{}", told(&fixed));
}

#[test]
fn a_warning_about_the_robot_stands_in_every_spec_and_can_be_allowed() {
    let folder = tempfile::tempdir().expect("a folder");
    let urdf = CRANE.replace("effort=\"60\"", "effort=\"1000\"");
    assert_eq!(code(&import(folder.path(), &urdf, &[])), 0);
    for file in ["a.toml", "b.toml"] {
        let new = specforge(folder.path(), &["new", file, "--robot", "crane", "--task", "squat"]);
        assert!(code(&new) == 0 && told(&new).contains("[W0414]"), "{}", told(&new));
    }
    for arguments in [["check", "a.toml", "--deny", "warnings"], ["check", "b.toml", "--deny", "warnings"]] {
        assert_eq!(code(&specforge(folder.path(), &arguments)), 3);
    }
    let text = fs::read_to_string(folder.path().join("a.toml")).expect("written");
    fs::write(folder.path().join("a.toml"), text + "\n[allow]\nW0414 = \"nobody knows the motor\"\n")
        .expect("written");
    let allowed = specforge(folder.path(), &["check", "a.toml", "--deny", "warnings"]);
    assert_eq!(code(&allowed), 0, "{}", told(&allowed));
}

#[test]
fn a_projects_robot_is_listed_and_one_that_replaces_a_shipped_robot_is_told_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    let listed = told(&specforge(folder.path(), &["list", "robots"]));
    assert!(listed.contains("crane") && listed.contains("[robots/crane.toml]"), "{listed}");
    assert!(listed.contains("atlas") && !listed.contains("replaces"), "{listed}");
    // A copy of the shipped file replaces nothing.
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/g1.toml");
    let own = folder.path().join("robots/g1.toml");
    fs::copy(&shipped, &own).expect("copied");
    assert!(!told(&specforge(folder.path(), &["list", "robots"])).contains("replaces"));
    assert!(!told(&specforge(folder.path(), &["robot", "show", "g1"])).contains("W0421"));
    fs::remove_file(&own).expect("it is there");
    let mut arguments = vec!["robot", "import", "crane.urdf", "--name", "g1"];
    FILLS.iter().for_each(|fill| arguments.extend(["--fill", fill]));
    let imported = specforge(folder.path(), &arguments);
    let text = told(&imported);
    assert!(code(&imported) == 0 && text.contains("warning[W0421]") && text.contains("--name"), "{text}");
    let replaced = "`robots/g1.toml` replaces the built-in robot `g1`";
    let shown = specforge(folder.path(), &["robot", "show", "g1"]);
    assert!(code(&shown) == 0 && told(&shown).contains(replaced), "{}", told(&shown));
    let listed = told(&specforge(folder.path(), &["list", "robots"]));
    assert!(
        listed.contains("[robots/g1.toml, which replaces the robot that comes with specforge]"),
        "{listed}"
    );
    let json = specforge(folder.path(), &["list", "robots", "--format", "json"]);
    let rows: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    let of = |name: &str| {
        let row =
            rows.as_array().expect("rows").iter().find(|row| row["name"] == name).expect("it is listed");
        (row["shipped"].as_bool(), row["replaces_shipped"].as_bool())
    };
    assert_eq!(
        [of("g1"), of("atlas"), of("crane")],
        [(Some(false), Some(true)), (Some(true), None), (Some(false), Some(false))]
    );
    let new = specforge(folder.path(), &["new", "squat.toml", "--robot", "g1", "--task", "squat"]);
    assert_eq!(code(&new), 0, "{}", told(&new));
    let checked = specforge(folder.path(), &["check", "squat.toml"]);
    assert!(code(&checked) == 0 && told(&checked).contains(replaced), "{}", told(&checked));
    let spec = fs::read_to_string(folder.path().join("squat.toml")).expect("written");
    let allowed = format!("{spec}\n[allow]\nW0421 = \"our G1 is another one\"\n");
    fs::write(folder.path().join("squat.toml"), allowed).expect("written");
    let checked = specforge(folder.path(), &["check", "squat.toml"]);
    assert!(!told(&checked).contains("W0421"), "{}", told(&checked));
}

#[test]
fn a_projects_motion_is_listed_and_one_that_replaces_a_shipped_motion_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let motions = folder.path().join("specs/motions");
    fs::create_dir_all(&motions).expect("a folder");
    fs::create_dir_all(folder.path().join("robots")).expect("a folder");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/motions/squat.toml");
    let text = fs::read_to_string(shipped).expect("it is shipped");
    fs::write(motions.join("squat.toml"), format!("# A deeper one.\n{text}")).expect("written");
    fs::write(motions.join("crouch.toml"), &text).expect("written");
    let listed = told(&specforge(folder.path(), &["list", "motions"]));
    let place = "[specs/motions/squat.toml, which replaces the motion that comes with specforge]";
    assert!(listed.contains(place) && listed.contains("[specs/motions/crouch.toml]"), "{listed}");
    let new = specforge(folder.path(), &["new", "squat.toml", "--robot", "tocabi", "--task", "squat"]);
    assert_eq!(code(&new), 0, "{}", told(&new));
    let checked = told(&specforge(folder.path(), &["check", "squat.toml"]));
    assert!(checked.contains("W0421") && checked.contains("the built-in motion `squat`"), "{checked}");
}
