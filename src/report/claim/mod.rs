//! Claims against what was measured: PASS, FAIL or NOT ESTABLISHED, with the numbers behind it.
//!
//! A claim passes when its test establishes what it expects, fails when the opposite is established, and is
//! not established otherwise. Runs that are missing are said, and leave a claim not established. Knows no
//! simulator and no store.

mod again;
mod agreement;
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

pub use again::again;
pub use agreement::disagreements;
pub use evidence::Evidence;
pub use judge::{expectation, judge, measured};
pub use planned::{Planned, PlannedArm, planned};
pub use power::settled_by;
pub use sample::{Asked, name, value_of};
pub use table::{correction, count, in_brief, meaningless, sentences, table};

use super::estimate::Estimate;
use super::model::Arm;
use super::source::Source;
use crate::spec::claim::{Paper, Points, Summary};

/// What became of a claim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ruling {
    /// What it expects is established.
    #[serde(rename = "PASS")]
    Pass,
    /// The opposite is established.
    #[serde(rename = "FAIL")]
    Fail,
    /// Neither is.
    #[default]
    #[serde(rename = "NOT ESTABLISHED")]
    NotEstablished,
    /// It compares a speed, reward, force or torque of robots that fail their task.
    #[serde(rename = "NOT MEANINGFUL")]
    NotMeaningful,
}

impl Ruling {
    /// As a reader sees it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "PASS",
            Self::Fail => "FAIL",
            Self::NotEstablished => "NOT ESTABLISHED",
            Self::NotMeaningful => "NOT MEANINGFUL",
        }
    }
}

/// An arm of the suite with the runs that were made of it.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Its points, by axis.
    pub points: &'a Points,
    /// Its runs by seed; a run without results is among them.
    pub runs: &'a [(u64, &'a Arm)],
}

/// A claim and what became of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Its name.
    pub id: String,
    /// What is claimed.
    pub text: String,
    /// The metric with its stage.
    pub metric: String,
    /// What is expected, with the arms' points in place of their letters.
    pub expect: String,
    /// The test.
    pub test: String,
    /// What is counted as one observation: `run` or `episode`.
    pub unit: String,
    /// Two-sided level.
    pub alpha: f64,
    /// The ends of the range in which the estimates are expected, where it has them.
    #[serde(default)]
    pub bounds: [Option<f64>; 2],
    /// By what the second side is multiplied before it is subtracted.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub factor: f64,
    /// What is claimed of several comparisons: `each`, `mean`, `some`, `none`, `at least 3`, `at most 3`;
    /// empty for one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub over: String,
    /// What the runs of an arm are summarised by.
    #[serde(default, skip_serializing_if = "Summary::is_mean")]
    pub summary: Summary,
    /// What became of it.
    pub verdict: Ruling,
    /// The p value of the claim by itself; absent when nothing could be tested.
    #[serde(default)]
    pub p: Option<f64>,
    /// The p value after Holm's correction over all claims of the suite.
    pub p_adjusted: Option<f64>,
    /// The runs that fail their task, so that the claim means nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failing: Vec<String>,
    /// What would settle the claim; absent where it is settled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub settled_by: Option<String>,
    /// Its comparisons; one, unless the claim is about each of several arms.
    pub cases: Vec<Case>,
    /// The axis that the claim is over; empty when it is over none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub axis: String,
    /// The points of that axis, and whether all comparisons hold there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Alternative>,
    /// What is missing, as sentences.
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

    /// The verdict of a comparison: of one among several its own, of the only one the claim's, which is
    /// corrected for the number of claims.
    pub fn ruling_of(&self, case: &Case) -> Ruling {
        let is_meaningless = self.verdict == Ruling::NotMeaningful;
        if is_meaningless || self.cases.len() == 1 && self.alternatives.is_empty() {
            self.verdict
        } else {
            case.verdict
        }
    }

    /// What became of a comparison, in words: of a claim that is over an axis, whether the expectation holds
    /// there, which is not yet what the claim says.
    pub fn word_of(&self, case: &Case) -> &'static str {
        match self.ruling_of(case) {
            ruling if self.alternatives.is_empty() => ruling.word(),
            Ruling::Pass => "holds",
            Ruling::Fail => "does not hold",
            Ruling::NotEstablished | Ruling::NotMeaningful => "open",
        }
    }

    /// What the event of a finished run says of it: numbers at the top when there is one comparison, else by
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

/// A point of the axis that a claim is over.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alternative {
    /// The point.
    pub point: String,
    /// PASS when the expectation is established in every comparison at this point, FAIL when it is refuted in
    /// one.
    pub verdict: Ruling,
}

/// One comparison of a claim.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// What tells it from the others: `robot=atlas`; empty when it is the only one.
    pub label: String,
    /// The alternative that it belongs to, for a claim over an axis or a number of comparisons.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub alternative: String,
    /// The values that it was judged by; absent in the records of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// Observations of each side, the left one first.
    pub n: Vec<usize>,
    /// Those of the smallest sample that is taken by itself; 0 in the records of earlier versions.
    #[serde(default)]
    pub fewest: usize,
    /// The value of each side.
    pub sides: Vec<Option<f64>>,
    /// What is compared with the boundary, with its interval.
    pub estimate: Estimate,
    /// The smaller of the two-sided p values for and against what is expected.
    pub p: Option<f64>,
    /// What became of it, before the other claims are looked at.
    pub verdict: Ruling,
    /// Why there is no interval, or what must be known of it; may be empty.
    pub remark: String,
    /// The stages of the runs that it was computed from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sources: Vec<Source>,
}
