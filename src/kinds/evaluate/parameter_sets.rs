//! The evaluation protocol `parameter_sets`.

use super::{Command, Setting};
use crate::spec::typed::prelude::*;

choice! {
    /// A randomization that scales a parameter of the robot or the ground.
    pub enum Parameter {
        /// The delay of the torque.
        ActionDelay = "action_delay",
        /// The friction of the soles.
        FootFriction = "foot_friction",
        /// The friction of the ground.
        GroundFriction = "ground_friction",
        /// The damping of the joints.
        JointDamping = "joint_damping",
        /// The friction of the joints.
        JointFriction = "joint_friction",
        /// The length of the legs.
        LegLength = "leg_length",
        /// The centres of mass of the links.
        LinkCom = "link_com",
        /// The inertia of the links.
        LinkInertia = "link_inertia",
        /// The mass of the links.
        LinkMass = "link_mass",
        /// The motors' torque constant.
        MotorConstant = "motor_constant",
    }
}

choice! {
    /// Sampling of parameter sets.
    pub enum Sampling {
        /// Stratified in every parameter.
        LatinHypercube = "latin_hypercube",
        /// Independently.
        Uniform = "uniform",
    }
}

/// The parameters of the paper's Table II and the length of the legs.
const EIGHT: &str = "[\"link_mass\", \"link_inertia\", \"link_com\", \"joint_damping\", \"joint_friction\", \
                     \"motor_constant\", \"action_delay\", \"leg_length\"]";

kind! {
    pub struct ParameterSets in "evaluate" = "parameter_sets" {
        /// Number of sets, each with one episode.
        #[range(1.0, 1e5)]
        sets: u64,
        /// Sampling of the sets: stratified in every parameter, or independent.
        #[default("\"latin_hypercube\"")]
        sampling: Sampling,
        /// The smallest and the largest factor on a parameter's nominal value.
        #[range(1e-3, 1e3)]
        #[length(Length::Each(&["lowest", "highest"]))]
        #[default("[0.7, 1.3]")]
        scale: Vec<f64>,
        /// The scaled parameters, by the names of their randomizations.
        #[default(EIGHT)]
        parameters: Vec<Parameter>,
        /// The command of every episode; by default the middle of the task's range.
        command: Option<Command>,
        /// Standard deviation of the joint positions around the default pose at the start.
        #[range(0.0, 1.0)]
        #[default("\"0 rad\"")]
        perturbation: Quantified<Radian>,
        ..setting: Setting,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize;

    #[test]
    fn every_randomization_with_a_scale_is_a_parameter_and_no_other() {
        let scaled =
            randomize::KINDS.iter().filter(|row| row.kind.params.iter().any(|param| param.name == "scale"));
        assert_eq!(scaled.map(|row| row.kind.name).collect::<Vec<_>>(), Parameter::WORDS);
    }
}
