//! Handling of interruptions by commands: before its work starts, a command ends at once, always with the
//! same message and exit code.

use super::{Exit, Global, output};
use crate::exec::Interrupt;

/// The message of an interrupted command.
const MESSAGE: &str = "interrupted";

/// Installs signal handlers; called before anything that may take long. `leave` removes what the command
/// would leave behind if a signal ends it before its work starts. Reports errors; `Err` is the exit code.
pub fn listen(global: &Global, leave: impl FnOnce() + Send + 'static) -> Result<Interrupt, Exit> {
    let told = global.clone();
    let farewell = move || {
        tell(&told);
        leave();
    };
    Interrupt::listen(farewell).map_err(|error| {
        output::complain(global, &format!("cannot install signal handlers: {error}"), None);
        Exit::Internal
    })
}

/// Reports that the command was interrupted.
pub fn tell(global: &Global) -> Exit {
    output::note(global, MESSAGE);
    Exit::Interrupted
}
