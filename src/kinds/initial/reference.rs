//! The initial state `reference`: reference-state initialisation.

use super::STANDING_NOISE;
use crate::quantity::Dimension;
use crate::spec::{Edition, Kind, Param, Signal, Ty};

/// The registry entry.
pub static KIND: Kind = Kind {
    name: "reference",
    since: Edition::ONE,
    doc: include_str!("reference.md"),
    params: &[
        Param::default("standing_share", Ty::Ratio("all episodes"), "\"20 %\"")
            .range(0.0, 1.0)
            .doc("Share of the episodes that start in the default pose at rest."),
        Param::default("phases", Ty::List(&Ty::Number), "[0.0, 0.5]")
            .range(0.0, 1.0)
            .doc("Phases of those standing starts, drawn with equal chance; evaluations, which all stand, take them in turn."),
        STANDING_NOISE,
        Param::optional("velocities", Ty::Choice(&["reference", "rest"])).doc(
            "What the robot moves with: the reference's velocities, which is also what is meant without this key, or none, \
             but for the noise below.",
        ),
        Param::default("position_noise", Ty::Sampler(Dimension::ANGLE), "{ normal = [\"0 rad\", \"0.02 rad\"] }")
            .range(-3.2, 3.2)
            .doc("Added to each joint position."),
        Param::default(
            "velocity_noise",
            Ty::Sampler(Dimension::ANGULAR_VELOCITY),
            "{ normal = [\"0 rad/s\", \"0.1 rad/s\"] }",
        )
        .range(-100.0, 100.0)
        .doc("Added to each joint velocity."),
        Param::default(
            "base_velocity_noise",
            Ty::Sampler(Dimension::VELOCITY),
            "{ normal = [\"0 m/s\", \"0.04 m/s\"] }",
        )
        .range(-10.0, 10.0)
        .doc("Added to each component of the base velocity."),
        Param::default(
            "base_rate_noise",
            Ty::Sampler(Dimension::ANGULAR_VELOCITY),
            "{ normal = [\"0 rad/s\", \"0.04 rad/s\"] }",
        )
        .range(-100.0, 100.0)
        .doc("Added to each component of the base's angular velocity."),
    ],
    needs: &[Signal::Reference],
};
