//! The rules: which values in the metrics of one update are a sign of a problem. Every threshold is a
//! constant with its reason; a sign becomes a finding when it persists for the rule's number of updates.

use crate::env::{Output, View};
use crate::learn::metrics::UpdateMetrics;
use crate::learn::settings::{Rate, Settings};

/// Consecutive updates after which a sign becomes a finding: single rollouts differ by chance, ten in a row
/// do not.
const PATIENCE: u64 = 10;
/// The same for the KL divergence: five updates at five times the target move the policy by 25 targets.
const KL_PATIENCE: u64 = 5;
/// A steered step size passes 1.5 times its target and, in the first updates of real trainings, 2.5 times.
const KL_FACTOR: f64 = 5.0;
/// One update of this KL divergence is enough: the means have moved by 1.4 standard deviations of the
/// exploration, so the rollout is not informative about the new policy.
const KL_AT_ONCE: f64 = 1.0;
/// A motor is at its limit for short times even in good running. Above this share of the time its command
/// acts like a switch.
const SATURATED: f64 = 0.5;
/// A mean that varies by less than a hundredth of the exploration contributes less than a ten-thousandth of
/// its variance.
const DEAD_SPREAD: f64 = 0.01;
/// Some units are always zero; a network that has lost half of its units is no longer the one in the spec.
const DEAD_UNITS: f64 = 0.5;
/// Updates after the warm-up in which neither the critic's fit nor the scale of its values is judged.
const SETTLING: u64 = 10;
/// A critic with the same value everywhere explains zero variance, up to rounding.
const EXPLAINED: f64 = 0.01;
/// A reference with a smaller share of single support is neither a walk nor a run.
const STEPPING: f64 = 0.2;
/// A standing robot lifts a foot now and then under exploration; a tenth of the reference's single support is
/// not stepping.
const STANDING: f64 = 0.1;
/// Robots that fall at once have no time to step, and another problem is the cause.
const LASTING_S: f64 = 2.0;
/// A term that varies by a thousandth of its weight has no visible effect on advantages.
const CONSTANT: f64 = 1e-3;
/// A term at its full weight up to rounding is a yes-or-no term whose condition is met; a kernel never gets
/// there.
const FULFILLED: f64 = 1e-6;
/// A term below this share of the largest possible reward hardly matters, so its being constant is not worth
/// a warning.
const ORNAMENT: f64 = 0.05;
/// Share of the possible range by which returns may exceed it: the targets contain the critic's own errors.
const BEYOND: f64 = 0.1;

/// A rule: its code, the number of consecutive updates for which its sign must be present, and the function
/// that finds its signs.
pub(super) struct Rule {
    pub code: &'static str,
    pub patience: u64,
    pub signs: fn(&UpdateMetrics, &Norms) -> Vec<Sign>,
}

/// The sign of a rule in one update.
pub(super) struct Sign {
    /// The action or reward term; empty for the training as a whole.
    pub subject: String,
    pub message: String,
    /// Whether this update alone suffices.
    pub urgent: bool,
}

/// All rules, by code.
pub(super) const RULES: &[Rule] = &[
    Rule { code: "W0601", patience: KL_PATIENCE, signs: kl },
    Rule { code: "W0602", patience: PATIENCE, signs: saturated_actions },
    Rule { code: "W0603", patience: PATIENCE, signs: dead_actions },
    Rule { code: "W0604", patience: PATIENCE, signs: dead_units },
    Rule { code: "W0605", patience: PATIENCE, signs: explained_variance },
    Rule { code: "W0606", patience: PATIENCE, signs: single_support },
    Rule { code: "W0607", patience: PATIENCE, signs: constant_terms },
    Rule { code: "W0608", patience: PATIENCE, signs: returns },
    Rule { code: "W0610", patience: 1, signs: diverged },
];

/// The normal values of a training, known before it begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Norms {
    /// Target KL divergence of an update.
    kl: f64,
    /// Number of first updates in which only the critic learns.
    warm_up: u64,
    /// The outputs of the actor.
    outputs: Vec<Output>,
    /// The reward terms that can vary, with their least and greatest values.
    terms: Vec<(String, [f64; 2])>,
    /// The least and the greatest sum of discounted, scaled rewards.
    returns: [f64; 2],
}

impl Norms {
    /// The normal values with these settings in this environment.
    pub fn new(settings: &Settings, environment: &dyn View) -> Self {
        let named = environment.terms().iter().cloned().zip(environment.term_ranges().iter().copied());
        let horizon = settings.reward_scale / (1.0 - settings.gamma);
        let ends = [0, 1].map(|end| environment.term_ranges().iter().map(|range| range[end]).sum::<f64>());
        Self {
            kl: match settings.rate {
                Rate::Steered { target, .. } => target,
                // The divergence of a policy whose every sample is at the clip bound.
                _ => 0.5 * libm::log(1.0 + settings.clip).powi(2),
            },
            warm_up: settings.warm_up,
            outputs: environment.outputs().to_vec(),
            terms: named.filter(|(_, [low, high])| high > low).collect(),
            // An episode that has ended has no further reward, so zero is always possible.
            returns: [(ends[0] * horizon).min(0.0), (ends[1] * horizon).max(0.0)],
        }
    }

    fn settled(&self, metrics: &UpdateMetrics) -> bool {
        metrics.update >= self.warm_up + SETTLING
    }
}

impl Sign {
    fn of(subject: &str, message: String) -> Self {
        Self { subject: subject.into(), message, urgent: false }
    }

    fn when(sign: bool, message: impl FnOnce() -> String) -> Vec<Self> {
        sign.then(|| Self::of("", message())).into_iter().collect()
    }
}

fn kl(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let found = !metrics.kl.is_finite() || metrics.kl > KL_FACTOR * norms.kl;
    let mut signs = Sign::when(found, || {
        let times = metrics.kl / norms.kl;
        format!(
            "the policy jumps: update {} moved it by a KL divergence of {}, {times:.0} times the target \
             of {}",
            metrics.update,
            figure(metrics.kl),
            figure(norms.kl)
        )
    });
    signs.iter_mut().for_each(|sign| sign.urgent = metrics.kl.is_nan() || metrics.kl > KL_AT_ONCE);
    signs
}

fn saturated_actions(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let used = norms.outputs.iter().filter(|output| !output.optional);
    let share = |output: &Output| metrics.action_saturation.get(&output.name).copied().unwrap_or(0.0);
    let signs = used.filter(|output| share(output) > SATURATED).map(|output| {
        let (name, percent) = (&output.name, 100.0 * share(output));
        Sign::of(
            name,
            format!(
                "action `{name}` is saturated: the policy commands more than its range in {percent:.0} % of \
                 the steps"
            ),
        )
    });
    signs.collect()
}

fn dead_actions(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let used = norms.outputs.iter().filter(|output| !output.optional && norms.settled(metrics));
    let spread = |output: &Output| metrics.action_spread.get(&output.name).copied().unwrap_or(f64::INFINITY);
    let signs = used.filter(|output| spread(output) < DEAD_SPREAD).map(|output| {
        let (name, percent) = (&output.name, figure(100.0 * spread(output)));
        Sign::of(
            name,
            format!(
                "action `{name}` is dead: over all states the policy moves it by {percent} % of the \
                exploration"
            ),
        )
    });
    signs.collect()
}

fn dead_units(metrics: &UpdateMetrics, _: &Norms) -> Vec<Sign> {
    let share = metrics.dead_units.unwrap_or(0.0);
    Sign::when(share > DEAD_UNITS, || {
        format!("{:.0} % of the actor's hidden units are zero in every state", 100.0 * share)
    })
}

fn explained_variance(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let explained = metrics.explained_variance;
    Sign::when(norms.settled(metrics) && explained < EXPLAINED, || {
        let percent = figure(100.0 * explained);
        format!(
            "the critic is useless: it explains {percent} % of the returns' variance, a constant explains \
             0 %"
        )
    })
}

fn single_support(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let (Some(found), Some(wanted)) = (metrics.single_support, metrics.reference_single_support) else {
        return Vec::new();
    };
    // Without any episode end in the rollout, episodes are long.
    let lasting = metrics.length_mean_s.is_none_or(|length| length > LASTING_S);
    let still = wanted > STEPPING && found < STANDING * wanted;
    Sign::when(still && lasting && norms.settled(metrics), || {
        format!(
            "the robot does not step: it is on one foot in {:.1} % of the steps, the reference in {:.0} %",
            100.0 * found,
            100.0 * wanted
        )
    })
}

fn constant_terms(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let width = |[low, high]: &[f64; 2]| high - low;
    let finite = norms.terms.iter().filter(|(_, range)| width(range).is_finite());
    let whole: f64 = finite.clone().map(|(_, range)| width(range)).sum();
    let heavy = finite.filter(|(_, range)| width(range) >= ORNAMENT * whole);
    let spread = |name: &String| metrics.term_spread.get(name).copied().unwrap_or(f64::INFINITY);
    let constant = heavy.filter(|(name, range)| spread(name) < CONSTANT * width(range));
    let signs = constant.filter_map(|(name, range)| {
        // Steps that ended in a failure count as zero in this mean.
        let mean = metrics.terms.get(name).copied().unwrap_or(0.0);
        let place = match (mean - range[0]) / width(range) {
            share if share < 0.01 => "zero".to_owned(),
            share if share > 0.9 && spread(name) < FULFILLED * width(range) => return None,
            share if share > 0.99 => "its full weight".to_owned(),
            share => format!("{:.0} % of its weight", 100.0 * share),
        };
        Some(Sign::of(name, format!("reward term `{name}` gives no signal: it is constantly {place}")))
    });
    signs.collect()
}

fn returns(metrics: &UpdateMetrics, norms: &Norms) -> Vec<Sign> {
    let ends = (metrics.target_min, metrics.target_max, metrics.value_min, metrics.value_max);
    let (Some(least), Some(greatest), Some(low), Some(high)) = ends else { return Vec::new() };
    let [floor, ceiling] = norms.returns;
    let room =
        BEYOND * [floor, ceiling].iter().filter(|end| end.is_finite()).map(|end| end.abs()).sum::<f64>();
    if least < floor - room || greatest > ceiling + room {
        let between = |low, high| format!("{} to {}", figure(low), figure(high));
        return Sign::when(true, || {
            let (found, possible) = (between(least, greatest), between(floor, ceiling));
            format!("the critic's targets are out of range: {found}, where the rewards allow {possible}")
        });
    }
    // Targets may be nearly equal; values need not match them that exactly.
    let width = (greatest - least).max(room);
    Sign::when(low < least - width || high > greatest + width, || {
        let [values, targets] =
            [[low, high], [least, greatest]].map(|[a, b]| format!("{} to {}", figure(a), figure(b)));
        format!("the critic's values are out of range: {values}, while its targets are {targets}")
    })
}

/// One episode is enough: in a stable simulation none diverges.
fn diverged(metrics: &UpdateMetrics, _: &Norms) -> Vec<Sign> {
    let lost = metrics.ends.get("exploded").copied().unwrap_or(0);
    Sign::when(lost > 0, || {
        let (update, ended) = (metrics.update, metrics.episodes);
        format!("the physics diverged in {lost} of {ended} episodes that ended in update {update}")
    })
}

/// A number with three digits.
fn figure(value: f64) -> String {
    match value.abs() {
        size if size >= 1e4 || (size > 0.0 && size < 1e-3) => format!("{value:.1e}"),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 0.1 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
