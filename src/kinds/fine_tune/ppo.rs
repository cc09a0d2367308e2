//! What may be written in `[fine_tune]` of kind `ppo`. `learn::Settings` reads it.

use crate::kinds::learn::ppo::LEARNING_RATE;
use crate::kinds::physics::EngineName;
use crate::kinds::terrain::Ground;
use crate::spec::typed::{HasKinds, Typed};
use crate::spec::{Edition, Kind, Param, Ty};

/// PPO that goes on from actor and critic.
pub const PPO: Kind = Kind {
    name: "ppo",
    since: Edition::ONE,
    doc: include_str!("ppo.md"),
    params: &[
        Param::required("samples", Ty::Count)
            .doc("Control steps to learn from, over all environments, beside those of `learn.samples`.")
            .range(1.0, 1e12),
        Param::required("terrain", Ty::Kind(Ground::KINDS)).doc("The ground to learn on, in place of `[terrain]`."),
        Param::optional("learning_rate", LEARNING_RATE)
            .doc("Adam's step size of the actor; without it `learn.learning_rate`, which begins anew.")
            .range(0.0, 1.0),
        Param::optional("warm_up", Ty::Count)
            .range(0.0, 1e9)
            .doc("First updates in which only the critic learns; without it `learn.warm_up`."),
        Param::optional("engine", EngineName::TY)
            .doc("The physics engine to learn in, at the rates of the training; without it `physics.engine`."),
        Param::optional("std", Ty::Ratio("what `action.std` is a share of"))
            .range(1e-6, 10.0)
            .doc("Standard deviation of the exploration noise; without it `action.std`."),
        Param::optional("weights", Ty::Named(&Ty::Number))
            .range(-1e6, 1e6)
            .doc("Weights of reward terms, by the name of the term; the other terms keep that of `[reward]`."),
    ],
    needs: &[],
};
