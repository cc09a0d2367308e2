//! `[physics]`: the engine and its rate.

use crate::spec::typed::prelude::*;

choice! {
    /// A physics engine, by its name in specs.
    pub enum EngineName {
        /// rapier
        Rapier = "rapier",
        /// MuJoCo
        Mujoco = "mujoco",
        /// specforge's own engine, which steps many robots at once.
        Batch = "batch",
    }
}

keys! {
    /// `[physics]`
    pub struct Physics in "physics" {
        /// The physics engine of training and evaluation.
        engine: EngineName,
        /// Rate of the simulation's steps; `action.rate` and `action.servo_rate` must divide it.
        #[range(1.0, 1e6)]
        rate: Quantified<Hertz>,
    }
}

/// Static facts about an engine.
#[derive(Clone, Copy, Debug)]
pub struct EngineFacts {
    /// Description, and recommended use.
    pub summary: &'static str,
    /// Its contacts.
    pub contacts: &'static str,
    /// Identity of its numerics: part of the fingerprints.
    pub numbers: &'static str,
    /// CPU time in us of a physics step in a training's rollout, on one core (first table of trainings in
    /// docs/experiments/2026-11-26-batch-engine-speed.md); for estimates only.
    pub step_us: f64,
    /// Whether a contact's time constant is at least two physics steps (E0521).
    pub contacts_take_two_steps: bool,
}

impl EngineName {
    /// Static facts about the engine.
    pub const fn facts(self) -> &'static EngineFacts {
        match self {
            Self::Rapier => &EngineFacts {
                summary: "rapier's multibody joints: stiff contacts, pure Rust",
                contacts: "impacts end within a step; `contact_time` softens them in proportion to the mass \
                    of the foot",
                numbers: "rapier 0.36.1, f32",
                step_us: 55.5,
                contacts_take_two_steps: false,
            },
            Self::Mujoco => &EngineFacts {
                summary: "the MuJoCo library: soft contacts, the paper's engine",
                contacts: "time constant of 20 ms, or `contact_time`; two physics steps if that is longer",
                numbers: "mujoco 3.17.0, f64, figures in a compiled geometry",
                step_us: 29.0,
                contacts_take_two_steps: true,
            },
            Self::Batch => &EngineFacts {
                summary: "MuJoCo's model in Rust, many worlds in each instruction: the fastest for training",
                contacts: "time constant of 20 ms, or `contact_time`, of at least two physics steps (E0521)",
                numbers: "batch 2, f64",
                step_us: 2.5,
                contacts_take_two_steps: true,
            },
        }
    }
}
