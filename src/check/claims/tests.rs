//! Mistakes of claims against a small suite.

use std::collections::BTreeMap;

use super::*;
use crate::diag::Sources;
use crate::spec::Value;
use crate::syntax::Item;

const CLAIM: &str = r#"
[[claim]]
id      = "torque_survives"
text    = "The torque policy survives more"
metric  = "evaluate.nominal.survival"
compare = { a = "control=torque", b = "control=position,stiffness=100 %" }
expect  = "a > b"
test    = "welch"
"#;

fn spec() -> Table {
    let table = |entries: &[(&str, Value)]| {
        Value::Table(entries.iter().map(|(k, v)| (k.to_string(), v.clone())).collect())
    };
    let kind = |word: &str| table(&[("kind", Value::Text(word.to_owned()))]);
    let deploy = table(&[("policy", kind("export")), ("mujoco", kind("transfer"))]);
    let evaluate = table(&[("nominal", kind("episodes"))]);
    BTreeMap::from([
        ("evaluate".to_owned(), evaluate),
        ("deploy".to_owned(), deploy),
        ("learn".to_owned(), kind("ppo")),
    ])
}

/// The mistakes in claims of a suite with this many seeds: code, marked text and first help.
fn found(text: &str, runs: usize) -> Vec<(&'static str, String, String)> {
    found_in(text, runs, &spec())
}

/// The same for a suite whose arms have these fields.
fn found_in(text: &str, runs: usize, fields: &Table) -> Vec<(&'static str, String, String)> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let document = crate::syntax::parse(&sources, source, &mut sink).expect("TOML");
    let Some(Item::List(nodes)) = document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
    else {
        panic!("claims");
    };
    let arm = |control: &str, stiffness: &str| {
        [("control", control), ("stiffness", stiffness)]
            .map(|(axis, point)| (axis.to_owned(), point.to_owned()))
            .to_vec()
    };
    let mut points = vec![arm("torque", "100 %"), arm("position", "100 %"), arm("position", "50 %")];
    if text.contains("trend =") {
        points.push(arm("position", "25 %"));
    }
    let scope = Scope {
        axes: vec![("control", vec!["torque", "position"]), ("stiffness", vec!["100 %", "50 %"])],
        arms: points.iter().map(|points| ArmScope { points, fields, robot: None, runs }).collect(),
        seeds: None,
        counted: text.contains("# counted"),
        shortened: false,
    };
    let sound = claims(nodes, &scope, &mut sink);
    assert_eq!(sound.len() < nodes.len(), sink.has_errors());
    let marked = |found: &Diagnostic| {
        found
            .labels
            .first()
            .map(|label| text[label.span.start..label.span.end].to_owned())
            .unwrap_or_default()
    };
    let help = |found: &Diagnostic| found.help.first().cloned().unwrap_or_default();
    sink.diagnostics.iter().map(|found| (found.code, marked(found), help(found))).collect()
}

/// The only mistake.
#[track_caller]
fn one(text: &str, runs: usize) -> (&'static str, String, String) {
    let found = found(text, runs);
    assert_eq!(found.len(), 1, "{found:#?}");
    found.into_iter().next().unwrap_or_default()
}

#[track_caller]
fn is((code, marked, help): (&'static str, String, String), expected: [&str; 3]) {
    assert_eq!([code, &marked], [expected[0], expected[1]], "{help}");
    assert!(help.contains(expected[2]), "{help}");
}

#[test]
fn a_claim_about_arms_and_metrics_that_are_there_is_sound() {
    assert!(found(CLAIM, 5).is_empty());
    let transfer = CLAIM.replace("evaluate.nominal.survival", "deploy.mujoco.peak_foot_force");
    assert!(found(&transfer, 5).is_empty());
    assert!(found(&CLAIM.replace("evaluate.nominal.survival", "learn.final_return"), 5).is_empty());
}

#[test]
fn an_axis_or_a_point_that_is_not_there_is_e0803() {
    is(one(&CLAIM.replace("=torque", "=torqe"), 3), ["E0803", "torqe", "did you mean `torque`?"]);
    is(one(&CLAIM.replace(",stiffness", ",stifness"), 3), ["E0803", "stifness", "did you mean `stiffness`?"]);
    is(one(&CLAIM.replace("=100 %", "=7 %"), 3), ["E0803", "7 %", "`100 %` and `50 %`"]);
    let excluded = CLAIM.replace("control=torque", "control=torque,stiffness=50 %");
    is(one(&excluded, 3), ["E0803", "\"control=torque,stiffness=50 %\"", "excluded"]);
}

#[test]
fn several_arms_need_a_word_on_what_is_claimed_of_them() {
    let text = CLAIM
        .replace(
            "compare = { a = \"control=torque\", b = \"control=position,stiffness=100 %\" }",
            "arm = \"control=position\"",
        )
        .replace("a > b", "a > 0.5");
    let (code, _, help) = one(&text, 3);
    assert_eq!(code, "E0806");
    assert!(help.contains("`stiffness=100 %` and `stiffness=50 %`") && help.contains("over"), "{help}");
    assert!(found(&format!("{text}over = \"each\"\n"), 3).is_empty());
    assert!(found(&format!("{text}over = \"mean\"\n"), 3).is_empty());
}

#[test]
fn an_arm_without_a_counterpart_is_e0806() {
    let text = CLAIM.replace(",stiffness=100 %", "");
    let (code, _, help) = one(&text, 3);
    assert_eq!((code, help.contains("name the axes")), ("E0806", true));
}

#[test]
fn a_metric_that_no_stage_produces_is_e0804() {
    is(one(&CLAIM.replace("survival\"", "survivl\""), 3), ["E0804", "survivl", "did you mean `survival`?"]);
    is(
        one(&CLAIM.replace(".nominal", ".nominl"), 3),
        ["E0804", "evaluate.nominl", "did you mean `evaluate.nominal`?"],
    );
    is(
        one(&CLAIM.replace("evaluate.nominal", "deploy.policy"), 3),
        ["E0804", "deploy.policy", "deploy.mujoco"],
    );
    is(one(&CLAIM.replace("evaluate.nominal", "learn"), 3), ["E0804", "learn", "evaluate.NAME.survival"]);
    let unknown = CLAIM.replace("evaluate.nominal.survival", "learn.samples_to_threshold");
    is(one(&unknown, 3), ["E0101", "samples_to_threshold", "threshold = 100"]);
}

#[test]
fn numbers_of_a_claim_are_in_the_metrics_unit() {
    let speed = CLAIM.replace("survival", "speed");
    is(one(&format!("{speed}margin = 0.1\n"), 5), ["E0201", "0.1", "0.1 m/s"]);
    is(one(&speed.replace("a > b", "a == b within 5 %"), 5), ["E0203", "5 %", "`m/s`"]);
    assert!(found(&speed.replace("a > b", "a == b within 0.1 m/s"), 5).is_empty());
    assert!(found(&format!("{CLAIM}margin = \"5 %\"\n"), 5).is_empty());
}

#[test]
fn a_test_that_does_not_suit_the_claim_is_e0807() {
    let with = |test: &str| CLAIM.replace("welch", test);
    is(one(&with("mcnemarr"), 3), ["E0301", "\"mcnemarr\"", "did you mean `mcnemar`?"]);
    is(one(&with("mcnemar").replace("survival\"", "speed\""), 3), ["E0807", "\"mcnemar\"", "`welch`"]);
    is(one(&with("wilson"), 3), ["E0807", "\"wilson\"", "`mcnemar`"]);
    is(one(&format!("{}summary = \"iqm\"\n", with("welch")), 3), ["E0807", "\"iqm\"", "remove `summary`"]);
    is(
        one(&format!("{}over = \"mean\"\n", with("mann_whitney")), 4),
        ["E0807", "\"mean\"", "over = \"each\""],
    );
    is(
        one(&format!("{}baseline = \"deploy.mujoco\"\n", with("mcnemar")), 3),
        ["E0807", "\"deploy.mujoco\"", "welch"],
    );
    is(one(&with("probability_of_improvement").replace("a > b", "a > 2 * b"), 10), ["E0807", "b", "welch"]);
}

#[test]
fn samples_to_a_threshold_are_compared_between_two_arms_within_a_training() {
    let count = |number: u64| Value::Count(number);
    let learn =
        [("kind", Value::Text("ppo".into())), ("samples", count(1_000_000)), ("rollout", count(4000))];
    let mut fields = spec();
    let learn: Table = learn.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    fields.insert("learn".to_owned(), Value::Table(learn));
    let two = CLAIM.replace("evaluate.nominal.survival", "learn.samples_to_threshold") + "threshold = 100\n";
    let two = two.replace("welch", "mann_whitney").replace("a > b", "a < b");
    let found = |text: &str| found_in(text, 5, &fields);
    assert_eq!(found(&two), []);
    assert_eq!(found(&two.replace("a < b", "a < b - 1000000")), []);
    for (text, marked) in [
        (two.replace("a < b", "a < b - 1000001"), "1000001"),
        (two.replace("a < b", "a == b within 2000000"), "2000000"),
        (two.clone() + "margin = 1e30\n", "1e30"),
    ] {
        let found = found(&text);
        assert_eq!(found, [("E0204", marked.to_owned(), "write 1000000 or less".to_owned())]);
    }
    // Follows the help: first that of the default test, then that of a rank test.
    let patterns = "compare = { a = \"control=torque\", b = \"control=position,stiffness=100 %\" }";
    let one = two.replace(patterns, "arm = \"control=torque\"").replace("a < b", "a < 500000");
    for test in ["welch", "mann_whitney"] {
        let found = found(&one.replace("mann_whitney", test));
        let [(code, _, help)] = found.as_slice() else { panic!("{found:#?}") };
        assert_eq!(*code, "E0807");
        assert!(help.contains("`compare` with two arms") && help.contains("a < b"), "{help}");
        assert!(help.contains("mann_whitney"), "{help}");
    }
}

#[test]
fn too_few_seeds_are_e0805_and_one_seed_is_w0504_unless_claims_count() {
    is(one(CLAIM, 1), ["W0504", "[[claim]]", "more seeds"]);
    is(one(&format!("{CLAIM}# counted\n"), 1), ["E0805", "\"welch\"", "seeds = 2"]);
    is(
        one(&CLAIM.replace("welch", "stratified_bootstrap"), 9),
        ["E0805", "\"stratified_bootstrap\"", "seeds = 10"],
    );
    is(one(&CLAIM.replace("welch", "mann_whitney"), 3), ["E0805", "\"mann_whitney\"", "seeds = 4"]);
    is(one(&CLAIM.replace("welch", "mcnemar"), 1), ["W0504", "[[claim]]", "more seeds"]);
    assert!(found(&CLAIM.replace("welch", "mcnemar"), 2).is_empty());
    // Three runs cannot have a p value below 0.002.
    let strict = CLAIM.replace("survival", "speed") + "alpha = 0.001\n";
    is(one(&strict, 3), ["E0805", "\"welch\"", "seeds = 5"]);
    assert!(found(&strict, 5).is_empty());
}

#[test]
fn the_advice_for_a_claim_that_can_only_pass_counts_its_margin() {
    let with = |expect: &str, margin: &str| {
        let claim = share(expect).replace("wilson", "welch");
        one(&format!("{claim}margin = \"{margin}\"\n"), 3)
    };
    let (code, _, help) = with("a >= 10 %", "50 %");
    let told = "write a number above 50 %, or a `margin` below 10 %";
    assert!(code == "W1001" && help.contains(told), "{help}");
    assert!(with("a <= 90 %", "50 %").2.contains("write a number below 50 %, or a `margin` below 10 %"));
    assert!(with("a >= 0 %", "50 %").2.contains("write a number above 50 %,"), "no margin is small enough");
    for (expect, margin) in [("a >= 51 %", "50 %"), ("a >= 10 %", "9 %")] {
        let claim = format!("{}margin = \"{margin}\"\n", share(expect).replace("wilson", "welch"));
        assert!(found(&claim, 3).iter().all(|told| told.0 != "W1001"), "{expect}, {margin}");
    }
}

#[test]
fn a_claim_that_can_only_pass_is_w1001() {
    is(one(&share("a >= 0 %").replace("wilson", "welch"), 3), ["W1001", "\"a >= 0 %\"", "smallest effect"]);
    is(
        one(&format!("{}margin = \"5 %\"\n", share("a >= 0 %")), 3),
        ["W1001", "\"a >= 0 %\"", "smallest effect"],
    );
    // 8 of 8 episodes have the interval [67.6, 100] %, so that `a > 60 %` can pass; 0 of 8 end at 32.4 %.
    let few = |expect: &str, episodes: u64| {
        let (mut fields, nominal) = (spec(), Table::from([("episodes".to_owned(), Value::Count(episodes))]));
        fields.insert(
            "evaluate".to_owned(),
            Value::Table(Table::from([("nominal".to_owned(), Value::Table(nominal))])),
        );
        found_in(&share(expect), 1, &fields)
            .into_iter()
            .filter(|found| found.0 != "W0504")
            .collect::<Vec<_>>()
    };
    assert!(few("a > 60 %", 8).is_empty());
    is(few("a > 30 %", 8).remove(0), ["W1001", "\"a > 30 %\"", "9 episodes or more"]);
    // One of many comparisons is refuted at alpha divided by their number.
    let many = CLAIM
        .replace(
            "compare = { a = \"control=torque\", b = \"control=position,stiffness=100 %\" }",
            "arm = \"control=position\"\nover = \"each\"\nalpha = 0.003",
        )
        .replace("a > b", "a > 0.5");
    is(one(&many, 3), ["W1001", "\"each\"", "seeds = 5"]);
    assert!(found(&many, 5).is_empty());
}

#[test]
fn a_claim_of_the_paper_states_its_effect() {
    let paper = "paper = { where = \"Exp. 1\", value = \"it fails\" }\n";
    is(one(&format!("{CLAIM}{paper}"), 5), ["W1002", "\"a > b\"", "a > b + 20 %"]);
    for expect in ["a > b + 20 %", "a > 2 * b", "a == b within 5 %"] {
        assert!(found(&format!("{}{paper}", CLAIM.replace("a > b", expect)), 5).is_empty(), "{expect}");
    }
    assert!(found(&format!("{CLAIM}{paper}margin = \"20 %\"\n"), 5).is_empty());
}

#[test]
fn effects_and_baselines_have_the_metrics_dimension_and_a_stage() {
    let speed = CLAIM.replace("survival", "speed");
    is(one(&speed.replace("a > b", "a > b + 5 %"), 5), ["E0203", "5 %", "`m/s`"]);
    is(one(&format!("{speed}spread = \"5 N\"\n"), 5), ["E0203", "\"5 N\"", "`m/s`"]);
    is(one(&format!("{speed}effect = 0.1\n"), 5), ["E0201", "0.1", "0.1 m/s"]);
    is(
        one(&format!("{CLAIM}baseline = \"deploy.mujco\"\n"), 5),
        ["E0804", "\"deploy.mujco\"", "deploy.mujoco"],
    );
    let relative = format!("{speed}baseline = \"deploy.mujoco\"\nrelative = true\n");
    assert!(found(&relative, 5).is_empty());
    is(one(&format!("{relative}margin = \"0.1 m/s\"\n"), 5), ["E0203", "\"0.1 m/s\"", "bare number"]);
}

#[test]
fn a_metric_that_the_task_does_not_measure_is_e1001() {
    let squatting = |text: &str| {
        let mut fields = spec();
        let task = Table::from([("kind".to_owned(), Value::Text("squat".to_owned()))]);
        fields.insert("task".to_owned(), Value::Table(task));
        found_in(text, 5, &fields)
    };
    assert!(squatting(CLAIM).is_empty());
    let found = squatting(&CLAIM.replace("survival", "speed"));
    assert_eq!(found.len(), 1, "{found:?}");
    is(found.into_iter().next().unwrap_or_default(), ["E1001", "speed", "walk"]);
}

#[test]
fn comparisons_are_counted_by_a_number_that_leaves_a_choice() {
    let text = share("a > 80 %").replace("control=torque", "control=position");
    let with = |over: &str| found(&format!("{text}over = {{ {over} }}\n"), 1);
    let sound = |over: &str| with(over).iter().all(|found| found.0 == "W0504");
    assert!(sound("at_least = 1") && sound("at_most = 0") && sound("at_most = 1"));
    for over in ["at_least = 2", "at_least = 3", "at_most = 2"] {
        assert_eq!(with(over)[0].0, "E0806", "{over}");
    }
}

#[test]
fn an_offset_of_nothing_states_no_effect() {
    let paper = "paper = { where = \"Exp. 1\", value = \"it fails\" }\n";
    let text = format!("{}{paper}", CLAIM.replace("a > b", "a > b + 0 %"));
    assert_eq!(one(&text, 5).0, "W1002");
}

#[test]
fn what_is_assumed_of_a_share_must_be_possible() {
    let with = |more: &str| one(&format!("{}{more}\n", CLAIM.replace("a > b", "a > b + 20 %")), 5);
    is(with("effect = \"101 %\""), ["E0204", "\"101 %\"", "from -100 % to 100 %"]);
    is(with("spread = \"51 %\""), ["E0204", "\"51 %\"", "from 0 % to 50 %"]);
    is(with("spread = \"-1 %\""), ["E0204", "\"-1 %\"", "remove `spread`"]);
    let sound = |text: String| assert!(found(&text, 5).is_empty(), "{text}");
    is(
        one(&format!("{CLAIM}effect = \"21 %\"\nspread = \"50 %\"\n"), 5),
        ["W1003", "\"21 %\"", "seeds = 90"],
    );
    sound(format!("{}effect = 0\n", CLAIM.replace("a > b", "a == b within 5 %")));
    sound(format!("{}margin = \"5 %\"\neffect = 0\n", CLAIM.replace("a > b", "a >= b")));
}

#[test]
fn two_claims_of_one_name_are_e0104() {
    is(one(&format!("{CLAIM}{CLAIM}"), 5), ["E0104", "\"torque_survives\"", "another `id`"]);
}

/// The claim about one arm with the test `wilson`, and this expectation.
fn share(expect: &str) -> String {
    CLAIM
        .replace(
            "compare = { a = \"control=torque\", b = \"control=position,stiffness=100 %\" }",
            "arm = \"control=torque\"",
        )
        .replace("a > b", expect)
        .replace("welch", "wilson")
}

#[test]
fn what_no_result_of_the_episodes_can_establish_is_w0511() {
    // Wilson's interval of 32 of 32 is [89.28, 100] %, of 35 of 35 [90.11, 100] %.
    assert!(found(&share("a > 89 %"), 3).is_empty());
    is(one(&share("a > 90 %"), 3), ["W0511", "\"a > 90 %\"", "35 episodes or more"]);
    is(one(&share("a < 10 %"), 3), ["W0511", "\"a < 10 %\"", "35 episodes or more"]);
    is(one(&share("a > 100 %"), 3), ["W0511", "\"a > 100 %\"", "no number of episodes"]);
    // For a range its width matters: 16 of 32 are [33.6, 66.4] %.
    assert!(found(&share("a == 50 % within 17 %"), 3).is_empty());
    let (code, _, help) = one(&share("a == 50 % within 16 %"), 3);
    assert_eq!((code, help.contains("34 episodes")), ("W0511", true), "{help}");
}

#[test]
fn a_level_that_is_divided_needs_more_episodes() {
    let some = share("a > 89 %").replace("control=torque", "control=position");
    assert!(found(&format!("{some}over = \"each\"\n"), 3).is_empty());
    // At alpha / 2 the interval of 32 of 32 begins at 86.4 %.
    let (code, _, help) = one(&format!("{some}over = {{ some = \"stiffness\" }}\n"), 3);
    assert_eq!((code, help.contains("41 episodes")), ("W0511", true), "{help}");
    // `none` is established by one comparison of the three seeds at alpha / 3, and refuted at alpha / 2.
    let none = format!("{some}over = {{ none = \"stiffness\" }}\n");
    let (code, _, help) = one(&none, 3);
    assert_eq!((code, help.contains("41 episodes")), ("W1001", true), "{help}");
    assert!(found(&none.replace("89 %", "85 %"), 3).is_empty());
    assert_eq!(one(&none.replace("89 %", "5 %"), 3).0, "W0511");
}

#[test]
fn a_mean_of_shares_lies_between_its_ends() {
    let mean = |expect: &str| share(expect).replace("wilson", "welch");
    assert!(found(&mean("a > 97 %"), 5).is_empty());
    is(one(&mean("a >= 100 %"), 5), ["W0511", "\"a >= 100 %\"", "margin"]);
    assert!(found(&format!("{}margin = \"3 %\"\n", mean("a >= 100 %")), 5).is_empty());
    is(one(&mean("a < 0 %").replace("survival", "single_support"), 5), ["W0511", "\"a < 0 %\"", "weaken"]);
    // Speeds are unbounded.
    assert!(found(&mean("a < 0 m/s").replace("survival", "speed"), 5).is_empty());
    let apart = |margin: &str| format!("{CLAIM}margin = \"{margin}\"\n");
    assert!(found(&apart("99 %"), 5).is_empty());
    is(one(&apart("100 %"), 5), ["W0511", "\"a > b\"", "weaken"]);
}

#[test]
fn paired_episodes_must_be_able_to_differ_enough() {
    let few = |episodes: u64| {
        let (mut fields, nominal) = (spec(), Table::from([("episodes".to_owned(), Value::Count(episodes))]));
        fields.insert(
            "evaluate".to_owned(),
            Value::Table(Table::from([("nominal".to_owned(), Value::Table(nominal))])),
        );
        found_in(&CLAIM.replace("welch", "mcnemar"), 3, &fields)
    };
    // The exact p value of n of n pairs is 2^(1 - n).
    assert!(few(7).is_empty());
    // One of three seeds refutes at alpha / 3.
    is(few(6).remove(0), ["W1001", "\"a > b\"", "7 episodes or more"]);
    is(few(5).remove(0), ["W0511", "\"a > b\"", "6 episodes or more"]);
}

#[test]
fn the_example_of_an_effect_is_in_the_metrics_unit() {
    let paper = "paper = { where = \"Exp. 1\", value = \"it fails\" }\n";
    let speed = format!("{}{paper}", CLAIM.replace("survival", "speed").replace("a > b", "a < b"));
    let (code, _, help) = one(&speed, 5);
    assert_eq!(code, "W1002");
    assert!(
        help.contains("`margin = \"0.2 m/s\"`") && help.contains("`expect = \"a < b - 0.2 m/s\"`"),
        "{help}"
    );
    // The suggested text is accepted.
    assert!(found(&speed.replace("a < b", "a < b - 0.2 m/s"), 5).is_empty());
    let ratio = format!("{speed}baseline = \"deploy.mujoco\"\nrelative = true\n");
    is(one(&ratio, 5), ["W1002", "\"a < b\"", "`margin = 0.2`"]);
}

#[test]
fn an_effect_that_does_not_meet_its_claim_is_e0204() {
    let with = |expect: &str, effect: &str| {
        format!("{}effect = \"{effect}\"\nspread = \"2 %\"\n", CLAIM.replace("a > b", expect))
    };
    is(one(&with("a > b + 20 %", "10 %"), 5), ["E0204", "\"10 %\"", "of `a` minus `b`"]);
    is(one(&with("a < b", "10 %"), 5), ["E0204", "\"10 %\"", "expected"]);
    is(one(&with("a == b within 5 %", "6 %"), 5), ["E0204", "\"6 %\"", "expected"]);
    for (expect, effect) in [("a > b + 20 %", "30 %"), ("a < b", "-10 %"), ("a == b within 5 %", "0 %")] {
        assert!(found(&with(expect, effect), 5).is_empty(), "{expect}");
    }
    // "No setting learns" needs an effect that the expectation excludes.
    let none = |effect: &str| {
        share("a > 90 %").replace("wilson", "welch").replace("control=torque", "control=position")
            + &format!("over = {{ none = \"stiffness\" }}\neffect = \"{effect}\"\n")
    };
    assert!(found(&none("40 %"), 5).is_empty());
    is(one(&none("95 %"), 5), ["E0204", "\"95 %\"", "of the arm"]);
}

#[test]
fn claims_that_holms_correction_leaves_open_are_w0511() {
    let many = |claims: usize| -> String {
        (0..claims)
            .map(|claim| {
                CLAIM.replace("survival", "speed").replace("torque_survives", &format!("claim_{claim}"))
            })
            .collect()
    };
    // With under 5 runs no p is below 0.002, which is 0.05 / 25 claims.
    assert!(found(&many(25), 3).is_empty());
    let found_in_26 = found(&many(26), 3);
    assert_eq!(found_in_26.len(), 1, "told once: {found_in_26:?}");
    is(found_in_26.into_iter().next().unwrap_or_default(), ["W0511", "\"welch\"", "`seeds = 5`"]);
    assert!(found(&many(26), 5).is_empty());
    // Five against five have p >= 0.008, so six claims can be established but not seven, unless others come
    // first.
    let ranked = |claims: usize| many(claims).replace("welch", "mann_whitney");
    assert!(found(&ranked(6), 5).is_empty());
    is(found(&ranked(7), 5).remove(0), ["W0511", "\"mann_whitney\"", "`seeds = 6`"]);
    let beside = format!("{}{}", CLAIM.replace("survival", "speed"), ranked(6));
    assert!(found(&beside, 5).is_empty(), "the seventh is a test that can reach any level");
}

#[test]
fn differences_from_a_baseline_and_slopes_have_ends() {
    let baseline = |expect: &str| share(expect).replace("wilson", "welch") + "baseline = \"deploy.mujoco\"\n";
    assert!(found(&baseline("a < -50 %"), 3).is_empty());
    is(one(&baseline("a > 120 %"), 3), ["E0204", "120 %", "from -100 % to 100 %"]);
    is(one(&baseline("a > 100 %"), 3), ["W0511", "\"a > 100 %\"", "weaken"]);
    is(one(&baseline("a > -100 %"), 3), ["W1001", "\"a > -100 %\"", "smallest effect"]);
    assert!(found(&(baseline("a > 1.2") + "relative = true\n"), 3).is_empty());
    let trend = |expect: &str| {
        share(expect).replace("wilson", "welch").replace("control=torque", "control=position")
            + "over = { trend = \"stiffness\" }\n"
    };
    // With three points the steepest slope is 0 to 100 % over two steps.
    assert!(found(&trend("a > 49 %"), 3).is_empty());
    is(one(&trend("a > 50 %"), 3), ["W0511", "\"a > 50 %\"", "weaken"]);
}

/// The arms' spec with this many episodes in `evaluate.nominal`.
fn with_episodes(episodes: u64) -> Table {
    let (mut fields, nominal) = (spec(), Table::from([("episodes".to_owned(), Value::Count(episodes))]));
    fields.insert(
        "evaluate".to_owned(),
        Value::Table(Table::from([("nominal".to_owned(), Value::Table(nominal))])),
    );
    fields
}

/// The arms' spec with a reward of weights 0.5 and 0.25 at 100 Hz in episodes of 10 s, and this training.
fn with_training(samples: u64) -> Table {
    let number = |si: f64| Value::Quantity(crate::spec::Quantity { si, text: si.to_string() });
    let table = |entries: &[(&str, Value)]| -> Value {
        Value::Table(entries.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
    };
    let count = Value::Count;
    let learn = [("kind", Value::Text("ppo".into())), ("samples", count(samples)), ("rollout", count(4000))];
    let term = |weight: f64| table(&[("kind", Value::Text("torque".into())), ("weight", number(weight))]);
    let mut fields = spec();
    fields.insert("learn".to_owned(), table(&learn));
    fields
        .insert("task".to_owned(), table(&[("kind", Value::Text("walk".into())), ("episode", number(10.0))]));
    fields.insert(
        "action".to_owned(),
        table(&[("kind", Value::Text("torque".into())), ("rate", number(100.0))]),
    );
    fields.insert("reward".to_owned(), table(&[("one", term(0.5)), ("two", term(0.25))]));
    fields
}

#[test]
fn a_bound_at_the_end_of_any_metrics_range_is_told_with_the_number_to_write() {
    let force =
        |expect: &str| share(expect).replace("wilson", "welch").replace("survival", "peak_foot_force");
    is(one(&force("a < 0 N"), 3), ["W0511", "\"a < 0 N\"", "a number above 0 N"]);
    is(one(&force("a <= 0 N"), 3), ["W0511", "\"a <= 0 N\"", "above 0 N, or add a `margin`"]);
    is(one(&force("a > 0 N"), 3), ["W1001", "\"a > 0 N\"", "a number above 0 N"]);
    assert!(found(&force("a > 1 N"), 3).is_empty());
    let ratio = |expect: &str| force(expect) + "baseline = \"deploy.mujoco\"\nrelative = true\n";
    is(one(&ratio("a < 0"), 3), ["W0511", "\"a < 0\"", "a number above 0"]);
    is(one(&share("a > 1").replace("wilson", "welch"), 3), ["W0511", "\"a > 1\"", "a number below 100 %"]);
}

#[test]
fn distances_that_no_two_values_have_are_e0204() {
    let with = |expect: &str| CLAIM.replace("a > b", expect);
    is(one(&with("a > b + 101 %"), 3), ["E0204", "101 %", "write 100 % or less"]);
    is(one(&with("a > 0.5 * b - 60 %"), 3), ["E0204", "60 %", "write 50 % or less"]);
    is(one(&with("a == b within 150 %"), 3), ["E0204", "150 %", "write 100 % or less"]);
    is(one(&format!("{CLAIM}margin = \"150 %\"\n"), 3), ["E0204", "\"150 %\"", "write 100 % or less"]);
    let ahead = CLAIM.replace("welch", "probability_of_improvement");
    is(one(&format!("{ahead}margin = 0.6\n"), 10), ["E0204", "0.6", "write 0.5 or less"]);
    is(one(&format!("{ahead}margin = 0.5\n"), 10), ["W0511", "\"a > b\"", "smaller"]);
    // Unbounded above.
    let force = CLAIM.replace("survival", "peak_foot_force");
    assert!(found(&force.replace("a > b", "a > b + 5000 N"), 3).is_empty());
    let one_arm = share("a > 100 N").replace("wilson", "welch").replace("survival", "peak_foot_force");
    is(one(&format!("{one_arm}effect = \"-5 N\"\n"), 3), ["E0204", "\"-5 N\"", "of 0 N or more"]);
}

#[test]
fn a_training_without_samples_has_no_curve() {
    let claim = CLAIM.replace("evaluate.nominal.survival", "learn.area_under_curve");
    let found = |samples: u64| found_in(&claim, 3, &with_training(samples));
    assert_eq!(found(8000), []);
    let told = found(0);
    assert_eq!((told.len(), told[0].0, told[0].1.as_str()), (1, "E0804", "learn"), "{told:?}");
    assert!(told[0].2.contains("give `learn` 4000 samples or more"), "{told:?}");
}

#[test]
fn returns_that_no_episode_has_are_e0204() {
    let fields = with_training(1_000_000);
    let sooner = CLAIM
        .replace("evaluate.nominal.survival", "learn.samples_to_threshold")
        .replace("a > b", "a < b")
        .replace("welch", "mann_whitney");
    let waits = |threshold: &str| found_in(&format!("{sooner}threshold = {threshold}\n"), 5, &fields);
    // 1000 steps of at most 0.75.
    assert_eq!(waits("749"), []);
    for threshold in ["750.5", "1e12", "0", "-5"] {
        let told = waits(threshold);
        assert_eq!((told.len(), told[0].0, told[0].1.as_str()), (1, "E0204", threshold), "{told:?}");
        assert!(told[0].2.contains("between 0 and 750"), "{told:?}");
    }
    let beyond = share("a > 751")
        .replace("wilson", "welch")
        .replace("evaluate.nominal.survival", "learn.final_return");
    let told = found_in(&beyond, 5, &fields);
    assert_eq!((told.len(), told[0].0, told[0].1.as_str()), (1, "E0204", "751"), "{told:?}");
}

#[test]
fn a_bootstrap_over_few_episodes_is_w0511() {
    let claim = share("a > 0.1 m/s").replace("survival", "speed").replace("wilson", "episode_bootstrap");
    let of = |episodes: u64| found_in(&claim, 3, &with_episodes(episodes));
    assert_eq!(of(5), []);
    let told = of(3);
    assert_eq!((told.len(), told[0].0), (1, "W0511"), "{told:?}");
    assert_eq!(told[0].2, "give `evaluate.nominal` 5 episodes or more");
}

#[test]
fn numbers_below_one_episode_are_w1004() {
    let fields = with_episodes(32);
    let told = |text: &str| found_in(text, 5, &fields);
    let expecting = |expect: &str| told(&CLAIM.replace("a > b", expect));
    for (expect, marked, word) in [
        ("a > b - 0.001 %", "0.001 %", "`a > b`"),
        ("a > b + 0.6 %", "0.6 %", "0.625 % or more"),
        ("a == b within 0.001 %", "0.001 %", "does not matter"),
    ] {
        let told = expecting(expect);
        assert_eq!((told.len(), told[0].0, told[0].1.as_str()), (1, "W1004", marked), "{told:?}");
        assert!(told[0].2.contains(word), "{told:?}");
    }
    assert_eq!(expecting("a > b - 0.625 %"), []);
    let margin = told(&format!("{CLAIM}margin = \"0.01 %\"\n"));
    assert!(margin[0].0 == "W1004" && margin[0].2.contains("remove `margin`"), "{margin:?}");
    // One run of five with one more success of 32: 1 / 32 / sqrt(5) = 1.398 %.
    let spread = |spread: &str| told(&format!("{CLAIM}effect = \"30 %\"\nspread = \"{spread}\"\n"));
    assert_eq!(spread("1.4 %"), []);
    let small = spread("1 %");
    assert!(small[0].0 == "W1004" && small[0].2.contains("1.4 % or more"), "{small:?}");
    // Speeds are reported to 0.001 m/s.
    let speed = |spread: &str| {
        let text = CLAIM.replace("survival", "speed");
        told(&format!("{text}effect = \"0.3 m/s\"\nspread = \"{spread}\"\n"))
    };
    assert_eq!(speed("0.00001 m/s"), []);
    assert_eq!(speed("0.000001 m/s")[0].0, "W1004");
}

#[test]
fn a_claim_that_its_own_effect_leaves_open_is_w1003_with_the_seeds_that_it_takes() {
    let with = |effect: &str| format!("{CLAIM}effect = \"{effect}\"\nspread = \"10 %\"\n");
    let (code, marked, help) = one(&with("1.5 %"), 5);
    assert_eq!((code, marked.as_str()), ("W1003", "\"1.5 %\""));
    // Cohen 1988: an effect of 0.15 standard deviations takes 699 or 700 runs per arm.
    assert!(help.contains("seeds = 699") || help.contains("seeds = 700"), "{help}");
    // Two standard deviations with five runs: power 79 %.
    assert!(found(&with("20 %"), 5).is_empty());
    assert!(found(&with("1.5 %"), 700).is_empty());
    // Every comparison must pass.
    let each = with("20 %").replace(
        "compare = { a = \"control=torque\", b = \"control=position,stiffness=100 %\" }",
        "compare = { a = \"control=position\", b = \"control=torque,stiffness=100 %\" }\nover = \"each\"",
    );
    assert!(found(&each, 5).iter().all(|found| found.0 != "W1003"), "62 % for both");
    assert!(found(&each, 4).iter().any(|found| found.0 == "W1003"));
}

#[test]
fn runs_that_are_all_alike_and_cannot_establish_a_claim_are_w0511() {
    let of = |text: &str, runs: usize, episodes: u64| found_in(text, runs, &with_episodes(episodes));
    // Fisher's test of three against three: p = 0.1; of four against four 0.029.
    let told = of(CLAIM, 3, 128);
    assert_eq!((told.len(), told[0].0), (1, "W0511"), "{told:?}");
    assert!(told[0].2.starts_with("write `seeds = 4` or more in `[sweep]`"), "{told:?}");
    assert_eq!(of(CLAIM, 4, 128), []);
    // 100 % against 100 % within 5 %: the pooled episodes decide, and 73 are enough (19 z^2 = 73.0).
    let level = CLAIM.replace("a > b", "a == b within 5 %");
    let told = of(&level, 3, 24);
    assert_eq!((told.len(), told[0].0), (1, "W0511"), "{told:?}");
    assert!(told[0].2.contains("`seeds = 4`") && told[0].2.contains("25 episodes"), "{told:?}");
    assert_eq!(of(&level, 3, 25), []);
    // Likewise for one arm: all of 3 times 21 pooled episodes leave 95 % open at z = 1.82.
    let nearly_all = share("a > 95 %").replace("wilson", "welch");
    assert_eq!(of(&nearly_all, 3, 21)[0].0, "W0511");
    assert_eq!(of(&nearly_all, 3, 32), []);
    // Speeds of runs are never identical.
    assert_eq!(of(&CLAIM.replace("survival", "speed"), 3, 128), []);
}

#[test]
fn the_help_of_w1002_suits_test_and_metric() {
    let paper = "paper = { where = \"Exp. 1\", value = \"it fails\" }\n";
    let ahead = format!("{}{paper}", CLAIM.replace("welch", "probability_of_improvement"));
    is(one(&ahead, 10), ["W1002", "\"a > b\"", "`margin = 0.2`"]);
    assert!(!one(&ahead, 10).2.contains("expect ="));
    assert!(found(&format!("{ahead}margin = 0.2\n"), 10).is_empty());
    let returns = format!("{}{paper}", CLAIM.replace("evaluate.nominal.survival", "learn.final_return"));
    is(one(&returns, 3), ["W1002", "\"a > b\"", "`expect = \"a > 1.2 * b\"`"]);
    assert!(found(&returns.replace("a > b", "a > 1.2 * b"), 3).is_empty());
}

#[test]
fn claims_that_every_robot_fulfils_are_w1001_in_every_unit() {
    let robot = crate::robot::tests::robot("tocabi");
    let mut fields = spec();
    let quantity = |si: f64| Value::Quantity(crate::spec::Quantity { si, text: format!("{si}") });
    let command = Table::from([("speed".to_owned(), quantity(0.5))]);
    let task = Table::from([
        ("kind".to_owned(), Value::Text("walk".to_owned())),
        ("episode".to_owned(), quantity(16.0)),
        ("command".to_owned(), Value::Table(command)),
    ]);
    fields.insert("task".to_owned(), Value::Table(task));
    let points = [("control".to_owned(), "torque".to_owned())].to_vec();
    let arm = || ArmScope { points: &points, fields: &fields, robot: Some(&robot), runs: 5 };
    let told = |metric: &str, expect: &str| -> Vec<&'static str> {
        let text = format!(
            "[[claim]]\nid = \"c\"\ntext = \"It does\"\nmetric = \"evaluate.nominal.{metric}\"\narm = \
             \"control=torque\"\nexpect = \"{expect}\"\ntest = \"welch\"\n"
        );
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let source = sources.add("suite.toml", text.as_str());
        let document = crate::syntax::parse(&sources, source, &mut sink).expect("TOML");
        let Some(Item::List(nodes)) =
            document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
        else {
            panic!("claims");
        };
        let scope = Scope {
            axes: vec![("control", vec!["torque"])],
            arms: vec![arm()],
            seeds: None,
            counted: false,
            shortened: false,
        };
        claims(nodes, &scope, &mut sink);
        sink.diagnostics.iter().map(|found| found.code).collect()
    };
    for (metric, sound, sure) in [
        ("time_to_fall", ["a > 10 s", "a < 15 s"], ["a > 0 s", "a < 100 s"]),
        ("peak_foot_force", ["a > 1200 N", "a < 1500 N"], ["a > 0 N", "a < 1e6 N"]),
        ("torque_rms", ["a > 10 N*m", "a < 50 N*m"], ["a > 0 N*m", "a < 1e4 N*m"]),
        ("peak_ankle_torque", ["a > 30 N*m", "a < 200 N*m"], ["a > 0 N*m", "a < 1e4 N*m"]),
        ("speed", ["a > 0.1 m/s", "a < 1 m/s"], ["a > 0 m/s", "a < 50 m/s"]),
        ("steady_speed", ["a > 0.1 m/s", "a < 1 m/s"], ["a > -1 m/s", "a < 50 m/s"]),
        ("distance", ["a > 1 m", "a < 5 m"], ["a > 0 m", "a < 1 km"]),
        ("joint_error", ["a > 0.1 rad", "a < 1 rad"], ["a > 0 rad", "a < 7 rad"]),
        ("speed_error", ["a > 0.1 m/s", "a < 0.1 m/s"], ["a > 0 m/s", "a < 50 m/s"]),
    ] {
        sound.iter().for_each(|expect| assert_eq!(told(metric, expect), [""; 0], "{metric} {expect}"));
        sure.iter().for_each(|expect| assert_eq!(told(metric, expect), ["W1001"], "{metric} {expect}"));
    }
}
