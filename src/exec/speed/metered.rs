//! An engine whose every call is timed: how a rollout's CPU time divides into physics and the rest.
//!
//! Times are CPU times of the calling thread, which other programs on the machine do not lengthen. Reading that clock
//! costs some tenths of a microsecond; the cost is measured once and taken off.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use crate::learn::clock::thread_seconds;
use crate::robot::Robot;
use crate::sim::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World};

/// What the calls of an engine have taken, over all its worlds and threads.
#[derive(Debug, Default)]
pub struct Spent {
    build: AtomicU64,
    step: AtomicU64,
    look: AtomicU64,
    calls: AtomicU64,
}

/// CPU seconds by kind of call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds {
    /// Building worlds.
    pub build: f64,
    /// Physics steps, torques handed over included.
    pub step: f64,
    /// Reading states and contacts, asking whether they are sane.
    pub look: f64,
    /// What reading the clock cost beside that.
    pub clock: f64,
}

impl Spent {
    /// The times so far, without the clock's own.
    pub fn seconds(&self) -> Seconds {
        let nanoseconds = |counter: &AtomicU64| counter.load(Ordering::Relaxed) as f64 * 1e-9;
        let clock = 2.0 * self.calls.load(Ordering::Relaxed) as f64 * clock_cost();
        Seconds { build: nanoseconds(&self.build), step: nanoseconds(&self.step), look: nanoseconds(&self.look), clock }
    }

    fn timed<T>(&self, counter: &AtomicU64, call: impl FnOnce() -> T) -> T {
        let start = thread_seconds();
        let result = call();
        let taken = (thread_seconds() - start - clock_cost()).max(0.0);
        counter.fetch_add((taken * 1e9).round() as u64, Ordering::Relaxed);
        self.calls.fetch_add(1, Ordering::Relaxed);
        result
    }
}

/// CPU seconds that one reading of the clock costs.
fn clock_cost() -> f64 {
    const READINGS: usize = 20_000;
    static COST: OnceLock<f64> = OnceLock::new();
    *COST.get_or_init(|| {
        let start = thread_seconds();
        (0..READINGS).for_each(|_| _ = std::hint::black_box(thread_seconds()));
        (thread_seconds() - start) / READINGS as f64
    })
}

/// An engine under the clock.
pub struct Metered {
    inner: Arc<dyn Engine>,
    spent: Arc<Spent>,
}

impl Metered {
    /// Puts an engine under the clock; the times gather in what comes with it.
    pub fn new(inner: Arc<dyn Engine>) -> (Self, Arc<Spent>) {
        let spent = Arc::new(Spent::default());
        (Self { inner, spent: spent.clone() }, spent)
    }
}

impl Engine for Metered {
    fn name(&self) -> &'static str {
        self.inner.name()
    }

    fn identity(&self) -> String {
        self.inner.identity()
    }

    fn build(
        &self,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<Box<dyn World>, EngineError> {
        let inner = self.spent.timed(&self.spent.build, || self.inner.build(robot, terrain, settings, state))?;
        Ok(Box::new(MeteredWorld { inner, spent: self.spent.clone() }))
    }
}

struct MeteredWorld {
    inner: Box<dyn World>,
    spent: Arc<Spent>,
}

impl World for MeteredWorld {
    fn step(&mut self, torque: &[f64]) {
        self.spent.timed(&self.spent.step, || self.inner.step(torque));
    }

    fn apply(&mut self, torque: &[f64]) {
        self.spent.timed(&self.spent.step, || self.inner.apply(torque));
    }

    fn advance(&mut self) {
        self.spent.timed(&self.spent.step, || self.inner.advance());
    }

    fn read(&self, state: &mut State) {
        self.spent.timed(&self.spent.look, || self.inner.read(state));
    }

    fn contacts(&self) -> Contacts {
        self.spent.timed(&self.spent.look, || self.inner.contacts())
    }

    fn push(&mut self, force: [f64; 3]) {
        self.inner.push(force);
    }

    fn is_sane(&self) -> bool {
        self.spent.timed(&self.spent.look, || self.inner.is_sane())
    }
}
