//! E0501: the rates at which policy and servo act are whole fractions of the physics rate, and the policy's of the servo's.

use super::Subject;
use super::subject::{short, whole};
use crate::diag::{Diagnostic, Sink};

/// `action.rate` and `action.servo_rate` divide `physics.rate` and the rate of every evaluation and transfer; the policy's rate
/// divides the servo's.
pub fn rates_divide_the_physics_rate(subject: &Subject, sink: &mut Sink) {
    for path in ["action.rate", "action.servo_rate"] {
        if !divides(subject, path, "physics.rate", sink) {
            return;
        }
        for (other, _) in subject.protocols() {
            divides(subject, path, &format!("{other}.rate"), sink);
        }
    }
    divides(subject, "action.rate", "action.servo_rate", sink);
}

/// Whether the rate at `path` divides the one at `whole_path`; reports it when it does not. Absent rates divide.
fn divides(subject: &Subject, path: &str, whole_path: &str, sink: &mut Sink) -> bool {
    let (Some(rate), Some(physics)) = (subject.number(path), subject.number(whole_path)) else { return true };
    let steps = physics / rate;
    if rate <= 0.0 || whole(steps).is_some_and(|steps| steps >= 1.0) {
        return true;
    }
    let (rate_text, physics_text) = (subject.written(path), subject.written(whole_path));
    let message = format!("`{path}` ({rate_text}) does not divide `{whole_path}` ({physics_text})");
    let mut diagnostic = Diagnostic::error("E0501", message);
    let remark = if steps < 1.0 {
        format!("faster than `{whole_path}`")
    } else {
        format!("{} steps of `{whole_path}`", short(steps))
    };
    if let Some(place) = subject.place(path) {
        diagnostic = diagnostic.at(place, remark);
    }
    if let Some(place) = subject.place(whole_path) {
        diagnostic = diagnostic.note(place, "not a whole multiple");
    }
    sink.emit(diagnostic.help(nearest(physics, steps)));
    false
}

/// The valid rates on both sides that can be written with at most three decimals.
fn nearest(physics: f64, steps: f64) -> String {
    let plain = |count: &u64| {
        let thousandths = physics / *count as f64 * 1e3;
        (thousandths - thousandths.round()).abs() < 1e-6
    };
    let most = libm::ceil(steps).max(1.0) as u64;
    let above = (1..most).rev().find(plain).map(|count| physics / count as f64);
    let below =
        (most..most + 1000).find(|count| *count as f64 >= steps && plain(count)).map(|count| physics / count as f64);
    match (below, above) {
        (Some(below), Some(above)) => format!("the nearest rates are {} Hz and {} Hz", below, above),
        (Some(rate), None) | (None, Some(rate)) => format!("the nearest rate is {rate} Hz"),
        (None, None) => "choose a whole fraction of it".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn messages(text: &str) -> Vec<(String, Vec<String>)> {
        let found = found(rates_divide_the_physics_rate, text, None);
        found.into_iter().map(|diagnostic| (diagnostic.message, diagnostic.help)).collect()
    }

    #[test]
    fn a_third_that_is_not_whole_is_e0501_with_its_neighbours() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 300.0 }";
        assert_eq!(
            messages(text),
            [(
                "`action.rate` (300) does not divide `physics.rate` (500)".to_owned(),
                vec!["the nearest rates are 250 Hz and 500 Hz".to_owned()]
            )]
        );
    }

    #[test]
    fn a_servo_faster_than_the_physics_is_e0501() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 250.0, servo_rate = 2000.0 }";
        let found = messages(text);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].1, ["the nearest rate is 500 Hz"]);
    }

    #[test]
    fn rates_also_divide_the_rate_of_a_transfer_and_of_an_evaluation() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 250.0 }\ndeploy.mujoco = { rate = 2000.0 }";
        assert_eq!(messages(text), []);
        for place in ["deploy", "evaluate"] {
            let text = format!(
                "physics = {{ rate = 600.0 }}\naction = {{ rate = 300.0 }}\n{place}.mujoco = {{ rate = 2000.0 }}"
            );
            assert_eq!(messages(&text).len(), 1, "{place}");
        }
    }

    #[test]
    fn the_policys_rate_divides_the_servos() {
        let text = "physics = { rate = 600.0 }\naction = { rate = 200.0, servo_rate = 300.0 }";
        assert_eq!(messages(text)[0].0, "`action.rate` (200) does not divide `action.servo_rate` (300)");
    }

    #[test]
    fn an_absent_rate_is_passed_over() {
        assert_eq!(messages("physics = { rate = 500.0 }\naction = { }"), []);
    }
}
