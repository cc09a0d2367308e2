//! An engine that times all of its calls: how a rollout's time divides into physics and the rest.
//!
//! Uses the monotonic clock, which takes some tens of nanoseconds to read, without a system call. The
//! thread's CPU clock takes ten times as long, and its system calls would disturb the caches at the expense
//! of the rest. Other programs slow down all parts alike, so the shares stay valid. The cost of timing is
//! measured once and subtracted.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crate::robot::Robot;
use crate::sim::{Contacts, Engine, EngineError, EngineSettings, State, Terrain, World, Worlds};

/// Nanoseconds spent in calls of an engine, over all its worlds and threads.
#[derive(Debug, Default)]
pub struct Spent {
    build: AtomicU64,
    step: AtomicU64,
    look: AtomicU64,
    calls: AtomicU64,
}

/// Time by kind of call, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seconds {
    /// Building worlds.
    pub build: f64,
    /// Physics steps, including setting the torques.
    pub step: f64,
    /// Reading and validating states and contacts.
    pub look: f64,
    /// The cost of timing, which is not part of the other fields.
    pub timing: f64,
}

/// Nanoseconds that the timing of one call costs.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// The part between the two clock readings.
    inside: u64,
    /// All of it.
    whole: f64,
}

impl Spent {
    /// The times so far, without the cost of timing.
    pub fn seconds(&self) -> Seconds {
        let seconds = |counter: &AtomicU64| counter.load(Ordering::Relaxed) as f64 * 1e-9;
        let timing = self.calls.load(Ordering::Relaxed) as f64 * Cost::known().whole * 1e-9;
        Seconds { build: seconds(&self.build), step: seconds(&self.step), look: seconds(&self.look), timing }
    }

    fn timed<T>(&self, counter: &AtomicU64, call: impl FnOnce() -> T) -> T {
        self.timed_but(Cost::known().inside, counter, call)
    }

    fn timed_but<T>(&self, inside: u64, counter: &AtomicU64, call: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = call();
        let taken = start.elapsed().as_nanos() as u64;
        counter.fetch_add(taken.saturating_sub(inside), Ordering::Relaxed);
        self.calls.fetch_add(1, Ordering::Relaxed);
        result
    }
}

impl Cost {
    /// Measured once, on empty calls, as the minimum over several stretches.
    fn known() -> Self {
        const STRETCHES: usize = 9;
        const CALLS: u64 = 5_000;
        static COST: OnceLock<Cost> = OnceLock::new();
        *COST.get_or_init(|| {
            let stretch = |_| {
                let (nothing, start) = (Spent::default(), Instant::now());
                (0..CALLS).for_each(|_| nothing.timed_but(0, &nothing.step, || std::hint::black_box(())));
                let whole = start.elapsed().as_nanos() as f64 / CALLS as f64;
                Self { inside: nothing.step.into_inner() / CALLS, whole }
            };
            (0..STRETCHES)
                .map(stretch)
                .min_by(|a, b| a.whole.total_cmp(&b.whole))
                .expect("there are stretches")
        })
    }
}

/// An engine whose calls are timed.
pub struct Metered {
    inner: Arc<dyn Engine>,
    spent: Arc<Spent>,
}

impl Metered {
    /// Wraps an engine; the times accumulate in the second value.
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
        let inner =
            self.spent.timed(&self.spent.build, || self.inner.build(robot, terrain, settings, state))?;
        Ok(Box::new(MeteredWorld { inner, spent: self.spent.clone() }))
    }

    fn width(&self) -> usize {
        self.inner.width()
    }

    fn worlds(&self, count: usize) -> Option<Box<dyn Worlds>> {
        let inner = self.inner.worlds(count)?;
        Some(Box::new(MeteredWorlds { inner, spent: self.spent.clone() }))
    }
}

struct MeteredWorlds {
    inner: Box<dyn Worlds>,
    spent: Arc<Spent>,
}

impl Worlds for MeteredWorlds {
    fn place(
        &mut self,
        slot: usize,
        robot: &Robot,
        terrain: &Terrain,
        settings: &EngineSettings,
        state: &State,
    ) -> Result<(), EngineError> {
        self.spent.timed(&self.spent.build, || self.inner.place(slot, robot, terrain, settings, state))
    }

    fn apply(&mut self, slot: usize, torque: &[f64]) {
        self.spent.timed(&self.spent.step, || self.inner.apply(slot, torque));
    }

    fn advance(&mut self) {
        self.spent.timed(&self.spent.step, || self.inner.advance());
    }

    fn read(&self, slot: usize, state: &mut State) {
        self.spent.timed(&self.spent.look, || self.inner.read(slot, state));
    }

    fn contacts(&self, slot: usize) -> Contacts {
        self.spent.timed(&self.spent.look, || self.inner.contacts(slot))
    }

    fn push(&mut self, slot: usize, force: [f64; 3]) {
        self.inner.push(slot, force);
    }

    fn is_sane(&self, slot: usize) -> bool {
        self.spent.timed(&self.spent.look, || self.inner.is_sane(slot))
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
