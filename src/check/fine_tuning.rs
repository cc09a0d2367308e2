//! E0808, E0809 and E0810: a policy that is asked for is trained, and a fine-tuning changes something that is there.

use super::Subject;
use crate::diag::{Diagnostic, Sink};
use crate::spec::suggest::nearest;
use crate::spec::value::canonical_table;

/// An evaluation or a deployment of the fine-tuned policy has a `[fine_tune]` to come from, and a transfer an export of
/// the same policy.
pub fn policies_are_trained(subject: &Subject, sink: &mut Sink) {
    let tuned = subject.section("fine_tune").is_some();
    for (path, _) in subject.protocols() {
        if subject.text(&format!("{path}.policy")) == Some("fine_tune") && !tuned {
            let message = format!("`{path}` is about the fine-tuned policy, and there is no `[fine_tune]`");
            let error = at(subject, &format!("{path}.policy"), Diagnostic::error("E0808", message), "not trained");
            let help = "add `[fine_tune]` with `kind = \"ppo\"`, `samples` and a `terrain`, or remove `policy`";
            sink.emit(error.help(help));
        }
    }
    if tuned {
        transfers_are_exported(subject, sink);
    }
}

/// Each transfer runs a policy that one of the exports writes.
fn transfers_are_exported(subject: &Subject, sink: &mut Sink) {
    let policy = |path: &str| subject.text(&format!("{path}.policy")).unwrap_or("fine_tune");
    let of_kind = |kind: &'static str| {
        let deploys = subject.terms("deploy").into_iter().map(|(path, _)| path);
        deploys.filter(move |path| subject.kind(path) == Some(kind))
    };
    let exported: Vec<&str> = of_kind("export").map(|path| policy(&path)).collect();
    for path in of_kind("transfer").filter(|path| !exported.is_empty() && !exported.contains(&policy(path))) {
        let meant = policy(&path);
        let message = format!("`{path}` runs the policy `{meant}`, which no export writes");
        let error = at(subject, &format!("{path}.policy"), Diagnostic::error("E0808", message), "not exported");
        let table = format!("[deploy.{meant}_policy]");
        sink.emit(error.help(format!("add `{table}` with `kind = \"export\"` and `policy = \"{meant}\"`")));
    }
}

/// The terms that a fine-tuning weighs otherwise are terms of the reward. A parent without a reward leaves it to its
/// children.
pub fn fine_tuning_weighs_terms(subject: &Subject, sink: &mut Sink) {
    let Some(weights) = subject.section("fine_tune.weights") else { return };
    let Some(reward) = subject.section("reward") else { return };
    let terms: Vec<&str> = reward.table().keys().map(String::as_str).collect();
    for term in weights.table().keys().filter(|term| !terms.contains(&term.as_str())) {
        let message = format!("`[reward]` has no term `{term}` for the fine-tuning to weigh");
        let error =
            at(subject, &format!("fine_tune.weights.{term}"), Diagnostic::error("E0810", message), "of which term?");
        let near = nearest(term, terms.iter().copied()).map(|near| format!("did you mean `{near}`?"));
        sink.emit(error.help(near.unwrap_or_else(|| format!("add `[reward.{term}]`, or remove the weight"))));
    }
}

/// Learning on the same ground in the same engine, with the same exploration and reward again is a longer training, not a
/// fine-tuning.
pub fn fine_tuning_changes_the_world(subject: &Subject, sink: &mut Sink) {
    let (Some(first), Some(second)) = (subject.section("terrain"), subject.section("fine_tune.terrain")) else {
        return;
    };
    if canonical_table(first.table()) != canonical_table(second.table()) {
        return;
    }
    let std = |section: &str| subject.section(section).and_then(|section| section.si_if("std"));
    let is_calm = std("fine_tune").is_some_and(|own| Some(own) != std("action"));
    let engine = subject.text("fine_tune.engine");
    let weighs = |term: &String| {
        subject.number(&format!("fine_tune.weights.{term}")) != subject.number(&format!("reward.{term}.weight"))
    };
    if subject.section("fine_tune.weights").is_some_and(|weights| weights.table().keys().any(weighs)) {
        return;
    }
    if is_calm || engine.is_some_and(|own| Some(own) != subject.text("physics.engine")) {
        return;
    }
    let message = "the ground of the fine-tuning is that of the first training";
    let mut error = at(subject, "fine_tune.terrain", Diagnostic::error("E0809", message), "the same ground again");
    if let Some(place) = subject.place("terrain") {
        error = error.note(place, "the ground of the training");
    }
    sink.emit(error.help("write another `terrain` here, an exploration (`std`), an `engine` or reward `weights` of its own, or raise `learn.samples` and remove `[fine_tune]`"));
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

    const FLAT: &str = "terrain = { kind = \"flat\", friction = 1.0 }\n";
    const ROUGH: &str = "fine_tune = { kind = \"ppo\", terrain = { kind = \"height_field\", friction = 1.0 } }\n";

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
        assert_eq!(found, [("E0808", "`deploy.mujoco` runs the policy `learner`, which no export writes".to_owned())]);
    }

    #[test]
    fn a_fine_tuning_on_the_same_ground_is_refused_however_it_is_written() {
        let tune = |terrain: &str| format!("{FLAT}fine_tune = {{ kind = \"ppo\", terrain = {{ {terrain} }} }}");
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
                "{FLAT}reward.velocity_tracking.weight = 0.3\nfine_tune = {{ kind = \"ppo\", {terrain}, weights = {{ velocity_tracking = {weight} }} }}"
            )
        };
        assert!(codes(fine_tuning_changes_the_world, &tune(0.6)).is_empty());
        assert_eq!(codes(fine_tuning_changes_the_world, &tune(0.3)).len(), 1);
    }

    #[test]
    fn only_a_term_of_the_reward_can_be_weighed() {
        let tune = |term: &str| {
            format!(
                "reward.velocity_tracking.weight = 0.3\nfine_tune = {{ kind = \"ppo\", weights = {{ {term} = 0.6 }} }}"
            )
        };
        assert!(codes(fine_tuning_weighs_terms, &tune("velocity_tracking")).is_empty());
        let found = codes(fine_tuning_weighs_terms, &tune("velocity_trackin"));
        assert_eq!(
            found,
            [("E0810", "`[reward]` has no term `velocity_trackin` for the fine-tuning to weigh".to_owned())]
        );
    }

    #[test]
    fn the_same_ground_in_another_engine_is_a_fine_tuning() {
        let tune = |engine: &str| {
            let terrain = "terrain = { friction = 1.0, kind = \"flat\" }";
            format!(
                "{FLAT}physics.engine = \"mujoco\"\nfine_tune = {{ kind = \"ppo\", {terrain}, engine = \"{engine}\" }}"
            )
        };
        assert!(codes(fine_tuning_changes_the_world, &tune("rapier")).is_empty());
        assert_eq!(codes(fine_tuning_changes_the_world, &tune("mujoco")).len(), 1);
    }
}
