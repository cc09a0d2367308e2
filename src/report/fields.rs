//! The values of a decoded spec by path, and where they differ between arms.

use std::borrow::Borrow;

use super::model::Arm;
use crate::spec::section::{Header, Report};
use crate::spec::typed::InSection as _;
use crate::spec::{Table, Value};

/// A value of a spec and its path, for example `learn.policy.hidden`.
pub type Field<'a> = (String, &'a Value);

/// Every value of a table that is not a table itself, in key order.
pub fn flat(table: &Table) -> Vec<Field<'_>> {
    let mut fields = Vec::new();
    collect(table, "", &mut fields);
    fields
}

fn collect<'a>(table: &'a Table, prefix: &str, fields: &mut Vec<Field<'a>>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(below) => collect(below, &path, fields),
            _ => fields.push((path, value)),
        }
    }
}

/// Whether a path equals one of these paths or lies below one.
pub fn lies_in(path: &str, roots: &[String]) -> bool {
    roots.iter().any(|root| {
        path.strip_prefix(root.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// The origin of a value: that of its own path or of its nearest parent table.
pub fn origin<'a>(arm: &'a Arm, path: &str) -> &'a str {
    let mut path = path;
    loop {
        if let Some(origin) = arm.origins.get(path) {
            return origin;
        }
        match path.rsplit_once('.') {
            Some((above, _)) => path = above,
            None => return "",
        }
    }
}

/// Paths whose values differ between arms, except names and summaries. A missing value differs from any
/// other.
pub fn differing<A: Borrow<Arm>>(arms: &[A]) -> Vec<String> {
    let flats: Vec<Vec<Field>> = arms.iter().map(|arm| flat(&arm.borrow().fields)).collect();
    let mut paths: Vec<&String> = flats.iter().flatten().map(|(path, _)| path).collect();
    paths.sort();
    paths.dedup();
    let value = |flat: &Vec<Field>, path: &str| {
        flat.iter().find(|(own, _)| own == path).map(|(_, value)| value.canonical())
    };
    let differs = |path: &&String| {
        let first = flats.first().map(|flat| value(flat, path));
        flats.iter().any(|flat| Some(value(flat, path)) != first)
    };
    let told = |path: &&String| {
        ![Header::name.name, Header::summary.name, Header::spec.name].contains(&path.as_str())
            && !path.starts_with(Report::SECTION)
    };
    paths.into_iter().filter(told).filter(differs).cloned().collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn arm(kind: &str, extra: Option<&str>) -> Arm {
        let mut action = BTreeMap::from([("kind".to_string(), Value::Text(kind.into()))]);
        action.extend(extra.map(|key| (key.to_string(), Value::Count(1))));
        let fields = BTreeMap::from([
            ("action".to_string(), Value::Table(action)),
            ("name".to_string(), Value::Text(format!("run_{kind}"))),
            ("seed".to_string(), Value::Count(1)),
        ]);
        Arm { fields, origins: BTreeMap::from([("action".into(), "a.toml:3".into())]), ..Arm::default() }
    }

    #[test]
    fn only_what_differs_is_named() {
        let arms = [arm("torque", None), arm("position", Some("stiffness"))];
        assert_eq!(differing(&arms), ["action.kind", "action.stiffness"]);
        assert_eq!(differing(&arms[..1]), Vec::<String>::new());
    }

    #[test]
    fn a_value_without_its_own_origin_has_that_of_its_table() {
        assert_eq!(origin(&arm("torque", None), "action.kind"), "a.toml:3");
        assert_eq!(origin(&arm("torque", None), "seed"), "");
    }

    #[test]
    fn a_root_holds_itself_and_what_is_below_it() {
        let roots = ["learn".to_string(), "task.kind".to_string()];
        assert!(lies_in("learn.seed", &roots) && lies_in("task.kind", &roots) && lies_in("learn", &roots));
        assert!(!lies_in("learner.x", &roots) && !lies_in("task.motion", &roots));
    }
}
