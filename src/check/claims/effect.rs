//! E0204: the effect assumed for the power of a test meets the claim.

use super::at;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::statistic::{Method, StatisticKind};
use crate::spec::claim::{Claim, Over, keys};
use crate::statistics::Interval;
use crate::statistics::region::Region;

/// E0204 if the assumed effect does not meet the expectation, or, for a claim that no point meets it, if it
/// does.
pub fn lies_where_expected(claim: &Claim, statistic: &StatisticKind, sink: &mut Sink) {
    let Some(effect) = claim.effect.as_ref().filter(|_| statistic.method != Method::ProbabilityOfImprovement)
    else {
        return;
    };
    let region = Region::of(claim, statistic);
    let here = Interval { low: effect.si, high: effect.si };
    let is_negated = matches!(claim.over, Some(Over::None(_) | Over::AtMost(_)));
    let is_expected = if is_negated { region.opposes(here) } else { region.holds(here) };
    if is_expected {
        return;
    }
    let (not, remark) =
        if is_negated { ("", "meets the claim") } else { (" not", "does not meet the claim") };
    let message = format!("`effect` is out of range: with it `{}` does{not} hold", claim.expect.written());
    let error = at(claim, keys::Claim::effect.name, Diagnostic::error("E0204", message), remark);
    let of = match (claim.sides.len(), claim.expect.factor == 1.0) {
        (1, _) => "of the arm".to_owned(),
        (_, true) => format!("of `{}` minus `{}`", claim.expect.left, other(claim)),
        (_, false) => format!("of `{}` minus the multiple of `{}`", claim.expect.left, other(claim)),
    };
    sink.emit(
        error.help(format!("write the value {of} that is expected, so that the power is that of a PASS")),
    );
}

/// The arm on the right of the expectation.
fn other(claim: &Claim) -> &'static str {
    if claim.expect.left == "b" { "a" } else { "b" }
}
