//! E0501: the physics rate is a multiple of the rates of policy and servo, and the servo's of the policy's.

use super::Subject;
use super::subject::{short, whole};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::evaluate::Setting;
use crate::kinds::physics::Physics;
use crate::spec::typed::Key;

/// Suggested rates are within this factor of the present one.
const NEAR: f64 = 4.0;

/// `action.rate` and `action.servo_rate` divide `physics.rate` and the rate of every evaluation and transfer;
/// the policy's rate divides the servo's.
pub fn rates_divide_the_physics_rate(subject: &Subject, sink: &mut Sink) {
    let [policy, servo] = acting();
    for path in [&policy, &servo] {
        if !divides(subject, path, &Physics::rate.path(), sink) {
            return;
        }
        for (other, _) in subject.protocols() {
            divides(subject, path, &Setting::rate.below(&other), sink);
        }
    }
    divides(subject, &policy, &servo, sink);
}

/// The policy's rate and the servo's divide the physics rate of the evaluation at this path.
pub fn rates_divide_that_of_an_evaluation(subject: &Subject, evaluation: &str, sink: &mut Sink) {
    let of_evaluation = Setting::rate.below(evaluation);
    let _ = acting().iter().all(|path| divides(subject, path, &of_evaluation, sink));
}

/// The paths of the policy's and the servo's rate.
fn acting() -> [String; 2] {
    [Position::rate, Position::servo_rate].map(Key::path)
}

/// Whether the rate at `path` divides the one at `whole_path`; reports it if not. True if one is absent.
fn divides(subject: &Subject, path: &str, whole_path: &str, sink: &mut Sink) -> bool {
    let (Some(rate), Some(physics)) = (subject.number(path), subject.number(whole_path)) else { return true };
    if rate <= 0.0 || is_fraction(rate, physics) {
        return true;
    }
    let steps = physics / rate;
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
        diagnostic = diagnostic.note(place, "not a multiple");
    }
    sink.emit(diagnostic.help(cure(subject, path, rate, whole_path, physics)));
    false
}

/// Whether a rate divides another.
fn is_fraction(rate: f64, physics: f64) -> bool {
    whole(physics / rate).is_some_and(|steps| steps >= 1.0)
}

/// Suggestions for each of the two rates. Evaluations and transfers follow the training's rates, not vice
/// versa.
fn cure(subject: &Subject, path: &str, rate: f64, whole_path: &str, physics: f64) -> String {
    let count = libm::ceil((physics / rate).max(1.0)) as u64 + 1000;
    let fractions: Vec<f64> = (1..count).map(|count| physics / count as f64).collect();
    let multiples: Vec<f64> = (1..count).map(|count| rate * count as f64).collect();
    let of_training = !subject.protocols().iter().any(|(other, _)| whole_path == Setting::rate.below(other));
    let both = [(path, rate, fractions, of_training), (whole_path, physics, multiples, true)];
    // Rates that settle all conflicts are preferred to those that settle this one alone.
    let of = |all: bool| -> Vec<String> {
        let offers = both.iter().filter(|(.., offered)| *offered);
        offers.filter_map(|(key, rate, rates, _)| neighbours(subject, key, *rate, rates, all)).collect()
    };
    let offers = Some(of(true)).filter(|offers| !offers.is_empty()).unwrap_or_else(|| of(false));
    if offers.is_empty() { "choose a whole fraction of it".to_owned() } else { offers.join(", or ") }
}

/// The next lower and higher rate that have at most three decimals and fit all others, and with `all` leave no
/// conflict between those either.
fn neighbours(subject: &Subject, key: &str, present: f64, rates: &[f64], all: bool) -> Option<String> {
    let plain = |rate: f64| (rate * 1e3 - (rate * 1e3).round()).abs() < 1e-6;
    let near = |rate: f64| (present / NEAR..=present * NEAR).contains(&rate);
    let sound =
        || rates.iter().copied().filter(|rate| near(*rate) && plain(*rate) && fits(subject, key, *rate, all));
    let below = sound().filter(|rate| *rate < present).reduce(f64::max);
    let above = sound().filter(|rate| *rate > present).reduce(f64::min);
    // Products of decimals: 1997.9999999999998 is 1998.
    let [below, above] = [below, above].map(|rate| rate.map(|rate| (rate * 1e3).round() / 1e3));
    match (below, above) {
        (Some(below), Some(above)) => Some(format!("`{key}` can be {below} Hz or {above} Hz")),
        (Some(rate), None) | (None, Some(rate)) => Some(format!("`{key}` can be {rate} Hz")),
        (None, None) => None,
    }
}

/// The lowest rate in Hz from `least` that fits all others: a multiple of the faster of policy and servo.
pub(super) fn from(subject: &Subject, key: &str, least: f64) -> Option<f64> {
    let acting = acting().into_iter().filter_map(|path| subject.number(&path));
    let acting = acting.filter(|rate| *rate > 0.0).fold(1.0, f64::max);
    let first = libm::ceil(least / acting * (1.0 - 1e-9)) as u64;
    (first..first + 1000).map(|count| acting * count as f64).find(|rate| fits(subject, key, *rate, false))
}

/// Whether a rate in place of the present one satisfies all divisibility rules that it is part of, or with
/// `all` every rule.
fn fits(subject: &Subject, key: &str, rate: f64, all: bool) -> bool {
    let own = |path: &str| if path == key { Some(rate) } else { subject.number(path) };
    let divides = |path: &str, whole_path: &str| {
        let concerned = all || path == key || whole_path == key;
        !concerned || own(path).zip(own(whole_path)).is_none_or(|(rate, physics)| is_fraction(rate, physics))
    };
    let protocols = subject.protocols().into_iter().map(|(path, _)| Setting::rate.below(&path));
    let mut wholes = std::iter::once(Physics::rate.path()).chain(protocols);
    let [policy, servo] = acting();
    divides(&policy, &servo) && wholes.all(|whole| divides(&policy, &whole) && divides(&servo, &whole))
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
                vec![
                    "`action.rate` can be 250 Hz or 500 Hz, or `physics.rate` can be 300 Hz or 600 Hz"
                        .to_owned()
                ]
            )]
        );
    }

    #[test]
    fn a_servo_faster_than_the_physics_is_e0501() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 250.0, servo_rate = 2000.0 }";
        let found = messages(text);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].1, ["`action.servo_rate` can be 500 Hz, or `physics.rate` can be 2000 Hz"]);
    }

    #[test]
    fn rates_also_divide_the_rate_of_a_transfer_and_of_an_evaluation() {
        let text = "physics = { rate = 500.0 }\naction = { rate = 250.0 }\ndeploy.mujoco = { rate = 2000.0 }";
        assert_eq!(messages(text), []);
        for place in ["deploy", "evaluate"] {
            let text = format!(
                "physics = {{ rate = 600.0 }}\naction = {{ rate = 300.0 }}\n{place}.mujoco = \
                 {{ rate = 2000.0 }}"
            );
            assert_eq!(messages(&text).len(), 1, "{place}");
        }
    }

    #[test]
    fn what_is_suggested_fits_all_other_rates() {
        let text =
            "physics = { rate = 500.0 }\naction = { rate = 250.0 }\nevaluate.nominal = { rate = 333.0 }";
        assert_eq!(messages(text)[0].1, ["`evaluate.nominal.rate` can be 250 Hz or 500 Hz"]);
        let text = "physics = { rate = 99.9 }\naction = { rate = 33.3 }\ndeploy.mujoco = { rate = 2000.0 }";
        assert_eq!(messages(text)[0].1, ["`deploy.mujoco.rate` can be 1998 Hz or 2031.3 Hz"]);
        let text = "physics = { rate = 499.0 }\naction = { rate = 50.0, servo_rate = 250.0 }";
        assert_eq!(messages(text)[0].1, ["`physics.rate` can be 250 Hz or 500 Hz"]);
    }

    #[test]
    fn no_rate_is_suggested_that_leaves_another_conflict() {
        let text = "physics = { rate = 2000.0 }\naction = { rate = 300.0, servo_rate = 2000.0 }\n\
                    deploy.mujoco = { rate = 2000.0 }";
        assert_eq!(messages(text)[0].1, ["`action.rate` can be 250 Hz or 400 Hz"]);
        // Nothing settles both conflicts at once.
        let text = "physics = { rate = 500.0 }\naction = { rate = 300.0 }\ndeploy.mujoco = { rate = 700.0 }\n\
                    evaluate.nominal = { rate = 333.0 }";
        assert!(messages(text)[0].1[0].contains("can be"), "{:?}", messages(text));
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
