//! The table of metrics.

use super::Better::{Higher, Lower};
use super::Source::{Episodes, Learning, SomeEpisodes, Task, Whole};
use super::Suited::{Flying, Staying, Travelling};
use super::{MetricKind, Scale, Source, Sums, learning, surviving};
use crate::outcome::Episode;
use crate::quantity::Dimension;
use crate::spec::Signal;

/// A metric by its name, its label in tables and its source. Its page is the Markdown file with its name.
macro_rules! metric {
    ($name:literal, $label:literal, $source:expr) => {
        MetricKind::new($name, include_str!(concat!($name, ".md")), $label, $source)
    };
}

/// Every metric, in the order of the tables; those of trainings come last.
pub static KINDS: &[&MetricKind] = &[
    &metric!("survival", "survival", Episodes(|e| f64::from(u8::from(e.survived))))
        .unit("%", Dimension::NONE, 0)
        .better(Higher)
        .scale(Scale::Success)
        .in_tables()
        .between(0.0, 1.0),
    &metric!("task_success", "task success", Task)
        .unit("%", Dimension::NONE, 0)
        .better(Higher)
        .scale(Scale::Success)
        .between(0.0, 1.0),
    &metric!("time_to_fall", "time until the fall or the limit", Episodes(|e| e.duration))
        .unit("s", Dimension::TIME, 2)
        .better(Higher)
        .in_tables()
        .not_negative(),
    &metric!("single_support", "single support", Episodes(|e| e.single_support))
        .unit("%", Dimension::NONE, 0)
        .in_tables()
        .between(0.0, 1.0),
    &metric!("left_support", "on the left foot alone", Episodes(|e| e.left_support))
        .unit("%", Dimension::NONE, 0)
        .of(Travelling)
        .in_tables()
        .between(0.0, 1.0),
    &metric!("right_support", "on the right foot alone", Episodes(|e| e.right_support))
        .unit("%", Dimension::NONE, 0)
        .of(Travelling)
        .in_tables()
        .between(0.0, 1.0),
    &metric!("flight", "no foot on the ground", Episodes(|e| e.flight))
        .unit("%", Dimension::NONE, 0)
        .of(Travelling)
        .of_a_task_done()
        .in_tables()
        .between(0.0, 1.0),
    &metric!("flight_per_step", "steps with a flight phase", Episodes(|e| e.flight_per_step))
        .unit("%", Dimension::NONE, 1)
        .better(Higher)
        .of(Flying)
        .in_tables()
        .between(0.0, 1.0),
    &metric!(
        "steady_flight_per_step",
        "steps with a flight phase, second half",
        Episodes(|e| e.steady_flight_per_step)
    )
    .unit("%", Dimension::NONE, 1)
    .better(Higher)
    .of(Flying)
    .in_tables()
    .between(0.0, 1.0),
    &metric!(
        "starting_steps",
        "steps until every step has a flight phase",
        Episodes(|e| f64::from(e.starting_steps))
    )
    .unit("", Dimension::NONE, 1)
    .better(Lower)
    .of(Flying)
    .of_a_task_done()
    .in_tables()
    .not_negative(),
    &metric!("left_steps", "steps of the left foot", Episodes(|e| f64::from(e.steps[0])))
        .unit("", Dimension::NONE, 1)
        .of(Travelling)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("right_steps", "steps of the right foot", Episodes(|e| f64::from(e.steps[1])))
        .unit("", Dimension::NONE, 1)
        .of(Travelling)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("cadence", "touch-downs per second", Episodes(cadence))
        .unit("/s", Dimension::RATE, 2)
        .of(Travelling)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("speed", "mean forward speed", Episodes(|e| e.speed))
        .unit("m/s", Dimension::VELOCITY, 3)
        .of(Travelling)
        .of_a_task_done()
        .in_tables(),
    &metric!("steady_speed", "speed in the second half", Episodes(|e| e.steady_speed))
        .unit("m/s", Dimension::VELOCITY, 3)
        .of(Travelling)
        .of_a_task_done()
        .in_tables(),
    &metric!("speed_error", "speed error", Episodes(|e| e.speed_error))
        .unit("m/s", Dimension::VELOCITY, 3)
        .better(Lower)
        .of(Travelling)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("distance", "distance", Episodes(|e| e.distance))
        .unit("m", Dimension::LENGTH, 2)
        .better(Higher)
        .of(Travelling)
        .of_a_task_done()
        .in_tables(),
    &metric!("drift", "largest distance of the base from its start", SomeEpisodes(|e| e.drift))
        .unit("m", Dimension::LENGTH, 3)
        .better(Lower)
        .of(Staying)
        .in_tables()
        .not_negative(),
    &metric!(
        "crossed",
        "crossed the obstacle",
        SomeEpisodes(|e| e.crossed.map(|crossed| f64::from(u8::from(crossed))))
    )
    .unit("%", Dimension::NONE, 0)
    .better(Higher)
    .scale(Scale::Success)
    .needs(&[Signal::Obstacle])
    .in_tables()
    .between(0.0, 1.0),
    &metric!("joint_error", "largest joint distance from the reference", Episodes(|e| e.tracking_error[0]))
        .unit("rad", Dimension::ANGLE, 3)
        .better(Lower)
        .in_tables()
        .not_negative(),
    &metric!(
        "height_error",
        "largest base-height distance from the reference",
        Episodes(|e| e.tracking_error[1])
    )
    .unit("m", Dimension::LENGTH, 3)
    .better(Lower)
    .in_tables()
    .not_negative(),
    &metric!("peak_foot_force", "peak vertical foot force", Episodes(|e| e.peak_foot_force))
        .unit("N", Dimension::FORCE, 0)
        .better(Lower)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("peak_ankle_torque", "peak ankle pitch torque", SomeEpisodes(|e| e.peak_ankle_torque))
        .unit("N m", Dimension::TORQUE, 0)
        .better(Lower)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("torque_rms", "torque rms", Episodes(|e| e.torque_rms))
        .unit("N m", Dimension::TORQUE, 1)
        .better(Lower)
        .of_a_task_done()
        .in_tables()
        .not_negative(),
    &metric!("self_collision", "time in self-collision", SomeEpisodes(|e| e.self_collision))
        .unit("%", Dimension::NONE, 1)
        .better(Lower)
        .in_tables()
        .between(0.0, 1.0),
    &metric!("reward_per_s", "reward per second", Episodes(|e| e.reward_per_second.values().sum()))
        .unit("/s", Dimension::RATE, 1)
        .better(Higher)
        .sums(Sums::PerStep)
        .of_a_task_done(),
    &metric!(
        "episode_reward",
        "reward of an episode",
        Episodes(|e| e.duration * e.reward_per_second.values().sum::<f64>())
    )
    .unit("", Dimension::NONE, 1)
    .better(Higher)
    .sums(Sums::PerStep)
    .of_a_task_done(),
    &metric!("surviving_reward", "reward of an episode that survives", Whole(surviving::mean))
        .unit("", Dimension::NONE, 1)
        .better(Higher)
        .sums(Sums::PerStep)
        .of_a_task_done(),
    &metric!(
        "surviving_reward_deviation",
        "deviation of the reward of episodes that survive",
        Whole(surviving::deviation)
    )
    .unit("", Dimension::NONE, 1)
    .better(Lower)
    .sums(Sums::PerStep)
    .of_a_task_done()
    .not_negative(),
    &metric!(
        "failure_loading",
        "loading of a parameter in the direction of failure",
        Source::Failures(|failures| failures.loading())
    )
    .unit("", Dimension::NONE, 2)
    .between(0.0, 1.0),
    &metric!(
        "failure_dominance",
        "lead of a parameter in the direction of failure",
        Source::Failures(|failures| failures.lead())
    )
    .unit("", Dimension::NONE, 2)
    .between(-1.0, 1.0),
    &metric!("final_return", "return at the end of learning", Learning(learning::final_return))
        .better(Higher)
        .sums(Sums::PerStep)
        .of_a_task_done(),
    &metric!(
        "final_return_time",
        "return times control step at the end of learning",
        Learning(learning::final_return_time)
    )
    .unit("s", Dimension::TIME, 1)
    .better(Higher)
    .sums(Sums::PerTime)
    .of_a_task_done(),
    &metric!("area_under_curve", "mean return over the learning", Learning(learning::area_under_curve))
        .better(Higher)
        .sums(Sums::PerStep),
    &metric!(
        "samples_to_threshold",
        "samples until the return reaches the threshold",
        Learning(learning::samples_to_threshold)
    )
    .better(Lower)
    .scale(Scale::Censored)
    .sums(Sums::PerStep)
    .not_negative(),
];

/// Touch-downs of both feet per second.
fn cadence(episode: &Episode) -> f64 {
    if episode.duration > 0.0 {
        f64::from(episode.steps[0] + episode.steps[1]) / episode.duration
    } else {
        0.0
    }
}
