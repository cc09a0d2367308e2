//! Interruption: the first Ctrl-C asks to stop, the second stops at once. Knows signals, nothing of works.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

/// The exit code of an interrupted run.
pub const EXIT_CODE: i32 = 6;

/// Signals this close to the first are its echo: who stops a process and its group (`timeout` does) signals it twice.
const ECHO: Duration = Duration::from_millis(100);

/// Whether the user wants to stop. Clones share one answer.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to Ctrl-C and SIGTERM: the first is remembered here, another one, later than its echo, ends the
    /// process with exit code 6. The store survives that: artefacts are renamed into place whole.
    pub fn listen() -> std::io::Result<Self> {
        let (interrupt, mut signals) = (Self::default(), Signals::new([SIGINT, SIGTERM])?);
        let told = interrupt.clone();
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            let mut first: Option<Instant> = None;
            for _ in signals.forever() {
                match first {
                    None if !told.is_set() => first = Some(Instant::now()),
                    Some(first) if first.elapsed() < ECHO => {}
                    _ => signal_hook::low_level::exit(EXIT_CODE),
                }
                told.set();
            }
        })?;
        Ok(interrupt)
    }

    /// Lets a write beyond `ulimit -f` fail as one on a full disk does; the signal would kill the process in mid-write.
    pub fn outlive_file_size_limit() {
        // SAFETY: ignoring a signal runs no code, and no other thread is there to change its disposition.
        unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
    }

    /// Whether to stop soon: finish the step, write a checkpoint, return.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }

    /// Asks to stop, as the first Ctrl-C does.
    pub fn set(&self) {
        self.0.store(true, Ordering::SeqCst);
    }
}
