//! Handwritten decoded specs for the tests of pre-training.

use crate::spec::{Quantity, Sampler, Table, Value};

pub fn number(si: f64) -> Value {
    Value::Quantity(Quantity { si, text: String::new() })
}

pub fn text(word: &str) -> Value {
    Value::Text(word.into())
}

pub fn list(numbers: &[f64]) -> Value {
    Value::List(numbers.iter().copied().map(number).collect())
}

pub fn table(keys: &[(&str, Value)]) -> Value {
    Value::Table(keys.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
}

/// A walk under torque control.
pub fn torque(kind: &str) -> Table {
    let clip = || ("clip", number(8.0));
    let observe = table(&[
        ("base_orientation", table(&[("scale", list(&[0.1, 0.1, 0.2])), clip()])),
        ("joint_position", table(&[("scale", list(&[0.15])), clip()])),
        (
            "joint_velocity",
            table(&[
                ("scale", list(&[0.135, 0.272, 0.587, 0.998, 0.654, 0.399])),
                ("low_pass", number(4.0)),
                clip(),
            ]),
        ),
        ("phase", table(&[("scale", number(0.7)), clip()])),
        ("command", table(&[clip()])),
    ]);
    let pretrain = table(&[
        ("kind", text(kind)),
        ("samples", Value::Count(4000)),
        ("epochs", Value::Count(6)),
        ("minibatch", Value::Count(128)),
        ("learning_rate", list(&[1e-3, 1e-5])),
        ("position_noise", Value::Sampler(Sampler::Uniform([0.05, 0.15]))),
        ("velocity_noise", number(1.0)),
        ("tilt_noise", list(&[0.06, 0.06, 0.15])),
        ("phase_label", text("zero")),
        ("stiffness", number(0.0625)),
        ("damping", number(0.25)),
        ("inertial", Value::Flag(false)),
        ("filter_lag", Value::Flag(false)),
        ("standing_share", number(0.5)),
        ("contact_height", number(0.02)),
    ]);
    let learn = table(&[
        ("seed", Value::Count(1)),
        ("symmetry", text("none")),
        (
            "policy",
            table(&[("hidden", Value::List(vec![Value::Count(64); 2])), ("activation", text("relu"))]),
        ),
    ]);
    let speed = Value::Sampler(Sampler::Uniform([0.0, 0.5]));
    let keys = [
        ("observe", observe),
        ("pretrain", pretrain),
        ("learn", learn),
        ("task", table(&[("kind", text("walk")), ("command", table(&[("speed", speed)]))])),
        ("physics", table(&[("rate", number(500.0))])),
        ("action", action("torque")),
    ];
    keys.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The same walk under position control.
pub fn position(kind: &str) -> Table {
    let mut fields = torque(kind);
    fields.insert("action".into(), action("position"));
    fields
}

/// The keys of `balance`.
pub fn balance() -> Value {
    table(&[
        ("stiffness", number(0.5)),
        ("damping", number(1.0)),
        ("upright", number(0.5)),
        ("upright_damping", number(0.05)),
    ])
}

/// The same fields without any noise.
pub fn still(mut fields: Table) -> Table {
    if let Some(Value::Table(pretrain)) = fields.get_mut("pretrain") {
        pretrain.insert("position_noise".into(), Value::Sampler(Sampler::Constant(0.0)));
        pretrain.insert("velocity_noise".into(), number(0.0));
        pretrain.insert("tilt_noise".into(), list(&[0.0, 0.0, 0.0]));
    }
    fields
}

fn action(kind: &str) -> Value {
    table(&[
        ("kind", text(kind)),
        ("rate", number(250.0)),
        ("std", number(0.1)),
        ("scale", number(1.0)),
        ("stiffness", number(0.125)),
        ("damping", text("sqrt")),
        ("servo_rate", number(500.0)),
        ("motor_speed_limit", Value::Flag(false)),
        ("phase_modulation", Value::Flag(true)),
    ])
}
