//! Custom messages for keys: derived values cannot be set, and keys of the low-level controller have their
//! own codes.

/// Derived values and their inputs. They cannot be set (E0603).
pub const DERIVED: &[(&str, &str)] = &[
    ("spec", "the file's own edition"),
    ("extends", "the file's own parents"),
    ("abstract", "the file itself"),
    ("requires", "the file itself"),
    ("name", "the file itself"),
    ("summary", "the file itself"),
    ("profile", "the files' own profiles; choose one with `--profile`"),
    ("action.size", "the robot's joints and `action.phase_modulation`"),
    ("learn.updates", "`learn.samples` and `learn.rollout`"),
    ("observe.size", "the terms in `[observe]`"),
    ("physics.step", "`physics.rate`"),
    ("robot.joints", "the robot's file"),
    ("robot.mass", "the robot's file"),
    ("robot.standing_height", "the robot's file"),
    ("task.period", "the reference motion"),
];

/// The code and message for a key that is missing or not allowed in tables of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wording {
    /// The section.
    pub path: &'static str,
    /// The kind; empty for any.
    pub kind: &'static str,
    /// The key; empty for the section itself.
    pub key: &'static str,
    /// The code that replaces E0101, E0102 or E0105.
    pub code: &'static str,
    /// The message.
    pub message: &'static str,
    /// The advice.
    pub help: &'static str,
}

/// Mistakes in the low-level controller, which have their own codes.
pub const WORDINGS: &[Wording] = &[
    gain_of_torque("stiffness"),
    gain_of_torque("damping"),
    gain_of_torque("servo_rate"),
    Wording {
        path: "action",
        kind: "position",
        key: "stiffness",
        code: "E0504",
        message: "a position action needs gains",
        help: "add `stiffness`, for example `\"100 %\"` for the gains in the robot's file",
    },
    Wording {
        path: "action",
        kind: "position",
        key: "servo_rate",
        code: "E0504",
        message: "a position action needs the rate of its servo",
        help: "add for example `servo_rate = \"500 Hz\"`; it must divide `physics.rate`",
    },
];

const fn gain_of_torque(key: &'static str) -> Wording {
    Wording {
        path: "action",
        kind: "torque",
        key,
        code: "E0503",
        message: "a torque action has no gains",
        help: "remove it, or write `kind = \"position\"`",
    }
}
