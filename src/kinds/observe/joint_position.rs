//! The observation `joint_position`.

use super::{Input, Observed, Readings, Subject, spread_over_joints};
use crate::spec::typed::prelude::*;

kind! {
    pub struct JointPosition = "joint_position", needs [Joints] {
        /// Encoder noise; without it positions are exact.
        #[range(-3.2, 3.2)]
        noise: Option<Sampled<Radian>>,
        /// Values that are normalised to 1: one number; six, for hip yaw, hip roll, hip pitch, knee, ankle
        /// pitch and ankle roll of either leg; or one per joint.
        #[range(1e-9, 1e9)]
        #[length(Length::Some)]
        #[default("[\"0.15 rad\"]")]
        scale: Vec<Quantified<Radian>>,
        /// Bound on the normalised numbers, both signs.
        #[range(1e-3, 1e6)]
        #[default("8.0")]
        clip: f64,
    }
}

impl Observed for JointPosition {
    fn inputs(&self, subject: &Subject) -> Vec<Input> {
        let scales = spread_over_joints(&self.scale, subject.robot);
        let joints = subject.robot.links.iter().map(|link| &link.joint);
        let input = |(joint, scale): (&crate::robot::Joint, f64)| Input {
            name: "joint_position".into(),
            joint: Some(joint.name.clone()),
            unit: "rad".into(),
            offset: joint.default_position,
            scale,
            clip: self.clip,
        };
        joints.zip(scales).map(input).collect()
    }

    fn read(readings: &Readings, index: usize) -> f64 {
        readings.joint_position(index)
    }
}
