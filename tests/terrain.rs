//! The ground of every engine against its description: where a sole touches it, how it resists, and where
//! episodes start on it.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

mod worlds;

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use specforge::env::{Mode, ground};
use specforge::robot::model::Body;
use specforge::robot::{Foot, Joint, Link, Robot};
use specforge::sim::{Engine, EngineSettings, State, Terrain};
use specforge::stream::Stream;
use worlds::{GRAVITY, Rig, as_it_is, blueprint, engines, kinematics, on_an_incline, sliding_grip};

/// Distance in m by which a sole is put above and below the height at which it should touch.
const HAIR: f64 = 4e-4;

/// A robot whose left foot is a probe: a sole of these half extents around the origin of the base, the right
/// one 50 m above.
fn probe(half: Vector3<f64>) -> Robot {
    let body = |name: &str, mass: f64| Body {
        name: name.into(),
        mass,
        com: Point3::origin(),
        inertia: Matrix3::identity() * (0.1 * mass),
        collisions: Vec::new(),
    };
    let link = |name: &str, height: f64| Link {
        body: body(name, 1.0),
        parent: None,
        joint: Joint {
            name: format!("{name}_joint"),
            origin: Isometry3::translation(0.0, 0.0, height),
            axis: Vector3::y_axis(),
            lower: -1.0,
            upper: 1.0,
            effort_limit: 1.0,
            velocity_limit: 1.0,
            damping: 0.0,
            friction: 0.0,
            armature: 0.1,
            stiffness_gain: 1.0,
            damping_gain: 1.0,
            default_position: 0.0,
        },
    };
    let foot = |link| Foot { link, half_extents: half, centre: Point3::new(0.0, 0.0, half.z), friction: 1.0 };
    Robot {
        name: "probe".into(),
        base: body("base", 10.0),
        links: vec![link("left", 0.0), link("right", 50.0)],
        feet: [foot(0), foot(1)],
        mirror: vec![(1, 1.0), (0, 1.0)],
        standing_height: 0.0,
    }
}

/// A place of the probe: the middle of its sole in the x-y plane, and its orientation.
#[derive(Clone, Copy, Debug)]
struct Spot {
    at: [f64; 2],
    turn: UnitQuaternion<f64>,
}

impl Spot {
    fn flat(x: f64, y: f64) -> Self {
        Self { at: [x, y], turn: UnitQuaternion::identity() }
    }

    /// The corners of a sole here, at height zero.
    fn sole(&self, half: &Vector3<f64>) -> [[f64; 3]; 4] {
        let pose = Isometry3::from_parts(Translation3::new(self.at[0], self.at[1], 0.0), self.turn);
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
            .map(|(x, y)| (pose * Point3::new(x * half.x, y * half.y, 0.0)).coords.into())
    }

    /// Whether the ground pushes on the probe in its first step, at rest at this height.
    fn touches(&self, engine: &Arc<dyn Engine>, terrain: &Terrain, robot: &Robot, height: f64) -> bool {
        let q = self.turn;
        let state = State {
            base_position: [self.at[0], self.at[1], height],
            base_orientation: [q.w, q.i, q.j, q.k],
            position: vec![0.0; 2],
            velocity: vec![0.0; 2],
            ..State::default()
        };
        let settings = EngineSettings { step: 1e-3, friction: 1.0, contact_time: None };
        let mut world = engine.build(robot, terrain, &settings, &state).unwrap();
        world.step(&[0.0; 2]);
        world.contacts().foot_force[0].iter().any(|force| force.abs() > 1e-6)
    }
}

/// The terrain of a `[terrain]` table, through the checker and the environment's own reading.
fn terrain(lines: &str) -> Terrain {
    let blueprint = blueprint("walk", "torque", &format!("[terrain]\nfriction = 1.0\n{lines}"));
    ground::terrain(&blueprint.part())
}

/// Every engine must touch a probe a hair below the height at which the description puts it on the ground,
/// and not a hair above.
fn every_engine_touches_where_the_description_says(terrain: &Terrain, half: Vector3<f64>, spots: &[Spot]) {
    let robot = probe(half);
    for engine in engines() {
        for spot in spots {
            let height = terrain.above(&spot.sole(&half));
            let [over, under] = [HAIR, -HAIR].map(|gap| spot.touches(&engine, terrain, &robot, height + gap));
            assert!(under && !over, "{}: {spot:?} should touch at {height} m: {over} {under}", engine.name());
        }
    }
}

/// A cube of 8 mm: a point, nearly.
const POINT: Vector3<f64> = Vector3::new(4e-3, 4e-3, 4e-3);

/// TOCABI's sole.
const SOLE: Vector3<f64> = Vector3::new(0.15, 0.085, 0.0135);

const ROUGH: &str = "kind = \"height_field\"\namplitude = \"0.08 m\"\ncell = \"0.1 m\"\nlength = \"2.4 \
    m\"\nwidth = \"1.8 m\"\n\
                     start = \"0 m\"\n";

/// Random spots of a field, tilted by up to this many radians.
fn spots(name: &str, count: usize, tilt: f64) -> Vec<Spot> {
    let mut stream = Stream::new(name);
    let mut within = |bound: f64| bound * (2.0 * stream.uniform() - 1.0);
    let one = |_| Spot {
        at: [within(0.9), within(0.6)],
        turn: UnitQuaternion::from_euler_angles(within(tilt), within(tilt), within(3.0)),
    };
    (0..count).map(one).collect()
}

#[test]
fn a_point_meets_the_same_height_on_a_field_in_every_engine() {
    for seed in 1..4 {
        let field = terrain(&format!("{ROUGH}seed = {seed}\n"));
        let spots = spots(&format!("test/points/{seed}"), 60, 0.0);
        // 4 mm to each side, on a ground as steep as 0.8 in both directions, is at most 6.4 mm of height.
        for spot in &spots {
            let [x, y] = spot.at;
            let apart = (field.above(&spot.sole(&POINT)) - field.height(x, y)).abs();
            assert!(apart < 6.5e-3, "{apart} m at {x}, {y}");
        }
        every_engine_touches_where_the_description_says(&field, POINT, &spots);
    }
}

#[test]
fn a_tilted_sole_rests_on_the_peaks_below_it_in_every_engine() {
    let field = terrain(ROUGH);
    let spots = spots("test/soles", 40, 0.15);
    // Corners alone would not do: on most of these spots something else touches first.
    let by_corners = |spot: &Spot| {
        spot.sole(&SOLE).iter().map(|[x, y, z]| field.height(*x, *y) - z).fold(f64::NEG_INFINITY, f64::max)
    };
    let buried = spots.iter().filter(|spot| field.above(&spot.sole(&SOLE)) > by_corners(spot) + 5e-3).count();
    assert!(buried > 20, "{buried} of 40 spots");
    every_engine_touches_where_the_description_says(&field, SOLE, &spots);
}

#[test]
fn a_box_is_where_its_reference_edge_says_in_every_engine() {
    for (reference, [front, back]) in [("front", [0.6, 1.0]), ("center", [0.4, 0.8])] {
        let lines = format!(
            "kind = \"box_obstacle\"\nheight = \"0.03 m\"\ndistance = \"0.6 m\"\nreference = \
             \"{reference}\"\n"
        );
        let block = terrain(&lines);
        let probed = [(front - 5e-3, 0.0), (front + 5e-3, 0.03), (back - 5e-3, 0.03), (back + 5e-3, 0.0)];
        for (x, height) in probed {
            assert_eq!(block.height(x, 0.5), height, "{reference}: at {x} m");
        }
        let spots: Vec<Spot> =
            probed.iter().flat_map(|(x, _)| [0.0, 3.9, -3.9].map(|y| Spot::flat(*x, y))).collect();
        every_engine_touches_where_the_description_says(&block, POINT, &spots);
        // A whole sole that reaches over an edge by 5 mm lies on the box.
        let over = [Spot::flat(front - SOLE.x + 5e-3, 0.0), Spot::flat(back + SOLE.x - 5e-3, 0.0)];
        assert!(over.iter().all(|spot| block.above(&spot.sole(&SOLE)) == 0.03));
        every_engine_touches_where_the_description_says(&block, SOLE, &over);
    }
}

#[test]
fn a_slope_and_the_plane_are_where_they_should_be_in_every_engine() {
    let level = terrain("kind = \"flat\"\n");
    every_engine_touches_where_the_description_says(&level, SOLE, &spots("test/plane", 10, 0.15));
    for angle in [-0.3, 0.2] {
        let slope = terrain(&format!("kind = \"slope\"\nangle = \"{angle} rad\"\n"));
        assert!((slope.height(2.0, 1.0) - 2.0 * libm::tan(angle)).abs() < 1e-12);
        every_engine_touches_where_the_description_says(&slope, SOLE, &spots("test/slope", 10, 0.15));
    }
}

#[test]
fn beyond_a_field_every_engine_has_the_lower_plane() {
    let field = terrain(ROUGH);
    let level = field.height(1.3, 0.0);
    assert!((-0.05..0.0).contains(&level) && level == field.height(0.0, -1.0));
    let spots = [Spot::flat(1.3, 0.0), Spot::flat(-3.0, 2.0), Spot::flat(0.2, 0.95)];
    every_engine_touches_where_the_description_says(&field, POINT, &spots);
}

#[test]
fn the_coefficient_of_a_foot_is_the_product_of_the_ground_s_and_its_own_in_every_engine() {
    for engine in engines() {
        // More and less than one, so that neither a maximum nor a minimum nor a mean would do.
        for (ground, feet) in [(0.05, [1.0, 1.0]), (0.05, [0.4, 1.6]), (0.02, [3.0, 0.5])] {
            let mut blueprint = on_an_incline(ground, "");
            (0..2).for_each(|side| blueprint.robot.feet[side].friction = feet[side]);
            let measured = sliding_grip(&blueprint, &engine);
            for side in 0..2 {
                let due = ground * feet[side];
                let ratio = measured[side] / due;
                println!(
                    "| {ground} * {} | {} | {:.5} | {due:.5} |",
                    feet[side],
                    engine.name(),
                    measured[side]
                );
                assert!((ratio - 1.0).abs() < 0.02, "{}: {measured:?}, not {due}, on {side}", engine.name());
            }
        }
    }
}

/// Terrains of the starts.
const GROUNDS: [&str; 6] = [
    "kind = \"flat\"\n",
    "kind = \"slope\"\nangle = \"0.15 rad\"\n",
    "kind = \"slope\"\nangle = \"-0.2 rad\"\n",
    // A bar before the toes.
    "kind = \"box_obstacle\"\nheight = \"0.03 m\"\nlength = \"0.06 m\"\ndistance = \"0.25 m\"\n",
    "kind = \"height_field\"\namplitude = \"0.06 m\"\ncell = \"0.07 m\"\nlength = \"3 m\"\nwidth = \"3 \
     m\"\nstart = \"0 m\"\nseed = 1\n",
    "kind = \"height_field\"\namplitude = \"0.1 m\"\ncell = \"0.2 m\"\nlength = \"3 m\"\nwidth = \"3 \
     m\"\nstart = \"0 m\"\nseed = 2\n",
];

/// How far the ground stands out of a robot's soles at most, in m, on a grid of points 5 mm apart; and how
/// far the soles are above the ground at least.
fn depth(robot: &Robot, state: &State, terrain: &Terrain) -> f64 {
    let kinematics = kinematics(robot, state);
    let mut deepest = f64::NEG_INFINITY;
    for side in 0..2 {
        let (sole, half) = (kinematics.sole(side), robot.feet[side].half_extents);
        let steps = |half: f64| (2.0 * half / 0.005).ceil() as usize;
        for (i, j) in (0..=steps(half.x)).flat_map(|i| (0..=steps(half.y)).map(move |j| (i, j))) {
            let share = |index: usize, count: usize| 2.0 * index as f64 / count as f64 - 1.0;
            let point =
                sole * Point3::new(share(i, steps(half.x)) * half.x, share(j, steps(half.y)) * half.y, 0.0);
            deepest = deepest.max(terrain.height(point.x, point.y) - point.z);
        }
    }
    deepest
}

#[test]
fn every_start_has_its_feet_on_or_above_the_ground_and_the_first_step_no_blow() {
    let legs = "[randomize.legs]\nkind = \"leg_length\"\nscale = { uniform = [0.8, 1.25] }\n";
    let reference = "[initial]\nkind = \"reference\"\nstanding_share = \"25 %\"\n";
    for engine in engines() {
        for ground in GROUNDS {
            let land = terrain(ground);
            // A squat never reaches what lies ahead (E0512).
            let tasks = [("walk", ""), ("walk", reference), ("squat", reference)];
            let ahead = ground.contains("distance");
            for (task, initial) in tasks.into_iter().filter(|(task, _)| *task == "walk" || !ahead) {
                let text = format!("[terrain]\nfriction = 1.0\n{ground}{initial}{legs}");
                let blueprint = blueprint(task, "torque", &text);
                let mut rig = Rig::of_mode(&blueprint, &engine, as_it_is, &Mode::Training);
                for episode in 0..6 {
                    rig.environment.begin(&format!("start/{episode}"));
                    let record = rig.act(&[], 1).record();
                    let (robot, start) = (rig.robot(), &record.states[0]);
                    let deepest = depth(&robot, start, &land);
                    // The grid is 5 mm wide; on the steepest cells that is less than 4 mm of height.
                    assert!(
                        (-5e-3..1e-9).contains(&deepest),
                        "{} {ground} {task}: {deepest} m deep",
                        engine.name()
                    );
                    let force: f64 =
                        record.contacts[0].foot_force.iter().flatten().map(|f| f * f).sum::<f64>().sqrt();
                    let weight = robot.total_mass() * GRAVITY;
                    assert!(force < 1.5 * weight, "{} {ground} {task}: {force} N, {weight} N", engine.name());
                }
            }
        }
    }
}
