//! Evaluation protocols. What they do stands in `evaluate/`.

pub mod episodes;
pub mod parameter_sets;
pub mod speeds;

use super::{randomize, terrain};
use crate::quantity::Dimension;
use crate::spec::{Kind, Kinds, Param, Section, Ty};

/// Every kind of this registry, sorted by name.
pub static KINDS: &[&Kind] = &[&episodes::KIND, &parameter_sets::KIND, &speeds::KIND];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.to_vec()
}

/// Episodes where a table, such as that of a transfer, does not say how many.
pub const EPISODES: u64 = 32;

/// The number of episodes of a decoded `[evaluate.NAME]` table, or of a `[deploy.NAME]` table of kind `transfer`.
pub fn episodes(section: Section) -> usize {
    let count = |key: &str, usual: u64| if section.has(key) { section.count(key) } else { usual } as usize;
    match section.text_if("kind") {
        Some("speeds") => speeds::grid(section).len() * count("repeats", 1),
        Some("parameter_sets") => count("sets", 0),
        _ => count("episodes", EPISODES),
    }
}

/// What is commanded for the whole of every episode.
pub const COMMAND: Param = Param::optional(
    "command",
    Ty::Table(&[Param::required("speed", Ty::Quantity(Dimension::VELOCITY))
        .range(-10.0, 10.0)
        .doc("Forward speed, held for the whole episode.")]),
)
.doc("The command of every episode; without it the middle of the task's range.");

/// How long an episode may last.
pub const TIME_LIMIT: Param = Param::optional("time_limit", Ty::Quantity(Dimension::TIME))
    .range(0.1, 3600.0)
    .doc("Duration of an episode that nothing ends; without it `task.episode`.");

/// The ground.
pub const TERRAIN: Param =
    Param::optional("terrain", Ty::Kind(Kinds { section: "terrain", noun: "terrain", all: terrain::kinds }))
        .doc("The ground of this evaluation, in place of the training's.");

/// What is drawn for every episode: a flag or a table of its own.
pub const DRAWN: Ty =
    Ty::OneOf(&[Ty::Flag, Ty::Terms(Kinds { section: "randomize", noun: "randomization", all: randomize::kinds })]);

/// Whether and by what episodes differ.
pub const RANDOMIZE: Param = Param::default("randomize", DRAWN, "false")
    .doc("What is drawn per episode: nothing, with `true` the training's randomization, or the rows of a table.");

/// How far apart the starts are.
pub const PERTURBATION: Param = Param::default("perturbation", Ty::Quantity(Dimension::ANGLE), "\"0.01 rad\"")
    .range(0.0, 1.0)
    .doc("Standard deviation of the joint positions about the default pose at the start.");

/// Noise of the encoders.
pub const NOISE: Param = Param::default("noise", Ty::Flag, "false").doc("Whether the observation carries its noise.");

/// The policy as it acts while it learns.
pub const EXPLORE: Param = Param::optional("explore", Ty::Flag)
    .doc("Whether the policy acts with the exploration of its training (`action.std`), not by its mean alone.");

/// The name of all that is random.
pub const SEED: Param =
    Param::default("seed", Ty::Count, "1000").doc("Names the streams of all episodes; training uses others.");

/// The engine.
pub const ENGINE: Param = Param::optional("engine", Ty::Choice(&["rapier", "mujoco", "batch"]))
    .doc("The engine to run in; without it that of the training.");

/// The physics rate.
pub const RATE: Param = Param::optional("rate", Ty::Quantity(Dimension::RATE))
    .range(1.0, 1e6)
    .doc("Physics rate; without it that of the training. The rates of control must divide it.");

/// How soft contacts are.
pub const CONTACT_TIME: Param = Param::optional("contact_time", Ty::Quantity(Dimension::TIME))
    .range(1e-4, 1.0)
    .doc("Time constant of soft contacts (MuJoCo's `solref`); without it the engine's own.");
