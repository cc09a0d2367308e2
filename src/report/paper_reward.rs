//! How a reward differs from the paper's table of ten terms.

use crate::spec::Section;

/// Names, weights and sharpness of the paper's terms, as `specs/base/biped.toml` spells them; `k` in SI units.
const TABLE: [(&str, f64, Option<f64>); 10] = [
    ("base_orientation", 0.3, Some(13.2)),
    ("joint_tracking", 0.35, Some(4.0)),
    ("contact_schedule", 0.2, None),
    ("velocity_tracking", 0.3, Some(3.0)),
    ("joint_velocity", 0.05, Some(0.01)),
    ("joint_velocity_change", 0.05, Some(20.0)),
    ("contact_force", 0.1, Some(0.0005)),
    ("contact_force_change", 0.1, Some(0.0005)),
    ("torque", 0.05, Some(0.01)),
    ("torque_change", 0.2, Some(0.01)),
];

/// What a spec's reward has in another way, in words; `None` where it is the paper's, or where there is no reward.
pub fn differences(spec: &Section) -> Option<String> {
    let reward = spec.section("reward")?;
    let terms: Vec<(&str, f64, Option<f64>)> = reward
        .sections()
        .map(|(name, term)| {
            (term.text_if("kind").unwrap_or(name), term.si_if("weight").unwrap_or(0.0), term.si_if("k"))
        })
        .collect();
    let of_paper = TABLE.iter().filter_map(|paper| match terms.iter().find(|term| term.0 == paper.0) {
        None => Some(format!("no `{}`", paper.0)),
        Some(own) => (own != paper).then(|| format!("{}, not {}", worth(own), figures(paper, own.2 != paper.2))),
    });
    // A second term of a kind is none of the paper's either.
    let is_new = |index: usize| {
        let is_kind_of = |other: &(&str, f64, Option<f64>)| other.0 == terms[index].0;
        !TABLE.iter().any(is_kind_of) || terms[..index].iter().any(is_kind_of)
    };
    let own = (0..terms.len()).filter(|index| is_new(*index));
    let own = own.map(|index| format!("{}, not in the paper", worth(&terms[index])));
    let said: Vec<String> = of_paper.chain(own).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

fn worth(term: &(&str, f64, Option<f64>)) -> String {
    format!("`{}` with {}", term.0, figures(term, true))
}

fn figures((_, weight, k): &(&str, f64, Option<f64>), sharpness: bool) -> String {
    match k.filter(|_| sharpness) {
        Some(k) => format!("{weight} at k = {k}"),
        None => weight.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::spec::{Quantity, Table, Value};

    fn reward(terms: &[(&str, f64, Option<f64>)]) -> Table {
        let value = |si: f64| Value::Quantity(Quantity { si, text: String::new() });
        let term = |(name, weight, k): &(&str, f64, Option<f64>)| {
            let keys = [("weight", Some(*weight)), ("k", *k)];
            let keys = keys.into_iter().filter_map(|(key, si)| Some((key.to_owned(), value(si?))));
            ((*name).to_owned(), Value::Table(keys.collect()))
        };
        Table::from([("reward".to_owned(), Value::Table(terms.iter().map(term).collect()))])
    }

    #[test]
    fn the_paper_s_own_table_differs_in_nothing() {
        assert_eq!(differences(&Section::new(&reward(&TABLE))), None);
        assert_eq!(differences(&Section::new(&Table::new())), None);
    }

    #[test]
    fn other_figures_missing_and_new_terms_are_told() {
        let mut terms = TABLE.to_vec();
        terms[2].1 = 0.4;
        terms[3] = ("velocity_tracking", 0.4, Some(40.0));
        terms.remove(9);
        terms.push(("mean_velocity_tracking", 0.4, Some(300.0)));
        assert_eq!(
            differences(&Section::new(&reward(&terms))).unwrap(),
            "`contact_schedule` with 0.4, not 0.2; `velocity_tracking` with 0.4 at k = 40, not 0.3 at k = 3; \
             no `torque_change`; `mean_velocity_tracking` with 0.4 at k = 300, not in the paper"
        );
    }

    #[test]
    fn a_second_term_of_a_kind_is_told() {
        let Value::Table(mut terms) = reward(&TABLE)["reward"].clone() else { panic!("a table") };
        let Value::Table(mut second) = terms["torque"].clone() else { panic!("a term") };
        second.insert("kind".into(), Value::Text("torque".into()));
        terms.insert("torque_again".into(), Value::Table(second));
        let told = differences(&Section::new(&Table::from([("reward".to_owned(), Value::Table(terms))])));
        assert_eq!(told.unwrap(), "`torque` with 0.05 at k = 0.01, not in the paper");
    }

    #[test]
    fn the_table_is_that_of_the_base_spec() {
        let text =
            std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/base/biped.toml")).unwrap();
        let base: toml::Table = text.parse().unwrap();
        let terms = base["reward"].as_table().unwrap();
        assert_eq!(terms.len(), TABLE.len());
        for (name, weight, k) in TABLE {
            let term = terms[name].as_table().unwrap();
            assert_eq!(term["weight"].as_float(), Some(weight), "{name}");
            let printed = term.get("k").map(|k| k.as_str().unwrap().split(' ').next().unwrap().parse().unwrap());
            assert_eq!(printed, k, "{name}");
        }
    }
}
