//! Forward kinematics of the soles as the engines have it: the height of the base at which a sole first feels
//! the ground, on level ground and on slopes, in random poses. Slopes and turns of the base make x and y
//! visible too.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use specforge::robot::kinematics::rotation_about;
use specforge::robot::{Kinematics, Robot};
use specforge::sim::{Engine, State, Terrain};
use specforge::stream::Stream;

use super::lab::{at_rest, bare, base, each, settings};
use super::table::{Row, within};

/// Half of the interval around the model's height that is searched, in m.
const REACH: f64 = 0.01;
/// Slopes in rad.
const SLOPES: [f64; 3] = [0.0, 0.35, -0.35];

/// All quantities of a robot.
pub fn rows(robot: &Robot) -> Vec<Row> {
    let figures = each(|engine| 1e3 * largest_miss(engine, robot));
    vec![Row::deviation(
        "both soles in 4 random poses, by their first touch of 3 slopes",
        "forward kinematics",
        "mm",
        within(2e-3, figures),
    )]
}

/// The largest difference in m between where a sole touches and where the model has it.
fn largest_miss(engine: &dyn Engine, robot: &Robot) -> f64 {
    let mut stream = Stream::new("parity/soles");
    let poses: Vec<State> = (0..4).map(|_| leaning(robot, &mut stream)).collect();
    let mut most: f64 = 0.0;
    for (side, pose) in (0..2).flat_map(|side| poses.iter().map(move |pose| (side, pose))) {
        let alone = on_one_foot(robot, side);
        for angle in SLOPES {
            let expected = height(robot, side, pose, angle);
            let miss = first_touch(engine, &alone, (side, angle), &lifted(pose, expected));
            most = most.max(miss.abs());
        }
    }
    most
}

/// A robot that leans, turned anyhow about the vertical, its joints near the default pose.
fn leaning(robot: &Robot, stream: &mut Stream) -> State {
    let turn = rotation_about(&Vector3::z(), 3.0 * stream.normal())
        * rotation_about(&Vector3::x(), 0.15 * stream.normal())
        * rotation_about(&Vector3::y(), 0.15 * stream.normal());
    let joints = robot.links.iter().map(|link| {
        let joint = &link.joint;
        (joint.default_position + 0.2 * stream.normal()).clamp(joint.lower, joint.upper)
    });
    at_rest(&Isometry3::from_parts(Translation3::identity(), turn), joints.collect())
}

/// A copy whose other foot is out of the way.
fn on_one_foot(robot: &Robot, side: usize) -> Robot {
    let mut alone = bare(robot);
    alone.feet[1 - side].centre.z += 50.0;
    alone
}

/// Height in m of the base at which the lowest corner of a sole is on a slope, by the model.
fn height(robot: &Robot, side: usize, pose: &State, angle: f64) -> f64 {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&base(pose), &pose.position);
    let normal = Vector3::new(-libm::sin(angle), 0.0, libm::cos(angle));
    let above = |corner: Point3<f64>| corner.coords.dot(&normal) / normal.z;
    -kinematics.corners(side).map(above).into_iter().fold(f64::INFINITY, f64::min)
}

fn lifted(pose: &State, by: f64) -> State {
    let mut lifted = pose.clone();
    lifted.base_position[2] += by;
    lifted
}

/// How much higher than in a pose the base is in m when a sole first touches a slope; more than the search
/// reaches when it touches everywhere or nowhere.
fn first_touch(engine: &dyn Engine, robot: &Robot, (side, angle): (usize, f64), pose: &State) -> f64 {
    let touches = |by: f64| {
        let terrain = if angle == 0.0 { Terrain::Flat } else { Terrain::Slope { angle } };
        let mut world = engine.build(robot, &terrain, &settings(1e-5), &lifted(pose, by)).unwrap();
        world.step(&vec![0.0; robot.joints()]);
        world.contacts().foot_force[side].iter().any(|force| *force != 0.0)
    };
    let (mut low, mut high) = (-REACH, REACH);
    if !touches(low) || touches(high) {
        return 2.0 * REACH;
    }
    while high - low > 1e-8 {
        let middle = 0.5 * (low + high);
        if touches(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
