//! W0501, W0520 and W0521: reward terms with zero weight, negative weight, or more weight than all others
//! together.

use std::collections::BTreeMap;

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::fine_tune::{self, FineTuning};
use crate::kinds::reward::Rewards;
use crate::spec::marks::below;
use crate::spec::section::RewardTerm;
use crate::spec::typed::InSection;

/// A term that pays more than this share of the maximum reward makes the others negligible. The shipped specs
/// pay at most 35 % for one term.
const SHARE: f64 = 0.8;
/// The same for a reward of two terms, often a goal and a small cost.
const SHARE_OF_TWO: f64 = 0.98;

/// No reward term has the weight zero.
pub fn weights_are_not_zero(subject: &Subject, sink: &mut Sink) {
    for (path, term) in subject.terms::<Rewards>() {
        if term.value(RewardTerm::weight) != Some(0.0) {
            continue;
        }
        let diagnostic = Diagnostic::warning("W0501", format!("`{path}` has no effect: its weight is zero"));
        sink.emit(
            placed(subject, &RewardTerm::weight.below(&path), diagnostic)
                .help("remove the term with `enabled = false`"),
        );
    }
}

/// No term rewards failure. Every kind of term is a number from 0 to 1 that is largest when all is well, so a
/// negative weight rewards the opposite, and a negative sum rewards ending the episode.
pub fn weights_are_positive(subject: &Subject, sink: &mut Sink) {
    for (place, term, weight) in paid(subject).into_iter().chain(tuned(subject)) {
        if weight >= 0.0 {
            continue;
        }
        let message =
            format!("`reward.{term}` has the negative weight {}, which rewards the opposite", short(weight));
        let help = "write a positive weight: reward terms are between 0 (worst) and 1 (best)";
        let diagnostic = placed(subject, &place, Diagnostic::warning("W0520", message)).help(help);
        let written = subject.marks.get(&place).and_then(|mark| mark.text.strip_prefix('-'));
        sink.emit(match written {
            Some(positive) => subject.edited(&place, positive, diagnostic),
            None => diagnostic,
        });
    }
}

/// No term outweighs all others, in training or fine-tuning.
pub fn no_weight_dominates(subject: &Subject, sink: &mut Sink) {
    let first = paid(subject);
    dominating(subject, &first, sink);
    let own = tuned(subject);
    if own.is_empty() {
        return;
    }
    let mut both: BTreeMap<String, (String, f64)> =
        first.into_iter().map(|(place, term, weight)| (term, (place, weight))).collect();
    both.extend(own.into_iter().map(|(place, term, weight)| (term, (place, weight))));
    let both: Vec<_> = both.into_iter().map(|(term, (place, weight))| (place, term, weight)).collect();
    if both.iter().any(|(place, ..)| place.starts_with(FineTuning::SECTION)) {
        dominating(subject, &both, sink);
    }
}

/// The place, name and weight of every reward term.
fn paid(subject: &Subject) -> Vec<(String, String, f64)> {
    let name = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let terms = subject.terms::<Rewards>().into_iter();
    terms
        .filter_map(|(path, term)| {
            Some((RewardTerm::weight.below(&path), name(&path), term.value(RewardTerm::weight)?))
        })
        .collect()
}

/// The same for terms that fine-tuning reweights.
fn tuned(subject: &Subject) -> Vec<(String, String, f64)> {
    let weights = subject.at(fine_tune::Ppo::weights).unwrap_or_default().into_iter();
    weights.map(|(term, weight)| (below(&fine_tune::Ppo::weights.path(), &term), term, weight)).collect()
}

/// Terms with zero weight are reported separately (W0501) and count as disabled.
fn dominating(subject: &Subject, weights: &[(String, String, f64)], sink: &mut Sink) {
    let weights: Vec<_> = weights.iter().filter(|(.., weight)| *weight != 0.0).collect();
    let largest = weights.iter().max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()));
    // Relative to the largest, so that sums cannot overflow.
    let unit = largest.map_or(1.0, |(.., weight)| weight.abs());
    let total: f64 = weights.iter().map(|(.., weight)| weight.abs() / unit).sum();
    let share = match weights.len() {
        0 | 1 => return,
        2 => SHARE_OF_TWO,
        _ => SHARE,
    };
    let Some((place, term, weight)) = largest.filter(|(.., weight)| weight.abs() / unit > share * total)
    else {
        return;
    };
    let rest: f64 =
        weights.iter().filter(|(_, other, _)| other != term).map(|(.., weight)| weight.abs()).sum();
    let others = weights.len() - 1;
    let message = format!(
        "`reward.{term}` contributes {:.1} % of the reward: {} against {} for the {}",
        100.0 * (weight.abs() / unit) / total,
        short(*weight),
        short(rest),
        if others == 1 { "other term".to_owned() } else { format!("{others} other terms together") },
    );
    let help = format!(
        "lower its weight to {} or less, so that the other terms influence the policy, or remove them",
        short(2.0 * rest)
    );
    sink.emit(placed(subject, place, Diagnostic::warning("W0521", message)).help(help));
}

fn placed(subject: &Subject, path: &str, diagnostic: Diagnostic) -> Diagnostic {
    match subject.place(path) {
        Some(place) => diagnostic.at(place, ""),
        None => diagnostic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    fn said(rule: fn(&Subject, &mut Sink), text: &str) -> Vec<(&'static str, String)> {
        found(rule, text, None).into_iter().map(|found| (found.code, found.message)).collect()
    }

    #[test]
    fn only_zero_is_zero() {
        let text = "[reward.torque]\nweight = 0.0\n[reward.contact_force]\nweight = 0.1";
        let expected = [("W0501", "`reward.torque` has no effect: its weight is zero".to_owned())];
        assert_eq!(said(weights_are_not_zero, text), expected);
    }

    #[test]
    fn weights_whose_sum_overflows_are_compared_all_the_same() {
        let text = "[reward.torque]\nweight = 1e308\n[reward.contact_force]\nweight = \
            1e308\n[reward.joint_tracking]\nweight = 1e307";
        assert_eq!(said(no_weight_dominates, text), []);
        let told = said(
            no_weight_dominates,
            &text.replacen("1e308", "1.7e308", 1).replacen("weight = 1e308", "weight = 1e306", 1),
        );
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(
            told[0].1.starts_with(
                "`reward.torque` contributes 93.9 % of the reward: 1.700e308 against \
                                   1.100e307"
            ),
            "{told:?}"
        );
    }

    #[test]
    fn a_negative_weight_is_told_in_the_training_and_in_the_fine_tuning() {
        let text = "[reward.torque]\nweight = -0.05\n[reward.contact_force]\nweight = \
            0.1\n[fine_tune.weights]\ncontact_force = -1.0";
        let message = |term: &str, weight: &str| {
            format!("`reward.{term}` has the negative weight {weight}, which rewards the opposite")
        };
        let expected = [("W0520", message("torque", "-0.05")), ("W0520", message("contact_force", "-1"))];
        assert_eq!(said(weights_are_positive, text), expected);
        assert!(said(weights_are_positive, "[reward.torque]\nweight = 0.0").is_empty());
    }

    #[test]
    fn a_weight_that_leaves_the_others_less_than_a_fifth_is_told() {
        let text = |weight: &str| {
            format!("[reward.a]\nweight = {weight}\n[reward.b]\nweight = 0.3\n[reward.c]\nweight = 0.2")
        };
        assert!(said(no_weight_dominates, &text("2.0")).is_empty());
        let expected = "`reward.a` contributes 98.0 % of the reward: 25 against 0.5 for the 2 other terms \
                        together";
        assert_eq!(said(no_weight_dominates, &text("25.0")), [("W0521", expected.to_owned())]);
        assert_eq!(said(no_weight_dominates, &text("1e300")).len(), 1);
        assert_eq!(said(no_weight_dominates, &text("-25.0")).len(), 1);
        // A goal and a small cost.
        assert!(said(no_weight_dominates, "[reward.a]\nweight = 1.0\n[reward.b]\nweight = 0.05").is_empty());
        assert_eq!(
            said(no_weight_dominates, "[reward.a]\nweight = 1.0\n[reward.b]\nweight = 0.001").len(),
            1
        );
        // A single term has nothing to dominate.
        assert!(said(no_weight_dominates, "[reward.a]\nweight = 25.0").is_empty());
    }

    #[test]
    fn the_weights_of_a_fine_tuning_lie_over_those_of_the_training() {
        let text = |weight: &str| {
            format!(
                "[reward.a]\nweight = 0.3\n[reward.b]\nweight = 0.3\n[reward.c]\nweight = \
                 0.1\n[fine_tune.weights]\nb = {weight}"
            )
        };
        assert!(said(no_weight_dominates, &text("0.9")).is_empty());
        assert_eq!(said(no_weight_dominates, &text("9.0")).len(), 1);
    }
}
