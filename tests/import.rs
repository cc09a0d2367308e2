//! Robots from other programs' files: what comes in is what went out, and nothing is invented.

#[path = "import/dropped.rs"]
mod dropped;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use specforge::diag::render::{Look, human};
use specforge::diag::{Sink, Sources};
use specforge::robot::import::{self, Folder, Origin, Selection, Welded};
use specforge::robot::model::Body;
use specforge::robot::{self, Joint, Robot, Shape};

fn load(name: &str, text: &str) -> Robot {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(Path::new("robot.toml"), text.to_owned());
    let robot = robot::load(name, &sources, source, &mut sink);
    robot.unwrap_or_else(|| panic!("{:?}", sink.diagnostics))
}

fn shipped(name: &str) -> Robot {
    load(name, robot::embedded(name).expect("it is shipped"))
}

fn welded(file: &Path, selection: &Selection) -> Welded {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let folder = Folder::around(file).expect("the file has a folder");
    let tree = import::read(file, &folder, &mut sources, &mut sink);
    let welded = tree.and_then(|tree| import::weld(&tree, selection, &mut sink));
    welded.unwrap_or_else(|| panic!("{}", human(&sources, &sink.diagnostics, Look::default())))
}

fn imported(file: &Path, selection: &Selection) -> (String, Vec<String>) {
    let written = import::text(
        &welded(file, selection),
        &Origin { name: "copy", source: "source", format: "XML", fills: &[] },
    );
    (written.text, written.missing)
}

/// Fills in the commented lines of an imported file from the robot that it was exported from.
fn filled(text: &str, original: &Robot) -> String {
    let mut joints = original.links.iter().map(|link| &link.joint);
    let mut figures = &original.links[0].joint;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line == "[links.joint]" {
            figures = joints.next().expect("the copy has no joint more");
        }
        let known = [
            ("velocity_limit", figures.velocity_limit, "rad/s"),
            ("armature", figures.armature, "kg*m^2"),
            ("stiffness_gain", figures.stiffness_gain, "N*m/rad"),
            ("damping_gain", figures.damping_gain, "N*m*s/rad"),
            ("default_position", figures.default_position, "rad"),
        ];
        let missing = known.iter().find(|(key, ..)| line.starts_with(&format!("# {key} =")));
        lines.push(match missing {
            Some((key, value, unit)) => format!("{key} = \"{value} {unit}\""),
            None => line.to_owned(),
        });
    }
    lines.join("\n")
}

/// Every figure of two robots to 1e-9.
fn same(copy: &Robot, original: &Robot) {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * (1.0 + b.abs());
    assert_eq!((copy.joints(), &copy.mirror), (original.joints(), &original.mirror));
    assert!(close(copy.standing_height, original.standing_height));
    let bodies = |robot: &Robot| -> Vec<Body> {
        std::iter::once(robot.base.clone()).chain(robot.links.iter().map(|link| link.body.clone())).collect()
    };
    for (index, (copy, original)) in bodies(copy).iter().zip(&bodies(original)).enumerate() {
        assert_eq!(copy.name, original.name);
        assert!(close(copy.mass, original.mass) && (copy.com - original.com).norm() < 1e-9, "{}", copy.name);
        assert!((copy.inertia - original.inertia).norm() < 1e-9, "{}", copy.name);
        // A foot has its sole in the place of other shapes.
        if index > 0 && !copy.collisions.is_empty() {
            assert_eq!(copy.collisions.len(), original.collisions.len(), "{}", copy.name);
        }
        for (copy, original) in copy.collisions.iter().zip(&original.collisions) {
            assert!((copy.pose.to_homogeneous() - original.pose.to_homogeneous()).norm() < 1e-8);
            let sizes = |shape: &Shape| match shape {
                Shape::Box(half) => ("box", vec![half.x, half.y, half.z]),
                Shape::Capsule(half, radius) => ("capsule", vec![*half, *radius]),
                Shape::Cylinder(half, radius) => ("cylinder", vec![*half, *radius]),
                Shape::Sphere(radius) => ("sphere", vec![*radius]),
            };
            let ((kind, a), (other, b)) = (sizes(&copy.shape), sizes(&original.shape));
            assert!(
                kind == other && a.iter().zip(&b).all(|(a, b)| close(*a, *b)),
                "{kind} {a:?}, {other} {b:?}"
            );
        }
    }
    for (copy, original) in copy.links.iter().zip(&original.links) {
        let (a, b) = (&copy.joint, &original.joint);
        assert_eq!((&a.name, copy.parent), (&b.name, original.parent));
        let figures = |joint: &Joint| {
            [
                joint.lower,
                joint.upper,
                joint.effort_limit,
                joint.velocity_limit,
                joint.damping,
                joint.friction,
                joint.armature,
                joint.stiffness_gain,
                joint.damping_gain,
                joint.default_position,
            ]
        };
        assert!(figures(a).iter().zip(figures(b)).all(|(a, b)| close(*a, b)), "{a:?} is not {b:?}");
        assert!((a.axis.into_inner() - b.axis.into_inner()).norm() < 1e-9);
        assert!((a.origin.to_homogeneous() - b.origin.to_homogeneous()).norm() < 1e-9, "{}", a.name);
    }
    for (copy, original) in copy.feet.iter().zip(&original.feet) {
        assert_eq!(copy.link, original.link);
        assert!((copy.half_extents - original.half_extents).norm() < 1e-9);
        assert!((copy.centre - original.centre).norm() < 1e-9);
    }
}

#[test]
fn a_robot_that_went_out_comes_back_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    for name in robot::names() {
        let original = shipped(name);
        for format in ["mjcf", "urdf"] {
            let output =
                specforge(folder.path()).args(["robot", "show", name, "--format", format]).assert().success();
            let file = folder.path().join(format!("{name}.{format}"));
            fs::write(&file, &output.get_output().stdout).unwrap();
            let (text, missing) = imported(&file, &Selection::default());
            // URDF holds neither rotor inertias nor gains nor poses.
            assert_eq!(
                missing.len(),
                if format == "urdf" { 4 * original.joints() } else { 0 },
                "{missing:?}"
            );
            same(&load(name, &filled(&text, &original)), &original);
        }
    }
}

/// A biped of URDF with arms: six joints in each leg, a fixed torso, a shoulder on each side.
fn urdf() -> String {
    let link = |name: &str, mass: f64, shape: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 -0.05\"/><mass value=\"{mass}\"/>\
             <inertia \
             ixx=\"0.02\" iyy=\"0.02\" izz=\"0.01\" \
             ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>\n"
        )
    };
    let joint = |name: &str, kind: &str, (parent, child): (&str, &str), (place, axis): (&str, &str)| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{place}\"/><parent link=\"{parent}\"/>\
             <child link=\"{child}\"/><axis xyz=\"{axis}\"/><limit \
             lower=\"-1\" upper=\"1\" effort=\"100\" velocity=\"9\"/></joint>\n"
        )
    };
    let mut text =
        "<?xml version=\"1.0\"?>\n<!-- <mujoco> is not what this is -->\n<robot name=\"walker\">\n"
            .to_owned();
    text += &link("pelvis", 10.0, "");
    text += &link(
        "torso",
        20.0,
        "<collision><origin xyz=\"0 0 0.2\"/><geometry><mesh filename=\"torso.stl\"/></geometry></collision>",
    );
    text += &joint("waist", "fixed", ("pelvis", "torso"), ("0 0 0.3", "0 0 1"));
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        text += &link(&format!("{side}_arm"), 3.0, "");
        let places = format!("0 {} 0.4", 0.3 * y);
        text += &joint(
            &format!("{side}_shoulder"),
            "revolute",
            ("torso", &format!("{side}_arm")),
            (&places, "0 1 0"),
        );
        let mut parent = "pelvis".to_owned();
        let chain = [
            ("hip_yaw", "0 0 1", 0.0),
            ("hip_roll", "1 0 0", 0.0),
            ("hip_pitch", "0 1 0", 0.0),
            ("knee", "0 1 0", -0.4),
            ("ankle_pitch", "0 1 0", -0.4),
            ("ankle_roll", "1 0 0", 0.0),
        ];
        for (name, axis, down) in chain {
            let child = format!("{side}_{name}_link");
            let sole = "<collision><origin xyz=\"0.03 0 -0.06\"/><geometry><box size=\"0.24 0.1 \
                0.04\"/></geometry></collision>";
            text += &link(&child, 2.0, if name == "ankle_roll" { sole } else { "" });
            let place = if name == "hip_yaw" { format!("0 {} 0", 0.1 * y) } else { format!("0 0 {down}") };
            text += &joint(&format!("{side}_{name}"), "revolute", (&parent, &child), (&place, axis));
            parent = child;
        }
    }
    text + "</robot>\n"
}

fn written(folder: &Path) -> PathBuf {
    let file = folder.join("walker.urdf");
    fs::write(&file, urdf()).unwrap();
    file
}

fn specforge(folder: &Path) -> Command {
    let mut command = Command::cargo_bin("specforge").unwrap();
    command.current_dir(folder);
    command
}

#[test]
fn what_is_not_selected_is_welded_and_what_is_missing_is_a_line_to_fill_in() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let arguments = ["robot", "import", "walker.urdf", "--joints", "hip|knee|ankle"];
    let output = specforge(folder.path()).args(arguments).assert().success();
    let printed = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(printed.contains("12 joints, 2 welded") && printed.contains("left_hip_yaw"), "{printed}");
    let text = fs::read_to_string(folder.path().join("robots/walker.toml")).unwrap();
    assert!(text.contains("the mesh torso.stl is not there and left out"), "{text}");
    assert!(text.contains("# * armature of all 12 joints\n"), "{text}");
    // Pelvis, torso and both arms: 10 + 20 + 2 x 3 kg.
    assert!(text.contains("name = \"pelvis\"\nmass = \"36 kg\""), "{text}");
    assert!(text.contains("total_mass = \"60 kg\""), "{text}");
    for key in ["damping", "friction", "armature", "stiffness_gain", "damping_gain", "default_position"] {
        assert_eq!(text.matches(&format!("\n# {key} = ")).count(), 12, "{key}");
    }
    // Until they are filled in the checker names every one of them.
    specforge(folder.path()).args(["robot", "show", "walker"]).assert().code(3);
    let complete = ["damping", "friction", "armature", "stiffness_gain", "damping_gain"]
        .iter()
        .fold(text, |text, key| text.replace(&format!("# {key} = \"..."), &format!("{key} = \"0.1")));
    let complete = complete.replace("# default_position = \"...", "default_position = \"0");
    fs::write(folder.path().join("robots/walker.toml"), complete).unwrap();
    specforge(folder.path()).args(["robot", "show", "walker"]).assert().success();
}

#[test]
fn an_inertia_of_no_rigid_body_is_refused_where_it_moves_and_balanced_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let long = |link: &str| {
        let text = urdf();
        let place = text.find(&format!("<link name=\"{link}\">")).expect("the link is there");
        let (before, after) = text.split_at(place);
        let moment = after.find("izz=\"").expect("it has an inertia") + 5;
        let end = moment + after[moment..].find('"').unwrap();
        fs::write(&file, format!("{before}{}0.09{}", &after[..moment], &after[end..])).unwrap();
        let import = ["robot", "import", "walker.urdf", "--joints", "hip|knee|ankle"];
        (specforge(folder.path()), import)
    };
    // A part that is welded to a sound body is told only.
    let (mut command, import) = long("left_arm");
    let output = command.args(import).args(["-o", "arm.toml"]).assert().success();
    let printed = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(printed.contains("`left_arm`: its inertia violates the triangle inequality"), "{printed}");
    let (mut command, import) = long("left_knee_link");
    let output = command.args(import).assert().code(3);
    let printed = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(printed.contains("E0405") && printed.contains("--balance-inertia"), "{printed}");
    let (mut command, import) = long("left_knee_link");
    let output = command.args(import).args(["--balance-inertia", "-o", "knee.toml"]).assert().success();
    let printed = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(
        printed.contains("`left_knee_link`: its inertia violates") && printed.contains("by their mean"),
        "{printed}"
    );
}

#[test]
fn a_base_without_a_free_joint_is_the_body_of_the_world_that_carries_joints() {
    let leg = |side: &str, y: f64| {
        let inertial = "<inertial pos=\"0 0 -0.2\" mass=\"2\" diaginertia=\"0.02 0.02 0.01\"/>";
        format!(
            "<body name=\"{side}\" pos=\"0 {y} 0\"><joint axis=\"1 0 0\"/><joint axis=\"0 1 0\"/>{inertial}\
             <body name=\"{side}_foot\" pos=\"0 0 -0.4\"><joint name=\"{side}_ankle\" axis=\"0 1 \
             0\"/>{inertial}\
             <geom type=\"box\" size=\"0.1 0.05 0.02\" friction=\"0.8 0.005 0.0001\"/></body></body>"
        )
    };
    let (left, right) = (leg("left", 0.1), leg("right", -0.1));
    let text = format!(
        "<mujoco><worldbody><body name=\"table\"><geom size=\"1\"/></body><body name=\"pelvis\"><joint \
         type=\"slide\"/>\
         <joint type=\"ball\"/><inertial pos=\"0 0 0\" mass=\"9\" diaginertia=\"0.1 0.1 \
         0.1\"/>{left}{right}</body></worldbody></mujoco>"
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("walker.xml");
    fs::write(&file, text).unwrap();
    let welded = welded(&file, &Selection::default());
    let names: Vec<&str> = welded.links.iter().map(|link| link.hinge.name.as_str()).collect();
    let joints = ["left_joint", "left_joint_2", "left_ankle", "right_joint", "right_joint_2", "right_ankle"];
    assert_eq!((welded.base.name.as_str(), names), ("pelvis", joints.to_vec()));
    // A coefficient that the robot file has no place for is told, not dropped.
    let told =
        welded.notes.iter().filter(|note| note.contains("friction coefficient of 0.8 is not taken over"));
    assert_eq!(told.count(), 2);
}

#[test]
fn the_feet_alone_select_the_legs() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let feet = ["left_ankle_roll_link".to_owned(), "right_ankle_roll_link".to_owned()];
    let welded = welded(&file, &Selection { feet: Some(feet), ..Selection::default() });
    assert_eq!(welded.fixed, ["left_shoulder", "right_shoulder"]);
    let sole = welded.feet[0].1.expect("the foot has a box");
    assert!((sole.half - nalgebra::Vector3::new(0.12, 0.05, 0.02)).norm() < 1e-12);
}

#[test]
fn feet_that_are_found_select_the_legs_too() {
    let folder = tempfile::tempdir().unwrap();
    let neck = "<link name=\"head\"/><joint name=\"neck\" type=\"revolute\"><origin xyz=\"0 0 0.6\"/>\
        <parent link=\"torso\"/><child link=\"head\"/><axis xyz=\"0 0 1\"/>\
        <limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"9\"/></joint>\n</robot>";
    let file = changed(folder.path(), &[("</robot>", neck)]);
    let welded = welded(&file, &Selection::default());
    assert_eq!(welded.links.len(), 12);
    assert_eq!(welded.fixed, ["left_shoulder", "right_shoulder", "neck"]);
    assert!(welded.notes.iter().any(|note| note.contains("the feet were not named")), "{:?}", welded.notes);
}

#[test]
fn mistakes_are_said_and_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let fails = |arguments: &[&str], code: i32, words: &str| {
        let output = specforge(folder.path()).args(["robot", "import"]).args(arguments).assert().code(code);
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(said.contains(words), "{said}");
    };
    fails(&["nothing.urdf"], 3, "E0004");
    fails(&["walker.urdf", "--joints", "wheel"], 3, "E0402");
    fails(&["walker.urdf", "--joints", "("], 2, "open group without closing");
    fails(&["walker.urdf", "--feet", "one"], 2, "a comma between them");
    fails(&["walker.urdf", "--fill", "velocity_limit=12"], 2, "the unit is missing: write it in rad/s");
    fails(&["walker.urdf", "--fill", "velocity_limit=fast"], 2, "does not begin with a number");
    fails(&["walker.urdf", "--fill", "velocity_limit=12 N"], 2, "write it in rad/s");
    fails(
        &["walker.urdf", "--fill", "kneee:armature=1 kg*m^2"],
        2,
        "`kneee` matches no moving joint; there are",
    );
    fails(&["walker.urdf", "--fill", "shoulder:armature=1 kg*m^2"], 2, ", and left_shoulder is welded");
    fails(
        &["walker.urdf", "--feet", "left_ankle_roll_link,toe"],
        3,
        "E0404]: --feet: there is no body `toe`",
    );
    fails(&["walker.urdf", "--feet", "pelvis,torso"], 3, "welded to the base");
    fs::write(folder.path().join("page.html"), "<html></html>").unwrap();
    fails(&["page.html"], 3, "E0410");
    let slides = urdf().replacen("type=\"revolute\"", "type=\"prismatic\"", 2);
    fs::write(folder.path().join("slides.urdf"), slides).unwrap();
    fails(&["slides.urdf", "--joints", "."], 3, "E0413");
    assert!(!folder.path().join("robots").exists());
    let arguments = ["walker.urdf", "--joints", "hip|knee|ankle"];
    specforge(folder.path()).args(["robot", "import"]).args(arguments).assert().success();
    fs::write(folder.path().join("robots/walker.toml"), "mine").unwrap();
    fails(&arguments, 2, "`robots/walker.toml` is already there");
    assert_eq!(fs::read_to_string(folder.path().join("robots/walker.toml")).unwrap(), "mine");
    drop(file);
}

/// The walker with other text in the place of what stands there first.
fn changed(folder: &Path, edits: &[(&str, &str)]) -> PathBuf {
    let text = edits.iter().fold(urdf(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let file = folder.join("walker.urdf");
    fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_mimic_joint_is_welded_and_named_or_refused_where_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let follows =
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><mimic joint=\"left_knee\" multiplier=\"2\"/>");
    let welded = welded(&changed(folder.path(), &[follows]), &Selection::default());
    assert_eq!(welded.fixed, ["left_shoulder (driven by `left_knee`)", "right_shoulder"]);
    let arguments = ["robot", "import", "walker.urdf", "--joints", "hip|knee|ankle|shoulder"];
    let output = specforge(folder.path()).args(arguments).assert().code(3);
    let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(said.contains("error[E0413]: joint `left_shoulder` is driven by `left_knee`"), "{said}");
}

#[test]
fn limits_that_a_joint_does_not_have_are_lines_to_fill_in() {
    let folder = tempfile::tempdir().unwrap();
    let axis = "<axis xyz=\"0 1 0\"/>";
    let limit = &format!("{axis}<limit lower=\"-1\" upper=\"1\" effort=\"100\" velocity=\"9\"/>");
    let joints = Some(regex_lite::Regex::new("shoulder|hip|knee|ankle").unwrap());
    let selection = Selection { joints, ..Selection::default() };
    let missing = |edits: &[(&str, &str)]| {
        let (_, missing) = imported(&changed(folder.path(), edits), &selection);
        let of = |key: &str| missing.iter().filter(|line| line.ends_with(&format!(": {key}"))).count();
        ["lower", "upper", "effort_limit", "velocity_limit"].map(of)
    };
    assert_eq!(missing(&[]), [0; 4]);
    assert_eq!(missing(&[("revolute", "continuous")]), [1, 1, 0, 0]);
    assert_eq!(missing(&[(limit, axis)]), [1; 4]);
    // Nothing and zero both mean that nobody knows.
    assert_eq!(
        missing(&[(limit, "<axis xyz=\"0 1 0\"/><limit effort=\"0\" velocity=\"9\"/>")]),
        [1, 1, 1, 0]
    );
}

#[test]
fn limits_that_no_motor_has_are_taken_over_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let said = |from: &str, to: &str, count: usize| {
        let file = folder.path().join("walker.urdf");
        fs::write(&file, urdf().replacen(from, to, count)).unwrap();
        let feet = ["left", "right"].map(|side| format!("{side}_ankle_roll_link"));
        let welded = welded(&file, &Selection { feet: Some(feet), ..Selection::default() });
        let draft = import::Draft { name: "copy", text: "", is_whole: false };
        let found = import::issues(&welded, &[], draft).into_iter().filter(|issue| issue.code == "W0414");
        found.map(|issue| issue.message).collect::<Vec<_>>()
    };
    assert!(said("", "", 0).is_empty());
    // 60 kg on legs of 0.9 m: 530 N m. The first limits are those of the waist and a shoulder, which are
    // welded.
    let told = said("effort=\"100\"", "effort=\"2600\"", 99);
    assert!(told.is_empty(), "{told:?}");
    let told = said("effort=\"100\"", "effort=\"2700\"", 99);
    assert!(
        told.len() == 1 && told[0].starts_with("the effort limit of all 12 joints, up to 2700 N m"),
        "{told:?}"
    );
    assert!(told[0].contains("530") || told[0].contains("529"), "{told:?}");
    let told = said("velocity=\"9\"", "velocity=\"1000\"", 3);
    assert!(told.len() == 1 && told[0].contains("limit of `left_hip_yaw`, up to 1000 rad/s"), "{told:?}");
    let told = said("lower=\"-1\"", "lower=\"-10\"", 7);
    let names = "`left_hip_yaw`, `left_hip_roll`, `left_hip_pitch` and 2 others, up to 11.0 rad";
    assert!(told.len() == 1 && told[0].contains(names), "{told:?}");
}

#[test]
fn joints_keep_the_order_of_the_file_as_far_as_a_tree_can() {
    let folder = tempfile::tempdir().unwrap();
    let text = urdf();
    let lines: Vec<&str> = text.lines().collect();
    // The joints of the right leg before those of the left one, from the foot up: parents still come first.
    let (joints, others): (Vec<&str>, Vec<&str>) = lines.iter().partition(|line| line.starts_with("<joint"));
    let (last, rest) = others.split_last().unwrap();
    let backwards: Vec<&str> = joints.into_iter().rev().collect();
    let file = folder.path().join("walker.urdf");
    fs::write(&file, [rest, &backwards, &[*last]].concat().join("\n")).unwrap();
    let feet = ["left_ankle_roll_link", "right_ankle_roll_link"].map(str::to_owned);
    let welded = welded(&file, &Selection { feet: Some(feet), ..Selection::default() });
    let names: Vec<&str> = welded.links.iter().map(|link| link.hinge.name.as_str()).collect();
    let leg = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"];
    let expected: Vec<String> =
        ["right", "left"].iter().flat_map(|side| leg.map(|joint| format!("{side}_{joint}"))).collect();
    assert_eq!(names, expected);
}

#[test]
fn a_name_that_leads_out_of_the_folder_is_none() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    for name in ["../walker", "a/b", "", "a b", "a\"b"] {
        specforge(folder.path()).args(["robot", "import", "walker.urdf", "--name", name]).assert().code(2);
    }
    assert!(!folder.path().join("robots").exists());
}
