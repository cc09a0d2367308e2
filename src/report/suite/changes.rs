//! What the points of a sweep change: the spec values in which an arm differs from the first one.

use crate::report::fields::differing;
use crate::report::group::{Group, varying};
use crate::report::model::{Arm, ReportInput};
use crate::report::table::setup::field;
use crate::report::table::{Cell, Table};
use crate::report::wording::arm_in_words;

/// Most values listed per arm.
const NAMED: usize = 8;

/// One row per arm, except the first, of a sweep over one axis; over several axes the arms differ too much
/// for such a list.
pub fn table(input: &ReportInput, groups: &[Group<'_>]) -> Table {
    let mut table = Table::new(
        "changes",
        "What the arms have other than the first",
        ["arm", "spec values"].map(String::from),
    );
    let firsts: Vec<&Arm> = groups.iter().filter_map(|group| group.runs.first().copied()).collect();
    let [first, others @ ..] = firsts.as_slice() else { return table };
    if varying(input, groups).len() != 1 {
        return table;
    }
    table.note = format!(
        "What each arm has other than {}, with that arm's values in brackets:",
        arm_in_words(groups[0].name)
    );
    for (group, arm) in groups.iter().skip(1).zip(others) {
        table.row("", &arm_in_words(group.name), [Cell::Text(changes(first, arm))]);
    }
    table
}

/// `` `learn.warm_up` 0 (6) ``: the arm's values, with the first arm's in brackets. For a table of another
/// kind, or that only one of them has, the kinds.
fn changes(first: &Arm, arm: &Arm) -> String {
    let mut paths: Vec<String> = Vec::new();
    for path in differing(&[first, arm]) {
        let above = path.match_indices('.').map(|(at, _)| format!("{}.kind", &path[..at]));
        let kind = above.into_iter().find(|kind| field(first, kind) != field(arm, kind));
        let told = kind.unwrap_or(path);
        if !paths.contains(&told) {
            paths.push(told);
        }
    }
    let written = |arm: &Arm, path: &str| field(arm, path).unwrap_or_else(|| "\u{2013}".to_owned());
    let named = paths.iter().take(NAMED).map(|path| {
        let name = path.strip_suffix(".kind").unwrap_or(path);
        format!("`{name}` {} ({})", written(arm, path), written(first, path))
    });
    let rest = paths.len().saturating_sub(NAMED);
    let rest = (rest > 0).then(|| format!("and {rest} more"));
    named.chain(rest).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::spec::Value;

    fn arm(values: &[(&str, u64)]) -> Arm {
        let learn = values.iter().map(|(key, value)| ((*key).to_owned(), Value::Count(*value))).collect();
        Arm { fields: BTreeMap::from([("learn".to_owned(), Value::Table(learn))]), ..Arm::default() }
    }

    #[test]
    fn values_stand_beside_those_of_the_first_arm_and_a_long_list_ends() {
        let first = arm(&[("epochs", 4), ("warm_up", 6)]);
        let told = changes(&first, &arm(&[("epochs", 4), ("rollout", 128)]));
        assert_eq!(told, "`learn.rollout` 128 (\u{2013}), `learn.warm_up` \u{2013} (6)");
        let of_kind = |kind: &str, key: &str| {
            let table = BTreeMap::from([
                ("kind".to_owned(), Value::Text(kind.into())),
                (key.to_owned(), Value::Count(1)),
            ]);
            Arm { fields: BTreeMap::from([("pretrain".to_owned(), Value::Table(table))]), ..Arm::default() }
        };
        let told =
            changes(&of_kind("tracking", "damping"), &of_kind("gravity_compensation", "contact_height"));
        assert_eq!(told, "`pretrain` gravity_compensation (tracking)");
        assert_eq!(
            changes(&of_kind("tracking", "damping"), &Arm::default()),
            "`pretrain` \u{2013} (tracking)"
        );
        let many: Vec<String> = (0..11).map(|at| format!("key_{at:02}")).collect();
        let many: Vec<(&str, u64)> = many.iter().map(|key| (key.as_str(), 1)).collect();
        assert!(changes(&arm(&[]), &arm(&many)).ends_with("`learn.key_07` 1 (\u{2013}), and 3 more"));
    }
}
