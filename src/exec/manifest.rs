//! The manifest of a stored artefact: what made it and which files it has.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::effort::Effort;
use crate::bounded;
use crate::plan::Stage;
use crate::plan::fingerprint::canonical_json;
use crate::safe_fs;

/// The name of the manifest in an artefact's folder.
pub const FILE: &str = "manifest.json";

/// Description of a stored artefact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The stage that made it, with its recipe, fields and origins.
    pub stage: Stage,
    /// Its files, sorted by path.
    pub files: Vec<FileRecord>,
    /// How it was made.
    pub provenance: Provenance,
    /// The files that it had when it was made, if only some of them were restored from the record of a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub originals: Vec<FileRecord>,
}

/// A file of an artefact.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Path in the artefact's folder, with `/`.
    pub path: String,
    /// Size in bytes.
    pub size: u64,
    /// BLAKE3 of the content.
    pub blake3: String,
}

/// How an artefact was made. Does not affect the fingerprint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of specforge.
    pub tool: String,
    /// Commit of specforge.
    pub commit: String,
    /// When it was finished, UTC, `2026-01-31T12:00:00Z`.
    pub finished: String,
    /// Cores of the machine.
    pub cores: usize,
    /// Wall time in s of the successful attempt and of interrupted or failed ones before it.
    pub wall_s: f64,
    /// CPU time in s of these attempts; concurrent stages divide the process's time by their threads.
    pub cpu_s: f64,
}

impl Provenance {
    /// The provenance of an artefact finished now.
    pub fn now(effort: Effort) -> Self {
        Self {
            tool: env!("CARGO_PKG_VERSION").into(),
            commit: env!("SPECFORGE_COMMIT").into(),
            finished: now(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            wall_s: effort.wall_s,
            cpu_s: effort.cpu_s,
        }
    }
}

/// How thoroughly to check an artefact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Manifest, sizes, and the digests of files below 16 MiB.
    Quick,
    /// Every digest.
    Full,
}

impl Manifest {
    /// Describes the files of a folder.
    pub fn describe(folder: &Path, stage: &Stage, provenance: Provenance) -> std::io::Result<Self> {
        let mut paths = Vec::new();
        list(folder, folder, &mut paths)?;
        paths.sort();
        let mut files = Vec::new();
        for path in paths {
            let (size, blake3) = digest(&folder.join(&path))?;
            files.push(FileRecord { path, size, blake3 });
        }
        Ok(Self { stage: stage.clone(), files, provenance, originals: Vec::new() })
    }

    /// Whether files of the original artefact are missing: it is enough for a report, but not for a stage
    /// that needs the weights.
    pub fn is_reduced(&self) -> bool {
        let is_missing = |original: &FileRecord| self.files.iter().all(|file| file.path != original.path);
        self.originals.iter().any(|original| original.path.ends_with(".safetensors") && is_missing(original))
    }

    /// The manifest as JSON with its own digest.
    pub fn to_text(&self) -> String {
        let mut json = serde_json::to_value(self).expect("a manifest is plain data");
        json["digest"] = blake3::hash(canonical_json(&json).as_bytes()).to_hex().to_string().into();
        serde_json::to_string_pretty(&json).expect("JSON can be written")
    }

    /// Parses a manifest and checks its digest.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut json: serde_json::Value =
            serde_json::from_str(text).map_err(|error| format!("{FILE} is not JSON: {error}"))?;
        let digest = json.as_object_mut().and_then(|map| map.shift_remove("digest"));
        let digest = digest.ok_or_else(|| format!("{FILE} has no digest"))?;
        if digest != blake3::hash(canonical_json(&json).as_bytes()).to_hex().as_str() {
            return Err(format!("{FILE} does not match its digest"));
        }
        let manifest: Self = serde_json::from_value(json).map_err(|error| format!("{FILE}: {error}"))?;
        match manifest.files.iter().find(|file| !safe_fs::is_plain(&file.path)) {
            Some(file) => {
                Err(format!("{FILE} names `{}`, which leads out of the artefact's folder", file.path))
            }
            None => Ok(manifest),
        }
    }
}

/// Size and BLAKE3 of a file.
pub(super) fn digest(path: &Path) -> std::io::Result<(u64, String)> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(bounded::open(path)?.take(bounded::ARTEFACT))?;
    Ok((hasher.count(), hasher.finalize().to_hex().to_string()))
}

/// The files below a folder, as relative paths.
pub(super) fn list(root: &Path, folder: &Path, found: &mut Vec<String>) -> std::io::Result<()> {
    for entry in folder.read_dir()? {
        let path = entry?.path();
        if path.is_dir() {
            list(root, &path, found)?;
        } else if path != root.join(FILE) {
            let relative: PathBuf = path.strip_prefix(root).unwrap_or(&path).components().collect();
            found.push(relative.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}

/// The present date and time in UTC, `2026-01-31T12:00:00Z`.
pub fn now() -> String {
    stamp(SystemTime::now()).unwrap_or_else(|| utc(0))
}

/// A date and time in UTC, in the form of [`now`]; `None` before 1970.
pub fn stamp(time: SystemTime) -> Option<String> {
    time.duration_since(UNIX_EPOCH).ok().map(|elapsed| utc(elapsed.as_secs()))
}

/// Seconds since 1970 as a date and time in UTC (days to civil date after H. Hinnant, "chrono-compatible
/// low-level date algorithms").
fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3_600, second % 3_600 / 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_become_dates() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_767_225_599), "2025-12-31T23:59:59Z");
    }
}
