//! Wall and CPU time of a stage's interrupted or failed attempts, kept in its scratch folder until an attempt
//! succeeds, so that a report gives the cost of the whole training and not of its last part only.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::events::{Event, Events};
use super::fault::StoreError;
use crate::{bounded, finite, safe_fs};

/// The file's name in the scratch folder.
const NAME: &str = "effort.json";
/// How often the effort is saved while a stage works: what a killed attempt spent after that is not counted.
const INTERVAL: Duration = Duration::from_secs(5);

/// Wall and CPU time of a stage, summed over attempts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Wall time in s.
    pub wall_s: f64,
    /// CPU time in s.
    pub cpu_s: f64,
}

impl Effort {
    /// The time spent by earlier attempts; zero if none was recorded or the file cannot be read.
    pub fn spent(scratch: &Path) -> Self {
        let text = bounded::text(&scratch.join(NAME), bounded::WRITTEN).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// The sum of both.
    pub fn and(self, other: Self) -> Self {
        Self { wall_s: self.wall_s + other.wall_s, cpu_s: self.cpu_s + other.cpu_s }
    }

    /// Saves it for the next attempt, atomically.
    pub fn keep(self, scratch: &Path) -> Result<(), StoreError> {
        let (path, draft) = (scratch.join(NAME), scratch.join("effort.draft"));
        let text =
            finite::to_string(&self).map_err(|found| StoreError::NotFinite { file: NAME.into(), found })?;
        safe_fs::replace_through(&draft, &path, text.as_bytes())
            .map_err(|error| StoreError::writing(&path, error))
    }
}

/// The effort of an attempt and those before it. Passes the events of the attempt on and saves the effort now
/// and then, so that an attempt that is killed counts, too.
pub struct Meter<'a> {
    events: &'a dyn Events,
    scratch: &'a Path,
    cpu: &'a (dyn Fn() -> f64 + Sync),
    earlier: Effort,
    start: Instant,
    saved: Mutex<Instant>,
}

impl<'a> Meter<'a> {
    /// A meter that begins now; `cpu` returns the CPU time of the attempt in s.
    pub fn begin(events: &'a dyn Events, scratch: &'a Path, cpu: &'a (dyn Fn() -> f64 + Sync)) -> Self {
        let (earlier, start) = (Effort::spent(scratch), Instant::now());
        Self { events, scratch, cpu, earlier, start, saved: Mutex::new(start) }
    }

    /// The effort of this attempt so far.
    pub fn attempt(&self) -> Effort {
        Effort { wall_s: self.start.elapsed().as_secs_f64(), cpu_s: (self.cpu)() }
    }

    /// The effort of all attempts so far.
    pub fn total(&self) -> Effort {
        self.earlier.and(self.attempt())
    }
}

impl Events for Meter<'_> {
    fn emit(&self, event: Event) {
        if matches!(event, Event::Progress { .. })
            && let Ok(mut saved) = self.saved.lock()
            && saved.elapsed() >= INTERVAL
        {
            *saved = Instant::now();
            // The stage matters more than an error in recording its cost.
            let _ = self.total().keep(self.scratch);
        }
        self.events.emit(event);
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::events::Silence;
    use super::*;

    #[test]
    fn the_effort_of_an_attempt_that_is_killed_is_saved_with_its_progress() {
        let scratch = tempfile::tempdir().expect("a folder");
        let progress = || Event::Progress {
            stage: "learner".into(),
            done: 1,
            total: 2,
            unit: "samples".into(),
            note: String::new(),
        };
        let earlier = Effort { wall_s: 100.0, cpu_s: 50.0 };
        earlier.keep(scratch.path()).expect("the folder can be written");
        let meter = Meter::begin(&Silence, scratch.path(), &|| 3.0);
        meter.emit(progress());
        assert_eq!(Effort::spent(scratch.path()), earlier, "not with every event");
        let long_ago = Instant::now().checked_sub(2 * INTERVAL).expect("the machine runs for longer");
        *meter.saved.lock().expect("nobody panicked") = long_ago;
        meter.emit(progress());
        let spent = Effort::spent(scratch.path());
        assert!(spent.cpu_s == 53.0 && spent.wall_s >= 100.0, "{spent:?}");
    }

    #[test]
    fn what_attempts_have_cost_adds_up_and_what_cannot_be_read_is_nothing() {
        let scratch = tempfile::tempdir().expect("a folder");
        assert_eq!(Effort::spent(scratch.path()), Effort::default());
        let attempt = Effort { wall_s: 1.5, cpu_s: 2.0 };
        for count in 1..=2 {
            Effort::spent(scratch.path())
                .and(attempt)
                .keep(scratch.path())
                .expect("the folder can be written");
            let times = f64::from(count);
            assert_eq!(Effort::spent(scratch.path()), Effort { wall_s: 1.5 * times, cpu_s: 2.0 * times });
        }
        fs::write(scratch.path().join(NAME), r#"{"wall_s": 1"#).expect("the folder can be written");
        assert_eq!(Effort::spent(scratch.path()), Effort::default());
    }
}
