//! W0507: soft contacts in rapier.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::physics::Physics;

/// Only MuJoCo uses `contact_time`.
pub fn soft_contacts_are_mujocos(subject: &Subject, sink: &mut Sink) {
    for (path, table) in subject.protocols() {
        let key = Setting::contact_time.below(&path);
        let engine = table.value(Setting::engine).or_else(|| subject.at(Physics::engine));
        let sinks = engine.is_some_and(|engine| engine.facts().soft_contacts_sink);
        if !table.holds(Setting::contact_time) || !sinks {
            continue;
        }
        let time = subject.written(&key);
        let mut diagnostic =
            Diagnostic::warning("W0507", format!("`{key}` softens the contacts of rapier to {time}"));
        if let Some(place) = subject.place(&key) {
            diagnostic = diagnostic.at(place, "rapier's soft contacts do not support light feet");
        }
        sink.emit(diagnostic.help("remove it; to match the engines, make MuJoCo's contacts stiffer"));
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn codes(engine: &str, own: &str) -> Vec<&'static str> {
        let text = format!(
            "[physics]\nengine = \"{engine}\"\n[evaluate.soft]\nkind = \"episodes\"\n{own}contact_time = 0.01"
        );
        found(soft_contacts_are_mujocos, &text, None).iter().map(|found| found.code).collect()
    }

    #[test]
    fn the_engine_is_that_of_the_evaluation_or_else_of_the_training() {
        assert_eq!(codes("rapier", ""), ["W0507"]);
        assert_eq!(codes("mujoco", "engine = \"rapier\"\n"), ["W0507"]);
        assert!(codes("mujoco", "").is_empty() && codes("rapier", "engine = \"mujoco\"\n").is_empty());
        assert_eq!(
            found(
                soft_contacts_are_mujocos,
                "[physics]\nengine = \"rapier\"\n[evaluate.a]\nepisodes = 3",
                None
            ),
            []
        );
    }
}
