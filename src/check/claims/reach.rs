//! W0511 and W1001: some result could establish the claim, and some could refute it.
//!
//! With few episodes even the best outcome's interval may cross the boundary, and means of shares cannot
//! exceed 0 or 1. The best outcomes are constructed here and passed to the claim's own test.

use super::range::{self, Range, in_unit};
use super::{ArmScope, Scope, at};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::deploy;
use crate::kinds::metric::{MetricKind, Scale};
use crate::kinds::statistic::{Method, StatisticKind, Unit};
use crate::spec::claim::{Case, Claim, Operand, Over, Relation, alternatives, keys};
use crate::statistics::Interval;
use crate::statistics::mean::FEWEST;
use crate::statistics::region::Region;
use crate::statistics::test::{Sample, Test};

/// Maximum number of episodes considered in the help; no evaluation can have more.
const MOST: usize = 100_000;

/// Maximum number of seeds considered in the help.
const MOST_SEEDS: usize = 200;

/// W0511 if no result, or none with identical runs, can establish the claim; W1001 if none can refute it.
pub fn can_be_decided(
    claim: &Claim,
    metric: &MetricKind,
    statistic: &StatisticKind,
    scope: &Scope,
    cases: &[Case],
    sink: &mut Sink,
) {
    let is_negated = matches!(claim.over, Some(Over::None(_) | Over::AtMost(_)));
    let reach = Reach { claim, metric, statistic, scope, cases };
    if let Some(best) = reach.unsettled(is_negated, Best::settles) {
        sink.emit(best.warning());
        return;
    }
    if let Some(best) = reach.unsettled(!is_negated, Best::settles) {
        sink.emit(best.refutation());
    } else if sink.diagnostics.iter().any(|found| found.code == "W1004") {
        // The cause is a distance of zero.
    } else if let Some(best) = reach.unsettled(is_negated, Best::settles_alike) {
        sink.emit(best.of_alike_runs());
    }
}

/// The possible results of a claim's comparisons.
struct Reach<'a> {
    claim: &'a Claim,
    metric: &'a MetricKind,
    statistic: &'a StatisticKind,
    scope: &'a Scope<'a>,
    cases: &'a [Case],
}

impl<'a> Reach<'a> {
    /// The first comparison whose results cannot settle the expectation, or its opposite if `opposed`.
    fn unsettled(&self, opposed: bool, settles: fn(&Best<'a>) -> bool) -> Option<Best<'a>> {
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
                // Refuting one comparison refutes the alternative.
                true if all.clone().any(|best| settles(&best)) => None,
                true => all.next(),
                false => all.find(|best| !settles(best)),
            }
        });
        let open: Vec<Option<Best>> = open.collect();
        let settled = open.iter().filter(|best| best.is_none()).count();
        if settled >= needed { None } else { open.into_iter().flatten().next() }
    }

    /// The best possible result of a comparison at a share of alpha.
    fn best(&self, place: usize, share: usize, opposed: bool) -> Best<'a> {
        let case = &self.cases[place];
        let arms: Vec<&ArmScope> =
            [Some(case.a), case.b].into_iter().flatten().map(|arm| &self.scope.arms[arm]).collect();
        // In a test over episodes every seed is a separate comparison.
        let seeds = arms.iter().map(|arm| arm.runs).max().unwrap_or(1).max(1);
        let divisor = if opposed && self.statistic.unit() == Unit::Episode { share * seeds } else { share };
        let episodes =
            arms.iter().filter_map(|arm| deploy::episodes(arm.fields, &self.claim.metric.stage)).min();
        let (claim, metric, statistic) = (self.claim, self.metric, self.statistic);
        let level = claim.alpha / divisor.max(1) as f64;
        let runs = arms.iter().map(|arm| arm.runs).collect();
        let points = self.cases.len();
        Best { claim, metric, statistic, negated: opposed, level, episodes, runs, points }
    }
}

/// The best possible result of a comparison.
#[derive(Clone)]
struct Best<'a> {
    claim: &'a Claim,
    metric: &'a MetricKind,
    statistic: &'a StatisticKind,
    /// Whether the claim needs the opposite of its expectation.
    negated: bool,
    /// The significance level of the comparison.
    level: f64,
    /// Episodes per run.
    episodes: Option<usize>,
    /// Runs of each arm.
    runs: Vec<usize>,
    /// Points of a trend.
    points: usize,
}

impl Best<'_> {
    /// Whether some result settles the comparison.
    fn settles(&self) -> bool {
        match self.episodes {
            Some(episodes) if self.counts() => self.settled_by(episodes),
            _ if self.too_few_to_resample().is_some() => false,
            _ => self
                .ends()
                .into_iter()
                .any(|value| self.is_where_wanted(Interval { low: value, high: value })),
        }
    }

    /// The number of episodes, if it is too small for a p value from a bootstrap over episodes.
    fn too_few_to_resample(&self) -> Option<usize> {
        let is_resampled = self.statistic.method == Method::EpisodeBootstrap;
        self.episodes.filter(|episodes| is_resampled && *episodes < FEWEST)
    }

    /// Whether identical runs, which have no spread, settle the comparison: in one of the clearest outcomes,
    /// with all or no episodes of an arm successful, on the wanted side.
    fn settles_alike(&self) -> bool {
        self.p_of_alike_runs().is_none_or(|p| p <= self.level)
    }

    /// The smallest p value of those outcomes; `None` if none is on the wanted side, or if the test is not
    /// affected by a lack of spread.
    fn p_of_alike_runs(&self) -> Option<f64> {
        let is_mean = matches!(self.statistic.method, Method::Welch | Method::StratifiedBootstrap);
        let is_joint = self.claim.over.as_ref().is_some_and(Over::is_joint);
        let is_share = self.metric.scale == Scale::Success && self.claim.baseline.is_none();
        if !is_mean || !is_share || is_joint || self.runs.iter().any(|runs| *runs < 2) {
            return None;
        }
        let episodes = Some(self.episodes?);
        let outcomes: &[&[f64]] = match self.runs.len() {
            1 => &[&[1.0], &[0.0]],
            _ => &[&[1.0, 0.0], &[0.0, 1.0], &[1.0, 1.0], &[0.0, 0.0]],
        };
        let p = |shares: &&[f64]| {
            let sides =
                shares.iter().zip(&self.runs).map(|(share, runs)| vec![vec![*share; *runs]]).collect();
            let sample = Sample::Runs { sides, episodes };
            let value = self.test().measure(&sample).value?;
            self.is_where_wanted(Interval { low: value, high: value }).then(|| self.p(&sample))?
        };
        outcomes.iter().filter_map(p).min_by(f64::total_cmp)
    }

    /// Whether the test counts successes, so that its interval depends only on their number.
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

    fn range(&self) -> Range {
        range::of_the_estimate(self.claim, self.statistic, self.metric, self.points)
    }

    /// The extreme possible values of the estimate.
    fn ends(&self) -> Vec<f64> {
        let Range { low, high } = self.range();
        vec![low, high, self.region().boundary().clamp(low, high)]
    }

    /// The clearest outcomes with this many episodes.
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
        // For a range: the smallest count whose interval begins inside it.
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

    /// The p value of the wanted result.
    fn p(&self, sample: &Sample) -> Option<f64> {
        let (test, region) = (self.test(), self.region());
        let value = test.measure(sample).value?;
        let p = |boundary: f64| test.p(sample, boundary);
        if self.negated { region.p_against(value, p) } else { region.p_for(value, p) }
    }

    /// Whether this many episodes could settle it.
    fn settled_by(&self, episodes: usize) -> bool {
        self.outcomes(episodes).iter().any(|sample| {
            self.interval(sample).is_some_and(|interval| self.is_where_wanted(interval))
                && self.p(sample).is_some_and(|p| p <= self.level)
        })
    }

    /// The minimum number of episodes that could settle it, searched upwards from here.
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

    /// The interval of the clearest outcome with this many episodes.
    fn at_best(&self, episodes: usize) -> String {
        let percent = |share: f64| short(100.0 * share);
        let outcomes = self.outcomes(episodes);
        let found = outcomes.iter().filter_map(|sample| Some((sample, self.interval(sample)?)));
        let (centre, relation) = (self.region().boundary(), self.claim.expect.relation);
        let wants_more = matches!(relation, Relation::Greater | Relation::AtLeast) != self.negated;
        // How far the interval extends across the boundary.
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

    /// The end of the range from which a number in `expect` must differ, so that values beyond it and its
    /// `margin` exist: `below 100 %`. `None` for claims without a number, and where no number is far enough.
    fn room(&self) -> Option<String> {
        let Operand::Number(_) = self.claim.expect.right else { return None };
        let (range, region) = (self.range(), self.region());
        let (word, end) = match (self.claim.expect.relation, self.negated) {
            (Relation::Equal, _) => return None,
            (Relation::Greater | Relation::AtLeast, false) | (Relation::Less | Relation::AtMost, true) => {
                ("below", range.high)
            }
            _ => ("above", range.low),
        };
        // The boundary lies beyond the number by the margin, or before it.
        let number = end + region.centre() - region.boundary();
        let is_possible = range.low < number && number < range.high;
        (number == end || is_possible).then(|| format!("{word} {}", in_unit(number, self.claim, self.metric)))
    }

    /// The `margin` below which results on the other side of the boundary exist: `below 10 %`. `None` without
    /// a margin, and where none is small enough.
    fn room_for_the_margin(&self) -> Option<String> {
        self.claim.margin.as_ref()?;
        if self.statistic.method == Method::ProbabilityOfImprovement {
            return None;
        }
        let (range, centre) = (self.range(), self.region().centre());
        let most = match self.claim.expect.relation {
            Relation::AtLeast if self.negated => centre - range.low,
            Relation::AtMost if self.negated => range.high - centre,
            _ => return None,
        };
        (most > 0.0).then(|| format!("below {}", in_unit(most, self.claim, self.metric)))
    }

    /// W1001: no data can contradict the claim.
    fn refutation(&self) -> Diagnostic {
        let id = &self.claim.id;
        let message = format!("no result can refute `{id}`: it can pass, but not fail");
        let warning = at(
            self.claim,
            keys::Claim::expect.name,
            Diagnostic::warning("W1001", message),
            "nothing contradicts it",
        );
        let enough = self.episodes.filter(|_| self.counts()).and_then(|episodes| self.enough(episodes));
        let purpose = "for the smallest effect that the claim is about";
        warning.help(match (enough, self.room(), self.room_for_the_margin()) {
            (Some(enough), _, _) => {
                let stage = &self.claim.metric.stage;
                format!("give `{stage}` {enough} episodes or more, or expect more")
            }
            (None, Some(room), None) => format!("expect more: write a number {room}, {purpose}"),
            (None, Some(room), Some(margin)) => {
                format!("expect more: write a number {room}, or a `margin` {margin}, {purpose}")
            }
            (None, None, Some(margin)) => format!("expect more: write a `margin` {margin}, {purpose}"),
            (None, None, None) => "expect more: state the smallest effect that the claim is about".to_owned(),
        })
    }

    fn warning(&self) -> Diagnostic {
        let (id, stage) = (&self.claim.id, &self.claim.metric.stage);
        let warned = |message: String, remark: &str| {
            at(self.claim, keys::Claim::expect.name, Diagnostic::warning("W0511", message), remark)
        };
        if let Some(episodes) = self.too_few_to_resample() {
            let message = format!("no result of {episodes} episodes can establish or refute `{id}`");
            let remark = format!("`{}` resamples {FEWEST} or more", self.statistic.kind.name);
            return warned(message, &remark).help(format!("give `{stage}` {FEWEST} episodes or more"));
        }
        match self.episodes.filter(|_| self.counts()) {
            Some(episodes) => {
                let message = format!("no result of {episodes} episodes can establish `{id}`");
                let warning = warned(message, &self.at_best(episodes));
                match self.enough(episodes) {
                    Some(enough) => warning.help(format!(
                        "give `{stage}` {enough} episodes or more, or weaken what is expected"
                    )),
                    None => warning.help("weaken what is expected: no number of episodes can show it"),
                }
            }
            None => {
                let remark = match self.statistic.method {
                    Method::ProbabilityOfImprovement => "the probability lies between 0 and 1".to_owned(),
                    _ => format!("values are {}", self.range().in_words(self.claim, self.metric)),
                };
                let warning = warned(format!("no result can establish `{id}`"), &remark);
                let relation = self.claim.expect.relation;
                let may_touch = matches!(relation, Relation::AtLeast | Relation::AtMost);
                let margin = if may_touch { ", or add a `margin`" } else { "" };
                match self.room().filter(|_| self.claim.margin.is_none()) {
                    Some(room) => {
                        warning.help(format!("weaken what is expected: write a number {room}{margin}"))
                    }
                    None => warning.help("weaken what is expected: a smaller distance or `margin`"),
                }
            }
        }
    }

    /// W0511: identical runs leave the claim open, however clear they are.
    fn of_alike_runs(&self) -> Diagnostic {
        let (id, stage) = (&self.claim.id, &self.claim.metric.stage);
        let message = format!("runs that are all alike cannot establish `{id}`");
        let p = self.p_of_alike_runs().unwrap_or(1.0);
        let fewest = self.runs.iter().copied().min().unwrap_or(0);
        let remark = match self.episodes {
            Some(episodes) => format!("p is {} at best of {fewest} runs of {episodes} episodes", short(p)),
            None => format!("p is {} at best of {fewest} runs", short(p)),
        };
        let warning =
            at(self.claim, keys::Claim::expect.name, Diagnostic::warning("W0511", message), &remark);
        let with = |episodes: usize, runs: usize| {
            let runs = vec![runs; self.runs.len()];
            Best { episodes: Some(episodes), runs, ..self.clone() }.settles_alike()
        };
        let episodes = self.episodes.unwrap_or(1).max(1);
        let seeds = (fewest..=MOST_SEEDS).find(|runs| with(episodes, *runs));
        let longer = (0..=MOST.ilog2())
            .map(|power| episodes << power)
            .take_while(|episodes| *episodes <= MOST)
            .find(|episodes| with(*episodes, fewest))
            .and_then(|most| (most / 2..=most).find(|episodes| with(*episodes, fewest)));
        let mut ways: Vec<String> = Vec::new();
        ways.extend(seeds.map(|seeds| format!("write `seeds = {seeds}` or more in `[sweep]`")));
        ways.extend(longer.map(|episodes| format!("give `{stage}` {episodes} episodes or more")));
        ways.push("weaken what is expected".to_owned());
        warning.help(ways.join(", or "))
    }
}
