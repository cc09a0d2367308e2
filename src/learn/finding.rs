//! Findings: what the run-time checks of a training report. Independent of the checks themselves.
//!
//! A [`Finding`] is a warning of the range W0601 to W0610 with the sample count at which its cause began and,
//! when it went away, ended.

use serde::{Deserialize, Serialize};

/// A problem found in a training; each is reported once per training.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// The code of its page, for example `W0601`.
    pub code: String,
    /// Name of the action or reward term that it is about; empty for the training as a whole.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub subject: String,
    /// What is wrong, with the numbers of the update in which it was found.
    pub message: String,
    /// Samples after the first update of its cause.
    pub since: u64,
    /// Samples after the last update of its cause; `None` while it persists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<u64>,
}

/// The first fix to try, in one line; the page of the code says more.
pub fn cure(code: &str) -> &'static str {
    match code {
        "W0601" => "lower `learn.learning_rate`, or give the critic a longer `learn.warm_up`",
        "W0602" => {
            "lower the load on the joint (`action`, the reference motion), or raise its limits (robot file)"
        }
        "W0603" => "check what the action moves: a joint without effect on the reward, or a dead network",
        "W0604" => "lower `learn.learning_rate`, or use `activation = \"tanh\"`",
        "W0605" => "set `learn.value.privileged`, or lower `learn.value.learning_rate`",
        "W0606" => "end episodes that stand still with `terminate.contact_schedule`",
        "W0607" => "choose the term's `k` so that its value varies between states, or drop the term",
        "W0608" => "lower `learn.value.learning_rate`, or scale the rewards with `learn.reward_scale`",
        "W0610" => "raise `physics.rate`, or look for gains, efforts and inertias that do not fit each other",
        _ => "see its page",
    }
}
