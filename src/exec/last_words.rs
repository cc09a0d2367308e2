//! What a run leaves behind when a library ends the process: the failure of the stage, reported like any
//! other, saved in its scratch folder for the next run, and added to the journal.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::events::{Event, Events};
use super::interrupt::Interrupt;
use super::journal::CrashLine;
use super::manifest;
use crate::bounded;
use crate::crash::{self, Crash, Work};
use crate::safe_fs;

/// The diagnostic's code.
pub const CODE: &str = "R0010";

/// The file's name in the scratch folder.
const NAME: &str = "failure.json";

/// How to fix it.
pub const HELP: &str = "finished stages are in the store; run again to resume from the checkpoints, with \
    fewer `--jobs` or environments if memory ran out";

/// Handles crashes of a run; `store` is the folder of its store, if it has one.
pub fn listen(store: Option<PathBuf>, events: Arc<dyn Events>, interrupt: &Interrupt) -> std::io::Result<()> {
    let (interrupt, start, last) = (interrupt.clone(), Instant::now(), events.clone());
    let told = move |crash: &Crash| tell(crash, store.as_deref(), events.as_ref());
    crash::listen(told, move || interrupt.set(), move || last.emit(finished(start)))
}

fn tell(crash: &Crash, store: Option<&Path>, events: &dyn Events) {
    let nameless = [Work { label: "the run".into(), key: String::new() }];
    let works = if crash.works.is_empty() { &nameless[..] } else { &crash.works };
    for Work { label, key } in works {
        if let Some(store) = store.filter(|_| !key.is_empty()) {
            let path = store.join("scratch").join(key).join(NAME);
            let text = serde_json::json!({ "code": CODE, "message": crash.message }).to_string();
            // Report the failure even if it cannot be saved.
            let _ = safe_fs::replace_through(&path.with_extension("draft"), &path, text.as_bytes());
        }
        let (stage, key, message) = (label.clone(), key.clone(), crash.message.clone());
        events.emit(Event::StageFailed {
            stage,
            key,
            code: Some(CODE.into()),
            message,
            help: Some(HELP.into()),
        });
    }
    // Last, because reading a long journal takes memory, which may have run out.
    let Some(store) = store.filter(|store| store.is_dir()) else { return };
    for Work { label, key } in works {
        let line = CrashLine {
            crash: label.clone(),
            key: key.clone(),
            code: CODE.into(),
            message: crash.message.clone(),
            time: manifest::now(),
            process: std::process::id(),
        };
        let _ = line.note(store);
    }
}

/// The last event of a run that a library ended. Only a thread that may have crashed knows which stages ran
/// or were cached; the events before this one have reported them.
fn finished(start: Instant) -> Event {
    Event::RunFinished {
        outcome: "crashed".into(),
        report: None,
        worked: 0,
        cached: 0,
        failed: 1,
        failing_arms: Vec::new(),
        unjudged_arms: Vec::new(),
        claims: Vec::new(),
        wall_s: start.elapsed().as_secs_f64(),
    }
}

/// Why the last attempt at a stage ended the process, if it did; reported only once.
pub fn of_last_attempt(scratch: &Path) -> Option<String> {
    let path = scratch.join(NAME);
    let text = bounded::text(&path, bounded::WRITTEN).ok()?;
    let _ = std::fs::remove_file(&path);
    let failure: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(failure["message"].as_str()?.to_owned())
}
