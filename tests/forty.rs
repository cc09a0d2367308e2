//! A robot of forty joints: legs of six, a waist of three, a neck, arms of seven and fingers. Nothing in the
//! program may take twelve joints, or legs that hang on the base itself, for granted.

use std::fmt::Write as _;
use std::path::Path;

use assert_cmd::Command;
use nalgebra::{Isometry3, Matrix6xX};
use specforge::diag::{Sink, Sources};
use specforge::kinds::motion;
use specforge::robot::{self, GravityCompensation, Kinematics, Leg, Robot, Weighting, leg_length, symmetry};

/// A link's name and parent, its joint's place, axis (0, 1, 2), mass in kg, length in m and default position.
type Row = (String, String, [f64; 3], usize, f64, f64, f64);

/// The rows of a biped; with `torso` the base is the torso and the waist carries the legs.
fn rows(torso: bool) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut add =
        |name: &str, parent: &str, place: [f64; 3], axis: usize, (mass, length, default): (f64, f64, f64)| {
            rows.push((name.to_owned(), parent.to_owned(), place, axis, mass, length, default));
        };
    let (trunk, hips) = if torso { ("base", "waist_pitch") } else { ("waist_pitch", "base") };
    let waist = if torso { -0.3 } else { 0.1 };
    add("waist_yaw", "base", [0.0, 0.0, waist], 2, (0.5, 0.05, 0.0));
    add("waist_roll", "waist_yaw", [0.0; 3], 0, (0.5, 0.05, 0.0));
    add("waist_pitch", "waist_roll", [0.0; 3], 1, (if torso { 8.0 } else { 15.0 }, 0.3, 0.0));
    add("neck_yaw", trunk, [0.0, 0.0, 0.4], 2, (0.3, 0.05, 0.0));
    add("neck_pitch", "neck_yaw", [0.0; 3], 1, (0.3, 0.05, 0.0));
    add("neck_roll", "neck_pitch", [0.0; 3], 0, (2.0, 0.15, 0.0));
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let of = |part: &str| format!("{side}_{part}");
        add(&of("hip_yaw"), hips, [0.0, 0.1 * sign, -0.1], 2, (1.0, 0.05, 0.0));
        add(&of("hip_roll"), &of("hip_yaw"), [0.0; 3], 0, (1.0, 0.05, 0.0));
        add(&of("hip_pitch"), &of("hip_roll"), [0.0; 3], 1, (4.0, -0.35, -0.3));
        add(&of("knee"), &of("hip_pitch"), [0.0, 0.0, -0.35], 1, (3.0, -0.35, 0.6));
        add(&of("ankle_pitch"), &of("knee"), [0.0, 0.0, -0.35], 1, (0.4, 0.04, -0.3));
        add(&of("ankle_roll"), &of("ankle_pitch"), [0.0; 3], 0, (1.2, -0.04, 0.0));
        let shoulder = [0.0, 0.2 * sign, 0.3];
        add(&of("shoulder_pitch"), trunk, shoulder, 1, (0.8, 0.05, 0.2));
        add(&of("shoulder_roll"), &of("shoulder_pitch"), [0.0; 3], 0, (0.8, 0.05, 0.1 * sign));
        add(&of("shoulder_yaw"), &of("shoulder_roll"), [0.0; 3], 2, (1.5, -0.25, 0.0));
        add(&of("elbow"), &of("shoulder_yaw"), [0.0, 0.0, -0.25], 1, (1.0, -0.2, -0.5));
        add(&of("wrist_yaw"), &of("elbow"), [0.0, 0.0, -0.2], 2, (0.2, 0.03, 0.0));
        add(&of("wrist_pitch"), &of("wrist_yaw"), [0.0; 3], 1, (0.2, 0.03, 0.0));
        add(&of("wrist_roll"), &of("wrist_pitch"), [0.0; 3], 0, (0.3, -0.08, 0.0));
        for finger in 0..4 {
            let place = [0.02 * f64::from(finger), 0.01 * sign, -0.08];
            add(&of(&format!("finger_{finger}")), &of("wrist_roll"), place, 1, (0.05, -0.06, 0.0));
        }
    }
    rows
}

/// A robot file; shapes take turns between the four primitives.
fn file(rows: &[Row]) -> String {
    let body = |mass: f64, length: f64, shape: usize| {
        let moment = 0.4 * mass * 0.03 + mass * length * length / 12.0;
        let low = 0.5 * moment;
        let along = |shape: &str| {
            format!(
                "{{ shape = \"{shape}\", from = [\"0 m\", \"0 m\", \"0 m\"], \
                 to = [\"0 m\", \"0 m\", \"{length} m\"], radius = \"0.02 m\" }}"
            )
        };
        let shape = match shape % 4 {
            0 => {
                "{ shape = \"sphere\", centre = [\"0 m\", \"0 m\", \"0 m\"], radius = \"0.02 m\" }".to_owned()
            }
            1 => along("cylinder"),
            2 => along("capsule"),
            _ => "{ shape = \"box\", half_extents = [\"0.02 m\", \"0.02 m\", \"0.02 m\"], \
                  centre = [\"0 m\", \"0 m\", \"0 m\"], rotation = [\"0 rad\", \"0.3 rad\", \"0 rad\"] }"
                .to_owned(),
        };
        format!(
            "mass = \"{mass} kg\"\ncom = [\"0 m\", \"0 m\", \"{} m\"]\n\
             inertia = \
             {{ ixx = \"{moment} kg*m^2\", iyy = \"{moment} kg*m^2\", izz = \"{low} kg*m^2\", \
             ixy = \"0 kg*m^2\", ixz = \"0 kg*m^2\", iyz = \"0 kg*m^2\" }}\n\
             collisions = [{shape}]\n",
            0.5 * length
        )
    };
    let mut text = format!("name = \"forty\"\n\n[base]\nname = \"base\"\n{}", body(10.0, 0.2, 0));
    for (index, (name, parent, [x, y, z], axis, mass, length, default)) in rows.iter().enumerate() {
        let axis = ["[1.0, 0.0, 0.0]", "[0.0, 1.0, 0.0]", "[0.0, 0.0, 1.0]"][*axis];
        let strong =
            name.contains("hip") || name.contains("knee") || name.contains("ankle") || name.contains("waist");
        let (effort, gain) = if strong { (300.0, 2000.0) } else { (40.0, 60.0) };
        let brake = if strong { 30.0 } else { 2.0 };
        let _ = write!(
            text,
            "\n[[links]]\nname = \"{name}\"\nparent = \"{parent}\"\n{}\n[links.joint]\nname = \
             \"{name}_joint\"\n\
             origin = [\"{x} m\", \"{y} m\", \"{z} m\"]\naxis = {axis}\nlower = \"-2 rad\"\nupper = \"2 \
             rad\"\n\
             effort_limit = \"{effort} N*m\"\nvelocity_limit = \"10 rad/s\"\ndamping = \"0.5 N*m*s/rad\"\n\
             friction = \"0.1 N*m\"\narmature = \"0.05 kg*m^2\"\nstiffness_gain = \"{gain} N*m/rad\"\n\
             damping_gain = \"{brake} N*m*s/rad\"\ndefault_position = \"{default} rad\"\n",
            body(*mass, *length, index)
        );
    }
    for side in ["left", "right"] {
        let _ = write!(
            text,
            "\n[feet.{side}]\nlink = \"{side}_ankle_roll\"\nhalf_extents = [\"0.12 m\", \"0.05 m\", \"0.02 \
             m\"]\ncentre = [\"0.03 m\", \"0 m\", \"-0.04 m\"]\n"
        );
    }
    text
}

fn load(text: &str) -> Result<Robot, Vec<&'static str>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(Path::new("robots/forty.toml"), text.to_owned());
    let robot = robot::load("forty", &sources, source, &mut sink);
    robot.ok_or_else(|| sink.diagnostics.iter().map(|diagnostic| diagnostic.code).collect())
}

fn both() -> [Robot; 2] {
    [false, true].map(|torso| load(&file(&rows(torso))).expect("it is sound"))
}

#[test]
fn forty_joints_are_a_robot_and_forty_one_are_not() {
    let mut rows = rows(false);
    assert_eq!(rows.len(), 40);
    let robot = load(&file(&rows)).expect("forty joints are taken");
    assert_eq!(robot.joints(), 40);
    assert!(symmetry::is_involution(&robot.mirror));
    let extra = ("tail".to_owned(), "base".to_owned(), [-0.1, 0.0, 0.0], 1, 1.0, -0.1, 0.0);
    rows.push(extra);
    assert_eq!(load(&file(&rows)), Err(vec!["E0407"]));
}

#[test]
fn a_wrong_mirror_image_is_refused_and_the_right_one_is_taken() {
    let text = file(&rows(false));
    let with = |image: &str| {
        text.replace(
            "name = \"left_hip_roll_joint\"\n",
            &format!("name = \"left_hip_roll_joint\"\nmirror = \"{image}\"\n"),
        )
    };
    assert!(load(&with("-right_hip_roll_joint")).is_ok());
    for wrong in
        ["right_hip_roll_joint", "+right_hip_roll_joint", "-right_knee_joint", "-left_hip_roll_joint", "x"]
    {
        assert_eq!(load(&with(wrong)), Err(vec!["E0408"]), "{wrong}");
    }
}

#[test]
fn legs_are_found_below_a_waist_too() {
    for robot in both() {
        assert!((leg_length(&robot).unwrap() - 0.70).abs() < 1e-12);
        for (side, name) in ["left", "right"].into_iter().enumerate() {
            let leg = Leg::of(&robot, side).expect("a leg of six joints");
            assert_eq!(robot.links[leg.knee.0].joint.name, format!("{name}_knee_joint"));
            assert_eq!(robot.links[leg.hip_yaw.0].joint.name, format!("{name}_hip_yaw_joint"));
        }
    }
}

#[test]
fn squat_walk_and_run_come_from_the_geometry_and_the_arms_stay() {
    for robot in both() {
        for name in ["squat", "walk", "run_gait"] {
            let motion =
                motion::shipped(name, &robot).unwrap().unwrap_or_else(|error| panic!("{name}: {error}"));
            let mut moved = vec![0.0f64; robot.joints()];
            for frame in &motion.samples {
                assert_eq!(frame.position.len(), 40);
                for (moved, (now, then)) in
                    moved.iter_mut().zip(frame.position.iter().zip(robot.default_pose()))
                {
                    *moved = moved.max((now - then).abs());
                }
            }
            for (link, moved) in robot.links.iter().zip(moved) {
                let name = &link.joint.name;
                let of_a_leg = ["hip", "knee", "ankle"].iter().any(|part| name.contains(part));
                assert!(of_a_leg || moved == 0.0, "{name} moves by {moved}");
            }
        }
    }
}

#[test]
fn gravity_compensation_holds_waist_arms_and_legs() {
    for robot in both() {
        let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
        let pose: Vec<f64> =
            robot.default_pose().iter().enumerate().map(|(index, q)| q + 0.01 * index as f64).collect();
        let base = Isometry3::translation(0.0, 0.0, 0.8);
        for contact in [[true, true], [true, false], [false, true]] {
            let balance = compensation.hold(&base, &pose, contact).clone();
            let mut kinematics = Kinematics::new(&robot);
            kinematics.place(&base, &pose);
            let mut rest = nalgebra::DVector::zeros(46);
            kinematics.gravity(&mut rest);
            let mut jacobian = Matrix6xX::zeros(46);
            for side in 0..2 {
                let point = kinematics.sole(side).translation.vector.into();
                kinematics.jacobian(Some(kinematics.foot_link(side)), &point, &mut jacobian);
                rest -= jacobian.transpose() * balance.wrench[side];
            }
            balance.torque.iter().enumerate().for_each(|(joint, torque)| rest[6 + joint] -= torque);
            assert!(rest.amax() < 1e-9, "{contact:?}: {}", rest.amax());
        }
    }
}

/// A new spec for the robot passes the checks, from the command line alone.
#[test]
fn a_spec_for_a_new_robot_needs_no_rust() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("robots")).unwrap();
    std::fs::write(folder.path().join("robots/forty.toml"), file(&rows(false))).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::cargo_bin("specforge")
            .unwrap()
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    for (task, action) in [("stand", "torque"), ("squat", "torque"), ("walk", "position"), ("run", "torque")]
    {
        let name = format!("{task}.toml");
        run(&["new", &name, "--robot", "forty", "--task", task, "--action", action]);
        run(&["check", &name]);
        let signals = run(&["show", &name, "--signals"]);
        assert!(signals.contains("right_finger_3_joint"), "{signals}");
        run(&["plan", &name]);
    }
}

#[cfg(any(feature = "rapier", feature = "mujoco"))]
#[test]
fn it_stands_in_the_engines() {
    use specforge::sim::{self, EngineSettings, State, Terrain};
    let engines =
        [cfg!(feature = "rapier").then_some("rapier"), cfg!(feature = "mujoco").then_some("mujoco")];
    for robot in both() {
        for engine in engines.into_iter().flatten() {
            let start = State {
                base_position: [0.0, 0.0, robot.standing_height],
                base_orientation: [1.0, 0.0, 0.0, 0.0],
                position: robot.default_pose(),
                velocity: vec![0.0; robot.joints()],
                ..State::default()
            };
            let settings = EngineSettings { step: 0.001, friction: 1.0, contact_time: None };
            let mut world =
                sim::open(engine).unwrap().build(&robot, &Terrain::Flat, &settings, &start).unwrap();
            let (mut state, mut force) = (State::default(), 0.0);
            let mut compensation = GravityCompensation::new(&robot, Weighting::EffortLimits);
            for step in 0..2000 {
                world.read(&mut state);
                let held =
                    compensation.hold(&Isometry3::identity(), &state.position, [true, true]).torque.clone();
                let torque = robot.links.iter().enumerate().map(|(index, link)| {
                    let joint = &link.joint;
                    let pull = joint.stiffness_gain * (joint.default_position - state.position[index]);
                    let torque = held[index] + pull - joint.damping_gain * state.velocity[index];
                    torque.clamp(-joint.effort_limit, joint.effort_limit)
                });
                let torque: Vec<f64> = torque.collect();
                world.step(&torque);
                if step >= 1500 {
                    force += world.contacts().foot_force.iter().map(|force| force[2]).sum::<f64>() / 500.0;
                }
            }
            assert!(world.is_sane() && !world.contacts().body, "{engine}");
            let sunk = (state.base_position[2] - robot.standing_height).abs();
            let weight = robot.total_mass() * 9.81;
            assert!(
                sunk < 0.01 && (force / weight - 1.0).abs() < 0.02,
                "{engine}: {sunk} m, {force} of {weight} N"
            );
            for (position, target) in state.position.iter().zip(robot.default_pose()) {
                assert!((position - target).abs() < 0.05, "{engine}: {position} instead of {target}");
            }
        }
    }
}
