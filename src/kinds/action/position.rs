//! The action kind `position`: the policy commands joint positions of a PD servo.

use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Section, Signal, Ty};

/// The derivative gain of the servo, as a rule or as a share.
const DAMPING: Ty =
    Ty::OneOf(&[Ty::Choice(&["sqrt", "linear", "fixed"]), Ty::Ratio("the robot's own derivative gain")]);

/// Whether the servo of a decoded `[action]` table reads its encoders, not the true state.
pub fn reads_encoders(action: Section) -> bool {
    action.text_if("feedback") == Some("measured")
}

/// What an action of 100 % is.
const SHARED: Ty = Ty::OneOf(&[Ty::Choice(&["joint_ranges", "effort_limits"]), Ty::Quantity(Dimension::ANGLE)]);

/// What `scale` and `std` of a position action are shares of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shares {
    /// Half of each joint's range.
    HalfRanges,
    /// The error at which the servo gives the joint's effort limit.
    EffortLimits,
    /// This angle in rad at every joint.
    Angle(f64),
}

impl Shares {
    /// Those of a decoded `[action]` table.
    pub fn of(action: Section) -> Self {
        match (action.text_if("shares_of"), action.si_if("shares_of")) {
            (Some("effort_limits"), _) => Self::EffortLimits,
            (_, Some(angle)) => Self::Angle(angle),
            _ => Self::HalfRanges,
        }
    }
}

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
            .range(1e-6, 100.0)
            .doc("Proportional gain; the paper's K / s_p, so 12.5 % is s_p = 8."),
        Param::default("damping", DAMPING, "\"sqrt\"").range(0.0, 100.0).doc(
            "The derivative gain: how it follows the stiffness, or a share of the robot's own. The delay holds the servo's torque back, so \
             much damping of light joints makes them shake (W0512).",
        ),
        Param::default("scale", Ty::Ratio("half of the joint's range"), "\"100 %\"")
            .range(1e-6, 10.0)
            .doc("What an action of 1 commands; it changes the numbers inside the policy, not the law."),
        Param::optional("targets", Ty::Choice(&["joint_limits", "effort_limits"])).doc(
            "How far the targets go: to the joints' limits, which is also what is meant without this key, or beyond them \
             until the effort limit is all that the servo gives. A soft servo needs the latter to hold the robot at all.",
        ),
        Param::optional("shares_of", SHARED).range(1e-3, 100.0).doc(
            "What `scale` and `std` are shares of: half of each joint's range (the default); the \
             error at which the servo gives the joint's effort limit, with which every joint explores with the same share of \
             its torque at every stiffness, as under torque control; or an angle, the same for every joint, as `\"3.14 rad\"`.",
        ),
        Param::required("std", Ty::Ratio("half of the joint's range"))
            .range(1e-6, 10.0)
            .doc("Standard deviation of the exploration noise, the same share for every joint."),
        Param::default("delay", Ty::Quantity(Dimension::TIME), "\"0 s\"")
            .range(0.0, 0.1)
            .doc("Time between a torque command and its effect; it need not be a whole number of physics steps. `randomize.action_delay` scales it."),
        Param::optional("feedback", Ty::Choice(&["true", "measured"])).doc(
            "What the servo reads: the joints' true positions and velocities (the default), or its \
             encoders: positions with the noise of `observe.joint_position`, and as the velocity their difference over the last \
             physics step, not low-passed. Both are shifted by `randomize.joint_offset`.",
        ),
        Param::default("phase_modulation", Ty::Flag, "true")
            .doc("Whether one more action in [0, 1] speeds the phase up, to at most twice the nominal cadence."),
        super::PHASE_ACTION,
        Param::default("motor_speed_limit", Ty::Flag, "false").doc(
            "Whether torque that drives a joint faster fades to zero between its velocity limit and 1.25 times that.",
        ),
    ],
    needs: &[Signal::Joints, Signal::Torque],
};

/// The proportional and the derivative gain of a position action, in shares of the robot's own (docs/design/paper.md, A20).
pub fn gain_shares(action: Section) -> Option<(f64, f64)> {
    let stiffness = action.si_if("stiffness")?;
    let rule = match action.text_if("damping") {
        Some("linear") => stiffness,
        Some("fixed") => 1.0,
        _ => stiffness.sqrt(),
    };
    Some((stiffness, action.si_if("damping").unwrap_or(rule)))
}
