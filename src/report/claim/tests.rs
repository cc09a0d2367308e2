//! Tests the claims on synthetic runs with a known truth.

use std::collections::BTreeMap;

use super::*;
use crate::diag::{Sink, Sources};
use crate::evaluate::outcome::{Episode, Evaluation};
use crate::report::model::{Measured, StageRecord, Update};
use crate::report::table::{Cell, Row};
use crate::spec::Value;
use crate::spec::claim::{self, Claim};
use crate::syntax::Item;

type Point = (String, String);

/// A run with these survivals and this speed.
fn run(survived: &[bool], speed: f64) -> Arm {
    let episode = |(index, survived): (usize, &bool)| Episode {
        stream: format!("1000/episode/{index}"),
        survived: *survived,
        speed,
        ..Episode::default()
    };
    let episodes = survived.iter().enumerate().map(episode).collect();
    let evaluation = Evaluation { engine: "rapier".into(), episodes, ..Evaluation::default() };
    let updates = (1..=10).map(|update| Update {
        samples: 100 * update,
        return_mean: Some(speed * update as f64),
        ..Update::default()
    });
    Arm {
        evaluations: vec![Measured { stage: "evaluate.nominal".into(), evaluation }],
        updates: updates.collect(),
        ..Arm::default()
    }
}

/// A run in which `count` of 20 episodes survive.
fn surviving(count: usize) -> Arm {
    run(&(0..20).map(|index| index < count).collect::<Vec<_>>(), count as f64 / 20.0)
}

fn claim(lines: &str) -> Claim {
    let rest = if lines.contains("arm =") {
        ""
    } else {
        "compare = { a = \"control=torque\", b = \"control=position\" }\n"
    };
    let metric = if lines.contains("metric =") { "" } else { "metric = \"evaluate.nominal.survival\"\n" };
    let text = format!("[[claim]]\nid = \"c\"\ntext = \"Torque survives more\"\n{metric}{rest}{lines}\n");
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add("suite.toml", text);
    let document = crate::syntax::parse(&sources, source, &mut sink).expect("TOML");
    let Some(Item::List(claims)) = document.table().and_then(|map| map.get("claim")).map(|node| &node.item)
    else {
        panic!("a claim");
    };
    claim::decode(&claims[0], &mut sink).unwrap_or_else(|| panic!("{:?}", sink.diagnostics))
}

/// Judges claims about two arms with these runs.
fn judged(claims: &[Claim], torque: Vec<Arm>, position: Vec<Arm>) -> Vec<Judged> {
    let points = |control: &str| -> Vec<Point> { vec![("control".into(), control.into())] };
    let (first, second) = (points("torque"), points("position"));
    let seeds = |arms: &'static [Arm]| (1u64..).zip(arms).collect::<Vec<_>>();
    let (torque, position) = (seeds(Vec::leak(torque)), seeds(Vec::leak(position)));
    let arms = [Observed { points: &first, runs: &torque }, Observed { points: &second, runs: &position }];
    judge(claims, &arms)
}

fn verdict(lines: &str, torque: &[usize], position: &[usize]) -> Ruling {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect();
    judged(&[claim(lines)], runs(torque), runs(position))[0].verdict
}

const HIGH: &[usize] = &[19, 18, 20, 17, 19];
const LOW: &[usize] = &[8, 11, 6, 9, 12];

#[test]
fn clear_differences_pass_or_fail_and_others_are_not_established() {
    for test in ["welch", "mann_whitney"] {
        let lines = format!("expect = \"a > b\"\ntest = \"{test}\"");
        assert_eq!(verdict(&lines, HIGH, LOW), Ruling::Pass, "{test}");
        assert_eq!(verdict(&lines, LOW, HIGH), Ruling::Fail, "{test}");
        assert_eq!(
            verdict(&lines, &[19, 10, 15, 8, 17], &[18, 9, 16, 7, 15]),
            Ruling::NotEstablished,
            "{test}"
        );
    }
}

#[test]
fn the_only_comparison_of_a_claim_is_called_what_the_claim_is_after_the_correction() {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect();
    let mut found = judged(&[claim("expect = \"a > b\"")], runs(HIGH), runs(LOW)).remove(0);
    assert_eq!(found.word_of(&found.cases[0]), "PASS");
    found.verdict = Ruling::NotEstablished;
    assert_eq!((found.cases[0].verdict, found.word_of(&found.cases[0])), (Ruling::Pass, "NOT ESTABLISHED"));
    found.cases.push(found.cases[0].clone());
    assert_eq!(found.word_of(&found.cases[0]), "PASS", "one among several has its own");
}

#[test]
fn the_p_value_of_a_claim_is_called_corrected_only_beside_those_of_others() {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect();
    let lone = judged(&[claim("expect = \"a > b\"")], runs(HIGH), runs(LOW)).remove(0);
    let tested = [lone.clone(), lone.clone()];
    let untested =
        [lone.clone(), Judged { id: "other".to_owned(), p: None, p_adjusted: None, ..lone.clone() }];
    assert!(sentences(&tested)[0].contains("Its p, corrected over the claims by Holm's method, is < 0.001."));
    let alone = &sentences(&[lone])[0];
    assert!(alone.contains("Its p is < 0.001."), "{alone}");
    assert!(correction(&untested[..1]).starts_with("There is one claim, so nothing is corrected"));
    assert!(
        correction(&untested).contains("corrected for 2 claims")
            && correction(&untested).contains("but counted: `other`.")
    );
}

#[test]
fn a_claim_that_cannot_be_tested_counts_in_the_correction() {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect::<Vec<_>>();
    let tested = claim("expect = \"a > b\"");
    // The arms do not run the same episodes, so McNemar's test has no p value.
    let untested = claim("expect = \"a > b\"\ntest = \"mcnemar\"");
    let mut other = runs(LOW);
    other.iter_mut().for_each(|run| {
        run.evaluations[0].evaluation.episodes.iter_mut().for_each(|episode| episode.stream.push('x'));
    });
    let alone = judged(std::slice::from_ref(&tested), runs(HIGH), other.clone()).remove(0);
    let both = judged(&[tested, untested], runs(HIGH), other);
    assert_eq!(both[1].p, None);
    let [one, two] = [&alone, &both[0]].map(|claim| claim.p_adjusted.expect("a p"));
    assert!((two - 2.0 * one).abs() < 1e-12, "{one} {two}");
}

#[test]
fn three_against_three_has_no_p_below_two_in_a_thousand() {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect::<Vec<_>>();
    let few = judged(&[claim("expect = \"a > b\"")], runs(&[19, 19, 18]), runs(&[2, 2, 1])).remove(0);
    assert_eq!((few.verdict, few.p, few.cases[0].fewest), (Ruling::Pass, Some(0.002), 3));
    let told = table(std::slice::from_ref(&few));
    assert_eq!(told.rows[0].cells[3], Cell::from("95 %"));
    assert_eq!(told.rows[0].cells[6], Cell::from("0.002 (the smallest below 5 seeds), corrected 0.002"));
    let enough = judged(&[claim("expect = \"a > b\"")], runs(HIGH), runs(LOW)).remove(0);
    assert!(enough.cases[0].p.is_some_and(|p| p < 0.001));
}

#[test]
fn the_other_relations_turn_and_shift_the_boundary() {
    assert_eq!(verdict("expect = \"a < b\"", LOW, HIGH), Ruling::Pass);
    assert_eq!(verdict("expect = \"b > a\"", LOW, HIGH), Ruling::Pass);
    let near: &[usize] = &[19, 18, 19, 18, 19];
    assert_eq!(verdict("expect = \"a >= b\"", near, HIGH), Ruling::NotEstablished);
    assert_eq!(verdict("expect = \"a >= b\"\nmargin = \"15 %\"", near, HIGH), Ruling::Pass);
    assert_eq!(verdict("expect = \"a == b within 15 %\"", near, HIGH), Ruling::Pass);
    assert_eq!(verdict("expect = \"a == b within 15 %\"", LOW, HIGH), Ruling::Fail);
    assert_eq!(verdict("expect = \"a > b\"\nmargin = \"90 %\"", HIGH, LOW), Ruling::Fail);
}

#[test]
fn one_arm_is_compared_with_a_number() {
    let lines = |expect: &str, test: &str| {
        format!("arm = \"control=torque\"\nexpect = \"{expect}\"\ntest = \"{test}\"")
    };
    assert_eq!(verdict(&lines("a > 70 %", "welch"), HIGH, LOW), Ruling::Pass);
    assert_eq!(verdict(&lines("a < 0.7", "welch"), HIGH, LOW), Ruling::Fail);
    assert_eq!(verdict(&lines("a > 93 %", "welch"), HIGH, LOW), Ruling::NotEstablished);
    // Wilson's interval of 20 of 20 begins at 0.839.
    assert_eq!(verdict(&lines("a > 80 %", "wilson"), &[20], LOW), Ruling::Pass);
    assert_eq!(verdict(&lines("a > 85 %", "wilson"), &[20], LOW), Ruling::NotEstablished);
}

#[test]
fn paired_episodes_are_tested_by_mcnemar_and_unpaired_ones_are_not() {
    let lines = "expect = \"a > b\"\ntest = \"mcnemar\"";
    let runs = |count| vec![surviving(count)];
    let found = &judged(&[claim(lines)], runs(18), runs(6))[0];
    assert_eq!((found.verdict, found.unit.as_str()), (Ruling::Pass, "episode"));
    // 12 discordant pairs, all of one kind: 2 / 2^12.
    assert!((found.cases[0].p.expect("a p") - 2.0 / 4096.0).abs() < 1e-12);
    let mut other = surviving(6);
    other.evaluations[0].evaluation.episodes.iter_mut().for_each(|episode| episode.stream.push('x'));
    let found = &judged(&[claim(lines)], runs(18), vec![other])[0];
    assert_eq!(found.verdict, Ruling::NotEstablished);
    assert!(found.cases[0].remark.contains("same episodes"), "{found:?}");
}

#[test]
fn every_seed_of_a_claim_about_policies_is_a_comparison_of_its_own() {
    let lines = "expect = \"a > b\"\ntest = \"newcombe\"";
    let runs = |counts: [usize; 2]| counts.map(surviving).to_vec();
    let found = &judged(&[claim(lines)], runs([18, 17]), runs([5, 16]))[0];
    assert_eq!(found.cases.iter().map(|case| case.label.as_str()).collect::<Vec<_>>(), ["seed=1", "seed=2"]);
    assert_eq!(
        found.cases.iter().map(|case| case.verdict).collect::<Vec<_>>(),
        [Ruling::Pass, Ruling::NotEstablished]
    );
    assert_eq!(found.verdict, Ruling::NotEstablished);
}

#[test]
fn a_missing_run_is_said_and_leaves_the_claim_open() {
    let mut torque: Vec<Arm> = HIGH.iter().map(|count| surviving(*count)).collect();
    torque[2].evaluations.clear();
    let position = LOW.iter().map(|count| surviving(*count)).collect();
    let found = &judged(&[claim("expect = \"a > b\"")], torque, position)[0];
    assert_eq!((found.verdict, found.cases[0].n.as_slice()), (Ruling::NotEstablished, &[4, 5][..]));
    assert_eq!(found.missing, ["`control=torque` with seed 3 has no result of `evaluate.nominal`"]);
    assert!(sentences(std::slice::from_ref(found))[0].contains("with seed 3"));
}

#[test]
fn an_evaluation_that_is_too_short_to_be_judged_leaves_every_claim_about_it_open() {
    let with_limit = |counts: &[usize], limit: f64| -> Vec<Arm> {
        let run = |count: &usize| {
            let mut run = surviving(*count);
            run.evaluations[0].evaluation.time_limit = limit;
            run
        };
        counts.iter().map(run).collect()
    };
    let judge_with = |lines: &str, limit: f64, low: &[usize]| {
        judged(&[claim(lines)], with_limit(HIGH, limit), with_limit(low, limit)).remove(0)
    };
    let tests = [
        "expect = \"a > b\"",
        "expect = \"b > a\"",
        "expect = \"a > b\"\ntest = \"newcombe\"\nover = \"each\"",
        "expect = \"a > 10 %\"\narm = \"control=torque\"\ntest = \"wilson\"",
    ];
    for lines in tests {
        let long = judge_with(lines, 20.0, LOW);
        assert!(long.missing.is_empty(), "{lines}: {:?}", long.missing);
        let short = judge_with(lines, 0.304, LOW);
        assert_eq!((short.verdict, short.p), (Ruling::NotEstablished, None), "{lines}");
        let told = &short.missing[0];
        let reason = "with seed 1 is not judged in `evaluate.nominal` (its episodes end after 0.304 s";
        assert!(told.contains(reason) && !told.contains("no result"), "{lines}: {told}");
    }
    // Where every episode ended with a fall, a longer one would have ended, too.
    let lines = "expect = \"a < 10 %\"\narm = \"control=position\"";
    assert_eq!(judge_with(lines, 0.304, &[0; 5]).verdict, judge_with(lines, 20.0, &[0; 5]).verdict);
}

#[test]
fn arms_that_were_never_trained_and_act_alike_leave_the_claim_open() {
    let runs = |warm_up: u64, counts: &[usize]| -> Vec<Arm> {
        let learn = BTreeMap::from([
            ("kind".to_owned(), Value::Text("ppo".into())),
            ("samples".to_owned(), Value::Count(1000)),
            ("warm_up".to_owned(), Value::Count(warm_up)),
        ]);
        let run = |count: &usize| Arm {
            fields: BTreeMap::from([("learn".to_owned(), Value::Table(learn.clone()))]),
            ..surviving(*count)
        };
        counts.iter().map(run).collect()
    };
    let lines = "expect = \"a == b within 50 %\"";
    let same = judged(&[claim(lines)], runs(10, HIGH), runs(10, HIGH)).remove(0);
    assert_eq!(same.verdict, Ruling::NotEstablished);
    assert!(same.missing[0].contains("never updated (`W0508`)"), "{:?}", same.missing);
    for (warm_up, other) in [(0, HIGH), (10, &[18, 18, 18, 18, 18][..])] {
        let found = judged(&[claim(lines)], runs(warm_up, HIGH), runs(10, other)).remove(0);
        assert!(found.missing.is_empty(), "{:?}", found.missing);
    }
}

#[test]
fn one_result_on_both_sides_leaves_the_claim_open() {
    let runs = |prefix: &str| -> Vec<Arm> {
        let run = |(seed, count): (usize, &usize)| {
            let fingerprint = format!("{prefix}{seed}");
            let record =
                StageRecord { stage: "evaluate.nominal".into(), fingerprint, ..StageRecord::default() };
            Arm { stages: vec![record], ..surviving(*count) }
        };
        HIGH.iter().enumerate().map(run).collect()
    };
    let of =
        |prefix: &str| judged(&[claim("expect = \"a >= b - 50 %\"")], runs("own"), runs(prefix)).remove(0);
    assert_eq!((of("other").verdict, of("other").missing.len()), (Ruling::Pass, 0));
    let same = of("own");
    assert_eq!(same.verdict, Ruling::NotEstablished);
    assert_eq!(same.missing, ["`control=torque` and `control=position` have the same `evaluate.nominal`"]);
}

#[test]
fn arms_that_are_all_alike_are_decided_by_fishers_test_over_the_seeds() {
    // With three runs per arm no order is significant; with four it is.
    assert_eq!(verdict("expect = \"a > b\"", &[20; 3], &[0; 3]), Ruling::NotEstablished);
    assert_eq!(verdict("expect = \"a > b\"", &[20; 4], &[0; 4]), Ruling::Pass);
    assert_eq!(verdict("expect = \"a > b\"", &[20; 4], &[20; 4]), Ruling::NotEstablished);
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect();
    let few = judged(&[claim("expect = \"a > b\"")], runs(&[20; 3]), runs(&[0; 3])).remove(0);
    assert!((few.p.expect("a p") - 0.1).abs() < 1e-9);
    assert!(few.cases[0].remark.contains("Fisher"), "{}", few.cases[0].remark);
    assert!(few.settled_by.is_some_and(|told| told.starts_with("about 4 seeds per arm")));
}

#[test]
fn equal_shares_are_equivalent_within_a_margin_and_refute_an_effect() {
    let all = &[100; 3];
    let survived = |count: usize| run(&(0..100).map(|index| index < count).collect::<Vec<_>>(), 0.5);
    let verdict = |lines: &str, torque: &[usize], position: &[usize]| {
        let runs = |counts: &[usize]| counts.iter().map(|count| survived(*count)).collect();
        judged(&[claim(lines)], runs(torque), runs(position))[0].verdict
    };
    assert_eq!(verdict("expect = \"a == b within 5 %\"", all, all), Ruling::Pass);
    assert_eq!(verdict("expect = \"a >= b\"\nmargin = 0.05", all, all), Ruling::Pass);
    assert_eq!(
        verdict("expect = \"a > b + 20 %\"", all, all),
        Ruling::Fail,
        "the data contradict the effect"
    );
    assert_eq!(
        verdict("expect = \"a > b\"", all, all),
        Ruling::NotEstablished,
        "without an effect nothing does"
    );
    // 98 % and 100 % of 300 episodes each do not establish a difference within 2 points.
    assert_eq!(verdict("expect = \"a == b within 1 %\"", all, all), Ruling::NotEstablished);
}

#[test]
fn an_effect_that_the_data_contradict_fails() {
    let near: &[usize] = &[19, 18, 20, 19, 18];
    assert_eq!(verdict("expect = \"a > b + 20 %\"", near, HIGH), Ruling::Fail);
    assert_eq!(verdict("expect = \"a > b + 20 %\"", HIGH, LOW), Ruling::Pass);
    assert_eq!(verdict("expect = \"a < 0.5 * b\"", near, HIGH), Ruling::Fail);
    assert_eq!(verdict("expect = \"a < 0.8 * b\"", LOW, HIGH), Ruling::Pass);
    assert_eq!(
        verdict("expect = \"a < 0.5 * b\"", LOW, HIGH),
        Ruling::NotEstablished,
        "46 % is about half of 93 %"
    );
}

#[test]
fn a_baseline_is_taken_from_every_run() {
    let with_box = |flat: usize, over: usize| {
        let mut run = surviving(flat);
        let mut other = surviving(over).evaluations.remove(0);
        other.stage = "evaluate.box".into();
        run.evaluations.push(other);
        run
    };
    let runs =
        |pairs: &[[usize; 2]]| pairs.iter().map(|[flat, over]| with_box(*flat, *over)).collect::<Vec<_>>();
    let lines =
        "metric = \"evaluate.box.survival\"\nbaseline = \"evaluate.nominal\"\nexpect = \"a > b + 10 %\"";
    let (steady, falling) =
        ([[20, 20], [10, 10], [15, 16], [12, 12], [18, 18]], [[20, 10], [12, 1], [15, 4], [18, 9], [14, 4]]);
    let found = judged(&[claim(lines)], runs(&steady), runs(&falling)).remove(0);
    assert_eq!(
        (found.verdict, found.metric.as_str()),
        (Ruling::Pass, "evaluate.box.survival - evaluate.nominal")
    );
    assert!(
        found.cases[0].sides[0].is_some_and(|value| (value - 0.01).abs() < 1e-12),
        "{:?}",
        found.cases[0].sides
    );
    let ratio = lines.replace("expect = \"a > b + 10 %\"", "relative = true\nexpect = \"a > b + 0.3\"");
    let found = judged(&[claim(&ratio)], runs(&steady), runs(&falling)).remove(0);
    assert_eq!(found.verdict, Ruling::Pass);
    assert_eq!(found.cases[0].estimate.unit, "");
}

#[test]
fn the_speed_of_robots_that_fall_is_not_meaningful_and_their_runs_are_named() {
    let lines = "metric = \"evaluate.nominal.speed\"\nexpect = \"a > b\"";
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect::<Vec<_>>();
    let fast = [20, 19, 20, 20, 19];
    let found = judged(&[claim(lines)], runs(&fast), runs(&[18, 19, 18, 7, 18])).remove(0);
    assert_eq!((found.verdict, found.p, found.p_adjusted), (Ruling::NotMeaningful, None, None));
    assert_eq!(found.failing, ["control=position,seed=4"]);
    let told = meaningless(std::slice::from_ref(&found)).expect("one claim");
    assert!(told.starts_with("**1 claim is not meaningful") && told.contains("position, seed 4"), "{told}");
    assert!(sentences(std::slice::from_ref(&found))[0].starts_with("**NOT MEANINGFUL**"));
    assert!(count(std::slice::from_ref(&found)).contains("1 of them is not meaningful"));
    let upright = judged(&[claim(lines)], runs(&fast), runs(&[18, 18, 19, 18, 18])).remove(0);
    assert_eq!(upright.verdict, Ruling::Pass);
    let mut pushed = runs(&[18, 18, 19, 18, 18]);
    pushed[1].evaluations[0].evaluation.episodes[0].end = "exploded".into();
    let exploded = judged(&[claim(lines)], runs(&fast), pushed).remove(0);
    assert_eq!((exploded.verdict, &*exploded.failing[0]), (Ruling::NotMeaningful, "control=position,seed=2"));
    for metric in ["flight", "starting_steps", "left_steps", "right_steps", "distance", "torque_rms"] {
        let lines = format!("metric = \"evaluate.nominal.{metric}\"\nexpect = \"a > b\"");
        let fallen = judged(&[claim(&lines)], runs(&fast), runs(&[7, 8, 7, 8, 7])).remove(0);
        assert_eq!(fallen.verdict, Ruling::NotMeaningful, "{metric}");
    }
    let survival = judged(&[claim("expect = \"a > b\"")], runs(&fast), runs(&[7, 8, 7, 8, 7])).remove(0);
    assert_eq!(survival.verdict, Ruling::Pass, "survival says that they fall");
}

#[test]
fn settings_that_learn_are_counted() {
    let lines = |over: &str| {
        format!("over = {{ {over} }}\nexpect = \"a > 76 %\"\nmetric = \"evaluate.nominal.task_success\"")
    };
    let counts = [[20, 20], [20, 0]];
    // Three of four learn: each is tested at alpha / 2, where the lower end for 20 of 20 is 0.799. One of
    // four: alpha / 4, where it is 0.762.
    let found = over_settings(&lines("at_least = 3"), counts);
    assert_eq!((found.verdict, found.over.as_str()), (Ruling::Pass, "at least 3"));
    assert_eq!(over_settings(&lines("at_most = 0"), counts).verdict, Ruling::Fail);
    assert_eq!(over_settings(&lines("at_most = 1"), [[0, 0], [20, 0]]).verdict, Ruling::Pass);
    assert_eq!(over_settings(&lines("at_most = 1"), [[0, 15], [20, 15]]).verdict, Ruling::NotEstablished);
    let text = &sentences(std::slice::from_ref(&found))[0];
    assert!(text.contains("holds at 3 of 4 comparisons, fails at 1"), "{text}");
}

#[test]
fn an_open_claim_says_how_many_seeds_settle_it() {
    let found = judged(
        &[claim("expect = \"a > b\"")],
        [14, 17, 12, 18, 15].map(surviving).to_vec(),
        [13, 10, 16, 11, 12].map(surviving).to_vec(),
    );
    assert_eq!(found[0].verdict, Ruling::NotEstablished);
    let told = found[0].settled_by.clone().expect("it is open");
    assert!(told.starts_with("about ") && told.contains("seeds per arm settle it (80 % power"), "{told}");
    assert!(sentences(&found)[0].contains("seeds per arm settle it"));
    let settled = judged(
        &[claim("expect = \"a > b\"")],
        HIGH.iter().map(|n| surviving(*n)).collect(),
        LOW.iter().map(|n| surviving(*n)).collect(),
    );
    assert_eq!(settled[0].settled_by, None);
}

#[test]
fn open_claims_about_episodes_and_ranks_say_what_settles_them() {
    let told = |test: &str, expect: &str, torque: &[usize], position: &[usize]| {
        let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect();
        let lines = format!("expect = \"{expect}\"\ntest = \"{test}\"");
        let found = judged(&[claim(&lines)], runs(torque), runs(position)).remove(0);
        assert_eq!(found.verdict, Ruling::NotEstablished, "{test}");
        found.settled_by.expect("it is open")
    };
    // Three pairs of 20 episodes each; 2 more survive on one side.
    for test in ["mcnemar", "newcombe", "episode_bootstrap"] {
        let told = told(test, "a > b", &[18; 3], &[16; 3]);
        assert!(
            told.starts_with("about ") && told.contains("episodes per policy settle it (80 % power"),
            "{test}: {told}"
        );
    }
    // Equal shares lie on the boundary.
    let equal = told("mcnemar", "a > b", &[18; 3], &[18; 3]);
    assert_eq!(equal, "no number of episodes that can be run settles it at the observed estimate");
    let ranks = told("mann_whitney", "a > b", &[14, 17, 12, 18, 15], &[13, 10, 16, 11, 12]);
    assert!(ranks.starts_with("about ") && ranks.contains("seeds per arm settle it"), "{ranks}");
    let single = told("welch", "a > b", &[14], &[13]);
    assert_eq!(single, "how many seeds would settle it is not estimated: a single run has no spread");
}

#[test]
fn p_values_are_corrected_over_all_claims_of_the_suite() {
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect::<Vec<_>>();
    let one = claim("expect = \"a > b\"\ntest = \"mann_whitney\"");
    // Four fully separated runs per arm: p = 2 / 70. Corrected for two claims it is 0.057.
    let alone = judged(std::slice::from_ref(&one), runs(&HIGH[..4]), runs(&LOW[..4]));
    assert_eq!(alone[0].verdict, Ruling::Pass);
    let both = judged(&[one.clone(), one], runs(&HIGH[..4]), runs(&LOW[..4]));
    assert!((both[0].p_adjusted.expect("a p") - 4.0 / 70.0).abs() < 1e-12);
    assert_eq!(both[0].verdict, Ruling::NotEstablished);
}

#[test]
fn a_threshold_that_is_never_reached_is_later_than_all_others() {
    let metric = "metric = \"learn.samples_to_threshold\"\nthreshold = 5\ntest = \"mann_whitney\"\n";
    // The mean return rises by the speed with every update: fast runs reach 5, slow runs never do.
    let runs = |speeds: &[f64]| speeds.iter().map(|speed| run(&[true], *speed)).collect::<Vec<_>>();
    let lines = format!("{metric}expect = \"a < b\"");
    let found = &judged(&[claim(&lines)], runs(&[2.0, 2.5, 1.9, 3.0]), runs(&[0.1, 0.2, 0.1, 0.3]))[0];
    assert_eq!(found.verdict, Ruling::Pass, "{found:?}");
    assert_eq!(found.cases[0].sides[1], Some(f64::INFINITY));
    assert!(sentences(std::slice::from_ref(found))[0].contains("never reach the threshold"));
}

#[test]
fn an_area_counts_the_samples_until_a_number() {
    let metric = "metric = \"learn.area_under_curve\"\n";
    let runs = |speeds: &[f64]| speeds.iter().map(|speed| run(&[true], *speed)).collect::<Vec<_>>();
    let value = |until: &str| {
        let lines = format!("{metric}{until}\narm = \"control=torque\"\nexpect = \"a > 1\"");
        judged(&[claim(&lines)], runs(&[2.0, 2.2, 2.4]), runs(&[0.1])).remove(0)
    };
    // The return rises by the speed every 100 samples: to 10 speeds, or to 3 speeds until 300 samples.
    let [whole, early] = ["", "until = 300"].map(|until| value(until).cases[0].sides[0].expect("a value"));
    assert!((whole - 5.5 * 2.2).abs() < 1e-9 && (early - 2.0 * 2.2).abs() < 1e-9, "{whole} {early}");
    assert_eq!(value("until = 300").metric, "learn.area_under_curve until 300");
}

#[test]
fn a_policy_is_compared_with_itself_over_the_same_episodes() {
    // On the box, position control falls in every episode that it survives on flat ground, and torque control
    // in one of four.
    let boxed = |flat: usize, boxed: usize| {
        let mut run = surviving(flat);
        let Measured { mut evaluation, .. } = surviving(boxed).evaluations.remove(0);
        evaluation.episodes.iter_mut().zip(&run.evaluations[0].evaluation.episodes).for_each(
            |(own, flat)| {
                own.survived &= flat.survived;
            },
        );
        run.evaluations.push(Measured { stage: "evaluate.box".into(), evaluation });
        run
    };
    let torque = || vec![boxed(20, 15), boxed(20, 16), boxed(20, 15)];
    let lines = |rest: &str| {
        let metric = "metric = \"evaluate.box.survival\"\nbaseline = \"evaluate.nominal\"\ntest = \
            \"episode_bootstrap\"";
        format!("{metric}\n{rest}")
    };
    let one = lines("arm = \"control=position\"\nexpect = \"a < -50 %\"");
    let found = judged(&[claim(&one)], torque(), vec![boxed(16, 0), boxed(18, 1)]).remove(0);
    assert_eq!(found.verdict, Ruling::Pass, "{found:?}");
    let lost = found.cases.iter().map(|case| case.estimate.value.expect("a value")).collect::<Vec<_>>();
    assert!((lost[0] + 0.8).abs() < 1e-12 && (lost[1] + 0.85).abs() < 1e-12, "{lost:?}");
    // Runs are paired by seed: the third torque policy has no counterpart and does not count as missing.
    let two = lines("expect = \"a > b + 20 %\"");
    let found = judged(&[claim(&two)], torque(), vec![boxed(20, 0), boxed(20, 1)]).remove(0);
    assert_eq!((found.verdict, found.cases.len(), found.missing.len()), (Ruling::Pass, 2, 0), "{found:?}");
    // Different episodes cannot be the baseline.
    let mut strangers = vec![boxed(16, 0)];
    strangers[0].evaluations[1].evaluation.episodes[3].stream.push('x');
    let found = judged(&[claim(&one)], torque(), strangers).remove(0);
    assert_eq!((found.verdict, found.missing.len()), (Ruling::NotEstablished, 1));
}

#[test]
fn a_run_is_compared_with_its_twin_of_the_same_seed() {
    let lines = "metric = \"learn.final_return\"\ntwin = \"control=position\"\nrelative = true\n\
                 arm = \"control=torque\"\nexpect = \"a > 0.7\"";
    let runs = |speeds: &[f64]| speeds.iter().map(|speed| run(&[true], *speed)).collect::<Vec<_>>();
    let found = judged(&[claim(lines)], runs(&[0.8, 1.62, 2.37]), runs(&[1.0, 2.0, 3.0])).remove(0);
    assert_eq!(found.verdict, Ruling::Pass, "{found:?}");
    assert!((found.cases[0].sides[0].expect("a ratio") - 0.8).abs() < 1e-9, "{found:?}");
    assert_eq!(found.metric, "learn.final_return / learn of control=position");
    // The twin of the third seed was not run.
    let found = judged(&[claim(lines)], runs(&[0.8, 1.62, 2.37]), runs(&[1.0, 2.0])).remove(0);
    assert_eq!((found.verdict, found.missing.len()), (Ruling::NotEstablished, 1), "{found:?}");
}

#[test]
fn a_trend_is_the_slope_of_the_means_over_the_points_of_an_axis() {
    let trend = |test: &str, counts: [[usize; 2]; 5]| {
        let points: Vec<Vec<Point>> =
            (0..5).map(|point| vec![("gain".to_owned(), format!("k{}", 8 << point))]).collect();
        let runs: Vec<Vec<Arm>> = counts.iter().map(|counts| counts.map(surviving).to_vec()).collect();
        let seeds: Vec<Vec<(u64, &Arm)>> = runs.iter().map(|runs| (1u64..).zip(runs).collect()).collect();
        let arms: Vec<Observed> =
            points.iter().zip(&seeds).map(|(points, runs)| Observed { points, runs }).collect();
        let lines = format!(
            "over = {{ trend = \"gain\" }}\narm = \"gain=*\"\nexpect = \"a > 2.5 %\"\ntest = \"{test}\""
        );
        judge(&[claim(&lines)], &arms).remove(0)
    };
    // The paper's counts out of 25, as shares of 20.
    let rising = trend("welch", [[12, 11], [14, 15], [17, 18], [18, 18], [20, 20]]);
    assert_eq!((rising.verdict, rising.cases.len()), (Ruling::Pass, 1), "{rising:?}");
    assert_eq!(trend("welch", [[20; 2]; 5]).verdict, Ruling::Fail, "all survive at every gain");
    // One policy per gain: a comparison for each seed.
    let policies = trend("newcombe", [[9, 8], [12, 12], [16, 17], [18, 18], [20, 20]]);
    assert_eq!((policies.verdict, policies.cases.len()), (Ruling::Pass, 2), "{policies:?}");
    assert!((policies.cases[0].sides[0].expect("a slope") - 0.14).abs() < 1e-12, "{policies:?}");
    let level = trend("newcombe", [[20; 2]; 5]).verdict;
    assert_eq!(level, Ruling::NotEstablished, "20 episodes at each gain leave a slope of 3.6 % possible");
    assert_eq!(
        trend("welch", [[12, 19], [20, 9], [17, 18], [11, 18], [20, 20]]).verdict,
        Ruling::NotEstablished
    );
}

#[test]
fn the_table_and_the_sentences_show_verdict_numbers_and_the_paper() {
    let lines = "expect = \"a > b\"\npaper = { where = \"Exp. 1\", value = \"it fails\" }";
    let runs = |counts: &[usize]| counts.iter().map(|count| surviving(*count)).collect::<Vec<_>>();
    let found = judged(&[claim(lines)], runs(HIGH), runs(LOW));
    let text = &sentences(&found)[0];
    // 93 % against 46 %.
    assert!(text.starts_with("**PASS**: Torque survives more. "), "{text}");
    assert!(text.contains("`control=torque > control=position`: difference 47 points ["), "{text}");
    assert!(text.contains("5 and 5 runs") && text.ends_with("The paper (Exp. 1): it fails."), "{text}");
    let table = table(&found);
    assert_eq!((table.rows.len(), table.rows[0].cells.len() + 1), (1, table.columns.len()));
    let brief = found[0].brief();
    assert_eq!(
        (brief["id"].as_str(), brief["verdict"].as_str(), brief["n"][0].as_u64()),
        (Some("c"), Some("PASS"), Some(5))
    );
    assert!(brief["interval"][0].as_f64() < brief["estimate"].as_f64(), "{brief}");
}

/// Judges a claim over two settings in two tasks, with one run each of which `counts` of 20 episodes survive.
fn over_settings(lines: &str, counts: [[usize; 2]; 2]) -> Judged {
    let mut points: Vec<Vec<Point>> = Vec::new();
    let mut runs: Vec<Vec<(u64, Arm)>> = Vec::new();
    for (setting, tasks) in ["position_k8", "position_k4"].into_iter().zip(counts) {
        for (task, count) in ["squat", "walk"].into_iter().zip(tasks) {
            points.push(vec![("task".into(), task.into()), ("setting".into(), setting.into())]);
            runs.push(vec![(1, surviving(count))]);
        }
    }
    let runs: Vec<Vec<(u64, &Arm)>> =
        runs.iter().map(|runs| runs.iter().map(|(seed, run)| (*seed, run)).collect()).collect();
    let observed: Vec<Observed> =
        points.iter().zip(&runs).map(|(points, runs)| Observed { points, runs }).collect();
    let lines = format!("arm = \"setting=position_*\"\ntest = \"wilson\"\n{lines}");
    judge(&[claim(&lines)], &observed).into_iter().next().expect("a claim")
}

#[test]
fn some_setting_serves_when_one_serves_every_task_at_the_level_of_two_settings() {
    let verdict = |expect: &str, counts| {
        over_settings(&format!("over = {{ some = \"setting\" }}\n{expect}"), counts).verdict
    };
    // For 20 of 20 the lower end is 20 / (20 + z^2): 0.799 at 97.5 % (two settings), 0.839 at 95 %.
    assert_eq!(verdict("expect = \"a > 79 %\"", [[20, 20], [0, 20]]), Ruling::Pass);
    assert_eq!(verdict("expect = \"a > 80 %\"", [[20, 20], [0, 20]]), Ruling::NotEstablished);
    let each = over_settings("over = \"each\"\nexpect = \"a > 80 %\"", [[20, 20], [20, 20]]);
    assert_eq!(each.verdict, Ruling::Pass, "each of them needs no correction");
    // Each setting is refuted by one of its two tasks: at 97.5 % the upper end for 0 of 20 is 0.201.
    assert_eq!(verdict("expect = \"a > 21 %\"", [[20, 0], [0, 20]]), Ruling::Fail);
    assert_eq!(verdict("expect = \"a > 20 %\"", [[20, 0], [0, 20]]), Ruling::NotEstablished);
    assert_eq!(
        verdict("expect = \"a > 21 %\"", [[20, 0], [6, 20]]),
        Ruling::NotEstablished,
        "one setting is open"
    );
}

#[test]
fn no_setting_serves_when_every_one_fails_in_a_task_and_the_report_says_which_hold() {
    let lines = |number: &str| format!("over = {{ none = \"setting\" }}\nexpect = \"a > {number}\"");
    let found = over_settings(&lines("79 %"), [[20, 0], [0, 20]]);
    assert_eq!((found.verdict, found.axis.as_str()), (Ruling::Pass, "setting"));
    // The score test of 0 of 20 against 0.79 has by far the smallest p value; twice that is below 0.0001.
    assert!(found.p_adjusted.is_some_and(|p| p < 1e-4), "{found:?}");
    let text = &sentences(std::slice::from_ref(&found))[0];
    assert!(text.contains("holds at 0 of 2 points of `setting`, fails at 2"), "{text}");
    let found = over_settings(&lines("79 %"), [[20, 20], [0, 20]]);
    assert_eq!(found.verdict, Ruling::Fail);
    // The score test of 20 of 20 against 0.79: z = 0.21 / sqrt(0.79 * 0.21 / 20) = 2.3057, p = 0.02113,
    // doubled for two settings.
    assert!(found.p_adjusted.is_some_and(|p| (p - 0.04225).abs() < 1e-4), "{:?}", found.p_adjusted);
    assert!(sentences(std::slice::from_ref(&found))[0].contains("It holds at `position_k8`."));
    let table = table(&[found]);
    let words: Vec<&Cell> = table.rows.iter().map(|row| &row.cells[0]).collect();
    let expected = ["FAIL", "holds", "holds", "does not hold", "holds"].map(Cell::from);
    assert_eq!(words, expected.iter().collect::<Vec<_>>(), "the claim, then its comparisons");
    let corrected = |row: &Row| matches!(&row.cells[6], Cell::Text(p) if p.contains("corrected"));
    let places: Vec<usize> = (0..table.rows.len()).filter(|at| corrected(&table.rows[*at])).collect();
    assert_eq!(places, [0], "the comparisons have their own");
}

#[test]
fn several_comparisons_are_told_with_their_smallest_and_largest_estimate() {
    let case = |value: f64, unit: &str| Case {
        estimate: Estimate { value: Some(value), digits: 2, unit: unit.into(), ..Estimate::default() },
        verdict: Ruling::Pass,
        ..Case::default()
    };
    let brief = |cases: Vec<Case>| in_brief(&Judged { cases, ..Judged::default() }, 1);
    let distances = vec![case(0.08, "rad"), case(0.04, "rad"), case(0.06, "rad")];
    assert_eq!(brief(distances), "0.04 to 0.08 rad; of 3 comparisons 3 pass, 0 fail");
    assert_eq!(brief(vec![case(1.0, "rad"), case(1.0, "rad")]), "1.00 rad; of 2 comparisons 2 pass, 0 fail");
    let unknown = Case { verdict: Ruling::Pass, ..Case::default() };
    assert_eq!(brief(vec![case(1.0, "rad"), unknown]), "of 2 comparisons 2 pass, 0 fail");
}

#[test]
fn a_claim_that_only_the_correction_leaves_open_says_so_beside_its_numbers() {
    let case = |verdict| Case {
        estimate: Estimate { value: Some(1.0), digits: 1, unit: "rad".into(), ..Estimate::default() },
        verdict,
        n: vec![3],
        ..Case::default()
    };
    let brief = |cases: Vec<Case>, p: f64| {
        let unit = "run".to_owned();
        let p_adjusted = Some(2.0 * p);
        in_brief(&Judged { cases, unit, alpha: 0.05, p: Some(p), p_adjusted, ..Judged::default() }, 5)
    };
    let corrected = "alone, not established after the correction for 5 claims";
    let (pass, fail, open) = (case(Ruling::Pass), case(Ruling::Fail), case(Ruling::NotEstablished));
    let both = vec![pass.clone(), pass.clone()];
    assert_eq!(brief(both.clone(), 0.03), format!("1.0 rad; 2 of 2 comparisons pass {corrected}"));
    assert_eq!(brief(both, 0.001), "1.0 rad; of 2 comparisons 2 pass, 0 fail");
    let failing = vec![pass.clone(), fail];
    assert_eq!(brief(failing, 0.03), format!("1.0 rad; 1 of 2 comparisons fails {corrected}"));
    assert_eq!(brief(vec![pass.clone(), open], 0.03), "1.0 rad; of 2 comparisons 1 pass, 0 fail");
    assert_eq!(brief(vec![pass], 0.03), format!("1.0 rad (n = 3 runs); passes {corrected}"));
}
