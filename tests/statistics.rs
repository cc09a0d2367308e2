//! The statistics of reports agree with independent implementations (`tests/reference/`), and their intervals
//! hold the true value as often as they say.

use serde_json::Value;
use specforge::kinds::statistic;
use specforge::report::estimate::Estimate;
use specforge::spec::claim::Summary;
use specforge::statistics::difference::{Pairs, independent};
use specforge::statistics::mean::{self, FEWEST, bootstrap};
use specforge::statistics::multiplicity::holm;
use specforge::statistics::proportion::{fisher_exact, mcnemar_exact, wilson};
use specforge::statistics::resample::{Draws, Strata, contrast, improvement_of, iqm_of, mean_of, percentile};
use specforge::statistics::summary::interquartile_mean;
use specforge::statistics::test::{Sample, Test};
use specforge::statistics::{Interval, rank, welch};
use specforge::stream::Stream;

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/statistics.json")).expect("JSON")
}

/// The entries of a part of the reference; there are some.
fn entries(part: &str) -> Vec<Value> {
    let entries = reference()[part].as_array().cloned().unwrap_or_default();
    assert!(!entries.is_empty(), "{part}");
    entries
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number: {value}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("numbers: {value}")).iter().map(number).collect()
}

fn counts(value: &Value) -> [u64; 2] {
    [0, 1].map(|index| value[index].as_u64().unwrap_or_else(|| panic!("counts: {value}")))
}

#[track_caller]
fn close(ours: f64, theirs: f64, tolerance: f64) {
    assert!((ours - theirs).abs() <= tolerance, "{ours} is not {theirs}");
}

#[track_caller]
fn same(ours: Interval, theirs: &Value, tolerance: f64) {
    close(ours.low, number(&theirs[0]), tolerance);
    close(ours.high, number(&theirs[1]), tolerance);
}

/// The two samples of a named case.
fn samples(name: &Value) -> [Vec<f64>; 2] {
    let case = entries("seeds").into_iter().find(|case| case["name"] == *name).expect("a case");
    [numbers(&case["first"]), numbers(&case["second"])]
}

#[test]
fn intervals_of_one_proportion_are_those_of_statsmodels() {
    for case in entries("one_proportion") {
        let [successes, trials] = counts(&case["count"]);
        same(wilson(successes, trials, number(&case["confidence"])), &case["interval"], 1e-9);
    }
}

#[test]
fn differences_of_proportions_are_those_of_statsmodels_and_their_tests_those_of_scipy() {
    for case in entries("two_proportions") {
        let [first, second] = [0, 1].map(|side| counts(&case["counts"][side]));
        let (_, interval) = independent(first, second, number(&case["confidence"]));
        same(interval, &case["interval"], 1e-9);
        close(fisher_exact(first, second), number(&case["fisher"]), 1e-9);
    }
}

#[test]
fn mcnemars_exact_test_is_that_of_statsmodels() {
    for case in entries("discordant") {
        let [first, second] = counts(&case["discordant"]);
        close(mcnemar_exact(first, second), number(&case["p"]), 1e-9);
    }
}

#[test]
fn interquartile_means_welch_and_rank_tests_are_those_of_scipy() {
    for case in entries("seeds") {
        let (first, second) = (numbers(&case["first"]), numbers(&case["second"]));
        for (sample, theirs) in [&first, &second].into_iter().zip(numbers(&case["iqm"])) {
            close(interquartile_mean(sample).expect("values"), theirs, 1e-12);
        }
        let difference = welch::two(&first, &second).expect("spread");
        close(difference.p(0.0).expect("a p"), number(&case["welch"]["p"]), 1e-7);
        same(difference.interval(0.95).expect("an interval"), &case["welch"]["interval"], 1e-6);
        close(rank::improvement(&first, &second).expect("values"), number(&case["improvement"]), 1e-12);
        close(rank::mann_whitney(&first, &second).expect("values"), number(&case["mann_whitney"]), 1e-9);
    }
}

#[test]
fn the_exact_interval_of_a_shift_is_that_of_its_definition() {
    for case in entries("rank_interval") {
        let [first, second] = samples(&case["name"]);
        close(rank::shift(&first, &second).expect("values"), number(&case["shift"]), 1e-12);
        same(rank::shift_interval(&first, &second, 0.95).expect("enough runs"), &case["interval"], 1e-12);
    }
}

#[test]
fn the_bootstrap_approaches_the_exact_percentiles_over_all_resamples() {
    let cases = entries("seeds").into_iter().filter(|case| !case["bootstrap"].is_null());
    let mut count = 0;
    for case in cases {
        let (first, second) = (numbers(&case["first"]), numbers(&case["second"]));
        let spread = first.iter().chain(&second).fold(0.0, |most: f64, value| most.max(value.abs()));
        let mut stream = Stream::new(&format!("test/bootstrap/{}", case["name"]));
        let sides = [vec![first], vec![second]];
        let interval = percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut stream);
        same(interval.expect("five runs"), &case["bootstrap"], 0.02 * spread);
        count += 1;
    }
    assert!(count >= 3);
}

#[test]
fn stratified_intervals_are_those_of_rliable() {
    for case in entries("stratified") {
        let strata: Strata = case["strata"].as_array().expect("strata").iter().map(numbers).collect();
        let summary = if case["summary"] == "iqm" { iqm_of } else { mean_of };
        close(summary(&strata).expect("runs"), number(&case["value"]), 1e-12);
        let mut stream = Stream::new(&format!("test/stratified/{}", case["summary"]));
        let interval = percentile(&[strata], &|sides| contrast(sides, summary), 0.95, &mut stream);
        same(interval.expect("five runs"), &case["interval"], 0.006);
    }
    let case = &reference()["improvement_interval"];
    let sides = samples(&case["name"]).map(|sample| vec![sample]);
    let interval = percentile(&sides, &improvement_of, 0.95, &mut Stream::new("test/improvement"));
    same(interval.expect("five runs"), &case["interval"], 0.041);
}

#[test]
fn holms_adjusted_values_are_those_of_statsmodels() {
    for case in entries("holm") {
        for (ours, theirs) in holm(&numbers(&case["p"])).into_iter().zip(numbers(&case["adjusted"])) {
            close(ours, theirs, 1e-12);
        }
    }
}

/// The chance of each number of successes in n trials.
fn binomial(n: usize, share: f64) -> Vec<f64> {
    let mut chance = vec![0.0; n + 1];
    chance[0] = 1.0;
    for trial in 1..=n {
        for at in (0..=trial).rev() {
            let below = if at > 0 { chance[at - 1] } else { 0.0 };
            chance[at] = chance[at] * (1.0 - share) + below * share;
        }
    }
    chance
}

#[test]
fn score_intervals_cover_95_percent_on_average_and_never_much_less() {
    let shares: Vec<f64> = (1..20).map(|step| f64::from(step) / 20.0).collect();
    let coverage = |share: &f64| -> f64 {
        let inside = |(x, chance): (usize, f64)| {
            if wilson(x as u64, 32, 0.95).contains(*share) { chance } else { 0.0 }
        };
        binomial(32, *share).into_iter().enumerate().map(inside).sum()
    };
    let all: Vec<f64> = shares.iter().map(coverage).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    assert!((0.945..0.965).contains(&mean) && all.iter().all(|coverage| *coverage > 0.91), "{mean} {all:?}");
}

#[test]
fn newcombes_interval_covers_the_difference_of_two_shares() {
    for [p, q] in [[0.9, 0.7], [0.5, 0.5], [0.95, 0.95], [1.0, 0.8]] {
        let (first, second) = (binomial(32, p), binomial(32, q));
        let mut coverage = 0.0;
        for (x, a) in first.iter().enumerate() {
            for (y, b) in second.iter().enumerate() {
                let (_, interval) = independent([x as u64, 32], [y as u64, 32], 0.95);
                coverage += if interval.contains(p - q) { a * b } else { 0.0 };
            }
        }
        assert!((0.93..=1.0).contains(&coverage), "{p} {q}: {coverage}");
    }
}

/// The interval of a difference of two samples, with a name for its stream.
type Method = dyn Fn(&[f64], &[f64], &str) -> Option<Interval>;

/// The share of simulated pairs of samples, normal and one apart, whose interval holds the truth.
fn coverage((runs, repetitions): (usize, usize), truth: f64, interval: &Method) -> f64 {
    let mut stream = Stream::new(&format!("test/coverage/{runs}"));
    let mut held = 0;
    for repetition in 0..repetitions {
        let first: Vec<f64> = (0..runs).map(|_| 1.0 + stream.normal()).collect();
        let second: Vec<f64> = (0..runs).map(|_| stream.normal()).collect();
        let interval = interval(&first, &second, &format!("test/coverage/{runs}/{repetition}"));
        held += usize::from(interval.is_some_and(|interval| interval.contains(truth)));
    }
    held as f64 / repetitions as f64
}

#[test]
fn welch_and_rank_intervals_keep_their_level_with_five_runs() {
    let student = coverage((5, 4000), 1.0, &|x, y, _| welch::two(x, y)?.interval(0.95));
    assert!((0.94..0.97).contains(&student), "{student}");
    let ranks = coverage((5, 4000), 1.0, &|x, y, _| rank::shift_interval(x, y, 0.95));
    // The exact level of this test with five and five runs is 1 - 2 * 4 / 252 = 0.968.
    assert!((0.96..0.98).contains(&ranks), "{ranks}");
}

/// What the page of `stratified_bootstrap` says: too narrow with few runs, and how much.
#[test]
fn bootstrap_intervals_cover_as_much_as_their_page_says() {
    let bootstrap = |x: &[f64], y: &[f64], name: &str| {
        let sides = [vec![x.to_vec()], vec![y.to_vec()]];
        percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new(name))
    };
    let measured = [3, 5, 10].map(|runs| coverage((runs, 200), 1.0, &bootstrap));
    let said = [0.80, 0.87, 0.92];
    for (measured, said) in measured.into_iter().zip(said) {
        assert!((measured - said).abs() < 0.06, "measured {measured}, said {said}");
    }
}

/// What a report says of intervals over few runs.
#[test]
fn intervals_over_few_values_cover_as_little_as_reports_say() {
    let of_mean = |x: &[f64], _: &[f64], name: &str| bootstrap(&[x], 0.95, &mut Stream::new(name));
    let of_difference = |x: &[f64], y: &[f64], name: &str| {
        let sides = [vec![x.to_vec()], vec![y.to_vec()]];
        percentile(&sides, &|sides| contrast(sides, mean_of), 0.95, &mut Stream::new(name))
    };
    for runs in 2..FEWEST {
        // The means are one, and one apart.
        let measured = [(&of_mean as &Method, 300), (&of_difference, 200)]
            .map(|(of, count)| coverage((runs, count), 1.0, of));
        let said = mean::coverage(runs).expect("few").map(|percent| f64::from(percent) / 100.0);
        for (measured, said) in measured.into_iter().zip(said) {
            assert!((measured - said).abs() < 0.08, "{runs} runs: measured {measured}, said {said}");
        }
    }
    assert_eq!([1, FEWEST].map(mean::coverage), [None; 2]);
}

/// The same number has one interval in a table and in a claim.
#[test]
fn the_interval_of_a_mean_is_that_of_a_claim_about_it() {
    let runs = vec![0.9, 0.4, 0.7, 0.8, 0.6];
    let test = Test {
        method: statistic::Method::StratifiedBootstrap,
        summary: Summary::Mean,
        trend: false,
        factor: 1.0,
        name: "speed",
    };
    let of_claim = test.interval(&Sample::of_runs(vec![vec![runs.clone()]]), 0.95);
    assert_eq!(Estimate::mean(&runs, "m/s", 3, "speed").interval(), of_claim);
}

/// The same of the page of `probability_of_improvement`.
#[test]
fn intervals_of_the_probability_of_improvement_cover_as_much_as_their_page_says() {
    let improvement = |x: &[f64], y: &[f64], name: &str| {
        let sides = [vec![x.to_vec()], vec![y.to_vec()]];
        percentile(&sides, &improvement_of, 0.95, &mut Stream::new(name))
    };
    // The chance that a normal number exceeds another whose mean is lower by one deviation.
    let truth = 0.760_249_938_9;
    let measured = [5, 10].map(|runs| coverage((runs, 150), truth, &improvement));
    let said = [0.87, 0.92];
    for (measured, said) in measured.into_iter().zip(said) {
        assert!((measured - said).abs() < 0.06, "measured {measured}, said {said}");
    }
}

/// With independent outcomes the paired interval of a difference of shares holds the truth as often as it
/// says.
#[test]
fn newcombes_paired_interval_covers_the_difference_of_two_shares() {
    let mut stream = Stream::new("test/coverage/paired");
    for [p, q] in [[0.9, 0.7], [0.5, 0.5], [0.95, 0.85]] {
        let mut held = 0;
        for _ in 0..2000 {
            // A common difficulty makes the outcomes of a pair alike.
            let outcomes: Vec<[bool; 2]> =
                (0..60)
                    .map(|_| {
                        let shared = stream.uniform();
                        [p, q].map(|share| {
                            if stream.uniform() < 0.5 { shared < share } else { stream.uniform() < share }
                        })
                    })
                    .collect();
            let side = |at: usize| outcomes.iter().map(|pair| pair[at]).collect::<Vec<bool>>();
            let (_, interval) = Pairs::count(&side(0), &side(1)).difference(0.95);
            held += usize::from(interval.contains(p - q));
        }
        let coverage = held as f64 / 2000.0;
        assert!((0.93..0.985).contains(&coverage), "{p} {q}: {coverage}");
    }
}

/// At the truth, p values of a bootstrap are below 5 % as often as its intervals leave the truth out.
#[test]
fn p_values_of_the_bootstrap_reject_the_truth_as_often_as_its_intervals_leave_it_out() {
    let mut stream = Stream::new("test/level");
    let (mut rejected, mut outside) = (0, 0);
    for repetition in 0..80 {
        let sample = |stream: &mut Stream| vec![(0..10).map(|_| stream.normal()).collect::<Vec<f64>>()];
        let sides = [sample(&mut stream), sample(&mut stream)];
        let mut own = Stream::new(&format!("test/level/{repetition}"));
        let draws = Draws::new(&sides, &|sides| contrast(sides, mean_of), &mut own).expect("ten runs");
        rejected += usize::from(draws.p(0.0) < 0.05);
        outside += usize::from(!draws.interval(0.95).expect("an interval").contains(0.0));
    }
    // Between two draws an interval ends by interpolation, a p value counts.
    assert!(rejected.abs_diff(outside) <= 1, "{rejected} rejected, {outside} outside");
    assert!((1..16).contains(&rejected), "{rejected} of 80");
}
