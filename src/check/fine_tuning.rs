//! E0808, E0809 and E0810: requested policies are trained, and fine-tuning changes something that exists.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::action::Position;
use crate::kinds::deploy::{Deployment, Export, Transfer};
use crate::kinds::evaluate::Setting;
use crate::kinds::fine_tune::{self, FineTuning, Trained};
use crate::kinds::physics::Physics;
use crate::kinds::reward::Rewards;
use crate::kinds::terrain::Ground;
use crate::spec::Section;
use crate::spec::marks::below;
use crate::spec::section::RewardTerm;
use crate::spec::suggest::nearest;
use crate::spec::typed::InSection;
use crate::spec::value::canonical_table;

/// An evaluation or deployment of the fine-tuned policy requires `[fine_tune]`, and a transfer an export of
/// the same policy.
pub fn policies_are_trained(subject: &Subject, sink: &mut Sink) {
    let tuned = subject.spec().within::<FineTuning>().is_some();
    for (path, table) in subject.protocols() {
        if table.value(Setting::policy) == Some(Trained::FineTune) && !tuned {
            let message = format!("`{path}` uses the fine-tuned policy, but `[fine_tune]` is missing");
            let error = at(
                subject,
                &Setting::policy.below(&path),
                Diagnostic::error("E0808", message),
                "not trained",
            );
            let help =
                "add `[fine_tune]` with `kind = \"ppo\"`, `samples` and a `terrain`, or remove `policy`";
            sink.emit(error.help(help));
        }
    }
    if tuned {
        transfers_are_exported(subject, sink);
    }
}

/// Each transfer runs an exported policy.
fn transfers_are_exported(subject: &Subject, sink: &mut Sink) {
    let policy = |table: &Section| table.value(Export::policy).unwrap_or(Trained::FineTune);
    let deploys = subject.terms::<Deployment>();
    let exports = deploys.iter().filter(|(_, table)| table.is::<Export>());
    let exported: Vec<Trained> = exports.map(|(_, table)| policy(table)).collect();
    let transfers = deploys.iter().filter(|(_, table)| table.is::<Transfer>());
    for (path, table) in
        transfers.filter(|(_, table)| !exported.is_empty() && !exported.contains(&policy(table)))
    {
        let meant = policy(table).word();
        let message = format!("`{path}` runs the policy `{meant}`, which is not exported");
        let error = at(
            subject,
            &Export::policy.below(path),
            Diagnostic::error("E0808", message),
            "no export of \
                 this policy",
        );
        let table = format!("[deploy.{meant}_policy]");
        sink.emit(error.help(format!("add `{table}` with `kind = \"export\"` and `policy = \"{meant}\"`")));
    }
}

/// The terms that fine-tuning reweights are terms of the reward. A parent without a reward leaves it to its
/// children.
pub fn fine_tuning_weighs_terms(subject: &Subject, sink: &mut Sink) {
    let Some(weights) = subject.at(fine_tune::Ppo::weights) else { return };
    let Some(reward) = subject.spec().within::<Rewards>() else { return };
    let terms: Vec<&str> = reward.table().keys().map(String::as_str).collect();
    for term in weights.keys().filter(|term| !terms.contains(&term.as_str())) {
        let message = format!("unknown reward term `{term}` in `fine_tune.weights`");
        let error = at(
            subject,
            &below(&fine_tune::Ppo::weights.path(), term),
            Diagnostic::error("E0810", message),
            "not in `[reward]`",
        );
        let key = subject.marks.get(&below(&fine_tune::Ppo::weights.path(), term)).map(|mark| mark.key);
        sink.emit(match (nearest(term, terms.iter().copied()), key) {
            (Some(near), Some(key)) => error.help(format!("did you mean `{near}`?")).fix(key, near),
            (Some(near), None) => error.help(format!("did you mean `{near}`?")),
            (None, _) => error.help(format!("add `[reward.{term}]`, or remove the weight")),
        });
    }
}

/// With the same terrain, engine, exploration and reward, it would be a longer training, not fine-tuning.
pub fn fine_tuning_changes_the_world(subject: &Subject, sink: &mut Sink) {
    let first = subject.spec().within::<Ground>();
    let (Some(first), Some(second)) = (first, subject.at(fine_tune::Ppo::terrain)) else { return };
    if canonical_table(first.table()) != canonical_table(&second) {
        return;
    }
    // A parent may leave the exploration to its children.
    let Some(std) = subject.at(Position::std) else { return };
    let is_calm = subject.at(fine_tune::Ppo::std).is_some_and(|own| own != std);
    let engine = subject.at(fine_tune::Ppo::engine);
    let rewards = subject.spec().within::<Rewards>();
    let weight = |term: &str| rewards?.section(term)?.value(RewardTerm::weight);
    let weights = subject.at(fine_tune::Ppo::weights).unwrap_or_default();
    if weights.iter().any(|(term, own)| Some(*own) != weight(term)) {
        return;
    }
    if is_calm || engine.is_some_and(|own| Some(own) != subject.at(Physics::engine)) {
        return;
    }
    let message = "the fine-tuning has the terrain, exploration, engine and rewards of the training";
    let mut error =
        at(subject, &fine_tune::Ppo::terrain.path(), Diagnostic::error("E0809", message), "same terrain");
    if let Some(place) = subject.place(Ground::SECTION) {
        error = error.note(place, "terrain of the training");
    }
    sink.emit(error.help(
        "change the `terrain`, `std`, `engine` or `weights`, or raise `learn.samples` and remove \
         `[fine_tune]`",
    ));
}

/// A diagnostic at the place of a value.
fn at(subject: &Subject, path: &str, diagnostic: Diagnostic, remark: &str) -> Diagnostic {
    match subject.place(path) {
        Some(place) => diagnostic.at(place, remark),
        None => diagnostic,
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    const SAME: &str = "action.std = 0.1\nterrain = { kind = \"flat\", friction = 1.0 }\n";
    const FLAT: &str = "terrain = { kind = \"flat\", friction = 1.0 }\n";
    const ROUGH: &str =
        "fine_tune = { kind = \"ppo\", terrain = { kind = \"height_field\", friction = 1.0 } }\n";

    fn codes(rule: fn(&Subject, &mut Sink), text: &str) -> Vec<(&'static str, String)> {
        found(rule, text, None).into_iter().map(|found| (found.code, found.message)).collect()
    }

    #[test]
    fn a_fine_tuned_policy_comes_from_a_fine_tuning() {
        let text = format!("{FLAT}evaluate.after = {{ kind = \"episodes\", policy = \"fine_tune\" }}");
        assert_eq!(codes(policies_are_trained, &text)[0].0, "E0808");
        assert!(codes(policies_are_trained, &format!("{ROUGH}{text}")).is_empty());
        let before = text.replace("\"fine_tune\"", "\"learner\"");
        assert!(codes(policies_are_trained, &before).is_empty());
    }

    #[test]
    fn a_transfer_needs_an_export_of_its_own_policy() {
        let deploy = |policy: &str| {
            let export = "deploy.policy = { kind = \"export\" }\n";
            format!("{ROUGH}{export}deploy.mujoco = {{ kind = \"transfer\"{policy} }}")
        };
        assert!(codes(policies_are_trained, &deploy("")).is_empty());
        let found = codes(policies_are_trained, &deploy(", policy = \"learner\""));
        assert_eq!(
            found,
            [("E0808", "`deploy.mujoco` runs the policy `learner`, which is not exported".to_owned())]
        );
    }

    #[test]
    fn a_fine_tuning_on_the_same_ground_is_refused_however_it_is_written() {
        let tune =
            |terrain: &str| format!("{SAME}fine_tune = {{ kind = \"ppo\", terrain = {{ {terrain} }} }}");
        let same = codes(fine_tuning_changes_the_world, &tune("friction = 1.0, kind = \"flat\""));
        assert_eq!(same.iter().map(|found| found.0).collect::<Vec<_>>(), ["E0809"]);
        assert!(codes(fine_tuning_changes_the_world, &tune("kind = \"flat\", friction = 0.6")).is_empty());
        assert!(codes(fine_tuning_changes_the_world, FLAT).is_empty());
    }

    #[test]
    fn the_same_ground_with_another_exploration_is_a_fine_tuning() {
        let tune = |std: f64| {
            let terrain = "terrain = { friction = 1.0, kind = \"flat\" }";
            format!("{FLAT}action.std = 0.1\nfine_tune = {{ kind = \"ppo\", {terrain}, std = {std} }}")
        };
        assert!(codes(fine_tuning_changes_the_world, &tune(0.025)).is_empty());
        assert_eq!(codes(fine_tuning_changes_the_world, &tune(0.1)).len(), 1);
    }

    #[test]
    fn the_same_ground_with_another_weight_is_a_fine_tuning() {
        let tune = |weight: f64| {
            let terrain = "terrain = { friction = 1.0, kind = \"flat\" }";
            format!(
                "{SAME}reward.velocity_tracking.weight = 0.3\nfine_tune = \
                 {{ kind = \"ppo\", {terrain}, weights = {{ velocity_tracking = {weight} }} }}"
            )
        };
        assert!(codes(fine_tuning_changes_the_world, &tune(0.6)).is_empty());
        assert_eq!(codes(fine_tuning_changes_the_world, &tune(0.3)).len(), 1);
    }

    #[test]
    fn only_a_term_of_the_reward_can_be_weighed() {
        let tune = |term: &str| {
            format!(
                "reward.velocity_tracking.weight = 0.3\nfine_tune = \
                 {{ kind = \"ppo\", weights = {{ {term} = 0.6 }} }}"
            )
        };
        assert!(codes(fine_tuning_weighs_terms, &tune("velocity_tracking")).is_empty());
        let found = codes(fine_tuning_weighs_terms, &tune("velocity_trackin"));
        assert_eq!(
            found,
            [("E0810", "unknown reward term `velocity_trackin` in `fine_tune.weights`".to_owned())]
        );
    }

    #[test]
    fn the_same_ground_in_another_engine_is_a_fine_tuning() {
        let tune = |engine: &str| {
            let terrain = "terrain = { friction = 1.0, kind = \"flat\" }";
            format!(
                "{SAME}physics.engine = \"mujoco\"\nfine_tune = \
                 {{ kind = \"ppo\", {terrain}, engine = \"{engine}\" }}"
            )
        };
        assert!(codes(fine_tuning_changes_the_world, &tune("rapier")).is_empty());
        assert_eq!(codes(fine_tuning_changes_the_world, &tune("mujoco")).len(), 1);
    }
}
