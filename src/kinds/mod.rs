//! The registries: one folder per registry, one file per kind.
//!
//! A kind is a descriptor ([`crate::spec::Kind`]) together with its behaviour. Its only access to the world
//! is [`Signals`]: plain numbers with documented units, order and frame.

pub mod action;
pub mod deploy;
pub mod evaluate;
pub mod fine_tune;
pub mod initial;
pub mod keys;
pub mod learn;
pub mod metric;
pub mod motion;
pub mod observe;
pub mod physics;
pub mod pretrain;
pub mod randomize;
pub mod reference;
pub mod reward;
pub mod signals;
pub mod statistic;
pub mod task;
pub mod terminate;
pub mod terrain;
pub mod vocabulary;

pub use signals::Signals;

use crate::spec::typed::Declared;
use crate::spec::{Kind, Section};

/// A registry entry of kinds with a common behaviour: rewards, terminations, randomizations.
pub struct Entry<Role: ?Sized + 'static> {
    /// Its descriptor.
    pub kind: &'static Kind,
    /// Builds its behaviour from the decoded table.
    pub build: fn(Section) -> Box<Role>,
}

/// A reward term: its unweighted value in `[0, 1]` for one control step.
pub trait Reward: Send + Sync {
    /// The unweighted value.
    fn value(&self, signals: &Signals) -> f64;
}

/// A termination: whether the episode ends here. `memory` holds two numbers (one per foot) as state between
/// steps; they are zero at the start of an episode.
pub trait Termination: Send + Sync {
    /// Whether the episode ends.
    fn ends(&self, signals: &Signals, memory: &mut [f64; 2]) -> bool;
}

/// An entry of the reward registry.
pub type RewardKind = Entry<dyn Reward>;
/// An entry of the termination registry.
pub type TerminationKind = Entry<dyn Termination>;

impl RewardKind {
    const fn of<Term: Declared + Reward + 'static>() -> Self {
        Self { kind: Term::KIND, build: |section| Box::new(section.read::<Term>()) }
    }
}

impl TerminationKind {
    const fn of<Term: Declared + Termination + 'static>() -> Self {
        Self { kind: Term::KIND, build: |section| Box::new(section.read::<Term>()) }
    }
}
