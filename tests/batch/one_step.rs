//! One step from states of recorded motions: accelerations and forces.

use specforge::robot::Robot;
use specforge::sim::{Contacts, State, Terrain, open};

use super::lab::{Drive, SETTINGS, bar, decorated, drawn, field, recorded, shipped};
use super::oracle::Oracle;

fn ours(robot: &Robot, terrain: &Terrain, state: &State, torque: &[f64], push: [f64; 3]) -> (Vec<f64>, Contacts) {
    let engine = open("batch").expect("it is built in");
    let mut world = engine.build(robot, terrain, &SETTINGS, state).expect("it takes the robot");
    world.push(push);
    world.step(torque);
    let mut after = State::default();
    world.read(&mut after);
    let all = |state: &State| [&state.base_velocity[..], &state.base_rate[..], &state.velocity[..]].concat();
    let change = all(&after).iter().zip(all(state)).map(|(a, b)| (a - b) / SETTINGS.step).collect();
    (change, world.contacts())
}

/// Differences of a motion's steps.
struct Differences {
    /// Of accelerations, relative to the largest one of the step, sorted.
    relative: Vec<f64>,
    /// Largest one of foot forces in N.
    force: f64,
    /// Steps in which one engine has the body on the ground and the other has not.
    body: usize,
    touching: usize,
}

fn differences(robot: &Robot, terrain: &Terrain, drive: Drive) -> Differences {
    let mut oracle = Oracle::new(robot, terrain, &SETTINGS);
    let mut found = Differences { relative: Vec::new(), force: 0.0, body: 0, touching: 0 };
    for (number, (state, torque)) in recorded("mujoco", robot, terrain, drive, 600).into_iter().enumerate().step_by(2) {
        let push = if number.is_multiple_of(4) { [80.0, -50.0, 30.0] } else { [0.0; 3] };
        let (ours, our_contacts) = ours(robot, terrain, &state, &torque, push);
        let (theirs, their_contacts) = oracle.step(&state, &torque, push);
        let scale = theirs.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        let error = ours.iter().zip(&theirs).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        found.relative.push(error / scale);
        for (own, other) in our_contacts.foot_force.iter().flatten().zip(their_contacts.foot_force.iter().flatten()) {
            found.force = found.force.max((own - other).abs());
        }
        found.body += usize::from(our_contacts.body != their_contacts.body);
        let forces = their_contacts.foot_force.iter().flatten();
        found.touching += usize::from(their_contacts.body || forces.copied().any(|force| force != 0.0));
    }
    found.relative.sort_by(f64::total_cmp);
    let at = |share: f64| found.relative[(share * (found.relative.len() - 1) as f64) as usize];
    println!(
        "| {} | {drive:?} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} of {} |",
        robot.name,
        at(0.5),
        at(0.99),
        at(1.0),
        found.force,
        found.touching,
        found.relative.len()
    );
    found
}

#[test]
fn on_planes_a_step_is_mujocos() {
    let mut robots = shipped();
    robots.extend((0..2).map(|number| drawn("tocabi", number)));
    robots.push(drawn("g1", 2));
    robots.push(decorated("atlas"));
    for robot in robots {
        for terrain in [Terrain::Flat, Terrain::Slope { angle: 0.15 }] {
            for drive in [Drive::Servo, Drive::Random] {
                let found = differences(&robot, &terrain, drive);
                let worst = found.relative[found.relative.len() - 1];
                assert!(worst < 1e-6, "{} on {terrain:?}, {drive:?}: {worst:e}", robot.name);
                assert_eq!(found.body, 0, "{} on {terrain:?}, {drive:?}", robot.name);
                assert!(found.touching > 50, "{} on {terrain:?}, {drive:?}: {}", robot.name, found.touching);
            }
        }
    }
}

#[test]
fn on_a_field_and_a_box_steps_are_mujocos() {
    // Of every thousand steps, how many are MuJoCo's. Capsules (G1's) and cylinders have other contacts with a box, and
    // MuJoCo finds the direction of a cylinder's contact with a field to 1e-5 only.
    let robots = [("tocabi", 1000, 1000), ("atlas", 1000, 1000), ("g1", 1000, 970)].map(|(name, field, bar)| {
        let robot = specforge::robot::shipped(name).expect("it is shipped");
        (robot, field, bar)
    });
    for (robot, on_field, on_bar) in robots.into_iter().chain([(decorated("atlas"), 750, 900)]) {
        for (name, terrain, share) in [("field", field(), on_field), ("box", bar(), on_bar)] {
            for drive in [Drive::Servo, Drive::Random] {
                println!("on the {name}");
                let found = differences(&robot, &terrain, drive);
                let count = found.relative.iter().filter(|error| **error < 1e-6).count();
                let all = found.relative.len();
                assert!(1000 * count >= share * all, "{} on the {name}, {drive:?}: {count} of {all}", robot.name);
            }
        }
    }
}

#[test]
fn inverse_weights_are_mujocos() {
    let robots = shipped().into_iter().chain([drawn("tocabi", 0), drawn("g1", 1), decorated("atlas")]);
    for robot in robots {
        let oracle = Oracle::new(&robot, &Terrain::Flat, &SETTINGS);
        let model = oracle.data.model();
        let (joints, bodies) = specforge::sim::batch::inverse_weights(&robot).expect("it takes the robot");
        let of_joints = oracle.dofs.iter().map(|dof| model.dof_invweight0()[*dof]);
        let of_bodies = oracle.bodies.iter().map(|body| model.body_invweight0()[*body][0]);
        for (ours, theirs) in joints.iter().chain(&bodies).zip(of_joints.chain(of_bodies)) {
            assert!((ours / theirs - 1.0).abs() < 1e-9, "{}: {ours} and {theirs}", robot.name);
        }
    }
}
