//! How the progress of stages is shown.

use std::io::IsTerminal;
use std::sync::Arc;

use crate::exec::bars::Bars;
use crate::exec::events::{Events, JsonLines};
use crate::exec::progress::{Lines, Quiet};

use super::{Format, Global, output};

/// The receiver of events: JSON lines for programs, bars on terminals, plain lines in logs.
pub fn events(global: &Global) -> Arc<dyn Events> {
    match global.format {
        Format::Json => Arc::new(JsonLines::new(std::io::stdout())),
        _ if global.quiet => Arc::new(Quiet::new(std::io::stderr())),
        _ if std::io::stderr().is_terminal() => Arc::new(Bars::new(output::colored(global))),
        _ => Arc::new(Lines::new(std::io::stderr())),
    }
}
