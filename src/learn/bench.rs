//! Benchmarks of the parts of a training: an update, the policy's inference, and rollouts.

use std::time::Instant;

use super::backend::native::Native;
use super::clock::timed;
use super::error::LearnError;
use super::inference::{Inference, Scratch};
use super::lane::{NotANumber, Records, Squad};
use super::network::{Activation, Network};
use super::pace::Pace;
use super::ppo::{Improve, Learner, Place, Unfinished, learner};
use super::rollout::{Halt, Policy, Spent, collect, together};
use super::settings::{Backend, Device, Normalisation, Rate, Round, Settings, Shape};
use crate::env::{Crew, Sizes};
use crate::stream::Stream;

/// CPU microseconds per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnerSpeed {
    /// Samples per gradient step.
    pub minibatch: usize,
    /// Passes over the rollout.
    pub epochs: usize,
    /// An update of both networks, all passes.
    pub update_us_per_sample: f64,
    /// An inference of the actor in a batch of 32 environments.
    pub inference_us_per_sample: f64,
}

/// Measures one update of 16 384 samples with the paper's networks on synthetic data.
pub fn learner_us_per_sample(minibatch: usize, epochs: usize) -> LearnerSpeed {
    let sizes = Sizes { observation: 30, privileged: 42, action: 13 };
    let settings = settings(minibatch, epochs, sizes);
    let network = |name: &str, inputs, outputs| {
        let mut stream = Stream::new(&format!("bench/learner/{name}"));
        Network::orthogonal(&settings.policy.widths(inputs, outputs), Activation::Relu, &mut stream)
    };
    let actor = network("actor", sizes.observation, sizes.action);
    let critic = network("critic", sizes.privileged, 1);
    let records: Vec<Records> =
        (0..settings.environments).map(|index| made_up(index, sizes, &settings)).collect();
    let records: Vec<&Records> = records.iter().collect();
    let mut learner = Learner::new(Native, [&actor, &critic], &settings);
    let mut update =
        |update| learner.improve(&records, &settings, Place { update, share: 0.0 }, Pace::to_the_end(1));
    // The first update allocates the buffers, so it is not measured.
    let outcome = update(0).and_then(|_| update(1));
    let inference = inference(&Inference::new(&actor), 32);
    LearnerSpeed {
        minibatch,
        epochs,
        update_us_per_sample: outcome
            .map_or(f64::NAN, |outcome| 1e6 * outcome.cpu.iter().sum::<f64>() / settings.batch() as f64),
        inference_us_per_sample: 1e6 * inference,
    }
}

/// CPU time in s of an inference per row, in batches of `rows` rows.
fn inference(actor: &Inference, rows: usize) -> f64 {
    const BATCHES: usize = 300;
    let (inputs, mut outputs) = (vec![0.1; rows * actor.inputs()], vec![0.0; rows * actor.outputs()]);
    let mut scratch = Scratch::default();
    let ((), cpu) = timed(|| (0..BATCHES).for_each(|_| actor.forward(&inputs, &mut outputs, &mut scratch)));
    cpu / (rows * BATCHES) as f64
}

/// Environments that are stepped through rollouts under freshly drawn networks, and a learner whose networks
/// are never used to act, so all rollouts are alike.
pub struct Rollouts<'a> {
    squads: Vec<Squad>,
    networks: [Inference; 2],
    learner: Box<dyn Improve>,
    settings: &'a Settings,
    update: u64,
}

/// Cost of a rollout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collected {
    /// Control steps of all environments.
    pub samples: usize,
    /// CPU time in s.
    pub cpu: Spent,
    /// Wall time in s.
    pub wall: f64,
}

impl<'a> Rollouts<'a> {
    /// Environments at the beginning of their first episodes; at least one.
    pub fn new(crews: Vec<Box<dyn Crew>>, settings: &'a Settings) -> Result<Self, LearnError> {
        let sizes = crews[0].view(0).sizes();
        let networks =
            [("actor", sizes.observation, sizes.action), ("critic", state_width(sizes, settings), 1)];
        let networks = networks.map(|(name, inputs, outputs)| {
            let mut stream = Stream::new(&format!("bench/rollout/{name}"));
            let widths = settings.policy.widths(inputs, outputs);
            Network::orthogonal(&widths, settings.policy.activation, &mut stream)
        });
        let squads = Squad::begun(crews, settings);
        let learner = learner(networks.each_ref(), settings)?;
        Ok(Self { squads, networks: networks.each_ref().map(Inference::new), learner, settings, update: 0 })
    }

    /// The next rollout on this many threads.
    pub fn collect(&mut self, threads: usize) -> Result<Collected, NotANumber> {
        let [actor, critic] = &self.networks;
        let policy = Policy { actor, critic, update: self.update };
        let start = Instant::now();
        let cpu = collect(&mut self.squads, policy, self.settings, Pace::to_the_end(threads));
        let cpu = cpu.map_err(|halt| match halt {
            Halt::Fault(fault) => fault,
            Halt::Interrupted => unreachable!("a measurement is not asked to stop"),
        })?;
        self.update += 1;
        Ok(Collected { samples: self.settings.batch(), cpu, wall: start.elapsed().as_secs_f64() })
    }

    /// CPU time in s of the actor's inference per row, in the batch size of a rollout.
    pub fn inference(&self) -> f64 {
        inference(&self.networks[0], together(&self.squads, 1))
    }

    /// Learns from the last rollout and returns the CPU time in s of actor and critic.
    pub fn improve(&mut self, threads: usize) -> Result<[f64; 2], Unfinished> {
        let records: Vec<&Records> =
            self.squads.iter().flat_map(|squad| &squad.lanes).map(|lane| &lane.records).collect();
        let place = Place { update: self.update, share: 0.0 };
        Ok(self.learner.improve(&records, self.settings, place, Pace::to_the_end(threads))?.cpu)
    }
}

fn state_width(sizes: Sizes, settings: &Settings) -> usize {
    if settings.privileged { sizes.privileged } else { sizes.observation }
}

fn settings(minibatch: usize, epochs: usize, sizes: Sizes) -> Settings {
    let shape = Shape { hidden: vec![256, 256], activation: Activation::Relu };
    Settings {
        samples: 2 * 16384,
        stop_at: None,
        rollout: 16384,
        environments: 64,
        minibatch,
        epochs,
        rate: Rate::Constant(5e-5),
        gamma: 0.99,
        lambda: 0.95,
        clip: 0.2,
        advantages: Normalisation::Minibatch,
        reward_scale: 1.0,
        warm_up: 0,
        policy: shape.clone(),
        value: shape,
        value_rate: 5e-4,
        critic_hidden_follows: false,
        value_coefficient: 0.5,
        privileged: true,
        max_grad_norm: 0.5,
        norm_of_both: false,
        adam_epsilon: 1e-5,
        seed: 1,
        checkpoint_every: 1,
        std: vec![0.1; sizes.action],
        std_decay: None,
        limits_are_failures: false,
        step: 0.004,
        round: Round::First,
        backend: Backend::Native,
        device: Device::Cpu,
    }
}

/// Records of normally distributed numbers.
fn made_up(index: usize, sizes: Sizes, settings: &Settings) -> Records {
    let mut stream = Stream::new(&format!("bench/learner/records/{index}"));
    let mut numbers = |count: usize, scale: f64| -> Vec<f32> {
        (0..count).map(|_| (scale * stream.normal()) as f32).collect()
    };
    let steps = settings.horizon();
    Records {
        observations: numbers(steps * sizes.observation, 1.0),
        states: numbers((steps + 1) * sizes.privileged, 1.0),
        actions: numbers(steps * sizes.action, 0.1),
        means: vec![0.0; steps * sizes.action],
        advantages: numbers(steps, 1.0),
        targets: numbers(steps, 1.0),
        ..Records::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measure_is_a_positive_time() {
        let speed = learner_us_per_sample(1024, 1);
        assert!(speed.update_us_per_sample > 0.0 && speed.inference_us_per_sample > 0.0, "{speed:?}");
    }
}
