//! One step from states of recorded motions: accelerations and forces.

use specforge::robot::Robot;
use specforge::sim::Terrain;

use super::differences::{Differences, differences};
use super::lab::{Drive, SETTINGS, bar, field};
use super::oracle::Oracle;
use super::robots::{decorated, drawn, shipped};

/// The differences, printed as a row.
fn printed(robot: &Robot, terrain: &Terrain, drive: Drive) -> Differences {
    let found = differences(robot, terrain, drive);
    let [half, most, all] = [0.5, 0.99, 1.0].map(|share| found.at(share));
    let (force, touching, steps) = (found.force, found.touching, found.relative.len());
    println!(
        "| {} | {drive:?} | {half:.1e} | {most:.1e} | {all:.1e} | {force:.1e} | {touching} of {steps} |",
        robot.name
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
                let found = printed(&robot, &terrain, drive);
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
    // Of every thousand steps, how many are MuJoCo's. Capsules (G1's) and cylinders have other contacts with
    // a box, and MuJoCo finds the direction of a cylinder's contact with a field to 1e-5 only.
    let robots =
        [("tocabi", 1000, 1000), ("atlas", 1000, 1000), ("g1", 1000, 970)].map(|(name, field, bar)| {
            let robot = specforge::robot::shipped(name).expect("it is shipped");
            (robot, field, bar)
        });
    for (robot, on_field, on_bar) in robots.into_iter().chain([(decorated("atlas"), 750, 900)]) {
        for (name, terrain, share) in [("field", field(), on_field), ("box", bar(), on_bar)] {
            for drive in [Drive::Servo, Drive::Random] {
                println!("on the {name}");
                let found = printed(&robot, &terrain, drive);
                let count = found.relative.iter().filter(|error| **error < 1e-6).count();
                let all = found.relative.len();
                assert!(
                    1000 * count >= share * all,
                    "{} on the {name}, {drive:?}: {count} of {all}",
                    robot.name
                );
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
