//! The registries by name, and their reference pages as Markdown: the content of `list`, `explain` and
//! `docs/reference/kinds.md`.

use std::fmt::Write;

use crate::quantity::Dimension;
use crate::spec::{Kind, Param, Presence, Share, Ty};

/// A registry: the kinds that are allowed in one place of a spec.
pub struct Registry {
    /// Its name: `reward`.
    pub name: &'static str,
    /// Its place in a spec: `[reward.NAME]`.
    pub place: &'static str,
    /// Its purpose.
    pub summary: &'static str,
    /// Its kinds.
    pub kinds: Vec<&'static Kind>,
    /// Text of a page in place of the usual `kind = "..."`.
    pub facts: Option<fn(&Kind) -> String>,
}

/// Every registry, in the order of a spec.
pub fn registries() -> Vec<Registry> {
    let registry = |name, place, summary, kinds| Registry { name, place, summary, kinds, facts: None };
    let words = |name, place, summary, kinds, facts| Registry {
        facts: Some(facts),
        ..registry(name, place, summary, kinds)
    };
    vec![
        registry("terrain", "[terrain]", "The ground", super::terrain::kinds()),
        registry("task", "[task]", "The robot's task", super::task::kinds()),
        registry(
            "motion",
            "specs/motions/NAME.toml",
            "The reference motion of a task, adapted to the robot",
            super::motion::kinds(),
        ),
        registry("initial", "[initial]", "The initial state of episodes", super::initial::kinds()),
        registry("action", "[action]", "The policy's commands", super::action::kinds()),
        registry(
            "observe",
            "[observe.NAME]",
            "The policy's inputs, in the order of the observation vector",
            super::observe::kinds(),
        ),
        registry("reward", "[reward.NAME]", "Reward terms, each with a `weight`", super::reward::kinds()),
        registry(
            "terminate",
            "[terminate.NAME]",
            "Conditions that end an episode",
            super::terminate::kinds(),
        ),
        registry(
            "randomize",
            "[randomize.NAME]",
            "Domain randomization, drawn for each episode",
            super::randomize::kinds(),
        ),
        registry(
            "pretrain",
            "[pretrain]",
            "Supervised training before reinforcement learning",
            super::pretrain::kinds(),
        ),
        registry("learn", "[learn]", "The learner", super::learn::kinds()),
        registry(
            "fine_tune",
            "[fine_tune]",
            "A second training, which continues from the first in a changed environment",
            super::fine_tune::kinds(),
        ),
        registry("evaluate", "[evaluate.NAME]", "Evaluation of the trained policy", super::evaluate::kinds()),
        registry(
            "deploy",
            "[deploy.NAME]",
            "Export of the trained policy, and transfer to another engine",
            super::deploy::kinds(),
        ),
        words(
            "metric",
            "[[claim]] metric",
            "Measurements of claims and reports",
            super::metric::kinds(),
            super::metric::facts,
        ),
        words(
            "statistic",
            "[[claim]] test",
            "Statistical tests of claims",
            super::statistic::kinds(),
            super::statistic::facts,
        ),
    ]
}

/// The first line of a kind's page.
pub fn summary(kind: &Kind) -> &'static str {
    kind.doc.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().trim_start_matches("# ")
}

/// The page of a kind: its text, its keys and the signals that it needs.
pub fn page(registry: &Registry, kind: &Kind) -> String {
    let mut page = format!("# {}.{}\n\n{}\n\n", registry.name, kind.name, kind.doc.trim());
    if let Some(facts) = registry.facts {
        return page + &facts(kind);
    }
    let _ = write!(page, "Set in `{}` with `kind = \"{}\"`", registry.place, kind.name);
    page += if registry.place.contains(".NAME") {
        ", which may be left out if NAME is the kind.\n"
    } else {
        ".\n"
    };
    if !kind.params.is_empty() {
        page += "\n| key | value | when absent | meaning |\n|---|---|---|---|\n";
        rows("", kind.params, &mut page);
    }
    if !kind.needs.is_empty() {
        let needs: Vec<String> = kind.needs.iter().map(|signal| words(&format!("{signal:?}"))).collect();
        let _ = write!(page, "\nReads: {}.\n", needs.join(", "));
    }
    page
}

/// All pages in one document.
pub fn document() -> String {
    let mut text = String::from(
        "# The kinds\n\nThe values of `kind` for each table of a spec, with their keys, and the \
         metrics and tests of claims;\n\
         `specforge explain KIND` prints one page. This document is generated from the descriptors in \
         `src/kinds/`.\n",
    );
    for registry in registries() {
        let _ = write!(text, "\n## {}\n\n{}: `{}`.\n", registry.name, registry.summary, registry.place);
        for kind in &registry.kinds {
            let _ = write!(text, "\n##{}", page(&registry, kind));
        }
    }
    text
}

fn rows(prefix: &str, params: &[Param], page: &mut String) {
    for param in params {
        let absent = match param.presence {
            Presence::Required => "error".to_owned(),
            Presence::Optional => "-".to_owned(),
            Presence::Default(value) => format!("`{value}`"),
        };
        let range =
            param.range.map(|(low, high)| format!(" From {low} to {high} in SI units.")).unwrap_or_default();
        let cell = |text: &str| text.replace('|', "\\|");
        let name = format!("{prefix}{}", param.name);
        let _ =
            writeln!(page, "| `{name}` | {} | {absent} | {}{range} |", cell(&takes(param)), cell(param.doc));
        for table in tables(&param.ty) {
            rows(&format!("{name}."), table, page);
        }
    }
}

/// The tables inside a type, whose keys get their own rows.
pub fn tables(ty: &Ty) -> Vec<&'static [Param]> {
    match ty {
        Ty::Table(params) => vec![params],
        Ty::OneOf(types) => types.iter().flat_map(tables).collect(),
        Ty::List(item) | Ty::Named(item) => tables(item),
        _ => Vec::new(),
    }
}

/// Description of a key's type, with the length of a list.
pub fn takes(param: &Param) -> String {
    let words = describe(&param.ty);
    match param.length {
        Some(length) => words.replacen("a list,", &format!("a list of {length},"), 1),
        None => words,
    }
}

/// A share, and the other quantity that its key takes.
fn share_of(share: &Share) -> String {
    let other = share
        .measure
        .map_or(String::new(), |measure| format!(", or {} (`{}`)", measure.name(), measure.unit()));
    format!("a share of {} (`%`){other}", share.of)
}

/// Description of a type: `a length ("1 m")`.
pub fn describe(ty: &Ty) -> String {
    match ty {
        Ty::Flag => "true or false".to_owned(),
        Ty::Count => "a count".to_owned(),
        Ty::Number => "a number".to_owned(),
        Ty::Quantity(dimension) => quantity(*dimension),
        Ty::Ratio(share) => share_of(share),
        Ty::Text => "a text".to_owned(),
        Ty::Choice(words) => {
            words.iter().map(|word| format!("`\"{word}\"`")).collect::<Vec<_>>().join(" or ")
        }
        Ty::Sampler(dimension) => format!("{} or a distribution", quantity(*dimension)),
        Ty::List(item) => format!("a list, each {}", describe(item)),
        Ty::Named(item) => format!("tables with names, each {}", describe(item)),
        Ty::Table([]) => "a table".to_owned(),
        Ty::Table(params) => {
            let keys: Vec<String> = params.iter().map(|param| format!("`{}`", param.name)).collect();
            format!("a table with {}", keys.join(", "))
        }
        Ty::Kind(kinds) => format!("a table as in `[{}]`", kinds.section),
        Ty::Terms(kinds) => format!("tables as in `[{}.NAME]`", kinds.section),
        Ty::OneOf(types) => types.iter().map(describe).collect::<Vec<_>>().join(", or "),
    }
}

fn quantity(dimension: Dimension) -> String {
    if dimension == Dimension::NONE {
        return "a number".to_owned();
    }
    let (name, unit) = (dimension.name(), dimension.unit());
    if name.starts_with("a quantity in") { name } else { format!("{name} (`{unit}`)") }
}

/// `BaseOrientation` as `base orientation`.
fn words(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push(' ');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Length;

    #[test]
    fn every_kind_has_a_one_line_summary_and_documented_keys() {
        for registry in registries() {
            assert!(!registry.kinds.is_empty(), "{} has kinds", registry.name);
            for kind in registry.kinds {
                assert!(!summary(kind).is_empty(), "{}.{}", registry.name, kind.name);
                for param in kind.params {
                    assert!(!param.doc.is_empty(), "{}.{} {}", registry.name, kind.name, param.name);
                }
            }
        }
    }

    #[test]
    fn types_are_described_with_their_unit() {
        assert_eq!(describe(&Ty::Quantity(Dimension::LENGTH)), "a length (`m`)");
        assert_eq!(describe(&Ty::List(&Ty::Count)), "a list, each a count");
        let pair = Param::required("ends", Ty::List(&Ty::Number)).length(Length::Each(&["low", "high"]));
        assert_eq!(takes(&pair), "a list of 2, each a number");
        assert_eq!(describe(&Ty::Choice(&["a", "b"])), "`\"a\"` or `\"b\"`");
    }
}
