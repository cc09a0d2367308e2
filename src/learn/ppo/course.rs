//! Progress of an update's passes: statistics so far, and whether to continue.

use super::super::adam::Rule;
use super::super::backend::Sums;
use super::super::settings::Settings;
use super::{Outcome, Unfinished};

/// The actor's passes so far.
pub(super) struct ActorCourse<'a> {
    settings: &'a Settings,
    outcome: Outcome,
    /// Settings of its steps of Adam.
    pub rule: Rule,
    steps: f64,
    seen: usize,
    /// Sum over the samples of the current pass.
    divergence: f64,
}

/// The critic's passes so far.
pub(super) struct CriticCourse<'a> {
    settings: &'a Settings,
    outcome: Outcome,
    /// Settings of its steps of Adam.
    pub rule: Rule,
    steps: f64,
}

/// The norm of a gradient if it is finite.
pub(super) fn finite(norm: f64) -> Result<f64, Unfinished> {
    if norm.is_finite() { Ok(norm) } else { Err(Unfinished::Diverged) }
}

fn rule(settings: &Settings, rates: [f64; 2]) -> Rule {
    Rule { rates, epsilon: settings.adam_epsilon, bound: settings.max_grad_norm }
}

impl<'a> ActorCourse<'a> {
    /// The state before the first pass, with this step size.
    pub fn new(settings: &'a Settings, rate: f64) -> Self {
        let outcome = Outcome { rate, ..Outcome::default() };
        Self { settings, outcome, rule: rule(settings, [rate; 2]), steps: 0.0, seen: 0, divergence: 0.0 }
    }

    /// Whether a minibatch shows that the policy has moved too far from the old one, so that no further step
    /// is taken.
    pub fn runs_away(&mut self, sums: &Sums, rows: usize) -> bool {
        let moved = sums.divergence / rows as f64;
        let runs_away = self.settings.rate.overrun(moved);
        if runs_away {
            self.outcome.epochs += 1;
            self.outcome.divergence = moved;
        }
        runs_away
    }

    /// Records a step over a minibatch of `rows` samples, with a gradient of this norm.
    pub fn stepped(&mut self, sums: &Sums, rows: usize, norm: f64) {
        self.seen += rows;
        self.outcome.actor_norm += norm;
        self.outcome.clip_fraction += sums.clipped;
        self.divergence += sums.divergence;
        self.steps += 1.0;
    }

    /// Ends a pass; returns whether the policy has moved far enough.
    pub fn ends_a_pass(&mut self) -> bool {
        self.outcome.epochs += 1;
        self.outcome.divergence = std::mem::take(&mut self.divergence) / self.settings.batch() as f64;
        self.settings.rate.exhausted(self.outcome.divergence)
    }

    /// The outcome of the passes.
    pub fn outcome(mut self) -> Outcome {
        self.outcome.actor_norm /= f64::max(self.steps, 1.0);
        self.outcome.clip_fraction /= self.seen.max(1) as f64;
        self.outcome
    }
}

impl<'a> CriticCourse<'a> {
    /// The state before the first pass, while the actor has this step size.
    pub fn new(settings: &'a Settings, actor_rate: f64) -> Self {
        let hidden = if settings.critic_hidden_follows { actor_rate } else { settings.value_rate };
        let rule = rule(settings, [hidden, settings.value_rate]);
        Self { settings, outcome: Outcome::default(), rule, steps: 0.0 }
    }

    /// Records a step with a gradient of this norm.
    pub fn stepped(&mut self, sums: &Sums, norm: f64) {
        self.outcome.value_loss += sums.error;
        self.outcome.critic_norm += norm;
        self.steps += 1.0;
    }

    /// The outcome of the passes.
    pub fn outcome(mut self) -> Outcome {
        self.outcome.critic_norm /= self.steps;
        self.outcome.value_loss /= (self.settings.epochs * self.settings.batch()) as f64;
        self.outcome
    }
}
