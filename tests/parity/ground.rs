//! Contact with the ground: the friction cone, a drop from 5 cm, and how contact stiffness changes its peak.

use specforge::robot::{GRAVITY, Robot};
use specforge::sim::{Engine, EngineSettings, State, Terrain, open};

use super::lab::{each, kinematics, settings, standing, statue, weight};
use super::stance::{braced, control};
use super::table::{Row, within};

/// Slope of the friction tests in rad.
const SLOPE: f64 = 0.08;
/// Height of the drop in m.
const DROP: f64 = 0.05;

/// All quantities of a robot.
pub fn rows(robot: &Robot) -> Vec<Row> {
    let mut rows = cone(robot);
    rows.extend(drop_test(robot));
    rows
}

/// The default pose on the slope.
fn on_the_slope(robot: &Robot) -> State {
    let (sine, cosine) = libm::sincos(SLOPE);
    State {
        base_orientation: [libm::cos(SLOPE / 2.0), 0.0, -libm::sin(SLOPE / 2.0), 0.0],
        base_position: [-sine * robot.standing_height, 0.0, cosine * robot.standing_height],
        ..standing(robot, 0.0)
    }
}

/// Velocity in m/s down the slope of a statue, 0.1 s and 0.4 s after it was put there.
fn slide(engine: &dyn Engine, statue: &Robot, friction: f64) -> [f64; 2] {
    let settings = EngineSettings { friction, ..settings(0.002) };
    let terrain = Terrain::Slope { angle: SLOPE };
    let mut world = engine.build(statue, &terrain, &settings, &on_the_slope(statue)).unwrap();
    let torque = vec![0.0; statue.joints()];
    let mut state = State::default();
    [50, 150].map(|steps| {
        (0..steps).for_each(|_| world.step(&torque));
        world.read(&mut state);
        let [x, _, z] = state.base_velocity;
        -(x * libm::cos(SLOPE) + z * libm::sin(SLOPE))
    })
}

/// A statue on a slope: the friction at which it begins to slip, how it slips at half of that, and how it
/// creeps at twice of it.
fn cone(robot: &Robot) -> Vec<Row> {
    let (statue, edge) = (statue(robot), libm::tan(SLOPE));
    let gain = |engine: &dyn Engine, friction: f64| {
        let [early, late] = slide(engine, &statue, friction);
        (late - early) / 0.3
    };
    let threshold = each(|engine| {
        let (mut slips, mut sticks) = (0.5 * edge, 2.0 * edge);
        while sticks - slips > 1e-3 * edge {
            let friction = 0.5 * (slips + sticks);
            if gain(engine, friction) > 5e-4 { slips = friction } else { sticks = friction }
        }
        0.5 * (slips + sticks) / edge - 1.0
    });
    let expected = GRAVITY * (libm::sin(SLOPE) - 0.5 * edge * libm::cos(SLOPE));
    let slip = each(|engine| gain(engine, 0.5 * edge) / expected - 1.0);
    let creep = each(|engine| 1e3 * slide(engine, &statue, 2.0 * edge)[1].abs());
    vec![
        Row::deviation(
            "friction cone: threshold of slip on a slope",
            format!("{edge:.4}"),
            "relative",
            within(5e-3, threshold),
        ),
        Row::deviation(
            "friction cone: acceleration at half of it",
            format!("{expected:.4} m/s^2"),
            "relative",
            within(0.01, slip),
        ),
        Row::deviation("friction cone: creep at twice of it", "0", "mm/s", within(1.0, creep)),
    ]
}

/// What a drop showed.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    /// Largest force on both feet in one step, in weights.
    pub peak: f64,
    /// Largest mean of it over 8 ms, in weights.
    pub mean: f64,
    /// Mean depth of the lowest sole in the last half second in m; `None` when the robot has fallen.
    pub depth: Option<f64>,
    /// Time of the first touch in s.
    pub touch: f64,
}

/// A drop of the default pose under position control, and two seconds of standing.
pub fn impact(engine: &dyn Engine, robot: &Robot, settings: &EngineSettings) -> Impact {
    let robot = braced(robot);
    let start = standing(&robot, DROP);
    let none = vec![0.0; robot.joints()];
    let mut world = engine.build(&robot, &Terrain::Flat, settings, &start).unwrap();
    let (mut state, mut forces, mut depths) = (start.clone(), Vec::new(), Vec::new());
    let steps = (2.0 / settings.step) as usize;
    for step in 0..steps {
        world.step(&control(&robot, &state, &start.position, &none));
        world.read(&mut state);
        let contacts = world.contacts();
        forces.push((contacts.foot_force[0][2] + contacts.foot_force[1][2]) / weight(&robot));
        if step >= steps * 3 / 4 && step % 10 == 0 {
            let kinematics = kinematics(&robot, &state);
            depths.push(-kinematics.lowest_corner(0).min(kinematics.lowest_corner(1)));
        }
    }
    let window = (0.008 / settings.step).round() as usize;
    let most = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
    let upright = state.base_position[2] > 0.9 * robot.standing_height;
    Impact {
        peak: most(&mut forces.iter().copied()),
        mean: most(&mut forces.windows(window).map(|part| part.iter().sum::<f64>() / window as f64)),
        depth: upright.then(|| depths.iter().sum::<f64>() / depths.len() as f64),
        touch: forces
            .iter()
            .position(|force| *force > 0.0)
            .map_or(f64::INFINITY, |step| step as f64 * settings.step),
    }
}

/// A drop from 5 cm with the settings of training and those of the transfer.
fn drop_test(robot: &Robot) -> Vec<Row> {
    let impacts = each(|engine| impact(engine, robot, &settings(0.002)));
    let fall = libm::sqrt(2.0 * DROP / GRAVITY);
    let touch = impacts.map(|impact| impact.touch - fall);
    vec![
        Row::deviation("drop from 5 cm: first touch", format!("{fall:.4} s"), "s", within(0.005, touch)),
        Row::between(
            "drop from 5 cm: peak of the 8 ms mean",
            "weights",
            impacts.map(|i| i.mean),
            (4.0, 15.0),
        ),
        Row::between("drop from 5 cm: peak of a step", "weights", impacts.map(|i| i.peak), (4.0, 60.0)),
    ]
}

/// Settings of contact: the engine, its step in s and its contact time in s; `None` is the engine's own
/// contact.
pub type Contact = (&'static str, f64, Option<f64>);

/// The settings of the table of contact stiffness. The first is that of training.
pub const CONTACTS: [Contact; 12] = [
    ("rapier", 0.002, None),
    ("rapier", 0.0005, None),
    ("MuJoCo", 0.002, None),
    ("MuJoCo", 0.002, Some(0.01)),
    ("MuJoCo", 0.002, Some(0.005)),
    ("MuJoCo", 0.0005, Some(0.01)),
    ("MuJoCo", 0.0005, Some(0.005)),
    ("batch", 0.002, None),
    ("batch", 0.002, Some(0.005)),
    ("rapier", 0.002, Some(0.005)),
    ("rapier", 0.002, Some(0.01)),
    ("rapier", 0.002, Some(0.02)),
];

/// Drops of a robot with every setting of contact.
pub fn stiffness(robot: &Robot) -> Vec<Impact> {
    let drop = |(engine, step, contact_time): Contact| {
        let engine = open(&engine.to_lowercase()).unwrap();
        impact(engine.as_ref(), robot, &EngineSettings { contact_time, ..settings(step) })
    };
    CONTACTS.into_iter().map(drop).collect()
}
