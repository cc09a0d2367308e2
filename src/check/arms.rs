//! Merges the diagnostics of a suite's arms: one shared by several arms is reported once, and one of only
//! some arms names them.

use std::collections::{BTreeMap, BTreeSet};

use super::CheckedArm;
use crate::diag::{Diagnostic, Severity, Sink, Span};
use crate::spec::suite::Suite;

/// Identifies equal diagnostics: code, severity, message and places.
type Identity = (&'static str, Severity, String, Vec<(Span, String)>);

/// Adds the diagnostics of all arms, given by arm, to those of the suite.
pub fn gather(suite: &Suite, arms: &[CheckedArm], found: Vec<Vec<Diagnostic>>, sink: &mut Sink) {
    let known: Vec<Identity> = sink.diagnostics.iter().map(identity).collect();
    let mut first: Vec<(Diagnostic, Vec<usize>)> = Vec::new();
    let mut places: BTreeMap<Identity, usize> = BTreeMap::new();
    for (arm, diagnostics) in found.into_iter().enumerate() {
        for diagnostic in diagnostics {
            let identity = identity(&diagnostic);
            if known.contains(&identity) {
                continue;
            }
            let place = *places.entry(identity).or_insert_with(|| {
                first.push((diagnostic, Vec::new()));
                first.len() - 1
            });
            if first[place].1.last() != Some(&arm) {
                first[place].1.push(arm);
            }
        }
    }
    for (diagnostic, of) in first {
        sink.emit(if of.len() == arms.len() { diagnostic } else { note(suite, arms, diagnostic, &of) });
    }
    sink.diagnostics
        .sort_by_key(|found| found.labels.first().map(|label| (label.span.source, label.span.start)));
}

/// If the sweep is invalid, keeps the diagnostics that do not depend on its selection: those of all arms, or
/// of all arms at one point.
pub fn keep_certain(arms: &[CheckedArm], found: &mut [Vec<Diagnostic>]) {
    let mut of: BTreeMap<Identity, Vec<usize>> = BTreeMap::new();
    for (arm, diagnostics) in found.iter().enumerate() {
        diagnostics.iter().for_each(|diagnostic| of.entry(identity(diagnostic)).or_default().push(arm));
    }
    let at = |point: &(String, String)| -> Vec<usize> {
        (0..arms.len()).filter(|arm| arms[*arm].arm.points.contains(point)).collect()
    };
    let points: BTreeSet<&(String, String)> = arms.iter().flat_map(|arm| &arm.arm.points).collect();
    let mut whole: BTreeSet<Vec<usize>> = points.into_iter().map(at).collect();
    whole.insert((0..arms.len()).collect());
    of.values_mut().for_each(Vec::dedup);
    found.iter_mut().for_each(|found| found.retain(|diagnostic| whole.contains(&of[&identity(diagnostic)])));
}

fn identity(diagnostic: &Diagnostic) -> Identity {
    let places = diagnostic.labels.iter().map(|label| (label.span, label.text.clone())).collect();
    (diagnostic.code, diagnostic.severity, diagnostic.message.clone(), places)
}

/// Names the arms with a diagnostic by the points they have in common, if no other arm has these.
fn note(suite: &Suite, arms: &[CheckedArm], diagnostic: Diagnostic, of: &[usize]) -> Diagnostic {
    let points = |arm: usize| &arms[arm].arm.points;
    let common: Vec<&(String, String)> =
        points(of[0]).iter().filter(|point| of.iter().all(|arm| points(*arm).contains(point))).collect();
    let has_all = |arm: &CheckedArm| common.iter().all(|point| arm.arm.points.contains(point));
    let exact = !common.is_empty() && arms.iter().filter(|arm| has_all(arm)).count() == of.len();
    let place = |point: &(String, String)| {
        let axis = suite.sweep.axes.iter().find(|axis| axis.name == point.0)?;
        axis.point(&point.1).map(|point| point.place)
    };
    let Some(span) = common.last().and_then(|point| place(point)).filter(|_| exact) else {
        let (count, example) = (of.len(), &arms[of[0]].arm.name);
        return match count {
            1 => diagnostic.help(format!("occurs in the arm `{example}`")),
            _ => diagnostic.help(format!("occurs in {count} of {} arms, such as `{example}`", arms.len())),
        };
    };
    let own = diagnostic.labels.first().is_some_and(|label| label.span.source == suite.source);
    if own && common.len() == 1 {
        // The label already points at that point of the sweep.
        return diagnostic;
    }
    let name: Vec<String> = common.iter().map(|(axis, point)| format!("{axis}={point}")).collect();
    let (name, rest) = (name.join(","), if of.len() > 1 { "in the arms with" } else { "in the arm" });
    diagnostic.note(span, format!("{rest} `{name}`"))
}
