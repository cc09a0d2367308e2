//! Who follows an evaluation while it runs, and what is known of it before.

use std::collections::BTreeMap;

use crate::outcome::{Episode, Trace};

/// An episode as it was measured; the first of an evaluation has its trace.
pub type Measured = (Episode, Option<Trace>);

/// A follower of an evaluation.
pub trait Follower: Sync {
    /// What an earlier run of the same evaluation has measured, by the number of the episode. It is not run again.
    fn known(&self) -> BTreeMap<usize, Measured> {
        BTreeMap::new()
    }

    /// Takes in an episode that has just been measured, when `done` of them are there. Says whether to go on.
    fn takes(&self, index: usize, measured: &Measured, done: usize) -> bool;
}

/// A follower that wants to know how many episodes are there, and nothing else.
pub struct Count<'a>(pub &'a (dyn Fn(usize) -> bool + Sync));

impl Follower for Count<'_> {
    fn takes(&self, _: usize, _: &Measured, done: usize) -> bool {
        (self.0)(done)
    }
}
