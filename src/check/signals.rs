//! E0303: the signals that a term reads exist in this experiment.

use std::collections::BTreeMap;

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds;
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::{Episodes, Evaluation, Speeds};
use crate::kinds::initial::Initial;
use crate::kinds::observe::Observations;
use crate::kinds::pretrain::Pretraining;
use crate::kinds::reward::Rewards;
use crate::kinds::task::{Task, Walk};
use crate::kinds::terminate::Terminations;
use crate::spec::suggest::listed;
use crate::spec::typed::InSection;
use crate::spec::{Kind, Signal};

/// Terms that read a motion or a command have one, and commanded speeds are set only where something tracks
/// them.
pub fn terms_find_their_signals(subject: &Subject, sink: &mut Sink) {
    if subject.spec().within::<Task>().is_none() {
        return;
    }
    let mut lacking: BTreeMap<String, Vec<(String, Signal)>> = BTreeMap::new();
    let mut look = |path: &str, registry: Vec<&'static Kind>| {
        let kind = subject.kind(path).and_then(|word| registry.iter().find(|kind| kind.name == word));
        if let Some((key, signal)) = kind.and_then(|kind| lacks(subject, kind)) {
            lacking.entry(key).or_default().push((path.to_owned(), signal));
        }
    };
    look(Initial::SECTION, kinds::initial::kinds());
    look(Pretraining::SECTION, kinds::pretrain::kinds());
    subject.terms::<Observations>().iter().for_each(|(path, _)| look(path, kinds::observe::kinds()));
    subject.terms::<Rewards>().iter().for_each(|(path, _)| look(path, kinds::reward::kinds()));
    subject.terms::<Terminations>().iter().for_each(|(path, _)| look(path, kinds::terminate::kinds()));
    let speeds = subject.protocols().into_iter().filter_map(|(path, table)| match table.is::<Speeds>() {
        true => Some(path),
        false => table.holds(Episodes::command).then(|| Episodes::command.below(&path)),
    });
    let command = Walk::command.path();
    if subject.value(&command).is_none() {
        let speeds: Vec<_> = speeds.map(|path| (path, Signal::CommandSpeed)).collect();
        lacking.entry(command).or_default().extend(speeds);
        lacking.retain(|_, readers| !readers.is_empty());
    }
    lacking.iter().for_each(|(key, readers)| sink.emit(missed(subject, key, readers)));
}

/// The first signal of a kind that this experiment lacks, and the key that would provide it.
fn lacks(subject: &Subject, kind: &Kind) -> Option<(String, Signal)> {
    kind.needs.iter().find_map(|signal| {
        let key = source(*signal)?;
        let is_there = subject.value(&key).is_some() || (key == Walk::motion.path() && stands(subject));
        (!is_there).then_some((key, *signal))
    })
}

/// Whether a task without a motion has the default pose as reference.
fn stands(subject: &Subject) -> bool {
    Task::meaning_in(subject.spec()).is_some_and(|task| task.default_pose)
}

/// A missing key, with all terms that read its signals: one cause is one error.
fn missed(subject: &Subject, key: &str, readers: &[(String, Signal)]) -> Diagnostic {
    let paths = || readers.iter().map(|(path, _)| path.as_str());
    let message = match readers {
        [(path, signal)] => format!("`{path}` needs {}, but `{key}` is missing", describe(*signal)),
        _ => format!("{} need `{key}`, which is missing", listed(paths())),
    };
    let mut diagnostic = Diagnostic::error("E0303", message);
    for (index, (path, signal)) in readers.iter().enumerate() {
        let Some(place) = subject.place(path) else { continue };
        let remark = format!("reads {}", describe(*signal));
        diagnostic = if index == 0 { diagnostic.at(place, remark) } else { diagnostic.note(place, remark) };
    }
    let word = key.rsplit('.').next().unwrap_or(key);
    if let Some(mark) = subject.marks.get(Task::SECTION) {
        diagnostic = diagnostic.note(mark.value, format!("without `{word}`"));
    }
    let example =
        if word == Walk::motion.name { "motion = \"walk\"" } else { "command = { speed = \"0.2 m/s\" }" };
    let protocols = [Evaluation::SECTION, Deployment::SECTION];
    let is_term = |path: &str| !path.split('.').next().is_some_and(|section| protocols.contains(&section));
    let drop = match (paths().all(is_term), readers.len()) {
        (true, 1) => "remove the term with `enabled = false`",
        (true, _) => "remove these terms with `enabled = false`",
        (false, 1) => "remove it",
        (false, _) => "remove them",
    };
    diagnostic.help(format!("add `{example}` to `[task]`, or {drop}"))
}

/// The key that provides a signal; `None` for signals that are always available.
fn source(signal: Signal) -> Option<String> {
    match signal {
        Signal::Reference | Signal::ContactSchedule | Signal::Phase => Some(Walk::motion.path()),
        Signal::CommandSpeed => Some(Walk::command.path()),
        Signal::BaseOrientation
        | Signal::BaseVelocity
        | Signal::BaseHeight
        | Signal::Joints
        | Signal::Torque
        | Signal::FootForce
        | Signal::BodyContact
        | Signal::SelfCollision
        | Signal::Obstacle => None,
    }
}

fn describe(signal: Signal) -> &'static str {
    match signal {
        Signal::BaseOrientation => "the orientation of the base",
        Signal::BaseVelocity => "the velocity of the base",
        Signal::BaseHeight => "the height of the base",
        Signal::Joints => "the joints",
        Signal::Torque => "the joint torques",
        Signal::FootForce => "the forces on the feet",
        Signal::BodyContact => "the contacts of the body",
        Signal::SelfCollision => "self-collisions",
        Signal::Reference => "a reference motion",
        Signal::ContactSchedule => "a contact schedule",
        Signal::Phase => "the phase of a motion",
        Signal::CommandSpeed => "a commanded speed",
        Signal::Obstacle => "an obstacle on the ground",
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn showing_a_command_that_there_is_not_is_e0303() {
        let terms =
            "[observe.speed]\nkind = \"command\"\n[reward.contact_schedule]\nkind = \"contact_schedule\"\n";
        let without = format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\n{terms}");
        let found_without = found(terms_find_their_signals, &without, None);
        assert_eq!(found_without.len(), 1);
        assert_eq!(
            (found_without[0].code, found_without[0].message.as_str()),
            ("E0303", "`observe.speed` needs a commanded speed, but `task.command` is missing")
        );
        let with =
            format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\ncommand = {{ speed = 0.2 }}\n{terms}");
        assert_eq!(found(terms_find_their_signals, &with, None), []);
    }

    #[test]
    fn a_speed_that_nothing_follows_is_e0303() {
        let text = "[task]\nkind = \"squat\"\nmotion = \"squat\"\n[evaluate.fast]\nkind = \
            \"episodes\"\ncommand = { speed = 0.2 }\n\
                    [evaluate.grid]\nkind = \"speeds\"\nspeeds = [0.1]\n[evaluate.nominal]\nkind = \
                    \"episodes\"\n";
        let missed = found(terms_find_their_signals, text, None);
        assert_eq!(missed.len(), 1);
        let message = "`evaluate.fast.command` and `evaluate.grid` need `task.command`, which is missing";
        assert_eq!((missed[0].code, missed[0].message.as_str()), ("E0303", message));
        let followed = text.replacen("motion =", "command = { speed = 0.1 }\nmotion =", 1);
        assert_eq!(found(terms_find_their_signals, &followed, None), []);
    }

    #[test]
    fn a_motion_that_several_terms_read_is_missed_once() {
        let text = "initial = { kind = \"reference\" }\n[task]\nkind = \"walk\"\n\
                    [terminate.contact_schedule]\nkind = \"contact_schedule\"\n[terminate.base_height]\nkind \
                    = \"base_height\"";
        let missed = found(terms_find_their_signals, text, None);
        assert_eq!(missed.len(), 1);
        assert_eq!(
            missed[0].message,
            "`initial` and `terminate.contact_schedule` need `task.motion`, which is missing"
        );
        let standing = found(terms_find_their_signals, &text.replace("walk", "stand"), None);
        assert_eq!(standing, [], "the default pose is the reference");
    }
}
