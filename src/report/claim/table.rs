//! Claims in a report: a table, and a sentence for each.

use super::{Case, Evidence, Judged, Ruling};
use crate::escape::markdown::code;
use crate::kinds::metric;
use crate::kinds::statistic::{self, FEW, SMALLEST_OF_FEW, Unit};
use crate::report::estimate::Estimate;
use crate::report::table::{Cell, Table};
use crate::report::wording::{arm_in_words, capitalised, listed, significance, with_interval};
use crate::spec::claim::Paper;
use crate::statistics::mean::coverage;

/// The table of the claims, one row per comparison.
pub fn table(judged: &[Judged]) -> Table {
    let heads =
        ["", "verdict", "expected", "measured", "interval's confidence", "n", "test", "p", "the paper"];
    let mut table = Table::new("claims", "Claims", heads.map(String::from));
    for claim in judged {
        if claim.cases.is_empty() || !claim.alternatives.is_empty() {
            let sources = claim.cases.iter().flat_map(|case| case.sources.clone()).collect();
            table.row_from(&claim.id, &format!("`{}`", claim.id), row(claim, None, judged.len()), sources);
        }
        for case in &claim.cases {
            let (name, label) = match case.label.as_str() {
                "" => (claim.id.clone(), format!("`{}`", claim.id)),
                label => {
                    (format!("{}/{label}", claim.id), format!("`{}`, {}", claim.id, arm_in_words(label)))
                }
            };
            table.row_from(&name, &label, row(claim, Some(case), judged.len()), case.sources.clone());
        }
    }
    table.sources =
        judged.iter().flat_map(|claim| &claim.cases).flat_map(|case| case.sources.clone()).collect();
    table.sources.sort();
    table.sources.dedup();
    table
}

/// `claims`: how many claims the page has.
fn row(claim: &Judged, case: Option<&Case>, claims: usize) -> Vec<Cell> {
    let own = case.filter(|_| claim.cases.len() > 1);
    let verdict = own.map_or_else(|| claim.verdict.word(), |case| claim.word_of(case));
    let measured = match case {
        Some(case) => shown(case),
        None if claim.cases.is_empty() => "\u{2013}".to_owned(),
        None => in_brief(claim, claims),
    };
    let measured = Cell::from(measured);
    let p = match (case.and_then(|case| case.p), claim.p_adjusted) {
        // The claim's own p value is in its sentence.
        (Some(p), _) if own.is_some() => told(p, case),
        (None, Some(adjusted)) if case.is_none() => format!("corrected {}", significance(adjusted)),
        (Some(p), Some(adjusted)) => format!("{}, corrected {}", told(p, case), significance(adjusted)),
        (Some(p), None) => told(p, case),
        _ => "\u{2013}".to_owned(),
    };
    let paper = claim.paper.as_ref().map_or_else(String::new, Paper::in_words);
    let n = case.map_or_else(String::new, |case| counted(claim, case));
    let confidence = confidence(claim, case);
    let expect = format!("{}: {}", claim.metric, code(&claim.expect));
    let words = [verdict.to_owned(), expect].map(Cell::from);
    let rest = [confidence, n, claim.test.clone(), p, paper].map(Cell::from);
    words.into_iter().chain([measured]).chain(rest).collect()
}

/// A p value, with a note if it is the smallest possible with so few runs.
fn told(p: f64, case: Option<&Case>) -> String {
    let is_of_few = |case: &Case| case.fewest < FEW && matches!(case.evidence, Some(Evidence::Runs { .. }));
    match case {
        Some(case) if p == SMALLEST_OF_FEW && is_of_few(case) => {
            format!("{} (the smallest below {FEW} seeds)", significance(p))
        }
        _ => significance(p),
    }
}

/// The confidence level of a claim's intervals, and the actual coverage of a bootstrap over so few runs.
fn confidence(claim: &Judged, case: Option<&Case>) -> String {
    let named = format!("{} %", percent(1.0 - claim.alpha));
    let is_bootstrap = ["stratified_bootstrap", "probability_of_improvement"].contains(&claim.test.as_str());
    let few = case.filter(|_| is_bootstrap).and_then(|case| Some((case, coverage(case.fewest)?)));
    let Some((case, [mean, difference])) = few else { return named };
    // Coverage was simulated for means of a single stratum at the 5 % level.
    let is_known = claim.test == "stratified_bootstrap"
        && percent(claim.alpha) == 5.0
        && case.n.iter().min() == Some(&case.fewest);
    match is_known {
        true => format!(
            "{named} in name, about {} % over so few runs",
            if case.sides.len() > 1 { difference } else { mean }
        ),
        false => format!("{named} in name, less over so few runs"),
    }
}

/// `Of 3 claims 1 passes ...`; empty without claims.
pub fn count(judged: &[Judged]) -> String {
    let count = |ruling| judged.iter().filter(|claim| claim.verdict == ruling).count();
    match judged.len() {
        0 => String::new(),
        all => {
            let meaningless = match count(Ruling::NotMeaningful) {
                0 => String::new(),
                1 => " 1 of them is not meaningful, because robots fail their task.".to_owned(),
                some => format!(" {some} of them are not meaningful, because robots fail their task."),
            };
            let open = count(Ruling::NotEstablished) + count(Ruling::NotMeaningful);
            let words = [
                verbal(count(Ruling::Pass), ["passes", "pass"]),
                verbal(count(Ruling::Fail), ["fails", "fail"]),
                verbal(open, ["is not established", "are not established"]),
            ];
            let plural = if all == 1 { "" } else { "s" };
            format!("Of {all} claim{plural} {}.{meaningless}", listed(&words))
        }
    }
}

/// `1 passes`, `2 pass`.
fn verbal(count: usize, [one, several]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// Which claims are meaningless because robots fail their task, with these runs; `None` without such claims.
pub fn meaningless(judged: &[Judged]) -> Option<String> {
    let claims: Vec<&Judged> = judged.iter().filter(|claim| claim.verdict == Ruling::NotMeaningful).collect();
    let ids: Vec<String> = claims.iter().map(|claim| code(&claim.id)).collect();
    let mut runs: Vec<String> =
        claims.iter().flat_map(|claim| claim.failing.iter().map(|run| arm_in_words(run))).collect();
    runs.sort();
    runs.dedup();
    let (plural, verb) = if ids.len() == 1 { ("", "is") } else { ("s", "are") };
    (!ids.is_empty()).then(|| {
        format!(
            "**{} claim{plural} {verb} not meaningful, because robots fail their task.** Claim{plural}: {}. \
             Runs that fail: {}.",
            ids.len(),
            some(&ids),
            some(&runs)
        )
    })
}

/// The measurement in a table of many suites: the number with its interval and n, or how many comparisons
/// pass; and that only the correction for this number of claims leaves the claim open.
pub fn in_brief(claim: &Judged, claims: usize) -> String {
    let corrected = || format!("alone, not established after the correction for {claims} claims");
    match (claim.cases.as_slice(), alone(claim)) {
        ([], _) => "nothing was measured".to_owned(),
        ([case], alone) => {
            let alone = alone.map_or_else(String::new, |verdict| match verdict {
                Ruling::Fail => format!("; fails {}", corrected()),
                _ => format!("; passes {}", corrected()),
            });
            format!("{} (n = {}){alone}", shown(case), counted(claim, case))
        }
        _ if !claim.alternatives.is_empty() => alternatives(claim),
        (cases, alone) => {
            let count = |ruling| cases.iter().filter(|case| case.verdict == ruling).count();
            let range = range(cases).map_or_else(String::new, |range| format!("{range}; "));
            let (all, pass, fail) = (cases.len(), count(Ruling::Pass), count(Ruling::Fail));
            match alone {
                Some(Ruling::Fail) => {
                    let verb = if fail == 1 { "fails" } else { "fail" };
                    format!("{range}{fail} of {all} comparisons {verb} {}", corrected())
                }
                Some(_) => format!("{range}{pass} of {all} comparisons pass {}", corrected()),
                None => format!("{range}of {all} comparisons {pass} pass, {fail} fail"),
            }
        }
    }
}

/// What a claim would be without the correction for several claims; `None` if the correction does not decide.
fn alone(claim: &Judged) -> Option<Ruling> {
    let exceeds = |p: Option<f64>| p.is_some_and(|p| p > claim.alpha);
    let is_corrected = claim.verdict == Ruling::NotEstablished
        && claim.missing.is_empty()
        && claim.alternatives.is_empty()
        && exceeds(claim.p_adjusted)
        && !exceeds(claim.p);
    let is = |ruling: Ruling| move |case: &Case| case.verdict == ruling;
    match is_corrected {
        true if claim.cases.iter().any(is(Ruling::Fail)) => Some(Ruling::Fail),
        true if claim.cases.iter().all(is(Ruling::Pass)) => Some(Ruling::Pass),
        _ => None,
    }
}

/// `0.043 to 0.078 rad`: the smallest and the largest estimate; `None` if one is missing or infinite.
fn range(cases: &[Case]) -> Option<String> {
    let values: Option<Vec<f64>> =
        cases.iter().map(|case| case.estimate.value.filter(|value| value.is_finite())).collect();
    let of = |pick: fn(f64, f64) -> f64| {
        let value = values.as_ref()?.iter().copied().reduce(pick)?;
        let case = cases.iter().find(|case| case.estimate.value == Some(value))?;
        let estimate = Estimate { low: None, high: None, ..case.estimate.clone() };
        Some(shown(&Case { estimate, ..case.clone() }))
    };
    let [low, high] = [of(f64::min)?, of(f64::max)?];
    // Both have the unit of the metric.
    let number = low.split(' ').next().unwrap_or(&low);
    Some(if low == high { low } else { format!("{number} to {high}") })
}

/// `holds at 2 of 3 points of `setting`, fails at 1`.
fn alternatives(claim: &Judged) -> String {
    let [holds, fails] = [Ruling::Pass, Ruling::Fail].map(|verdict| claim.alternatives_that(verdict));
    let all = claim.alternatives.len();
    let of =
        if claim.axis.is_empty() { "comparisons".to_owned() } else { format!("points of `{}`", claim.axis) };
    let open = match all - holds - fails {
        0 => String::new(),
        open => format!(", {open} open"),
    };
    format!("holds at {holds} of {all} {of}, fails at {fails}{open}")
}

/// One sentence on the correction for multiple claims; empty without claims.
pub fn correction(judged: &[Judged]) -> String {
    let untested: Vec<String> =
        judged.iter().filter(|claim| claim.p.is_none()).map(|claim| format!("`{}`", claim.id)).collect();
    let counted = match untested.is_empty() {
        true => String::new(),
        false => format!(" Not tested, but counted: {}.", untested.join(", ")),
    };
    match judged.len() {
        0 => String::new(),
        1 => "There is one claim, so nothing is corrected for their number.".to_owned(),
        count => format!("The p values are corrected for {count} claims by Holm's method.{counted}"),
    }
}

/// One sentence per claim, with missing runs and caveats.
pub fn sentences(judged: &[Judged]) -> Vec<String> {
    let corrected = judged.len() > 1;
    judged.iter().map(|claim| sentence(claim, corrected)).collect()
}

/// The verdict on a claim; `corrected`: its p value is corrected for multiple claims.
fn sentence(claim: &Judged, corrected: bool) -> String {
    let mut text = format!("**{}**: {}. ", claim.verdict.word(), claim.text.trim_end_matches('.'));
    text += &match claim.cases.as_slice() {
        [] => "Nothing was measured.".to_owned(),
        _ if !claim.alternatives.is_empty() => {
            let named = |verdict: Ruling| {
                let points = claim.alternatives.iter().filter(|alternative| alternative.verdict == verdict);
                points.map(|alternative| code(&alternative.point)).collect::<Vec<_>>().join(", ")
            };
            let serving = match named(Ruling::Pass) {
                none if none.is_empty() => String::new(),
                points => format!(" It holds at {points}."),
            };
            format!("`{}`, {}: {}.{serving}", claim.metric, code(&claim.expect), alternatives(claim))
        }
        [case] => evidence(claim, case),
        cases => {
            let count = |ruling| cases.iter().filter(|case| case.verdict == ruling).count();
            let (pass, fail) = (count(Ruling::Pass), count(Ruling::Fail));
            format!(
                "Of {} comparisons {pass} pass, {fail} fail and {} are not established.",
                cases.len(),
                cases.len() - pass - fail
            )
        }
    };
    if !claim.failing.is_empty() {
        text += &format!(
            " These runs fail their task, so their {} says nothing about the methods: {}.",
            metric_of(claim),
            some(&claim.failing.iter().map(|run| arm_in_words(run)).collect::<Vec<_>>())
        );
    }
    if let Some(p) = claim.p_adjusted {
        let method = if corrected { ", corrected over the claims by Holm's method," } else { "" };
        text += &format!(" Its p{method} is {}.", significance(p));
    }
    if statistic::find(&claim.test).is_some_and(|test| test.unit() == Unit::Episode) {
        text += " This is about these policies, not about the methods.";
    }
    if !claim.missing.is_empty() {
        text += &format!(" Missing, so that nothing is established: {}.", claim.missing.join("; "));
    }
    if let Some(settled) = &claim.settled_by {
        text += &format!(" {}.", capitalised(settled));
    }
    if let Some(paper) = &claim.paper {
        let less = if paper.weaker { "; this claim expects less" } else { "" };
        text += &format!(" The paper ({}): {}{less}.", paper.place, paper.value.trim_end_matches('.'));
    }
    text
}

/// The name of the metric in words.
fn metric_of(claim: &Judged) -> &str {
    let own = claim.metric.split(' ').next().unwrap_or_default();
    let name = own.rsplit('.').next().unwrap_or_default();
    metric::find(name).map_or(name, |metric| metric.label)
}

/// Lists names that may contain commas, abbreviated if there are many.
fn some(names: &[String]) -> String {
    const NAMED: usize = 6;
    let shown = names[..names.len().min(NAMED)].join("; ");
    match names.len().saturating_sub(NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// `survival differs by 31 points [12, 48] (91 % and 60 %; 5 and 5 runs; welch)`.
fn evidence(claim: &Judged, case: &Case) -> String {
    let (compares, shown) = (case.sides.len() > 1, shown(case));
    let what = match (claim.test.as_str(), compares) {
        ("probability_of_improvement", _) => {
            format!("probability of improvement {}", with_interval(&case.estimate, true))
        }
        (_, true) if case.estimate.value.is_some_and(f64::is_infinite) => {
            "most runs of one side never reach the threshold".to_owned()
        }
        (_, true) if claim.factor != 1.0 => format!("a - {} b = {shown}", claim.factor),
        (_, true) => format!("difference {shown}"),
        (_, false) => format!("measured {shown}"),
    };
    let remark = if case.remark.is_empty() { String::new() } else { format!("; {}", case.remark) };
    format!(
        "`{}`, {}: {what} (n = {}, {}{remark}).",
        claim.metric,
        code(&claim.expect),
        counted(claim, case),
        claim.test
    )
}

/// The estimate with its unit: differences of shares are in percentage points.
fn shown(case: &Case) -> String {
    let text = with_interval(&case.estimate, true);
    match (case.estimate.unit.as_str(), case.sides.len()) {
        ("%", 2) => text.replacen(" %", " points", 1),
        _ => text,
    }
}

/// `5 and 5 runs`.
fn counted(claim: &Judged, case: &Case) -> String {
    let counts: Vec<String> = case.n.iter().map(usize::to_string).collect();
    let plural = if counts == ["1"] { "" } else { "s" };
    format!("{} {}{plural}", counts.join(" and "), claim.unit)
}

fn percent(share: f64) -> f64 {
    (share * 1e4).round() / 1e2
}
