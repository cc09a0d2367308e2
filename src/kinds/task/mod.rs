//! Tasks: motion, duration and commanded speed.

mod long_enough;
mod meaning;
pub mod run;
pub mod squat;
pub mod stand;
pub mod walk;

pub use long_enough::{Judged, Shortest};
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
        /// Time between two draws of the speed; by default one draw holds for the episode.
        #[range(1e-3, 1e6)]
        every: Option<Quantified<Second>>,
        /// Duration of the linear transition to a new speed.
        #[range(0.0, 1e6)]
        #[default("\"0 s\"")]
        ramp: Quantified<Second>,
    }
}

/// The common interface of a task's keys.
pub trait Goal {
    /// The name of the reference motion; `None` for standing without one.
    fn motion(&self) -> Option<&str>;
    /// Time limit of an episode in s.
    fn episode(&self) -> f64;
    /// The commanded speed, if any.
    fn command(&self) -> Option<&Command>;
}

/// An entry of the task registry.
pub struct TaskKind {
    /// Its descriptor.
    pub kind: &'static Kind,
    /// Its properties.
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

/// The properties of the task with this name.
pub fn meaning(task: &str) -> Option<&'static Meaning> {
    KINDS.iter().find(|entry| entry.kind.name == task).map(|entry| entry.meaning)
}

/// The section `[task]`.
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
    /// Its kind in a spec.
    pub fn kind(&self) -> &'static str {
        self.kind.name
    }

    /// The name of the reference motion of a decoded spec or of a part of it, if any.
    pub fn named_motion(fields: Section) -> Option<String> {
        fields.at(walk::Walk::motion)
    }

    /// The commanded speed of a decoded spec or of a part of it, if any.
    pub fn commanded(fields: Section) -> Option<Command> {
        fields.at(walk::Walk::command)
    }

    /// The properties of a decoded spec's task, if it has one.
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
