//! The values that a comparison was judged by, as a report's record stores them: enough to judge it again.

use serde::{Deserialize, Serialize};

use crate::kinds::statistic::Method;
use crate::statistics::test::{Sample, count, pairs};

/// The values of a comparison, the left side of the expectation first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Evidence {
    /// The value of every run.
    Runs {
        /// By side and stratum, in the order of the sources; absent for a threshold that was never reached.
        values: Vec<Vec<Vec<Option<f64>>>>,
        /// The fewest episodes behind a run's value, where that is a share of episodes.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        episodes: Option<usize>,
    },
    /// Successes and trials of each side.
    Counts(Vec<[u64; 2]>),
    /// Paired episodes: both sides succeeded, only the first, only the second, neither.
    Pairs([u64; 4]),
    /// The value of every episode of each side.
    Episodes {
        /// By side.
        values: Vec<Vec<f64>>,
        /// Whether both sides ran the same episodes.
        paired: bool,
    },
}

impl Evidence {
    /// What a test with this method needs of a sample.
    pub fn of(sample: &Sample, method: Method) -> Self {
        let finite = |value: &f64| value.is_finite().then_some(*value);
        match sample {
            Sample::Runs { sides, episodes } => {
                let stratum = |runs: &Vec<f64>| runs.iter().map(finite).collect();
                let values = sides.iter().map(|strata| strata.iter().map(stratum).collect()).collect();
                Self::Runs { values, episodes: *episodes }
            }
            Sample::Episodes { sides, paired } => match (method, paired, pairs(sides)) {
                (Method::Mcnemar, true, Some(pairs)) => {
                    Self::Pairs([pairs.both, pairs.only_first, pairs.only_second, pairs.neither])
                }
                (Method::EpisodeBootstrap, ..) => Self::Episodes { values: sides.clone(), paired: *paired },
                _ => Self::Counts(sides.iter().map(|values| count(values)).collect()),
            },
        }
    }
}
