//! Describes the low-level law in words, for pages and contracts.

use crate::kinds::action::Action;
use crate::kinds::action::position::{Position, SharesOf, Span, Targets};
use crate::kinds::learn::Ppo;
use crate::kinds::randomize::Rows;
use crate::kinds::randomize::action_delay::ActionDelay;
use crate::spec::{Sampler, Section, Table};

/// The effective law of a decoded spec, for example
/// `tau = clamp(effort_limit * a, +-effort_limit), held for 4 ms, delayed 2..6 ms`.
pub fn law(fields: &Table) -> Option<String> {
    let fields = Section::new(fields);
    let action: Action = fields.part()?;
    let fading = if action.motor_speed_limit() { ", fading beyond the motors' speed limits" } else { "" };
    Some(format!("{}, {}{fading}", command(&action), delay(fields, &action)))
}

/// The law of an action without its randomization, as a deployed policy runs.
pub fn nominal_law(action: &Action) -> String {
    format!("{}, {}", command(action), nominal_delay(action))
}

/// The conversion of an action into a command, and how long it is held.
fn command(action: &Action) -> String {
    let command = match action.servo() {
        Some(servo) => position(servo),
        None => "tau = clamp(effort_limit * a, +-effort_limit)".to_owned(),
    };
    format!("{command}, held for {} ms", milliseconds(1.0 / action.rate()))
}

/// The exploration around the policy's mean while training.
pub fn exploration(fields: &Table) -> Option<String> {
    let fields = Section::new(fields);
    let action: Action = fields.part()?;
    let reference = match action.servo().map(|servo| servo.shares_of) {
        Some(Some(SharesOf::Span(Span::EffortLimits))) => {
            "the servo error that demands each joint's effort limit".to_owned()
        }
        Some(Some(SharesOf::Angle(angle))) => format!("{} rad", number(angle)),
        Some(_) => "half of each joint's range".to_owned(),
        None => "each joint's effort limit".to_owned(),
    };
    let share = |ratio: f64| format!("{} %", number(100.0 * ratio));
    let std = share(action.std());
    let falling = fields.at(Ppo::std_decay).map(|decay| {
        let (to, over) = (share(decay.to), share(decay.over));
        format!(", which falls to {to} of that over the first {over} of the samples")
    });
    let falling = falling.unwrap_or_default();
    Some(format!("a normal distribution with a standard deviation of {std} of {reference}{falling}"))
}

fn position(servo: &Position) -> String {
    let (stiffness, damping) = servo.gains();
    let share = |ratio: f64| format!("{} %", number(100.0 * ratio));
    let measured = if servo.reads_encoders() { ", q and qd as measured" } else { "" };
    let whole = match servo.shares_of {
        Some(SharesOf::Span(Span::EffortLimits)) => "effort_limit / K_p".to_owned(),
        Some(SharesOf::Angle(angle)) => format!("of {} rad", number(angle)),
        _ => "half_range".to_owned(),
    };
    format!(
        "tau = clamp(K_p (q_d - q) - K_d qd, +-effort_limit) at {} Hz{measured}, q_d = clamp(q_default + {} \
         {whole} * a, limits{}), \
         K_p = {} and K_d = {} of the robot's own gains",
        number(servo.servo_rate),
        share(servo.scale),
        if servo.targets == Some(Targets::EffortLimits) { " +- effort_limit / K_p" } else { "" },
        share(stiffness),
        share(damping),
    )
}

/// The delay, with the range over which it is randomized.
fn delay(fields: Section, action: &Action) -> String {
    let nominal = action.delay();
    let mut terms = fields.within::<Rows>().into_iter().flat_map(|section| section.sections());
    let drawn = terms.find(|(_, term)| term.is::<ActionDelay>());
    match drawn.and_then(|(_, term)| term.value(ActionDelay::scale)) {
        Some(scale) if nominal > 0.0 && !matches!(scale, Sampler::Constant(_)) => {
            let [low, high] = scale.bounds();
            format!("delayed {}..{} ms", milliseconds(low * nominal), milliseconds(high * nominal))
        }
        _ => nominal_delay(action),
    }
}

fn nominal_delay(action: &Action) -> String {
    match action.delay() {
        0.0 => "not delayed".to_owned(),
        delay => format!("delayed {} ms", milliseconds(delay)),
    }
}

fn milliseconds(seconds: f64) -> String {
    number(1e3 * seconds)
}

/// A number to four decimals without trailing zeros.
fn number(value: f64) -> String {
    ((value * 1e4).round() / 1e4).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Quantity, Value};

    fn table(entries: &[(&str, Value)]) -> Table {
        entries.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
    }

    fn si(si: f64) -> Value {
        Value::Quantity(Quantity { si, text: String::new() })
    }

    fn word(text: &str) -> Value {
        Value::Text(text.to_owned())
    }

    #[test]
    fn a_torque_action_goes_to_the_motors_as_it_is() {
        let action =
            table(&[("kind", word("torque")), ("rate", si(250.0)), ("delay", si(0.004)), ("std", si(0.1))]);
        let scale = Value::Sampler(Sampler::Uniform([0.5, 1.5]));
        let delay = table(&[("kind", word("action_delay")), ("scale", scale)]);
        let randomize = table(&[("action_delay", Value::Table(delay))]);
        let mut fields =
            table(&[("action", Value::Table(action.clone())), ("randomize", Value::Table(randomize))]);
        let words = "tau = clamp(effort_limit * a, +-effort_limit), held for 4 ms, delayed 2..6 ms";
        assert_eq!(law(&fields).as_deref(), Some(words));
        let mut limited = fields.clone();
        let action = action.into_iter().chain([("motor_speed_limit".to_owned(), Value::Flag(true))]);
        limited.insert("action".to_owned(), Value::Table(action.collect()));
        assert_eq!(law(&limited), Some(format!("{words}, fading beyond the motors' speed limits")));
        assert!(exploration(&fields).is_some_and(|text| text.ends_with("10 % of each joint's effort limit")));
        let decay = table(&[("to", si(0.5)), ("over", si(0.4))]);
        fields.insert("learn".to_owned(), Value::Table(table(&[("std_decay", Value::Table(decay))])));
        let falling = "effort limit, which falls to 50 % of that over the first 40 % of the samples";
        assert!(exploration(&fields).is_some_and(|text| text.ends_with(falling)));
    }

    #[test]
    fn a_position_action_goes_through_the_servo() {
        let action = table(&[
            ("kind", word("position")),
            ("rate", si(125.0)),
            ("servo_rate", si(500.0)),
            ("std", si(0.1)),
            ("stiffness", si(0.25)),
            ("damping", word("sqrt")),
        ]);
        let text = law(&table(&[("action", Value::Table(action.clone()))])).expect("the action is complete");
        assert!(
            text.contains("at 500 Hz") && text.contains("K_p = 25 % and K_d = 50 % of the robot's own gains"),
            "{text}"
        );
        assert!(text.ends_with("held for 8 ms, not delayed"), "{text}");
        assert!(text.contains("q_default + 100 % half_range * a"), "{text}");
        let entries = [("shares_of", word("effort_limits"))].map(|(key, value)| (key.to_owned(), value));
        let action: Table = action.into_iter().chain(entries).collect();
        let mut encoders = action.clone();
        encoders.insert("feedback".into(), word("measured"));
        let encoders = law(&table(&[("action", Value::Table(encoders))]));
        assert!(encoders.is_some_and(|text| text.contains(" at 500 Hz, q and qd as measured, q_d = ")));
        let mut angle = action.clone();
        angle.insert("shares_of".into(), si(1.5));
        let angle = table(&[("action", Value::Table(angle))]);
        assert!(
            law(&angle).is_some_and(|text| text.contains("q_default + 100 % of 1.5 rad * a")),
            "{:?}",
            law(&angle)
        );
        assert!(
            exploration(&angle).is_some_and(|text| text.ends_with("a standard deviation of 10 % of 1.5 rad"))
        );
        let fields = table(&[("action", Value::Table(action))]);
        assert!(law(&fields).is_some_and(|text| text.contains("q_default + 100 % effort_limit / K_p * a")));
        let words = "10 % of the servo error that demands each joint's effort limit";
        assert!(exploration(&fields).is_some_and(|text| text.ends_with(words)));
    }
}
