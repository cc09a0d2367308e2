//! Tasks: what the robot is asked to do, for how long and how fast.

pub mod run;
pub mod squat;
pub mod stand;
pub mod walk;

use crate::spec::Section;
use crate::spec::typed::prelude::*;

section! {
    /// What the robot is asked to do.
    pub enum Task in "task", "task" { run: Run, squat: Squat, stand: Stand, walk: Walk }
}

keys! {
    /// A commanded speed.
    pub struct Command {
        /// Commanded forward speed.
        #[range(-10.0, 10.0)]
        speed: Sampled<MetrePerSecond>,
        /// Time between two draws of the speed; without it one draw holds for the episode.
        #[range(1e-3, 1e6)]
        every: Option<Quantified<Second>>,
        /// Time over which a new speed is approached linearly.
        #[range(0.0, 1e6)]
        #[default("\"0 s\"")]
        ramp: Quantified<Second>,
    }
}

impl Task {
    /// The name of the reference motion of a decoded spec or of a part of it; `None` where there is none.
    pub fn named_motion(fields: Section) -> Option<String> {
        fields.within::<Self>()?.value(walk::Walk::motion)
    }

    /// The commanded speed of a decoded spec or of a part of it; `None` where none is commanded.
    pub fn commanded(fields: Section) -> Option<Command> {
        fields.within::<Self>()?.value(walk::Walk::command)
    }

    /// The name of the reference motion; none for standing without one.
    pub fn motion(&self) -> Option<&str> {
        match self {
            Self::Run(run) => Some(&run.motion),
            Self::Squat(squat) => Some(&squat.motion),
            Self::Stand(stand) => stand.motion.as_deref(),
            Self::Walk(walk) => Some(&walk.motion),
        }
    }

    /// Time limit of an episode in s.
    pub fn episode(&self) -> f64 {
        match self {
            Self::Run(run) => run.episode,
            Self::Squat(squat) => squat.episode,
            Self::Stand(stand) => stand.episode,
            Self::Walk(walk) => walk.episode,
        }
    }

    /// The commanded speed, where one is commanded.
    pub fn command(&self) -> Option<&Command> {
        match self {
            Self::Run(run) => Some(&run.command),
            Self::Squat(squat) => squat.command.as_ref(),
            Self::Stand(stand) => stand.command.as_ref(),
            Self::Walk(walk) => Some(&walk.command),
        }
    }
}
