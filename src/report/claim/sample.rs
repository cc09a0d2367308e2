//! From runs to samples: the value of every run, or the values of every episode, and what is missing.

use super::Observed;
use crate::evaluate::outcome::Evaluation;
use crate::kinds::metric::{self, Curve, MetricKind};
use crate::kinds::statistic::Unit;
use crate::plan::Training;
use crate::report::comparison::are_paired;
use crate::report::model::Arm;
use crate::report::source::Source;
use crate::spec::claim::cases::alternative;
use crate::spec::claim::{Case, Claim, Over, Points, cases};
use crate::statistics::resample::Strata;
use crate::statistics::summary::mean;
use crate::statistics::test::Sample;

/// The sample of a case.
#[derive(Clone, Debug)]
pub struct Found {
    /// The label of the case.
    pub label: String,
    /// Its point on the axis that the claim is over; empty when it is over none.
    pub alternative: String,
    /// Its values.
    pub sample: Sample,
    /// The stages of the runs that they come from.
    pub sources: Vec<Source>,
}

/// The samples of a claim, and what is missing.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// The samples by case.
    pub cases: Vec<Found>,
    /// Sentences.
    pub missing: Vec<String>,
}

/// Collects what a claim is about.
pub fn samples(claim: &Claim, (metric, unit): (&MetricKind, Unit), arms: &[Observed]) -> Samples {
    let points: Vec<&Points> = arms.iter().map(|arm| arm.points).collect();
    let cases = cases(claim, &points);
    let sides = |case: &Case| -> Vec<usize> {
        let left = if claim.expect.left == "b" { case.b } else { Some(case.a) };
        let right = if claim.expect.left == "b" { Some(case.a) } else { case.b };
        [left, right.filter(|_| claim.sides.len() == 2)].into_iter().flatten().collect()
    };
    let mut collector = Collector { claim, metric, found: Samples::default() };
    let place = |case: &Case| {
        let point = alternative(claim, &points, case).unwrap_or_default();
        (case.label.clone(), point.to_owned())
    };
    match (unit, &claim.over) {
        (Unit::Episode, _) => cases.iter().for_each(|case| collector.episodes(place(case), &pick(arms, &sides(case)))),
        (Unit::Seed, Some(Over::Mean)) => {
            let mut all: Vec<Strata> = vec![Vec::new(); claim.sides.len()];
            let mut sources = Vec::new();
            for case in &cases {
                let arms = pick(arms, &sides(case));
                sources.extend(collector.sources(&arms));
                let strata = arms.into_iter().map(|arm| collector.runs(arm)).collect::<Vec<_>>();
                all.iter_mut().zip(strata).for_each(|(side, stratum)| side.push(stratum));
            }
            let (label, alternative) = Default::default();
            collector.found.cases.push(Found { label, alternative, sample: Sample::Runs(all), sources });
        }
        (Unit::Seed, _) => {
            for case in &cases {
                let arms = pick(arms, &sides(case));
                let sources = collector.sources(&arms);
                let sides = arms.into_iter().map(|arm| vec![collector.runs(arm)]).collect();
                let (label, alternative) = place(case);
                collector.found.cases.push(Found { label, alternative, sample: Sample::Runs(sides), sources });
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

/// The run of an arm with this seed.
fn run<'a>(arm: &Observed<'a>, seed: u64) -> Option<&'a Arm> {
    arm.runs.iter().find(|(own, _)| *own == seed).map(|(_, run)| *run)
}

struct Collector<'a> {
    claim: &'a Claim,
    metric: &'a MetricKind,
    found: Samples,
}

impl Collector<'_> {
    /// The stages of the runs of these arms that have a value.
    fn sources(&self, arms: &[&Observed]) -> Vec<Source> {
        let runs = arms.iter().flat_map(|arm| arm.runs).filter(|(_, run)| self.value(run).is_some());
        runs.map(|(_, run)| self.source(run)).collect()
    }

    /// The training that a metric of learning is about.
    fn training(&self) -> Training {
        match self.claim.metric.stage == Training::FineTuning.section() {
            true => Training::FineTuning,
            false => Training::First,
        }
    }

    fn source(&self, run: &Arm) -> Source {
        let stage = match self.metric.source {
            metric::Source::Learning(_) => self.training().stage(),
            _ => &self.claim.metric.stage,
        };
        Source { arm: run.name.clone(), stage: stage.to_owned() }
    }

    /// The values of the runs that have one.
    fn runs(&mut self, arm: &Observed) -> Vec<f64> {
        let mut values = Vec::new();
        for (seed, run) in arm.runs {
            match self.value(run) {
                Some(value) => values.push(value),
                None => self.lack(arm, *seed),
            }
        }
        values
    }

    /// The mean of the metric in a run; `None` when it was not measured.
    fn value(&self, run: &Arm) -> Option<f64> {
        match self.metric.source {
            metric::Source::Episodes(_) | metric::Source::SomeEpisodes(_) => {
                mean(&self.metric.values(&self.evaluation(run)?.episodes)?)
            }
            metric::Source::Learning(of) => {
                let reached = run.updates_of(self.training()).iter();
                let points: Vec<(f64, f64)> =
                    reached.filter_map(|update| Some((update.samples as f64, update.return_mean?))).collect();
                let control_step = run.control_rate().map(|rate| 1.0 / rate);
                of(&Curve { points: &points, threshold: self.claim.threshold, control_step })
            }
        }
    }

    fn evaluation<'r>(&self, run: &'r Arm) -> Option<&'r Evaluation> {
        let measured = run.evaluations.iter().find(|measured| measured.stage == self.claim.metric.stage)?;
        Some(&measured.evaluation).filter(|evaluation| self.metric.values(&evaluation.episodes).is_some())
    }

    /// The episodes of every seed that all sides have; several seeds are a case each.
    fn episodes(&mut self, (label, alternative): (String, String), arms: &[&Observed]) {
        let mut seeds: Vec<u64> = arms.iter().flat_map(|arm| arm.runs.iter().map(|(seed, _)| *seed)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        for seed in &seeds {
            let find = |arm: &&Observed| run(arm, *seed).and_then(|run| self.evaluation(run)).cloned();
            let found: Vec<Option<Evaluation>> = arms.iter().map(find).collect();
            for (arm, _) in arms.iter().zip(&found).filter(|(_, evaluation)| evaluation.is_none()) {
                self.lack(arm, *seed);
            }
            let Some(evaluations) = found.into_iter().collect::<Option<Vec<_>>>() else { continue };
            let sources = arms.iter().filter_map(|arm| Some(self.source(run(arm, *seed)?))).collect();
            let seed = (seeds.len() > 1).then(|| format!("seed={seed}"));
            let words = [Some(label.clone()).filter(|label| !label.is_empty()), seed];
            let label = words.into_iter().flatten().collect::<Vec<_>>().join(",");
            let (alternative, sample) = (alternative.clone(), self.sample(&evaluations));
            self.found.cases.push(Found { label, alternative, sample, sources });
        }
    }

    fn sample(&self, evaluations: &[Evaluation]) -> Sample {
        let values = |evaluation: &Evaluation| self.metric.values(&evaluation.episodes).unwrap_or_default();
        let paired = matches!(evaluations, [first, second] if are_paired(first, second));
        Sample::Episodes { sides: evaluations.iter().map(values).collect(), paired }
    }

    fn lack(&mut self, arm: &Observed, seed: u64) {
        let name: Vec<String> = arm.points.iter().map(|(axis, point)| format!("{axis}={point}")).collect();
        let stage = &self.claim.metric.stage;
        self.found.missing.push(format!("`{}` with seed {seed} has no result of `{stage}`", name.join(",")));
    }
}
