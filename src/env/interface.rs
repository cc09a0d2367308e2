//! What a learner or an evaluation sees of an environment: plain numbers, no engine types.

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
    /// What it moves: a joint's name, or `phase`.
    pub name: String,
    /// The numbers that make a difference: what is beyond is clipped.
    pub range: [f64; 2],
    /// Whether a good policy may leave it where it is, as it may the advance of the phase.
    pub optional: bool,
}

/// The feet after a control step, left and right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stance {
    /// Whether each carries something.
    pub feet: [bool; 2],
    /// Whether the reference motion wants it to.
    pub reference: [bool; 2],
}

/// Why an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// By the termination term with this index in [`View::causes`].
    Terminated(usize),
    /// At the episode's time limit: not a failure, the value of the last state is bootstrapped.
    TimeOut,
    /// The physics left the realm of numbers (R0001).
    Exploded,
}

/// The outcome of one control step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The sum of the weighted reward terms.
    pub reward: f64,
    /// Whether the episode ended with this step. The next call must be [`Crew::begin`].
    pub end: Option<End>,
}

/// What can be read of an environment between two control steps.
pub trait View: Send {
    /// Lengths of the vectors.
    fn sizes(&self) -> Sizes;

    /// Writes the actor's inputs (normalised).
    fn observe(&self, observation: &mut [f32]);

    /// Writes what the critic sees beyond the actor (normalised): truths of the simulator.
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

    /// The least and the greatest weighted value that each reward term can have; infinite where there is no
    /// bound.
    fn term_ranges(&self) -> &[[f64; 2]];

    /// The outputs of the actor, in order.
    fn outputs(&self) -> &[Output];

    /// The feet after the last step; `None` for what does not stand on two.
    fn stance(&self) -> Option<Stance>;

    /// Names of the terminations.
    fn causes(&self) -> &[String];
}

/// Environments that step together, because their engine advances several worlds at once, or one alone.
/// Deterministic: the same stream name and the same actions give the same numbers, bit for bit, whatever
/// happened before `begin` and whichever other environments step along.
pub trait Crew: Send {
    /// Number of environments, at least one.
    fn count(&self) -> usize;

    /// What can be read of one of them.
    fn view(&self, index: usize) -> &dyn View;

    /// Starts an episode in one of them; all its randomness comes from the stream of this name
    /// (`1/train/env/17/episode/42`).
    fn begin(&mut self, index: usize, stream: &str);

    /// Hands one of them the actor's (unclipped) outputs for its next control step.
    fn act(&mut self, index: usize, action: &[f32]);

    /// Advances one control step each environment that was handed outputs since the last call; the others
    /// wait.
    fn step(&mut self);

    /// The outcome of the last control step of one of them.
    fn outcome(&self, index: usize) -> Step;
}
