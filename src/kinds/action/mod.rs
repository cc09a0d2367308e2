//! Actions: what the policy commands and the low-level law behind it (`control/` executes it).

pub mod position;
pub mod torque;

use crate::spec::{Kind, Param, Ty};

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&position::KIND, &torque::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

const PHASE_ACTION: Param = Param::optional("phase_action", Ty::Choice(&["share", "time"])).doc(
    "What a phase action of 1 adds to a control step: as much time again, which is also what is meant without this key, or \
     the step's seconds read as a share of the cycle, as printed (2.8 times the nominal cadence for a cycle of 1.8 s).",
);
