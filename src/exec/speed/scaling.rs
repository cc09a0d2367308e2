//! Rollouts and trainings on one thread and on the requested number, measured alternately.

use std::sync::Arc;

use serde::Serialize;

use super::{Seen, SpeedError, crews, median};
use crate::env::Blueprint;
use crate::learn::Settings;
use crate::learn::bench::Rollouts;
use crate::sim::Engine;

/// Repetitions, alternating between one thread and all; the medians are reported.
const TURNS: usize = 5;

/// Where the CPU time of an iteration goes, and how it scales with threads.
#[derive(Clone, Debug, Serialize)]
pub struct Scaling {
    /// Medians on one thread, CPU time in microseconds per sample.
    pub parts: Parts,
    /// One thread and, if there are more, all threads.
    pub rows: Vec<Row>,
}

/// The parts of an iteration, in microseconds of CPU time per sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// The rollout: environments and inference, split over all threads.
    pub rollout: f64,
    /// The actor's gradient steps.
    pub actor: f64,
    /// The critic's gradient steps; concurrent with the actor's if there are two or more threads.
    pub critic: f64,
    /// What only one thread does: metrics, checks, files, and conversion of the networks.
    pub serial: f64,
}

/// Samples per second on a number of threads.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Threads.
    pub threads: usize,
    /// From the CPU time of the slowest thread: the rate on an otherwise idle machine.
    pub undisturbed: f64,
    /// From the wall time of a training.
    pub measured: f64,
}

/// The learner's time per iteration: the networks run in parallel on two or more threads.
fn learner([actor, critic]: [f64; 2], threads: usize) -> f64 {
    if threads > 1 { f64::max(actor, critic) } else { actor + critic }
}

/// Rollouts and updates on one thread and on all, in s.
pub(super) struct Turns {
    alone: Turn,
    together: Turn,
}

/// Medians for one number of threads, in s per rollout.
#[derive(Default)]
struct Turn {
    /// CPU time of the busiest thread.
    longest: f64,
    /// Wall time of the rollout.
    wall: f64,
    /// CPU time of actor and critic.
    learner: [f64; 2],
}

/// Measures rollouts and updates, alternating between all threads and one so that the load affects both.
pub(super) fn turns(
    blueprint: &Blueprint,
    engine: &Arc<dyn Engine>,
    settings: &Settings,
    threads: usize,
) -> Result<Turns, SpeedError> {
    let mut rollouts = Rollouts::new(crews(blueprint, engine.clone(), settings, threads)?, settings)?;
    rollouts.collect(threads)?;
    let (mut alone, mut together) = (Vec::new(), Vec::new());
    for _ in 0..TURNS {
        for (turns, threads) in [(&mut together, threads), (&mut alone, 1)] {
            let collected = rollouts.collect(threads)?;
            let learner = rollouts.improve(threads).map_err(|_| SpeedError::Gradient)?;
            turns.push(Turn { longest: collected.cpu.longest, wall: collected.wall, learner });
        }
    }
    Ok(Turns { alone: middle(&alone), together: middle(&together) })
}

fn middle(turns: &[Turn]) -> Turn {
    let of = |figure: &dyn Fn(&Turn) -> f64| median(turns.iter().map(figure).collect());
    let learner = [of(&|turn| turn.learner[0]), of(&|turn| turn.learner[1])];
    Turn { longest: of(&|turn| turn.longest), wall: of(&|turn| turn.wall), learner }
}

impl Turns {
    /// Samples per second of wall time in rollouts on all threads, and the ratio to one thread.
    pub(super) fn rollouts(&self, samples: usize) -> (f64, f64) {
        (samples as f64 / self.together.wall, self.alone.wall / self.together.wall)
    }

    /// The parts on one thread, and the rates of trainings on one thread and on all.
    pub(super) fn scaling(&self, samples: usize, alone: &Seen, together: &Seen, threads: usize) -> Scaling {
        let us = |seconds: f64| 1e6 * seconds / samples as f64;
        let [actor, critic] = self.alone.learner.map(us);
        let parts = Parts { rollout: us(self.alone.longest), actor, critic, serial: serial(alone) };
        let row = |threads: usize, turn: &Turn, training: &Seen| Row {
            threads,
            undisturbed: 1e6 / (parts.serial + us(turn.longest) + learner(turn.learner.map(us), threads)),
            measured: training.samples_per_s(),
        };
        let mut rows = vec![row(1, &self.alone, alone)];
        if threads > 1 {
            rows.push(row(threads, &self.together, together));
        }
        Scaling { parts, rows }
    }
}

/// Time of a single-threaded training outside rollouts and gradient steps, in microseconds per sample.
fn serial(training: &Seen) -> f64 {
    let last = training.seen.len() - 1;
    let whole = training.clock[last] - training.clock[0];
    let parts = training.seen[last].cpu_s - training.seen[0].cpu_s;
    1e6 * (whole - parts).max(0.0) / training.samples()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_and_all_are_told_with_the_thread_that_the_others_wait_for() {
        let metrics = |samples, wall_s, cpu_s| crate::learn::UpdateMetrics {
            samples,
            wall_s,
            cpu_s,
            ..Default::default()
        };
        let seen = |wall: f64| Seen {
            seen: vec![metrics(0, 0.0, 0.0), metrics(1000, wall, 0.11)],
            clock: vec![1.0, 1.12],
        };
        let turn = |longest| Turn { longest, wall: longest, learner: [0.004, 0.006] };
        let turns = Turns { alone: turn(0.1), together: turn(0.04) };
        let scaling = turns.scaling(1000, &seen(0.2), &seen(0.1), 3);
        assert!((scaling.parts.serial - 10.0).abs() < 1e-9, "{:?}", scaling.parts);
        let [one, three] = &scaling.rows[..] else { panic!("{:?}", scaling.rows) };
        assert_eq!((one.threads, three.threads), (1, 3));
        // On one thread the actor and critic times add up; with more, the slower one counts.
        assert!((one.undisturbed - 1e6 / (10.0 + 100.0 + 10.0)).abs() < 1e-6);
        assert!((three.undisturbed - 1e6 / (10.0 + 40.0 + 6.0)).abs() < 1e-6);
        assert!((one.measured - 5e3).abs() < 1e-6 && (three.measured - 1e4).abs() < 1e-6);
        assert_eq!(turns.scaling(1000, &seen(0.2), &seen(0.2), 1).rows.len(), 1);
    }
}
