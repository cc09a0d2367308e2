//! Evaluation protocols. `evaluate/` implements them.

pub mod episodes;
mod last_push;
pub mod parameter_sets;
pub mod speeds;

use super::fine_tune::Trained;
use super::randomize::Rows;
use super::terrain::Ground;
use crate::sim::EngineName;
use crate::spec::Section;
use crate::spec::marks::below;
use crate::spec::typed::prelude::*;

/// The name of the evaluation that a transfer takes missing keys from.
pub const NOMINAL: &str = "nominal";

/// The path of its table.
pub fn nominal() -> String {
    below(Evaluation::SECTION, NOMINAL)
}

section! {
    /// Protocol of an evaluation.
    pub enum Evaluation in "evaluate", "evaluation" {
        episodes: Episodes, parameter_sets: ParameterSets, speeds: Speeds
    }
}

/// Default number of episodes.
pub const EPISODES: u64 = 32;

/// Default seed of the random streams of all episodes.
pub const SEED: u64 = 1000;

/// The number of episodes of a decoded `[evaluate.NAME]` table, or of a `[deploy.NAME]` table of kind
/// `transfer`.
pub fn episodes(section: Section) -> usize {
    match Evaluation::of_section(section) {
        Some(Evaluation::Speeds(speeds)) => speeds.grid().len() * speeds.repeats as usize,
        Some(Evaluation::ParameterSets(sets)) => sets.sets as usize,
        Some(Evaluation::Episodes(protocol)) => protocol.episodes as usize,
        None => section.value(Episodes::episodes).unwrap_or(EPISODES) as usize,
    }
}

keys! {
    /// A constant command.
    pub struct Command {
        /// Forward speed for the whole episode.
        #[range(-10.0, 10.0)]
        speed: Quantified<MetrePerSecond>,
    }
}

either! {
    /// Randomization per episode.
    pub enum Drawn {
        /// The training's randomization, or none.
        AsTrained(bool),
        /// The rows of a separate table.
        Rows(RawTerms<Rows>),
    }
}

keys! {
    /// Environment and policy of an evaluation.
    pub struct Setting in "evaluate" {
        /// Time limit of an episode; by default `task.episode`.
        #[range(0.1, 3600.0)]
        time_limit: Option<Quantified<Second>>,
        /// The policy: that of `[learn]` (`learner`) or of `[fine_tune]` (default if the spec has one), each
        /// in its training environment.
        policy: Option<Trained>,
        /// The ground of this evaluation; by default the training's.
        terrain: Option<RawKind<Ground>>,
        /// Seed of the random streams of all episodes; independent of the training's streams.
        #[default("1000")]
        seed: u64,
        /// The engine; by default the training's.
        engine: Option<EngineName>,
        /// Physics rate; by default the training's. The rates of control must divide it.
        #[range(1.0, 1e6)]
        rate: Option<Quantified<Hertz>>,
        /// Time constant of soft contacts (MuJoCo's `solref`); by default the engine's.
        #[range(1e-4, 1.0)]
        contact_time: Option<Quantified<Second>>,
    }
}

keys! {
    /// Differences between the episodes of an evaluation.
    pub struct Spread in "evaluate" {
        /// Standard deviation of the joint positions around the default pose at the start.
        #[range(0.0, 1.0)]
        #[default("\"0.01 rad\"")]
        perturbation: Quantified<Radian>,
        /// Randomization per episode: none, the training's (`true`), or the rows of a table.
        #[default("false")]
        randomize: Drawn,
        /// Whether the observation is noisy.
        #[default("false")]
        noise: bool,
        /// Whether the policy acts with the exploration of its training (`action.std`) rather than by its
        /// mean.
        explore: Option<bool>,
    }
}

pub use episodes::Episodes;
pub use last_push::last_push;
pub use parameter_sets::ParameterSets;
pub use speeds::Speeds;
