//! Reads the embedded robots for tests, without the spec decoder: all their units are SI already.

use crate::robot::{Robot, embedded, from_table};
use crate::spec::{Quantity, Table, Value};

/// A robot that comes with specforge.
pub(crate) fn robot(name: &str) -> Robot {
    let (robot, issues) = from_table(name, &table(embedded(name).expect("a robot of this name")));
    assert_eq!(issues, [], "{name}");
    robot.expect("a robot without issues")
}

/// A text's table, with every string that starts like a number taken as a quantity in SI units.
pub(crate) fn table(text: &str) -> Table {
    let table: toml::Table = text.parse().expect("TOML");
    table.into_iter().map(|(key, value)| (key, decode(value))).collect()
}

fn decode(value: toml::Value) -> Value {
    match value {
        toml::Value::String(text) => match text.split_once(' ').map(|(number, _)| number.parse::<f64>()) {
            Some(Ok(si)) => Value::Quantity(Quantity { si, text }),
            _ => Value::Text(text),
        },
        toml::Value::Float(si) => Value::Quantity(Quantity { si, text: si.to_string() }),
        toml::Value::Integer(count) => Value::Count(count.unsigned_abs()),
        toml::Value::Boolean(flag) => Value::Flag(flag),
        toml::Value::Array(items) => Value::List(items.into_iter().map(decode).collect()),
        toml::Value::Table(table) => Value::Table(table.into_iter().map(|(key, value)| (key, decode(value))).collect()),
        toml::Value::Datetime(date) => Value::Text(date.to_string()),
    }
}
