//! docs/explanation/paper_claims.md says of every claim of the paper's suites what the suites say and what
//! their tests can decide. SPECFORGE_BLESS=1 writes the numbers again; the words and the numbers of other
//! tests are written by hand.

#![cfg(all(feature = "batch", feature = "rapier", feature = "mujoco"))]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value as Json;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn document() -> PathBuf {
    root().join("docs/explanation/paper_claims.md")
}

/// What the tests of a suite's claims can decide, as the program says.
fn planned(suite: &Path) -> Vec<Json> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_specforge"));
    command
        .current_dir(root())
        .args(["plan", "--power", "--profile", "paper", "--format", "json"])
        .arg(suite);
    let output = command.output().expect("the program runs");
    assert!(output.status.success(), "{}: {}", suite.display(), String::from_utf8_lossy(&output.stderr));
    let answer: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    answer["claims"].as_array().expect("claims").clone()
}

fn claims(suite: &Path) -> Vec<toml::Table> {
    let suite: toml::Table = fs::read_to_string(root().join(suite)).expect("a suite").parse().expect("TOML");
    let claims = suite["claim"].as_array().expect("claims").iter();
    claims.map(|claim| claim.as_table().expect("a table").clone()).collect()
}

/// Three significant digits, as the program prints numbers.
fn short(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (2 - value.abs().log10().floor() as i32).max(0) as usize };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The cell about the power of a claim, where the program computes it.
fn power(claim: &toml::Table, planned: &Json) -> Option<String> {
    if let Some(told) = planned["successes"]["told"].as_str() {
        return Some(told.to_owned());
    }
    let text = |key: &str| {
        let value = claim.get(key)?;
        Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))
    };
    let share = 100.0 * planned["power"].as_f64()?;
    let needed = match planned["seeds_needed"].as_u64() {
        Some(seeds) if share < 80.0 => format!("; 80 % need {seeds} seeds"),
        _ => String::new(),
    };
    Some(format!(
        "at an effect of {} and a spread of {}: {} %{needed}",
        text("effect")?,
        text("spread")?,
        short(share)
    ))
}

/// The table of a suite in the document: the first line says how many claims there are, the rows begin with
/// their names.
fn section(text: &str, name: &str) -> Option<(usize, usize)> {
    let start = text.find(&format!("\n## {name}\n")).or_else(|| text.find(&format!("\n## {name},")))? + 1;
    let end = text[start..].find("\n## ").map_or(text.len(), |end| start + end);
    Some((start, end))
}

#[test]
fn the_document_of_the_papers_claims_says_what_the_suites_say() {
    let mut suites: Vec<PathBuf> = fs::read_dir(root().join("specs/paper"))
        .expect("suites")
        .map(|entry| Path::new("specs/paper").join(entry.expect("an entry").file_name()))
        .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("paper_")))
        .filter(|path| fs::read_to_string(root().join(path)).is_ok_and(|text| text.contains("[[claim]]")))
        .collect();
    suites.push("specs/paper/control_rate.toml".into());
    let committed = fs::read_to_string(document()).expect("the document");
    let mut text = committed.clone();
    for suite in suites {
        let name = suite.file_stem().expect("a name").to_string_lossy().into_owned();
        let (start, end) = section(&text, &name).unwrap_or_else(|| panic!("no section about {name}"));
        let (claims, planned) = (claims(&suite), planned(&suite));
        let planned: BTreeMap<&str, &Json> =
            planned.iter().map(|planned| (planned["id"].as_str().expect("a name"), planned)).collect();
        let level = short(planned.values().next().expect("a claim")["level"].as_f64().expect("a level"));
        let mut known: BTreeMap<String, String> = text[start..end]
            .lines()
            .filter_map(|line| {
                Some((line.strip_prefix("| `")?.split('`').next()?.to_owned(), line.to_owned()))
            })
            .collect();
        let mut section = text[start..end].to_owned();
        let noun = if claims.len() == 1 { "claim" } else { "claims" };
        let head = format!("{} {noun}: the smallest p value must be below {level} (Holm).", claims.len());
        let old =
            section.lines().find(|line| line.contains("the smallest p value must be below")).expect("a head");
        let rest = old.split_once("(Holm).").expect("a head").1.to_owned();
        section = section.replacen(&old.to_owned(), &format!("{head}{rest}"), 1);
        for claim in &claims {
            let own =
                |key: &str| claim.get(key).and_then(|value| value.as_str()).unwrap_or_default().to_owned();
            let id = own("id");
            let row = known.remove(&id).unwrap_or_else(|| panic!("{name}: no row about `{id}`"));
            let mut words =
                vec![own("metric"), own("expect"), own("test"), own("baseline"), own("parameter")];
            let table =
                |key: &str| claim.get(key).and_then(|value| value.as_table()).cloned().unwrap_or_default();
            words.extend(table("compare").values().filter_map(|side| Some(side.as_str()?.to_owned())));
            words.push(own("arm"));
            words.push(
                table("paper").get("value").and_then(|value| value.as_str()).unwrap_or_default().to_owned(),
            );
            for word in words {
                assert!(row.replace("\\|", "|").contains(&word), "{name}: the row of `{id}` lacks `{word}`");
            }
            let is_weaker = table("paper").get("weaker").and_then(toml::Value::as_bool) == Some(true);
            assert_eq!(row.contains("(weaker)"), is_weaker, "{name}: `{id}`");
            let Some(power) = power(claim, planned[id.as_str()]) else { continue };
            let cells = row.trim_end_matches(" |").rsplit_once(" | ").expect("cells").0;
            section = section.replacen(&row, &format!("{cells} | {power} |"), 1);
            if let Some(policies) = planned[id.as_str()]["successes"]["policies"].as_u64() {
                let episodes = planned[id.as_str()]["successes"]["episodes"].as_u64().expect("episodes");
                let noun = if policies == 1 { "policy" } else { "policies" };
                assert!(
                    cells.ends_with(&format!("wilson, {policies} {noun} of {episodes} episodes")),
                    "{name}: {cells}"
                );
            }
        }
        assert!(known.is_empty(), "{name}: rows of no claim: {known:?}");
        text.replace_range(start..end, &section);
    }
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        fs::write(document(), &text).expect("the document can be written");
    }
    let committed = fs::read_to_string(document()).expect("the document");
    assert!(committed == text, "write it again with `SPECFORGE_BLESS=1 cargo test --test paper_claims`");
}
