//! The monitor: which problems are present, since when, and whether they disappeared.

use std::collections::BTreeMap;

use super::rules::{Norms, RULES, Rule, Sign};
use crate::learn::finding::Finding;
use crate::learn::metrics::UpdateMetrics;

/// Watches the metrics of a training, update by update.
#[derive(Clone, Debug)]
pub struct Monitor {
    norms: Norms,
    spells: BTreeMap<(&'static str, String), Spell>,
    findings: Vec<Finding>,
}

/// How long a sign has been present or absent.
#[derive(Clone, Debug, Default)]
struct Spell {
    /// Consecutive updates with the sign.
    present: u64,
    /// Consecutive updates without it.
    absent: u64,
    /// Samples after the first and the last of the consecutive updates with the sign.
    samples: [u64; 2],
    /// Index among the findings.
    finding: Option<usize>,
}

impl Monitor {
    /// A monitor at the beginning of a training.
    pub fn new(norms: Norms) -> Self {
        Self { norms, spells: BTreeMap::new(), findings: Vec::new() }
    }

    /// Takes the metrics of the next update and returns the new findings.
    pub fn observe(&mut self, metrics: &UpdateMetrics) -> Vec<Finding> {
        let known = self.findings.len();
        for rule in RULES {
            let signs = (rule.signs)(metrics, &self.norms);
            let gone = |spell: &String| signs.iter().all(|sign| sign.subject != *spell);
            for ((_, _), spell) in
                self.spells.iter_mut().filter(|((code, at), _)| *code == rule.code && gone(at))
            {
                spell.miss(rule, &mut self.findings);
            }
            for sign in signs {
                let spell = self.spells.entry((rule.code, sign.subject.clone())).or_default();
                spell.see(metrics.samples, rule, sign, &mut self.findings);
            }
        }
        self.findings[known..].to_vec()
    }

    /// All findings so far, in the order of their detection.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}

impl Spell {
    fn see(&mut self, samples: u64, rule: &Rule, sign: Sign, findings: &mut Vec<Finding>) {
        self.samples = [if self.present == 0 { samples } else { self.samples[0] }, samples];
        self.present += 1;
        self.absent = 0;
        if self.present < rule.patience && !sign.urgent {
            return;
        }
        match self.finding {
            // The problem is back and was already reported.
            Some(place) => findings[place].until = None,
            None => {
                self.finding = Some(findings.len());
                let Sign { subject, message, .. } = sign;
                findings.push(Finding {
                    code: rule.code.into(),
                    subject,
                    message,
                    since: self.samples[0],
                    until: None,
                });
            }
        }
    }

    fn miss(&mut self, rule: &Rule, findings: &mut [Finding]) {
        self.present = 0;
        self.absent += 1;
        if let (true, Some(place)) = (self.absent == rule.patience, self.finding) {
            findings[place].until = Some(self.samples[1]);
        }
    }
}
