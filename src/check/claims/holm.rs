//! W0511: a claim can be established under the Holm correction for all claims of its suite.

use super::{Scope, arms_in, at, sample};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::statistic::{self, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Points, cases, keys};
use crate::spec::suggest::listed;
use crate::statistics::multiplicity::holm;

/// Bisection steps of the search for the smallest p value among the levels.
const STEPS: usize = 60;

/// W0511, once: claims with so few runs that the Holm correction for all claims leaves each open, even if
/// every claim has the smallest p value of its test.
pub fn can_be_established(claims: &[Claim], scope: &Scope, sink: &mut Sink) {
    let planned: Vec<Planned> = claims.iter().map(|claim| Planned::new(claim, scope)).collect();
    let smallest: Vec<f64> = planned.iter().map(|planned| planned.smallest).collect();
    let adjusted = holm(&smallest);
    let open: Vec<(&Claim, &Planned)> = claims
        .iter()
        .zip(&planned)
        .zip(adjusted)
        .filter(|((claim, planned), adjusted)| planned.runs > 1 && *adjusted > claim.alpha * (1.0 + 1e-6))
        .map(|(pair, _)| pair)
        .collect();
    let Some((first, planned)) = open.first() else { return };
    let names: Vec<String> = open.iter().map(|(claim, _)| format!("`{}`", claim.id)).collect();
    let names = match names.as_slice() {
        [] | [_] | [_, _] | [_, _, _] => listed(open.iter().map(|(claim, _)| claim.id.as_str())),
        [first, rest @ ..] => format!("{first} and {} more claims", rest.len()),
    };
    let message = format!(
        "no result of {} seeds can establish {names}: Holm's correction is for {} claims",
        planned.runs,
        claims.len()
    );
    let remark = format!("p is {} at best, times {}", short(planned.smallest), claims.len());
    let warning = at(first, keys::Claim::test.name, Diagnostic::warning("W0511", message), &remark);
    let level = first.alpha / (planned.divisor * claims.len() as f64);
    let warning = match scope.seeds {
        Some(span) => warning.note(span, "the seeds"),
        None => warning,
    };
    let needed = planned.test.map_or(planned.runs + 1, |test| (test.least)(level));
    sink.emit(warning.help(format!(
        "write `seeds = {needed}` or more in `[sweep]`, or make several suites of the claims"
    )));
}

/// The best possible result of a claim's test.
struct Planned {
    test: Option<&'static StatisticKind>,
    /// Number of runs of its smallest arm.
    runs: usize,
    /// Divisor of the level for its comparisons.
    divisor: f64,
    /// The smallest possible p value of the claim.
    smallest: f64,
}

impl Planned {
    fn new(claim: &Claim, scope: &Scope) -> Self {
        let points: Vec<&Points> = scope.points();
        let cases: Vec<Case> = cases(claim, &points);
        let runs = arms_in(&cases, scope).into_iter().map(|arm| arm.runs).min().unwrap_or(0);
        let test = statistic::find(&claim.test);
        let divisor = claim.alpha / sample::levels(claim, scope, &cases)[0];
        let smallest = match test {
            // A claim that stays open still counts among the claims.
            Some(test) if test.unit() == Unit::Seed => (divisor * smallest_p(test, runs)).min(1.0),
            _ => 0.0,
        };
        Self { test, runs, divisor, smallest }
    }
}

/// The smallest possible p value of a test with this many runs; 1 if none is below a half.
fn smallest_p(test: &StatisticKind, runs: usize) -> f64 {
    let is_reached = |level: f64| (test.least)(level) <= runs;
    let (mut low, mut high) = (libm::log(1e-9), libm::log(0.5));
    if !is_reached(libm::exp(high)) {
        return 1.0;
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if is_reached(libm::exp(middle)) { high = middle } else { low = middle }
    }
    libm::exp(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_p_values_are_those_of_the_tests() {
        let of = |name: &str, runs: usize| smallest_p(statistic::find(name).expect("a test"), runs);
        assert!((of("welch", 3) - statistic::SMALLEST_OF_FEW).abs() < 1e-9);
        assert!(of("welch", 5) < 1e-8);
        // Two of the 252 orders of five runs against five.
        assert!((of("mann_whitney", 5) - 2.0 / 252.0).abs() < 1e-9);
        assert_eq!(of("mann_whitney", 1), 1.0);
    }
}
