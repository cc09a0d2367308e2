//! Collision shapes touch the ground where their geometry says, in every engine.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

#[expect(dead_code, reason = "the states of the engine tests are not needed here")]
#[path = "parity/biped.rs"]
mod biped;

use biped::biped;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use specforge::robot::{Collision, Shape};
use specforge::sim::{ENGINES, EngineSettings, State, Terrain, open};

/// The height in m at which the base of a biped comes to rest whose base has this shape, and whether it lies
/// on it.
fn rest(engine: &str, shape: &Shape, turn: UnitQuaternion<f64>) -> (f64, bool) {
    let mut robot = biped();
    for link in &mut robot.links {
        link.body.collisions.clear();
    }
    let pose = Isometry3::from_parts(nalgebra::Translation3::identity(), turn);
    robot.base.collisions = vec![Collision { shape: shape.clone(), pose }];
    let start = State {
        base_position: [0.0, 0.0, 1.02],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        ..State::default()
    };
    let settings = EngineSettings { step: 0.001, friction: 1.0, contact_time: None };
    let mut world = open(engine).unwrap().build(&robot, &Terrain::Flat, &settings, &start).unwrap();
    let mut state = State::default();
    for _ in 0..1000 {
        world.read(&mut state);
        let hold = robot.links.iter().enumerate().map(|(index, link)| {
            let joint = &link.joint;
            let pull = joint.stiffness_gain * (joint.default_position - state.position[index]);
            (pull - joint.damping_gain * state.velocity[index]).clamp(-joint.effort_limit, joint.effort_limit)
        });
        let torque: Vec<f64> = hold.collect();
        world.step(&torque);
    }
    world.read(&mut state);
    let contacts = world.contacts();
    let lifted = contacts.foot_force.iter().flatten().all(|force| force.abs() < 1e-6);
    (state.base_position[2], contacts.body && lifted)
}

#[test]
fn a_cylinder_stands_on_its_flat_end_with_the_feet_in_the_air() {
    for engine in ENGINES {
        // Feet reach 0.93 m below the base. Along another axis the cylinder would reach 0.6 m only.
        let (height, lies) = rest(engine, &Shape::Cylinder(1.0, 0.6), UnitQuaternion::identity());
        assert!(lies && (height - 1.0).abs() < 5e-3, "{engine}: {height} m");
    }
}

#[test]
fn a_turned_box_stands_on_the_face_that_its_rotation_turns_down() {
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    for engine in ENGINES {
        let (height, lies) = rest(engine, &Shape::Box(Vector3::new(0.6, 1.0, 0.5)), quarter);
        assert!(lies && (height - 1.0).abs() < 5e-3, "{engine}: {height} m");
    }
}
