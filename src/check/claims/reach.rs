//! W0511 and W1001: there is a result that could establish the claim, and one that could refute it.
//!
//! With few episodes even the best outcome has an interval across the boundary, and the mean of shares lies
//! beyond neither end. The best outcomes are made up here and put to the claim's own test.

use super::{ArmScope, Scope, at};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy;
use crate::kinds::metric::{MetricKind, Scale};
use crate::kinds::statistic::{Method, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Over, Relation, alternatives};
use crate::statistics::Interval;
use crate::statistics::region::Region;
use crate::statistics::test::{Sample, Test};
use crate::statistics::trend;

/// The most episodes that the help looks at; no evaluation can have more.
const MOST: usize = 100_000;

/// W0511 when no result can establish the claim, else W1001 when none can refute it.
pub fn can_be_decided(
    claim: &Claim,
    metric: &MetricKind,
    statistic: &StatisticKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    // A ratio of shares has no upper end.
    let is_ratio = claim.baseline.as_ref().is_some_and(|baseline| baseline.relative);
    if metric.scale != Scale::Success && metric.unit != "%" || is_ratio {
        return;
    }
    let is_negated = matches!(claim.over, Some(Over::None(_) | Over::AtMost(_)));
    let reach = Reach { claim, statistic, scope, cases };
    if let Some(best) = reach.unsettled(is_negated) {
        sink.emit(best.warning());
    } else if let Some(best) = reach.unsettled(!is_negated) {
        sink.emit(best.refutation());
    }
}

/// What the comparisons of a claim can come to.
struct Reach<'a> {
    claim: &'a Claim,
    statistic: &'a StatisticKind,
    scope: &'a Scope<'a>,
    cases: &'a [Case],
}

impl<'a> Reach<'a> {
    /// The first comparison that stands in the way of the expectation, or of the opposite when `opposed`.
    fn unsettled(&self, opposed: bool) -> Option<Best<'a>> {
        let points = self.scope.points();
        let alternatives = alternatives(self.claim, &points, self.cases);
        let holding = match self.claim.over {
            Some(Over::AtLeast(count)) => count,
            Some(Over::AtMost(count)) => count + 1,
            _ => 1,
        };
        let refuting = (alternatives.len() + 1).saturating_sub(holding);
        let (needed, divisor) = if opposed { (refuting, holding) } else { (holding, refuting) };
        let open = alternatives.iter().map(|alternative| {
            let share = if opposed { divisor * alternative.cases.len() } else { divisor };
            let mut all = alternative.cases.iter().map(|place| self.best(*place, share, opposed));
            match opposed {
                // One comparison that is refuted refutes the alternative.
                true if all.clone().any(|best| best.settles()) => None,
                true => all.next(),
                false => all.find(|best| !best.settles()),
            }
        });
        let open: Vec<Option<Best>> = open.collect();
        let settled = open.iter().filter(|best| best.is_none()).count();
        if settled >= needed { None } else { open.into_iter().flatten().next() }
    }

    /// The best that can come out of a comparison at a share of alpha.
    fn best(&self, place: usize, share: usize, opposed: bool) -> Best<'a> {
        let case = &self.cases[place];
        let arms: Vec<&ArmScope> =
            [Some(case.a), case.b].into_iter().flatten().map(|arm| &self.scope.arms[arm]).collect();
        // Of a test over episodes every seed is a comparison of its own.
        let seeds = arms.iter().map(|arm| arm.runs).max().unwrap_or(1).max(1);
        let divisor = if opposed && self.statistic.unit() == Unit::Episode { share * seeds } else { share };
        let episodes =
            arms.iter().filter_map(|arm| deploy::episodes(arm.fields, &self.claim.metric.stage)).min();
        let (claim, statistic) = (self.claim, self.statistic);
        let level = claim.alpha / divisor.max(1) as f64;
        Best { claim, statistic, negated: opposed, level, episodes, points: self.cases.len() }
    }
}

/// The best that can come out of a comparison.
#[derive(Clone)]
struct Best<'a> {
    claim: &'a Claim,
    statistic: &'a StatisticKind,
    /// Whether the claim needs the opposite of what it expects.
    negated: bool,
    /// The level at which the comparison is judged.
    level: f64,
    /// Episodes of a run.
    episodes: Option<usize>,
    /// Points of a trend.
    points: usize,
}

impl Best<'_> {
    /// Whether some result settles the comparison.
    fn settles(&self) -> bool {
        match self.episodes {
            Some(episodes) if self.counts() => self.settled_by(episodes),
            _ => self
                .ends()
                .into_iter()
                .any(|value| self.is_where_wanted(Interval { low: value, high: value })),
        }
    }

    /// Whether the test counts successes, so that its interval depends on their number alone.
    fn counts(&self) -> bool {
        matches!(self.statistic.method, Method::Wilson | Method::Mcnemar | Method::Newcombe)
            && !self.is_trend()
    }

    fn is_trend(&self) -> bool {
        matches!(self.claim.over, Some(Over::Trend(_)))
    }

    fn region(&self) -> Region {
        Region::of(self.claim, self.statistic)
    }

    fn is_where_wanted(&self, interval: Interval) -> bool {
        if self.negated { self.region().opposes(interval) } else { self.region().holds(interval) }
    }

    /// The range of means of shares, of their differences or slopes.
    fn range(&self) -> [f64; 2] {
        if self.statistic.method == Method::ProbabilityOfImprovement {
            return [0.0, 1.0];
        }
        let least = if self.claim.baseline.is_some() { -1.0 } else { 0.0 };
        let [low, high] = if self.is_trend() {
            // The steepest trend has its first half at one end of the range and its second half at the other.
            let steepest: f64 = trend::weights(self.points).into_iter().filter(|weight| *weight > 0.0).sum();
            [-steepest * (1.0 - least), steepest * (1.0 - least)]
        } else {
            [least, 1.0]
        };
        let factor = self.claim.expect.factor;
        if self.claim.sides.len() == 1 { [low, high] } else { [low - factor * high, high - factor * low] }
    }

    /// What the means of shares can come to at their best.
    fn ends(&self) -> Vec<f64> {
        let [low, high] = self.range();
        vec![low, high, self.region().boundary().clamp(low, high)]
    }

    /// The outcomes of so many episodes that speak most clearly.
    fn outcomes(&self, episodes: usize) -> Vec<Sample> {
        let sample = |counts: &[usize]| {
            let side = |count: &usize| (0..episodes).map(|at| f64::from(u8::from(at < *count))).collect();
            Sample::Episodes { sides: counts.iter().map(side).collect(), paired: counts.len() == 2 }
        };
        if self.claim.sides.len() == 2 {
            let half = episodes / 2;
            return [[episodes, 0], [0, episodes], [episodes; 2], [half; 2]]
                .map(|counts| sample(&counts))
                .into();
        }
        // Of a range the smallest count whose interval begins inside it.
        let begins_below = |count: &usize| {
            let interval = self.interval(&sample(&[*count]));
            let low = self.region().bounds().0;
            interval.zip(low).is_some_and(|(interval, low)| interval.low <= low)
        };
        let counts: Vec<usize> = (0..=episodes).collect();
        let middle = match self.claim.expect.relation {
            Relation::Equal => counts.partition_point(begins_below).min(episodes),
            _ => episodes,
        };
        [middle, 0, episodes].map(|count| sample(&[count])).into()
    }

    fn test(&self) -> Test<'_> {
        let (method, summary) = (self.statistic.method, self.claim.summary);
        Test { method, summary, trend: false, factor: self.claim.expect.factor, name: &self.claim.id }
    }

    fn interval(&self, sample: &Sample) -> Option<Interval> {
        self.test().interval(sample, 1.0 - self.level)
    }

    /// The p value for what is wanted.
    fn p(&self, sample: &Sample) -> Option<f64> {
        let (test, region) = (self.test(), self.region());
        let value = test.measure(sample).value?;
        let p = |boundary: f64| test.p(sample, boundary);
        if self.negated { region.p_against(value, p) } else { region.p_for(value, p) }
    }

    /// Whether so many episodes could settle it.
    fn settled_by(&self, episodes: usize) -> bool {
        self.outcomes(episodes).iter().any(|sample| {
            self.interval(sample).is_some_and(|interval| self.is_where_wanted(interval))
                && self.p(sample).is_some_and(|p| p <= self.level)
        })
    }

    /// The fewest episodes that could, looked for from these upwards.
    fn enough(&self, episodes: usize) -> Option<usize> {
        let (mut too_few, mut enough) = (episodes, episodes.max(1) * 2);
        while !self.settled_by(enough.min(MOST)) {
            too_few = enough;
            enough *= 2;
            if too_few >= MOST {
                return None;
            }
        }
        enough = enough.min(MOST);
        while enough - too_few > 1 {
            let middle = too_few.midpoint(enough);
            if self.settled_by(middle) { enough = middle } else { too_few = middle }
        }
        Some(enough)
    }

    /// What the clearest outcome of so many episodes comes to.
    fn at_best(&self, episodes: usize) -> String {
        let percent = |share: f64| short(100.0 * share);
        let outcomes = self.outcomes(episodes);
        let found = outcomes.iter().filter_map(|sample| Some((sample, self.interval(sample)?)));
        let (centre, relation) = (self.region().boundary(), self.claim.expect.relation);
        let wants_more = matches!(relation, Relation::Greater | Relation::AtLeast) != self.negated;
        // How far the interval reaches across the boundary.
        let order = |interval: &Interval| match (relation, wants_more) {
            (Relation::Equal, _) => (centre - interval.low).max(interval.high - centre),
            (_, true) => -interval.low,
            (_, false) => interval.high,
        };
        match found.min_by(|(_, a), (_, b)| order(a).total_cmp(&order(b))) {
            Some((sample, interval)) if self.is_where_wanted(interval) => {
                format!("at best p = {}", short(self.p(sample).unwrap_or(1.0)))
            }
            Some((_, interval)) => {
                format!("at best the interval is [{}, {}] %", percent(interval.low), percent(interval.high))
            }
            None => "too few episodes".to_owned(),
        }
    }

    /// W1001: the data cannot contradict the claim.
    fn refutation(&self) -> Diagnostic {
        let id = &self.claim.id;
        let message = format!("no result can refute `{id}`: it can pass, but not fail");
        let warning =
            at(self.claim, "expect", Diagnostic::warning("W1001", message), "nothing contradicts it");
        match self.episodes.filter(|_| self.counts()).map(|episodes| self.enough(episodes)) {
            Some(Some(enough)) => {
                let stage = &self.claim.metric.stage;
                warning.help(format!("give `{stage}` {enough} episodes or more, or expect more"))
            }
            _ => warning.help("expect more: state the smallest effect that the claim is about"),
        }
    }

    fn warning(&self) -> Diagnostic {
        let id = &self.claim.id;
        let warned = |message: String, remark: &str| {
            at(self.claim, "expect", Diagnostic::warning("W0511", message), remark)
        };
        match self.episodes.filter(|_| self.counts()) {
            Some(episodes) => {
                let message = format!("no result of {episodes} episodes can establish `{id}`");
                let warning = warned(message, &self.at_best(episodes));
                match self.enough(episodes) {
                    Some(enough) => {
                        let stage = &self.claim.metric.stage;
                        warning.help(format!(
                            "give `{stage}` {enough} episodes or more, or weaken what is expected"
                        ))
                    }
                    None => warning.help("weaken what is expected: no number of episodes can show it"),
                }
            }
            None => {
                let [low, high] = self.range().map(|end| short(100.0 * end));
                let remark = format!("lies between {low} and {high} %");
                warned(format!("no result can establish `{id}`"), &remark)
                    .help("weaken what is expected; `>=` and `<=` at an end of the range need a `margin`")
            }
        }
    }
}
