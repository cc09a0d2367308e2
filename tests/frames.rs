//! Frames of other conventions: a robot whose frames are turned is the same robot everywhere.

#[path = "frames/draft.rs"]
#[allow(missing_docs, reason = "of a test")]
mod draft;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use draft::{Draft, SOLES, Sole, Solid, anyhow, stork};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use regex_lite::Regex;
use specforge::diag::render::{Look, human};
use specforge::diag::{Sink, Sources};
use specforge::kinds::motion::{self, Frame};
use specforge::robot::Proportions;
use specforge::robot::import::{self, Fill, Folder, Origin, Selection};
use specforge::robot::{self, Kinematics, Robot, Shape, Support, leg_length};
use specforge::scaffold::{Wish, alone};
use specforge::stream::Stream;

/// Largest difference of a figure.
const EXACT: f64 = 1e-9;
/// The same where a mesh is part of it, whose points have seven digits.
const ROUNDED: f64 = 1e-6;

fn fill(joints: Option<&str>, key: &str, value: &str) -> Fill {
    Fill { joints: joints.map(|joints| Regex::new(joints).unwrap()), key: key.into(), value: value.into() }
}

/// What neither format says.
fn fills() -> Vec<Fill> {
    vec![
        fill(None, "armature", "0.02 kg*m^2"),
        fill(None, "velocity_limit", "10 rad/s"),
        fill(None, "stiffness_gain", "250 N*m/rad"),
        fill(None, "damping_gain", "5 N*m*s/rad"),
        fill(None, "default_position", "0 rad"),
        fill(Some("hip_pitch"), "default_position", "-0.3 rad"),
        fill(Some("knee"), "default_position", "0.6 rad"),
        fill(Some("ankle_pitch"), "default_position", "-0.3 rad"),
    ]
}

/// A robot that was imported, its file without the remarks at its head, and those.
struct Imported {
    robot: Robot,
    text: String,
    notes: Vec<String>,
    warnings: Vec<String>,
}

/// Imports a draft, or renders what is wrong with it.
fn import(draft: &Draft, format: &str, selection: Selection) -> Result<Imported, String> {
    import_with(draft, format, selection, &[])
}

/// The same with more figures filled in.
fn import_with(draft: &Draft, format: &str, selection: Selection, more: &[Fill]) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    match format {
        "urdf" => draft.urdf(folder.path(), "copy"),
        _ => draft.mjcf(folder.path(), "copy"),
    }
    let file = folder.path().join(format!("copy.{}", if format == "urdf" { "urdf" } else { "xml" }));
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let tree = import::read(&file, &Folder::around(&file).unwrap(), &mut sources, &mut sink);
    let fills = fills().into_iter().chain(more.iter().cloned()).collect();
    let selection = Selection { fills, ..selection };
    let welded = tree.and_then(|tree| import::weld(&tree, &selection, &mut sink));
    let said = human(&sources, &sink.diagnostics, Look::default());
    let welded = welded.ok_or_else(|| said.clone())?;
    let origin = Origin { name: "copy", source: "source", format: "XML", fills: &selection.fills };
    let written = import::text(&welded, &origin);
    assert_eq!(written.missing, [""; 0]);
    let (mut sources, mut loading) = (Sources::default(), Sink::default());
    let source = sources.add(Path::new("copy.toml"), written.text.clone());
    let robot = robot::load("copy", &sources, source, &mut loading);
    let robot = robot.ok_or_else(|| human(&sources, &loading.diagnostics, Look::default()))?;
    let text = written.text.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    let warnings = sink.diagnostics.iter().map(|told| told.code.to_owned() + ": " + &told.message).collect();
    Ok(Imported { robot, text, notes: written.notes, warnings })
}

fn sound(draft: &Draft, format: &str) -> Imported {
    import(draft, format, Selection::default()).unwrap_or_else(|said| panic!("{said}"))
}

/// The steepest tilt of a sole in the default pose, in rad.
fn tilt(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    let normals = [0, 1].map(|side| kinematics.sole(side).rotation * Vector3::z());
    normals
        .map(|normal| libm::atan2(libm::hypot(normal.x, normal.y), normal.z))
        .into_iter()
        .fold(0.0, f64::max)
}

/// Everything that a program does with a robot's frames, in numbers: what turns with no frame of a link.
fn behaviour(robot: &Robot) -> Vec<(String, Vec<f64>)> {
    let mut all = vec![
        ("standing height".to_owned(), vec![robot.standing_height]),
        ("leg length".to_owned(), leg_length(robot).into_iter().collect()),
        ("mirror".to_owned(), robot.mirror.iter().flat_map(|(image, sign)| [*image as f64, *sign]).collect()),
        ("feet".to_owned(), robot.feet.iter().map(|foot| foot.link as f64).collect()),
        ("tilt".to_owned(), vec![tilt(robot)]),
        ("margin".to_owned(), vec![Support::standing_margin(robot)]),
        ("base".to_owned(), robot.base.com.iter().chain(robot.base.inertia.iter()).copied().collect()),
    ];
    for foot in &robot.feet {
        let sole = foot.half_extents.iter().chain(foot.centre.iter()).copied().collect();
        all.push((format!("sole of {}", foot.link), sole));
    }
    let mut kinematics = Kinematics::new(robot);
    let mut stream = Stream::new("test/frames/poses");
    for pose in 0..5 {
        let position: Vec<f64> =
            robot.default_pose().iter().map(|rest| rest + 0.2 * stream.normal()).collect();
        kinematics.place(&Isometry3::translation(0.1, 0.2, 0.3), &position);
        for side in 0..2 {
            let sole = kinematics.sole(side).to_homogeneous();
            all.push((format!("sole {side} in pose {pose}"), sole.iter().copied().collect()));
        }
        all.push((format!("centre of mass in pose {pose}"), kinematics.com().iter().copied().collect()));
        all.push((format!("masses in pose {pose}"), kinematics.mass_matrix().iter().copied().collect()));
    }
    all
}

/// The robot's reference motions, in numbers.
fn motions(robot: &Robot) -> Vec<(String, Vec<f64>)> {
    let mut frame = Frame::default();
    let mut all = Vec::new();
    for name in ["walk", "squat", "run_gait"] {
        let motion = motion::shipped(name, robot).expect("it is shipped");
        let motion = motion.unwrap_or_else(|error| panic!("{name}: {error}"));
        for step in 0..20 {
            motion.at(f64::from(step) / 20.0, &mut frame);
            all.push((format!("{name} at {step}"), frame.position.clone()));
        }
    }
    all
}

fn same_numbers(found: &[(String, Vec<f64>)], expected: &[(String, Vec<f64>)], exact: f64, what: &str) {
    for ((name, found), (_, expected)) in found.iter().zip(expected) {
        assert_eq!(found.len(), expected.len(), "{what}: {name}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < exact * (1.0 + expected.abs()),
                "{what}: {name}: {found} is not {expected}"
            );
        }
    }
}

/// A robot that others are compared with.
struct Reference {
    imported: Imported,
    behaviour: Vec<(String, Vec<f64>)>,
    motions: Vec<(String, Vec<f64>)>,
    specs: Vec<String>,
    exact: f64,
}

impl Reference {
    fn new(draft: &Draft, format: &str) -> Self {
        let imported = sound(draft, format);
        let robot = &imported.robot;
        let mesh = |solid: &Solid| matches!(solid, Solid::Mesh(_));
        let is_rounded = draft.bodies.iter().flat_map(|body| &body.solids).any(|(solid, _)| mesh(solid));
        let exact = if is_rounded { ROUNDED } else { EXACT };
        let (behaviour, motions, specs) = (behaviour(robot), motions(robot), new_specs(robot));
        Self { imported, behaviour, motions, specs, exact }
    }

    /// Tells where a robot is another one.
    fn compare(&self, other: &Imported, what: &str) {
        // The same file is the same robot.
        if other.text != self.imported.text {
            same_numbers(&behaviour(&other.robot), &self.behaviour, self.exact, what);
            assert_eq!(new_specs(&other.robot), self.specs, "{what}");
        }
    }

    /// The same with reference motions, which take their time.
    fn compare_motions(&self, other: &Imported, what: &str) {
        self.compare(other, what);
        same_numbers(&motions(&other.robot), &self.motions, self.exact, what);
    }
}

/// What `new` writes for a robot.
fn new_specs(robot: &Robot) -> Vec<String> {
    let wish = |task: &str, action: &str| Wish {
        name: "try".into(),
        robot: "copy".into(),
        task: task.into(),
        action: action.into(),
        build: Some(Proportions::of(robot)),
        motion: None,
    };
    ["walk", "squat", "run"]
        .iter()
        .flat_map(|task| ["torque", "position"].map(|action| alone(&wish(task, action))))
        .collect()
}

/// A quarter, a half or any other turn.
fn turns(stream: &mut Stream) -> Vec<UnitQuaternion<f64>> {
    let about =
        |axis: Vector3<f64>, degrees: f64| UnitQuaternion::from_scaled_axis(axis * degrees.to_radians());
    let mut turns = vec![
        about(Vector3::x(), 90.0),
        about(Vector3::y(), -90.0),
        about(Vector3::z(), 90.0),
        about(Vector3::x(), 180.0),
        about(Vector3::y(), 180.0),
        about(Vector3::z(), 180.0),
        about(Vector3::z(), 20.0),
        about(Vector3::y(), 17.0),
        about(Vector3::x(), -3.0),
    ];
    turns.extend((0..4).map(|_| anyhow(stream)));
    turns
}

#[test]
fn a_frame_that_follows_the_convention_stays_as_it_is() {
    for sole in SOLES {
        for format in ["urdf", "mjcf"] {
            let imported = sound(&stork(sole), format);
            let told =
                imported.notes.iter().filter(|note| note.contains("turned") || note.contains("skipped"));
            assert_eq!(told.collect::<Vec<_>>(), [""; 0], "{sole:?}");
            assert!(
                (imported.robot.standing_height - 0.6605).abs() < 1e-3,
                "{}",
                imported.robot.standing_height
            );
            assert!(tilt(&imported.robot) < EXACT);
        }
    }
}

#[test]
fn a_robot_with_turned_feet_is_the_same_robot() {
    let mut stream = Stream::new("test/frames/feet");
    for sole in SOLES {
        for format in ["urdf", "mjcf"] {
            let plain = Reference::new(&stork(sole), format);
            for (case, turn) in turns(&mut stream).into_iter().enumerate() {
                let mut draft = stork(sole);
                // Both feet the same way, or each one its own.
                let other = if case % 2 == 0 { turn } else { anyhow(&mut stream) };
                for (foot, turn) in [("left_foot", turn), ("right_foot", other)] {
                    draft.turn(draft.find(foot), turn);
                }
                let turned = sound(&draft, format);
                let what = format!("{sole:?} in {format} turned by {turn}");
                plain.compare(&turned, &what);
                let told =
                    turned.notes.iter().filter(|note| note.contains("the frame of this foot was turned by"));
                assert!((1..=2).contains(&told.count()), "{what}: {:?}", turned.notes);
                // Round figures come out to the bit.
                if sole != Sole::Mesh && case < 6 && case % 2 == 0 {
                    assert_eq!(turned.text, plain.imported.text, "{what}");
                }
            }
        }
    }
}

#[test]
fn a_robot_with_a_turned_base_is_the_same_robot() {
    let mut stream = Stream::new("test/frames/base");
    for sole in SOLES {
        for format in ["urdf", "mjcf"] {
            let plain = Reference::new(&stork(sole), format);
            for turn in turns(&mut stream) {
                let mut draft = stork(sole);
                draft.turn(0, turn);
                let turned = sound(&draft, format);
                let what = format!("{sole:?} in {format} turned by {turn}");
                plain.compare(&turned, &what);
                let told = turned
                    .notes
                    .iter()
                    .filter(|note| note.contains("`torso`: the frame of the base was turned by"));
                assert_eq!(told.count(), 1, "{what}: {:?}", turned.notes);
                assert!(
                    turned
                        .notes
                        .iter()
                        .any(|note| note.contains("`left_foot` and `right_foot` are the ends")),
                    "{what}"
                );
            }
        }
    }
}

#[test]
fn a_robot_with_all_frames_turned_is_the_same_robot() {
    let mut stream = Stream::new("test/frames/all");
    for sole in SOLES {
        for format in ["urdf", "mjcf"] {
            let plain = Reference::new(&stork(sole), format);
            for _ in 0..3 {
                let mut draft = stork(sole);
                (0..draft.bodies.len()).for_each(|body| draft.turn(body, anyhow(&mut stream)));
                plain.compare_motions(&sound(&draft, format), &format!("{sole:?} in {format}"));
            }
        }
    }
}

#[test]
fn a_root_without_mass_is_skipped() {
    let mut stream = Stream::new("test/frames/root");
    for format in ["urdf", "mjcf"] {
        let plain = Reference::new(&stork(Sole::Box), format);
        for footprints in [vec!["base_footprint"], vec!["world", "base_footprint", "base_link"]] {
            for turn in turns(&mut stream) {
                let mut draft = stork(Sole::Box);
                draft.root = Isometry3::translation(0.1, -0.2, 0.66);
                draft.footprints = footprints.clone();
                draft.turn(0, turn);
                let turned = sound(&draft, format);
                assert_eq!(turned.robot.base.name, "torso");
                plain.compare(&turned, &format!("{format} turned by {turn}"));
                let told = turned.notes.iter().find(|note| note.contains("skipped: the base is `torso`"));
                assert!(
                    told.is_some_and(|told| footprints.iter().all(|name| told.contains(name))),
                    "{:?}",
                    turned.notes
                );
            }
        }
    }
}

#[test]
fn where_along_its_axis_a_joint_has_its_origin_changes_nothing() {
    let mut stream = Stream::new("test/frames/slides");
    for sole in [Sole::Box, Sole::Mesh] {
        for format in ["urdf", "mjcf"] {
            let plain = Reference::new(&stork(sole), format);
            for turn in turns(&mut stream) {
                let mut draft = stork(sole);
                let names: Vec<String> = draft.bodies.iter().map(|body| body.name.clone()).collect();
                // Each joint of one leg or of the other one, by centimetres.
                for name in
                    names.iter().filter(|name| name.starts_with(["left", "right"][usize::from(turn.w > 0.9)]))
                {
                    draft.slide(draft.find(name), 0.05 + 0.01 * stream.normal());
                }
                draft.turn(0, turn);
                let slid = sound(&draft, format);
                let what = format!("{sole:?} in {format} turned by {turn}");
                plain.compare(&slid, &what);
                let told = slid.notes.iter().filter(|note| note.contains("moved along their own axes"));
                assert_eq!(told.count(), 1, "{what}: {:?}", slid.notes);
                for (a, b) in slid.robot.links.iter().zip(&plain.imported.robot.links) {
                    let apart =
                        (a.joint.origin.translation.vector - b.joint.origin.translation.vector).norm();
                    assert!(apart < plain.exact, "{what}: {} is {apart} off", a.joint.name);
                }
            }
        }
    }
}

#[test]
fn a_leg_of_pitch_joints_alone_may_have_its_origins_anywhere_too() {
    let mut draft = stork(Sole::Box);
    // Nothing but places says where the middle is.
    for joint in draft.bodies.iter_mut().filter_map(|body| body.joint.as_mut()) {
        joint.axis = Vector3::y();
    }
    let plain = sound(&draft, "urdf");
    let mut slid = draft.clone();
    slid.slide(slid.find("left_knee_link"), 0.05);
    slid.slide(slid.find("right_hip_yaw_link"), -0.04);
    for degrees in [0.0, 90.0, 180.0] {
        let mut turned = slid.clone();
        turned.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * f64::to_radians(degrees)));
        let turned = sound(&turned, "urdf");
        same_numbers(
            &behaviour(&turned.robot),
            &behaviour(&plain.robot),
            EXACT,
            &format!("turned by {degrees} deg"),
        );
    }
}

#[test]
fn a_quadruped_whose_front_feet_are_named_is_not_turned() {
    // Two pairs of legs with bent knees, thighs further from upright than a frame may be: the feet are balls.
    let mut draft = stork(Sole::Balls);
    for side in ["left", "right"] {
        let pose = |draft: &Draft, name: &str| draft.find(&format!("{side}_{name}_link"));
        let (hip, knee) = (pose(&draft, "hip_pitch"), pose(&draft, "knee"));
        draft.bodies[hip].joint.as_mut().unwrap().rest = 0.9;
        draft.bodies[hip].joint.as_mut().unwrap().range = [-1.6, 1.2];
        draft.bodies[knee].joint.as_mut().unwrap().rest = -1.8;
        draft.bodies[knee].joint.as_mut().unwrap().range = [-2.4, -0.5];
        // The shank is the last body, with a ball at its end.
        let ball =
            (Solid::Shape(specforge::robot::Shape::Sphere(0.02)), Isometry3::translation(0.0, 0.0, -0.27));
        draft.bodies[knee].solids = vec![ball];
    }
    draft.bodies.retain(|body| !body.name.contains("ankle") && !body.name.contains("foot"));
    for (index, body) in draft.bodies.iter_mut().enumerate().filter(|(index, _)| *index > 4) {
        body.parent = if index == 5 { 0 } else { index - 1 };
    }
    let feet = Some(["left_knee_link".to_owned(), "right_knee_link".to_owned()]);
    let imported = import(&draft, "mjcf", Selection { feet, ..Selection::default() });
    let notes = imported.map_or_else(|said| panic!("{said}"), |imported| imported.notes);
    assert!(!notes.iter().any(|note| note.contains("frame of the base was turned")), "{notes:?}");
}

#[test]
fn a_base_with_its_origin_outside_of_the_pelvis_is_moved_to_the_hips() {
    let mut stream = Stream::new("test/frames/origin");
    for format in ["urdf", "mjcf"] {
        let mut middle = stork(Sole::Box);
        middle.reframe(0, &Isometry3::translation(0.0, 0.0, -0.08));
        let plain = Reference::new(&middle, format);
        assert!(plain.imported.notes.iter().all(|note| !note.contains("was moved by")));
        for place in
            [[0.0, 0.0, -0.66], [0.1, 0.05, -0.3], [0.0, 0.0, 0.5], [0.4, 0.0, 0.0], [0.0, -0.3, 2.0]]
        {
            let mut draft = stork(Sole::Box);
            draft.reframe(0, &Isometry3::new(Vector3::from(place), Vector3::zeros()));
            draft.turn(0, anyhow(&mut stream));
            let moved = sound(&draft, format);
            plain.compare(&moved, &format!("{format} moved by {place:?}"));
            assert!(
                moved.notes.iter().any(|note| note.contains("to the middle of the hips")),
                "{place:?}: {:?}",
                moved.notes
            );
        }
    }
}

#[test]
fn what_new_writes_does_not_depend_on_where_in_the_pelvis_the_origin_is() {
    let build = |up: f64| {
        let mut draft = stork(Sole::Box);
        draft.reframe(0, &Isometry3::translation(0.05, 0.0, up));
        let robot = sound(&draft, "urdf").robot;
        (Proportions::of(&robot), robot.standing_height)
    };
    let (plain, stands) = build(0.0);
    for up in [-0.1, 0.1] {
        let (moved, higher) = build(up);
        assert!((higher - stands - up).abs() < EXACT, "the origin stays");
        let figures = |build: Proportions| {
            [build.stands, build.stiffness.unwrap(), build.damping.unwrap(), build.effort.unwrap()]
        };
        for (moved, plain) in figures(moved).into_iter().zip(figures(plain)) {
            assert!((moved - plain).abs() < EXACT, "{moved} is not {plain}");
        }
        assert!((moved.base - plain.base - up).abs() < EXACT);
    }
}

#[test]
fn a_base_that_leans_in_the_key_frame_stands_as_it_does_there() {
    let plain = sound(&stork(Sole::Box), "mjcf").robot;
    for degrees in [-20.0, 5.0, 15.0, 17.7, 30.0] {
        let lean = f64::to_radians(degrees);
        for turn in [0.0, std::f64::consts::PI] {
            let mut draft = stork(Sole::Box);
            for side in ["left", "right"] {
                let hip = draft.find(&format!("{side}_hip_pitch_link"));
                draft.bodies[hip].joint.as_mut().unwrap().rest -= lean;
            }
            draft.lean = UnitQuaternion::from_scaled_axis(Vector3::y() * lean);
            draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * turn));
            let imported = sound(&draft, "mjcf");
            let what = format!("{degrees} deg, turned by {turn}");
            assert!(tilt(&imported.robot) < EXACT, "{what}: {}", tilt(&imported.robot));
            // The whole robot turned about its base, whose origin is above the hips.
            assert!((imported.robot.standing_height - plain.standing_height).abs() < 0.02, "{what}");
            assert!(
                imported
                    .notes
                    .iter()
                    .any(|note| note.contains("in the key frame, in which the soles are level")),
                "{what}: {:?}",
                imported.notes
            );
        }
    }
}

#[test]
fn a_base_beside_the_plane_of_symmetry_is_moved_into_it() {
    let plain = Reference::new(&stork(Sole::Box), "urdf");
    let mut draft = stork(Sole::Box);
    draft.reframe(0, &Isometry3::new(Vector3::new(0.0, 0.04, 0.0), Vector3::new(0.0, 0.0, 3.0)));
    let turned = sound(&draft, "urdf");
    plain.compare(&turned, "beside");
    assert!(
        turned.notes.iter().any(|note| note.contains("was moved by 40.0 mm into the plane of symmetry")),
        "{:?}",
        turned.notes
    );
}

#[test]
fn soles_that_are_level_in_the_default_pose_alone_are_found_there() {
    let mut stream = Stream::new("test/frames/pose");
    // At zero the feet point 0.35 rad down, because the ankles' zero is elsewhere.
    let tilted = || {
        let mut draft = stork(Sole::Box);
        for side in ["left", "right"] {
            let foot = draft.find(&format!("{side}_ankle_pitch_link"));
            draft.bodies[foot].pose.rotation = UnitQuaternion::from_scaled_axis(Vector3::y() * 0.35);
            draft.bodies[foot].joint.as_mut().unwrap().rest = -0.65;
        }
        draft
    };
    let rest = [fill(Some("ankle_pitch"), "default_position", "-0.65 rad")];
    for format in ["urdf", "mjcf"] {
        let plain = import_with(&tilted(), format, Selection::default(), &rest)
            .unwrap_or_else(|said| panic!("{said}"));
        assert!(tilt(&plain.robot) < EXACT);
        for _ in 0..4 {
            let mut draft = tilted();
            for body in [0, draft.find("left_foot"), draft.find("right_foot")] {
                draft.turn(body, anyhow(&mut stream));
            }
            let turned = import_with(&draft, format, Selection::default(), &rest)
                .unwrap_or_else(|said| panic!("{said}"));
            same_numbers(&behaviour(&turned.robot), &behaviour(&plain.robot), EXACT, format);
        }
    }
}

#[test]
fn names_need_not_say_left_and_right() {
    let plain = Reference::new(&stork(Sole::Box).renamed("port", "star"), "urdf");
    let mut draft = stork(Sole::Box).renamed("port", "star");
    draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::PI));
    let turned = sound(&draft, "urdf");
    plain.compare(&turned, "port and star");
    assert!(
        turned.notes.iter().any(|note| note.contains("its x axis pointed backward")),
        "{:?}",
        turned.notes
    );
}

#[test]
fn what_cannot_be_decided_is_refused_and_names_the_frame() {
    // Feet as long behind as ahead, and knees that bend against the frame's x axis: nothing else says where
    // forward is.
    let mut draft = stork(Sole::Box).renamed("port", "star");
    for body in [draft.find("port_foot"), draft.find("star_foot")] {
        draft.bodies[body].solids[0].1.translation.vector.x = 0.0;
    }
    let plain = Reference::new(&draft, "urdf");
    draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::PI));
    let said = import(&draft, "urdf", Selection::default()).err().expect("it is refused");
    assert!(said.contains("E0416") && said.contains("which way `torso` faces is unclear"), "{said}");
    // The user settles it.
    let feet = Some(["port_foot".to_owned(), "star_foot".to_owned()]);
    let settled = import(&draft, "urdf", Selection { feet, ..Selection::default() })
        .unwrap_or_else(|said| panic!("{said}"));
    plain.compare(&settled, "settled");
}

#[test]
fn feet_that_are_named_the_other_way_round_are_told_and_exchanged() {
    let plain = Reference::new(&stork(Sole::Box), "urdf");
    let feet = Some(["right_foot".to_owned(), "left_foot".to_owned()]);
    for turn in [0.0, std::f64::consts::PI] {
        let mut draft = stork(Sole::Box);
        draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * turn));
        let imported = import(&draft, "urdf", Selection { feet: feet.clone(), ..Selection::default() });
        let imported = imported.unwrap_or_else(|said| panic!("{said}"));
        plain.compare(&imported, "exchanged");
        assert_eq!(imported.warnings.len(), 1);
        assert!(
            imported.warnings[0].starts_with("W0401: --feet: `right_foot` is the right foot"),
            "{:?}",
            imported.warnings
        );
    }
}

/// The bodies and joints of arms that reach ahead, so that a turned frame has other lowest ends.
fn with_arms() -> Draft {
    let mut draft = stork(Sole::Box);
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        for (name, parent, place) in [
            ("shoulder", "torso".to_owned(), [0.0, 0.16 * y, 0.3]),
            ("elbow", format!("{side}_shoulder_link"), [0.0, 0.0, -0.25]),
        ] {
            let mut body = draft.bodies[draft.find(&format!("{side}_hip_yaw_link"))].clone();
            (body.name, body.parent) = (format!("{side}_{name}_link"), draft.find(&parent));
            body.pose = Isometry3::translation(place[0], place[1], place[2]);
            let joint = body.joint.as_mut().unwrap();
            (joint.name, joint.axis) = (format!("{side}_{name}"), Vector3::y());
            draft.bodies.push(body);
        }
    }
    draft
}

#[test]
fn feet_are_found_below_a_turned_base_with_arms() {
    let mut stream = Stream::new("test/frames/arms");
    let plain = Reference::new(&with_arms(), "urdf");
    for turn in turns(&mut stream) {
        let mut draft = with_arms();
        draft.turn(0, turn);
        plain.compare(&sound(&draft, "urdf"), &format!("turned by {turn}"));
    }
}

/// The stork with hips whose roll and yaw axes lean by so many degrees, as those of oblique drives do, mirror
/// images of each other.
fn oblique(degrees: f64) -> Draft {
    let mut draft = stork(Sole::Box);
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        for (name, lean) in
            [("hip_yaw", Vector3::new(0.6 * y, 1.0, 0.0)), ("hip_roll", Vector3::new(0.0, 1.0, 0.3 * y))]
        {
            let turn = UnitQuaternion::from_scaled_axis(lean * degrees.to_radians());
            let body = draft.find(&format!("{side}_{name}_link"));
            let joint = draft.bodies[body].joint.as_mut().unwrap();
            joint.axis = turn * joint.axis;
        }
    }
    draft
}

#[test]
fn a_base_that_is_tilted_by_a_few_degrees_above_oblique_hips_is_the_same_robot() {
    let mut stream = Stream::new("test/frames/oblique");
    for format in ["urdf", "mjcf"] {
        for degrees in [8.0, 20.0, -35.0] {
            let plain = Reference::new(&oblique(degrees), format);
            for axis in [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(0.6, -0.7, 0.4)] {
                for tilt in [2.0, -4.0, 7.0] {
                    let mut draft = oblique(degrees);
                    draft.turn(0, UnitQuaternion::from_scaled_axis(axis * f64::to_radians(tilt)));
                    plain.compare(
                        &sound(&draft, format),
                        &format!("{degrees} in {format}, tilted by {tilt} about {axis}"),
                    );
                }
            }
            let mut draft = oblique(degrees);
            (0..draft.bodies.len()).for_each(|body| draft.turn(body, anyhow(&mut stream)));
            plain.compare(&sound(&draft, format), &format!("{degrees} in {format}, every frame turned"));
        }
    }
}

#[test]
fn a_backward_base_with_exchanged_feet_is_the_same_robot() {
    let feet = Some(["right_foot".to_owned(), "left_foot".to_owned()]);
    for degrees in [0.0, 20.0] {
        let plain = Reference::new(&oblique(degrees), "mjcf");
        for yaw in [180.0, 177.0, -176.0] {
            let mut draft = oblique(degrees);
            draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * f64::to_radians(yaw)));
            draft.turn(0, UnitQuaternion::from_scaled_axis(Vector3::x() * f64::to_radians(3.0)));
            let imported = import(&draft, "mjcf", Selection { feet: feet.clone(), ..Selection::default() });
            let imported = imported.unwrap_or_else(|said| panic!("{said}"));
            plain.compare(&imported, &format!("hips by {degrees}, base by {yaw}"));
            assert!(
                imported.warnings.iter().any(|told| told.starts_with("W0401")),
                "{:?}",
                imported.warnings
            );
        }
    }
}

#[test]
fn feet_that_are_balls_at_the_ends_of_shanks_are_level_however_their_frames_lie() {
    let mut stream = Stream::new("test/frames/balls");
    let draft = || {
        let mut draft = stork(Sole::Box);
        for side in ["left", "right"] {
            let foot = draft.find(&format!("{side}_foot"));
            let shank = UnitQuaternion::from_scaled_axis(Vector3::y() * -0.1);
            let at = |z: f64| Isometry3::from_parts((shank * Vector3::new(0.0, 0.0, z)).into(), shank);
            draft.bodies[foot].solids = vec![
                (Solid::Shape(Shape::Sphere(0.03)), at(-0.2)),
                (Solid::Shape(Shape::Capsule(0.06, 0.02)), at(-0.08)),
            ];
        }
        draft
    };
    for format in ["urdf", "mjcf"] {
        for _ in 0..4 {
            let mut turned = draft();
            for side in ["left", "right"] {
                let foot = turned.find(&format!("{side}_foot"));
                turned.turn(foot, anyhow(&mut stream));
            }
            let imported = sound(&turned, format);
            assert!(tilt(&imported.robot) < 1e-9, "{format}: {}", tilt(&imported.robot).to_degrees());
            let radius = |foot: &robot::Foot| foot.half_extents.iter().all(|half| (half - 0.03).abs() < 1e-9);
            assert!(imported.robot.feet.iter().all(radius), "{:?}", imported.robot.feet);
        }
    }
}

fn specforge(folder: &Path) -> Command {
    let mut command = Command::cargo_bin("specforge").unwrap();
    command.current_dir(folder);
    command
}

/// What the program prints about a robot, and the specs that it writes for it.
fn printed(draft: &Draft) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    draft.urdf(folder.path(), "stork");
    let mut import = specforge(folder.path());
    import.args(["robot", "import", "stork.urdf"]);
    for Fill { joints, key, value } in fills() {
        let joints = joints.map(|joints| format!("{joints}:")).unwrap_or_default();
        import.args(["--fill", &format!("{joints}{key}={value}")]);
    }
    import.assert().success();
    let mut said = Vec::new();
    let mut says = |arguments: &[&str]| {
        let output = specforge(folder.path()).args(arguments).assert().success();
        said.push(String::from_utf8_lossy(&output.get_output().stdout).into_owned());
    };
    says(&["robot", "show", "stork"]);
    says(&["robot", "show", "stork", "--format", "mjcf"]);
    for task in ["walk", "squat"] {
        let file = format!("{task}.toml");
        says(&["new", &file, "--robot", "stork", "--task", task, "--action", "torque"]);
        says(&["check", &file]);
    }
    said.extend(
        ["walk", "squat"].map(|task| fs::read_to_string(folder.path().join(format!("{task}.toml"))).unwrap()),
    );
    said
}

#[test]
fn the_program_says_the_same_of_turned_feet_and_of_a_root_on_the_ground() {
    let plain = printed(&stork(Sole::Box));
    assert!(plain[0].contains("ok   soles are flat and level") && !plain[0].contains("FAIL"), "{}", plain[0]);
    let mut feet = stork(Sole::Box);
    for foot in ["left_foot", "right_foot"] {
        feet.turn(
            feet.find(foot),
            UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::FRAC_PI_2),
        );
    }
    let mut backward = stork(Sole::Box);
    backward.turn(0, UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::PI));
    let mut footprint = stork(Sole::Box);
    footprint.root = Isometry3::translation(0.0, 0.0, 0.66);
    footprint.footprints = vec!["base_footprint"];
    for (what, draft) in [("feet", feet), ("backward", backward), ("base_footprint", footprint)] {
        assert_eq!(printed(&draft), plain, "{what}");
    }
}

#[cfg(any(feature = "rapier", feature = "mujoco"))]
mod simulated {
    use specforge::sim::{ENGINES, EngineSettings, State, Terrain, open};

    use super::*;

    /// Where a robot is that holds its default pose for a tenth of a second after a fall of 5 mm.
    fn landing(robot: &Robot, engine: &str) -> State {
        let Ok(engine) = open(engine) else { return State::default() };
        let settings = EngineSettings { step: 0.001, friction: 1.0, contact_time: None };
        let mut state = State {
            base_position: [0.0, 0.0, robot.standing_height + 0.005],
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            position: robot.default_pose(),
            velocity: vec![0.0; robot.joints()],
            ..State::default()
        };
        let mut world = engine.build(robot, &Terrain::Flat, &settings, &state).unwrap();
        for _ in 0..100 {
            world.read(&mut state);
            let torque = robot.links.iter().enumerate().map(|(index, link)| {
                let joint = &link.joint;
                let pull = joint.stiffness_gain * (joint.default_position - state.position[index]);
                (pull - joint.damping_gain * state.velocity[index])
                    .clamp(-joint.effort_limit, joint.effort_limit)
            });
            world.step(&torque.collect::<Vec<_>>());
        }
        world.read(&mut state);
        state
    }

    fn numbers(state: &State) -> Vec<f64> {
        let base = [state.base_position, state.base_velocity, state.base_rate].concat();
        [base, state.base_orientation.to_vec(), state.position.clone(), state.velocity.clone()].concat()
    }

    #[test]
    fn a_robot_with_turned_frames_lands_the_same_way_in_every_engine() {
        let mut stream = Stream::new("test/frames/landing");
        let plain = sound(&stork(Sole::Box), "urdf").robot;
        let mut ends = stork(Sole::Box);
        for body in [0, ends.find("left_foot"), ends.find("right_foot")] {
            ends.turn(body, UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::PI));
        }
        let mut all = stork(Sole::Box);
        (0..all.bodies.len()).for_each(|body| all.turn(body, anyhow(&mut stream)));
        for engine in ENGINES {
            let expected = numbers(&landing(&plain, engine));
            assert_eq!(numbers(&landing(&sound(&ends, "urdf").robot, engine)), expected, "{engine}");
            let found = numbers(&landing(&sound(&all, "urdf").robot, engine));
            // Rapier counts with seven digits, and a landing magnifies what is left.
            let close = if *engine == "rapier" { 1e-2 } else { 1e-6 };
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < close, "{engine}: {found} is not {expected}");
            }
        }
    }
}
