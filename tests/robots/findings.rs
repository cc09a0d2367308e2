//! What an import says of a robot is what `robot show` says of its file, with the cause and a fix that works.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::{CRANE, code, import, specforge, told};

/// The words after which a file is whole and usable.
const PASSES: &str = "nothing is missing";

fn codes(text: &str) -> BTreeSet<String> {
    let marks = text.match_indices('[').map(|(at, _)| &text[at + 1..]);
    let code = |rest: &str| {
        let (word, _) = rest.split_once(']')?;
        let (letter, digits) = word.split_at_checked(1)?;
        (matches!(letter, "E" | "W") && digits.len() == 4 && digits.parse::<u32>().is_ok())
            .then(|| word.to_owned())
    };
    marks.filter_map(code).collect()
}

fn show(folder: &Path) -> std::process::Output {
    specforge(folder, &["robot", "show", "crane"])
}

#[test]
fn an_import_says_nothing_is_missing_where_robot_show_passes_and_all_that_it_finds_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let plain = CRANE.to_owned();
    let boxed = |size: &str| CRANE.replace("0.18 0.22 0.3", size);
    let cases: [(&str, String, &[&str]); 14] = [
        ("plain", plain.clone(), &[]),
        ("a knee beyond its limit", plain.clone(), &["left_knee:default_position=3 rad"]),
        ("hips beyond their limits", plain.clone(), &["hip:default_position=-3.3 rad"]),
        ("all joints beyond", plain.clone(), &["default_position=9 rad"]),
        ("no gains", plain.clone(), &["stiffness_gain=0 N*m/rad", "damping_gain=0 N*m*s/rad"]),
        ("one gain", plain.clone(), &["right_ankle:stiffness_gain=0 N*m/rad"]),
        ("a negative gain", plain.clone(), &["knee:damping_gain=-1 N*m*s/rad"]),
        ("no rotor", plain.clone(), &["armature=-0.1 kg*m^2"]),
        ("a hip unlike the other", plain.clone(), &["left_hip:default_position=-0.2 rad"]),
        ("a leg longer than the other", CRANE.replacen("0 0 -0.27", "0 0 -0.29", 1), &[]),
        ("a hip beside the other", CRANE.replacen("0 0.09 0", "0.05 0.09 0", 1), &[]),
        ("a trunk of a millimetre", boxed("1e-3 1e-3 1e-3"), &[]),
        ("a trunk of a kilometre", boxed("1000 1000 1000"), &[]),
        (
            "a knee that bends the other way",
            CRANE.replacen("lower=\"0\" upper=\"2.2\"", "lower=\"-2.2\" upper=\"0\"", 1),
            &[],
        ),
    ];
    for (name, urdf, fills) in cases {
        let imported = import(folder.path(), &urdf, fills);
        let (said, shown) = (told(&imported), show(folder.path()));
        assert_eq!(code(&imported), code(&shown), "{name}: {said}");
        assert_eq!(said.contains(PASSES), code(&shown) == 0, "{name}: {said}");
        let mut found = codes(&said);
        // Of fills and of the source.
        found.remove("W0420");
        assert_eq!(found, codes(&told(&shown)), "{name}: {said}");
    }
}

#[test]
fn what_is_known_of_a_robot_with_lines_to_fill_in_is_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("crane.urdf"), CRANE).expect("written");
    for (fills, expected) in [
        (["knee:default_position=3 rad", "hip:default_position=0 rad"], "[E0406]"),
        (["armature=-1 kg*m^2", "hip:default_position=0 rad"], "[E0405]"),
    ] {
        let _ = fs::remove_dir_all(folder.path().join("robots"));
        let words = ["robot", "import", "crane.urdf", "--fill", fills[0], "--fill", fills[1]];
        let said = told(&specforge(folder.path(), &words));
        assert!(said.contains(expected) && !said.contains(PASSES), "{said}");
    }
}

#[test]
fn a_pose_beyond_the_limits_turns_no_frame_and_exchanges_no_feet() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = || fs::read_to_string(folder.path().join("robots/crane.toml")).expect("written");
    let frames = |text: &str| -> Vec<String> {
        let kept = |line: &&str| !line.starts_with('#') && !line.starts_with("default_position");
        text.lines().filter(kept).map(str::to_owned).collect()
    };
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    let plain = frames(&file());
    for fills in [
        ["hip:default_position=-3.3 rad"].as_slice(),
        &["hip:default_position=3.1416 rad"],
        &["left_knee:default_position=3 rad"],
        &["ankle:default_position=1.5708 rad"],
        &["hip:default_position=1.5708 rad", "knee:default_position=-1.5708 rad"],
    ] {
        let said = told(&import(folder.path(), CRANE, fills));
        assert!(said.contains("error[E0406]") && said.contains("all joints at zero"), "{said}");
        assert!(!said.contains("E0420") && !said.contains("was turned"), "{said}");
        assert_eq!(frames(&file()), plain, "{fills:?}");
    }
}

#[test]
fn position_control_needs_a_gain_at_every_joint() {
    let folder = tempfile::tempdir().expect("a folder");
    let zero = ["stiffness_gain=0 N*m/rad", "damping_gain=0 N*m*s/rad"];
    let ankle = ["left_ankle:stiffness_gain=0 N*m/rad"];
    for (fills, names) in [(zero.as_slice(), "all 6 joints"), (&ankle, "`left_ankle`")] {
        assert_eq!(code(&import(folder.path(), CRANE, fills)), 0);
        let shown = show(folder.path());
        assert!(code(&shown) == 0 && told(&shown).contains("warning[W0424]"), "{}", told(&shown));
        for (action, expected) in [("position", 3), ("torque", 0)] {
            let file = format!("{action}.toml");
            let _ = fs::remove_file(folder.path().join(&file));
            let words = ["new", &file, "--robot", "crane", "--task", "stand", "--action", action];
            let made = specforge(folder.path(), &words);
            let checked = specforge(folder.path(), &["check", &file]);
            assert_eq!([code(&made), code(&checked)], [expected; 2], "{}", told(&checked));
            assert_eq!(told(&checked).contains("error[E0511]"), expected == 3, "{}", told(&checked));
            assert!(expected == 0 || told(&checked).contains(names), "{}", told(&checked));
        }
    }
    // A gain that is not zero, and with which no target holds the robot.
    assert_eq!(code(&import(folder.path(), CRANE, &["stiffness_gain=1e-3 N*m/rad"])), 0);
    let soft = specforge(folder.path(), &["check", "position.toml", "--profile", "paper"]);
    assert!(code(&soft) == 0, "{}", told(&soft));
    assert!(
        told(&soft).contains("warning[W0424]") && told(&soft).contains("warning[W0513]"),
        "{}",
        told(&soft)
    );
}

/// The positions that a help says to write, by joint.
fn advised(said: &str) -> Vec<(String, String)> {
    let help = said.lines().filter(|line| line.trim_start().starts_with("help:"));
    let pieces: Vec<&str> = help.flat_map(|line| line.split("`default_position = \"")).skip(1).collect();
    let read = |piece: &&str| {
        let (position, rest) = piece.split_once('"')?;
        let joint = rest.split_once("for joint `")?.1.split_once('`')?.0;
        Some((joint.to_owned(), position.to_owned()))
    };
    pieces.iter().filter_map(read).collect()
}

#[test]
fn a_pose_whose_sides_differ_is_told_with_the_joints_that_differ_and_the_fix_works() {
    let folder = tempfile::tempdir().expect("a folder");
    for (fills, joints) in [
        (["left_hip:default_position=-0.2 rad"].as_slice(), ["left_hip"].as_slice()),
        (&["right_hip:default_position=-0.2 rad"], &["right_hip"]),
        (&["left_knee:default_position=0.5 rad"], &["left_knee"]),
        (&["right_ankle:default_position=-0.25 rad"], &["right_ankle"]),
        (
            &["left_hip:default_position=-0.2 rad", "left_knee:default_position=0.5 rad"],
            &["left_hip", "left_knee"],
        ),
        (
            // Each leg is level by itself, and one sole is higher.
            &[
                "left_hip:default_position=-0.5 rad",
                "left_knee:default_position=1 rad",
                "left_ankle:default_position=-0.5 rad",
            ],
            &["left_hip", "left_knee", "left_ankle"],
        ),
    ] {
        let said = told(&import(folder.path(), CRANE, fills));
        assert!(said.contains("error[E0420]") && said.contains("do not mirror each other"), "{said}");
        let changes = advised(&said);
        for joint in joints {
            assert!(said.contains(&format!("`{joint}` ")), "{joint}: {said}");
        }
        assert_eq!(changes.len(), joints.len(), "{changes:?}: {said}");
        let more: Vec<String> =
            changes.iter().map(|(joint, position)| format!("{joint}:default_position={position}")).collect();
        let all: Vec<&str> = fills.iter().copied().chain(more.iter().map(String::as_str)).collect();
        let fixed = told(&import(folder.path(), CRANE, &all));
        assert!(!fixed.contains("findings:"), "{fills:?}: {fixed}");
    }
    // Both legs are off and unlike: the two steps that are named level both.
    let fills = ["left_hip:default_position=-0.2 rad", "right_knee:default_position=0.5 rad"];
    let said = told(&import(folder.path(), CRANE, &fills));
    assert!(said.contains("so that both legs are alike; then write"), "{said}");
    let mut more: Vec<String> = Vec::new();
    for (joint, position) in advised(&said) {
        more.push(format!("{joint}:default_position={position}"));
        if joint.ends_with("ankle") {
            more.push(format!("ankle:default_position={position}"));
        }
    }
    let all: Vec<&str> = fills.iter().copied().chain(more.iter().map(String::as_str)).collect();
    let fixed = told(&import(folder.path(), CRANE, &all));
    assert!(!fixed.contains("findings:"), "{fixed}");
}

#[test]
fn a_foot_that_is_turned_alone_is_no_matter_of_positions() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    let path = folder.path().join("robots/crane.toml");
    let text = fs::read_to_string(&path).expect("written");
    // The last joint is the right ankle: its frame leans by 0.1 rad.
    let at = text.rfind("origin = ").expect("an origin");
    fs::write(
        &path,
        format!("{}rotation = [\"0 rad\", \"0.1 rad\", \"0 rad\"]\n{}", &text[..at], &text[at..]),
    )
    .expect("written");
    let said = told(&show(folder.path()));
    assert!(said.contains("the frame of `right_foot` is turned against that of `left_foot`"), "{said}");
}

#[test]
fn a_file_that_is_no_robot_is_named_with_the_robot_that_is_meant() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(code(&import(folder.path(), CRANE, &[])), 0);
    let made = specforge(folder.path(), &["new", "squat.toml", "--robot", "crane", "--task", "squat"]);
    assert_eq!(code(&made), 0, "{}", told(&made));
    let made = specforge(folder.path(), &["new", "two.toml", "--suite", "squat.toml"]);
    assert_eq!(code(&made), 0, "{}", told(&made));
    fs::write(folder.path().join("gait.toml"), "kind = \"walk\"\n").expect("written");
    fs::write(folder.path().join("lost.toml"), "spec = 1\n").expect("written");
    for (file, what, advice) in [
        (
            "squat.toml",
            "is a spec, not the file of a robot",
            "its robot is `crane`: `specforge robot show robots/crane.toml`",
        ),
        ("two.toml", "is a suite, not", "its robot is `crane`"),
        ("gait.toml", "is a reference motion, not", "`crane`"),
        ("lost.toml", "is a spec, not", "`[robot]` names the robot"),
        ("crane.urdf", "there is no robot `crane.urdf`", "`specforge robot import crane.urdf`"),
        ("Crane", "there is no robot `Crane`", "did you mean `crane`?"),
        ("nothing", "there is no robot `nothing`", "`crane`"),
    ] {
        let output = specforge(folder.path(), &["robot", "show", file]);
        let said = told(&output);
        assert!(code(&output) == 2 && said.contains(what) && said.contains(advice), "{file}: {said}");
        assert!(said.lines().count() == 2, "{file}: {said}");
    }
}

#[test]
fn the_next_command_of_new_can_be_pasted() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("my specs")).expect("made");
    for (file, shown) in
        [("-x.toml", "./-x.toml"), ("--y.toml", "./--y.toml"), ("my specs/a.toml", "'my specs/a.toml'")]
    {
        let made = specforge(folder.path(), &["new", "--", file]);
        let said = told(&made);
        assert!(code(&made) == 0 && said.contains(&format!("next: specforge check {shown}, then")), "{said}");
        let command = said.split("next: specforge ").nth(1).and_then(|rest| rest.split(", then").next());
        let words = shlex::split(command.expect("a command")).expect("words");
        let checked = specforge(folder.path(), &words.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(code(&checked), 0, "{}", told(&checked));
    }
}

#[test]
fn the_folder_to_read_from_is_no_body_and_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("crane.urdf"), CRANE).expect("written");
    for root in ["left_thigh", "left_foot", "TRUNK", "nothing", "crane.urdf"] {
        let output = specforge(folder.path(), &["robot", "import", "crane.urdf", "--root", root]);
        let said = told(&output);
        assert!(code(&output) == 2 && said.contains(&format!("--root `{root}`: ")), "{said}");
        assert!(said.contains("--root names the folder from which meshes"), "{said}");
        assert!(!folder.path().join("robots").exists(), "{root}");
    }
}

#[test]
fn figures_with_which_nothing_can_be_computed_are_named_at_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to, expected) in [
        ("mass value=\"9\"", "mass value=\"1e308\"", "error[E0424]: the mass of `trunk` is 1e308 kg"),
        ("mass value=\"1.6\"", "mass value=\"1e9\"", "error[E0424]: the mass of `left_thigh` is 1e9 kg"),
        ("ixx=\"0.11\"", "ixx=\"1e308\"", "error[E0424]: the inertia of `trunk` is 1e308 kg m^2"),
        (
            "xyz=\"0 0 0.15\"",
            "xyz=\"0 0 1e200\"",
            "error[E0424]: the centre of mass of `trunk` is 1e200 m away",
        ),
        ("xyz=\"0 0.09 0\"", "xyz=\"0 1e200 0\"", "error[E0424]: `left_thigh` is 1e200 m away"),
    ] {
        let output = import(folder.path(), &CRANE.replace(from, to), &[]);
        let said = told(&output);
        assert!(code(&output) == 3 && said.contains(expected), "{to}: {said}");
        assert!(said.contains("--> crane.urdf:") && !said.contains("no inertia"), "{to}: {said}");
    }
}

#[test]
fn a_file_without_a_joint_that_turns_lists_what_it_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let fixed = told(&import(folder.path(), &CRANE.replace("revolute", "fixed"), &[]));
    assert!(fixed.contains("the file has no joint: all its bodies are fixed to each other"), "{fixed}");
    assert!(!fixed.contains("the joints of the file are"), "{fixed}");
    let sliding = told(&import(folder.path(), &CRANE.replace("revolute", "prismatic"), &[]));
    assert!(
        sliding.contains("no revolute joint") && sliding.contains("`left_hip` (prismatic), "),
        "{sliding}"
    );
}
