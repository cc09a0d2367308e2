//! What may be written in two ways with the same result: it enters a recipe in one of them, so that rewriting it makes no
//! stage anew.

use crate::spec::{Table, Value};

/// Keys whose value changes no result: section, key, and the count that stands for all of them.
const IDLE: &[(&str, &str, u64)] = &[("learn", "checkpoint_every", 10)];

/// Values that say what is meant without their key: section, key, value.
const IMPLIED: &[(&str, &str, &str)] = &[
    ("action", "feedback", "true"),
    ("action", "phase_action", "time"),
    ("action", "shares_of", "joint_ranges"),
    ("action", "targets", "joint_limits"),
    ("learn", "device", "cpu"),
    ("learn", "time_limit", "bootstrap"),
];

/// The fields of a stage as its recipe has them.
pub fn fields(fields: &Table) -> Table {
    let mut neutral = fields.clone();
    for (section, key, count) in IDLE {
        if let Some(value) = table(&mut neutral, section).and_then(|table| table.get_mut(*key)) {
            *value = Value::Count(*count);
        }
    }
    for (section, key, implied) in IMPLIED {
        if let Some(table) = table(&mut neutral, section) {
            table.retain(|name, value| name != key || *value != Value::Text((*implied).into()));
        }
    }
    neutral
}

/// Fields as a recipe has them, of whatever version, without what changes no result.
pub fn stripped(fields: &serde_json::Value) -> serde_json::Value {
    let mut fields = fields.clone();
    let mut drop_if = |section: &str, key: &str, idle: &dyn Fn(&serde_json::Value) -> bool| {
        let table = fields.get_mut(section).and_then(serde_json::Value::as_object_mut);
        if let Some(table) = table.filter(|table| table.get(key).is_some_and(idle)) {
            table.shift_remove(key);
        }
    };
    IDLE.iter().for_each(|(section, key, _)| drop_if(section, key, &|_| true));
    IMPLIED.iter().for_each(|(section, key, implied)| drop_if(section, key, &|value| value == implied));
    fields
}

fn table<'a>(fields: &'a mut Table, section: &str) -> Option<&'a mut Table> {
    match fields.get_mut(section) {
        Some(Value::Table(table)) => Some(table),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn learn<const N: usize>(entries: [(&str, Value); N]) -> Table {
        let learn = entries.map(|(key, value)| (key.to_owned(), value));
        Table::from([("learn".to_owned(), Value::Table(learn.into()))])
    }

    #[test]
    fn how_often_a_checkpoint_is_written_and_the_device_that_is_meant_anyway_change_no_recipe() {
        let usual = learn([("checkpoint_every", Value::Count(10))]);
        assert_eq!(fields(&usual), usual);
        let often = learn([("checkpoint_every", Value::Count(1)), ("device", Value::Text("cpu".into()))]);
        assert_eq!(fields(&often), usual);
        let other = learn([("checkpoint_every", Value::Count(10)), ("device", Value::Text("cuda".into()))]);
        assert_eq!(fields(&other), other, "another device makes another policy");
    }
}
