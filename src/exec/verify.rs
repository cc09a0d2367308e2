//! Checks an artefact: its manifest and the files in its folder must agree. Files that are not results may lie
//! beside them.

use std::path::Path;

use super::manifest::{Depth, FILE, Manifest, digest};
use super::{copies, evidence, numbers, strays};
use crate::plan::{Fingerprint, StageKind};
use crate::safe_fs;

/// Files up to this size are hashed whenever the store is inspected (BLAKE3 takes a millisecond per MB);
/// larger ones only before they are read.
const QUICK_LIMIT: u64 = 16 << 20;

/// Checks that the manifest of an artefact and the files in its folder agree.
pub(super) fn check(
    manifest: &Manifest,
    folder: &Path,
    kind: StageKind,
    key: &Fingerprint,
    depth: Depth,
) -> Result<(), String> {
    if manifest.stage.fingerprint != *key {
        return Err(format!("{FILE} belongs to another stage"));
    }
    evidence::agrees(manifest, kind)?;
    if let Some(path) = strays::false_result(manifest, folder) {
        return Err(format!("{path} is not in {FILE}"));
    }
    for file in &manifest.files {
        let path = safe_fs::inside(folder, &file.path).map_err(|error| error.to_string())?;
        let size = path.metadata().map_err(|error| format!("{}: {error}", file.path))?.len();
        if size != file.size {
            return Err(format!("{} has {size} bytes in place of {}", file.path, file.size));
        }
        if depth == Depth::Full || size <= QUICK_LIMIT {
            let (_, found) = digest(&path).map_err(|error| format!("{}: {error}", file.path))?;
            if found != file.blake3 {
                return Err(format!("the bytes of {} do not match their digest", file.path));
            }
        }
    }
    numbers::check(folder, manifest.files.iter().map(|file| file.path.as_str()))?;
    // A reduced artefact lacks the files that its copies are compared with.
    if manifest.originals.is_empty() { copies::check(folder, &manifest.stage, depth) } else { Ok(()) }
}
