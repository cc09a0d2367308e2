//! Claims as users write them, valid and invalid.

use super::*;
use crate::diag::{Diagnostic, Sources};
use crate::syntax::Item;

/// Decodes the first `[[claim]]` of a text; the codes and the marked places of its mistakes.
fn read(text: &str) -> (Option<Claim>, Vec<(&'static str, String)>) {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let document = crate::syntax::parse(&sources, source, &mut sink).expect("TOML");
    let Some(Item::List(claims)) = document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
    else {
        panic!("a claim");
    };
    let claim = decode(&claims[0], &mut sink);
    let marked = |found: &Diagnostic| text[found.labels[0].span.start..found.labels[0].span.end].to_owned();
    let found = sink.diagnostics.iter().map(|found| (found.code, marked(found))).collect();
    (claim, found)
}

const SOUND: &str = r#"
[[claim]]
id      = "torque_survives"
text    = "The torque policy survives more"
metric  = "evaluate.nominal.survival"
compare = { a = "control=torque", b = "control=position,stiffness=100 %" }
expect  = "a > b"
paper   = { where = "Exp. 1", value = "it fails" }
"#;

/// A claim about these arms.
pub fn sample(a: &str, b: Option<&str>) -> Claim {
    let (line, expect) = match b {
        Some(b) => (format!("compare = {{ a = \"{a}\", b = \"{b}\" }}"), "a > b"),
        None => (format!("arm = \"{a}\""), "a > 0.5"),
    };
    let text = with("compare", &line).replace("a > b", expect);
    read(&text).0.expect("a sound claim")
}

/// The claim with one line replaced.
fn with(key: &str, line: &str) -> String {
    let lines = SOUND.lines().map(|old| if old.split_whitespace().next() == Some(key) { line } else { old });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_claim_is_read_whole_with_its_defaults() {
    let (claim, found) = read(SOUND);
    assert!(found.is_empty(), "{found:?}");
    let claim = claim.expect("sound");
    assert_eq!((claim.id.as_str(), claim.test.as_str(), claim.alpha), ("torque_survives", "welch", 0.05));
    assert_eq!((claim.metric.stage.as_str(), claim.metric.name.as_str()), ("evaluate.nominal", "survival"));
    assert_eq!(claim.sides["b"].written(), "control=position,stiffness=100 %");
    assert_eq!((claim.expect.written().as_str(), claim.summary, claim.over), ("a > b", Summary::Mean, None));
    assert_eq!(claim.paper.map(|paper| paper.place).as_deref(), Some("Exp. 1"));
}

#[test]
fn the_places_of_axes_and_points_are_kept() {
    let claim = read(SOUND).0.expect("sound");
    let mark = claim.marks.get("compare.b.1").expect("a term");
    let text = |span: Span| &SOUND[span.start..span.end];
    assert_eq!((text(mark.key), text(mark.value)), ("stiffness", "100 %"));
    assert_eq!(text(claim.marks.get("metric.name").expect("a metric").value), "survival");
    assert_eq!(text(claim.marks.get("expect.right").expect("a side").value), "b");
}

#[test]
fn a_claim_about_one_arm_takes_a_number() {
    let text = with("compare", "arm = \"control=torque\"").replace("a > b", "a > 90 %");
    let (claim, found) = read(&text);
    assert!(found.is_empty(), "{found:?}");
    let claim = claim.expect("sound");
    assert_eq!(claim.sides.keys().collect::<Vec<_>>(), ["a"]);
}

#[test]
fn each_mistake_has_its_code_and_place() {
    let one = |text: String| {
        let (claim, found) = read(&text);
        assert!(claim.is_none(), "{text}");
        assert_eq!(found.len(), 1, "{found:?}");
        found.into_iter().next().unwrap_or_default()
    };
    let is = |code, place: &str| (code, place.to_owned());
    assert_eq!(one(with("expect", "expect = \"c > b\"")), is("E0803", "c"));
    assert_eq!(one(with("expect", "expect = \"a == b\"")), is("E0103", "a == b"));
    assert_eq!(one(with("expect", "expect = \"a > 0.9\"")), is("E0103", "\"a > 0.9\""));
    assert_eq!(one(with("metric", "metric = \"survival\"")), is("E0103", "\"survival\""));
    assert_eq!(one(with("compare", "")).0, "E0101");
    assert_eq!(one(with("paper", "arm = \"control=torque\"")), is("E0105", "arm"));
    assert_eq!(one(with("compare", "compare = { a = \"torque\", b = \"x=y\" }")), is("E0103", "torque"));
    assert_eq!(one(with("id", "id = \"two words\"")), is("E0103", "\"two words\""));
    assert_eq!(one(with("paper", "alpha = 0.7")), is("E0204", "0.7"));
    assert_eq!(one(with("paper", "margin = -0.1")), is("E0204", "-0.1"));
    assert_eq!(one(with("paper", "margin = \"5 parsec\"")), is("E0202", "parsec"));
    assert_eq!(one(with("paper", "over = \"some\"")), is("E0106", "\"some\""));
    assert_eq!(one(with("paper", "allpha = 0.1")), is("E0102", "allpha"));
    assert_eq!(one(with("paper", "spread = -0.1")), is("E0204", "-0.1"));
    assert_eq!(one(with("paper", "relative = true")), is("E0105", "true"));
    assert_eq!(
        one(with("paper", "over = { at_least = 2, some = \"std\" }")),
        is("E0105", "{ at_least = 2, some = \"std\" }")
    );
    let both = with("paper", "margin = 0.1").replace("a > b", "a == b within 5 %");
    assert_eq!(one(both), is("E0105", "margin"));
}

#[test]
fn independent_mistakes_are_all_reported() {
    let text = with("metric", "metric = \"survival\"").replace("a > b", "a b");
    let codes: Vec<_> = read(&text).1.into_iter().map(|(code, _)| code).collect();
    assert_eq!(codes, ["E0103", "E0103"]);
}

#[test]
fn a_claim_is_the_same_when_it_is_made_again_of_its_table() {
    let changed = with(
        "paper",
        "baseline = \"evaluate.flat\"\nrelative = true\nspread = 0.1\neffect = -0.2\nover = { at_most = 0 }",
    )
    .replace("a > b", "a > 0.5 * b - 10 %");
    for text in [
        SOUND.to_owned(),
        with("paper", "margin = \"5 %\"\nover = \"each\""),
        with("paper", "margin = 0.05"),
        changed,
    ] {
        let claim = read(&text).0.expect("sound");
        let again = Claim::of_table(&claim.fields).expect("a claim");
        let written = serde_json::to_string(&claim).expect("JSON");
        let read: Claim = serde_json::from_str(&written).expect("a claim");
        assert_eq!((&again, &read), (&Claim { marks: again.marks.clone(), ..claim }, &again));
    }
}

/// The advice for the first `[[claim]]` of a text.
fn advice(text: &str) -> Vec<String> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let document = crate::syntax::parse(&sources, source, &mut sink).expect("TOML");
    let Some(Item::List(claims)) = document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
    else {
        panic!("a claim");
    };
    decode(&claims[0], &mut sink);
    sink.diagnostics.into_iter().flat_map(|found| found.help).collect()
}

#[test]
fn advice_that_is_followed_is_accepted() {
    let follow = |wrong: &str, advised: &str, right: &str| {
        let text = with("paper", wrong);
        let help = advice(&text).concat();
        assert!(help.contains(advised), "{wrong}: {help}");
        let found = read(&text.replace(wrong, right)).1;
        assert!(found.is_empty(), "{right}: {found:?}");
    };
    follow("alpha = \"5 %\"", "`alpha = 0.05`", "alpha = 0.05");
    follow("margin = true", "`margin = 1`", "margin = 1");
    follow(
        "paper = \"Exp. 1\"",
        "`paper = { where = \"...\", value = \"...\" }`",
        "paper = { where = \"...\", value = \"...\" }",
    );
    // A key that is already present is not suggested for a wrong key.
    let twice = advice(&with("paper", "paper = { where = \"Exp. 1\", value = \"it falls\", weake = true }"));
    assert_eq!(twice, ["did you mean `weaker`?"]);
    let third = with(
        "compare",
        "compare = { a = \"control=torque\", b = \"control=position\", c = \"control=position\" }",
    );
    assert_eq!(advice(&third), ["remove it: the valid keys are `a` and `b`"]);
    let alone = with("compare", "arm = \"control=torque\"");
    let help = advice(&alone).concat();
    assert!(help.contains("`expect = \"a > 90 %\"`"), "{help}");
    assert!(read(&alone.replace("a > b", "a > 90 %")).1.is_empty());
}
