//! E0521: contact time constants under two physics steps, which MuJoCo and the batch engine would raise.

use super::subject::duration;
use super::{Subject, rates};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::physics::Physics;
use crate::sim::EngineName;
use crate::spec::typed::InSection;

/// Default time constant of contacts in s.
const CONTACT_TIME: f64 = 0.02;

/// A contact's time constant is at least two physics steps.
pub fn contacts_are_slower_than_steps(subject: &Subject, sink: &mut Sink) {
    for (path, engine) in subject.tables_with_engines() {
        contact_is_slower_than_steps(subject, &path, engine, true, sink);
    }
}

/// The same in the table at this path, which runs in this engine; with `is_spec` its contacts can be
/// softened.
pub(super) fn contact_is_slower_than_steps(
    subject: &Subject,
    path: &str,
    engine: EngineName,
    is_spec: bool,
    sink: &mut Sink,
) {
    let key = Setting::contact_time.below(path);
    let own_rate = Setting::rate.below(path);
    let own = subject.number(&key);
    let rate = subject.number(&own_rate).or_else(|| subject.at(Physics::rate));
    let Some(step) = rate.filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate) else { return };
    let time = own.unwrap_or(CONTACT_TIME);
    if !engine.facts().contacts_take_two_steps || time >= 2.0 * step * (1.0 - 1e-9) {
        return;
    }
    // If the rate is inherited from the training, report it once, there.
    let has_rate = path == Physics::SECTION || subject.number(&own_rate).is_some();
    if own.is_none() && !has_rate {
        return;
    }
    let message = format!(
        "in engine `{}` contacts with a time constant of {} need a physics rate of {} Hz or more",
        engine.word(),
        duration(time),
        whole_hertz(time)
    );
    let mut diagnostic = Diagnostic::error("E0521", message);
    let at = if own.is_some() { key } else { own_rate.clone() };
    if let Some(place) = subject.place(&at) {
        diagnostic = diagnostic.at(place, "physics step too long");
    }
    let key = if subject.number(&own_rate).is_some() { own_rate } else { Physics::rate.path() };
    let fitting = rates::from(subject, &key, 2.0 / time).map(|rate| format!("raise `{key}` to {rate} Hz"));
    let slower = is_spec.then(|| format!("use a `contact_time` of {} or more", duration(2.0 * step)));
    let fixes: Vec<String> = fitting.into_iter().chain(slower).collect();
    sink.emit(diagnostic.help(fixes.join(", or ")));
}

/// The lowest whole rate in Hz at which a time constant in s spans two steps.
fn whole_hertz(time: f64) -> f64 {
    libm::ceil(2.0 / time * (1.0 - 1e-9))
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn a_contact_within_two_steps_is_e0521() {
        let codes = |text: &str| -> Vec<&'static str> {
            found(contacts_are_slower_than_steps, text, None).iter().map(|found| found.code).collect()
        };
        let spec = |engine: &str, rate: f64, more: &str| {
            format!("[physics]\nengine = \"{engine}\"\nrate = {rate:?}\n{more}")
        };
        assert_eq!(codes(&spec("batch", 90.0, "")), ["E0521"]);
        assert!(codes(&spec("batch", 100.0, "")).is_empty());
        let stiff = "[evaluate.stiff]\nepisodes = 2\ncontact_time = 0.003\n";
        assert_eq!(codes(&spec("batch", 500.0, stiff)), ["E0521"]);
        assert!(codes(&spec("batch", 1000.0, stiff)).is_empty());
        assert_eq!(codes(&spec("mujoco", 500.0, stiff)), ["E0521"]);
        assert!(codes(&spec("rapier", 500.0, stiff)).is_empty());
        // Reported once, where the rate is set.
        assert_eq!(codes(&spec("batch", 50.0, "[evaluate.nominal]\nepisodes = 2\n")), ["E0521"]);
    }

    #[test]
    fn the_rate_that_is_offered_fits_the_policys() {
        let text = "physics = { engine = \"batch\", rate = 500.0 }\naction = { rate = 125.0 }\n\
                    evaluate.stiff = { episodes = 2, contact_time = 0.0039 }";
        let found = found(contacts_are_slower_than_steps, text, None);
        assert_eq!(
            found[0].help,
            ["raise `physics.rate` to 625 Hz, or use a `contact_time` of 4 ms or more"]
        );
    }
}
