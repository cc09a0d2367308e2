//! What the stages of a plan that must run are expected to take.

use std::collections::BTreeMap;

use super::fingerprint::Fingerprint;
use crate::escape::terminal::one_line;
use crate::quantity::span;

/// Expected times, as measured before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expected {
    /// CPU time in s of each stage that must run and takes more than seconds.
    pub seconds: BTreeMap<Fingerprint, f64>,
    /// The rates that the times follow from, each with where it was measured.
    pub rates: Vec<String>,
}

impl Expected {
    /// The expected time of a stage, as the table of `plan` shows it; empty if it is not known.
    pub fn time(&self, key: &Fingerprint) -> String {
        self.seconds.get(key).map(|seconds| span(*seconds)).unwrap_or_default()
    }

    /// The core-hours of the plan and the rates; empty if nothing long must run.
    pub fn text(&self) -> String {
        if self.seconds.is_empty() {
            return String::new();
        }
        let hours = self.seconds.values().sum::<f64>() / 3600.0;
        let digits = if hours < 1.0 { 2 } else { 1 };
        let mut out = one_line(&format!(
            "expected: {hours:.digits$} core-hours; the times are of one core, at these rates:"
        ));
        self.rates.iter().for_each(|rate| out += &one_line(&format!("  {rate}")));
        out + "\n"
    }
}
