//! What an interruption means to a command: until its work begins, it ends at once, with the message and the
//! exit code that an interruption always has.

use super::{Exit, Global, output};
use crate::exec::Interrupt;

/// What a command says that was interrupted.
const MESSAGE: &str = "interrupted";

/// Listens from here on; the first thing that a command does which may take long. `leave` puts away what the
/// command would leave behind, should a signal end it before its work begins. `Err` is the exit code;
/// everything has been said then.
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

/// Says that the command was interrupted.
pub fn tell(global: &Global) -> Exit {
    output::note(global, MESSAGE);
    Exit::Interrupted
}
