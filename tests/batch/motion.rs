//! Motions of half a second, and figures that need no oracle.

use specforge::robot::{GRAVITY, Robot, shipped};
use specforge::sim::{Contacts, State, Terrain, World, open};

use super::lab::{Drive, Driver, SETTINGS, bar, standing};
use super::robots::drawn;

/// A motion of both engines under the same torques, those of the first: states and contacts.
fn both(
    robot: &Robot,
    terrain: &Terrain,
    lift: f64,
    drive: Drive,
    steps: usize,
) -> Vec<[(State, Contacts); 2]> {
    let start = standing(robot, lift);
    let mut worlds: Vec<Box<dyn World>> = ["mujoco", "batch"]
        .map(|name| {
            let engine = open(name).expect("both are built in");
            engine.build(robot, terrain, &SETTINGS, &start).expect("it takes the robot")
        })
        .into();
    let mut driver = Driver::new(robot, drive, &format!("motion/{}", robot.name));
    let (mut state, mut all) = (start, Vec::new());
    for _ in 0..steps {
        let torque = driver.torque(robot, &state);
        let after: Vec<(State, Contacts)> = worlds
            .iter_mut()
            .map(|world| {
                world.step(&torque);
                let mut state = State::default();
                world.read(&mut state);
                (state, world.contacts())
            })
            .collect();
        state = after[0].0.clone();
        all.push(after.try_into().expect("two engines"));
    }
    all
}

/// The largest difference of base positions in m, and the mean vertical forces in N.
fn compared(motion: &[[(State, Contacts); 2]]) -> (f64, [f64; 2]) {
    let mut apart: f64 = 0.0;
    let mut forces = [0.0; 2];
    for step in motion {
        for axis in 0..3 {
            apart = apart.max((step[0].0.base_position[axis] - step[1].0.base_position[axis]).abs());
        }
        for (sum, (_, contacts)) in forces.iter_mut().zip(step) {
            *sum += contacts.foot_force.iter().map(|force| force[2]).sum::<f64>() / motion.len() as f64;
        }
    }
    (apart, forces)
}

#[test]
fn half_a_second_of_steps_falls_and_drops_is_mujocos() {
    let robots = ["tocabi", "atlas", "g1"].map(|name| shipped(name).expect("it is shipped"));
    for robot in robots.into_iter().chain((0..2).map(|number| drawn("atlas", number))) {
        for terrain in [Terrain::Flat, Terrain::Slope { angle: 0.1 }] {
            for (lift, drive) in [(0.05, Drive::Servo), (2.0, Drive::Random)] {
                let (apart, [theirs, ours]) = compared(&both(&robot, &terrain, lift, drive, 250));
                println!("| {} | {drive:?} | {apart:.1e} m | {theirs:.3} N | {ours:.3} N |", robot.name);
                assert!(apart < 1e-5, "{} on {terrain:?}, {drive:?}: {apart} m", robot.name);
                assert!((theirs - ours).abs() < 1e-3 * (1.0 + theirs.abs()), "{theirs} N and {ours} N");
            }
        }
    }
}

#[test]
fn on_a_box_robots_stand_as_high_and_press_as_much() {
    for robot in ["tocabi", "atlas", "g1"].map(|name| shipped(name).expect("it is shipped")) {
        for (name, terrain) in [("bar", bar()), ("plane", Terrain::Flat)] {
            let (apart, [theirs, ours]) = compared(&both(&robot, &terrain, 0.05, Drive::Servo, 150));
            println!("| {} | {name} | {apart:.1e} m | {theirs:.1} N | {ours:.1} N |", robot.name);
            assert!(apart < 0.02, "{} on the {name}: {apart} m", robot.name);
            assert!(
                (theirs / ours - 1.0).abs() < 0.1,
                "{} on the {name}: {theirs} N and {ours} N",
                robot.name
            );
        }
    }
}

#[test]
fn a_standing_robot_presses_with_its_weight() {
    // Its own gains hold TOCABI up; the others would need stiffer ankles.
    let mut robot = shipped("tocabi").expect("it is shipped");
    let engine = open("batch").expect("it is built in");
    // Position control with its damping in the joints, where it is implicit.
    robot.links.iter_mut().for_each(|link| link.joint.damping += link.joint.damping_gain);
    let mut state = standing(&robot, 0.0);
    let mut world = engine.build(&robot, &Terrain::Flat, &SETTINGS, &state).expect("it takes the robot");
    for _ in 0..2000 {
        let hold = robot.links.iter().zip(&state.position);
        let pull = |(link, position): (&specforge::robot::Link, &f64)| {
            link.joint.stiffness_gain * (link.joint.default_position - position)
        };
        let torque: Vec<f64> = hold.map(pull).collect();
        world.step(&torque);
        world.read(&mut state);
    }
    let force: f64 = world.contacts().foot_force.iter().map(|force| force[2]).sum();
    let weight = robot.total_mass() * GRAVITY;
    assert!((force / weight - 1.0).abs() < 1e-3, "{}: {force} N of {weight} N", robot.name);
    assert!(!world.contacts().body);
}
