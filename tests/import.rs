//! Robots from other programs' files: what comes in is what went out, and nothing is invented.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use specforge::diag::{Sink, Sources};
use specforge::robot::import::{self, Origin, Selection};
use specforge::robot::{self, Robot};
use specforge::sim::{EngineSettings, Terrain, mjcf};

fn load(name: &str, text: &str) -> Robot {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(Path::new("robot.toml"), text.to_owned());
    let robot = robot::load(name, &sources, source, &mut sink);
    robot.unwrap_or_else(|| panic!("{:?}", sink.diagnostics))
}

fn shipped(name: &str) -> Robot {
    load(name, robot::embedded(name).expect("it is shipped"))
}

fn imported(file: &Path, selection: &Selection) -> (String, Vec<String>) {
    let tree = import::read(file).expect("the file can be read");
    let welded = import::weld(&tree, selection).expect("it can be welded");
    import::text(&welded, &Origin { name: "copy", source: "source", format: tree.format })
}

/// Fills in what a source of MJCF cannot say.
fn filled(text: &str, original: &Robot) -> String {
    let mut joint = 0;
    let mut lines = Vec::new();
    for line in text.lines() {
        let of = |key: &str| line.starts_with(&format!("# {key} ="));
        let figures = &original.links[joint.min(original.joints() - 1)].joint;
        lines.push(match () {
            () if of("velocity_limit") => format!("velocity_limit = \"{} rad/s\"", figures.velocity_limit),
            () if of("stiffness_gain") => format!("stiffness_gain = \"{} N*m/rad\"", figures.stiffness_gain),
            () if of("damping_gain") => format!("damping_gain = \"{} N*m*s/rad\"", figures.damping_gain),
            () if of("default_position") => {
                joint += 1;
                format!("default_position = \"{} rad\"", figures.default_position)
            }
            () => line.to_owned(),
        });
    }
    lines.join("\n")
}

#[test]
fn a_robot_that_went_out_as_mjcf_comes_back_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["tocabi", "atlas", "g1"] {
        let original = shipped(name);
        let settings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
        let file = folder.path().join(format!("{name}.xml"));
        fs::write(&file, mjcf::document(&original, &Terrain::Flat, &settings)).unwrap();
        let (text, missing) = imported(&file, &Selection::default());
        // MJCF holds neither motor speeds nor, without position servos and key frames, gains and poses.
        assert_eq!(missing.len(), 4 * original.joints(), "{missing:?}");
        let copy = load(name, &filled(&text, &original));
        assert_eq!(copy.joints(), original.joints());
        assert_eq!(copy.mirror, original.mirror);
        assert!((copy.total_mass() - original.total_mass()).abs() < 1e-8);
        assert!((copy.standing_height - original.standing_height).abs() < 1e-8);
        for (copy, original) in copy.links.iter().zip(&original.links) {
            let (a, b) = (&copy.joint, &original.joint);
            assert_eq!((&a.name, copy.parent), (&b.name, original.parent));
            for (a, b) in [
                (a.lower, b.lower),
                (a.upper, b.upper),
                (a.effort_limit, b.effort_limit),
                (a.damping, b.damping),
                (a.friction, b.friction),
                (a.armature, b.armature),
                (copy.body.mass, original.body.mass),
            ] {
                assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{name} {}: {a} is not {b}", original.joint.name);
            }
            assert!((a.axis.into_inner() - b.axis.into_inner()).norm() < 1e-8);
            assert!((a.origin.translation.vector - b.origin.translation.vector).norm() < 1e-8);
            assert!(a.origin.rotation.angle_to(&b.origin.rotation) < 1e-7);
            assert!((copy.body.com - original.body.com).norm() < 1e-8);
            assert!((copy.body.inertia - original.body.inertia).norm() < 1e-8);
            assert_eq!(copy.body.collisions.len(), original.body.collisions.len());
        }
        for (copy, original) in copy.feet.iter().zip(&original.feet) {
            assert_eq!(copy.link, original.link);
            assert!((copy.half_extents - original.half_extents).norm() < 1e-8);
            assert!((copy.centre - original.centre).norm() < 1e-8);
        }
    }
}

/// A biped of URDF with arms: six joints in each leg, a fixed torso, a shoulder on each side.
fn urdf() -> String {
    let link = |name: &str, mass: f64, shape: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 -0.05\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"0.02\" iyy=\"0.02\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>\n"
        )
    };
    let joint = |name: &str, kind: &str, (parent, child): (&str, &str), (place, axis): (&str, &str)| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{place}\"/><parent link=\"{parent}\"/>\
             <child link=\"{child}\"/><axis xyz=\"{axis}\"/><limit lower=\"-1\" upper=\"1\" effort=\"100\" velocity=\"9\"/></joint>\n"
        )
    };
    let mut text =
        "<?xml version=\"1.0\"?>\n<!-- <mujoco> is not what this is -->\n<robot name=\"walker\">\n".to_owned();
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
        text += &joint(&format!("{side}_shoulder"), "revolute", ("torso", &format!("{side}_arm")), (&places, "0 1 0"));
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
            let sole = "<collision><origin xyz=\"0.03 0 -0.06\"/><geometry><box size=\"0.24 0.1 0.04\"/></geometry></collision>";
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
    assert!(text.contains("the mesh torso.stl is left out"), "{text}");
    assert!(text.contains("# * armature of all 12 joints\n"), "{text}");
    // Pelvis, torso and both arms: 10 + 20 + 2 x 3 kg.
    assert!(text.contains("name = \"pelvis\"\nmass = \"36 kg\""), "{text}");
    assert!(text.contains("total_mass = \"60 kg\""), "{text}");
    for key in ["damping", "friction", "armature", "stiffness_gain", "damping_gain", "default_position"] {
        assert_eq!(text.matches(&format!("\n# {key} = ")).count(), 12, "{key}");
    }
    // Until they are filled in the checker names every one of them.
    specforge(folder.path()).args(["robot", "show", "walker"]).assert().code(3);
    let complete = ["damping", "friction", "armature", "stiffness_gain", "damping_gain", "default_position"]
        .iter()
        .fold(text, |text, key| text.replace(&format!("# {key} = \"..."), &format!("{key} = \"0.1")));
    fs::write(folder.path().join("robots/walker.toml"), complete).unwrap();
    specforge(folder.path()).args(["robot", "show", "walker"]).assert().success();
}

#[test]
fn the_feet_alone_select_the_legs() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let feet = ["left_ankle_roll_link".to_owned(), "right_ankle_roll_link".to_owned()];
    let tree = import::read(&file).unwrap();
    let welded = import::weld(&tree, &Selection { joints: None, feet: Some(feet) }).unwrap();
    assert_eq!(welded.fixed, ["left_shoulder", "right_shoulder"]);
    let sole = welded.feet[0].1.expect("the foot has a box");
    assert!((sole.half - nalgebra::Vector3::new(0.12, 0.05, 0.02)).norm() < 1e-12);
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
    fails(&["nothing.urdf"], 3, "nothing.urdf");
    fails(&["walker.urdf", "--joints", "wheel"], 3, "matches no joint");
    fails(&["walker.urdf", "--joints", "("], 2, "regex");
    fails(&["walker.urdf", "--feet", "one"], 2, "a comma between them");
    fails(&["walker.urdf", "--feet", "left_ankle_roll_link,toe"], 3, "there is no body `toe`");
    fails(&["walker.urdf", "--feet", "pelvis,torso"], 3, "welded to the base");
    fs::write(folder.path().join("page.html"), "<html></html>").unwrap();
    fails(&["page.html"], 3, "`html`");
    let slides = urdf().replacen("type=\"revolute\"", "type=\"prismatic\"", 2);
    fs::write(folder.path().join("slides.urdf"), slides).unwrap();
    fails(&["slides.urdf", "--joints", "."], 3, "prismatic");
    assert!(!folder.path().join("robots").exists());
    let arguments = ["walker.urdf", "--joints", "hip|knee|ankle"];
    specforge(folder.path()).args(["robot", "import"]).args(arguments).assert().success();
    fs::write(folder.path().join("robots/walker.toml"), "mine").unwrap();
    fails(&arguments, 2, "--output");
    assert_eq!(fs::read_to_string(folder.path().join("robots/walker.toml")).unwrap(), "mine");
    drop(file);
}
