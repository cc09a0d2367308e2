//! E0303: what a term reads of the world exists in this experiment.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds;
use crate::spec::{Kind, Signal};

/// Terms that read a motion have one, terms that read a command have one.
pub fn terms_find_their_signals(subject: &Subject, sink: &mut Sink) {
    if subject.section("task").is_none() {
        return;
    }
    let mut look = |path: &str, registry: &[&'static Kind]| {
        let kind = subject.kind(path).and_then(|word| registry.iter().find(|kind| kind.name == word));
        if let Some(diagnostic) = kind.and_then(|kind| lacking(subject, path, kind)) {
            sink.emit(diagnostic);
        }
    };
    look("initial", &kinds::initial::kinds());
    look("pretrain", &kinds::pretrain::kinds());
    for (section, registry) in [
        ("observe", kinds::observe::kinds()),
        ("reward", kinds::reward::kinds()),
        ("terminate", kinds::terminate::kinds()),
    ] {
        for (path, _) in subject.terms(section) {
            look(&path, &registry);
        }
    }
}

/// The first signal of a kind that this experiment lacks.
fn lacking(subject: &Subject, path: &str, kind: &Kind) -> Option<Diagnostic> {
    let (signal, key) = kind.needs.iter().find_map(|signal| {
        let key = source(*signal)?;
        subject.value(key).is_none().then_some((*signal, key))
    })?;
    let message = format!("`{path}` needs {}, but there is no `{key}`", describe(signal));
    let mut diagnostic = Diagnostic::error("E0303", message);
    if let Some(place) = subject.place(path) {
        diagnostic = diagnostic.at(place, format!("reads {}", describe(signal)));
    }
    if let Some(mark) = subject.marks.get("task") {
        diagnostic = diagnostic.note(mark.value, format!("without `{}`", key.trim_start_matches("task.")));
    }
    Some(diagnostic.help(format!("write `{key}`, or drop the term with `enabled = false`")))
}

/// The key that brings a signal; `None` for what every world has.
fn source(signal: Signal) -> Option<&'static str> {
    match signal {
        Signal::Reference | Signal::ContactSchedule | Signal::Phase => Some("task.motion"),
        Signal::CommandSpeed => Some("task.command"),
        Signal::BaseOrientation
        | Signal::BaseVelocity
        | Signal::BaseHeight
        | Signal::Joints
        | Signal::Torque
        | Signal::FootForce
        | Signal::BodyContact => None,
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
        Signal::Reference => "a reference motion",
        Signal::ContactSchedule => "a contact schedule",
        Signal::Phase => "the phase of a motion",
        Signal::CommandSpeed => "a commanded speed",
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn showing_a_command_that_there_is_not_is_e0303() {
        let terms = "[observe.speed]\nkind = \"command\"\n[reward.contact_schedule]\nkind = \"contact_schedule\"\n";
        let without = format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\n{terms}");
        let found_without = found(terms_find_their_signals, &without, None);
        assert_eq!(found_without.len(), 1);
        assert_eq!(
            (found_without[0].code, found_without[0].message.as_str()),
            ("E0303", "`observe.speed` needs a commanded speed, but there is no `task.command`")
        );
        let with = format!("[task]\nkind = \"walk\"\nmotion = \"walk\"\ncommand = {{ speed = 0.2 }}\n{terms}");
        assert_eq!(found(terms_find_their_signals, &with, None), []);
    }

    #[test]
    fn a_motion_is_missed_once_by_each_term_that_reads_it() {
        let text = "initial = { kind = \"reference\" }\n[task]\nkind = \"stand\"\n\
                    [terminate.contact_schedule]\nkind = \"contact_schedule\"\n[terminate.base_height]\nkind = \"base_height\"";
        assert_eq!(found(terms_find_their_signals, text, None).len(), 2);
    }
}
