//! Interruption: while a command only reads and plans, Ctrl-C ends it; once it works, the first asks to stop
//! and the second stops at once. Knows signals, nothing of works.
//!
//! What a terminal that closes and the batch systems of clusters send asks to stop, too, and never twice.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};
use signal_hook::iterator::Signals;

/// The exit code of an interrupted run.
pub const EXIT_CODE: i32 = 6;

/// Signals this close to the first are its echo: who stops a process and its group (`timeout` does) signals
/// it twice.
const ECHO: Duration = Duration::from_millis(100);

/// Signals that the system sends. Batch systems can be told to send SIGUSR1 or SIGUSR2 before a job's time is
/// over.
const SYSTEMS: [i32; 4] = [SIGHUP, SIGXCPU, SIGUSR1, SIGUSR2];

/// How long a process that ends waits for its last words, which a reader that has stopped reading may hold
/// up.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// Whether the user wants to stop. Clones share one answer.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    /// Whether somebody asked to stop.
    asked: AtomicBool,
    /// Whether there is work that must be stopped in order.
    working: AtomicBool,
}

impl Interrupt {
    /// Listens to the signals that ask a program to end. Until [`Self::work`] is called there is nothing to
    /// lose: the first says farewell and ends the process with exit code 6, whatever the command is at. After
    /// it the first is remembered. Another Ctrl-C, SIGTERM or SIGQUIT, later than its echo, ends the process
    /// with exit code 6; the store survives that, as artefacts are renamed into place whole. Of what the
    /// system sends (a terminal that closes, a limit of CPU time, a batch system's warning) any number is
    /// one: it comes more than once by itself.
    pub fn listen(farewell: impl FnOnce() + Send + 'static) -> std::io::Result<Self> {
        let mut heard = vec![SIGINT, SIGTERM, SIGQUIT];
        heard.extend(SYSTEMS.into_iter().filter(|signal| *signal != SIGHUP || !is_ignored(SIGHUP)));
        let (interrupt, mut signals) = (Self::default(), Signals::new(heard)?);
        let told = interrupt.clone();
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            let (mut first, mut by_system): (Option<Instant>, bool) = (None, false);
            for signal in signals.forever() {
                if !told.0.working.load(Ordering::SeqCst) {
                    return end(farewell);
                }
                match first {
                    _ if SYSTEMS.contains(&signal) => by_system = true,
                    None if by_system || !told.is_set() => first = Some(Instant::now()),
                    Some(first) if first.elapsed() < ECHO => {}
                    _ => signal_hook::low_level::exit(EXIT_CODE),
                }
                told.set();
            }
        })?;
        Ok(interrupt)
    }

    /// From here on there is work: a signal asks to stop, and who works looks at [`Self::is_set`].
    pub fn work(&self) {
        self.0.working.store(true, Ordering::SeqCst);
    }

    /// Lets a write beyond `ulimit -f` fail as one on a full disk does; the signal would kill the process in
    /// mid-write.
    pub fn outlive_file_size_limit() {
        // SAFETY: ignoring a signal runs no code, and no other thread is there to change its disposition.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
    }

    /// Whether to stop soon: finish the step, write a checkpoint, return.
    pub fn is_set(&self) -> bool {
        self.0.asked.load(Ordering::SeqCst)
    }

    /// Asks to stop, as the first Ctrl-C does.
    pub fn set(&self) {
        self.0.asked.store(true, Ordering::SeqCst);
    }
}

/// Says farewell and ends the process. The farewell has a thread of its own: standard error may be blocked.
fn end(farewell: impl FnOnce() + Send + 'static) {
    let (said, heard) = mpsc::channel();
    let speaker = std::thread::Builder::new().name("farewell".into());
    let started = speaker.spawn(move || {
        farewell();
        let _ = said.send(());
    });
    if started.is_ok() {
        let _ = heard.recv_timeout(LAST_WORDS);
    }
    signal_hook::low_level::exit(EXIT_CODE)
}

/// Whether whoever started the program has it ignore a signal, as `nohup` does with SIGHUP.
fn is_ignored(signal: i32) -> bool {
    // SAFETY: only reads the present disposition into a value of its type.
    unsafe {
        let mut present: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &raw mut present) == 0
            && present.sa_sigaction == libc::SIG_IGN
    }
}
