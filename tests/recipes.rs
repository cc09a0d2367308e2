//! What recipes leave out, and what must therefore not change unnoticed: a default that is changed gives
//! other results under the same recipe.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value as Json;
use specforge::kinds::{motion, vocabulary};
use specforge::robot;
use specforge::spec::{Kind, Param, Presence, Shape, Ty};

/// Compares with a file of this folder, or writes it when SPECFORGE_BLESS is set.
fn compare(name: &str, found: &str, advice: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        std::fs::write(&path, found).expect("the folder is writable");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
    let (known, found) = (lines(&known), lines(found));
    let gone: Vec<_> = known.difference(&found).collect();
    let new: Vec<_> = found.difference(&known).collect();
    assert!(gone.is_empty() && new.is_empty(), "{advice}\ngone: {gone:#?}\nnew: {new:#?}");
}

fn keys(path: &str, params: &[Param], lines: &mut Vec<String>) {
    for param in params {
        let own = format!("{path}.{}", param.name);
        if let Presence::Default(text) = param.presence {
            lines.push(format!("{own} = {text}"));
        }
        below(&own, &param.ty, lines);
    }
}

fn below(path: &str, ty: &Ty, lines: &mut Vec<String>) {
    match ty {
        Ty::Table(params) => keys(path, params, lines),
        Ty::List(item) | Ty::Named(item) => below(path, item, lines),
        Ty::OneOf(types) => types.iter().for_each(|ty| below(path, ty, lines)),
        // Those of another section stand there.
        _ => {}
    }
}

#[test]
fn every_default_is_the_one_that_recipes_leave_out() {
    let mut lines = Vec::new();
    let kind = |section: &str, kind: &Kind, lines: &mut Vec<String>| {
        keys(&format!("{section} {}", kind.name), kind.params, lines);
    };
    for section in vocabulary::vocabulary().sections {
        match &section.shape {
            Shape::Plain(params) => keys(section.name, params, &mut lines),
            Shape::Kind(kinds) => kinds.iter().for_each(|one| kind(section.name, one, &mut lines)),
            Shape::Terms(kinds, extra) => {
                kinds.iter().for_each(|one| kind(section.name, one, &mut lines));
                keys(section.name, extra, &mut lines);
            }
        }
    }
    motion::kinds().iter().for_each(|one| kind("motion", one, &mut lines));
    lines.sort();
    lines.dedup();
    assert!(lines.len() > 80, "{lines:?}");
    let advice = "A recipe leaves out keys with their defaults. A new key may have a default that gives the \
        old behaviour. \
                  If another default changes, raise the revision of its kind in src/plan/revision.rs. Then \
                  run this test with \
                  SPECFORGE_BLESS=1.";
    compare("defaults.txt", &(lines.join("\n") + "\n"), advice);
}

/// The keys of a tree, lists as `[]`.
fn paths(value: &Json, above: &str, found: &mut BTreeSet<String>) {
    match value {
        Json::Object(map) => map.iter().for_each(|(key, value)| {
            let own = format!("{above}.{key}");
            found.insert(own.clone());
            paths(value, &own, found);
        }),
        Json::Array(items) => items.iter().for_each(|item| paths(item, &format!("{above}[]"), found)),
        _ => {}
    }
}

#[test]
fn a_recipe_has_the_figures_of_a_robot_that_this_list_has() {
    let mut found = BTreeSet::new();
    for name in robot::names() {
        let robot = robot::load::shipped(name).expect("a shipped robot");
        paths(&serde_json::to_value(robot).expect("plain data"), "robot", &mut found);
    }
    let advice = "A new figure of a robot is left out of its JSON where its value gives the old behaviour \
                  (`skip_serializing_if`), and what is only seen never stands in it: otherwise every stage \
                  of every robot is \
                  made anew. Then run this test with SPECFORGE_BLESS=1.";
    compare("robot_figures.txt", &(found.into_iter().collect::<Vec<_>>().join("\n") + "\n"), advice);
}
