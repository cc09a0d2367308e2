//! Interruption: the first Ctrl-C asks to stop, the second stops at once. Knows signals, nothing of works.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};

/// The exit code of an interrupted run.
pub const EXIT_CODE: i32 = 6;

/// Whether the user wants to stop. Clones share one answer.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to Ctrl-C and SIGTERM: the first is remembered here, the second ends the process with
    /// exit code 6. The store survives that: artefacts are renamed into place whole.
    pub fn listen() -> std::io::Result<Self> {
        let interrupt = Self::default();
        for signal in [SIGINT, SIGTERM] {
            // In this order: the shutdown must see the flag of an earlier signal, not of this one.
            signal_hook::flag::register_conditional_shutdown(signal, EXIT_CODE, interrupt.0.clone())?;
            signal_hook::flag::register(signal, interrupt.0.clone())?;
        }
        Ok(interrupt)
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
