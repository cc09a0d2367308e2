//! Random torques on every robot, terrain and engine: do the engines ever leave the realm of numbers?
//!
//! `cargo bench --bench robustness` steps ten million times per engine (set `STEPS` for another number,
//! `ENGINE` for one engine) and prints a table; its figures are in
//! docs/experiments/2026-11-22-engine-robustness.md. An episode lasts 2 s at 500 Hz; its torques are uniform
//! within the effort limits, drawn anew in every step, held for ten, or at the limits alone, in turn.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use specforge::learn::clock::thread_seconds;
use specforge::robot::{self, Kinematics, Robot};
use specforge::sim::{self, Engine, EngineSettings, State, Terrain};
use specforge::stream::Stream;

/// Physics steps of an episode.
const EPISODE: u64 = 1000;

fn main() {
    let wanted =
        std::env::var("STEPS").ok().map_or(10_000_000, |text| text.parse().expect("STEPS is a number"));
    println!(
        "| engine | robot | terrain | steps | episodes | beyond reason | not a number | panics | highest \
         joint rate rad/s | furthest beyond a limit rad | us per step |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let chosen = std::env::var("ENGINE").ok();
    for name in sim::ENGINES.iter().filter(|name| chosen.as_deref().is_none_or(|chosen| chosen == **name)) {
        let engine = sim::open(name).expect("all engines are built in");
        let cases: Vec<(&str, &str)> =
            robot::names().flat_map(|robot| TERRAINS.iter().map(move |terrain| (robot, *terrain))).collect();
        let episodes = wanted / EPISODE / cases.len() as u64 + 1;
        let start = Instant::now();
        let (mut sum, chunk) = (Tally::default(), cases.len().div_ceil(threads()));
        let tallies: Vec<Tally> = std::thread::scope(|scope| {
            let work = |cases: &[(&str, &str)]| -> Vec<Tally> {
                cases.iter().map(|(robot, terrain)| torture(&engine, robot, terrain, episodes)).collect()
            };
            let handles: Vec<_> = cases.chunks(chunk).map(|cases| scope.spawn(move || work(cases))).collect();
            handles.into_iter().flat_map(|handle| handle.join().expect("panics are caught")).collect()
        });
        for ((robot, terrain), tally) in cases.iter().zip(&tallies) {
            println!("| {name} | {robot} | {terrain} | {} |", tally.row());
            sum.add(tally);
        }
        println!("| {name} | all | all | {} |", sum.row());
        eprintln!("{name}: {:.0} s", start.elapsed().as_secs_f64());
    }
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

const TERRAINS: [&str; 4] = ["flat", "box", "height field", "slope"];

fn terrain(name: &str) -> Terrain {
    match name {
        "box" => Terrain::BoxObstacle { centre: 0.6, half_length: 0.2, half_width: 4.0, height: 0.05 },
        "height field" => {
            let (counts, mut stream) = ([81, 81], Stream::new("robustness/terrain"));
            let heights = (0..counts[0] * counts[1]).map(|_| 0.05 * stream.uniform()).collect();
            Terrain::HeightField { cell: 0.1, counts, heights }
        }
        "slope" => Terrain::Slope { angle: 0.2 },
        _ => Terrain::Flat,
    }
}

/// What happened.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    steps: u64,
    episodes: u64,
    /// Episodes whose state was finite but beyond physical reason.
    wild: u64,
    /// Episodes whose state was not a number.
    broken: u64,
    panics: u64,
    rate: f64,
    beyond: f64,
    cpu: f64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.steps += other.steps;
        self.episodes += other.episodes;
        self.wild += other.wild;
        self.broken += other.broken;
        self.panics += other.panics;
        self.rate = self.rate.max(other.rate);
        self.beyond = self.beyond.max(other.beyond);
        self.cpu += other.cpu;
    }

    fn row(&self) -> String {
        let Self { steps, episodes, wild, broken, panics, rate, beyond, cpu } = self;
        let us = 1e6 * cpu / *steps as f64;
        format!("{steps} | {episodes} | {wild} | {broken} | {panics} | {rate:.0} | {beyond:.3} | {us:.0}")
    }
}

/// Episodes of one robot on one terrain.
fn torture(engine: &Arc<dyn Engine>, robot: &str, ground: &str, episodes: u64) -> Tally {
    let robot = robot::shipped(robot).expect("it comes with specforge");
    let terrain = terrain(ground);
    let mut tally = Tally::default();
    for number in 0..episodes {
        let mut stream = Stream::new(&format!("robustness/{}/{ground}/{number}", robot.name));
        let mut episode = tally;
        let cpu = thread_seconds();
        let ran = catch_unwind(AssertUnwindSafe(|| {
            play(engine, (&robot, &terrain), number, &mut stream, &mut episode)
        }));
        episode.cpu += thread_seconds() - cpu;
        episode.episodes += 1;
        episode.panics += u64::from(ran.is_err());
        tally = episode;
    }
    tally
}

/// One episode.
fn play(
    engine: &Arc<dyn Engine>,
    place: (&Robot, &Terrain),
    number: u64,
    stream: &mut Stream,
    tally: &mut Tally,
) {
    let (robot, terrain) = place;
    let settings = EngineSettings { step: 0.002, friction: 0.8, contact_time: None };
    let mut state = standing(robot, terrain);
    let mut world = engine.build(robot, terrain, &settings, &state).expect("the engine takes the robot");
    let mut torque = vec![0.0; robot.joints()];
    for step in 0..EPISODE {
        if number % 3 != 1 || step % 10 == 0 {
            for (torque, limit) in torque.iter_mut().zip(robot.effort_limits()) {
                let draw = 2.0 * stream.uniform() - 1.0;
                *torque = if number % 3 == 2 { limit * draw.signum() } else { limit * draw };
            }
        }
        world.step(&torque);
        tally.steps += 1;
        std::hint::black_box(world.contacts());
        world.read(&mut state);
        let mut numbers = state.position.iter().chain(&state.velocity).chain(&state.base_position);
        let finite = numbers.all(|number| number.is_finite());
        if !world.is_sane() || !finite {
            *(if finite { &mut tally.wild } else { &mut tally.broken }) += 1;
            eprintln!(
                "{} {} episode {number} ends in step {step}, finite: {finite}",
                engine.name(),
                robot.name
            );
            return;
        }
        for (link, (position, rate)) in robot.links.iter().zip(state.position.iter().zip(&state.velocity)) {
            tally.rate = tally.rate.max(rate.abs());
            tally.beyond = tally.beyond.max(link.joint.lower - position).max(position - link.joint.upper);
        }
    }
}

/// The default pose at rest, the soles a centimetre above the highest ground below them.
fn standing(robot: &Robot, terrain: &Terrain) -> State {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&nalgebra::Isometry3::identity(), &robot.default_pose());
    let mut height: f64 = 0.0;
    for side in 0..2 {
        let sole = kinematics.sole(side).translation.vector;
        for (x, y) in (-4..=4).flat_map(|x| (-4..=4).map(move |y| (0.1 * f64::from(x), 0.1 * f64::from(y)))) {
            height = height.max(terrain.height(sole.x + x, sole.y + y) - sole.z);
        }
    }
    State {
        base_position: [0.0, 0.0, height + 0.01],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        velocity: vec![0.0; robot.joints()],
        position: robot.default_pose(),
        ..State::default()
    }
}
