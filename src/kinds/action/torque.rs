//! The action kind `torque`: the policy commands joint torques.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "torque",
    since: Edition::ONE,
    doc: include_str!("torque.md"),
    params: &[
        Param::required("rate", Ty::Quantity(Dimension::RATE))
            .range(1.0, 1e4)
            .doc("Control rate: how often the policy acts. It must divide `physics.rate`."),
        Param::required("std", Ty::Ratio("the joint's effort limit"))
            .range(1e-6, 10.0)
            .doc("Standard deviation of the exploration noise, the same share for every joint."),
        Param::default("delay", Ty::Quantity(Dimension::TIME), "\"0 s\"")
            .range(0.0, 0.1)
            .doc("Time between a torque command and its effect; it need not be a whole number of physics steps. `randomize.action_delay` scales it."),
        Param::default("phase_modulation", Ty::Flag, "true")
            .doc("Whether one more action in [0, 1] speeds the phase up, to at most twice the nominal cadence."),
        super::PHASE_ACTION,
        Param::default("motor_speed_limit", Ty::Flag, "false").doc(
            "Whether torque that drives a joint faster fades to zero between its velocity limit and 1.25 times that.",
        ),
    ],
    needs: &[Signal::Torque],
};
