//! The list of engines, and what a spec can know of each without its library.

use std::sync::Arc;

use super::engine::Engine;
use super::error::EngineError;
use crate::spec::typed::prelude::*;

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
    /// The same on a height field with cells of 10 cm (TOCABI).
    pub field_step_us: f64,
    /// Whether a contact's time constant is at least two physics steps (E0521).
    pub contacts_take_two_steps: bool,
    /// Whether light feet sink into contacts that `contact_time` has softened (W0507).
    pub soft_contacts_sink: bool,
    /// Whether it gives a shape one contact with each prism of a height field (W0527).
    pub touches_cells_in_points: bool,
    /// What to do where its library is missing (R0005).
    pub cure: &'static str,
}

/// What to do about an engine that is compiled in but cannot be used, or that a build lacks.
const ASK_THE_DOCTOR: &str = "`specforge doctor` says what is missing";

/// Declares the engines: the word in a spec, the feature of the build, the function that opens it, its facts.
macro_rules! engines {
    ($(
        $(#[$about:meta])*
        $variant:ident = $word:literal, feature = $feature:literal, open = $open:expr, facts = $facts:expr;
    )*) => {
        choice! {
            /// A physics engine, by its name in specs.
            pub enum EngineName { $( $(#[$about])* $variant = $word, )* }
        }

        impl EngineName {
            /// Static facts about the engine.
            pub const fn facts(self) -> &'static EngineFacts {
                match self { $( Self::$variant => const { &$facts }, )* }
            }

            /// The engine, or R0005 if this build or machine lacks it.
            pub fn open(self) -> Result<Arc<dyn Engine>, EngineError> {
                match self { $(
                    #[cfg(feature = $feature)]
                    Self::$variant => Ok(Arc::new($open?)),
                    #[cfg(not(feature = $feature))]
                    Self::$variant => Err(EngineError::LibraryMissing {
                        engine: $word,
                        reason: concat!("this build lacks the feature `", $feature, "`").to_owned(),
                    }),
                )* }
            }
        }
    };
}

engines! {
    /// rapier
    Rapier = "rapier",
        feature = "rapier",
        open = Ok::<_, EngineError>(super::rapier::Rapier),
        facts = EngineFacts {
            summary: "rapier's multibody joints: stiff contacts, pure Rust",
            contacts: "impacts end within a step; `contact_time` softens them in proportion to the mass \
                of the foot",
            numbers: "rapier 0.36.1, f32",
            step_us: 55.5,
            field_step_us: 87.0,
            contacts_take_two_steps: false,
            soft_contacts_sink: true,
            touches_cells_in_points: false,
            cure: ASK_THE_DOCTOR,
        };
    /// MuJoCo
    Mujoco = "mujoco",
        feature = "mujoco",
        open = super::mujoco::Mujoco::new(),
        facts = EngineFacts {
            summary: "the MuJoCo library: soft contacts, the paper's engine",
            contacts: "time constant of 20 ms, or `contact_time`; two physics steps if that is longer",
            numbers: "mujoco 3.17.0, f64, figures in a compiled geometry",
            step_us: 29.0,
            field_step_us: 85.0,
            contacts_take_two_steps: true,
            soft_contacts_sink: false,
            touches_cells_in_points: true,
            cure: if cfg!(feature = "mujoco") {
                "fetch it with `make native` in specforge's folder, or name the library's file in the \
                 variable SPECFORGE_MUJOCO; `specforge doctor` says what is missing"
            } else {
                ASK_THE_DOCTOR
            },
        };
    /// specforge's own engine, which steps many robots at once.
    Batch = "batch",
        feature = "batch",
        open = Ok::<_, EngineError>(super::batch::Batch::default()),
        facts = EngineFacts {
            summary: "MuJoCo's model in Rust, many worlds in each instruction: the fastest for training",
            contacts: "time constant of 20 ms, or `contact_time`, of at least two physics steps (E0521)",
            numbers: "batch 2, f64",
            step_us: 2.5,
            field_step_us: 21.0,
            contacts_take_two_steps: true,
            soft_contacts_sink: false,
            touches_cells_in_points: true,
            cure: ASK_THE_DOCTOR,
        };
}
