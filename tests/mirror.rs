//! The mirror map (reflection in the plane y = 0) leaves the dynamics unchanged: a mirrored state under
//! mirrored torques goes where the state goes under its torques, seen in the mirror. In both engines, in the
//! air and on the ground.
//!
//! The robots' left and right halves come from measurements and differ a little, so the strict comparison is
//! made with robots whose right half is the exact mirror image of the left, and the robots as they are have a
//! tolerance of their own.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use specforge::robot::model::Body;
use specforge::robot::symmetry::{is_involution, mirrored};
use specforge::robot::{Robot, shipped};
use specforge::sim::{ENGINES, EngineSettings, State, Terrain, World, open};
use specforge::stream::Stream;

const ROBOTS: [&str; 3] = ["tocabi", "atlas", "g1"];

fn robot(name: &str) -> Robot {
    shipped(name).expect("it comes with the program")
}

fn reflection() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0))
}

fn reflected(pose: &Isometry3<f64>) -> Isometry3<f64> {
    let rotation = reflection() * pose.rotation.to_rotation_matrix().matrix() * reflection();
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Isometry3::from_parts(Translation3::from(reflection() * pose.translation.vector), rotation)
}

fn reflected_body(body: &Body, name: &str) -> Body {
    let mut image = body.clone();
    image.name = name.to_owned();
    image.com = Point3::from(reflection() * body.com.coords);
    image.inertia = reflection() * body.inertia * reflection();
    image.collisions.iter_mut().for_each(|collision| collision.pose = reflected(&collision.pose));
    image
}

/// The middle between a body and its mirror image.
fn levelled(body: &Body) -> Body {
    let image = reflected_body(body, &body.name);
    Body {
        com: nalgebra::center(&body.com, &image.com),
        inertia: 0.5 * (body.inertia + image.inertia),
        collisions: Vec::new(),
        ..image
    }
}

/// The robot with an exact mirror image of its left half on the right.
fn symmetric(robot: &Robot) -> Robot {
    let mut even = robot.clone();
    even.base = levelled(&robot.base);
    for (left, &(right, sign)) in robot.mirror.iter().enumerate().filter(|(left, (right, _))| left < right) {
        let model = &robot.links[left];
        let image = &mut even.links[right];
        image.body = reflected_body(&model.body, &image.body.name);
        let axis = -sign * (reflection() * model.joint.axis.into_inner());
        let off = (axis - image.joint.axis.into_inner()).norm();
        assert!(off < 2e-3, "{}: the axis of `{}` is {off} off", robot.name, image.joint.name);
        let mut joint = model.joint.clone();
        (joint.axis, joint.origin) = (Unit::new_normalize(axis), reflected(&model.joint.origin));
        joint.name = image.joint.name.clone();
        image.joint = joint;
    }
    even.feet[1].half_extents = even.feet[0].half_extents;
    even.feet[1].centre = Point3::from(reflection() * even.feet[0].centre.coords);
    even.feet[1].friction = even.feet[0].friction;
    even
}

/// A state's mirror image.
fn image(robot: &Robot, state: &State) -> State {
    let [w, x, y, z] = state.base_orientation;
    let (place, velocity, rate) = (state.base_position, state.base_velocity, state.base_rate);
    State {
        base_position: [place[0], -place[1], place[2]],
        base_orientation: [w, -x, y, -z],
        base_velocity: [velocity[0], -velocity[1], velocity[2]],
        base_rate: [-rate[0], rate[1], -rate[2]],
        position: mirrored(&robot.mirror, &state.position),
        velocity: mirrored(&robot.mirror, &state.velocity),
    }
}

/// Largest difference of two states over all their numbers.
fn distance(one: &State, other: &State) -> f64 {
    let numbers = |state: &State| {
        let base = [state.base_position, state.base_velocity, state.base_rate].concat();
        [&base, &state.base_orientation[..], &state.position, &state.velocity].concat()
    };
    numbers(one).iter().zip(numbers(other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A state near the default pose, tilted and moving, this far above the ground.
fn start(robot: &Robot, stream: &mut Stream, height: f64, motion: f64) -> State {
    let mut normal = |scale: f64| scale * stream.normal();
    let tilt =
        UnitQuaternion::from_euler_angles(normal(0.1 * motion), normal(0.1 * motion), normal(0.1 * motion));
    State {
        base_position: [normal(0.05), normal(0.05), robot.standing_height + height],
        base_orientation: [tilt.w, tilt.i, tilt.j, tilt.k],
        base_velocity: [0; 3].map(|_| normal(0.3 * motion)),
        base_rate: [0; 3].map(|_| normal(0.3 * motion)),
        position: robot.default_pose().into_iter().map(|place| place + normal(0.1 * motion)).collect(),
        velocity: (0..robot.joints()).map(|_| normal(0.5 * motion)).collect(),
    }
}

/// How far a world and its mirror image are apart after this many steps under random torques, how far the
/// robot has moved in its joints, and whether every foot force was the other's mirror image up to a share of
/// the weight.
struct Compared {
    apart: f64,
    moved: f64,
    forces_apart: f64,
    touched: bool,
}

fn compared(robot: &Robot, engine: &str, state: &State, steps: usize) -> Compared {
    let settings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
    let engine = open(engine).expect("both engines are built in");
    let build =
        |state: &State| engine.build(robot, &Terrain::Flat, &settings, state).expect("the robot is sound");
    let mut worlds: [Box<dyn World>; 2] = [build(state), build(&image(robot, state))];
    let mut stream = Stream::new("test/mirror/torque");
    let mut found = Compared { apart: 0.0, moved: 0.0, forces_apart: 0.0, touched: false };
    let mut torque = vec![0.0; robot.joints()];
    for step in 0..steps {
        if step % 5 == 0 {
            torque = robot.effort_limits().into_iter().map(|limit| 0.1 * limit * stream.normal()).collect();
        }
        worlds[0].step(&torque);
        worlds[1].step(&mirrored(&robot.mirror, &torque));
        let [[left, right], [mirror_left, mirror_right]] =
            worlds.each_ref().map(|world| world.contacts().foot_force);
        for (force, other) in [(left, mirror_right), (right, mirror_left)] {
            let apart = [force[0] - other[0], force[1] + other[1], force[2] - other[2]];
            found.forces_apart = apart.iter().fold(found.forces_apart, |most, part| most.max(part.abs()));
            found.touched |= force[2] > 0.2 * robot.total_mass() * 9.81;
        }
    }
    let mut ends = [State::default(), State::default()];
    worlds.iter().zip(&mut ends).for_each(|(world, end)| world.read(end));
    found.apart = distance(&image(robot, &ends[0]), &ends[1]);
    found.moved = distance(&ends[0], state);
    found
}

#[test]
fn the_map_is_an_involution_on_states_and_torques() {
    for robot in ROBOTS.map(robot) {
        assert!(is_involution(&robot.mirror), "{}", robot.name);
        let state = start(&robot, &mut Stream::new("test/mirror/involution"), 0.3, 1.0);
        assert_eq!(distance(&image(&robot, &image(&robot, &state)), &state), 0.0);
        assert!(distance(&image(&robot, &state), &state) > 0.1, "{}: it is not the identity", robot.name);
    }
}

#[test]
fn in_the_air_a_mirrored_robot_flies_as_the_mirror_image() {
    for robot in ROBOTS.map(robot) {
        let even = symmetric(&robot);
        // To rounding: rapier has single precision, MuJoCo double. In rapier for so short a time that no two
        // joints lie at their limits, which its solver takes one after the other, left before right.
        for (engine, steps, tolerance) in [("rapier", 25, 1e-5), ("mujoco", 100, 1e-12)] {
            let state = start(&even, &mut Stream::new("test/mirror/flight"), 1.0, 0.5);
            let found = compared(&even, engine, &state, steps);
            println!("{} in {engine}, flight: {:.1e}, moved {:.1}", robot.name, found.apart, found.moved);
            assert!(found.apart < tolerance * found.moved, "{} in {engine}: {:.1e}", robot.name, found.apart);
            assert!(found.moved > 1.0 && !found.touched, "{} in {engine}: {}", robot.name, found.moved);
        }
    }
}

#[test]
fn on_the_ground_a_mirrored_robot_moves_as_the_mirror_image() {
    for robot in ROBOTS.map(robot) {
        let even = symmetric(&robot);
        // Rapier's solver takes the contacts one after the other, the left foot's first, and stops before
        // their order has ceased to matter; MuJoCo's goes on to the one solution.
        for (engine, tolerance) in [("rapier", 5e-3), ("mujoco", 1e-12)] {
            let state = start(&even, &mut Stream::new("test/mirror/ground"), 0.0, 0.02);
            let found = compared(&even, engine, &state, 50);
            println!(
                "{} in {engine}, ground: {:.1e}, moved {:.1}, forces {:.1e} N",
                robot.name, found.apart, found.moved, found.forces_apart
            );
            assert!(found.apart < tolerance * found.moved, "{} in {engine}: {:.1e}", robot.name, found.apart);
            assert!(
                engine == "rapier" || found.forces_apart < 1e-8,
                "{}: {} N",
                robot.name,
                found.forces_apart
            );
            assert!(found.touched && found.moved > 0.1, "{} in {engine}: {}", robot.name, found.moved);
        }
    }
}

#[test]
fn the_robots_as_they_are_differ_from_their_mirror_image_by_their_own_asymmetry_only() {
    for robot in ROBOTS.map(robot) {
        for engine in ENGINES {
            let state = start(&robot, &mut Stream::new("test/mirror/real"), 1.0, 1.0);
            let found = compared(&robot, engine, &state, 25);
            println!("{} as it is in {engine}: {:.1e}, moved {:.1}", robot.name, found.apart, found.moved);
            assert!(found.apart < 2e-3 * found.moved, "{} in {engine}: {:.1e}", robot.name, found.apart);
        }
    }
}

#[test]
fn a_wrong_sign_is_seen() {
    for engine in ENGINES {
        let mut even = symmetric(&robot("tocabi"));
        let (yaw, other) = (0, even.mirror[0].0);
        (even.mirror[yaw].1, even.mirror[other].1) = (1.0, 1.0);
        let state = start(&even, &mut Stream::new("test/mirror/flight"), 1.0, 1.0);
        let found = compared(&even, engine, &state, 100);
        assert!(found.apart > 0.1, "{engine}: {:.1e}", found.apart);
    }
}
