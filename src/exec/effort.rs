//! Wall and CPU time of a stage's interrupted or failed attempts, kept in its scratch folder until an attempt
//! succeeds, so that a report gives the cost of the whole training and not of its last part only.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::fault::StoreError;
use crate::{bounded, finite, safe_fs};

/// The file's name in the scratch folder.
const NAME: &str = "effort.json";

/// Wall and CPU time of a stage, summed over attempts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Wall time in s.
    pub wall_s: f64,
    /// CPU time in s.
    pub cpu_s: f64,
}

impl Effort {
    /// The time spent by earlier attempts; zero if none was recorded or the file cannot be read. An attempt
    /// that was killed records no time.
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

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
