//! Extracts samples from runs: one value per run or per episode, and what is missing.

use super::Observed;
use crate::escape::markdown::code;
use crate::kinds::metric::{self, Curve, Failures, MetricKind};
use crate::kinds::statistic::Unit;
use crate::outcome::{Episode, Evaluation};
use crate::plan::Training;
use crate::report::comparison::are_paired;
use crate::report::failures;
use crate::report::model::Arm;
use crate::report::source::Source;
use crate::report::untrained;
use crate::report::verdict;
use crate::spec::claim::cases::{alternative, twin};
use crate::spec::claim::{Case, Claim, Over, Points, cases};
use crate::statistics::resample::Strata;
use crate::statistics::summary::mean;
use crate::statistics::test::Sample;

/// The sample of a case.
#[derive(Clone, Debug)]
pub struct Found {
    /// The label of the case.
    pub label: String,
    /// Its point on the axis that the claim quantifies over; may be empty.
    pub alternative: String,
    /// Its values.
    pub sample: Sample,
    /// The stages that the values come from.
    pub sources: Vec<Source>,
}

/// The samples of a claim, and what is missing.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// The samples by case.
    pub cases: Vec<Found>,
    /// Sentences that say what is missing.
    pub missing: Vec<String>,
}

/// Collects the samples that a claim compares.
pub fn samples(claim: &Claim, metric: &MetricKind, unit: Unit, arms: &[Observed]) -> Samples {
    let points: Vec<&Points> = arms.iter().map(|arm| arm.points).collect();
    let cases = cases(claim, &points);
    let sides = |case: &Case| -> Vec<usize> {
        let left = if claim.expect.left == "b" { case.b } else { Some(case.a) };
        let right = if claim.expect.left == "b" { Some(case.a) } else { case.b };
        [left, right.filter(|_| claim.sides.len() == 2)].into_iter().flatten().collect()
    };
    let mut collector = Collector { claim, metric, arms, found: Samples::default() };
    for case in &cases {
        collector.lack_a_difference(case);
        collector.lack_a_training(case);
    }
    let place = |case: &Case| {
        let point = alternative(claim, &points, case).unwrap_or_default();
        Place { label: case.label.clone(), alternative: point }
    };
    match (unit, &claim.over) {
        (Unit::Episode, Some(Over::Trend(_))) => {
            let points: Vec<usize> = cases.iter().map(|case| case.a).collect();
            collector.episodes(Place::default(), &pick(arms, &points));
        }
        (Unit::Episode, _) => {
            cases.iter().for_each(|case| collector.episodes(place(case), &pick(arms, &sides(case))))
        }
        (Unit::Seed, Some(over)) if over.is_joint() => {
            let mut all: Vec<Strata> = vec![Vec::new(); claim.sides.len()];
            let (mut sources, mut episodes) = (Vec::new(), Vec::new());
            for case in &cases {
                let arms = pick(arms, &sides(case));
                episodes.push(collector.fewest_episodes(&arms));
                sources.extend(collector.sources(&arms));
                let strata = arms.into_iter().map(|arm| collector.runs(arm)).collect::<Vec<_>>();
                all.iter_mut().zip(strata).for_each(|(side, stratum)| side.push(stratum));
            }
            let Place { label, alternative } = Place::default();
            // The episodes at the points of a trend are pooled when their runs have no spread.
            let episodes = episodes.into_iter().min().flatten().filter(|_| matches!(over, Over::Trend(_)));
            let sample = Sample::Runs { sides: all, episodes };
            collector.found.cases.push(Found { label, alternative, sample, sources });
        }
        (Unit::Seed, _) => {
            for case in &cases {
                let arms = pick(arms, &sides(case));
                let sources = collector.sources(&arms);
                let episodes = collector.fewest_episodes(&arms);
                let sides = arms.into_iter().map(|arm| vec![collector.runs(arm)]).collect();
                let Place { label, alternative } = place(case);
                let sample = Sample::Runs { sides, episodes };
                collector.found.cases.push(Found { label, alternative, sample, sources });
            }
        }
    }
    collector.found.missing.sort();
    collector.found.missing.dedup();
    collector.found
}

fn pick<'a, 'o>(arms: &'o [Observed<'a>], places: &[usize]) -> Vec<&'o Observed<'a>> {
    places.iter().map(|place| &arms[*place]).collect()
}

/// What is compared: the case's label, and its point on the axis that the claim quantifies over.
#[derive(Default)]
struct Place {
    label: String,
    alternative: String,
}

/// A run of an arm.
#[derive(Clone, Copy)]
struct Run<'a, 'o> {
    arm: &'o Observed<'a>,
    seed: u64,
    own: &'a Arm,
}

impl<'a, 'o> Run<'a, 'o> {
    /// All runs of an arm.
    fn all(arm: &'o Observed<'a>) -> impl Iterator<Item = Self> {
        arm.runs.iter().map(move |(seed, own)| Self { arm, seed: *seed, own })
    }

    /// The run of an arm with this seed.
    fn of(arm: &'o Observed<'a>, seed: u64) -> Option<Self> {
        Some(Self { arm, seed, own: run(arm, seed)? })
    }
}

/// The episodes of a run: their values, and what was measured.
struct Episodes {
    values: Vec<f64>,
    evaluation: Evaluation,
}

/// The run of an arm with this seed.
fn run<'a>(arm: &Observed<'a>, seed: u64) -> Option<&'a Arm> {
    arm.runs.iter().find(|(own, _)| *own == seed).map(|(_, run)| *run)
}

struct Collector<'a> {
    claim: &'a Claim,
    metric: &'a MetricKind,
    arms: &'a [Observed<'a>],
    found: Samples,
}

impl Collector<'_> {
    /// The stages of the runs of these arms that have a value.
    fn sources(&self, arms: &[&Observed]) -> Vec<Source> {
        let measured = arms.iter().flat_map(|arm| Run::all(arm)).filter(|run| self.value(*run).is_some());
        measured.map(|run| self.source(run.own)).collect()
    }

    fn source(&self, run: &Arm) -> Source {
        let stage = match self.metric.source {
            metric::Source::Learning(_) => training(&self.claim.metric.stage).stage(),
            _ => &self.claim.metric.stage,
        };
        Source { arm: run.name.clone(), stage: stage.to_owned() }
    }

    /// The values of the runs that have one.
    fn runs(&mut self, arm: &Observed) -> Vec<f64> {
        let mut values = Vec::new();
        for run in Run::all(arm) {
            match self.value(run) {
                Some(value) => values.push(value),
                None => self.lack(arm, run.seed),
            }
        }
        values
    }

    /// The value of a run: its metric, relative to the baseline if the claim has one; `None` if not measured
    /// or not judged.
    fn value(&self, run: Run) -> Option<f64> {
        let compared = self.compared(run)?;
        if self.unjudged(run.own, compared).is_some() {
            return None;
        }
        run_value(run.own, compared, self.claim, self.metric)
    }

    /// Which evaluation of a run or of its baseline is too short for its survivors to be judged, and why: they
    /// may be falling, and every metric of longer episodes may differ.
    fn unjudged(&self, run: &Arm, compared: &Arm) -> Option<String> {
        let told = |run: &Arm, stage: &str| {
            let evaluation = evaluation_of(run, stage)?;
            let reason = verdict::too_short_for_survivors(run, evaluation)?;
            Some(format!("is not judged in `{stage}` ({reason})"))
        };
        let base = || told(compared, &self.claim.baseline.as_ref()?.stage);
        told(run, &self.claim.metric.stage).or_else(base)
    }

    /// The baseline of a run: the run itself, or the run with the same seed in the twin arm; `None` if
    /// missing.
    fn compared<'r>(&'r self, Run { arm, seed, own }: Run<'r, '_>) -> Option<&'r Arm> {
        let Some(pattern) = self.claim.baseline.as_ref().and_then(|baseline| baseline.twin.as_ref()) else {
            return Some(own);
        };
        let points: Vec<&Points> = self.arms.iter().map(|arm| arm.points).collect();
        let at = points.iter().position(|points| *points == arm.points)?;
        run(&self.arms[twin(pattern, &points, at)?], seed)
    }

    /// The fewest episodes behind a run's value, where that is a share of episodes.
    fn fewest_episodes(&self, arms: &[&Observed]) -> Option<usize> {
        if self.metric.scale != metric::Scale::Success || self.claim.baseline.is_some() {
            return None;
        }
        let runs = arms.iter().flat_map(|arm| arm.runs);
        runs.filter_map(|(_, run)| Some(self.evaluation(run)?.episodes.len())).min()
    }

    fn evaluation<'r>(&self, run: &'r Arm) -> Option<&'r Evaluation> {
        let evaluation = evaluation_of(run, &self.claim.metric.stage)?;
        Some(evaluation).filter(|evaluation| values(run, evaluation, self.metric).is_some())
    }

    /// The value of each episode of a run, relative to the baseline if the claim has one; `None` if not
    /// measured or not judged, or if the episodes are not the same.
    fn of_episodes(&self, run: Run) -> Option<Episodes> {
        let (own, other) = (run.own, self.compared(run)?);
        let evaluation = self.evaluation(own)?;
        if self.unjudged(own, other).is_some() {
            return None;
        }
        let found = values(own, evaluation, self.metric)?;
        let Some(baseline) = &self.claim.baseline else {
            return Some(Episodes { values: found, evaluation: evaluation.clone() });
        };
        let base = evaluation_of(other, &baseline.stage)?;
        let bases = values(other, base, self.metric).filter(|_| are_paired(evaluation, base))?;
        let less = |(own, base): (&f64, &f64)| if baseline.relative { own / base } else { own - base };
        let values: Vec<f64> = found.iter().zip(&bases).map(less).collect();
        let is_finite = values.iter().all(|value| value.is_finite());
        is_finite.then(|| Episodes { values, evaluation: evaluation.clone() })
    }

    /// Collects the episodes of every seed that all sides have. Each of several seeds is a case of its own.
    fn episodes(&mut self, place: Place, arms: &[&Observed]) {
        let mut seeds: Vec<u64> =
            arms.iter().flat_map(|arm| arm.runs.iter().map(|(seed, _)| *seed)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        // An arm may have fewer seeds than another.
        seeds.retain(|seed| arms.iter().all(|arm| run(arm, *seed).is_some()));
        for seed in &seeds {
            let find = |arm: &&Observed| self.of_episodes(Run::of(arm, *seed)?);
            let found: Vec<Option<Episodes>> = arms.iter().map(find).collect();
            for (arm, _) in arms.iter().zip(&found).filter(|(_, evaluation)| evaluation.is_none()) {
                self.lack(arm, *seed);
            }
            let Some(evaluations) = found.into_iter().collect::<Option<Vec<_>>>() else { continue };
            let sources = arms.iter().filter_map(|arm| Some(self.source(run(arm, *seed)?))).collect();
            let seed = (seeds.len() > 1).then(|| format!("seed={seed}"));
            let words = [Some(place.label.clone()).filter(|label| !label.is_empty()), seed];
            let label = words.into_iter().flatten().collect::<Vec<_>>().join(",");
            let (alternative, sample) = (place.alternative.clone(), sample(evaluations));
            self.found.cases.push(Found { label, alternative, sample, sources });
        }
    }

    /// Records when neither side of a case was ever updated and both did the same in every episode: the
    /// policies are those that the trainings began with.
    fn lack_a_training(&mut self, case: &Case) {
        let Some(other) = case.b else { return };
        let [one, other] = [&self.arms[case.a], &self.arms[other]];
        let stage = &self.claim.metric.stage;
        let alike = |own: &Arm, twin: &Arm| {
            let episodes = |run| evaluation_of(run, stage).map(|evaluation| &evaluation.episodes);
            let is_untrained = untrained::is_untrained(own) && untrained::is_untrained(twin);
            is_untrained && episodes(own).is_some() && episodes(own) == episodes(twin)
        };
        let mut pairs = one.runs.iter().filter_map(|(seed, own)| Some((*own, run(other, *seed)?))).peekable();
        if pairs.peek().is_some() && pairs.all(|(own, twin)| alike(own, twin)) {
            self.found.missing.push(format!(
                "the policies of {} and {} are the same, because they were never updated (`W0508`)",
                code(&name(one.points)),
                code(&name(other.points))
            ));
        }
    }

    /// Records when both sides of a case use the same result, so that they cannot differ. `check` refuses
    /// such claims, but a profile may remove what distinguishes the arms.
    fn lack_a_difference(&mut self, case: &Case) {
        let Some(other) = case.b else { return };
        let [one, other] = [&self.arms[case.a], &self.arms[other]];
        let keys = |run: Run| -> Option<[String; 2]> {
            let key = |run: &Arm, stage: &str| {
                let name = match self.metric.source {
                    metric::Source::Learning(_) => training(stage).stage(),
                    _ => stage,
                };
                let found = run.stages.iter().find(|record| record.stage == name)?;
                Some(found.fingerprint.clone()).filter(|key| !key.is_empty())
            };
            let base = match &self.claim.baseline {
                Some(baseline) => key(self.compared(run)?, &baseline.stage)?,
                None => String::new(),
            };
            Some([key(run.own, &self.claim.metric.stage)?, base])
        };
        let pairs = Run::all(one).filter_map(|run| Some((keys(run)?, keys(Run::of(other, run.seed)?)?)));
        let mut pairs = pairs.peekable();
        if pairs.peek().is_some() && pairs.all(|(own, other)| own == other) {
            let stage = &self.claim.metric.stage;
            let sentence = format!(
                "{} and {} have the same `{stage}`",
                code(&name(one.points)),
                code(&name(other.points))
            );
            self.found.missing.push(sentence);
        }
    }

    fn lack(&mut self, arm: &Observed, seed: u64) {
        let unjudged = || {
            let own = run(arm, seed)?;
            self.unjudged(own, self.compared(Run { arm, seed, own })?)
        };
        let reason = unjudged().unwrap_or_else(|| format!("has no result of `{}`", self.claim.metric.stage));
        self.found.missing.push(format!("{} with seed {seed} {reason}", code(&name(arm.points))));
    }
}

/// `control=torque,std=1 %`.
pub fn name(points: &Points) -> String {
    points.iter().map(|(axis, point)| format!("{axis}={point}")).collect::<Vec<_>>().join(",")
}

/// The parameters of a claim's metric.
#[derive(Clone, Copy, Debug, Default)]
pub struct Asked<'a> {
    /// The return to reach.
    pub threshold: Option<f64>,
    /// The number of training samples to consider; all if absent.
    pub until: Option<f64>,
    /// The parameter whose effect on failures is measured.
    pub parameter: Option<&'a str>,
}

/// The value of a run for a claim, given its baseline run; `None` if not measured.
pub fn run_value(run: &Arm, compared: &Arm, claim: &Claim, metric: &MetricKind) -> Option<f64> {
    let asked =
        Asked { threshold: claim.threshold, until: claim.until, parameter: claim.parameter.as_deref() };
    let own = value_of(run, &claim.metric.stage, metric, asked)?;
    let Some(baseline) = &claim.baseline else { return Some(own) };
    let base = value_of(compared, &baseline.stage, metric, asked)?;
    let value = if baseline.relative { own / base } else { own - base };
    value.is_finite().then_some(value)
}

/// A metric of a run: its mean over the episodes of a stage, its value over all of them, or its value for the
/// training; `None` if not measured.
pub fn value_of(run: &Arm, stage: &str, metric: &MetricKind, asked: Asked) -> Option<f64> {
    match metric.source {
        metric::Source::Whole(of) => of(&evaluation_of(run, stage)?.episodes),
        metric::Source::Failures(of) => {
            let direction = failures::direction(run, stage)?;
            of(&Failures { direction: &direction, parameter: asked.parameter? })
        }
        metric::Source::Learning(of) => {
            let reached = run.updates_of(training(stage)).iter();
            let points: Vec<(f64, f64)> =
                reached.filter_map(|update| Some((update.samples as f64, update.return_mean?))).collect();
            let counts = |samples: f64| asked.until.is_none_or(|until| samples <= until);
            let points: Vec<(f64, f64)> =
                points.into_iter().filter(|(samples, _)| counts(*samples)).collect();
            let control_step = run.control_rate().map(|rate| 1.0 / rate);
            of(&Curve { points: &points, threshold: asked.threshold, control_step })
        }
        _ => mean(&values(run, evaluation_of(run, stage)?, metric)?),
    }
}

/// The training that a learning metric refers to.
fn training(stage: &str) -> Training {
    match stage == Training::FineTuning.section() {
        true => Training::FineTuning,
        false => Training::First,
    }
}

fn evaluation_of<'r>(run: &'r Arm, stage: &str) -> Option<&'r Evaluation> {
    run.evaluations.iter().find(|measured| measured.stage == stage).map(|measured| &measured.evaluation)
}

/// The metric in every episode of an evaluation.
fn values(run: &Arm, evaluation: &Evaluation, metric: &MetricKind) -> Option<Vec<f64>> {
    match metric.source {
        // An episode counts if it is survived and the policy meets the other criteria of its task.
        metric::Source::Task => {
            let does = verdict::does_but_for_survival(run, evaluation)?;
            let of = |episode: &Episode| f64::from(u8::from(does && episode.survived));
            Some(evaluation.episodes.iter().map(of).collect()).filter(|values: &Vec<f64>| !values.is_empty())
        }
        _ => metric.values(&evaluation.episodes),
    }
}

/// The sample for the episodes of one seed.
fn sample(sides: Vec<Episodes>) -> Sample {
    let paired = match sides.as_slice() {
        [first, second] => are_paired(&first.evaluation, &second.evaluation),
        _ => false,
    };
    Sample::Episodes { sides: sides.into_iter().map(|side| side.values).collect(), paired }
}
