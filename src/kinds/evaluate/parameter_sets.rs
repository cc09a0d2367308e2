//! The evaluation protocol `parameter_sets`.

use super::{COMMAND, CONTACT_TIME, ENGINE, RATE, SEED, TERRAIN, TIME_LIMIT};
use crate::kinds::fine_tune::POLICY;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Length, Param, Ty};

/// The randomizations that scale something of the robot or the ground, by name.
pub const PARAMETERS: &[&str] = &[
    "action_delay",
    "foot_friction",
    "ground_friction",
    "joint_damping",
    "joint_friction",
    "leg_length",
    "link_com",
    "link_inertia",
    "link_mass",
    "motor_constant",
];

/// The paper's eight: those of its Table II and the length of the legs.
const EIGHT: &str = "[\"link_mass\", \"link_inertia\", \"link_com\", \"joint_damping\", \"joint_friction\", \
                     \"motor_constant\", \"action_delay\", \"leg_length\"]";

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "parameter_sets",
    since: Edition::ONE,
    doc: include_str!("parameter_sets.md"),
    params: &[
        Param::required("sets", Ty::Count).range(1.0, 1e5).doc("Number of sets; each is one episode."),
        Param::default("sampling", Ty::Choice(&["latin_hypercube", "uniform"]), "\"latin_hypercube\"")
            .doc("How sets are drawn: stratified in every parameter, or independently."),
        Param::default("scale", Ty::List(&Ty::Number), "[0.7, 1.3]")
            .range(1e-3, 1e3)
            .length(Length::Each(&["lowest", "highest"]))
            .doc("The lowest and the highest factor on the nominal value of a parameter."),
        Param::default("parameters", Ty::List(&Ty::Choice(PARAMETERS)), EIGHT)
            .doc("What is scaled, by the name of its randomization."),
        COMMAND,
        TIME_LIMIT,
        POLICY,
        TERRAIN,
        Param::default("perturbation", Ty::Quantity(Dimension::ANGLE), "\"0 rad\"")
            .range(0.0, 1.0)
            .doc("Standard deviation of the joint positions about the default pose at the start."),
        SEED,
        ENGINE,
        RATE,
        CONTACT_TIME,
    ],
    needs: &[],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::randomize;

    #[test]
    fn every_randomization_with_a_scale_is_a_parameter_and_no_other() {
        let scaled = randomize::KINDS.iter().filter(|row| row.kind.params.iter().any(|param| param.name == "scale"));
        assert_eq!(scaled.map(|row| row.kind.name).collect::<Vec<_>>(), PARAMETERS);
    }
}
