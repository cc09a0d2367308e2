//! The observation `joint_velocity`.

use super::{Input, Observed, Readings, Subject, spread_over_joints};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointVelocity = "joint_velocity", needs [Joints] {
        /// Cut-off frequency of the filter; without it the raw difference is used.
        #[range(1e-3, 1e5)]
        low_pass: Option<Quantified<Hertz>>,
        /// Values that are normalised to 1: one number; six, for hip yaw, hip roll, hip pitch, knee, ankle
        /// pitch and ankle roll of either leg; or one per joint.
        #[range(1e-9, 1e9)]
        #[length(Length::Some)]
        #[default("[\"0.135 rad/s\", \"0.272 rad/s\", \"0.587 rad/s\", \"0.998 rad/s\", \"0.654 rad/s\", \
            \"0.399 rad/s\"]")]
        scale: Vec<Quantified<RadianPerSecond>>,
        /// Bound on the normalised numbers, both signs.
        #[range(1e-3, 1e6)]
        #[default("8.0")]
        clip: f64,
    }
}

impl Observed for JointVelocity {
    fn inputs(&self, subject: &Subject) -> Vec<Input> {
        let scales = spread_over_joints(&self.scale, subject.robot);
        let joints = subject.robot.links.iter().map(|link| &link.joint);
        let input = |(joint, scale): (&crate::robot::Joint, f64)| Input {
            name: "joint_velocity".into(),
            joint: Some(joint.name.clone()),
            unit: "rad/s".into(),
            offset: 0.0,
            scale,
            clip: self.clip,
        };
        joints.zip(scales).map(input).collect()
    }

    fn read(readings: &Readings, index: usize) -> f64 {
        readings.joint_velocity(index)
    }
}
