//! Time of a physics step of the batch engine under each instruction set, beside MuJoCo's in the same
//! minutes.
//!
//! `cargo bench --bench batch` prints a table: microseconds of one core's time per environment and step, the
//! best of several rounds. TOCABI, soles on flat ground, 2 ms: standing under position control, the same with
//! targets that are drawn anew every 0.1 s, dropped from 5 cm, and in flight. `ROBOT` names another robot.

use std::sync::Arc;

use specforge::learn::clock::thread_seconds;
use specforge::robot::{self, Robot};
use specforge::sim::batch::{Batch, Set};
use specforge::sim::{Engine, EngineSettings, State, Terrain, Worlds, open};
use specforge::stream::Stream;

const SETTINGS: EngineSettings = EngineSettings { step: 0.002, friction: 1.0, contact_time: None };
/// Steps of a round, rounds, environments.
const STEPS: usize = 250;
const ROUNDS: usize = 5;
const ENVIRONMENTS: usize = 32;

fn main() {
    let name = std::env::var("ROBOT").unwrap_or_else(|_| "tocabi".into());
    let robot = robot::shipped(&name).expect("it is shipped");
    println!("| motion | MuJoCo | scalar | AVX2 x 4 | AVX-512 x 8 | MuJoCo / widest |");
    println!("|---|---|---|---|---|---|");
    for motion in ["standing", "random targets", "drop", "flight"] {
        let mut best = [f64::INFINITY; 4];
        for round in 0..ROUNDS {
            best[0] = best[0].min(mujoco(&robot, motion, round));
            for (set, best) in Set::available().into_iter().zip(&mut best[1..]) {
                *best = best.min(lanes(set, &robot, motion, round));
            }
        }
        let last = best.iter().copied().rfind(|time| time.is_finite()).expect("MuJoCo ran");
        let [mujoco, scalar, avx2, avx512] = best;
        println!("| {motion} | {mujoco:.2} | {scalar:.2} | {avx2:.2} | {avx512:.2} | {:.1} |", mujoco / last);
    }
}

fn start(robot: &Robot, motion: &str, stream: &mut Stream) -> State {
    let lift = match motion {
        "drop" => 0.05,
        "flight" => 5.0,
        _ => 0.0,
    };
    let noise = if lift > 0.0 { 0.05 } else { 0.0 };
    let mut noisy = |value: f64| value + noise * stream.normal();
    State {
        base_position: [0.0, 0.0, robot.standing_height + lift],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        position: robot.default_pose().into_iter().map(&mut noisy).collect(),
        velocity: vec![0.0; robot.joints()].into_iter().map(&mut noisy).collect(),
        ..State::default()
    }
}

/// A robot's position control towards targets that may change.
struct Control {
    stream: Stream,
    target: Vec<f64>,
    torque: Vec<f64>,
    noise: f64,
}

impl Control {
    fn new(robot: &Robot, motion: &str, stream: Stream) -> Self {
        let noise = if motion == "random targets" { 0.15 } else { 0.0 };
        Self { stream, target: robot.default_pose(), torque: vec![0.0; robot.joints()], noise }
    }

    fn draw(&mut self, robot: &Robot) {
        for (target, link) in self.target.iter_mut().zip(&robot.links) {
            *target = link.joint.default_position + self.noise * self.stream.normal();
        }
    }

    fn torque(&mut self, robot: &Robot, state: &State) -> &[f64] {
        for (index, link) in robot.links.iter().enumerate() {
            let joint = &link.joint;
            let pull = joint.stiffness_gain * (self.target[index] - state.position[index]);
            let torque = pull - joint.damping_gain * state.velocity[index];
            self.torque[index] = torque.clamp(-joint.effort_limit, joint.effort_limit);
        }
        &self.torque
    }
}

fn mujoco(robot: &Robot, motion: &str, round: usize) -> f64 {
    let engine: Arc<dyn Engine> = open("mujoco").expect("it is built in");
    let mut seconds = 0.0;
    for environment in 0..ENVIRONMENTS {
        let mut stream = Stream::new(&format!("bench/{motion}/{round}/{environment}"));
        let mut state = start(robot, motion, &mut stream);
        let mut control = Control::new(robot, motion, stream);
        let mut world = engine.build(robot, &Terrain::Flat, &SETTINGS, &state).expect("it takes the robot");
        for step in 0..STEPS {
            if step.is_multiple_of(50) {
                control.draw(robot);
            }
            world.apply(control.torque(robot, &state));
            let begin = thread_seconds();
            world.advance();
            seconds += thread_seconds() - begin;
            world.read(&mut state);
        }
    }
    let overhead = clock_overhead();
    1e6 * (seconds / (ENVIRONMENTS * STEPS) as f64 - overhead)
}

fn lanes(set: Set, robot: &Robot, motion: &str, round: usize) -> f64 {
    let mut seconds = 0.0;
    let lanes = set.lanes();
    for group in 0..ENVIRONMENTS / lanes {
        let mut worlds: Box<dyn Worlds> = Batch::slots(set, lanes);
        let mut all: Vec<(State, Control)> = (0..lanes)
            .map(|lane| {
                let mut stream = Stream::new(&format!("bench/{motion}/{round}/{}", group * lanes + lane));
                let state = start(robot, motion, &mut stream);
                worlds.place(lane, robot, &Terrain::Flat, &SETTINGS, &state).expect("it is the same robot");
                (state, Control::new(robot, motion, stream))
            })
            .collect();
        for step in 0..STEPS {
            for (lane, (state, control)) in all.iter_mut().enumerate() {
                if step.is_multiple_of(50) {
                    control.draw(robot);
                }
                worlds.apply(lane, control.torque(robot, state));
            }
            let begin = thread_seconds();
            worlds.advance();
            seconds += thread_seconds() - begin;
            for (lane, (state, _)) in all.iter_mut().enumerate() {
                worlds.read(lane, state);
            }
        }
    }
    let overhead = clock_overhead() / lanes as f64;
    1e6 * (seconds / (ENVIRONMENTS * STEPS) as f64 - overhead)
}

/// What the clock itself adds to a measurement, in s.
fn clock_overhead() -> f64 {
    let begin = thread_seconds();
    let mut sum = 0.0;
    for _ in 0..1000 {
        let begin = thread_seconds();
        sum += thread_seconds() - begin;
    }
    std::hint::black_box(begin);
    sum / 1000.0
}
