//! Locks on fingerprints: of two runs that want one artefact, one works and the other waits.
//!
//! A lock is an advisory `flock` on a file; it ends with the process, however that ends.

use std::fs::File;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::Duration;

use rustix::fs::{FlockOperation, OFlags, flock};

use super::fault::StoreError;
use super::interrupt::Interrupt;

/// How often a waiting run asks again.
const POLL: Duration = Duration::from_millis(50);

/// A lock that is held until it is dropped.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

/// The answer to a request for a lock.
#[derive(Debug)]
pub enum Locked {
    /// It is ours.
    Yes(Lock),
    /// The user interrupted the wait.
    Interrupted,
}

/// Takes the lock, or says that another process has it.
pub fn attempt(path: &Path) -> Result<Option<Lock>, StoreError> {
    taken(path, FlockOperation::NonBlockingLockExclusive)
}

/// Takes a lock that is held for moments only, however long another process has it.
pub fn exclusive(path: &Path) -> Result<Lock, StoreError> {
    patient(path, FlockOperation::NonBlockingLockExclusive)
}

/// The same, beside others who take it so.
pub fn shared(path: &Path) -> Result<Lock, StoreError> {
    patient(path, FlockOperation::NonBlockingLockShared)
}

fn patient(path: &Path, operation: FlockOperation) -> Result<Lock, StoreError> {
    loop {
        if let Some(lock) = taken(path, operation)? {
            return Ok(lock);
        }
        std::thread::sleep(POLL);
    }
}

fn taken(path: &Path, operation: FlockOperation) -> Result<Option<Lock>, StoreError> {
    // Not blocking: a named pipe in the place of the file would wait for a reader.
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
    let opened = File::options().create(true).append(true).custom_flags(flags).open(path);
    let file = opened.map_err(|error| StoreError::writing(path, error))?;
    match flock(&file, operation) {
        Ok(()) => Ok(Some(Lock { _file: file })),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(None),
        Err(error) => Err(StoreError::writing(path, error.into())),
    }
}

/// Takes the lock, waiting for another process to release it. `waits` is called once if it has to.
pub fn wait(path: &Path, interrupt: &Interrupt, waits: impl FnOnce()) -> Result<Locked, StoreError> {
    let mut waits = Some(waits);
    loop {
        if let Some(lock) = attempt(path)? {
            return Ok(Locked::Yes(lock));
        }
        if let Some(waits) = waits.take() {
            waits();
        }
        if interrupt.is_set() {
            return Ok(Locked::Interrupted);
        }
        std::thread::sleep(POLL);
    }
}
