//! All works of a run: those of `exec`, and the report's, which stands above them.

use crate::exec::Works;
use crate::exec::works;

/// The works by kind.
pub fn works() -> Works {
    works::works()
}
