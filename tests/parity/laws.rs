//! Laws of physics that every engine must obey, on the biped, and what the trait promises of a world.

use nalgebra::Isometry3;
use specforge::robot::{GRAVITY, GravityCompensation, Robot, Weighting};
use specforge::sim::{EngineSettings, State, Terrain, World};

use super::biped::{self, biped, centre_of_mass};
use super::flight::tumbling;
use super::lab::{engines, settings, standing};

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
        let mut world =
            engine.build(&robot, &Terrain::Flat, &settings(0.002), &standing(&robot, 0.0)).unwrap();
        let (state, force) = stand(world.as_mut(), &robot, 1000);
        let weight = robot.total_mass() * GRAVITY;
        assert!(
            (force / weight - 1.0).abs() < 1e-3,
            "{}: {force} N on the feet, weight {weight} N",
            engine.name()
        );
        assert!(
            state.base_position[2] > robot.standing_height - 0.05,
            "{}: {:?}",
            engine.name(),
            state.base_position
        );
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

#[test]
fn a_state_is_read_back_as_it_was_set() {
    let robot = biped();
    for engine in engines() {
        let start = tumbling(&robot);
        let world = engine.build(&robot, &Terrain::Flat, &settings(0.002), &start).unwrap();
        let mut state = State::default();
        world.read(&mut state);
        let numbers = |state: &State| {
            let mut all = [state.base_position, state.base_velocity, state.base_rate].concat();
            all.extend(state.base_orientation);
            all.extend(&state.position);
            all.extend(&state.velocity);
            all
        };
        for (read, set) in numbers(&state).iter().zip(numbers(&start)) {
            assert!((read - set).abs() < 1e-6, "{}: {read} was set to {set}", engine.name());
        }
    }
}

#[test]
fn the_centre_of_mass_of_a_tumbling_robot_flies_a_parabola() {
    // With a base frame that is not at the base's centre of mass, a free root of rapier would move wrongly.
    let robot = biped();
    for engine in engines() {
        let mut world = engine.build(&robot, &Terrain::Flat, &settings(0.0005), &tumbling(&robot)).unwrap();
        let mut state = State::default();
        world.read(&mut state);
        let start = centre_of_mass(&robot, &state);
        // Velocity of the centre of mass from a small step along the velocities.
        let small = 1e-5;
        let moved = biped::advanced(&state, small);
        let velocity = (centre_of_mass(&robot, &moved) - start) / small;
        let (time, torque) = (0.4, vec![0.0; robot.joints()]);
        for _ in 0..800 {
            world.step(&torque);
        }
        world.read(&mut state);
        let mut expected = start + velocity * time;
        expected.z -= 0.5 * GRAVITY * time * time;
        let error = (centre_of_mass(&robot, &state) - expected).norm();
        assert!(error < 2e-3, "{}: the centre of mass is {error} m off its parabola", engine.name());
    }
}

#[test]
fn engines_agree_on_the_step_response_of_a_joint() {
    let robot = biped();
    let ends: Vec<State> = engines()
        .iter()
        .map(|engine| {
            let mut world =
                engine.build(&robot, &Terrain::Flat, &settings(0.0005), &standing(&robot, 3.0)).unwrap();
            let mut torque = vec![0.0; robot.joints()];
            (torque[3], torque[8]) = (40.0, -60.0);
            (0..300).for_each(|_| world.step(&torque));
            let mut state = State::default();
            world.read(&mut state);
            state
        })
        .collect();
    for (joint, rest) in robot.default_pose().into_iter().enumerate() {
        for end in &ends[1..] {
            let (one, other) = (ends[0].position[joint] - rest, end.position[joint] - rest);
            assert!(
                (one - other).abs() < 2e-3 + 0.01 * one.abs(),
                "joint {joint} moves by {one} rad or {other} rad"
            );
        }
    }
    assert!(ends[0].position[3] - robot.default_pose()[3] > 0.2, "the torque must move the knee");
}

#[test]
fn equal_worlds_have_bit_identical_states() {
    let robot = biped();
    for engine in engines() {
        let run = || {
            let start = standing(&robot, 0.02);
            let mut world = engine.build(&robot, &Terrain::Flat, &settings(0.002), &start).unwrap();
            let mut state = State::default();
            for step in 0..400 {
                let torque: Vec<f64> =
                    (0..12).map(|joint| 30.0 * libm::sin(0.1 * f64::from(step) + joint as f64)).collect();
                world.step(&torque);
            }
            world.read(&mut state);
            (state, world.contacts())
        };
        let (first, _other) =
            (run(), engine.build(&robot, &Terrain::Flat, &settings(0.001), &standing(&robot, 1.0)));
        assert_eq!(first, run(), "{}", engine.name());
    }
}

#[test]
fn a_push_gives_the_robot_its_impulse_and_ends() {
    let robot = biped();
    for engine in engines() {
        let mut world =
            engine.build(&robot, &Terrain::Flat, &settings(0.001), &standing(&robot, 3.0)).unwrap();
        let (mut state, torque) = (State::default(), vec![0.0; robot.joints()]);
        let mut centre = || {
            world.read(&mut state);
            centre_of_mass(&robot, &state)
        };
        let start = centre();
        world.push([200.0, 0.0, 0.0]);
        (0..100).for_each(|_| world.step(&torque));
        world.push([0.0; 3]);
        (0..200).for_each(|_| world.step(&torque));
        world.read(&mut state);
        let gone = (centre_of_mass(&robot, &state) - start).x;
        // 0.1 s of acceleration, then 0.2 s at the speed reached.
        let speed = 20.0 / robot.total_mass();
        assert!(
            (gone - speed * 0.25).abs() < 1e-3,
            "{}: moved {gone} m, not {}",
            engine.name(),
            speed * 0.25
        );
    }
}

#[test]
fn a_fallen_robot_touches_the_ground_with_its_body() {
    let robot = biped();
    for engine in engines() {
        let mut world =
            engine.build(&robot, &Terrain::Flat, &settings(0.002), &standing(&robot, 0.0)).unwrap();
        let torque: Vec<f64> = (0..12).map(|joint| if joint % 6 == 3 { 200.0 } else { 0.0 }).collect();
        (0..1500).for_each(|_| world.step(&torque));
        assert!(world.contacts().body && world.is_sane(), "{}", engine.name());
    }
}

#[test]
fn every_engine_stands_on_the_height_that_the_terrain_states() {
    let robot = biped();
    // Four plateaus of different heights around the origin.
    let counts = [41, 31];
    let heights = (0..counts[0] * counts[1])
        .map(|index| match (index / counts[1] > 20, index % counts[1] > 15) {
            (false, false) => 0.0,
            (false, true) => 0.1,
            (true, false) => 0.2,
            (true, true) => 0.3,
        })
        .collect();
    let field = Terrain::HeightField { cell: 0.2, counts, heights };
    let block = Terrain::BoxObstacle { centre: 2.0, half_length: 0.6, half_width: 0.6, height: 0.12 };
    for engine in engines() {
        for (terrain, [x, y]) in
            [(&field, [2.0, 1.5]), (&field, [2.0, -1.5]), (&field, [-2.0, 1.5]), (&block, [2.0, 0.0])]
        {
            let ground = terrain.height(x, y);
            let mut start = standing(&robot, ground + 0.002);
            (start.base_position[0], start.base_position[1]) = (x, y);
            let mut world = engine.build(&robot, terrain, &settings(0.002), &start).unwrap();
            let (state, force) = stand(world.as_mut(), &robot, 500);
            let sunk = start.base_position[2] - state.base_position[2];
            assert!((-0.002..0.04).contains(&sunk), "{}: sinks {sunk} m at {x}, {y}", engine.name());
            assert!(
                (force / (robot.total_mass() * GRAVITY) - 1.0).abs() < 0.02,
                "{}: {force} N",
                engine.name()
            );
        }
    }
}

#[test]
fn a_state_that_is_not_a_number_is_noticed() {
    let robot = biped();
    for engine in engines() {
        let mut start = standing(&robot, 0.5);
        start.velocity[4] = f64::NAN;
        let mut world = engine.build(&robot, &Terrain::Flat, &settings(0.002), &start).unwrap();
        assert!(!world.is_sane(), "{}", engine.name());
        world.step(&[0.0; 12]);
        assert!(!world.is_sane(), "{} after a step", engine.name());
    }
}

#[test]
fn gravity_compensation_alone_holds_the_default_pose_while_the_feet_share_the_weight() {
    let robot = biped();
    let base = Isometry3::translation(0.0, 0.0, robot.standing_height);
    let balance = GravityCompensation::new(&robot, Weighting::Uniform)
        .hold(&base, &robot.default_pose(), [true; 2])
        .clone();
    for engine in engines() {
        let mut world =
            engine.build(&robot, &Terrain::Flat, &settings(0.001), &standing(&robot, 0.0)).unwrap();
        let mut state = State::default();
        let mut left = 0.0;
        for step in 0..1000 {
            world.step(&balance.torque);
            if step >= 500 {
                left += world.contacts().foot_force[0][2] / 500.0;
            }
        }
        world.read(&mut state);
        for (joint, (is, was)) in state.position.iter().zip(robot.default_pose()).enumerate() {
            assert!((is - was).abs() < 0.01, "{}: joint {joint} drifted by {} rad", engine.name(), is - was);
        }
        let half = robot.total_mass() * GRAVITY / 2.0;
        assert!((left / half - 1.0).abs() < 0.15, "{}: {left} N on the left foot of {half} N", engine.name());
    }
}

#[test]
fn feet_slip_on_a_steep_slope_as_coulomb_says_and_stick_on_a_rough_one() {
    let robot = biped();
    let angle: f64 = 0.08;
    let half = angle / 2.0;
    let mut start = standing(&robot, 0.0);
    start.base_orientation = [libm::cos(half), 0.0, -libm::sin(half), 0.0];
    start.base_position =
        [-libm::sin(angle) * robot.standing_height, 0.0, libm::cos(angle) * robot.standing_height];
    for engine in engines() {
        let slide = |friction: f64, steps: usize| {
            let settings = EngineSettings { friction, ..settings(0.001) };
            let mut world = engine.build(&robot, &Terrain::Slope { angle }, &settings, &start).unwrap();
            stand(world.as_mut(), &robot, steps).0
        };
        let down = |state: &State| {
            let [x, _, z] = state.base_velocity;
            -(x * libm::cos(angle) + z * libm::sin(angle))
        };
        // The trunk's swing in the joints' hold cancels in the mean of two moments half a second apart.
        let (early, late) = (slide(0.02, 300), slide(0.02, 800));
        let acceleration = (down(&late) - down(&early)) / 0.5;
        let expected = GRAVITY * (libm::sin(angle) - 0.02 * libm::cos(angle));
        assert!(
            (acceleration / expected - 1.0).abs() < 0.1,
            "{}: slips with {acceleration} m/s^2, not {expected}",
            engine.name()
        );
        let rest = down(&slide(1.0, 800));
        assert!(rest.abs() < 0.02, "{}: slips at {rest} m/s on rough ground", engine.name());
    }
}
