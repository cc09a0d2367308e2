//! The end of the process during a task: errors from which a native library does not return, aborts (a failed
//! allocation, an uncaught C++ exception) and faults such as a stack overflow.
//!
//! The affected thread never continues. It wakes a reporting thread that was created while memory was
//! available; that one reports the affected task to the listener, waits for the other tasks' checkpoints if
//! memory is still intact, and ends the process with [`EXIT_CODE`]. Independent of stages and stores.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

/// The exit code after a crash: that of a failed stage.
pub const EXIT_CODE: i32 = 4;

/// Memory reserved for the crash report, in bytes.
const RESERVE: usize = 8 << 20;
/// Time that other tasks have for their checkpoints.
const GRACE: Duration = Duration::from_secs(30);
/// Time limit of the crash report; after it the process ends without one.
const PATIENCE: Duration = Duration::from_secs(5);
/// Fatal signals.
const FAULTS: [i32; 5] = [libc::SIGABRT, libc::SIGSEGV, libc::SIGBUS, libc::SIGILL, libc::SIGFPE];

thread_local! {
    /// The task of this thread; 0 is none.
    static WORK: Cell<u32> = const { Cell::new(0) };
}

/// The running tasks, by number.
static RUNNING: Mutex<BTreeMap<u32, Work>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicU32 = AtomicU32::new(1);
/// Error message of a library, with the task's number.
static ERROR: Mutex<Option<(u32, String)>> = Mutex::new(None);
/// The first fault's signal, and the affected task.
static FAULT: AtomicI32 = AtomicI32::new(0);
static STRUCK: AtomicU32 = AtomicU32::new(0);
/// Whether a crash is being reported.
static ENDING: AtomicBool = AtomicBool::new(false);
static SPARE: Mutex<Vec<u8>> = Mutex::new(Vec::new());
/// Write end of the pipe that wakes the reporting thread; negative without a listener.
static WAKE: AtomicI32 = AtomicI32::new(-1);

/// A task that can be named.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Its name for human readers.
    pub label: String,
    /// Its key in the store; empty if it has none.
    pub key: String,
}

/// Description of a crash.
#[derive(Clone, Debug)]
pub struct Crash {
    /// The affected task; all running ones if it is unknown.
    pub works: Vec<Work>,
    /// The cause, as far as known.
    pub message: String,
}

/// A running task; it ends when this is dropped.
#[derive(Debug)]
pub struct Working {
    number: u32,
    outer: u32,
}

/// Assigns the current thread to this task.
pub fn working(work: Work) -> Working {
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    running().insert(number, work);
    Working { number, outer: WORK.replace(number) }
}

impl Drop for Working {
    fn drop(&mut self) {
        WORK.set(self.outer);
        running().remove(&self.number);
    }
}

/// The task of a thread, for the threads that it starts.
#[derive(Clone, Copy, Debug)]
pub struct Part(u32);

/// The task of the current thread.
pub fn part() -> Part {
    Part(WORK.get())
}

impl Part {
    /// Assigns the current thread to this task, too.
    pub fn join(self) {
        WORK.set(self.0);
    }
}

/// The result of a thread. If it panicked, the panic continues in the calling thread with its original
/// message.
pub fn joined<T>(result: std::thread::Result<T>) -> T {
    result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Reports crashes to `tell`, on a separate thread; `stop` asks the other tasks for their checkpoints, and
/// `over` is called last.
pub fn listen(
    tell: impl Fn(&Crash) + Send + 'static,
    stop: impl Fn() + Send + 'static,
    over: impl Fn() + Send + 'static,
) -> std::io::Result<()> {
    let mut ends = [0; 2];
    // SAFETY: the array has room for the two ends.
    if unsafe { libc::pipe2(ends.as_mut_ptr(), libc::O_CLOEXEC) } != 0 {
        return Err(std::io::Error::last_os_error());
    }
    *lock(&SPARE) = vec![0; RESERVE];
    let [wait, wake] = ends;
    std::thread::Builder::new().name("last words".into()).spawn(move || {
        last_words(wait, &tell, &stop);
        over();
        exit()
    })?;
    WAKE.store(wake, Ordering::SeqCst);
    FAULTS.into_iter().for_each(catch);
    Ok(())
}

/// Ends the process because a library cannot continue. Called from within the library, on any thread; never
/// returns.
pub fn fatal(library: &str, message: &str) -> ! {
    // The message takes memory, which may have run out.
    release();
    let first = !ENDING.swap(true, Ordering::SeqCst);
    if first {
        *lock(&ERROR) = Some((WORK.get(), format!("{library} stopped with an error: {message}")));
        if !wake() {
            complain(&format!("error[R0010]: {library} stopped with an error: {message}\n"));
            exit();
        }
    }
    // Meanwhile the process ends; this thread may hold a lock that the others' checkpoints need.
    std::thread::sleep(GRACE + 2 * PATIENCE);
    exit()
}

/// The thread that reports the crash before the process ends.
fn last_words(wait: i32, tell: &(impl Fn(&Crash) + Send), stop: &(impl Fn() + Send)) {
    let mut byte = 0_u8;
    // SAFETY: reads at most one byte into a byte. Interrupted calls are repeated.
    while unsafe { libc::read(wait, (&raw mut byte).cast(), 1) } < 1 {}
    release();
    let error = lock(&ERROR).take();
    let (struck, message) = match &error {
        Some((work, message)) => (*work, message.clone()),
        None => (STRUCK.load(Ordering::SeqCst), in_words(FAULT.load(Ordering::SeqCst))),
    };
    tell(&Crash { works: works(struck), message });
    if error.is_some() {
        // Memory is intact: other tasks can write their checkpoints.
        stop();
        let start = Instant::now();
        let others = || running().keys().any(|number| *number != struck);
        while others() && start.elapsed() < GRACE {
            std::thread::sleep(Duration::from_millis(20));
        }
        // The threads that started the ended tasks record their end.
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// The task with this number, or all running ones.
fn works(number: u32) -> Vec<Work> {
    // The affected thread may hold the lock.
    let start = Instant::now();
    let running = loop {
        match RUNNING.try_lock() {
            Ok(running) => break running,
            Err(TryLockError::Poisoned(poisoned)) => break poisoned.into_inner(),
            Err(TryLockError::WouldBlock) if start.elapsed() > PATIENCE / 5 => return Vec::new(),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    running.get(&number).map_or_else(|| running.values().cloned().collect(), |work| vec![work.clone()])
}

/// Describes a fault for users.
fn in_words(signal: i32) -> String {
    let what = match signal {
        libc::SIGABRT => {
            "it was aborted (SIGABRT): memory ran out, or a native library failed; the lines above may say \
             more"
        }
        libc::SIGSEGV => "invalid memory access or stack overflow (SIGSEGV)",
        libc::SIGBUS => "memory that cannot be read (SIGBUS): a truncated file, or a full temporary folder",
        libc::SIGILL => "an instruction that this processor does not have (SIGILL)",
        _ => "invalid arithmetic (SIGFPE)",
    };
    format!("the process crashed: {what}")
}

/// Installs the handler of a fault's signal, on the thread's own signal stack.
fn catch(signal: i32) {
    // SAFETY: the handler only makes async-signal-safe calls, and never returns.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = struck as extern "C" fn(i32) as usize;
        action.sa_flags = libc::SA_ONSTACK;
        libc::sigemptyset(&raw mut action.sa_mask);
        libc::sigaction(signal, &raw const action, std::ptr::null_mut());
    }
}

/// The handler: records the signal, wakes the reporting thread and waits for the end. It neither allocates
/// nor locks.
extern "C" fn struck(signal: i32) {
    if !ENDING.swap(true, Ordering::SeqCst) {
        FAULT.store(signal, Ordering::SeqCst);
        STRUCK.store(WORK.get(), Ordering::SeqCst);
        wake();
    }
    std::thread::sleep(PATIENCE);
    complain("error[R0010]: the process crashed, and the running task could not be determined\n");
    exit()
}

/// Wakes the reporting thread; false without one.
fn wake() -> bool {
    let wake = WAKE.load(Ordering::SeqCst);
    // SAFETY: writes one byte.
    wake >= 0 && unsafe { libc::write(wake, c"!".as_ptr().cast(), 1) } == 1
}

/// Frees the reserved memory.
fn release() {
    if let Ok(mut spare) = SPARE.try_lock() {
        drop(std::mem::take(&mut *spare));
    }
}

/// Writes to standard error without a buffer or a lock.
fn complain(text: &str) {
    // SAFETY: the bytes live for the whole call. A failure cannot be reported any more.
    let _ = unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
}

/// Ends the process at once: destructors of native libraries would run while other threads still use them.
fn exit() -> ! {
    // SAFETY: never returns.
    unsafe { libc::_exit(EXIT_CODE) }
}

fn running() -> MutexGuard<'static, BTreeMap<u32, Work>> {
    lock(&RUNNING)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_part_of_the_work_of_the_one_that_started_it() {
        let work = |label: &str| Work { label: label.into(), key: String::new() };
        let outer = working(work("outer"));
        let inner = working(work("inner"));
        let part = part();
        let named = std::thread::spawn(move || {
            let before = works(WORK.get()).contains(&Work { label: "outer".into(), key: String::new() });
            part.join();
            (before, works(WORK.get()))
        });
        let (before, after) = named.join().expect("it ends");
        assert!(before, "a thread of no work may be part of any");
        assert_eq!(after, [work("inner")]);
        drop(inner);
        assert_eq!(works(WORK.get()), [work("outer")]);
        drop(outer);
        assert_eq!(WORK.get(), 0);
    }
}
