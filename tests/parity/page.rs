//! `docs/reference/parity.md`: what the suite measured, between words that say what it means.

use std::fs;
use std::path::Path;

use super::defects::strays;
use super::ground::{CONTACTS, Contact, Impact};
use super::table::{Row, markdown, number};

const INTRODUCTION: &str = include_str!("introduction.md");
const CONTACT: &str = include_str!("contact.md");
const DEFECTS: &str = include_str!("defects.md");

/// The page.
pub fn text(tables: &[(String, Vec<Row>)], impacts: &[(String, Vec<Impact>)]) -> String {
    let mut text = format!("{INTRODUCTION}\n## Quantities\n");
    for (robot, rows) in tables {
        text += &format!("\n### {robot}\n\n{}", markdown(rows));
    }
    let [off, at] = strays().map(|stray| number(f64::from(stray)));
    let defects = DEFECTS.replace("ROOT_OFF", &off).replace("ROOT_AT", &at);
    text + "\n" + &CONTACT.replace("TABLE\n", &stiffness(impacts)) + "\n" + &defects
}

/// The table of contact stiffness: peaks in weights, depth in mm.
fn stiffness(impacts: &[(String, Vec<Impact>)]) -> String {
    let mut text = "| engine | step | `contact_time` |".to_owned();
    impacts.iter().for_each(|(robot, _)| text += &format!(" {robot} |"));
    text += "\n|---|---|---|";
    impacts.iter().for_each(|_| text += "---|");
    for (index, contact) in CONTACTS.iter().enumerate() {
        text += &format!("\n{}", setting(contact));
        impacts.iter().for_each(|(_, impacts)| text += &format!(" {} |", cell(&impacts[index])));
    }
    text + "\n"
}

/// The first cells of a row.
fn setting((engine, step, time): &Contact) -> String {
    let time = time.map_or("-".to_owned(), |time| format!("{} ms", 1e3 * time));
    format!("| {engine} | {} ms | {time} |", 1e3 * step)
}

fn cell(impact: &Impact) -> String {
    let depth = impact.depth.map_or("falls".to_owned(), |depth| format!("{} mm", number(1e3 * depth)));
    format!("{}, {}, {depth}", number(impact.mean), number(impact.peak))
}

/// Compares the page with the file, or writes it.
pub fn assert_blessed(page: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/parity.md");
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(&path, page).expect("the folder is there");
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    let changed = page.lines().zip(stored.lines()).find(|(now, then)| now != then);
    assert!(
        stored == page,
        "docs/reference/parity.md is not what the suite measures, first in {changed:?}; SPECFORGE_BLESS=1 \
         writes it again"
    );
}
