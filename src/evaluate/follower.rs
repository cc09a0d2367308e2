//! Who follows an evaluation while it runs, and what is known of it before.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::outcome::{Episode, Trace};

/// An episode as it was measured; the first of an evaluation has its trace.
pub type Measured = (Episode, Option<Trace>);

/// A follower of an evaluation.
pub trait Follower: Sync {
    /// What an earlier run of the same evaluation has measured, by the number of the episode. It is not run
    /// again.
    fn known(&self) -> BTreeMap<usize, Measured> {
        BTreeMap::new()
    }

    /// Takes in an episode that has just been measured, when `done` of them are there. Says whether to go on.
    fn takes(&self, index: usize, measured: &Measured, done: usize) -> bool;

    /// Whether the evaluation is to end in the middle of its episodes; they are measured anew by the next
    /// run.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// The wall time after which an episode is called long.
    fn patience(&self) -> Duration {
        Duration::from_secs(30)
    }

    /// Hears of the first long episode, once: its number and how far it is.
    fn lasts(&self, _index: usize, _course: Lasting) {}
}

/// How far an episode is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasting {
    /// Wall time so far in s.
    pub wall_s: f64,
    /// Simulated time so far in s.
    pub simulated_s: f64,
    /// Simulated time at most in s.
    pub limit_s: f64,
}

impl Lasting {
    /// What is waited for, in words.
    pub fn sentence(&self, index: usize) -> String {
        let Self { wall_s, simulated_s, limit_s } = self;
        format!(
            "waiting for episode {}, which has taken {wall_s:.0} s so far: {simulated_s:.1} s of at most \
             {limit_s} s are \
             simulated",
            index + 1
        )
    }
}

/// What to do about a long episode.
pub const LONG_EPISODE: &str = "Ctrl-C ends it; `time_limit` makes the episodes of an evaluation shorter";

/// A follower that wants to know how many episodes are there, and nothing else.
pub struct Count<'a>(pub &'a (dyn Fn(usize) -> bool + Sync));

impl Follower for Count<'_> {
    fn takes(&self, _: usize, _: &Measured, done: usize) -> bool {
        (self.0)(done)
    }
}
