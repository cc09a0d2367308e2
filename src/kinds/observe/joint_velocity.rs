//! The observation `joint_velocity`.

use super::{Input, ObserveKind, Readings, Subject, spread_over_joints};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: ObserveKind = ObserveKind {
    kind: Kind {
        name: "joint_velocity",
        since: Edition::ONE,
        doc: include_str!("joint_velocity.md"),
        params: &[
            Param::optional("low_pass", Ty::Quantity(Dimension::RATE))
                .range(1e-3, 1e5)
                .doc("Cut-off frequency of the filter; without it the difference is used as it is."),
            Param::default(
                "scale",
                Ty::List(&Ty::Quantity(Dimension::ANGULAR_VELOCITY)),
                "[\"0.135 rad/s\", \"0.272 rad/s\", \"0.587 rad/s\", \"0.998 rad/s\", \"0.654 rad/s\", \"0.399 rad/s\"]",
            )
            .range(1e-9, 1e9)
            .length(Length::Some)
            .doc("What becomes 1 after normalisation: one number; six, those of hip yaw, hip roll, hip pitch, knee, ankle pitch and ankle roll of either leg; or one per joint."),
            Param::default("clip", Ty::Number, "8.0").range(1e-3, 1e6).doc("Bound of the normalised numbers, both signs."),
        ],
        needs: &[Signal::Joints],
    },
    inputs,
    read,
};

fn inputs(section: Section, subject: &Subject) -> Vec<Input> {
    let scales = spread_over_joints(&section.numbers("scale"), subject.robot);
    let joints = subject.robot.links.iter().map(|link| &link.joint);
    let input = |(joint, scale): (&crate::robot::Joint, f64)| Input {
        name: "joint_velocity".into(),
        joint: Some(joint.name.clone()),
        unit: "rad/s".into(),
        offset: 0.0,
        scale,
        clip: section.si("clip"),
    };
    joints.zip(scales).map(input).collect()
}

fn read(readings: &Readings, index: usize) -> f64 {
    readings.joint_velocity(index)
}
