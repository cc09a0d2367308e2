//! W0507: soft contacts in an engine whose soft contacts do not support light feet.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::physics::Physics;

/// `contact_time` is set only for engines in which light feet stand on soft contacts.
pub fn soft_contacts_support_the_feet(subject: &Subject, sink: &mut Sink) {
    for (path, table) in subject.protocols() {
        let key = Setting::contact_time.below(&path);
        let Some(engine) = table.value(Setting::engine).or_else(|| subject.at(Physics::engine)) else {
            continue;
        };
        if !table.holds(Setting::contact_time) || !engine.facts().soft_contacts_sink {
            continue;
        }
        let engine = engine.word();
        let time = subject.written(&key);
        let mut diagnostic =
            Diagnostic::warning("W0507", format!("`{key}` softens the contacts of {engine} to {time}"));
        if let Some(place) = subject.place(&key) {
            diagnostic = diagnostic.at(place, format!("{engine}'s soft contacts do not support light feet"));
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
        found(soft_contacts_support_the_feet, &text, None).iter().map(|found| found.code).collect()
    }

    #[test]
    fn the_engine_is_that_of_the_evaluation_or_else_of_the_training() {
        assert_eq!(codes("rapier", ""), ["W0507"]);
        assert_eq!(codes("mujoco", "engine = \"rapier\"\n"), ["W0507"]);
        assert!(codes("mujoco", "").is_empty() && codes("rapier", "engine = \"mujoco\"\n").is_empty());
        assert_eq!(
            found(
                soft_contacts_support_the_feet,
                "[physics]\nengine = \"rapier\"\n[evaluate.a]\nepisodes = 3",
                None
            ),
            []
        );
    }
}
