//! Evaluation protocols. What they do stands in `evaluate/`.

pub mod episodes;

use crate::quantity::Dimension;
use crate::spec::{Kind, Param, Ty};

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&episodes::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

/// What is commanded for the whole of every episode.
pub const COMMAND: Param = Param::optional(
    "command",
    Ty::Table(&[Param::required("speed", Ty::Quantity(Dimension::VELOCITY))
        .range(-10.0, 10.0)
        .doc("Forward speed, held for the whole episode.")]),
)
.doc("The command of every episode; without it the middle of the task's range.");

/// How long an episode may last.
pub const TIME_LIMIT: Param = Param::optional("time_limit", Ty::Quantity(Dimension::TIME))
    .range(0.1, 3600.0)
    .doc("Duration of an episode that nothing ends; without it `task.episode`.");
