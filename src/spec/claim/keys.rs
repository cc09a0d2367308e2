//! The keys of a `[[claim]]`.

use serde::{Deserialize, Serialize};

use crate::spec::typed::Plain;
use crate::spec::typed::prelude::*;

choice! {
    /// How the runs of an arm are summarized.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Summary {
        /// The mean.
        #[default]
        Mean = "mean",
        /// The interquartile mean (Agarwal et al. 2021).
        Iqm = "iqm",
    }
}

impl Summary {
    /// Whether it is the default.
    pub fn is_mean(&self) -> bool {
        *self == Self::Mean
    }
}

choice! {
    /// How all arms of a pattern are combined.
    pub enum All {
        /// The expectation holds for each.
        Each = "each",
        /// It holds for the mean over them.
        Mean = "mean",
    }
}

keys! {
    /// The keys of `over` as a table; exactly one is written.
    pub struct Quantifier in "over" {
        /// An axis: at one of its points at least, the expectation holds in every comparison.
        some: Option<String>,
        /// An axis: at none of its points does the expectation hold in every comparison.
        none: Option<String>,
        /// In so many of the comparisons, or more, the expectation holds.
        #[range(1.0, 1e4)]
        at_least: Option<usize>,
        /// In so many of the comparisons, or fewer, the expectation holds.
        #[range(0.0, 1e4)]
        at_most: Option<usize>,
        /// An axis: the expectation is about the slope of the means over its points, in their order and per
        /// point.
        trend: Option<String>,
    }
}

either! {
    /// How a claim combines the arms that a pattern matches.
    pub enum Over {
        /// All of them.
        All(All),
        /// Some of them.
        Quantifier(Quantifier),
    }
}

either! {
    /// A number in the metric's unit.
    pub enum Amount {
        /// Without a unit.
        Number(Plain),
        /// With one.
        Text(String),
    }
}

keys! {
    /// The arms of a claim that compares two.
    pub struct Compare in "compare" {
        /// An arm, as `axis=point` joined by commas.
        a: String,
        /// The arm that it is compared with.
        b: String,
    }
}

keys! {
    /// What the reproduced paper reports.
    pub struct Paper in "paper" {
        /// Where the paper says it.
        r#where: String,
        /// What it says, in few words.
        value: String,
        /// The same as a number, in the metric's unit, to be drawn beside the measurement; of a claim that
        /// compares two arms, their difference.
        number: Option<Amount>,
        /// Whether this claim expects less than that, so that its PASS does not establish what the paper
        /// says.
        weaker: Option<bool>,
    }
}

keys! {
    /// A `[[claim]]`.
    pub struct Claim in "claim" {
        /// Its name in reports and events: letters, digits, `_`, `-` and `.`.
        id: String,
        /// What is claimed, as a sentence.
        text: String,
        /// A stage of the arms and a metric of it: `evaluate.nominal.survival`, `learn.final_return`.
        metric: String,
        /// Another stage of the same runs: the value of a run is the metric in the stage of `metric` minus
        /// the metric in this stage.
        baseline: Option<String>,
        /// Another arm, as `axis=point` joined by commas: what a run is compared with is the run of the same
        /// seed in the arm that has these points and else its own, in the stage of `metric` or of
        /// `baseline`.
        twin: Option<String>,
        /// Whether the metric is divided by that of the `baseline` or of the `twin` instead.
        relative: Option<bool>,
        /// The arms `a` and `b` of the expectation. An axis that is not named may take any point.
        compare: Option<Compare>,
        /// The arm `a` of a claim that compares one arm with a number.
        arm: Option<String>,
        /// What is claimed when a pattern matches several arms: that it holds for `each` of them, for the
        /// `mean` over them, for `{ some = AXIS }` point of an axis, for `{ none = AXIS }`, for
        /// `{ at_least = N }` or `{ at_most = N }` of the comparisons, or for the `{ trend = AXIS }` of their
        /// means. Without it a pattern must match one arm.
        over: Option<Over>,
        /// `a > b`, `a >= b + 20 %`, `a < 0.5 * b`, `a > 0.9`, `a < 0.2 m/s` or `a == b within 5 %`; see the
        /// page of claims.
        expect: String,
        /// The test: `specforge list statistic`.
        #[default("\"welch\"")]
        test: String,
        /// What an arm's runs are summarised by: the mean, or the interquartile mean.
        #[default("\"mean\"")]
        summary: Summary,
        /// Two-sided level of the test; the interval has the confidence 1 - alpha.
        #[range(1e-6, 0.5)]
        #[default("0.05")]
        alpha: f64,
        /// In the metric's unit: `>` and `<` must exceed it, `>=` and `<=` may fall short by it
        /// (non-inferiority).
        margin: Option<Amount>,
        /// The true value that is assumed for the power of the test: of one arm, or the difference of two, in
        /// the metric's unit.
        effect: Option<Amount>,
        /// The standard deviation between runs that is assumed for the power of the test before there are
        /// runs, in the metric's unit.
        spread: Option<Amount>,
        /// The return that `samples_to_threshold` waits for.
        threshold: Option<f64>,
        /// The samples from the beginning of a training that a metric of its curve looks at; without it, and
        /// in a shorter training, all.
        #[range(1.0, 1e12)]
        until: Option<u64>,
        /// The parameter that `failure_loading` and `failure_dominance` are about, by the name of its
        /// randomization.
        parameter: Option<String>,
        /// What the reproduced paper reports.
        paper: Option<Paper>,
    }
}
