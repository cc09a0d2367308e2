//! The rate of a stage and the time it has left, from what this process has done alone: what a checkpoint
//! already had took no time here.

use std::time::Instant;

/// The progress of a stage in this process.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// What was done at the first report, and its time.
    first: (u64, Instant),
    /// The same at the latest report.
    last: (u64, Instant),
}

impl Pace {
    /// The pace of a stage that reports this amount first, for a resumed stage the amount of its checkpoint.
    pub fn new(done: u64, now: Instant) -> Self {
        Self { first: (done, now), last: (done, now) }
    }

    /// Takes in a report.
    pub fn advance(&mut self, done: u64, now: Instant) {
        self.last = (done, now);
    }

    /// Amount per second since the first report; `None` while nothing more is done.
    pub fn rate(&self) -> Option<f64> {
        let done = self.last.0.checked_sub(self.first.0).filter(|done| *done > 0)?;
        let seconds = self.last.1.duration_since(self.first.1).as_secs_f64();
        (seconds > 0.0).then(|| done as f64 / seconds)
    }

    /// Seconds left at the latest report; `None` while the rate is unknown.
    pub fn left(&self, total: u64) -> Option<f64> {
        Some(total.saturating_sub(self.last.0) as f64 / self.rate()?)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_resumed_stage_counts_only_what_it_did_since() {
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        // 60 M of 80 M samples are in the checkpoint; 1 M more take 500 s.
        let mut pace = Pace::new(60_000_000, start);
        assert_eq!((pace.rate(), pace.left(80_000_000)), (None, None));
        pace.advance(60_000_000, after(100));
        assert_eq!((pace.rate(), pace.left(80_000_000)), (None, None), "nothing is done yet");
        pace.advance(61_000_000, after(500));
        assert_eq!((pace.rate(), pace.left(80_000_000)), (Some(2000.0), Some(9500.0)));
        pace.advance(80_000_000, after(10_000));
        assert_eq!(pace.left(80_000_000), Some(0.0));
    }
}
