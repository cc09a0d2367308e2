//! Physics that every engine must get right, and agreement of the engines with each other.

#![cfg(feature = "rapier")]

#[path = "parity/biped.rs"]
mod biped;

use biped::biped;
use specforge::robot::Robot;
use specforge::sim::rapier::Rapier;
use specforge::sim::{Engine, EngineSettings, State, Terrain, World};

/// Acceleration of gravity in m/s^2.
const GRAVITY: f64 = 9.81;

fn settings(step: f64) -> EngineSettings {
    EngineSettings { step, friction: 1.0, contact_time: None }
}

fn engines() -> Vec<Box<dyn Engine>> {
    vec![Box::new(Rapier)]
}

fn standing(robot: &Robot, lift: f64) -> State {
    State {
        base_position: [0.0, 0.0, robot.standing_height + lift],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        ..State::default()
    }
}

/// The robot's own position control at a share of its stiffness, clamped to the effort limits.
fn hold(robot: &Robot, state: &State, target: &[f64], share: f64, torque: &mut [f64]) {
    for (index, link) in robot.links.iter().enumerate() {
        let joint = &link.joint;
        let pull = joint.stiffness_gain * share * (target[index] - state.position[index]);
        let brake = joint.damping_gain * share.sqrt() * state.velocity[index];
        torque[index] = (pull - brake).clamp(-joint.effort_limit, joint.effort_limit);
    }
}

/// Steps a world under the hold of the default pose and returns the state at the end and the mean of
/// the total vertical force over the last quarter.
fn stand(world: &mut dyn World, robot: &Robot, steps: usize) -> (State, f64) {
    let (mut state, mut torque) = (State::default(), vec![0.0; robot.joints()]);
    let (target, tail) = (robot.default_pose(), steps / 4);
    let mut force = 0.0;
    for step in 0..steps {
        world.read(&mut state);
        hold(robot, &state, &target, 1.0, &mut torque);
        world.step(&torque);
        if step >= steps - tail {
            force += world.contacts().foot_force.iter().map(|force| force[2]).sum::<f64>() / tail as f64;
        }
    }
    world.read(&mut state);
    (state, force)
}

#[test]
fn the_feet_of_a_standing_robot_carry_its_weight() {
    let robot = biped();
    for engine in engines() {
        let mut world = engine.build(&robot, &Terrain::Flat, &settings(0.002), &standing(&robot, 0.0)).unwrap();
        let (state, force) = stand(world.as_mut(), &robot, 1000);
        let weight = robot.total_mass() * GRAVITY;
        assert!((force / weight - 1.0).abs() < 1e-3, "{}: {force} N on the feet, weight {weight} N", engine.name());
        assert!(state.base_position[2] > robot.standing_height - 0.05, "{}: {:?}", engine.name(), state.base_position);
        assert!(world.is_sane() && !world.contacts().body);
    }
}

#[test]
fn a_robot_in_the_air_falls_as_galileo_says() {
    let robot = biped();
    for engine in engines() {
        let start = State { base_velocity: [0.5, 0.0, 1.0], ..standing(&robot, 2.0) };
        let mut world = engine.build(&robot, &Terrain::Flat, &settings(0.001), &start).unwrap();
        let (mut state, torque) = (State::default(), vec![0.0; robot.joints()]);
        for _ in 0..300 {
            world.step(&torque);
        }
        world.read(&mut state);
        // The joints are free to move, but joint friction holds them in free fall: nothing pulls on them.
        let expected = start.base_position[2] + 0.3 - 0.5 * GRAVITY * 0.09;
        assert!(
            (state.base_position[2] - expected).abs() < 2e-3,
            "{}: {} m, not {expected}",
            engine.name(),
            state.base_position[2]
        );
        assert!((state.base_position[0] - 0.15).abs() < 1e-3, "{}: {:?}", engine.name(), state.base_position);
        assert!((state.base_velocity[2] - (1.0 - GRAVITY * 0.3)).abs() < 1e-3);
    }
}
