//! Execution of an update: the number of threads, and when to stop early.

/// The threads of a rollout and of the learning from it, and the condition that ends both early. Neither
/// changes results: an update that ends early is discarded.
#[derive(Clone, Copy)]
pub struct Pace<'a> {
    /// Number of threads.
    pub threads: usize,
    /// Called between control steps and between minibatches, on every thread; true ends the update.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Pace<'static> {
    /// A pace that never ends early.
    pub fn to_the_end(threads: usize) -> Self {
        Self { threads, stop: &|| false }
    }
}
