//! The interface of environments to learners and evaluations: plain numbers, no engine types.

use serde::{Deserialize, Serialize};

/// Lengths of the vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sizes {
    /// Inputs of the actor.
    pub observation: usize,
    /// Inputs of the critic; at least `observation`, which comes first.
    pub privileged: usize,
    /// Outputs of the actor.
    pub action: usize,
}

/// One output of the actor.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The name of the joint that it moves, or `phase`.
    pub name: String,
    /// The effective range: values beyond it are clipped.
    pub range: [f64; 2],
    /// Whether a good policy may keep it constant, for example the phase's speed.
    pub optional: bool,
}

/// Foot contacts after a control step, left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stance {
    /// Whether each foot carries load.
    pub feet: [bool; 2],
    /// Whether the reference motion schedules its contact.
    pub reference: [bool; 2],
}

/// Why an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// By the termination term with this index in [`View::causes`].
    Terminated(usize),
    /// At the episode's time limit: not a failure, the value of the last state is bootstrapped.
    TimeOut,
    /// The simulation diverged (NaN or infinity, R0001).
    Exploded,
}

/// The outcome of one control step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Sum of the weighted reward terms.
    pub reward: f64,
    /// Why the episode ended with this step, if it did. The next call must then be [`Crew::begin`].
    pub end: Option<End>,
}

/// The readable state of an environment between two control steps.
pub trait View: Send {
    /// Lengths of the vectors.
    fn sizes(&self) -> Sizes;

    /// Writes the actor's inputs (normalised).
    fn observe(&self, observation: &mut [f32]);

    /// Writes the critic's additional inputs (normalised): ground truth of the simulator.
    fn observe_truths(&self, truths: &mut [f32]);

    /// Writes the critic's inputs (normalised), the actor's first.
    fn observe_privileged(&self, observation: &mut [f32]) {
        let (own, truths) = observation.split_at_mut(self.sizes().observation);
        self.observe(own);
        self.observe_truths(truths);
    }

    /// Names of the reward terms.
    fn terms(&self) -> &[String];

    /// Weighted value of each reward term in the last step.
    fn term_values(&self) -> &[f64];

    /// Range of each weighted reward term; infinite where it is unbounded.
    fn term_ranges(&self) -> &[[f64; 2]];

    /// The outputs of the actor, in order.
    fn outputs(&self) -> &[Output];

    /// The foot contacts after the last step; `None` for robots without two feet.
    fn stance(&self) -> Option<Stance>;

    /// Names of the terminations.
    fn causes(&self) -> &[String];
}

/// Environments that step together because their engine advances several worlds at once, or a single one.
/// Deterministic: the same stream name and the same actions give the same numbers, bit for bit, whatever
/// happened before `begin` and whatever the other environments do.
pub trait Crew: Send {
    /// Number of environments, at least one.
    fn count(&self) -> usize;

    /// The readable state of one of them.
    fn view(&self, index: usize) -> &dyn View;

    /// Starts an episode in one of them; all its randomness comes from the stream with this name
    /// (`1/train/env/17/episode/42`).
    fn begin(&mut self, index: usize, stream: &str);

    /// Sets the actor's (unclipped) outputs for the next control step of one of them.
    fn act(&mut self, index: usize, action: &[f32]);

    /// Advances by one control step each environment whose outputs were set since the last call; the others
    /// do not change.
    fn step(&mut self);

    /// The outcome of the last control step of one of them.
    fn outcome(&self, index: usize) -> Step;
}
