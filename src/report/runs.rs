//! The value of every metric in every run of a suite: verdicts can be recomputed from them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::claim::{Asked, value_of};
use super::model::{Arm, ReportInput};
use crate::kinds::metric::{self, Scale, Source};
use crate::plan::Training;

/// A run with the values of its metrics.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Its name, as in the sources of a claim.
    pub run: String,
    /// Its arm: `control=torque,std=10 %`.
    pub arm: String,
    /// Its learning seed.
    pub seed: u64,
    /// Its stages with measurements.
    pub stages: BTreeMap<String, Measurements>,
}

/// What a stage of a run measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measurements {
    /// Number of episodes; absent for a training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episodes: Option<usize>,
    /// The mean over the episodes by metric, in SI units; shares are between 0 and 1.
    pub values: BTreeMap<String, f64>,
}

/// The records of a suite's runs; empty for a report on single specs.
pub fn records(input: &ReportInput) -> Vec<RunRecord> {
    input.arms.iter().filter_map(record).collect()
}

fn record(run: &Arm) -> Option<RunRecord> {
    let known = run.run.as_ref()?;
    let mut stages = BTreeMap::new();
    for measured in &run.evaluations {
        let episodes = Some(measured.evaluation.episodes.len());
        insert(&mut stages, &measured.stage, episodes, values(run, &measured.stage, false));
    }
    for training in [Training::First, Training::FineTuning] {
        insert(&mut stages, training.section(), None, values(run, training.section(), true));
    }
    Some(RunRecord { run: run.name.clone(), arm: known.arm.clone(), seed: known.seed, stages })
}

fn insert(
    stages: &mut BTreeMap<String, Measurements>,
    stage: &str,
    episodes: Option<usize>,
    values: BTreeMap<String, f64>,
) {
    if !values.is_empty() {
        stages.insert(stage.to_owned(), Measurements { episodes, values });
    }
}

/// The values of a stage.
fn values(run: &Arm, stage: &str, of_training: bool) -> BTreeMap<String, f64> {
    let kinds = metric::KINDS.iter().filter(|metric| {
        // Metrics with a threshold or parameter only have values in claims.
        metric.scale != Scale::Censored && matches!(metric.source, Source::Learning(_)) == of_training
    });
    let value = |metric: &&metric::MetricKind| {
        let value = value_of(run, stage, metric, Asked::default()).filter(|value| value.is_finite())?;
        Some((metric.kind.name.to_owned(), value))
    };
    kinds.copied().filter_map(|metric| value(&metric)).collect()
}
