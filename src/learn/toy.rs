//! A toy environment with a known optimum, and settings that learn it.

use super::settings::{Backend, Device, Normalisation, Rate, Shape};
use super::*;
use crate::env::{Crew, End, Output, Sizes, Stance, Step, View};
use crate::stream::Stream;

/// A drifting number; the best action is `0.5 x - 0.3` everywhere and earns a reward of 1.
pub struct Toy {
    pub(super) stream: Stream,
    pub(super) x: f64,
    pub(super) steps: u64,
    pub(super) terms: Vec<String>,
    pub(super) values: Vec<f64>,
    pub(super) causes: Vec<String>,
    /// The declared range of its one action.
    pub outputs: Vec<Output>,
    /// The declared ranges of its reward terms.
    pub ranges: [[f64; 2]; 2],
    /// A step in which the reward is NaN.
    pub broken_step: Option<u64>,
    /// A value of the number above which the simulation diverges.
    pub limit: f64,
    /// The action of the next step.
    pub(super) action: f64,
    /// The outcome of the last step.
    pub(super) outcome: Step,
}

impl Toy {
    pub fn new() -> Self {
        let terms = vec!["accuracy".to_owned(), "bonus".to_owned()];
        let stream = Stream::new("");
        Self {
            stream,
            x: 0.0,
            steps: 0,
            terms,
            values: vec![0.0; 2],
            causes: vec!["too_far".to_owned()],
            outputs: vec![Output { name: "pull".to_owned(), range: [-2.0, 2.0], optional: false }],
            ranges: [[f64::NEG_INFINITY, 1.0], [0.0, 0.0]],
            broken_step: None,
            limit: f64::INFINITY,
            action: 0.0,
            outcome: Step { reward: 0.0, end: None },
        }
    }

    /// `count` toys, each as its own crew.
    pub fn crews(count: usize) -> Vec<Box<dyn Crew>> {
        (0..count).map(|_| Box::new(Self::new()) as Box<dyn Crew>).collect()
    }
}

impl View for Toy {
    fn sizes(&self) -> Sizes {
        Sizes { observation: 2, privileged: 3, action: 1 }
    }

    fn observe(&self, observation: &mut [f32]) {
        observation.copy_from_slice(&[self.x as f32, 1.0]);
    }

    fn observe_truths(&self, truths: &mut [f32]) {
        truths.copy_from_slice(&[self.steps as f32 / 25.0]);
    }

    fn terms(&self) -> &[String] {
        &self.terms
    }

    fn term_values(&self) -> &[f64] {
        &self.values
    }

    fn term_ranges(&self) -> &[[f64; 2]] {
        &self.ranges
    }

    fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    fn stance(&self) -> Option<Stance> {
        None
    }

    fn causes(&self) -> &[String] {
        &self.causes
    }
}

impl Crew for Toy {
    fn count(&self) -> usize {
        1
    }

    fn view(&self, _: usize) -> &dyn View {
        self
    }

    fn begin(&mut self, _: usize, stream: &str) {
        self.stream = Stream::new(stream);
        self.x = self.stream.normal();
        self.steps = 0;
    }

    fn act(&mut self, _: usize, action: &[f32]) {
        self.action = f64::from(action[0]);
    }

    fn step(&mut self) {
        let miss = self.action - (0.5 * self.x - 0.3);
        self.x = 0.9 * self.x + 0.1 * self.action + 0.3 * self.stream.normal();
        self.steps += 1;
        self.values = vec![1.0 - miss * miss, 0.0];
        let end = match self.steps {
            _ if self.x > self.limit => Some(End::Exploded),
            _ if self.x.abs() > 2.2 => Some(End::Terminated(0)),
            25 => Some(End::TimeOut),
            _ => None,
        };
        let reward = if self.broken_step == Some(self.steps) { f64::NAN } else { self.values[0] };
        self.outcome = Step { reward, end };
    }

    fn outcome(&self, _: usize) -> Step {
        self.outcome
    }
}

/// A training of eight updates.
pub fn settings() -> Settings {
    let shape = Shape { hidden: vec![24, 24], activation: Activation::Relu };
    Settings {
        samples: 2400,
        stop_at: None,
        rollout: 300,
        environments: 5,
        minibatch: 64,
        epochs: 3,
        rate: Rate::Steered { target: 0.02, start: 3e-4 },
        gamma: 0.9,
        lambda: 0.95,
        clip: 0.2,
        advantages: Normalisation::Minibatch,
        reward_scale: 0.1,
        warm_up: 1,
        policy: shape.clone(),
        value: shape,
        value_rate: 1e-3,
        critic_hidden_follows: false,
        value_coefficient: 0.5,
        privileged: true,
        max_grad_norm: 0.5,
        norm_of_both: false,
        adam_epsilon: 1e-5,
        seed: 1,
        checkpoint_every: 2,
        std: vec![0.1],
        std_decay: None,
        limits_are_failures: false,
        step: 0.01,
        round: Round::First,
        backend: Backend::Native,
        device: Device::Cpu,
    }
}
