//! From runs to samples: the value of every run, or the values of every episode, and what is missing.

use super::Observed;
use crate::evaluate::outcome::Evaluation;
use crate::kinds::metric::{Curve, MetricKind, Source};
use crate::kinds::statistic::Unit;
use crate::report::comparison::are_paired;
use crate::report::model::Arm;
use crate::report::statistics::resample::Strata;
use crate::report::statistics::summary::mean;
use crate::spec::claim::{Case, Claim, Over, Points, cases};

/// What a comparison is computed from; the left side of the expectation comes first.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    /// The values of the runs, by side and stratum.
    Runs(Vec<Strata>),
    /// The values of the episodes of one policy a side, and whether the episodes are the same.
    Episodes {
        /// By side.
        sides: Vec<Vec<f64>>,
        /// Whether both sides ran the same episodes.
        paired: bool,
    },
}

/// The samples of a claim, by the label of their case, and what is missing.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// The samples.
    pub cases: Vec<(String, Sample)>,
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
    match (unit, claim.over) {
        (Unit::Episode, _) => cases.iter().for_each(|case| collector.episodes(&case.label, &pick(arms, &sides(case)))),
        (Unit::Seed, Some(Over::Mean)) => {
            let mut all: Vec<Strata> = vec![Vec::new(); claim.sides.len()];
            for case in &cases {
                let strata = pick(arms, &sides(case)).into_iter().map(|arm| collector.runs(arm)).collect::<Vec<_>>();
                all.iter_mut().zip(strata).for_each(|(side, stratum)| side.push(stratum));
            }
            collector.found.cases.push((String::new(), Sample::Runs(all)));
        }
        (Unit::Seed, _) => {
            for case in &cases {
                let sides = pick(arms, &sides(case)).into_iter().map(|arm| vec![collector.runs(arm)]).collect();
                collector.found.cases.push((case.label.clone(), Sample::Runs(sides)));
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

struct Collector<'a> {
    claim: &'a Claim,
    metric: &'a MetricKind,
    found: Samples,
}

impl Collector<'_> {
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
            Source::Episodes(of) => {
                let evaluation = self.evaluation(run)?;
                mean(&evaluation.episodes.iter().map(of).collect::<Vec<_>>())
            }
            Source::Learning(of) => {
                let reached = run.updates.iter();
                let points: Vec<(f64, f64)> =
                    reached.filter_map(|update| Some((update.samples as f64, update.return_mean?))).collect();
                of(&Curve { points: &points, threshold: self.claim.threshold })
            }
        }
    }

    fn evaluation<'r>(&self, run: &'r Arm) -> Option<&'r Evaluation> {
        let measured = run.evaluations.iter().find(|measured| measured.stage == self.claim.metric.stage)?;
        Some(&measured.evaluation).filter(|evaluation| !evaluation.episodes.is_empty())
    }

    /// The episodes of every seed that all sides have; several seeds are a case each.
    fn episodes(&mut self, label: &str, arms: &[&Observed]) {
        let mut seeds: Vec<u64> = arms.iter().flat_map(|arm| arm.runs.iter().map(|(seed, _)| *seed)).collect();
        seeds.sort_unstable();
        seeds.dedup();
        for seed in &seeds {
            let find = |arm: &&Observed| {
                let run = arm.runs.iter().find(|(own, _)| own == seed);
                run.and_then(|(_, run)| self.evaluation(run)).cloned()
            };
            let found: Vec<Option<Evaluation>> = arms.iter().map(find).collect();
            for (arm, _) in arms.iter().zip(&found).filter(|(_, evaluation)| evaluation.is_none()) {
                self.lack(arm, *seed);
            }
            let Some(evaluations) = found.into_iter().collect::<Option<Vec<_>>>() else { continue };
            let seed = (seeds.len() > 1).then(|| format!("seed={seed}"));
            let words = [Some(label.to_owned()).filter(|label| !label.is_empty()), seed];
            let label = words.into_iter().flatten().collect::<Vec<_>>().join(",");
            self.found.cases.push((label, self.sample(&evaluations)));
        }
    }

    fn sample(&self, evaluations: &[Evaluation]) -> Sample {
        let values = |evaluation: &Evaluation| match self.metric.source {
            Source::Episodes(of) => evaluation.episodes.iter().map(of).collect(),
            Source::Learning(_) => Vec::new(),
        };
        let paired = matches!(evaluations, [first, second] if are_paired(first, second));
        Sample::Episodes { sides: evaluations.iter().map(values).collect(), paired }
    }

    fn lack(&mut self, arm: &Observed, seed: u64) {
        let name: Vec<String> = arm.points.iter().map(|(axis, point)| format!("{axis}={point}")).collect();
        let stage = &self.claim.metric.stage;
        self.found.missing.push(format!("`{}` with seed {seed} has no result of `{stage}`", name.join(",")));
    }
}
