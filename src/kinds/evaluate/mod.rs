//! Evaluation protocols. What they do stands in `evaluate/`.

pub mod episodes;
pub mod parameter_sets;
pub mod speeds;

use super::fine_tune::Trained;
use super::physics::EngineName;
use super::randomize::Rows;
use super::terrain::Ground;
use crate::spec::Section;
use crate::spec::typed::prelude::*;

section! {
    /// What a policy is put through.
    pub enum Evaluation in "evaluate", "evaluation" {
        episodes: Episodes, parameter_sets: ParameterSets, speeds: Speeds
    }
}

/// Episodes where a table, such as that of a transfer, does not say how many.
pub const EPISODES: u64 = 32;

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
    /// What is commanded for the whole of every episode.
    pub struct Command {
        /// Forward speed, held for the whole episode.
        #[range(-10.0, 10.0)]
        speed: Quantified<MetrePerSecond>,
    }
}

either! {
    /// What is drawn for every episode.
    pub enum Drawn {
        /// What the training draws, or nothing.
        AsTrained(bool),
        /// The rows of a table of its own.
        Rows(RawTerms<Rows>),
    }
}

keys! {
    /// Where and on which policy an evaluation runs.
    pub struct Setting in "evaluate" {
        /// Duration of an episode that nothing ends; without it `task.episode`.
        #[range(0.1, 3600.0)]
        time_limit: Option<Quantified<Second>>,
        /// Which policy: that of `[learn]` (`learner`) or that of `[fine_tune]`, each in the world that it
        /// was trained in. Without it the last one.
        policy: Option<Trained>,
        /// The ground of this evaluation, in place of the training's.
        terrain: Option<RawKind<Ground>>,
        /// Names the streams of all episodes; training uses others.
        #[default("1000")]
        seed: u64,
        /// The engine to run in; without it that of the training.
        engine: Option<EngineName>,
        /// Physics rate; without it that of the training. The rates of control must divide it.
        #[range(1.0, 1e6)]
        rate: Option<Quantified<Hertz>>,
        /// Time constant of soft contacts (MuJoCo's `solref`); without it the engine's own.
        #[range(1e-4, 1.0)]
        contact_time: Option<Quantified<Second>>,
    }
}

keys! {
    /// By what the episodes of an evaluation differ.
    pub struct Spread in "evaluate" {
        /// Standard deviation of the joint positions about the default pose at the start.
        #[range(0.0, 1.0)]
        #[default("\"0.01 rad\"")]
        perturbation: Quantified<Radian>,
        /// What is drawn per episode: nothing, with `true` the training's randomization, or the rows of a
        /// table.
        #[default("false")]
        randomize: Drawn,
        /// Whether the observation carries its noise.
        #[default("false")]
        noise: bool,
        /// Whether the policy acts with the exploration of its training (`action.std`), not by its mean
        /// alone.
        explore: Option<bool>,
    }
}

pub use episodes::Episodes;
pub use parameter_sets::ParameterSets;
pub use speeds::Speeds;
