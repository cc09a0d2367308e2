//! W1003: claims whose test would probably miss the stated effect.

use super::{Scope, at};
use crate::check::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::statistic;
use crate::spec::claim::{Case, Claim, cases, keys};
use crate::statistics::assumed::Assumed;

/// With less power than this, a claim is more likely left open than established even if its effect is real.
const LEAST: f64 = 0.5;

/// W1003 for every claim whose stated effect and spread give its test little power at the Holm-corrected
/// level for all claims, as `plan --power` shows it.
pub fn is_large_enough(claims: &[Claim], scope: &Scope, sink: &mut Sink) {
    let points = scope.points();
    for claim in claims {
        let level = claim.alpha / claims.len() as f64;
        told(claim, &cases(claim, &points), scope, level).into_iter().for_each(|warning| sink.emit(warning));
    }
}

fn told(claim: &Claim, cases: &[Case], scope: &Scope, level: f64) -> Option<Diagnostic> {
    let assumed = Assumed::of(claim, statistic::find(&claim.test)?);
    let power = assumed.power(cases, |arm| scope.arms[arm].runs, level).filter(|power| *power < LEAST)?;
    let percent = if power < 0.001 { "below 0.1".to_owned() } else { short(100.0 * power) };
    let message =
        format!("`{}` would stay open though its effect is there: its power is {percent} %", claim.id);
    let remark = format!("with this effect and spread, at alpha {}", short(level));
    let warning = at(claim, keys::Claim::effect.name, Diagnostic::warning("W1003", message), &remark);
    let warning = match scope.seeds {
        Some(span) => warning.note(span, "the seeds"),
        None => warning,
    };
    Some(match assumed.runs_for_all(cases, level) {
        Some(seeds) => warning.help(format!(
            "write `seeds = {seeds}` in `[sweep]` for a power of 80 %, or expect less, so that the effect \
             lies further from what is expected"
        )),
        None => warning.help("expect less, so that the effect lies further from what is expected"),
    })
}
