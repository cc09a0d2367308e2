//! The registries by name, and their reference pages as Markdown: what `list`, `explain` and
//! `docs/reference/kinds.md` show.

use std::fmt::Write;

use crate::quantity::Dimension;
use crate::spec::{Kind, Param, Presence, Ty};

/// A registry: the kinds that may stand in one place of a spec.
pub struct Registry {
    /// Its name: `reward`.
    pub name: &'static str,
    /// Where its kinds are written: `[reward.NAME]`.
    pub place: &'static str,
    /// What it is for.
    pub summary: &'static str,
    /// Its kinds.
    pub kinds: Vec<&'static Kind>,
    /// What a page says in place of how its kind is written, where that is not `kind = "..."`.
    pub facts: Option<fn(&Kind) -> String>,
}

/// Every registry, in the order in which a spec is read.
pub fn registries() -> Vec<Registry> {
    let registry = |name, place, summary, kinds| Registry { name, place, summary, kinds, facts: None };
    let words = |name, place, summary, kinds, facts| Registry {
        facts: Some(facts),
        ..registry(name, place, summary, kinds)
    };
    vec![
        registry("terrain", "[terrain]", "The ground", super::terrain::kinds()),
        registry("task", "[task]", "What the robot is asked to do", super::task::kinds()),
        registry(
            "motion",
            "specs/motions/NAME.toml",
            "The reference motion that a task names, made for the robot at hand",
            super::motion::kinds(),
        ),
        registry("initial", "[initial]", "How an episode begins", super::initial::kinds()),
        registry("action", "[action]", "What the policy commands", super::action::kinds()),
        registry(
            "observe",
            "[observe.NAME]",
            "What the policy sees, in the order of the vector",
            super::observe::kinds(),
        ),
        registry(
            "reward",
            "[reward.NAME]",
            "What earns reward; each term has a `weight`",
            super::reward::kinds(),
        ),
        registry("terminate", "[terminate.NAME]", "What ends an episode", super::terminate::kinds()),
        registry(
            "randomize",
            "[randomize.NAME]",
            "What differs from episode to episode",
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
            "A second training, which goes on from the first in a changed world",
            super::fine_tune::kinds(),
        ),
        registry(
            "evaluate",
            "[evaluate.NAME]",
            "How the trained policy is measured",
            super::evaluate::kinds(),
        ),
        registry("deploy", "[deploy.NAME]", "What is made of the trained policy", super::deploy::kinds()),
        words(
            "metric",
            "[[claim]] metric",
            "What a claim and a report measure",
            super::metric::kinds(),
            super::metric::facts,
        ),
        words(
            "statistic",
            "[[claim]] test",
            "How a claim is decided",
            super::statistic::kinds(),
            super::statistic::facts,
        ),
    ]
}

/// The first line of a kind's page.
pub fn summary(kind: &Kind) -> &'static str {
    kind.doc.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().trim_start_matches("# ")
}

/// The page of a kind: its text, its keys and what it reads.
pub fn page(registry: &Registry, kind: &Kind) -> String {
    let mut page = format!("# {}.{}\n\n{}\n\n", registry.name, kind.name, kind.doc.trim());
    if let Some(facts) = registry.facts {
        return page + &facts(kind);
    }
    let _ = write!(page, "Written in `{}` as `kind = \"{}\"`", registry.place, kind.name);
    page += if registry.place.contains(".NAME") {
        ", which may be left out when NAME is the kind.\n"
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
        "# The kinds\n\nWhat may be written as `kind` of each table of a spec, with its keys, and the \
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

/// The tables inside a type, whose keys get rows of their own.
pub fn tables(ty: &Ty) -> Vec<&'static [Param]> {
    match ty {
        Ty::Table(params) => vec![params],
        Ty::OneOf(types) => types.iter().flat_map(tables).collect(),
        Ty::List(item) | Ty::Named(item) => tables(item),
        _ => Vec::new(),
    }
}

/// What a key takes, in words: its type, and how many items of it.
pub fn takes(param: &Param) -> String {
    let words = describe(&param.ty);
    match param.length {
        Some(length) => words.replacen("a list,", &format!("a list of {length},"), 1),
        None => words,
    }
}

/// A type in words: `a length ("1 m")`.
pub fn describe(ty: &Ty) -> String {
    match ty {
        Ty::Flag => "true or false".to_owned(),
        Ty::Count => "a count".to_owned(),
        Ty::Number => "a number".to_owned(),
        Ty::Quantity(dimension) => quantity(*dimension),
        Ty::Ratio(reference) => format!("a share of {reference} (`%`)"),
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
