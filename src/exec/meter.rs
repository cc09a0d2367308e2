//! CPU time of concurrent stages: the process's time, divided by their threads.

use std::collections::BTreeMap;
use std::path::Path;

use crate::bounded;
use crate::plan::Fingerprint;

/// Divides CPU time among stages.
#[derive(Debug, Default)]
pub struct Meter {
    last: f64,
    spent: BTreeMap<Fingerprint, f64>,
}

impl Meter {
    /// A meter that starts now.
    pub fn start() -> Self {
        Self { last: process_cpu_seconds(), spent: BTreeMap::new() }
    }

    /// Divides the time since the last call among the stages that ran since then, in proportion to threads.
    pub fn share(&mut self, running: &[(Fingerprint, usize)]) {
        let now = process_cpu_seconds();
        let elapsed = now - std::mem::replace(&mut self.last, now);
        let threads: usize = running.iter().map(|(_, threads)| threads).sum();
        for (key, share) in running {
            *self.spent.entry(key.clone()).or_default() += elapsed * *share as f64 / threads as f64;
        }
    }

    /// The CPU time of a stage so far, in s.
    pub fn spent(&self, key: &Fingerprint) -> f64 {
        self.spent.get(key).copied().unwrap_or(0.0)
    }
}

/// User and system CPU time of this process in s; 0 if unavailable.
pub fn process_cpu_seconds() -> f64 {
    /// Ticks per second of `/proc/self/stat`, fixed for user space on Linux.
    const TICKS: f64 = 100.0;
    let stat = bounded::text(Path::new("/proc/self/stat"), bounded::WRITTEN).unwrap_or_default();
    // The command name is in parentheses and may contain spaces; utime and stime are fields 14 and 15.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields);
    let ticks = fields.split(' ').skip(11).take(2).filter_map(|field| field.parse::<f64>().ok());
    ticks.sum::<f64>() / TICKS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_time_grows_with_work() {
        let before = process_cpu_seconds();
        let mut sum = 0u64;
        while process_cpu_seconds() - before < 0.02 {
            sum = (0..100_000u64).fold(sum, |sum, number| sum.wrapping_mul(31).wrapping_add(number));
        }
        assert_ne!(sum, 1);
    }
}
