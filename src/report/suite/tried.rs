//! Counts the settings a suite tries per action space: the best of many tries is better by chance alone.

use crate::kinds::action::Action;
use crate::report::group::Group;
use crate::spec::Value;
use crate::spec::typed::InSection;

/// The number of different `[action]` tables of each kind, in arm order; empty if there is only one kind.
pub fn counts<'a>(groups: &[Group<'a>]) -> Vec<(&'a str, usize)> {
    let mut found: Vec<(&str, Vec<serde_json::Value>)> = Vec::new();
    for arm in groups.iter().filter_map(|group| group.runs.first()) {
        let Some(action) = arm.fields.get(Action::SECTION).map(Value::canonical) else { continue };
        let kind = arm.kind::<Action>();
        match found.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, settings)) if settings.contains(&action) => {}
            Some((_, settings)) => settings.push(action),
            None => found.push((kind, vec![action])),
        }
    }
    if found.len() < 2 {
        return Vec::new();
    }
    found.into_iter().map(|(kind, settings)| (kind, settings.len())).collect()
}

/// `3 of torque, 12 of position`.
pub fn words(counts: &[(&str, usize)]) -> String {
    counts.iter().map(|(kind, count)| format!("{count} of {kind}")).collect::<Vec<_>>().join(", ")
}

/// The warning, if action spaces had different numbers of tries.
pub fn warning(groups: &[Group<'_>]) -> Option<String> {
    let counts = counts(groups);
    let unequal = counts.windows(2).any(|pair| pair[0].1 != pair[1].1);
    unequal.then(|| {
        let words = words(&counts);
        format!(
            "Not as many settings were tried of each action space, {words}: the best of more tries is \
            better by luck alone."
        )
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::report::model::Arm;

    fn arm(kind: &str, std: u64) -> Arm {
        let action = [("kind", Value::Text(kind.into())), ("std", Value::Count(std))];
        let action = action.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        Arm { fields: BTreeMap::from([("action".to_owned(), Value::Table(action))]), ..Arm::default() }
    }

    #[test]
    fn a_setting_that_several_arms_share_is_one_try() {
        let arms = [arm("torque", 10), arm("torque", 20), arm("position", 10), arm("torque", 10)];
        fn groups(arms: &[Arm]) -> Vec<Group<'_>> {
            arms.iter().map(|arm| Group { name: "a", points: &[], runs: vec![arm] }).collect()
        }
        let all = groups(&arms);
        assert_eq!(words(&counts(&all)), "2 of torque, 1 of position");
        assert!(warning(&all).is_some_and(|text| text.contains("2 of torque, 1 of position: the best")));
        let level = groups(&arms[1..3]);
        assert_eq!(
            (words(&counts(&level)), warning(&level)),
            ("1 of torque, 1 of position".to_owned(), None)
        );
        let alone = groups(&arms[..2]);
        assert_eq!((counts(&alone), warning(&alone)), (Vec::new(), None));
    }
}
