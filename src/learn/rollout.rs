//! Rollouts: all environments step under the current policy, in small groups that threads take in turn for a
//! few steps each.
//!
//! A thread takes the group that has waited longest and returns it after some steps, so all groups finish at
//! about the same time and no thread idles. What is recorded does not depend on the number of threads:
//! inference treats each row separately, and each environment draws its noise from its own stream.

use std::collections::VecDeque;
use std::sync::Mutex;

use super::advantage::Discount;
use super::clock::timed;
use super::inference::{Inference, Scratch};
use super::lane::{Lane, NotANumber, Squad, observe_state};
use super::pace::Pace;
use super::settings::Settings;
use crate::crash;
use crate::env::View;
use crate::stream::Stream;

/// The networks of a rollout and its position in the training.
#[derive(Clone, Copy, Debug)]
pub struct Policy<'a> {
    /// The actor.
    pub actor: &'a Inference,
    /// The critic.
    pub critic: &'a Inference,
    /// Number of the update that will learn from the rollout.
    pub update: u64,
}

/// Environments that go through a rollout side by side, unless a larger number steps together: their worlds,
/// 120 kB each in rapier, stay in a core's cache between steps, and their rows share each load of the actor's
/// weights.
const GROUP: usize = 4;
/// Smallest number of control steps for which a thread takes a group.
const STRETCH: usize = 4;
/// Rows of the critic's inputs that are evaluated at once.
const VALUE_ROWS: usize = 256;

/// CPU time in s that a rollout took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Over all threads.
    pub all: f64,
    /// CPU time of the busiest thread, for which the others wait.
    pub longest: f64,
    /// Part of the total spent on the critic's values and the advantages after the steps.
    pub values: f64,
}

/// Reasons why a rollout did not finish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// A reward is NaN or infinite.
    Fault(NotANumber),
    /// The rollout was interrupted. The lanes can still return to its beginning ([`Lane::at_start`]).
    Interrupted,
}

/// Steps all environments for one rollout and estimates advantages.
pub fn collect(squads: &mut [Squad], policy: Policy, settings: &Settings, pace: Pace) -> Result<Spent, Halt> {
    let threads = pace.threads.clamp(1, squads.len().max(1));
    let size = squads_together(squads, threads);
    let groups = squads.chunks_mut(size).map(|squads| Group::new(squads, policy, settings));
    let waiting = Mutex::new(groups.collect::<VecDeque<_>>());
    let part = crash::part();
    let work = || {
        let mut share = Share::default();
        let mut scratch = Scratch::default();
        // No group is waiting while each unfinished group is with another thread.
        let next = || waiting.lock().expect("taking a group does not panic").pop_front();
        part.join();
        let ((), cpu) = timed(|| {
            while let Some(mut group) = next() {
                let mut place = group.stretch(policy, settings, &mut scratch, pace);
                if let Ok(Place::Done) = place {
                    let (is_whole, cpu) = timed(|| group.estimate(policy, settings, &mut scratch, pace));
                    share.values += cpu;
                    place = if is_whole { place } else { Err(Halt::Interrupted) };
                }
                match place {
                    Ok(Place::Done) => {}
                    Ok(Place::Waiting) => {
                        waiting.lock().expect("giving a group back does not panic").push_back(group)
                    }
                    Err(Halt::Fault(fault)) => share.faults.push((group.step, fault)),
                    Err(Halt::Interrupted) => {
                        share.interrupted = true;
                        break;
                    }
                }
            }
        });
        Share { cpu, ..share }
    };
    let results: Vec<Share> = std::thread::scope(|scope| {
        let handles: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut results = vec![work()];
        results.extend(handles.into_iter().map(|handle| crash::joined(handle.join())));
        results
    });
    let all = results.iter().map(|share| share.cpu).sum();
    let longest = results.iter().map(|share| share.cpu).fold(0.0, f64::max);
    let values = results.iter().map(|share| share.values).sum();
    if results.iter().any(|share| share.interrupted) {
        return Err(Halt::Interrupted);
    }
    // The earliest fault, whichever thread met it; at equal steps that of the first environment.
    let faults = results.into_iter().flat_map(|share| share.faults);
    let first = faults.min_by_key(|(step, fault)| (*step, fault.environment));
    first.map_or(Ok(Spent { all, longest, values }), |(_, fault)| Err(Halt::Fault(fault)))
}

/// Number of squads that go through a rollout side by side on one thread.
fn squads_together(squads: &[Squad], threads: usize) -> usize {
    let most = GROUP.div_ceil(squads.first().map_or(1, |squad| squad.lanes.len()));
    (squads.len() / (2 * threads)).clamp(1, most)
}

/// The number of environments in these squads.
pub(super) fn together(squads: &[Squad], threads: usize) -> usize {
    squads[..squads_together(squads, threads)].iter().map(|squad| squad.lanes.len()).sum()
}

/// Result of one thread's share of a rollout.
#[derive(Default)]
struct Share {
    /// Rewards that are NaN or infinite, with their step of the rollout.
    faults: Vec<(usize, NotANumber)>,
    /// CPU time in s.
    cpu: f64,
    /// Part of it spent on values and advantages.
    values: f64,
    /// Whether it was interrupted before the end.
    interrupted: bool,
}

/// Environments that go through a rollout side by side, a few steps at a time, on whichever thread takes them
/// next.
struct Group<'a> {
    squads: &'a mut [Squad],
    noise: Vec<Stream>,
    /// One row per environment.
    observations: Vec<f32>,
    means: Vec<f32>,
    /// Control steps so far.
    step: usize,
}

/// State of a group after some steps.
enum Place {
    /// In the middle of the rollout.
    Waiting,
    /// At its end.
    Done,
}

impl<'a> Group<'a> {
    fn new(squads: &'a mut [Squad], policy: Policy, settings: &Settings) -> Self {
        let stream =
            |lane: &Lane| Stream::new(&settings.stream(&format!("noise/{}/{}", policy.update, lane.index)));
        let noise: Vec<Stream> = squads.iter().flat_map(|squad| &squad.lanes).map(stream).collect();
        let observations = vec![0.0; noise.len() * policy.actor.inputs()];
        let means = vec![0.0; noise.len() * policy.actor.outputs()];
        squads.iter_mut().for_each(Squad::clear);
        Self { squads, noise, observations, means, step: 0 }
    }

    /// The next control steps: half of the remaining ones, so that towards the end no thread waits long for
    /// another.
    fn stretch(
        &mut self,
        policy: Policy,
        settings: &Settings,
        scratch: &mut Scratch,
        pace: Pace,
    ) -> Result<Place, Halt> {
        let left = settings.horizon() - self.step;
        for _ in 0..(left / 2).max(STRETCH).min(left) {
            if (pace.stop)() {
                return Err(Halt::Interrupted);
            }
            self.advance(policy.actor, settings, scratch).map_err(Halt::Fault)?;
        }
        Ok(if self.step < settings.horizon() { Place::Waiting } else { Place::Done })
    }

    /// The values of all states and the advantages, at the end of the rollout. False if interrupted before.
    fn estimate(&mut self, policy: Policy, settings: &Settings, scratch: &mut Scratch, pace: Pace) -> bool {
        let discount = Discount { gamma: settings.gamma, lambda: settings.lambda };
        for squad in &mut *self.squads {
            for (slot, lane) in squad.lanes.iter_mut().enumerate() {
                if !evaluate(lane, squad.crew.view(slot), policy.critic, settings, scratch, pace) {
                    return false;
                }
                lane.estimate(discount);
            }
        }
        true
    }

    /// One control step of each environment.
    fn advance(
        &mut self,
        actor: &Inference,
        settings: &Settings,
        scratch: &mut Scratch,
    ) -> Result<(), NotANumber> {
        let Self { squads, noise, observations, means, step } = self;
        let mut rows = observations.chunks_exact_mut(actor.inputs());
        for squad in &mut **squads {
            for ((slot, lane), row) in squad.lanes.iter_mut().enumerate().zip(&mut rows) {
                observe(lane, squad.crew.view(slot), *step, row, settings);
            }
        }
        actor.forward(observations, means, scratch);
        let mut drawn = means.chunks_exact(actor.outputs()).zip(noise);
        for squad in &mut **squads {
            for (lane, (means, noise)) in squad.lanes.iter_mut().zip(&mut drawn) {
                draw(lane, *step, means, noise, &settings.std);
            }
            squad.advance(*step, settings)?;
        }
        *step += 1;
        Ok(())
    }
}

/// Records the inputs of both networks.
fn observe(lane: &mut Lane, view: &dyn View, step: usize, row: &mut [f32], settings: &Settings) {
    view.observe(row);
    lane.records.observations[step * row.len()..(step + 1) * row.len()].copy_from_slice(row);
    let width = lane.records.state_width();
    let (own, truths) = lane.records.states[step * width..(step + 1) * width].split_at_mut(row.len());
    own.copy_from_slice(row);
    if settings.privileged {
        view.observe_truths(truths);
    }
}

/// Draws and records an action.
fn draw(lane: &mut Lane, step: usize, means: &[f32], noise: &mut Stream, std: &[f64]) {
    let row = step * means.len()..(step + 1) * means.len();
    lane.records.means[row.clone()].copy_from_slice(means);
    for ((action, mean), std) in lane.records.actions[row].iter_mut().zip(means).zip(std) {
        *action = mean + (std * noise.normal()) as f32;
    }
}

/// Records the critic's values of all states, including the state after the rollout and the states at time
/// limits. False if interrupted before.
fn evaluate(
    lane: &mut Lane,
    view: &dyn View,
    critic: &Inference,
    settings: &Settings,
    scratch: &mut Scratch,
    pace: Pace,
) -> bool {
    let (steps, width) = (settings.horizon(), lane.records.state_width());
    observe_state(view, settings.privileged, &mut lane.records.states[steps * width..]);
    let records = &mut lane.records;
    for (states, values) in
        records.states.chunks(VALUE_ROWS * width).zip(records.values.chunks_mut(VALUE_ROWS))
    {
        if (pace.stop)() {
            return false;
        }
        critic.forward(states, values, scratch);
    }
    let mut values = vec![0.0; records.timeouts.len()];
    if !values.is_empty() {
        critic.forward(&records.timeout_states, &mut values, scratch);
    }
    for (step, value) in records.timeouts.iter().zip(values) {
        records.ends[*step] = Some(value);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::{Crew, End};
    use crate::learn::toy::{Toy, settings};
    use crate::learn::{Activation, Network};

    fn network(name: &str, widths: &[usize]) -> Inference {
        Inference::new(&Network::orthogonal(widths, Activation::Relu, &mut Stream::new(name)))
    }

    #[test]
    fn every_environment_takes_all_its_steps_whatever_the_number_of_threads() {
        for (environments, horizon) in [(1, 1), (5, 3), (7, 21), (9, 100)] {
            let settings = Settings { rollout: environments * horizon, environments, ..settings() };
            let (actor, critic) =
                (network("test/rollout/actor", &[2, 8, 1]), network("test/rollout/critic", &[3, 8, 1]));
            let rollout = |threads| {
                let mut squads = Squad::begun(Toy::crews(environments), &settings);
                let policy = Policy { actor: &actor, critic: &critic, update: 0 };
                collect(&mut squads, policy, &settings, Pace::to_the_end(threads)).unwrap();
                let lanes: Vec<Lane> = squads.into_iter().flat_map(|squad| squad.lanes).collect();
                assert!(lanes.iter().all(|lane| lane.tally.steps == horizon as u64));
                let numbers =
                    |lane: Lane| (lane.records.actions, lane.records.advantages, lane.records.targets);
                lanes.into_iter().map(numbers).collect::<Vec<_>>()
            };
            let alone = rollout(1);
            for threads in [2, 3, 16] {
                assert!(
                    rollout(threads) == alone,
                    "{environments} environments, {horizon} steps, {threads} threads"
                );
            }
        }
    }

    #[test]
    fn the_earliest_fault_is_told_whichever_thread_meets_it() {
        let settings = settings();
        for threads in [1, 2, 5] {
            let (actor, critic) =
                (network("test/rollout/actor", &[2, 8, 1]), network("test/rollout/critic", &[3, 8, 1]));
            let broken = [None, Some(9), None, Some(9), None, Some(6), Some(6), None, Some(8)];
            let toy = |broken_step| Box::new(Toy { broken_step, ..Toy::new() }) as Box<dyn Crew>;
            let mut squads = Squad::begun(broken.map(toy).into(), &settings);
            let policy = Policy { actor: &actor, critic: &critic, update: 0 };
            let fault = collect(&mut squads, policy, &settings, Pace::to_the_end(threads)).unwrap_err();
            assert_eq!(
                fault,
                Halt::Fault(NotANumber { environment: 5, episode: 0, step: 5 }),
                "{threads} threads"
            );
        }
    }

    #[test]
    fn a_time_limit_counts_the_value_of_its_last_state_and_a_failure_nothing() {
        ends(false);
    }

    #[test]
    fn a_time_limit_that_is_a_failure_counts_nothing() {
        ends(true);
    }

    fn ends(limits_are_failures: bool) {
        let settings =
            Settings { rollout: 400, environments: 2, privileged: true, limits_are_failures, ..settings() };
        // The exploration is so wide that some episodes fail before their limit of 25 steps.
        let settings = Settings { std: vec![2.5], ..settings };
        // There are so many hidden units that some are active in every state.
        let (actor, critic) =
            (network("test/rollout/actor", &[2, 8, 1]), network("test/rollout/critic", &[3, 64, 1]));
        let mut squads = Squad::begun(Toy::crews(2), &settings);
        let policy = Policy { actor: &actor, critic: &critic, update: 0 };
        collect(&mut squads, policy, &settings, Pace::to_the_end(1)).unwrap();
        let mut counts = [0; 2];
        for (index, lane) in squads.iter().flat_map(|squad| &squad.lanes).enumerate() {
            // Replays the same episodes, step by step, with the recorded actions.
            let mut environment = Toy::new();
            let mut episode = 0;
            environment.begin(0, &format!("{}/train/env/{index}/episode/0", settings.seed));
            for (step, found) in lane.records.ends.iter().enumerate() {
                environment.act(0, &lane.records.actions[step..=step]);
                environment.step();
                let end = environment.outcome(0).end;
                let mut state = [0.0; 3];
                environment.observe_privileged(&mut state);
                let mut value = [0.0];
                critic.forward(&state, &mut value, &mut Scratch::default());
                let expected = match end {
                    None => None,
                    Some(End::TimeOut) if !limits_are_failures => Some(value[0]),
                    Some(_) => Some(0.0),
                };
                assert_eq!(*found, expected, "environment {index}, step {step}");
                if let Some(end) = end {
                    counts[usize::from(end == End::TimeOut)] += 1;
                    assert!(end != End::TimeOut || value[0] != 0.0);
                    episode += 1;
                    environment.begin(0, &format!("{}/train/env/{index}/episode/{episode}", settings.seed));
                }
            }
        }
        assert!(counts.iter().all(|count| *count >= 3), "failures and time limits: {counts:?}");
    }
}
