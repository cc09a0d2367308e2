//! The action kind `position`: the policy commands joint positions of a PD servo.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "position",
    since: Edition::ONE,
    doc: include_str!("position.md"),
    params: &[
        Param::required("rate", Ty::Quantity(Dimension::RATE))
            .range(1.0, 1e4)
            .doc("Control rate: how often the policy acts. It must divide `physics.rate`."),
        Param::required("servo_rate", Ty::Quantity(Dimension::RATE))
            .range(1.0, 1e5)
            .doc("Rate of the PD servo. It must divide `physics.rate` and be a multiple of `rate`."),
        Param::required("stiffness", Ty::Ratio("the robot's own proportional gain"))
            .range(0.0, 100.0)
            .doc("Proportional gain; the paper's K / s_p, so 12.5 % is s_p = 8."),
        Param::default("damping", Ty::Choice(&["sqrt", "linear", "fixed"]), "\"sqrt\"")
            .doc("How the derivative gain follows the stiffness."),
        Param::default("scale", Ty::Ratio("half of the joint's range"), "\"100 %\"")
            .range(1e-6, 10.0)
            .doc("What an action of 1 commands; it changes the numbers inside the policy, not the law."),
        Param::optional("targets", Ty::Choice(&["joint_limits", "effort_limits"])).doc(
            "How far the targets go: to the joints' limits, which is also what is meant without this key, or beyond them \
             until the effort limit is all that the servo gives. A soft servo needs the latter to hold the robot at all.",
        ),
        Param::optional("shares_of", Ty::Choice(&["joint_ranges", "effort_limits"])).doc(
            "What `scale` and `std` are shares of: half of each joint's range, which is also what is meant without this key, or the \
             error at which the servo gives the joint's effort limit. With the latter every joint explores with the same share of \
             its torque at every stiffness, as under torque control.",
        ),
        Param::required("std", Ty::Ratio("half of the joint's range"))
            .range(0.0, 10.0)
            .doc("Standard deviation of the exploration noise, the same share for every joint."),
        Param::default("delay", Ty::Quantity(Dimension::TIME), "\"0 s\"")
            .range(0.0, 0.1)
            .doc("Time between a torque command and its effect, rounded to physics steps; `randomize.action_delay` scales it."),
        Param::default("phase_modulation", Ty::Flag, "true")
            .doc("Whether one more action in [0, 1] speeds the phase up, to at most twice the nominal cadence."),
        super::PHASE_ACTION,
        Param::default("motor_speed_limit", Ty::Flag, "false").doc(
            "Whether torque that drives a joint faster fades to zero between its velocity limit and 1.25 times that.",
        ),
    ],
    needs: &[Signal::Joints, Signal::Torque],
};
