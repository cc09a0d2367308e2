//! E0507, W0508, W0522 and W0702 between keys of the learner: batches divide the rollout, the actor is trained
//! after the critic's warm-up, an early stop is after the first update and before the end, and whole updates
//! keep to the budget.

use std::collections::BTreeMap;

use super::{CheckedArm, Subject};
use crate::diag::{Diagnostic, Sink};
use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::in_whole_updates;
use crate::spec::Section;
use crate::syntax::Layer;

/// `learn.environments` divides `learn.rollout`, and a minibatch is at most one rollout.
pub fn batches_divide_the_rollout(subject: &Subject, sink: &mut Sink) {
    let Some(rollout) = subject.at(Ppo::rollout) else { return };
    let mut report = |path: &str, message: String, advice: String, most: u64| {
        let mut diagnostic = Diagnostic::error("E0507", message);
        if let Some(place) = subject.place(path) {
            diagnostic = diagnostic.at(place, "");
        }
        if let Some(mark) =
            subject.marks.get(&Ppo::rollout.path()).filter(|mark| mark.layer != Layer::Default)
        {
            diagnostic = diagnostic.note(mark.value, "samples per update");
        }
        sink.emit(subject.edited(path, most.to_string(), diagnostic.help(advice)));
    };
    if let Some(environments) = subject.at(Ppo::environments)
        && (environments == 0 || rollout % environments != 0)
    {
        let message =
            format!("`learn.environments` ({environments}) does not divide `learn.rollout` ({rollout})");
        let nearest = (1..=environments.min(rollout)).rev().find(|count| rollout % count == 0).unwrap_or(1);
        report(
            &Ppo::environments.path(),
            message,
            format!("write `learn.environments = {nearest}`, the next lower divisor"),
            nearest as u64,
        );
    }
    if let Some(minibatch) = subject.at(Ppo::minibatch)
        && minibatch > rollout
    {
        let message = format!("`learn.minibatch` ({minibatch}) is larger than `learn.rollout` ({rollout})");
        let advice =
            format!("write `learn.minibatch = {rollout}` or less: a minibatch is part of one rollout");
        report(&Ppo::minibatch.path(), message, advice, rollout as u64);
    }
}

/// The budget has updates after the critic's warm-up.
pub fn the_actor_has_its_turn(subject: &Subject, sink: &mut Sink) {
    let (Some(samples), Some(warm_up)) = (subject.at(Ppo::samples), subject.at(Ppo::warm_up)) else { return };
    let Some(rollout) = subject.at(Ppo::rollout).map(|rollout| rollout as u64) else { return };
    // With 0 samples no training is intended.
    if samples == 0 {
        return;
    }
    let stop = subject.at(Ppo::stop_at).filter(|stop| *stop < samples);
    let samples = stop.unwrap_or(samples);
    let updates = samples.div_ceil(rollout.max(1));
    if updates > warm_up {
        return;
    }
    let message = match updates {
        0 => "the actor is never updated: the training stops before its first sample".to_owned(),
        _ => format!(
            "the actor is never updated: {samples} samples are {updates} updates of {rollout}, and the \
             critic's warm-up takes {warm_up}"
        ),
    };
    let mut diagnostic = Diagnostic::warning("W0508", message);
    if let Some(place) =
        subject.place(&if stop.is_some() { Ppo::stop_at.path() } else { Ppo::samples.path() })
    {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some(mark) = subject.marks.get(&Ppo::warm_up.path()).filter(|_| warm_up > 0) {
        diagnostic = diagnostic.note(mark.value, "warm-up of the critic");
    }
    let (fewer, more) = (updates / 5, (warm_up + 1).saturating_mul(rollout));
    sink.emit(match (stop, updates) {
        (Some(_), 0) => diagnostic.help(format!("set `learn.stop_at = {more}`, or remove it")),
        (Some(_), _) => diagnostic.help(format!("set `learn.warm_up = {fewer}` or `learn.stop_at = {more}`")),
        (None, _) => diagnostic.help(format!("set `learn.warm_up = {fewer}` or `learn.samples = {more}`")),
    });
}

/// An early stop is after the first update: trainings end after whole updates.
pub fn the_stop_comes_after_an_update(subject: &Subject, sink: &mut Sink) {
    let (Some(stop), Some(samples)) = (subject.at(Ppo::stop_at), subject.at(Ppo::samples)) else { return };
    let Some(rollout) = subject.at(Ppo::rollout).map(|rollout| rollout as u64) else { return };
    // `the_actor_has_its_turn` reports a stop at 0.
    if stop == 0 || stop >= samples || stop >= rollout {
        return;
    }
    let message = format!(
        "`learn.stop_at` is less than one update: the training ends after {rollout} samples, not {stop}"
    );
    let mut diagnostic = Diagnostic::warning("W0522", message);
    if let Some(place) = subject.place(&Ppo::stop_at.path()) {
        diagnostic = diagnostic.at(place, "within the first update");
    }
    if let Some(mark) = subject.marks.get(&Ppo::rollout.path()) {
        diagnostic = diagnostic.note(mark.value, "samples per update");
    }
    let diagnostic = diagnostic.help(format!("write `learn.stop_at = {rollout}` or a multiple of it"));
    sink.emit(subject.edited(&Ppo::stop_at.path(), rollout.to_string(), diagnostic));
}

/// An early stop is before the end of the budget.
pub fn the_stop_comes_before_the_end(subject: &Subject, sink: &mut Sink) {
    let (Some(stop), Some(samples)) = (subject.at(Ppo::stop_at), subject.at(Ppo::samples)) else { return };
    if stop < samples {
        return;
    }
    let message = format!("`learn.stop_at` has no effect: the training ends after {samples} samples anyway");
    let mut diagnostic = Diagnostic::warning("W0522", message);
    if let Some(place) = subject.place(&Ppo::stop_at.path()) {
        diagnostic = diagnostic.at(place, "not before the end");
    }
    if let Some(mark) = subject.marks.get(&Ppo::samples.path()) {
        diagnostic = diagnostic.note(mark.value, "sample budget");
    }
    sink.emit(diagnostic.help("remove `stop_at`, or write a number below `learn.samples`"));
}

/// Factor between budget and whole updates from which a training is reported.
const ROUNDED: f64 = 1.2;
/// The same between the arms of a suite.
const APART: f64 = 1.02;

/// Whole updates do not exceed the budget by much.
pub fn whole_updates_keep_to_the_budget(subject: &Subject, sink: &mut Sink) {
    let (Some(samples), Some(rollout)) = (subject.at(Ppo::samples), subject.at(Ppo::rollout)) else { return };
    let rollout = rollout as u64;
    let whole = in_whole_updates(samples, rollout);
    let warm_up = subject.at(Ppo::warm_up).unwrap_or(0);
    let stops = subject.at(Ppo::stop_at).is_some_and(|stop| stop < samples);
    // A training without an update of the actor is W0508, an early stop W0522.
    if stops || whole / rollout.max(1) <= warm_up || whole as f64 <= ROUNDED * samples as f64 {
        return;
    }
    let message = format!("the training takes {whole} samples, not {samples}: updates are whole");
    let mut diagnostic = Diagnostic::warning("W0702", message);
    if let Some(place) = subject.place(&Ppo::samples.path()) {
        diagnostic = diagnostic.at(place, "");
    }
    if let Some(mark) = subject.marks.get(&Ppo::rollout.path()).filter(|mark| mark.layer != Layer::Default) {
        diagnostic = diagnostic.note(mark.value, "samples per update");
    }
    let diagnostic =
        diagnostic.help(format!("write `learn.samples = {whole}`, or a smaller `learn.rollout`"));
    sink.emit(subject.edited(&Ppo::samples.path(), whole.to_string(), diagnostic));
}

/// Arms of one budget take the same number of samples, whatever their rollouts.
pub fn arms_take_equal_samples(arms: &[CheckedArm], sink: &mut Sink) {
    let mut budgets: BTreeMap<u64, Vec<(u64, &CheckedArm)>> = BTreeMap::new();
    for arm in arms {
        let fields = Section::new(&arm.arm.experiment.table);
        let (Some(samples), Some(rollout)) = (fields.at(Ppo::samples), fields.at(Ppo::rollout)) else {
            continue;
        };
        let samples = fields.at(Ppo::stop_at).map_or(samples, |stop| stop.min(samples));
        budgets.entry(samples).or_default().push((in_whole_updates(samples, rollout as u64), arm));
    }
    for (samples, arms) in budgets {
        let taken = || arms.iter().map(|(taken, _)| *taken);
        let (Some(fewest), Some(most)) = (taken().min(), taken().max()) else { continue };
        if most as f64 <= APART * fewest as f64 {
            continue;
        }
        let mut diagnostic = Diagnostic::warning(
            "W0702",
            format!(
                "arms with the budget {samples} take between {fewest} and {most} samples: updates are whole, and \
                 their rollouts differ"
            ),
        );
        let largest = arms.iter().find(|(taken, _)| *taken == most);
        let mark = largest.and_then(|(_, arm)| arm.arm.experiment.marks.get(&Ppo::rollout.path()));
        if let Some(mark) = mark {
            diagnostic = diagnostic.at(mark.value, format!("samples per update: {most} in all"));
        }
        if arms.iter().any(|(_, arm)| arm.arm.experiment.allow.contains_key("W0702")) {
            continue;
        }
        sink.emit(diagnostic.help("write a `learn.samples` that every rollout divides"));
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn environments_share_a_rollout_evenly() {
        let spec = |environments: u32| {
            format!("[learn]\nrollout = 8192\nminibatch = 128\nenvironments = {environments}")
        };
        assert_eq!(found(batches_divide_the_rollout, &spec(64), None), []);
        let diagnostics = found(batches_divide_the_rollout, &spec(60), None);
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(
            (diagnostics[0].code, diagnostics[0].help[0].as_str()),
            ("E0507", "write `learn.environments = 32`, the next lower divisor")
        );
    }

    #[test]
    fn a_budget_within_the_warm_up_is_warned_of() {
        let spec = |samples: u32| format!("[learn]\nrollout = 8192\nwarm_up = 5\nsamples = {samples}");
        assert_eq!(found(the_actor_has_its_turn, &spec(0), None), []);
        assert_eq!(found(the_actor_has_its_turn, &spec(40_961), None), []);
        let diagnostics = found(the_actor_has_its_turn, &spec(40_000), None);
        assert_eq!(diagnostics.len(), 1);
        let told = (diagnostics[0].code, diagnostics[0].help[0].as_str());
        assert_eq!(told, ("W0508", "set `learn.warm_up = 1` or `learn.samples = 49152`"));
    }

    #[test]
    fn a_stop_before_the_actor_learns_is_warned_of_at_the_stop() {
        let spec = |warm_up: u32, stop: u32| {
            format!("[learn]\nrollout = 8192\nwarm_up = {warm_up}\nsamples = 8000000\nstop_at = {stop}")
        };
        let told = |warm_up: u32, stop: u32| {
            let found = found(the_actor_has_its_turn, &spec(warm_up, stop), None);
            found.into_iter().map(|found| (found.message, found.help[0].clone())).collect::<Vec<_>>()
        };
        assert_eq!(told(5, 40_961), []);
        let [(message, help)] = <[_; 1]>::try_from(told(5, 40_000)).expect("one");
        assert!(
            message.starts_with("the actor is never updated: 40000 samples are 5 updates of 8192"),
            "{message}"
        );
        assert_eq!(help, "set `learn.warm_up = 1` or `learn.stop_at = 49152`");
        for warm_up in [0, 5] {
            let [(message, _)] = <[_; 1]>::try_from(told(warm_up, 0)).expect("one");
            assert_eq!(message, "the actor is never updated: the training stops before its first sample");
        }
    }

    #[test]
    fn a_stop_within_the_first_update_is_warned_of() {
        let spec = |stop: u32| format!("[learn]\nrollout = 8192\nsamples = 8000000\nstop_at = {stop}");
        let codes = |stop| found(the_stop_comes_after_an_update, &spec(stop), None).len();
        assert_eq!([0, 1, 8191, 8192, 8193].map(codes), [0, 1, 1, 0, 0]);
    }

    #[test]
    fn a_stop_at_or_after_the_end_is_warned_of() {
        let spec = |stop: u32| format!("[learn]\nsamples = 40000\nstop_at = {stop}");
        assert_eq!(found(the_stop_comes_before_the_end, &spec(39_999), None), []);
        let diagnostics = found(the_stop_comes_before_the_end, &spec(40_000), None);
        assert_eq!(diagnostics.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0522"]);
    }

    #[test]
    fn a_minibatch_is_a_part_of_a_rollout() {
        let text = "[learn]\nrollout = 512\nminibatch = 1024\nenvironments = 8";
        assert_eq!(found(batches_divide_the_rollout, text, None).len(), 1);
    }

    #[test]
    fn a_training_that_a_whole_update_makes_much_longer_is_told() {
        let spec = |samples: u32| format!("[learn]\nrollout = 16384\nsamples = {samples}");
        let told = |samples| found(whole_updates_keep_to_the_budget, &spec(samples), None).len();
        assert_eq!([0, 1000, 16_384, 17_000, 200_000, 4_000_000].map(told), [0, 1, 0, 1, 0, 0]);
        let found = found(whole_updates_keep_to_the_budget, &spec(17_000), None);
        assert_eq!(found[0].message, "the training takes 32768 samples, not 17000: updates are whole");
    }
}
