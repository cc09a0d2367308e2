//! What a description says and a robot file does not is taken over or told: springs, damping, masks, ranges,
//! legs, shapes.

use std::fs;
use std::path::Path;

use regex_lite::Regex;
use specforge::diag::render::{Look, human};
use specforge::diag::{Sink, Sources};
use specforge::robot::import::{self, Folder, Hinge, Selection, Welded};

use super::{specforge, welded};

const URDF: &str = include_str!("heron.urdf");
const MJCF: &str = include_str!("heron.xml");
const SOLE: &str = include_str!("sole.dae");

/// A text with others in the place of what stands there, everywhere.
fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// The robot of a text, by the ending of its file.
fn read(ending: &str, text: &str, selection: &Selection) -> Welded {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("heron.{ending}"));
    fs::write(&file, text).unwrap();
    fs::write(folder.path().join("sole.dae"), SOLE).unwrap();
    welded(&file, selection)
}

fn urdf(edits: &[(&str, &str)]) -> Welded {
    read("urdf", &edited(URDF, edits), &Selection::default())
}

fn mjcf(edits: &[(&str, &str)]) -> Welded {
    read("xml", &edited(MJCF, edits), &Selection::default())
}

fn hinge<'a>(welded: &'a Welded, name: &str) -> &'a Hinge {
    let links = welded.links.iter().map(|link| &link.hinge);
    links.into_iter().find(|hinge| hinge.name == name).unwrap_or_else(|| panic!("no joint {name}"))
}

/// The one remark with these words.
fn told<'a>(welded: &'a Welded, words: &str) -> &'a str {
    let found: Vec<&String> = welded.notes.iter().filter(|note| note.contains(words)).collect();
    assert_eq!(found.len(), 1, "{words}: {:#?}", welded.notes);
    found[0]
}

/// What an import of a text says on standard error.
fn refused(ending: &str, text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = format!("heron.{ending}");
    fs::write(folder.path().join(&file), text).unwrap();
    let output = specforge(folder.path()).args(["robot", "import", &file]).assert().code(3);
    assert!(!folder.path().join("robots").exists());
    String::from_utf8_lossy(&output.get_output().stderr).into_owned()
}

#[test]
fn the_plain_files_have_no_remark_on_what_is_not_imported() {
    for plain in [urdf(&[]), mjcf(&[])] {
        let notes: Vec<&String> =
            plain.notes.iter().filter(|note| !note.contains("the feet were not named")).collect();
        let shapeless =
            notes.iter().all(|note| note.starts_with("no body but the feet has a collision shape"));
        assert!(shapeless, "{notes:?}");
    }
    assert!(!urdf(&[]).notes.iter().any(|note| note.contains("collision shape")));
}

#[test]
fn parts_of_a_collada_file_with_the_same_ids_are_all_there() {
    let foot = "<origin xyz=\"0.03 0 -0.045\"/><geometry><box size=\"0.18 0.08 0.02\"/></geometry>";
    let welded = urdf(&[(foot, "<geometry><mesh filename=\"sole.dae\"/></geometry>")]);
    let sole = welded.feet[0].1.expect("the foot has a sole");
    assert!((2.0 * sole.half - nalgebra::Vector3::new(0.18, 0.08, 0.065)).norm() < 1e-9, "{sole:?}");
}

#[test]
fn the_damping_of_a_spring_with_a_time_constant_is_mujocos_and_the_spring_is_told() {
    let spring = ("range=\"0 2.2\"", "range=\"0 2.2\" springdamper=\"0.05 1\"");
    let welded = mjcf(&[spring]);
    for side in ["port", "star"] {
        let damping = hinge(&welded, &format!("{side}_knee")).damping.unwrap();
        assert!((damping - 1.37066).abs() < 1e-5, "{damping}");
        assert_eq!(hinge(&welded, &format!("{side}_hip")).damping, Some(0.2));
    }
    let line = told(&welded, "not imported: springs");
    assert!(line.contains("`springdamper` of <joint> `port_knee` and `star_knee`;"), "{line}");
    told(&welded, "the damping of `port_knee` and `star_knee` follows from `springdamper`");
    // A class says it for every joint that has it.
    let by_class =
        mjcf(&[("<joint damping=\"0.2\"", "<joint stiffness=\"3\" springref=\"0.1\" damping=\"0.2\"")]);
    let line = told(&by_class, "not imported: springs");
    assert!(
        line.contains(
            "`stiffness` of <joint> `port_hip`, `port_knee`, `port_ankle` and 3 others, `springref`"
        ),
        "{line}"
    );
    let none = mjcf(&[("<joint damping=\"0.2\"", "<joint stiffness=\"0\" springref=\"0\" damping=\"0.2\"")]);
    assert!(!none.notes.iter().any(|note| note.contains("spring")), "{:?}", none.notes);
}

#[test]
fn armature_and_damping_of_a_drive_are_added_through_its_gear() {
    let gear = "gear=\"50\"";
    let own = mjcf(&[(gear, "gear=\"50\" armature=\"0.001\" damping=\"0.0002\"")]);
    let by_class = mjcf(&[("</default>", "<motor armature=\"0.001\" damping=\"0.0002\"/></default>")]);
    let by_another = mjcf(&[("</default>", "<general armature=\"0.001\" damping=\"0.0002\"/></default>")]);
    for welded in [own, by_class, by_another] {
        let knee = hinge(&welded, "port_knee");
        assert!((knee.armature.unwrap() - 2.52).abs() < 1e-12 && (knee.damping.unwrap() - 0.7).abs() < 1e-12);
    }
}

#[test]
fn what_mujoco_has_and_a_robot_file_has_not_is_one_line_each() {
    let arm = |more: &str| {
        format!(
            "<body name=\"arm\" {more}><inertial mass=\"2\" pos=\"0 0 0\" diaginertia=\"0.01 0.01 \
             0.01\"/></body><body name=\"port_thigh\""
        )
    };
    let (body, knee) = ("<body name=\"port_thigh\"", "<joint name=\"port_knee\"");
    let (motor, end) = ("gear=\"50\"", "</mujoco>");
    let geom = "name=\"port_sole\"";
    for (from, to, words) in [
        (body, arm("gravcomp=\"1\"").as_str(), "gravity compensation of bodies, `gravcomp` of <body> `arm`"),
        (
            knee,
            "<joint actuatorgravcomp=\"true\" name=\"port_knee\"",
            "`actuatorgravcomp` of <joint> `port_knee`",
        ),
        (
            knee,
            "<joint solreflimit=\"0.1 1\" name=\"port_knee\"",
            "contacts and limits, `solreflimit` of <joint> `port_knee`",
        ),
        (
            motor,
            "gear=\"50\" delay=\"0.01\" nsample=\"4\"",
            "dynamics of drives, `delay` of <motor> `port_hip`, `port_knee`",
        ),
        (geom, "condim=\"1\" name=\"port_sole\"", "`condim` of <geom> `port_sole`"),
        (
            geom,
            "contype=\"2\" name=\"port_sole\"",
            "contact masks, pairs and exclusions, `contype` of <geom> `port_sole`",
        ),
        (
            geom,
            "fluidshape=\"ellipsoid\" name=\"port_sole\"",
            "wind and fluids, `fluidshape` of <geom> `port_sole`",
        ),
        (
            geom,
            "colour=\"red\" name=\"port_sole\"",
            "unknown elements and attributes, `colour` of <geom> `port_sole`",
        ),
        (
            "<freejoint/>",
            "<joint type=\"free\" damping=\"3\"/>",
            "the free joint, `damping` of <joint> `hull`",
        ),
        (
            "<compiler",
            "<option gravity=\"0 0 -1.62\" timestep=\"0.001\"/><compiler",
            "wind and fluids, `gravity` of <option>",
        ),
        (
            "<compiler",
            "<option><flag contact=\"disable\"/></option><compiler",
            "switched off, `contact` of <flag>",
        ),
        (
            end,
            "<contact><exclude name=\"e\" body1=\"hull\" body2=\"port_foot\"/></contact></mujoco>",
            "exclusions, <exclude> `e`",
        ),
        (
            end,
            "<equality><connect name=\"loop\" body1=\"hull\" body2=\"port_foot\" anchor=\"0 0 \
             0\"/></equality></mujoco>",
            "constraints, <connect> `loop`",
        ),
        (
            end,
            "<tendon><fixed name=\"t\"><joint joint=\"port_knee\" coef=\"1\"/></fixed></tendon></mujoco>",
            "tendons, <fixed> `t`",
        ),
        (
            end,
            "<actuator><motor name=\"m\" tendon=\"t\"/></actuator></mujoco>",
            "sites and bodies, `tendon` of <motor> `m`",
        ),
        (
            end,
            "<actuator><muscle name=\"m\" joint=\"port_knee\"/></actuator></mujoco>",
            "nor servos, <muscle> `m`",
        ),
        (end, "<springs/></mujoco>", "unknown elements and attributes, <springs>"),
        (
            "</worldbody>",
            "<body name=\"table\"><geom size=\"1\"/></body><geom name=\"step\" size=\"1\"/></worldbody>",
            "beside the robot, <body> `table`, <geom> `step`",
        ),
    ] {
        let welded = mjcf(&[(from, to)]);
        let line = told(&welded, words);
        assert!(line.starts_with("not imported: "), "{line}");
        assert_eq!(
            welded.notes.iter().filter(|note| note.starts_with("not imported")).count(),
            1,
            "{:#?}",
            welded.notes
        );
    }
    // Looks, sensors and the parameters of a simulation say nothing about the robot.
    let harmless = "<visual><global offwidth=\"99\"/></visual><option \
        timestep=\"0.001\" solver=\"CG\"/><sensor><gyro site=\"s\"/></sensor>\
         <contact><exclude body1=\"a\" body2=\"b\"/></contact></mujoco>";
    let harmless = harmless.replace("<contact><exclude body1=\"a\" body2=\"b\"/></contact>", "");
    let welded = mjcf(&[
        (end, &harmless),
        ("<geom name=\"port_sole\"", "<site name=\"s\"/><geom rgba=\"1 0 0 1\" name=\"port_sole\""),
    ]);
    assert!(!welded.notes.iter().any(|note| note.starts_with("not imported")), "{:#?}", welded.notes);
}

#[test]
fn a_servos_damping_is_its_gain_and_not_the_joints_damping() {
    let knee = "<motor name=\"port_knee\" joint=\"port_knee\" gear=\"50\" ctrlrange=\"-1 1\"/>";
    let servo = |actuator: &str| {
        let welded = mjcf(&[(knee, actuator)]);
        let hinge = hinge(&welded, "port_knee");
        assert_eq!(hinge.damping, Some(0.2), "{actuator}");
        (hinge.stiffness_gain, hinge.damping_gain)
    };
    let joint = "joint=\"port_knee\" gear=\"2\"";
    assert_eq!(servo(&format!("<position {joint} kp=\"100\" kv=\"5\"/>")), (Some(400.0), Some(20.0)));
    assert_eq!(
        servo(&format!("<position {joint} kp=\"100\"/><velocity {joint} kv=\"5\"/>")),
        (Some(400.0), Some(20.0))
    );
    assert_eq!(servo(&format!("<pid {joint} kp=\"100\" kv=\"5\" ki=\"3\"/>")), (Some(400.0), Some(20.0)));
    assert_eq!(servo(&format!("<velocity {joint} kv=\"5\"/>")), (None, Some(20.0)));
    let affine = |prm: &str| format!("<general {joint} {prm} biastype=\"affine\"/>");
    assert_eq!(servo(&affine("gainprm=\"100\" biasprm=\"0 -100 -5\"")), (Some(400.0), Some(20.0)));
    assert_eq!(servo(&affine("gainprm=\"1\" biasprm=\"0 0 -5\"")), (None, Some(20.0)));
    // By critical damping of 100 N m/rad, through the gear 400, on an inertia of 0.034267 kg m^2.
    let critical = 2.0 * (400.0_f64 * 0.034266615).sqrt();
    for ratio in [
        format!("<position {joint} kp=\"100\" dampratio=\"1\"/>"),
        affine("gainprm=\"100\" biasprm=\"0 -100 1\""),
    ] {
        let (stiffness, damping) = servo(&ratio);
        assert!(
            stiffness == Some(400.0) && (damping.unwrap() - critical).abs() < 1e-6,
            "{ratio}: {damping:?}"
        );
    }
    // The damping that is given nearer to the servo counts.
    let class = "</default>";
    let welded = mjcf(&[
        (class, "<position dampratio=\"1\"/></default>"),
        (knee, &format!("<position {joint} kp=\"100\" kv=\"5\"/>")),
    ]);
    assert_eq!(hinge(&welded, "port_knee").damping_gain, Some(20.0));
}

#[test]
fn a_geom_that_touches_in_a_contact_pair_alone_is_a_sole() {
    let masked = ("<geom name=\"port_sole\"", "<geom contype=\"0\" conaffinity=\"0\" name=\"port_sole\"");
    let lost = mjcf(&[masked]);
    assert!(lost.feet.iter().any(|(_, sole)| sole.is_none()));
    told(&lost, "the geoms of `port_foot` touch nothing in the file (contype and conaffinity are 0)");
    let pair = "<contact><pair geom1=\"floor\" geom2=\"port_sole\"/></contact></mujoco>";
    let paired = mjcf(&[masked, ("</mujoco>", pair)]);
    assert!(paired.feet.iter().all(|(_, sole)| sole.is_some()), "{:?}", paired.feet);
    told(&paired, "the geoms `port_sole` touch in contact pairs alone");
    let dropped = told(&paired, "not imported: contact masks, pairs and exclusions");
    assert!(dropped.contains("`geom1` of <pair>, `geom2` of <pair>"), "{dropped}");
}

#[test]
fn several_joints_of_one_body_all_stay_and_are_told() {
    let two = "<joint name=\"port_roll\" axis=\"1 0 0\"/><joint name=\"port_hip\"";
    let driven = "<actuator><motor name=\"port_roll\" joint=\"port_roll\" gear=\"50\" ctrlrange=\"-1 1\"/>";
    let welded = mjcf(&[("<joint name=\"port_hip\"", two), ("<actuator>", driven)]);
    let names: Vec<&str> = welded.links.iter().map(|link| link.hinge.name.as_str()).take(3).collect();
    assert_eq!(names, ["port_roll", "port_hip", "port_knee"]);
    told(&welded, "`port_thigh` have several joints, of which each became a body of its own");
    // Nothing is to be filled in, and the whole is what it was.
    let plain = mjcf(&[]);
    let mass =
        |welded: &Welded| welded.base.mass + welded.links.iter().map(|link| link.body.mass).sum::<f64>();
    assert!((mass(&welded) - mass(&plain)).abs() < 1e-12);
    assert!(
        welded
            .links
            .iter()
            .all(|link| !link.weigh && link.body.mass > 0.0 && link.body.inertia.trace() > 0.0)
    );
    assert!((welded.links[0].body.mass - 1.5e-6).abs() < 1e-12, "{}", welded.links[0].body.mass);
    assert!((welded.links[1].body.mass - 1.499_998_5).abs() < 1e-12);
    // A frame that is welded is a part of its body again.
    let joints = Some(Regex::new("hip|knee|ankle").unwrap());
    let text = edited(MJCF, &[("<joint name=\"port_hip\"", two)]);
    let merged = read("xml", &text, &Selection { joints, ..Selection::default() });
    assert_eq!(merged.links.len(), 6);
    assert!((merged.base.mass + merged.links[0].body.mass - 9.5).abs() < 1e-12);
}

#[test]
fn the_masses_that_a_file_says_stand_in_the_lines_to_fill_in() {
    let hand = "<body name=\"hand\"><geom name=\"thumb\" type=\"mesh\" mesh=\"thumb\"/></body><body \
        name=\"port_thigh\"";
    let asset = "<asset><mesh name=\"thumb\" file=\"thumb.stl\"/></asset><worldbody>";
    let welded = mjcf(&[("<body name=\"port_thigh\"", hand), ("<worldbody>", asset)]);
    assert!(welded.weigh_base);
    let origin = import::Origin { name: "heron", source: "heron.xml", format: "MJCF", fills: &[] };
    let written = import::text(&welded, &origin);
    let line = written.text.lines().find(|line| line.starts_with("# mass = ")).expect("a line to fill in");
    assert!(line.contains("\"8 kg\"") && line.contains("without `hand`"), "{line}");
    let notes = written.notes.join("\n");
    assert!(
        notes.contains(
            "`hull`: the source says the masses of some parts, 8 kg together, and not those of `hand`"
        ),
        "{notes}"
    );
}

#[test]
fn a_range_of_a_continuous_joint_is_told_with_its_figures() {
    let edits = [("type=\"revolute\"", "type=\"continuous\"")];
    let welded = urdf(&edits);
    let line = told(&welded, "calls continuous");
    for range in [
        "-1.5 .. 0.9 rad of `port_hip` and `star_hip`",
        "0 .. 2.2 rad of `port_knee`",
        "-1.1 .. 0.9 rad of `port_ankle`",
    ] {
        assert!(line.contains(range), "{line}");
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("heron.urdf"), edited(URDF, &edits)).unwrap();
    specforge(folder.path()).args(["robot", "import", "heron.urdf"]).assert().success();
    let text = fs::read_to_string(folder.path().join("robots/heron.toml")).unwrap();
    let (unknown, void) =
        text.split_once("because the source's figure does not count").expect("it has a list of its own");
    assert!(unknown.contains("armature of all 6 joints") && !unknown.contains("lower of"), "{unknown}");
    assert!(
        void.contains("# * lower of all 6 joints") && void.contains("# lower = \"-1.5 rad\"    # fill in: "),
        "{void}"
    );
    let free = mjcf(&[("range=\"0 2.2\"", "limited=\"false\" range=\"0 2.2\"")]);
    told(&free, "calls continuous or not limited, 0 .. 2.2 rad of `port_knee` and `star_knee`;");
    // Zeros mean that nobody knows, and a joint without a range has none to tell.
    let zeros = edited(URDF, &edits);
    let zeros = Regex::new("lower=\"[^\"]*\" upper=\"[^\"]*\"")
        .unwrap()
        .replace_all(&zeros, "lower=\"0\" upper=\"0\"")
        .into_owned();
    assert!(
        !read("urdf", &zeros, &Selection::default()).notes.iter().any(|note| note.contains("continuous"))
    );
}

#[test]
fn limits_of_zero_are_told() {
    let welded =
        urdf(&[("effort=\"30\"", "effort=\"0\""), ("lower=\"0\" upper=\"2.2\"", "lower=\"0\" upper=\"0\"")]);
    let line = told(&welded, "limits of zero are taken for unknown");
    assert!(
        line.ends_with(
            "range of `port_knee` and `star_knee`, effort of `port_ankle` and `star_ankle`; weld a joint \
             that nothing drives by leaving it \
             out of --joints"
        ),
        "{line}"
    );
    // Where no effort is known, zeros say nothing of single joints.
    let none = urdf(&[("effort=\"30\"", "effort=\"0\""), ("effort=\"50\"", "effort=\"0\"")]);
    assert!(!told(&none, "limits of zero are taken for unknown").contains("nothing drives"));
}

/// A forearm on an elbow of this type, with this between its tags.
fn forearm(kind: &str, inside: &str) -> String {
    format!(
        "<link name=\"forearm\"><inertial><mass value=\"1\"/><inertia \
         ixx=\"0.004\" iyy=\"0.004\" izz=\"0.001\"/></inertial></link>\
         <joint name=\"elbow\" type=\"{kind}\"><origin xyz=\"0 0.15 0.2\"/><parent link=\"hull\"/><child \
         link=\"forearm\"/>\
         <axis xyz=\"0 1 0\"/>{inside}</joint></robot>"
    )
}

#[test]
fn a_joint_that_is_welded_where_it_cannot_be_is_told_on_the_terminal() {
    let range = |lower: f64, upper: f64| {
        format!("<limit lower=\"{lower}\" upper=\"{upper}\" effort=\"9\" velocity=\"9\"/>")
    };
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("heron.urdf"),
        edited(URDF, &[("</robot>", &forearm("revolute", &range(-2.4, -0.5)))]),
    )
    .unwrap();
    let output = specforge(folder.path()).args(["robot", "import", "heron.urdf"]).assert().success();
    let printed = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(
        printed.contains("welded at zero, which is outside of the joint's range: `elbow` (-2.4 .. -0.5 rad)"),
        "{printed}"
    );
    let slide = urdf(&[("</robot>", &forearm("prismatic", &range(0.1, 0.3)))]);
    told(&slide, "outside of the joint's range: `elbow` (0.1 .. 0.3 m)");
    told(&slide, "the joints of a robot file are hinges: `elbow` (prismatic)");
    assert!(!slide.notes.iter().any(|note| note.contains("of a leg")), "{:?}", slide.notes);
    let inside = urdf(&[("</robot>", &forearm("revolute", &range(-2.4, 0.0)))]);
    assert!(!inside.notes.iter().any(|note| note.contains("welded")), "{:?}", inside.notes);
    // A joint that is kept can be where it is put.
    let joints = Some(Regex::new(".").unwrap());
    let text = edited(URDF, &[("</robot>", &forearm("revolute", &range(-2.4, -0.5)))]);
    let kept = read("urdf", &text, &Selection { joints, ..Selection::default() });
    assert!(!kept.notes.iter().any(|note| note.contains("outside")), "{:?}", kept.notes);
    let arm = "<body name=\"arm\"><joint name=\"elbow\" axis=\"0 1 0\" range=\"0.5 2\"/>\
        <inertial mass=\"2\" pos=\"0 0 0\" diaginertia=\"0.01 0.01 0.01\"/></body><body name=\"port_thigh\"";
    told(
        &mjcf(&[("<body name=\"port_thigh\"", arm)]),
        "outside of the joint's range: `elbow` (0.5 .. 2 rad)",
    );
}

#[test]
fn a_sliding_joint_of_a_leg_is_told_as_what_it_is() {
    let knee = |side: &str| {
        (
            format!("name=\"{side}_knee\" type=\"revolute\""),
            format!("name=\"{side}_knee\" type=\"prismatic\""),
        )
    };
    let [port, star] = ["port", "star"].map(knee);
    let welded = urdf(&[(&port.0, &port.1), (&star.0, &star.1)]);
    let line = told(&welded, "the joints of a robot file are hinges");
    assert!(line.contains("`port_knee` (prismatic) of a leg, `star_knee` (prismatic) of a leg"), "{line}");
    assert!(line.contains("move differently from those of the file"), "{line}");
    assert!(!welded.notes.iter().any(|note| note.contains("independently")), "{:?}", welded.notes);
    let ball = ("name=\"star_ankle\" axis=\"0 1 0\"", "name=\"star_ankle\" type=\"ball\"");
    let slide = ("name=\"port_knee\" axis", "name=\"port_knee\" type=\"slide\" axis");
    let all = mjcf(&[slide, ball]);
    let line = told(&all, "the joints of a robot file are hinges");
    assert!(line.contains("`port_knee` (a slide joint) of a leg"), "{line}");
    assert!(line.contains("`star_ankle` (a ball joint) of a leg"), "{line}");
}

/// The exit code of an import and everything that it says.
fn imported(folder: &Path, file: &str) -> (Option<i32>, String) {
    let _ = fs::remove_dir_all(folder.join("robots"));
    let output = specforge(folder).args(["robot", "import", file]).output().unwrap();
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (output.status.code(), text.concat())
}

#[test]
fn a_leg_that_is_bent_at_zero_is_told_as_that_and_the_import_is_no_success() {
    let folder = tempfile::tempdir().unwrap();
    let knee = "name=\"port_knee\" axis";
    for (joint, angle) in
        [("port_knee", 1.0), ("port_knee", 2.0), ("port_knee", -1.5), ("port_knee", 3.0), ("star_knee", 1.5)]
    {
        let from = knee.replace("port_knee", joint);
        let to = from.replace(" axis", &format!(" ref=\"{angle}\" axis"));
        fs::write(folder.path().join("heron.xml"), edited(MJCF, &[(&from, &to)])).unwrap();
        let (code, text) = imported(folder.path(), "heron.xml");
        let bent = format!("by {:.2} rad more than the right one at `star_knee`", f64::abs(angle));
        assert!(text.contains("the left leg is bent at `port_knee`") && text.contains(&bent), "{text}");
        assert!(text.contains("the same `ref`") && !text.contains("turn the frame of"), "{text}");
        assert_eq!(code, Some(3), "{text}");
        assert!(folder.path().join("robots/heron.toml").is_file(), "it can be corrected");
    }
    // With the same zero on both sides there is no mistake.
    let both = edited(MJCF, &[("_knee\" axis", "_knee\" ref=\"1.5\" axis")]);
    fs::write(folder.path().join("heron.xml"), both).unwrap();
    let (code, text) = imported(folder.path(), "heron.xml");
    assert!(code == Some(0) && !text.contains("E0426"), "{text}");
}

#[test]
fn a_file_that_cannot_be_included_is_the_only_error() {
    let folder = tempfile::tempdir().unwrap();
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("secret.xml"), MJCF).unwrap();
    let secret = outside.path().join("secret.xml").display().to_string();
    let body =
        "<mujoco><worldbody><body name=\"a\"><geom type=\"box\" size=\"1 1 1\"/></body></worldbody></mujoco>";
    fs::write(folder.path().join("body.xml"), body).unwrap();
    fs::write(folder.path().join("broken.xml"), "<mujoco><").unwrap();
    fs::write(folder.path().join("itself.xml"), "<mujoco><include file=\"itself.xml\"/></mujoco>").unwrap();
    for (files, code) in [
        (&["gone.xml"][..], "E0414"),
        (&[secret.as_str()], "E0414"),
        (&["broken.xml"], "E0410"),
        (&["body.xml", "body.xml"], "E0414"),
        (&["itself.xml"], "E0414"),
        (&["."], "E0"),
    ] {
        let includes: String = files.iter().map(|file| format!("<include file=\"{file}\"/>")).collect();
        fs::write(folder.path().join("heron.xml"), format!("<mujoco>{includes}</mujoco>")).unwrap();
        let (exit, text) = imported(folder.path(), "heron.xml");
        assert_eq!(exit, Some(3), "{text}");
        assert!(text.matches("error[").count() == 1 && text.contains(&format!("error[{code}")), "{text}");
    }
}

#[test]
fn a_mimic_joint_is_told_on_the_terminal() {
    let welded = urdf(&[(
        "</robot>",
        &forearm("revolute", "<mimic joint=\"port_knee\" multiplier=\"2\" offset=\"1\"/>"),
    )]);
    told(&welded, "turn independently of each other: `elbow` (driven by `port_knee`)");
}

/// The heron with a second pair of legs behind the first.
fn quadruped() -> String {
    let legs = &URDF[URDF.find("  <link name=\"port_thigh\">").unwrap()..URDF.find("</robot>").unwrap()];
    let hind = legs
        .replace("port_", "hind_port_")
        .replace("star_", "hind_star_")
        .replace("xyz=\"0 0.08 0\"", "xyz=\"-0.4 0.08 0\"");
    URDF.replace("</robot>", &(hind.replace("xyz=\"0 -0.08 0\"", "xyz=\"-0.4 -0.08 0\"") + "</robot>"))
}

#[test]
fn legs_beyond_two_are_told() {
    let feet = || Some(["port_foot".to_owned(), "star_foot".to_owned()]);
    let named = || Selection { feet: feet(), ..Selection::default() };
    let welded = read("urdf", &quadruped(), &named());
    assert_eq!((welded.links.len(), welded.fixed.len()), (6, 6));
    let line = told(&welded, "a robot has two feet");
    assert!(
        line.contains(
            "2 legs more dropped, `hind_port_foot` and `hind_star_foot`, whose 6 joints are welded"
        ),
        "{line}"
    );
    let joints = Some(Regex::new(".").unwrap());
    let all = read("urdf", &quadruped(), &Selection { joints, ..named() });
    told(&all, "2 legs more without a foot");
    // Crouching legs are as high as an arm, and as heavy as the others.
    let crouched = quadruped().replace(
        "<origin xyz=\"0 0 -0.26\"/><parent link=\"hind",
        "<origin xyz=\"0 0 0.2\"/><parent link=\"hind",
    );
    told(&read("urdf", &crouched, &named()), "2 legs more dropped");
    assert!(!urdf(&[]).notes.iter().any(|note| note.contains("two feet")));
    for text in [quadruped(), crouched] {
        let said = refused("urdf", &text);
        assert!(said.contains("error[E0427]: the robot has 4 legs: "), "{said}");
        assert!(
            said.contains("`hind_star_foot`") && said.contains("name them with --feet LEFT,RIGHT"),
            "{said}"
        );
    }
}

#[test]
fn a_robot_of_arms_alone_is_no_biped_unless_its_feet_are_named() {
    let arms =
        edited(URDF, &[("hip", "shoulder"), ("knee", "elbow"), ("ankle", "wrist"), ("thigh", "upper_arm")]);
    let arms = edited(&arms, &[("shank", "forearm"), ("foot", "gripper")]);
    let said = refused("urdf", &arms);
    assert!(said.contains("error[E0427]: the robot has no legs: by their names `port_gripper`"), "{said}");
    let feet = Some(["port_gripper".to_owned(), "star_gripper".to_owned()]);
    assert_eq!(read("urdf", &arms, &Selection { feet, ..Selection::default() }).links.len(), 6);
}

/// The heron with arms, and key frames: one lying, one standing with the arms turned.
fn with_keys(base: &str) -> String {
    let arm = "<body name=\"arm\" pos=\"0 0 0.3\"><joint name=\"elbow\" axis=\"0 1 0\" range=\"0.5 2\"/>\
        <inertial mass=\"2\" pos=\"0 0 -0.2\" diaginertia=\"0.01 0.01 0.001\"/></body><body \
        name=\"port_thigh\"";
    let keys = format!(
        "<keyframe><key name=\"lying\" qpos=\"0 0 0.1 1 0 0 0 0 0 0 0 0 0 0\"/>\
         <key name=\"stand\" qpos=\"0 0 0.5 {base} 1 -0.3 0.6 -0.3 -0.3 0.6 -0.3\"/></keyframe></mujoco>"
    );
    edited(MJCF, &[("<body name=\"port_thigh\"", arm), ("</mujoco>", &keys)])
}

/// The robot of a text with the default positions of this key frame.
fn posed(text: &str, key: Option<&str>) -> Welded {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("heron.xml");
    fs::write(&file, text).unwrap();
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let around = Folder::around(&file).unwrap();
    let tree = import::read_with_key(&file, key, &around, &mut sources, &mut sink);
    tree.and_then(|tree| import::weld(&tree, &Selection::default(), &mut sink))
        .unwrap_or_else(|| panic!("{sink:?}"))
}

#[test]
fn a_key_frame_poses_welded_joints_too_and_others_are_told() {
    let text = with_keys("1 0 0 0");
    let lying = posed(&text, None);
    told(&lying, "default positions are those of the key frame `lying`; --key takes `stand` instead");
    told(&lying, "welded at zero, which is outside of the joint's range: `elbow` (0.5 .. 2 rad)");
    let standing = posed(&text, Some("stand"));
    assert_eq!(hinge(&standing, "port_knee").default_position, Some(0.6));
    told(&standing, "welded at the positions of the key frame `stand`: `elbow` at 1 rad");
    assert!(
        !standing.notes.iter().any(|note| note.contains("outside of the joint's range")),
        "{:?}",
        standing.notes
    );
    // The arm turned by 1 rad about y: its 2 kg at (-0.2 sin 1, 0, 0.3 - 0.2 cos 1), the hull's 8 kg at 0.12
    // m.
    let com = standing.base.com;
    assert!((com.x - 2.0 * -0.2 * libm::sin(1.0) / 10.0).abs() < 1e-12, "{com}");
    assert!((com.z - (2.0 * (0.3 - 0.2 * libm::cos(1.0)) + 8.0 * 0.12) / 10.0).abs() < 1e-12, "{com}");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("heron.xml"), &text).unwrap();
    fs::write(folder.path().join("heron.urdf"), URDF).unwrap();
    for (file, names) in [("heron.xml", "`lying` and `stand`"), ("heron.urdf", "leave --key out")] {
        let output =
            specforge(folder.path()).args(["robot", "import", file, "--key", "jump"]).assert().code(3);
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(
            said.contains("error[E0402]: --key: the file has no key frame `jump`") && said.contains(names),
            "{said}"
        );
    }
}

#[test]
fn a_fill_without_effect_is_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("heron.xml"), with_keys("1 0 0 0")).unwrap();
    let fills = ["friction=9 N*m", "hip:default_position=-0.2 rad", "velocity_limit=10 rad/s"];
    let mut import = specforge(folder.path());
    import.args(["robot", "import", "heron.xml", "--key", "stand"]);
    for fill in fills {
        import.args(["--fill", fill]);
    }
    let output = import.assert().success();
    let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert_eq!(said.matches("warning[W0420]").count(), 2, "{said}");
    assert!(said.contains("`friction=9 N*m` has no effect: the file says this figure"), "{said}");
    assert!(
        said.contains(
            "`hip:default_position=-0.2 rad` has no effect: default positions are those of the key frame \
             `stand`"
        ),
        "{said}"
    );
}

#[test]
fn a_robot_that_is_fixed_to_the_world_floats_and_that_is_told() {
    told(
        &mjcf(&[("<freejoint/>", "")]),
        "`hull` is fixed to the world in the file (no freejoint): the base of a robot floats",
    );
    assert!(!mjcf(&[]).notes.iter().any(|note| note.contains("fixed to the world")));
}

#[test]
fn targets_of_a_servo_bound_no_torque_and_are_no_remark() {
    let knee = "<motor name=\"port_knee\" joint=\"port_knee\" gear=\"50\" ctrlrange=\"-1 1\"/>";
    let servo = mjcf(&[(knee, "<position joint=\"port_knee\" kp=\"100\" ctrlrange=\"-0.3 1.35\"/>")]);
    assert_eq!(hinge(&servo, "port_knee").effort_limit, None);
    assert!(!servo.notes.iter().any(|note| note.contains("is limited to")), "{:?}", servo.notes);
    let motor = mjcf(&[(knee, "<motor joint=\"port_knee\" gear=\"50\" ctrlrange=\"-0.3 1.35\"/>")]);
    told(&motor, "is limited to -0.3 .. 1.35; the smaller bound is taken for both");
}

#[test]
fn round_feet_are_told_and_wheels_are_a_warning() {
    let foot = "<origin xyz=\"0.03 0 -0.045\"/><geometry><box size=\"0.18 0.08 0.02\"/></geometry>";
    let shod = |shape: &str| urdf(&[(foot, shape)]).notes;
    let says = |notes: &[String], words: &str| notes.iter().filter(|note| note.contains(words)).count();
    let ball = "<origin xyz=\"0 0.01 -0.045\"/><geometry><sphere radius=\"0.01\"/></geometry>";
    assert_eq!(says(&shod(ball), "its lowest shape, a sphere, touches the ground in a point"), 2);
    let lying = |kind: &str| {
        format!(
            "<origin xyz=\"0.03 0 -0.045\" rpy=\"0 1.5707963 0\"/><geometry><{kind} \
             radius=\"0.02\" length=\"0.15\"/></geometry>"
        )
    };
    for kind in ["capsule", "cylinder"] {
        assert_eq!(
            says(&shod(&lying(kind)), "touches the ground in a line; a sole is a flat box"),
            2,
            "{kind}"
        );
    }
    for flat in
        [foot, "<origin xyz=\"0 0 -0.045\"/><geometry><cylinder radius=\"0.05\" length=\"0.02\"/></geometry>"]
    {
        assert_eq!(says(&shod(flat), "touches the ground in"), 0, "{flat}");
    }
    let wheel = "<origin xyz=\"0 0 0\" rpy=\"1.5707963 0 0\"/><geometry><cylinder \
        radius=\"0.05\" length=\"0.04\"/></geometry>";
    let folder = tempfile::tempdir().unwrap();
    for (shape, warns) in [(wheel, true), (foot, false), (ball, false)] {
        let _ = fs::remove_dir_all(folder.path().join("robots"));
        fs::write(folder.path().join("heron.urdf"), edited(URDF, &[(foot, shape)])).unwrap();
        let output = specforge(folder.path()).args(["robot", "import", "heron.urdf"]).assert().success();
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert_eq!(said.contains("warning[W0419]: the foot `port_foot` is a wheel"), warns, "{said}");
    }
}

#[test]
fn the_lines_of_a_missing_sole_offer_the_image_of_the_other_one() {
    let masked = ("<geom name=\"port_sole\"", "<geom contype=\"0\" conaffinity=\"0\" name=\"port_sole\"");
    let welded = mjcf(&[masked, ("pos=\"0.03 0 -0.045\"", "pos=\"0.03 0.004 -0.045\"")]);
    let origin = import::Origin { name: "heron", source: "heron.xml", format: "MJCF", fills: &[] };
    let text = import::text(&welded, &origin).text;
    let offered = |key: &str, value: &str| {
        let line =
            text.lines().find(|line| line.starts_with(&format!("# {key} = "))).expect("a line to fill in");
        assert!(line.contains(value) && line.contains("the mirror image of the other foot's"), "{line}");
    };
    offered("half_extents", "[\"0.09 m\", \"0.04 m\", \"0.01 m\"]");
    offered("centre", "[\"0.03 m\", \"-0.004 m\", \"-0.045 m\"]");
}

#[test]
fn bodies_that_lose_their_shapes_are_told() {
    let trunk = "<box size=\"0.16 0.2 0.26\"/>";
    let line_of = |to: &str| told(&urdf(&[(trunk, to)]), "no collision shape is left of `hull`").to_owned();
    line_of("<mesh filename=\"missing.stl\"/>");
    line_of("<cone radius=\"1\" length=\"1\"/>");
    let none = urdf(&[(trunk, "<mesh filename=\"missing.stl\"/>")]);
    told(&none, "no body but the feet has a collision shape: self-collisions cannot be found");
    let empty = urdf(&[("<geometry><box size=\"0.16 0.2 0.26\"/></geometry>", "")]);
    told(&empty, "`hull`: a collision without a shape is left out");
    told(&empty, "no collision shape is left of `hull`");
}

#[test]
fn a_quaternion_of_urdf_turns_as_angles_do_and_an_unknown_version_is_told() {
    let hip = "<origin xyz=\"0 0.08 0\"/>";
    let turned = |origin: &str, version: &str| {
        urdf(&[(hip, origin), ("<robot name=\"heron\">", &format!("<robot name=\"heron\"{version}>"))])
    };
    let angles = turned("<origin xyz=\"0 0.08 0\" rpy=\"0 0 1.5707963267948966\"/>", "");
    let quaternion = turned("<origin xyz=\"0 0.08 0\" quat_xyzw=\"0 0 1 1\"/>", " version=\"1.1\"");
    let pose = |welded: &Welded| welded.links[0].origin.to_homogeneous();
    assert!((pose(&angles) - pose(&quaternion)).norm() < 1e-12);
    assert!(!quaternion.notes.iter().any(|note| note.contains("version")), "{:?}", quaternion.notes);
    told(
        &turned("<origin xyz=\"0 0.08 0\" quat_xyzw=\"0 0 0 1\"/>", ""),
        "`quat_xyzw`, which URDF has since version 1.1",
    );
    told(&turned(hip, " version=\"2.0\""), "unknown URDF version \"2.0\"");
    assert!(turned(hip, " version=\"1.0\"").notes.iter().all(|note| !note.contains("version")));
    let both = edited(URDF, &[(hip, "<origin rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\"/>")]);
    assert!(refused("urdf", &both).contains("error[E0411]: an origin has `rpy` and `quat_xyzw`"));
    let zero = edited(URDF, &[(hip, "<origin quat_xyzw=\"0 0 0 0\"/>")]);
    assert!(refused("urdf", &zero).contains("`quat_xyzw` of <origin> has no length"));
}

#[test]
fn a_word_that_is_no_number_everywhere_is_one_message() {
    let efforts = Regex::new("effort=\"[^\"]*\"").unwrap();
    for (word, message) in [
        ("inf", "`effort` of <limit> is not a finite number: `inf` (and 5 more like it)"),
        ("nan", "`effort` of <limit> is not a finite number: `nan` (and 5 more like it)"),
        ("0x1F", "`effort` of <limit> is not a decimal number: `0x1F` (and 5 more like it)"),
        ("1,5", "`effort` of <limit> is not a finite number: `1,5` (and 5 more like it)"),
    ] {
        let text = efforts.replace_all(URDF, format!("effort=\"{word}\"")).into_owned();
        let said = refused("urdf", &text);
        assert!(said.matches("error[").count() == 1 && said.contains(message), "{word}: {said}");
    }
    let macros = efforts.replace_all(URDF, "effort=\"$${motor}\"").into_owned();
    let said = refused("urdf", &macros);
    assert!(
        said.matches("error[").count() == 1 && said.contains("E0410") && said.contains("xacro"),
        "{said}"
    );
}

#[test]
fn a_file_full_of_what_is_not_imported_has_few_remarks() {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let folder = tempfile::tempdir().unwrap();
    let gears: String = (0..200)
        .map(|index| {
            format!(
                "<body name=\"b{index}\"><joint \
                 name=\"j{index}\" stiffness=\"1\" margin=\"1\" oops{index}=\"1\"/>\
                 <geom name=\"g{index}\" size=\"0.1\" condim=\"1\" solref=\"0.1 1\" gap=\"1\"/></body>"
            )
        })
        .collect();
    let text = MJCF.replace("<body name=\"port_thigh\"", &(gears + "<body name=\"port_thigh\""));
    let file = folder.path().join("heron.xml");
    fs::write(&file, text).unwrap();
    let tree = import::read(&file, &Folder::around(Path::new(&file)).unwrap(), &mut sources, &mut sink)
        .expect("it is read");
    let lines: Vec<&String> = tree.notes.iter().filter(|note| note.starts_with("not imported")).collect();
    assert!(lines.len() == 3 && lines.iter().all(|line| line.len() < 600), "{lines:#?}");
}

/// Springs and rods of a linkage: Cassie's shin and tarsus.
#[test]
fn joints_of_a_leg_that_nothing_drives_are_no_motors_unless_the_user_says_so() {
    let idle = edited(
        MJCF,
        &[("    <motor name=\"port_ankle\" joint=\"port_ankle\" gear=\"50\" ctrlrange=\"-1 1\"/>\n", "")],
    );
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("heron.xml"), &idle).unwrap();
    let import = |more: &[&str]| {
        let output =
            specforge(folder.path()).args(["robot", "import", "heron.xml"]).args(more).output().unwrap();
        let told =
            [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat();
        (output.status.code(), told)
    };
    let (code, told) = import(&[]);
    assert!(
        code == Some(3) && told.contains("error[E0429]: `port_ankle` between the base and the feet has no"),
        "{told}"
    );
    assert!(!folder.path().join("robots").exists());
    // Both fixes that it names work.
    let driven = told
        .split("--joints '")
        .nth(1)
        .and_then(|rest| rest.split('\'').next())
        .expect("a pattern")
        .to_owned();
    let (code, welded) = import(&["--name", "welded", "--joints", &driven]);
    // With one ankle less than the other leg it is written, and cannot be used.
    let is_lame = welded.contains("5 joints, 1 welded") && welded.contains("error[E0405]");
    assert!(code == Some(3) && is_lame, "{welded}");
    let (code, filled) = import(&["--name", "filled", "--fill", "port_ankle:effort_limit=40 N*m"]);
    assert!(code == Some(0) && filled.contains("6 joints, 0 welded"), "{filled}");
    let (code, kept) = import(&["--name", "kept", "--joints", "hip|knee|ankle"]);
    let remark = "motors in the robot file and without an actuator in the source: `port_ankle`";
    assert!(code == Some(0) && kept.contains(remark), "{kept}");
    // A figure for all joints, or for some of which others are driven, makes no motors.
    for general in ["effort_limit=40 N*m", ".*:effort_limit=40 N*m", "ankle:effort_limit=40 N*m"] {
        let (code, told) = import(&["--name", "general", "--fill", general]);
        let help = format!(
            "help: --fill '{general}' fits driven joints, too, and gives those that nothing drives no motors"
        );
        assert!(
            code == Some(3) && told.contains("error[E0429]") && told.contains(&help),
            "{general}: {told}"
        );
        let (code, told) = import(&["--name", "general", "--joints", "hip|knee|ankle", "--fill", general]);
        let remark = format!(
            "without an actuator in the source: `port_ankle`; --fill '{general}' is for the joints that the \
             source drives"
        );
        assert!(code == Some(0) && told.contains(&remark), "{general}: {told}");
        let file = folder.path().join("robots/general.toml");
        let text = fs::read_to_string(&file).unwrap();
        assert!(
            text.contains("effort_limit of port_ankle") && !text.contains("\"40 N*m\""),
            "{general}: {text}"
        );
        fs::remove_file(file).unwrap();
    }
    let (code, told) = import(&[
        "--name",
        "both",
        "--fill",
        "effort_limit=30 N*m",
        "--fill",
        "port_ankle:effort_limit=40 N*m",
    ]);
    assert!(code == Some(0) && told.contains("6 joints, 0 welded"), "{told}");
    // A file without any actuator says nothing of them.
    let start = MJCF.find("  <actuator>").expect("it has them");
    let end = MJCF.find("</actuator>").expect("they end") + "</actuator>".len();
    fs::write(folder.path().join("heron.xml"), [&MJCF[..start], &MJCF[end..]].concat()).unwrap();
    let (code, without) = import(&["--name", "without"]);
    assert!(code == Some(0) && !without.contains("without an actuator"), "{without}");
}

/// The frame of the base stays where its legs say that it is upright; that the file has it turned is told.
#[test]
fn a_base_that_does_not_stand_upright_in_the_file_is_told_with_its_angle() {
    let base = "<body name=\"hull\" ";
    let feet = Some(["port_foot".to_owned(), "star_foot".to_owned()]);
    let selection = Selection { feet, ..Selection::default() };
    let turned = |by: &str| read("xml", &edited(MJCF, &[(base, &format!("{base}{by} "))]), &selection);
    let upright = turned("");
    for (by, told_as) in [
        (
            "euler=\"3.14159265358979 0 0\"",
            "turned by 180.0 degrees about (1, 0, 0), with its z axis 180.0 degrees from up",
        ),
        (
            "euler=\"0 0.610865238198015 0\"",
            "turned by 35.0 degrees about (0, 1, 0), with its z axis 35.0 degrees from up",
        ),
    ] {
        let welded = turned(by);
        let remark = told(&welded, "in the source the base is");
        assert!(remark.contains(told_as), "{remark}");
        assert_eq!(welded.links.len(), upright.links.len());
    }
    for by in ["", "euler=\"0 0 1.2\""] {
        let notes = turned(by).notes;
        assert!(!notes.iter().any(|note| note.contains("in the source the base is")), "{by}: {notes:#?}");
    }
}

/// The heron with springs in its ankles, which hang on rods from the shanks: nothing drives them.
fn sprung(springref: &str, more: &str) -> String {
    let motor = |side: &str| {
        format!("    <motor name=\"{side}_ankle\" joint=\"{side}_ankle\" gear=\"50\" ctrlrange=\"-1 1\"/>\n")
    };
    let spring = format!("range=\"-1.1 0.9\" stiffness=\"90\" springref=\"{springref}\"/>");
    edited(
        MJCF,
        &[
            (&motor("port"), ""),
            (&motor("star"), ""),
            ("range=\"-1.1 0.9\"/>", &spring),
            ("</mujoco>", &format!("{more}</mujoco>")),
        ],
    )
}

/// Linkages of Cassie's kind.
#[test]
fn closed_loops_and_what_follows_a_driven_joint_are_told_with_passive_joints() {
    let ties = "<equality>\
        <connect name=\"port_rod\" body1=\"port_thigh\" body2=\"port_foot\" anchor=\"0 0 0\"/>\
        <connect body1=\"star_thigh\" body2=\"star_foot\" anchor=\"0 0 0\"/>\
        <joint joint1=\"port_ankle\" joint2=\"port_knee\" polycoef=\"0 -1 0 0 0\"/></equality>";
    let said = refused("xml", &sprung("0", ties));
    for words in [
        "error[E0429]: `port_ankle` and `star_ankle` between the base and the feet have no actuator",
        "`port_thigh` to `port_foot` (<connect> port_rod), `star_thigh` to `star_foot` (<connect>)",
        "`port_ankle` follows `port_knee`",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // Without ties nothing is said of them, and a pose that the joints cannot have is told before they are
    // welded there.
    let said = refused("xml", &sprung("0", ""));
    assert!(!said.contains("loops") && !said.contains("follows") && !said.contains("outside"), "{said}");
    let said = refused("xml", &sprung("0", "").replace("-1.1 0.9", "0.2 0.9"));
    assert!(
        said.contains(
            "`port_ankle` and `star_ankle` would be outside of the range there, so give the file a key"
        ),
        "{said}"
    );
}

#[test]
fn a_passive_joint_is_welded_where_its_spring_is_at_rest() {
    let joints = || Selection { joints: Some(Regex::new("hip|knee").unwrap()), ..Selection::default() };
    let tilt = |welded: &Welded| {
        let notes: Vec<&String> =
            welded.notes.iter().filter(|note| note.contains("springs are at rest")).collect();
        (notes.len(), welded.feet.map(|(link, _)| welded.links[link].body.com))
    };
    let (told_at_zero, flat) = tilt(&read("xml", &sprung("0", ""), &joints()));
    let bent = read("xml", &sprung("-0.4", ""), &joints());
    let line = told(&bent, "springs are at rest");
    assert_eq!(
        line,
        "welded where their springs are at rest, because nothing drives them: `port_ankle` at -0.4 rad, \
         `star_ankle` at -0.4 rad"
    );
    let (told_bent, tipped) = tilt(&bent);
    assert_eq!([told_at_zero, told_bent], [0, 1]);
    assert!((flat[0] - tipped[0]).norm() > 1e-4, "{flat:?} {tipped:?}");
    // The same foot by hand: its centre of mass is at (0.02, 0, -0.03) about the ankle, which is 0.25 m below
    // the knee. It weighs a third of what moves with the shank, whose own centre is 0.11 m below the knee.
    let (sine, cosine) = (-0.4_f64).sin_cos();
    let foot = [0.02 * cosine - 0.03 * sine, -0.25 - 0.02 * sine - 0.03 * cosine];
    let [x, z] = [foot[0] / 3.0, (foot[1] - 2.0 * 0.11) / 3.0];
    let seen = bent.links.iter().find(|link| link.body.name == "port_shank").expect("it moves").body.com;
    assert!((seen.coords.norm() - x.hypot(z)).abs() < 1e-9, "{seen} is not {x} {z}");
    // A key frame says more than a spring.
    let key = "<keyframe><key name=\"home\" qpos=\"0 0 0.56 1 0 0 0 0 0 -0.2 0 0 -0.2\"/></keyframe>";
    let at_key = read("xml", &sprung("-0.4", key), &joints());
    assert!(!at_key.notes.iter().any(|note| note.contains("springs are at rest")), "{:?}", at_key.notes);
    told(&at_key, "welded at the positions of the key frame `home`: `port_ankle` at -0.2 rad");
}

/// The diagnostics of a description that is read and welded, warnings too.
fn diagnosed(ending: &str, text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("heron.{ending}"));
    fs::write(&file, text).unwrap();
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let tree = import::read(&file, &Folder::around(&file).unwrap(), &mut sources, &mut sink);
    let _ = tree.and_then(|tree| import::weld(&tree, &Selection::default(), &mut sink));
    human(&sources, &sink.diagnostics, Look::default())
}

#[test]
fn a_motor_with_a_gear_or_a_gain_of_zero_leaves_its_limit_to_be_filled_in() {
    let weak = "name=\"port_knee\" joint=\"port_knee\" gear=\"50\"";
    for (from, to) in [
        (weak, "name=\"port_knee\" joint=\"port_knee\" gear=\"0\""),
        (weak, "name=\"port_knee\" joint=\"port_knee\" gear=\"0 0 0 50 0 0\""),
    ] {
        let welded = mjcf(&[(from, to)]);
        assert_eq!(hinge(&welded, "port_knee").effort_limit, None, "{to}");
        assert_eq!(hinge(&welded, "star_knee").effort_limit, Some(50.0));
        assert_eq!(told(&welded, "limits of zero"), told(&welded, "effort of `port_knee`"));
    }
    let general = MJCF.replace(
        "<motor name=\"port_knee\" joint=\"port_knee\" gear=\"50\" ctrlrange=\"-1 1\"/>",
        "<general name=\"port_knee\" joint=\"port_knee\" gear=\"50\" gainprm=\"0\" ctrlrange=\"-1 1\"/>",
    );
    let welded = read("xml", &general, &Selection::default());
    assert_eq!(hinge(&welded, "port_knee").effort_limit, None);
}

#[test]
fn a_key_frame_has_as_many_positions_as_the_file() {
    let with = |positions: &str| {
        MJCF.replace(
            "</mujoco>",
            &format!("<keyframe><key name=\"home\" qpos=\"{positions}\"/></keyframe></mujoco>"),
        )
    };
    let right = with("0 0 0.5 1 0 0 0 -0.3 0.6 -0.3 -0.3 0.6 -0.3");
    assert!(!diagnosed("xml", &right).contains("error"), "{}", diagnosed("xml", &right));
    for (positions, count) in [
        ("0 0 0.5 1 0 0 0", 7),
        ("-0.3 0.6 -0.3 -0.3 0.6 -0.3", 6),
        ("0 0 0.5 1 0 0 0 -0.3 0.6 -0.3 -0.3 0.6", 12),
        ("0 0 0.5 1 0 0 0 -0.3 0.6 -0.3 -0.3 0.6 -0.3 0", 14),
    ] {
        let said = refused("xml", &with(positions));
        let expected =
            format!("`qpos` of the key frame `home` has {count} numbers, and the file has 13 positions");
        assert!(said.contains("error[E0411]") && said.contains(&expected), "{said}");
    }
}

#[test]
fn a_robot_floats_once() {
    let free = "<joint name=\"port_knee\" axis=\"0 1 0\" range=\"0 2.2\" />";
    for (text, expected) in [
        (MJCF.replace("<freejoint/>", "<freejoint/><freejoint name=\"again\"/>"), "`hull` has 2 free joints"),
        (
            MJCF.replace("<freejoint/>", "<freejoint/><joint name=\"more\" axis=\"0 0 1\"/>"),
            "`hull` has a free joint and other joints beside it",
        ),
        (MJCF.replace(free, "<freejoint/>"), "`port_shank` has a free joint and hangs on another body"),
        (
            MJCF.replace(free, "<joint name=\"port_knee\" type=\"free\"/>"),
            "`port_shank` has a free joint and hangs on another body",
        ),
        (
            MJCF.replace(
                "</worldbody>",
                "<body name=\"ball\"><freejoint/><geom size=\"0.1\"/></body></worldbody>",
            ),
            "several bodies of the world have free joints",
        ),
    ] {
        let said = refused("xml", &text);
        assert!(said.contains("error[E0412]") && said.contains(expected), "{said}");
    }
}

#[test]
fn ranges_in_degrees_that_look_like_radians_are_told() {
    let silent = MJCF.replace(" angle=\"radian\"", "");
    let said = diagnosed("xml", &silent);
    assert!(
        said.contains("warning[W0425]: no joint turns further than 2.2 degrees: <compiler> says no"),
        "{said}"
    );
    let said = diagnosed("xml", &MJCF.replace("\"radian\"", "\"degree\""));
    assert!(said.contains("warning[W0425]") && said.contains("`angle` is degree"), "{said}");
    let said = diagnosed("xml", &MJCF.replace("<compiler angle=\"radian\"/>", ""));
    assert!(said.contains("warning[W0425]"), "{said}");
    assert!(!diagnosed("xml", MJCF).contains("W0425"));
    // Ranges that are degrees.
    let degrees =
        silent.replace("-1.5 0.9", "-86 52").replace("0 2.2", "0 126").replace("-1.1 0.9", "-63 52");
    assert!(!diagnosed("xml", &degrees).contains("W0425"), "{}", diagnosed("xml", &degrees));
}
