//! Locks on fingerprints: if two runs need the same artefact, one makes it and the other waits.
//!
//! A lock is an advisory `flock` on a file and ends with the process, however that ends. The file contains
//! the ID of the process that took it last, for messages to waiting users.

use std::fs::File;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::process::{Pid, test_kill_process};

use super::fault::StoreError;
use super::interrupt::Interrupt;
use crate::bounded;
use crate::quantity::span;

/// Polling interval of a waiting run.
const POLL: Duration = Duration::from_millis(50);
/// How long to wait silently for a lock that is normally held only briefly.
const MOMENT: Duration = Duration::from_secs(1);
/// Name for a lock holder whose process ID is unknown.
const UNKNOWN: &str = "another process";

/// How to wait for a lock held by another process: what ends the wait, and how to report it (once).
#[derive(Clone, Copy, Default)]
pub struct Wait<'a> {
    /// Ends the wait when set. Without it, only a signal that ends the process does.
    pub interrupt: Option<&'a Interrupt>,
    /// Called with the lock's holder and for how long it has held it: `process 1234 (for 2 min 5 s)`, or
    /// `another process` if its ID is unknown.
    pub tell: Option<&'a dyn Fn(&str)>,
}

/// A lock, held until dropped.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

/// Takes the lock; `None` if another process holds it.
pub fn attempt(path: &Path) -> Result<Option<Lock>, StoreError> {
    taken(path, FlockOperation::NonBlockingLockExclusive)
}

/// Takes a lock that is held only briefly; [`StoreError::Interrupted`] if the wait is interrupted.
pub fn exclusive(path: &Path, wait: &Wait) -> Result<Lock, StoreError> {
    patient(path, FlockOperation::NonBlockingLockExclusive, MOMENT, wait)
}

/// As [`exclusive`], but shared with other shared locks.
pub fn shared(path: &Path, wait: &Wait) -> Result<Lock, StoreError> {
    patient(path, FlockOperation::NonBlockingLockShared, MOMENT, wait)
}

/// Takes a lock that is held as long as a stage runs; a wait is reported at once.
pub fn lasting(path: &Path, wait: &Wait) -> Result<Lock, StoreError> {
    patient(path, FlockOperation::NonBlockingLockExclusive, Duration::ZERO, wait)
}

/// Takes the lock of a folder, which is held only briefly; `None` if the folder is missing or its file system
/// does not support locks.
pub fn folder(path: &Path, wait: &Wait) -> Result<Option<Lock>, StoreError> {
    let Ok(file) = File::open(path) else { return Ok(None) };
    let mut file = Some(file);
    let attempt = || match file.as_ref().map(|file| flock(file, FlockOperation::NonBlockingLockExclusive)) {
        Some(Err(rustix::io::Errno::WOULDBLOCK)) => Ok(None),
        Some(Ok(())) => Ok(Some(file.take().map(|file| Lock { _file: file }))),
        Some(Err(_)) | None => Ok(Some(None)),
    };
    awaited(attempt, || UNKNOWN.to_owned(), MOMENT, wait)
}

fn patient(
    path: &Path,
    operation: FlockOperation,
    silent: Duration,
    wait: &Wait,
) -> Result<Lock, StoreError> {
    awaited(|| taken(path, operation), || holder(path), silent, wait)
}

/// Retries until the attempt succeeds. Reports the holder once, after the time `silent`.
fn awaited<T>(
    mut attempt: impl FnMut() -> Result<Option<T>, StoreError>,
    holder: impl Fn() -> String,
    silent: Duration,
    wait: &Wait,
) -> Result<T, StoreError> {
    let (start, mut tell) = (Instant::now(), wait.tell);
    loop {
        if let Some(there) = attempt()? {
            return Ok(there);
        }
        if start.elapsed() >= silent
            && let Some(tell) = tell.take()
        {
            tell(&holder());
        }
        if wait.interrupt.is_some_and(Interrupt::is_set) {
            return Err(StoreError::Interrupted);
        }
        std::thread::sleep(POLL);
    }
}

fn taken(path: &Path, operation: FlockOperation) -> Result<Option<Lock>, StoreError> {
    // Non-blocking: opening a named pipe in place of the file would wait for a reader.
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
    let opened = File::options().create(true).append(true).custom_flags(flags).open(path);
    let mut file = opened.map_err(|error| StoreError::writing(path, error))?;
    match flock(&file, operation) {
        Ok(()) => {
            // The process ID only informs others, so take the lock even if a full disk prevents writing it.
            let _ = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
            Ok(Some(Lock { _file: file }))
        }
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(None),
        Err(error) => Err(StoreError::writing(path, error.into())),
    }
}

/// Describes who holds the lock. If no process has the ID, its process has ended or is on another machine.
fn holder(path: &Path) -> String {
    let text = bounded::text(path, bounded::WRITTEN).unwrap_or_default();
    let number = text.lines().last().and_then(|line| line.parse().ok()).and_then(Pid::from_raw);
    match number.filter(|pid| !matches!(test_kill_process(*pid), Err(rustix::io::Errno::SRCH))) {
        Some(pid) => format!("process {}{}", pid.as_raw_nonzero(), held(path)),
        None => UNKNOWN.to_owned(),
    }
}

/// How long the lock has been held, from the time its holder wrote its process ID. Empty below one second, or
/// if the clock was set back since then.
fn held(path: &Path) -> String {
    let since = std::fs::metadata(path).and_then(|found| found.modified()).ok();
    let seconds = since.and_then(|since| since.elapsed().ok()).map_or(0.0, |elapsed| elapsed.as_secs_f64());
    if seconds < 1.0 { String::new() } else { format!(" (for {})", span(seconds)) }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    #[test]
    fn a_wait_names_the_process_that_holds_the_lock_and_ends_with_the_first_interruption() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lock");
        let held = attempt(&path).expect("it can be written").expect("it is free");
        let (interrupt, told) = (Interrupt::default(), RefCell::new(Vec::new()));
        let tell = |who: &str| {
            told.borrow_mut().push(who.to_owned());
            interrupt.set();
        };
        let wait = Wait { interrupt: Some(&interrupt), tell: Some(&tell) };
        for lock in [exclusive, shared, lasting] {
            let wait = Wait { tell: Some(&tell), ..wait };
            // The interruption of another test leaves nothing behind.
            assert!(matches!(lock(&path, &wait), Err(StoreError::Interrupted)));
        }
        let own = format!("process {}", std::process::id());
        assert!(told.borrow()[0].starts_with(&own), "the first wait was told before it ended");
        let file = File::options().append(true).open(&path).expect("it is there");
        let two_hours = std::time::SystemTime::now() - Duration::from_secs(7210);
        file.set_modified(two_hours).expect("its owner may");
        assert_eq!(holder(&path), format!("{own} (for 2 h 0 min)"));
        std::fs::write(&path, "2147483646\n").expect("it can be written");
        assert_eq!(holder(&path), "another process");
        std::fs::write(&path, "0\nx").expect("it can be written");
        assert_eq!(holder(&path), "another process");
        drop(held);
        assert!(exclusive(&path, &Wait::default()).is_ok());
    }

    #[test]
    fn the_wait_for_a_folder_is_told_and_ends_with_the_first_interruption() {
        let place = tempfile::tempdir().expect("a folder");
        let held = super::folder(place.path(), &Wait::default()).expect("it is free");
        assert!(held.is_some(), "this file system has locks");
        let (interrupt, told) = (Interrupt::default(), RefCell::new(Vec::new()));
        let tell = |who: &str| {
            told.borrow_mut().push(who.to_owned());
            interrupt.set();
        };
        let wait = Wait { interrupt: Some(&interrupt), tell: Some(&tell) };
        assert!(matches!(super::folder(place.path(), &wait), Err(StoreError::Interrupted)));
        assert_eq!(*told.borrow(), ["another process"]);
        drop(held);
        assert!(super::folder(place.path(), &wait).expect("it is free").is_some());
        assert!(super::folder(&place.path().join("none"), &wait).expect("nothing to lock").is_none());
    }
}
