//! The observation `joint_position`.

use super::{Input, ObserveKind, Readings, Subject, spread_over_joints};
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Section, Signal, Ty};

/// The registry entry.
pub static KIND: ObserveKind = ObserveKind {
    kind: Kind {
        name: "joint_position",
        since: Edition::ONE,
        doc: include_str!("joint_position.md"),
        params: &[
            Param::optional("noise", Ty::Sampler(Dimension::ANGLE))
                .range(-3.2, 3.2)
                .doc("Encoder noise; without it positions are exact."),
            Param::default("scale", Ty::List(&Ty::Quantity(Dimension::ANGLE)), "[\"0.15 rad\"]")
                .range(1e-9, 1e9)
                .length(Length::Some)
                .doc("What becomes 1 after normalisation: one number; six, those of hip yaw, hip roll, hip pitch, knee, ankle pitch and ankle roll of either leg; or one per joint."),
            Param::default("clip", Ty::Number, "8.0")
                .range(1e-3, 1e6)
                .doc("Bound of the normalised numbers, both signs."),
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
        name: "joint_position".into(),
        joint: Some(joint.name.clone()),
        unit: "rad".into(),
        offset: joint.default_position,
        scale,
        clip: section.si("clip"),
    };
    joints.zip(scales).map(input).collect()
}

fn read(readings: &Readings, index: usize) -> f64 {
    readings.joint_position(index)
}
