//! Tasks: what the robot is asked to do, for how long and how fast.

mod meaning;
pub mod run;
pub mod squat;
pub mod stand;
pub mod walk;

pub use meaning::{Bound, Criterion, Evidence, Meaning};
pub use walk::Walk;

use crate::spec::typed::prelude::*;
use crate::spec::{Kind, Kinds, Section};

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

/// The keys of a task as the rest of the program reads them.
pub trait Goal {
    /// The name of the reference motion; none for standing without one.
    fn motion(&self) -> Option<&str>;
    /// Time limit of an episode in s.
    fn episode(&self) -> f64;
    /// The commanded speed, where one is commanded.
    fn command(&self) -> Option<&Command>;
}

/// An entry of the task registry.
pub struct TaskKind {
    /// What may be written.
    pub kind: &'static Kind,
    /// What it asks of a policy.
    pub meaning: &'static Meaning,
    read: fn(Section) -> Option<Box<dyn Goal>>,
}

impl TaskKind {
    const fn of<Task: Declared + Goal + 'static>(meaning: &'static Meaning) -> Self {
        let read =
            |section: Section| -> Option<Box<dyn Goal>> { Some(Box::new(Task::of_table(section.table())?)) };
        Self { kind: Task::KIND, meaning, read }
    }
}

/// Every task, sorted by name.
pub static KINDS: &[&TaskKind] = &[
    &TaskKind::of::<run::Run>(&run::MEANING),
    &TaskKind::of::<squat::Squat>(&squat::MEANING),
    &TaskKind::of::<stand::Stand>(&stand::MEANING),
    &TaskKind::of::<walk::Walk>(&walk::MEANING),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

/// What the task of this name asks of a policy.
pub fn meaning(task: &str) -> Option<&'static Meaning> {
    KINDS.iter().find(|entry| entry.kind.name == task).map(|entry| entry.meaning)
}

/// What the robot is asked to do: the section `[task]`.
pub struct Task {
    kind: &'static Kind,
    goal: Box<dyn Goal>,
}

impl std::ops::Deref for Task {
    type Target = dyn Goal;
    fn deref(&self) -> &Self::Target {
        &*self.goal
    }
}

impl HasKinds for Task {
    const KINDS: Kinds = Kinds { section: "task", noun: "task", all: kinds };
}

impl SectionKinds for Task {}

impl Part for Task {
    fn of_section(section: Section) -> Option<Self> {
        let word = section.kind()?;
        let entry = KINDS.iter().find(|entry| entry.kind.name == word)?;
        (entry.read)(section).map(|goal| Self { kind: entry.kind, goal })
    }
}

impl Task {
    /// The word of its kind in a spec.
    pub fn kind(&self) -> &'static str {
        self.kind.name
    }

    /// The name of the reference motion of a decoded spec or of a part of it; `None` where there is none.
    pub fn named_motion(fields: Section) -> Option<String> {
        fields.at(walk::Walk::motion)
    }

    /// The commanded speed of a decoded spec or of a part of it; `None` where none is commanded.
    pub fn commanded(fields: Section) -> Option<Command> {
        fields.at(walk::Walk::command)
    }

    /// What the task of a decoded spec asks of a policy; `None` where it has none.
    pub fn meaning_in(fields: Section) -> Option<&'static Meaning> {
        meaning(fields.within::<Self>()?.kind()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::metric;

    #[test]
    fn every_task_is_judged_by_metrics_of_episodes() {
        for TaskKind { kind, meaning, .. } in KINDS {
            let criteria = meaning.criteria.iter().map(|criterion| criterion.metric);
            for name in criteria.chain([meaning.evidence.metric]).chain(meaning.evidence.second_half) {
                assert!(metric::find(name).is_some(), "{}: {name}", kind.name);
            }
        }
    }
}
