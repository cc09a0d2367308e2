//! Wall and CPU clocks of a training. Results never depend on them; only metrics carry them.

use std::time::Instant;

use rustix::time::{ClockId, clock_gettime};

/// CPU time of the calling thread in s.
pub fn thread_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Runs the work and returns its result with the CPU time in s that it took on this thread.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = thread_seconds();
    let result = work();
    (result, thread_seconds() - start)
}

/// Sums of wall and CPU time over a training, carried across its interruptions.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    wall_before: f64,
    /// CPU time so far in s, over all threads of the training.
    pub cpu: f64,
}

impl Clock {
    /// A clock that continues from these wall and CPU seconds.
    pub fn resumed(wall: f64, cpu: f64) -> Self {
        Self { start: Instant::now(), wall_before: wall, cpu }
    }

    /// Wall time so far in s.
    pub fn wall(&self) -> f64 {
        self.wall_before + self.start.elapsed().as_secs_f64()
    }
}
