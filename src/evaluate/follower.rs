//! Observers of a running evaluation, which may also know episodes of an earlier run.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::outcome::{Episode, Trace};

/// A measured episode; the first of an evaluation has its trace.
pub type Measured = (Episode, Option<Trace>);

/// A follower of an evaluation.
pub trait Follower: Sync {
    /// The episodes that an earlier run of the same evaluation has measured, by number. They are not
    /// repeated.
    fn known(&self) -> BTreeMap<usize, Measured> {
        BTreeMap::new()
    }

    /// Receives an episode when it is measured and `done` episodes are finished. Returns whether to continue.
    fn takes(&self, index: usize, measured: &Measured, done: usize) -> bool;

    /// Whether to interrupt the evaluation during its episodes; the next run repeats the unfinished ones.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// The wall time after which an episode counts as long.
    fn patience(&self) -> Duration {
        Duration::from_secs(30)
    }

    /// Called once, for the first long episode: its number and progress.
    fn lasts(&self, _index: usize, _course: Lasting) {}
}

/// Progress of an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lasting {
    /// Wall time so far in s.
    pub wall_s: f64,
    /// Simulated time so far in s.
    pub simulated_s: f64,
    /// Largest simulated time in s.
    pub limit_s: f64,
}

impl Lasting {
    /// Describes the wait.
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

/// Advice for a long episode.
pub const LONG_EPISODE: &str = "Ctrl-C ends it; `time_limit` makes the episodes of an evaluation shorter";

/// A follower that only counts finished episodes.
pub struct Count<'a>(pub &'a (dyn Fn(usize) -> bool + Sync));

impl Follower for Count<'_> {
    fn takes(&self, _: usize, _: &Measured, done: usize) -> bool {
        (self.0)(done)
    }
}
