//! Judges claims by the measurements: PASS, FAIL or NOT ESTABLISHED, with the numbers behind each verdict.
//!
//! A claim passes when its test establishes the expectation and fails when the test establishes the opposite;
//! otherwise it is not established. A claim with missing runs names them and is not established. Independent
//! of the simulators and the store.

mod again;
mod evidence;
mod judge;
mod meaning;
mod planned;
mod power;
mod quantifier;
mod sample;
mod table;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use serde_json::json;

pub use again::{again, metric_path};
pub use evidence::Evidence;
pub use judge::{expectation, is_of, judge, measured};
pub use planned::{Planned, PlannedArm, planned};
pub use power::settled_by;
pub use sample::{Asked, name, value_of};
pub use table::{correction, count, in_brief, meaningless, sentences, table};

use super::estimate::Estimate;
use super::model::Arm;
use super::source::Source;
use crate::spec::claim::{Paper, Points, Summary};

/// The verdict on a claim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ruling {
    /// The expectation is established.
    #[serde(rename = "PASS")]
    Pass,
    /// The opposite is established.
    #[serde(rename = "FAIL")]
    Fail,
    /// Neither is established.
    #[default]
    #[serde(rename = "NOT ESTABLISHED")]
    NotEstablished,
    /// It compares a speed, reward, force or torque of robots that fail their task.
    #[serde(rename = "NOT MEANINGFUL")]
    NotMeaningful,
}

impl Ruling {
    /// The verdict as printed in a report.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "PASS",
            Self::Fail => "FAIL",
            Self::NotEstablished => "NOT ESTABLISHED",
            Self::NotMeaningful => "NOT MEANINGFUL",
        }
    }
}

/// An arm of a suite with its runs.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Its points, by axis.
    pub points: &'a Points,
    /// Its runs by seed, including runs without results.
    pub runs: &'a [(u64, &'a Arm)],
}

/// A claim and its verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Its name.
    pub id: String,
    /// What is claimed.
    pub text: String,
    /// The metric with its stage.
    pub metric: String,
    /// The expectation, with the arms' points in place of their letters.
    pub expect: String,
    /// The test.
    pub test: String,
    /// The unit of observation: `run` or `episode`.
    pub unit: String,
    /// Two-sided level.
    pub alpha: f64,
    /// The ends of the range in which the estimates are expected; absent for an open end.
    #[serde(default)]
    pub bounds: [Option<f64>; 2],
    /// The factor on the second side before it is subtracted.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub factor: f64,
    /// The quantifier over several comparisons: `each`, `mean`, `some`, `none`, `at least 3`, `at most 3`;
    /// empty for a single one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub over: String,
    /// The statistic that summarises an arm's runs.
    #[serde(default, skip_serializing_if = "Summary::is_mean")]
    pub summary: Summary,
    /// The verdict.
    pub verdict: Ruling,
    /// The p value before correction; absent when nothing could be tested.
    #[serde(default)]
    pub p: Option<f64>,
    /// The p value after Holm's correction over all claims of the suite.
    pub p_adjusted: Option<f64>,
    /// The runs that fail their task, which makes the claim meaningless.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failing: Vec<String>,
    /// What would settle the claim; absent when it is settled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settled_by: Option<String>,
    /// Its comparisons; one, unless the claim quantifies over several arms.
    pub cases: Vec<Case>,
    /// The axis that the claim quantifies over; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub axis: String,
    /// The points of that axis, each with its verdict over all comparisons there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Alternative>,
    /// Sentences that say what is missing.
    pub missing: Vec<String>,
    /// What the paper reports.
    pub paper: Option<Paper>,
}

fn one() -> f64 {
    1.0
}

fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

impl Judged {
    /// How many alternatives have this verdict.
    pub fn alternatives_that(&self, verdict: Ruling) -> usize {
        self.alternatives.iter().filter(|alternative| alternative.verdict == verdict).count()
    }

    /// The verdict of a comparison: its own if there are several, else the claim's, which is corrected for
    /// the number of claims.
    pub fn ruling_of(&self, case: &Case) -> Ruling {
        let is_meaningless = self.verdict == Ruling::NotMeaningful;
        if is_meaningless || self.cases.len() == 1 && self.alternatives.is_empty() {
            self.verdict
        } else {
            case.verdict
        }
    }

    /// The verdict of a comparison in words. For a claim over an axis they say whether the expectation holds
    /// there, as the claim as a whole may be decided differently.
    pub fn word_of(&self, case: &Case) -> &'static str {
        match self.ruling_of(case) {
            ruling if self.alternatives.is_empty() => ruling.word(),
            Ruling::Pass => "holds",
            Ruling::Fail => "does not hold",
            Ruling::NotEstablished | Ruling::NotMeaningful => "open",
        }
    }

    /// A summary for the event of a finished run: numbers at the top level for a single comparison, else by
    /// case.
    pub fn brief(&self) -> serde_json::Value {
        let numbers = |case: &Case| {
            let interval = case.estimate.interval().map(|ends| [ends.low, ends.high]);
            json!({ "verdict": case.verdict, "n": case.n, "estimate": case.estimate.value,
                    "interval": interval })
        };
        let mut brief = match self.cases.as_slice() {
            [case] => numbers(case),
            _ => json!({ "n": null, "estimate": null, "interval": null }),
        };
        brief["id"] = json!(self.id);
        brief["verdict"] = json!(self.verdict);
        brief["test"] = json!(self.test);
        brief["alpha"] = json!(self.alpha);
        brief["p"] = json!(self.p);
        brief["p_adjusted"] = json!(self.p_adjusted);
        if !self.failing.is_empty() {
            brief["failing"] = json!(self.failing);
        }
        if self.cases.len() > 1 {
            let cases = self.cases.iter().map(|case| {
                let mut numbers = numbers(case);
                numbers["case"] = json!(case.label);
                numbers
            });
            brief["cases"] = cases.collect();
        }
        if !self.alternatives.is_empty() {
            brief["alternatives"] = json!(self.alternatives);
        }
        brief
    }
}

/// A point of the axis that a claim quantifies over.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alternative {
    /// The point.
    pub point: String,
    /// PASS when the expectation is established in every comparison at this point, FAIL when it is refuted in
    /// at least one.
    pub verdict: Ruling,
}

/// One comparison of a claim.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Distinguishes it from the others: `robot=atlas`; empty for a single comparison.
    pub label: String,
    /// The alternative it belongs to, for a claim over an axis or a number of comparisons.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub alternative: String,
    /// The values it was judged by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// Number of observations on each side, the left one first.
    pub n: Vec<usize>,
    /// Number of observations in the smallest stratum.
    pub fewest: usize,
    /// The value of each side.
    pub sides: Vec<Option<f64>>,
    /// The estimate that is compared with the boundary, with its interval.
    pub estimate: Estimate,
    /// The smaller of the two-sided p values for and against the expectation.
    pub p: Option<f64>,
    /// The verdict before Holm's correction.
    pub verdict: Ruling,
    /// Why the interval is missing, or a caveat; may be empty.
    pub remark: String,
    /// The stages of the runs that it was computed from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<Source>,
}
