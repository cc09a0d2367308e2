//! The commanded speed over an episode: draws at intervals, approached along ramps.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::kinds::task::{self, Task};
use crate::spec::Sampler;
use crate::stream::Stream;

/// Number of speeds that represent a continuous distribution.
const PARTS: usize = 8;

/// The settings of `task.command`.
#[derive(Clone, Debug, PartialEq)]
pub struct CommandPlan {
    speed: Sampler,
    every: Option<f64>,
    ramp: f64,
}

impl CommandPlan {
    /// The plan of a task; the speed is zero without a command.
    pub fn new(task: &Task) -> Self {
        let plan = |command: &task::Command| Self {
            speed: command.speed.clone(),
            every: command.every,
            ramp: command.ramp,
        };
        task.command().map_or_else(|| Self::constant(0.0), plan)
    }

    /// Equally likely speeds in m/s that represent the distribution of the draws: for a continuous one,
    /// values of equal probability.
    pub fn speeds(&self) -> Vec<f64> {
        let middle = |part: usize| (part as f64 + 0.5) / PARTS as f64;
        match &self.speed {
            Sampler::Constant(speed) => vec![*speed],
            Sampler::Choice(speeds) => speeds.clone(),
            Sampler::Normal([mean, deviation]) => {
                let normal = Normal::standard();
                (0..PARTS).map(|part| mean + deviation * normal.inverse_cdf(middle(part))).collect()
            }
            Sampler::Uniform(_) | Sampler::LogUniform(_) => {
                (0..PARTS).map(|part| self.speed.draw(middle(part), 0.0)).collect()
            }
        }
    }

    /// A constant speed in m/s.
    pub fn constant(speed: f64) -> Self {
        Self { speed: Sampler::Constant(speed), every: None, ramp: 0.0 }
    }
}

/// The command of a running episode.
#[derive(Clone, Debug)]
pub struct Command {
    stream: Stream,
    from: f64,
    target: f64,
    since: f64,
    next: f64,
}

impl Command {
    /// Starts an episode at the first draw.
    pub fn begin(plan: &CommandPlan, mut stream: Stream) -> Self {
        let speed = stream.draw(&plan.speed);
        Self { stream, from: speed, target: speed, since: 0.0, next: plan.every.unwrap_or(f64::INFINITY) }
    }

    /// Advances to a time in s and returns the speed in m/s; times must not decrease.
    pub fn at(&mut self, plan: &CommandPlan, time: f64) -> f64 {
        // A nanosecond of slack: sums of control steps fall short of the interval by rounding.
        while time >= self.next - 1e-9 {
            self.from = self.speed(plan, self.next);
            self.target = self.stream.draw(&plan.speed);
            self.since = self.next;
            self.next += plan.every.unwrap_or(f64::INFINITY);
        }
        self.speed(plan, time)
    }

    fn speed(&self, plan: &CommandPlan, time: f64) -> f64 {
        let passed = time - self.since;
        if passed >= plan.ramp {
            self.target
        } else {
            self.from + (self.target - self.from) * passed / plan.ramp
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_draw_is_approached_along_a_straight_ramp() {
        let plan = CommandPlan { speed: Sampler::Uniform([0.0, 0.5]), every: Some(4.0), ramp: 1.0 };
        let mut command = Command::begin(&plan, Stream::new("test"));
        let first = command.at(&plan, 0.0);
        assert_eq!(command.at(&plan, 3.9), first);
        let quarter = command.at(&plan, 4.25);
        let second = command.at(&plan, 5.0);
        assert_ne!(first, second);
        assert!((quarter - (first + 0.25 * (second - first))).abs() < 1e-12);
        assert_eq!(command.at(&plan, 7.9), second);
    }

    #[test]
    fn a_few_speeds_represent_the_distribution() {
        let speeds = |speed| CommandPlan { speed, every: None, ramp: 0.0 }.speeds();
        let mean = |speeds: &[f64]| speeds.iter().sum::<f64>() / speeds.len() as f64;
        assert_eq!(CommandPlan::constant(0.3).speeds(), [0.3]);
        assert_eq!(speeds(Sampler::Choice(vec![0.1, 0.9])), [0.1, 0.9]);
        let uniform = speeds(Sampler::Uniform([0.0, 0.8]));
        assert!((uniform[0] - 0.05).abs() < 1e-12 && (mean(&uniform) - 0.4).abs() < 1e-12, "{uniform:?}");
        let normal = speeds(Sampler::Normal([0.5, 0.1]));
        assert!((mean(&normal) - 0.5).abs() < 1e-9 && normal[7] > 0.6, "{normal:?}");
    }

    #[test]
    fn without_an_interval_one_draw_holds() {
        let plan = CommandPlan { speed: Sampler::Uniform([0.1, 0.3]), every: None, ramp: 0.0 };
        let mut command = Command::begin(&plan, Stream::new("test"));
        let first = command.at(&plan, 0.0);
        assert!((0.1..0.3).contains(&first));
        assert_eq!(command.at(&plan, 1e6), first);
    }
}
