//! Time of a check for self-collision: `cargo bench --bench self_collision` prints microseconds of CPU time
//! per check.
//!
//! The joints are at their default positions plus up to 0.3 rad, about as far as walking moves them.

use specforge::learn::clock::thread_seconds;
use specforge::robot::{self, SelfCollision};
use specforge::stream::Stream;

/// Poses of a round, and rounds.
const POSES: usize = 2000;
const ROUNDS: usize = 9;

fn main() {
    println!("| robot | pairs of bodies | us per check | poses that collide |");
    println!("|---|---|---|---|");
    for name in robot::names() {
        let robot = robot::shipped(name).expect("it is shipped");
        let pairs = SelfCollision::pairs(&robot);
        let mut check = SelfCollision::new(&robot, pairs.clone());
        let mut stream = Stream::new("bench/self_collision");
        let mut pose = || -> Vec<f64> {
            robot.default_pose().iter().map(|angle| angle + 0.3 * (2.0 * stream.uniform() - 1.0)).collect()
        };
        let poses: Vec<Vec<f64>> = (0..POSES).map(|_| pose()).collect();
        let (mut times, mut colliding) = (Vec::new(), 0);
        for _ in 0..ROUNDS {
            let start = thread_seconds();
            colliding = poses.iter().filter(|pose| check.find(pose).is_some()).count();
            times.push(1e6 * (thread_seconds() - start) / POSES as f64);
        }
        times.sort_by(f64::total_cmp);
        println!("| {name} | {} | {:.2} | {colliding} of {POSES} |", pairs.len(), times[ROUNDS / 2]);
    }
}
