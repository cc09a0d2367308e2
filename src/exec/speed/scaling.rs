//! What more threads bring: measured on as many as there are, modelled beyond.
//!
//! An iteration on n threads takes `serial + rollout * ceil(E / n) / E + learner`: E environments, of which
//! no thread has more than its share, rounded up; the learner is actor plus critic on one thread and the
//! slower of the two on more, for they are two independent chains of steps. Waiting for memory or for other
//! programs is not in it.

use std::sync::Arc;

use serde::Serialize;

use super::{Seen, SpeedError, crews, median};
use crate::env::Blueprint;
use crate::learn::Settings;
use crate::learn::bench::Rollouts;
use crate::sim::Engine;

/// Rollouts and updates with one thread and with all, in turn; the medians count.
const TURNS: usize = 5;
/// The numbers of threads that the model is asked for.
const MODELLED: [usize; 5] = [1, 2, 4, 8, 16];

/// The model's parts and what they come to.
#[derive(Clone, Debug, Serialize)]
pub struct Scaling {
    /// Medians on one thread, CPU time in microseconds per sample.
    pub parts: Parts,
    /// By number of threads.
    pub rows: Vec<Row>,
}

/// The parts of an iteration, in microseconds of CPU time per sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// The rollout: environments and inference, split over all threads.
    pub rollout: f64,
    /// The actor's passes.
    pub actor: f64,
    /// The critic's, beside the actor's where there are two threads.
    pub critic: f64,
    /// What one thread does alone: metrics, checks, files, the networks laid out anew.
    pub serial: f64,
}

/// Samples per second on a number of threads.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Threads.
    pub threads: usize,
    /// By the model.
    pub modelled: f64,
    /// By the CPU time of the thread that the others wait for: what an undisturbed machine would do.
    pub undisturbed: Option<f64>,
    /// By the wall clock of a training.
    pub measured: Option<f64>,
}

impl Parts {
    /// Samples per second that this many threads make of these environments.
    pub fn modelled(&self, threads: usize, environments: usize) -> f64 {
        let longest = environments.div_ceil(threads) as f64 / environments as f64;
        1e6 / (self.serial + self.rollout * longest + learner([self.actor, self.critic], threads))
    }
}

/// The learner's share of an iteration.
fn learner([actor, critic]: [f64; 2], threads: usize) -> f64 {
    if threads > 1 { f64::max(actor, critic) } else { actor + critic }
}

/// Rollouts and updates on one thread and on all, in s.
pub(super) struct Turns {
    alone: Turn,
    together: Turn,
}

/// Medians on one number of threads, in s per rollout.
#[derive(Default)]
struct Turn {
    /// CPU time of the thread with the most to do.
    longest: f64,
    /// Wall time of the rollout.
    wall: f64,
    /// CPU time of actor and critic.
    learner: [f64; 2],
}

/// Measures rollouts and updates, in turn on all threads and on one, so that both see the same machine.
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

    /// The model from the parts on one thread, beside what was measured: a training on one thread and one on
    /// all, with so many samples per update and environments.
    pub(super) fn scaling(
        &self,
        (samples, environments): (usize, usize),
        trainings: [&Seen; 2],
        threads: usize,
    ) -> Scaling {
        let us = |seconds: f64| 1e6 * seconds / samples as f64;
        let [alone, together] = trainings;
        let [actor, critic] = self.alone.learner.map(us);
        let parts = Parts { rollout: us(self.alone.longest), actor, critic, serial: serial(alone) };
        let undisturbed = |turn: &Turn, threads| {
            1e6 / (parts.serial + us(turn.longest) + learner(turn.learner.map(us), threads))
        };
        let mut numbers = MODELLED.to_vec();
        numbers.extend((!MODELLED.contains(&threads)).then_some(threads));
        numbers.sort_unstable();
        let row = |count: usize| {
            let seen = match count {
                1 => Some((&self.alone, alone)),
                _ if count == threads => Some((&self.together, together)),
                _ => None,
            };
            Row {
                threads: count,
                modelled: parts.modelled(count, environments),
                undisturbed: seen.map(|(turn, _)| undisturbed(turn, count)),
                measured: seen.map(|(_, training)| training.samples_per_s()),
            }
        };
        Scaling { parts, rows: numbers.into_iter().map(row).collect() }
    }
}

/// What the thread of a training on one thread did beside rollouts and passes, in microseconds per sample.
fn serial(training: &Seen) -> f64 {
    let last = training.seen.len() - 1;
    let whole = training.clock[last] - training.clock[0];
    let parts = training.seen[last].cpu_s - training.seen[0].cpu_s;
    1e6 * (whole - parts).max(0.0) / training.samples()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARTS: Parts = Parts { rollout: 96.0, actor: 10.0, critic: 12.0, serial: 2.0 };

    #[test]
    fn the_model_adds_the_serial_part_the_longest_chunk_and_the_learner() {
        for (threads, us) in [(1, 96.0 + 22.0 + 2.0), (2, 48.0 + 12.0 + 2.0), (16, 6.0 + 12.0 + 2.0)] {
            assert!((PARTS.modelled(threads, 64) - 1e6 / us).abs() < 1e-6, "{threads}");
        }
        // Of ten environments on four threads one thread has three.
        assert!((PARTS.modelled(4, 10) - 1e6 / (0.3 * 96.0 + 14.0)).abs() < 1e-6);
        // More threads than environments change nothing.
        assert!((PARTS.modelled(64, 8) - PARTS.modelled(8, 8)).abs() < 1e-9);
    }

    #[test]
    fn only_what_was_run_is_told_as_measured() {
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
        let scaling = turns.scaling((1000, 10), [&seen(0.2), &seen(0.1)], 3);
        assert!((scaling.parts.serial - 10.0).abs() < 1e-9, "{:?}", scaling.parts);
        let threads: Vec<usize> = scaling.rows.iter().map(|row| row.threads).collect();
        assert_eq!(threads, [1, 2, 3, 4, 8, 16]);
        for row in &scaling.rows {
            assert_eq!(row.measured.is_some(), [1, 3].contains(&row.threads), "{row:?}");
        }
        let three = &scaling.rows[2];
        assert!((three.measured.unwrap() - 1e4).abs() < 1e-6);
        assert!((three.undisturbed.unwrap() - 1e6 / (10.0 + 40.0 + 6.0)).abs() < 1e-6);
        assert!((three.modelled - 1e6 / (10.0 + 0.4 * 100.0 + 6.0)).abs() < 1e-6);
    }
}
