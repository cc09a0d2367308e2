//! Normalizes spellings with the same result, so that a recipe has only one of them and rewriting a spec
//! invalidates no stage.

use serde_json::Value as Json;

use super::defaults;
use crate::kinds::action::position::{Feedback, Position, Span, Targets};
use crate::kinds::action::{Action, PhaseAction};
use crate::kinds::fine_tune::FineTuning;
use crate::kinds::learn::Learner;
use crate::kinds::learn::ppo::{Backend, Device, Ppo, TimeLimit};
use crate::spec::Table;
use crate::spec::typed::{InSection, section_mut};
use crate::spec::value::canonical_table;

/// Keys that affect no result: section, key.
const IDLE: &[(&str, &str)] = &[(Ppo::SECTION, Ppo::checkpoint_every.name)];

/// Values that are equivalent to a missing key: section, key, value.
const IMPLIED: &[(&str, &str, &str)] = &[
    (Action::SECTION, Position::feedback.name, Feedback::True.word()),
    (Action::SECTION, Position::phase_action.name, PhaseAction::Time.word()),
    (Action::SECTION, Position::shares_of.name, Span::JointRanges.word()),
    (Action::SECTION, Position::targets.name, Targets::JointLimits.word()),
    (Learner::SECTION, Ppo::backend.name, Backend::Native.word()),
    (Learner::SECTION, Ppo::device.name, Device::Cpu.word()),
    (Learner::SECTION, Ppo::time_limit.name, TimeLimit::Bootstrap.word()),
];

/// The fields of a stage's recipe: canonical, without what affects no result.
pub fn fields(fields: &Table) -> Json {
    stripped(&canonical_table(fields))
}

/// Canonical fields of any version, without what affects no result.
pub fn stripped(fields: &Json) -> Json {
    let mut fields = fields.clone();
    let mut drop_if = |section: &str, key: &str, idle: &dyn Fn(&Json) -> bool| {
        let table = fields.get_mut(section).and_then(Json::as_object_mut);
        if let Some(table) = table.filter(|table| table.get(key).is_some_and(idle)) {
            table.shift_remove(key);
        }
    };
    IDLE.iter().for_each(|(section, key)| drop_if(section, key, &|_| true));
    IMPLIED.iter().for_each(|(section, key, implied)| drop_if(section, key, &|value| value == implied));
    strip_idle_stop(&mut fields);
    defaults::strip(&mut fields);
    fields
}

/// Removes from the fields of a spec what another key overrides. Recipes keep it, so this compares specs only.
pub fn remove_overridden(fields: &mut Table) {
    let Some(learn) = section_mut::<Learner>(fields) else { return };
    if learn.contains_key(Ppo::discount_time.name) {
        learn.remove(Ppo::gamma.name);
    }
}

/// Removes an early stop without effect: one at or after the end, and that of the first training from a
/// fine-tuning.
fn strip_idle_stop(fields: &mut Json) {
    let is_fine_tuning = fields.get(FineTuning::SECTION).is_some();
    let Some(learn) = fields.get_mut(Learner::SECTION).and_then(Json::as_object_mut) else { return };
    let count = |key: &str| learn.get(key).and_then(Json::as_f64);
    let (Some(stop), Some(samples)) = (count(Ppo::stop_at.name), count(Ppo::samples.name)) else { return };
    if is_fine_tuning || stop >= samples {
        learn.shift_remove(Ppo::stop_at.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Value;

    fn learn<const N: usize>(entries: [(&str, Value); N]) -> Json {
        let learn = entries.map(|(key, value)| (key.to_owned(), value));
        fields(&Table::from([("learn".to_owned(), Value::Table(learn.into()))]))
    }

    #[test]
    fn how_often_a_checkpoint_is_written_and_the_backend_and_device_that_are_meant_anyway_change_no_recipe() {
        let usual = learn([]);
        assert_eq!(learn([("checkpoint_every", Value::Count(10))]), usual);
        assert_eq!(
            learn([("checkpoint_every", Value::Count(1)), ("device", Value::Text("cpu".into()))]),
            usual
        );
        let samples = ("samples", Value::Count(1000));
        let stop = |at: u64| ("stop_at", Value::Count(at));
        assert_eq!(learn([samples.clone(), stop(1000)]), learn([samples.clone()]), "it stops at the end");
        assert_ne!(learn([samples.clone(), stop(999)]), learn([samples]));
        let other = learn([("device", Value::Text("cuda".into()))]);
        assert_ne!(other, usual, "another device makes another policy");
        assert_eq!(learn([("backend", Value::Text("native".into()))]), usual);
        let other = learn([("backend", Value::Text("torch".into()))]);
        assert_ne!(other, usual, "another backend makes another policy");
    }
}
