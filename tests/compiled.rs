//! Imported robots against the models that MuJoCo compiles from the same files: masses and inertias through
//! the mass matrix in random poses, which also holds every place and axis, and the figures of the joints.

#![cfg(feature = "mujoco")]

use std::fs;
use std::path::Path;

use mujoco_rs::prelude::{MjData, MjModel, MjtObjBase};
use nalgebra::Isometry3;
use regex_lite::Regex;
use specforge::diag::render::{Look, human};
use specforge::diag::{Sink, Sources};
use specforge::robot::import::{self, Folder, Selection, Welded};
use specforge::robot::{Kinematics, Robot};
use specforge::stream::Stream;

/// The model that MuJoCo compiles; the engine keeps its messages out of the working folder.
fn compiled(file: &Path) -> MjModel {
    specforge::sim::open("mujoco").expect("the library is there");
    MjModel::from_xml(file).unwrap_or_else(|error| panic!("{error}"))
}

fn welded(file: &Path, joints: Option<&str>) -> Welded {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let selection =
        Selection { joints: joints.map(|joints| Regex::new(joints).unwrap()), ..Selection::default() };
    let tree = import::read(file, &Folder::around(file).unwrap(), &mut sources, &mut sink);
    let welded = tree.and_then(|tree| import::weld(&tree, &selection, &mut sink));
    welded.unwrap_or_else(|| panic!("{}", human(&sources, &sink.diagnostics, Look::default())))
}

/// How far figures may be apart: bodies with several hinges give a millionth of their mass to each frame
/// between them.
const NEAR: f64 = 1e-5;

/// The joints in the key frame of `ODD`.
const KEY: [f64; 7] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7];

/// Compares the mass matrices in random poses, with the base where it is in the file or floating at the
/// origin.
fn masses_agree(robot: &Robot, model: &MjModel, floating: bool) {
    let mut stream = Stream::new("test/compiled");
    let mut kinematics = Kinematics::new(robot);
    let joints = robot.links.iter().map(|link| {
        let name = &link.joint.name;
        model
            .name_to_id(MjtObjBase::mjOBJ_JOINT, name)
            .unwrap_or_else(|| panic!("MuJoCo has no joint {name}"))
    });
    let joints: Vec<usize> = joints.collect();
    let first = if floating { 6 } else { 0 };
    let places: Vec<usize> =
        (0..first).chain(joints.iter().map(|joint| model.jnt_dofadr()[*joint] as usize)).collect();
    let mut data = MjData::try_new(model).unwrap();
    let size = data.qvel().len();
    for _ in 0..5 {
        let pose: Vec<f64> = robot.links.iter().map(|_| stream.normal()).collect();
        kinematics.place(&Isometry3::identity(), &pose);
        let ours = kinematics.mass_matrix();
        let positions = data.qpos_mut();
        positions.fill(0.0);
        if floating {
            // Welded joints stay where the key frame of `ODD` has them.
            positions[3] = 1.0;
            positions[7..].copy_from_slice(&KEY);
        }
        for (joint, position) in joints.iter().zip(&pose) {
            positions[model.jnt_qposadr()[*joint] as usize] = *position;
        }
        data.forward();
        let mut theirs = vec![0.0; size * size];
        data.full_m(&mut theirs).unwrap();
        for (row, &their_row) in places.iter().enumerate() {
            for (column, &their_column) in places.iter().enumerate() {
                let (a, b) =
                    (ours[(row + 6 - first, column + 6 - first)], theirs[their_row * size + their_column]);
                assert!((a - b).abs() < NEAR * (1.0 + b.abs()), "row {row}, column {column}: {a} is not {b}");
            }
        }
    }
}

/// Compares ranges, damping, friction and armature.
fn joints_agree(robot: &Robot, model: &MjModel) {
    for link in &robot.links {
        let joint = &link.joint;
        let id = model.name_to_id(MjtObjBase::mjOBJ_JOINT, &joint.name).unwrap();
        let dof = model.jnt_dofadr()[id] as usize;
        let [lower, upper] = model.jnt_range()[id];
        for (ours, theirs) in
            [(joint.lower, lower), (joint.upper, upper), (joint.armature, model.dof_armature()[dof])]
        {
            assert!((ours - theirs).abs() < 1e-12, "{}: {ours} is not {theirs}", joint.name);
        }
        let friction = model.dof_frictionloss()[dof];
        assert!((joint.friction - friction).abs() < 1e-12, "{}: {friction}", joint.name);
    }
}

/// Whatever MJCF offers for places, orientations, classes and masses.
const ODD: &str = r#"<mujoco model="odd">
  <compiler angle="degree" eulerseq="zyX" boundinertia="0.0005" boundmass="0.01"/>
  <include file="defaults.xml"/>
  <asset><mesh name="torso" file="torso.obj" scale="0.5 0.5 0.5"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <frame pos="0 0 1" euler="10 20 30">
      <body name="pelvis" pos="0 0 0.2" childclass="part">
        <freejoint/>
        <inertial pos="0.01 0 0.1" mass="12" diaginertia="0.3 0.25 0.2" axisangle="0 1 0 30"/>
        <geom type="mesh" mesh="torso"/>
        <frame pos="0 0 0.3" quat="0.9 0.1 0.2 0">
          <body name="head" zaxis="0.1 0.2 1"><geom type="sphere" size="0.1"/>
            <geom type="ellipsoid" size="0.1 0.05 0.02" pos="0 0.1 0" euler="5 6 7"/>
            <geom type="box" size="0.3 0.3 0.3" group="3" mass="0"/></body>
          <body name="arm"><joint name="shoulder" axis="1 1 0" pos="0 0 0.1" ref="-15" range="-90 90"/>
            <geom type="cylinder" size="0.04 0.2" pos="0 0 -0.2" mass="1.5"/></body>
        </frame>
        <body name="left_thigh" pos="0 0.1 0" childclass="limb" xyaxes="1 0.1 0 0.3 1 0.2">
          <joint name="left_hip" pos="0.01 0 0.02" ref="20"/>
          <geom fromto="0 0 0 0.02 0.05 -0.35"/>
          <body name="left_shank" pos="0 0 -0.37">
            <joint name="left_twist" axis="0 0 1" range="-20 20"/>
            <joint name="left_knee" pos="0 0.01 0"/>
            <inertial pos="0 0 -0.2" mass="2.5" fullinertia="0.05 0.045 0.02 0.002 -0.003 0.001"/>
            <body name="left_foot" pos="0 0 -0.4" euler="0 10 0"><joint class="foot" name="left_ankle"/>
              <geom class="foot" pos="0.03 0 -0.05"/>
                <geom class="foot" type="capsule" fromto="0 0 0 0.1 0 0" size="0.02"/></body>
          </body>
        </body>
        <body name="right_thigh" pos="0 -0.1 0" childclass="limb">
          <joint name="right_hip"/>
          <geom fromto="0 0 0 0.02 -0.05 -0.35"/>
          <body name="right_foot" pos="0 0 -0.8"><joint class="foot" name="right_ankle"/>
            <geom class="foot" pos="0.03 0 -0.05"/></body>
        </body>
      </body>
    </frame>
  </worldbody>
  <actuator>
    <motor joint="left_hip" gear="50" ctrlrange="-2 2" forcerange="-1.5 1.5"/>
    <position joint="left_ankle" kp="80" kv="4" gear="2"/>
    <general joint="right_hip" gainprm="90" biastype="affine" biasprm="0 -90 -5" forcerange="-30 40"/>
    <motor joint="right_ankle" ctrlrange="-70 70"/>
  </actuator>
  <keyframe><key name="home" qpos="0 0 1 1 0 0 0 0.1 0.2 0.3 0.4 0.5 0.6 0.7"/></keyframe>
</mujoco>
"#;

const DEFAULTS: &str = r#"<mujoco><default>
  <joint damping="1.5" armature="0.02" range="-100 80"/>
  <motor forcerange="-60 60"/>
  <default class="part"><geom density="700"/>
    <default class="limb"><joint frictionloss="0.3" axis="0 1 0"/><geom type="capsule" size="0.05"/>
      <default class="foot"><joint armature="0.05" actuatorfrcrange="-55 55" range="-30 40"/>
        <geom type="box" size="0.1 0.05 0.02" density="400"/></default></default></default>
</default></mujoco>
"#;

const TORSO: &str = "v 0 0 0\nv 0.4 0 0\nv 0 0.6 0\nv 0 0 0.8\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn odd(edit: &[(&str, &str)]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let text = edit.iter().fold(ODD.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    fs::write(folder.path().join("odd.xml"), text).unwrap();
    fs::write(folder.path().join("defaults.xml"), DEFAULTS).unwrap();
    fs::write(folder.path().join("torso.obj"), TORSO).unwrap();
    let file = folder.path().join("odd.xml");
    (folder, file)
}

/// The variants of the file that change how its numbers are read.
fn variants() -> Vec<Vec<(&'static str, &'static str)>> {
    vec![
        vec![],
        vec![("angle=\"degree\"", "angle=\"radian\"")],
        vec![("eulerseq=\"zyX\"", "eulerseq=\"XYZ\"")],
        vec![("boundmass=\"0.01\"", "settotalmass=\"40\"")],
        vec![
            ("boundmass=\"0.01\"", "inertiafromgeom=\"true\""),
            ("<geom type=\"mesh\" mesh=\"torso\"/>", "<geom size=\"0.2\"/>"),
        ],
        vec![("boundmass=\"0.01\"", "inertiagrouprange=\"0 2\""), ("group=\"3\" mass=\"0\"", "group=\"3\"")],
        vec![
            ("boundinertia=\"0.0005\"", "balanceinertia=\"true\""),
            ("diaginertia=\"0.3 0.25 0.2\"", "diaginertia=\"0.6 0.25 0.2\""),
        ],
    ]
}

#[test]
fn an_mjcf_file_means_what_mujoco_makes_of_it() {
    for variant in variants() {
        let (_folder, file) = odd(&variant);
        eprintln!("{variant:?}");
        let model = compiled(&file);
        // Without the twist, which shares the shank with the knee: welded, it stays where the key frame has
        // it.
        let welded = welded(&file, Some("shoulder|hip|knee|ankle"));
        let robot = welded.skeleton();
        assert_eq!(robot.joints(), 6);
        masses_agree(&robot, &model, true);
        joints_agree(&robot, &model);
    }
}

#[test]
fn several_joints_of_one_body_are_a_chain() {
    let (_folder, file) = odd(&[]);
    let model = compiled(&file);
    let welded = welded(&file, Some("."));
    let robot = welded.skeleton();
    assert_eq!(robot.joints(), 7);
    masses_agree(&robot, &model, true);
    let between =
        welded.links.iter().find(|link| link.body.name == "left_shank_left_twist").expect("it is between");
    assert!(!between.weigh && between.body.mass > 0.0, "it has a share of the shank's mass");
}

#[test]
fn actuators_and_the_key_frame_give_limits_gains_and_the_default_pose() {
    let (_folder, file) = odd(&[]);
    let welded = welded(&file, Some("."));
    let joint = |name: &str| {
        let link = welded.links.iter().find(|link| link.hinge.name == name).unwrap();
        let hinge = &link.hinge;
        [hinge.effort_limit, hinge.stiffness_gain, hinge.damping_gain, hinge.default_position]
    };
    // The force range of the motor itself, 1.5 N m, times the gear of 50.
    assert_eq!(joint("left_hip"), [Some(75.0), None, None, Some(0.2)]);
    // Gains act through the gear twice; the class of the joint bounds its torque; the shared defaults the
    // force.
    assert_eq!(joint("left_ankle"), [Some(55.0), Some(320.0), Some(16.0), Some(0.5)]);
    assert_eq!(joint("right_hip"), [Some(30.0), Some(90.0), Some(5.0), Some(0.6)]);
    assert_eq!(joint("right_ankle"), [Some(55.0), None, None, Some(0.7)]);
    assert_eq!(joint("shoulder"), [None, None, None, Some(0.1)]);
    assert!(welded.notes.iter().any(|note| note.contains("limited to -30 .. 40")), "{:?}", welded.notes);
}

#[test]
fn a_mass_without_a_closed_form_is_left_to_be_filled_in() {
    let (_folder, file) = odd(&[(
        "<inertial pos=\"0.01 0 0.1\" mass=\"12\" diaginertia=\"0.3 0.25 0.2\" axisangle=\"0 1 0 30\"/>",
        "",
    )]);
    let welded = welded(&file, Some("."));
    assert!(
        welded.weigh_base && welded.notes.iter().any(|note| note.contains("no closed form")),
        "{:?}",
        welded.notes
    );
}

const URDF: &str = r#"<robot name="odd">
  <link name="base"><inertial><mass value="5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="a"><inertial><origin xyz="0.1 0.2 -0.1" rpy="0.3 0.2 0.1"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="-0.003"/></inertial></link>
  <link name="plate"><inertial><origin xyz="0 0.1 0" rpy="0 0 1"/><mass value="0.5"/>
    <inertia ixx="0.002" iyy="0.001" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="sensor"/>
  <link name="b"><inertial><origin xyz="0 0 -0.3"/><mass value="1.5"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"><inertial><origin xyz="0 0 -0.3"/><mass value="1.5"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hip_a" type="revolute"><origin xyz="0 0.1 -0.1" rpy="0.1 -0.4 1.5707963"/>
    <parent link="base"/><child link="a"/><axis xyz="0 0.6 0.8"/>
      <limit lower="-1" upper="0.5" effort="60" velocity="9"/><dynamics damping="0.7" friction="0.2"/></joint>
  <joint name="plate_fix" type="fixed"><origin xyz="0.3 0 0.1" rpy="1 2 3"/><parent link="a"/>
    <child link="plate"/></joint>
  <joint name="sensor_fix" type="fixed"><origin xyz="0.3 0 0.1"/><parent link="plate"/><child link="sensor"/>
    </joint>
  <joint name="knee_a" type="revolute"><origin xyz="0.02 0 -0.4" rpy="0 0.2 0"/><parent link="a"/>
    <child link="b"/><axis xyz="0 1 0"/><limit lower="-2" upper="0.1" effort="60" velocity="9"/></joint>
  <joint name="hip_b" type="revolute"><origin xyz="0 -0.1 -0.1"/><parent link="base"/><child link="c"/>
    <limit lower="-1" upper="1" effort="60" velocity="9"/></joint>
</robot>
"#;

#[test]
fn a_urdf_file_means_what_mujoco_makes_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("odd.urdf");
    fs::write(&file, URDF).unwrap();
    let model = compiled(&file);
    let robot = welded(&file, None).skeleton();
    assert_eq!(robot.joints(), 3);
    // MuJoCo fixes the base of a URDF file to the world.
    masses_agree(&robot, &model, false);
    joints_agree(&robot, &model);
}

/// Springs by a time constant and servos by a damping ratio, over the odd file with its places, `ref` and
/// masses.
#[test]
fn damping_that_mujoco_computes_is_what_it_computes() {
    let edits = [
        ("name=\"left_hip\" pos", "springdamper=\"0.05 0.7\" name=\"left_hip\" pos"),
        ("name=\"left_twist\"", "springdamper=\"0.2 1\" type=\"slide\" name=\"left_twist\""),
        ("name=\"shoulder\"", "springdamper=\"0.1 1\" name=\"shoulder\""),
        (
            "kp=\"80\" kv=\"4\" gear=\"2\"",
            "kp=\"80\" dampratio=\"0.8\" gear=\"2\" armature=\"0.03\" damping=\"0.1\"",
        ),
        ("biasprm=\"0 -90 -5\"", "biasprm=\"0 -90 1.5\""),
    ];
    let (_folder, file) = odd(&edits);
    let model = compiled(&file);
    let welded = welded(&file, Some("shoulder|hip|knee|ankle"));
    let hinge = |name: &str| &welded.links.iter().find(|link| link.hinge.name == name).unwrap().hinge;
    let near = |ours: Option<f64>, theirs: f64| {
        let ours = ours.expect("it is known");
        assert!((ours - theirs).abs() < NEAR * theirs.abs(), "{ours} is not {theirs}");
    };
    for name in ["left_hip", "shoulder", "left_knee"] {
        let joint = model.name_to_id(MjtObjBase::mjOBJ_JOINT, name).unwrap();
        near(hinge(name).damping, model.dof_damping()[model.jnt_dofadr()[joint] as usize]);
    }
    // The second and the third actuator; gains act through the gear twice.
    for (actuator, name, gear) in [(1, "left_ankle", 2.0), (2, "right_hip", 1.0)] {
        near(hinge(name).damping_gain, -model.actuator_biasprm()[actuator][2] * gear * gear);
    }
    near(hinge("left_ankle").armature, 0.05 + 4.0 * 0.03);
    near(hinge("left_ankle").damping, 1.5 + 4.0 * 0.1);
}
