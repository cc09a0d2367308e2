//! The power of the tests of a suite's claims, before anything is run.

use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF};

use crate::kinds::deploy;
use crate::kinds::metric::{self, MetricKind};
use crate::kinds::statistic::{self, Method, StatisticKind, Unit};
use crate::report::wording::number;
use crate::spec::Table;
use crate::spec::claim::{Case, Claim, Over, Points, alternatives, cases};
use crate::statistics::assumed::Assumed;
use crate::statistics::power::alike_runs_needed;
use crate::statistics::proportion::{score_test, wilson};
use crate::statistics::region::Region;

/// An arm of a suite before anything is run.
#[derive(Clone, Copy, Debug)]
pub struct PlannedArm<'a> {
    /// Its points, by axis.
    pub points: &'a Points,
    /// Number of seeds.
    pub seeds: usize,
    /// The sections `evaluate` and `deploy` of its spec.
    pub fields: &'a Table,
}

/// A claim's test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Planned {
    /// The claim.
    pub id: String,
    /// Its test.
    pub test: String,
    /// Seeds per arm.
    pub seeds: usize,
    /// `run` or `episode`.
    pub unit: &'static str,
    /// The level of its smallest p value after Holm's correction over all claims of the suite.
    pub level: f64,
    /// The unit of the metric; `%` for shares, whose values here lie between 0 and 1.
    pub metric_unit: &'static str,
    /// How far beyond the boundary the true value must lie for a power of 80 %, at the claim's `spread`.
    pub detects: Option<f64>,
    /// The power at the claim's `effect` and `spread`.
    pub power: Option<f64>,
    /// The seeds per arm for a power of 80 %.
    pub seeds_needed: Option<usize>,
    /// The seeds per arm that decide the claim when the runs of each arm are all alike.
    pub seeds_needed_alike: Option<usize>,
    /// For the test `wilson`: the numbers of successes that decide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub successes: Option<Successes>,
}

/// The successes of a policy at which a claim about shares passes and fails.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Successes {
    /// Episodes per policy.
    pub episodes: usize,
    /// Number of policies compared.
    pub policies: usize,
    /// The fewest successes that establish the expectation for a policy (the most for `<`); absent when no
    /// number does.
    pub holds: Option<u64>,
    /// The most successes that refute it (the fewest for `<`); absent when no number does.
    pub fails: Option<u64>,
    /// The power at given shares of successes.
    pub powers: Vec<PowerAtShare>,
    /// A summary in words.
    pub told: String,
}

/// The chance of a PASS, given the share of successes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerAtShare {
    /// The share of successes of every policy.
    pub share: f64,
    /// The chance that the claim passes.
    pub power: f64,
}

/// The tests of a suite's claims with these arms, each with as many seeds as its smallest arm has.
pub fn planned(claims: &[Claim], arms: &[PlannedArm]) -> Vec<Planned> {
    let level = |claim: &Claim| claim.alpha / claims.len().max(1) as f64;
    claims.iter().filter_map(|claim| one(claim, arms, level(claim))).collect()
}

fn one(claim: &Claim, arms: &[PlannedArm], level: f64) -> Option<Planned> {
    let (metric, test) = (metric::find(&claim.metric.name)?, statistic::find(&claim.test)?);
    let points: Vec<&Points> = arms.iter().map(|arm| arm.points).collect();
    let cases = cases(claim, &points);
    let of_case =
        |case: &Case| [Some(case.a), case.b.filter(|_| claim.sides.len() == 2)].into_iter().flatten();
    let seeds = cases.iter().flat_map(of_case).map(|arm| arms[arm].seeds).min().unwrap_or(1);
    let of_runs = test.unit() == Unit::Seed;
    let assumed = Assumed::of(claim, test);
    Some(Planned {
        id: claim.id.clone(),
        test: claim.test.clone(),
        seeds,
        unit: if of_runs { "run" } else { "episode" },
        level,
        metric_unit: unit(claim, metric),
        detects: assumed.detectable(&cases, seeds, level),
        power: assumed.power(&cases, |arm| arms[arm].seeds, level),
        seeds_needed: assumed.runs_for_all(&cases, level),
        seeds_needed_alike: alike_runs_needed(level).filter(|_| of_runs && claim.sides.len() == 2),
        successes: successes(claim, test, arms, &cases, level),
    })
}

/// The successes that decide a `wilson` claim with a single boundary.
fn successes(
    claim: &Claim,
    test: &StatisticKind,
    arms: &[PlannedArm],
    cases: &[Case],
    level: f64,
) -> Option<Successes> {
    let region = Region::of(claim, test);
    let (boundary, is_above) = match region.bounds() {
        (Some(low), None) => (low, true),
        (None, Some(high)) => (high, false),
        _ => return None,
    };
    if test.method != Method::Wilson || cases.is_empty() {
        return None;
    }
    let episodes =
        cases.iter().filter_map(|case| deploy::episodes(arms[case.a].fields, &claim.metric.stage)).min()?;
    let points: Vec<&Points> = arms.iter().map(|arm| arm.points).collect();
    let groups: Vec<usize> = alternatives(claim, &points, cases)
        .iter()
        .map(|alternative| alternative.cases.iter().map(|case| arms[cases[*case].a].seeds).sum())
        .collect();
    let needed = match claim.over {
        Some(Over::AtLeast(count)) => count,
        Some(Over::AtMost(count)) => count + 1,
        _ => 1,
    };
    let refuting = (groups.len() + 1).saturating_sub(needed).max(1);
    let most = groups.iter().copied().max().unwrap_or(1);
    let trials = episodes as u64;
    let decides = |count: u64, level: f64, above: bool| {
        let share = count as f64 / trials as f64;
        let interval = wilson(count, trials, 1.0 - level);
        let is_beyond = if above { interval.low > boundary } else { interval.high < boundary };
        let is_shown = if 0.0 < boundary && boundary < 1.0 {
            score_test(count, trials, boundary).is_some_and(|p| p <= level)
        } else {
            share != boundary
        };
        is_beyond && is_shown
    };
    // The count beyond the boundary that is nearest to it.
    let nearest = |level: f64, above: bool| {
        if above {
            (0..=trials).find(|count| decides(*count, level, true))
        } else {
            (0..=trials).rev().find(|count| decides(*count, level, false))
        }
    };
    let holds = nearest(level / refuting as f64, is_above);
    let fails = nearest(level / (needed * most) as f64, !is_above);
    let mut found = Successes {
        episodes,
        policies: groups.iter().sum(),
        holds,
        fails,
        powers: Vec::new(),
        told: String::new(),
    };
    let is_negated = matches!(claim.over, Some(Over::None(_) | Over::AtMost(_)));
    let shares = match (is_negated, is_above) {
        (true, _) => vec![0.5],
        (false, true) => vec![0.999, 0.99],
        (false, false) => vec![boundary - 0.2, 0.1],
    };
    let at = |share: &f64| {
        Some(PowerAtShare {
            share: *share,
            power: found.power(*share, is_above, is_negated, &groups, needed)?,
        })
    };
    found.powers = shares.iter().filter_map(at).collect();
    found.told = found.in_words(is_above, is_negated, groups.len());
    Some(found)
}

impl Successes {
    /// The chance of a PASS when every policy has this share; `None` unless one or all alternatives decide
    /// the claim.
    fn power(
        &self,
        share: f64,
        is_above: bool,
        is_negated: bool,
        groups: &[usize],
        needed: usize,
    ) -> Option<f64> {
        let binomial = Binomial::new(share, self.episodes as u64).ok()?;
        let from = |count: Option<u64>| match count {
            None => 0.0,
            Some(0) => 1.0,
            Some(count) => binomial.sf(count - 1),
        };
        let to = |count: Option<u64>| count.map_or(0.0, |count| binomial.cdf(count));
        let (holds, fails) =
            if is_above { (from(self.holds), to(self.fails)) } else { (to(self.holds), from(self.fails)) };
        let all = |chance: f64, policies: usize| libm::pow(chance, policies as f64);
        match (is_negated, needed) {
            // Refuting one policy refutes its alternative; the claim fails when all alternatives are refuted.
            (true, 1) => Some(groups.iter().map(|policies| 1.0 - all(1.0 - fails, *policies)).product()),
            (false, 1) => {
                Some(1.0 - groups.iter().map(|policies| 1.0 - all(holds, *policies)).product::<f64>())
            }
            _ => None,
        }
    }

    fn in_words(&self, is_above: bool, is_negated: bool, alternatives: usize) -> String {
        let [or_more, or_fewer] = if is_above { ["or more", "or fewer"] } else { ["or fewer", "or more"] };
        let count = |count: Option<u64>, direction: &str, who: &str, verdict: &str| match count {
            Some(count) => format!("{verdict} where {who} {count} successes {direction}"),
            None => format!("no {verdict}"),
        };
        let (all, one) = match alternatives {
            1 => ("each has", "one has"),
            _ => ("one setting has in each policy", "every setting has in a policy"),
        };
        let [held, refuted] = if is_negated { ["FAIL", "PASS"] } else { ["PASS", "FAIL"] };
        let (held, refuted) =
            (count(self.holds, or_more, all, held), count(self.fails, or_fewer, one, refuted));
        let powers: Vec<String> = self
            .powers
            .iter()
            .map(|at| format!("at {} %: {} %", number(100.0 * at.share), number(100.0 * at.power)))
            .collect();
        let [first, second] = if is_negated { [refuted, held] } else { [held, refuted] };
        let parts = [vec![first], powers, vec![second]].concat();
        parts.join("; ")
    }
}

fn unit(claim: &Claim, metric: &MetricKind) -> &'static str {
    if claim.baseline.as_ref().is_some_and(|baseline| baseline.relative) { "" } else { metric.unit }
}

impl Planned {
    /// Its row in the table of a plan: claim, test, n, level, detectable effect, power, seeds for 80 %.
    pub fn cells(&self) -> [String; 7] {
        let absent = || "-".to_owned();
        let amount = |value: f64| match self.metric_unit {
            "%" => format!("{} points", number(100.0 * value)),
            "" => number(value),
            unit => format!("{} {unit}", number(value)),
        };
        let n = match self.unit {
            "run" => format!("{} seeds", self.seeds),
            _ => format!("{} policies", self.seeds),
        };
        let (mut detects, mut power) = (
            self.detects.map_or_else(absent, amount),
            self.power.map_or_else(absent, |power| format!("{} %", number(100.0 * power))),
        );
        if let Some(successes) = &self.successes {
            let told = |count: Option<u64>| count.map_or_else(absent, |count| count.to_string());
            detects = format!(
                "{}, not {}, of {}",
                told(successes.holds),
                told(successes.fails),
                successes.episodes
            );
            if let Some(at) = successes.powers.last() {
                power = format!("{} % at {} %", number(100.0 * at.power), number(100.0 * at.share));
            }
        }
        [
            self.id.clone(),
            self.test.clone(),
            n,
            number(self.level),
            detects,
            power,
            self.seeds_needed.map_or_else(absent, |seeds| seeds.to_string()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::Quantity;
    use crate::spec::claim::tests::sample;

    #[test]
    fn the_power_of_a_claim_is_that_of_its_effect_and_spread() {
        let quantity = |si: f64| Some(Quantity { si, text: si.to_string() });
        let claim = |effect: f64| Claim {
            margin: quantity(0.2),
            effect: quantity(effect),
            spread: quantity(0.1),
            ..sample("control=torque", Some("control=position"))
        };
        let arms = ["torque", "position"].map(|control| vec![("control".to_owned(), control.to_owned())]);
        let with = |claims: &[Claim], seeds: [usize; 2]| {
            let fields = Table::new();
            let arm = |(points, seeds): (&'_ Vec<(String, String)>, usize)| (points.clone(), seeds);
            let arms: Vec<_> = arms.iter().zip(seeds).map(arm).collect();
            let arms: Vec<PlannedArm> = arms
                .iter()
                .map(|(points, seeds)| PlannedArm { points, seeds: *seeds, fields: &fields })
                .collect();
            planned(claims, &arms)
        };
        let plan = |effect: f64, seeds: usize| with(&[claim(effect)], [seeds; 2]).remove(0);
        assert_eq!(with(&[claim(0.3)], [5, 3])[0].seeds, 3, "the arm with the fewest seeds decides");
        // The true value is two standard deviations beyond the margin: 17 runs suffice.
        assert!(plan(0.3, 17).power.is_some_and(|power| (power - 0.8).abs() < 0.01), "{:?}", plan(0.3, 17));
        assert_eq!(plan(0.3, 3).seeds_needed, Some(17));
        assert!(plan(0.3, 17).detects.is_some_and(|distance| (distance - 0.1).abs() < 0.002));
        assert!(plan(0.1, 17).power.is_some_and(|power| power < 0.001), "the effect is on the other side");
        assert_eq!(plan(0.1, 17).seeds_needed, None);
        assert!(
            with(&[claim(0.3)], [17, 9])[0].power < plan(0.3, 17).power,
            "an arm with fewer seeds has less power"
        );
        // Two claims share the level.
        assert_eq!(with(&[claim(0.3), claim(0.3)], [5; 2])[0].level, 0.025);
        let unknown = with(&[sample("control=torque", None)], [5; 2]).remove(0);
        assert_eq!((unknown.power, unknown.detects), (None, None));
    }

    #[test]
    fn several_comparisons_need_more_runs_than_one_and_their_mean_fewer() {
        let quantity = |si: f64| Some(Quantity { si, text: si.to_string() });
        let plan = |grounds: &[&str], over: Over, seeds: usize| {
            let claim = Claim {
                margin: quantity(0.2),
                effect: quantity(0.3),
                spread: quantity(0.1),
                over: Some(over),
                ..sample("control=torque", Some("control=position"))
            };
            let point = |axis: &str, point: &str| (axis.to_owned(), point.to_owned());
            let arms = |ground: &&str| {
                ["torque", "position"].map(|control| vec![point("control", control), point("ground", ground)])
            };
            let points: Vec<_> = grounds.iter().flat_map(arms).collect();
            let fields = Table::new();
            let arm = |points| PlannedArm { points, seeds, fields: &fields };
            let arms: Vec<PlannedArm> = points.iter().map(|points| arm(points.as_slice())).collect();
            planned(&[claim], &arms).remove(0)
        };
        let one = plan(&["hard"], Over::Each, 17);
        let [each, mean] = [Over::Each, Over::Mean].map(|over| plan(&["hard", "soft"], over, 17));
        for over in
            [Over::Some("ground".into()), Over::None("ground".into()), Over::AtLeast(1), Over::AtMost(1)]
        {
            let other = plan(&["hard", "soft"], over, 17);
            assert_eq!((other.power, other.detects, other.seeds_needed), (None, None, None), "not computed");
        }
        // Both comparisons must pass; the mean of two has half the variance.
        assert!(each.power.zip(one.power).is_some_and(|(each, one)| (each - one * one).abs() < 1e-9));
        assert!(each.detects > one.detects && one.detects > mean.detects, "{each:?} {one:?} {mean:?}");
        let needed = [&one, &each, &mean].map(|planned| planned.seeds_needed);
        assert_eq!(needed, [Some(17), Some(22), Some(9)]);
        for (over, seeds) in [(Over::Each, 22), (Over::Mean, 9)] {
            let power = |seeds| plan(&["hard", "soft"], over.clone(), seeds).power.expect("a power");
            assert!(power(seeds) >= 0.8 && power(seeds - 1) < 0.8, "{over:?}: {}", power(seeds));
        }
    }

    #[test]
    fn the_successes_that_decide_are_those_of_wilsons_interval() {
        use crate::spec::Value;
        use crate::spec::claim::{MetricPath, Operand};
        let claim = Claim {
            metric: MetricPath { stage: "evaluate.nominal".into(), name: "survival".into() },
            test: "wilson".into(),
            over: Some(Over::Each),
            ..sample("setting=*", None)
        };
        let mut claim = claim;
        claim.expect.right = Operand::Number(Quantity { si: 0.9, text: "90 %".into() });
        let nominal = Table::from([("episodes".to_owned(), Value::Count(128))]);
        let fields = Table::from([(
            "evaluate".to_owned(),
            Value::Table(Table::from([("nominal".to_owned(), Value::Table(nominal))])),
        )]);
        let points: Vec<_> =
            ["s5", "s10", "s20"].map(|point| vec![("setting".to_owned(), point.to_owned())]).into();
        let arms: Vec<PlannedArm> =
            points.iter().map(|points| PlannedArm { points, seeds: 3, fields: &fields }).collect();
        let claims: Vec<Claim> = (0..6).map(|_| claim.clone()).collect();
        let found = planned(&claims, &arms).remove(0).successes.expect("counts");
        // Six claims: each policy passes at 0.00833 and is refuted at a ninth of that level.
        assert_eq!(
            (found.holds, found.fails, found.policies, found.episodes),
            (Some(125), Some(103), 9, 128)
        );
        assert!(found.powers[1].power > 0.68 && found.powers[1].power < 0.70, "{found:?}");
        assert!(
            found.told.starts_with("PASS where each has 125 successes or more; at 99.9 %: "),
            "{}",
            found.told
        );
        assert!(found.told.ends_with("FAIL where one has 103 successes or fewer"), "{}", found.told);
    }
}
