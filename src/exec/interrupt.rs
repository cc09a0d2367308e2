//! Interruption. While a command only reads and plans, Ctrl-C ends it. While stages run, the first Ctrl-C
//! requests a stop and the second stops at once.
//!
//! A closed terminal and the signals of batch systems also request a stop, but never force one.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};
use signal_hook::iterator::Signals;

/// The exit code of an interrupted run.
pub const EXIT_CODE: i32 = 6;

/// Signals this close to the first are duplicates: `timeout`, for example, signals a process and its group,
/// so the process receives two.
const ECHO: Duration = Duration::from_millis(100);

/// Signals sent by the system. Batch systems can be configured to send SIGUSR1 or SIGUSR2 before a job's time
/// runs out.
const SYSTEMS: [i32; 4] = [SIGHUP, SIGXCPU, SIGUSR1, SIGUSR2];

/// How long an ending process waits for its last message, which a reader that stopped reading may block.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// Whether a stop was requested. Clones share the same flag.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    /// Whether a stop was requested.
    asked: AtomicBool,
    /// Whether stages are running, which must be stopped in order.
    working: AtomicBool,
}

impl Interrupt {
    /// Installs signal handlers. Until [`Self::work`] is called there is nothing to lose, so the first signal
    /// prints `farewell` and ends the process with exit code 6. After that call, the first signal is
    /// recorded; another Ctrl-C, SIGTERM or SIGQUIT that is not a duplicate ends the process with exit code
    /// 6. The store survives that, because artefacts are renamed into place whole. Signals sent by the system
    /// (closed terminal, CPU time limit, warning of a batch system) may repeat, so all of them count as one.
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

    /// Marks that stages are running: a signal now requests a stop, and stages poll [`Self::is_set`].
    pub fn work(&self) {
        self.0.working.store(true, Ordering::SeqCst);
    }

    /// Makes a write beyond `ulimit -f` fail like one on a full disk; the signal would kill the process in
    /// the middle of the write.
    pub fn outlive_file_size_limit() {
        // SAFETY: ignoring a signal runs no code, and no other thread exists to change its disposition.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
    }

    /// Whether to stop soon: finish the step, write a checkpoint, return.
    pub fn is_set(&self) -> bool {
        self.0.asked.load(Ordering::SeqCst)
    }

    /// Requests a stop, as the first Ctrl-C does.
    pub fn set(&self) {
        self.0.asked.store(true, Ordering::SeqCst);
    }
}

/// Prints `farewell` and ends the process. A separate thread prints it because standard error may block.
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

/// Whether the parent process made this one ignore a signal, as `nohup` does with SIGHUP.
fn is_ignored(signal: i32) -> bool {
    // SAFETY: only reads the current disposition into a value of its type.
    unsafe {
        let mut present: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &raw mut present) == 0
            && present.sa_sigaction == libc::SIG_IGN
    }
}
