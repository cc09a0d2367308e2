//! How an update is worked on: on how many threads, and whether to go on at all.

/// The threads of a rollout and of the learning from it, and what ends both early. Neither changes a number:
/// what is ended early is discarded.
#[derive(Clone, Copy)]
pub struct Pace<'a> {
    /// Number of threads.
    pub threads: usize,
    /// Asked between control steps and between minibatches, on every thread: true ends the update.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Pace<'static> {
    /// Nothing ends it early.
    pub fn to_the_end(threads: usize) -> Self {
        Self { threads, stop: &|| false }
    }
}
