//! Semantic rules over a decoded spec and its robot, one file each. No simulator, no libtorch.
//!
//! A rule ignores absent values: a value that failed to decode is absent, and has been reported already.

mod applicable;
mod arms;
mod attached;
mod baseline;
mod budget;
mod cells;
mod chain;
mod checked;
mod checker;
pub mod claims;
mod conditions;
mod contact_time;
mod corners;
mod delay;
mod device;
mod exports;
mod field;
mod figures;
mod fine_tuning;
mod gains;
mod height;
mod judging;
mod limits;
mod motion_kind;
mod negligible;
mod observation;
mod odd;
mod once;
mod overridden;
mod parents;
mod phase;
mod plausible;
mod profiled;
mod rates;
mod reference;
mod relative;
mod robots;
mod scales;
mod scheduled;
mod seeds;
mod selectors;
mod servo;
mod signals;
mod simulated;
mod softness;
mod steps;
mod subject;
mod suite;
mod symmetry;
mod terms;
mod weights;

pub use checked::{Checked, CheckedArm, checked, checked_in, unrunnable};
pub use checker::Checker;
pub use robots::issue;
pub use subject::Subject;
pub use suite::{CheckedSuite, suite, suite_in};

use crate::diag::Sink;
use crate::sim::EngineName;

/// Applies every rule.
pub fn check(subject: &Subject, sink: &mut Sink) {
    for rule in RULES {
        rule(subject, sink);
    }
}

/// Applies the rules on the events and the time limit of one evaluation, the table at this path.
pub fn evaluation(subject: &Subject, path: &str, sink: &mut Sink) {
    steps::time_limit_is_whole_steps(subject, path, sink);
    scheduled::evaluated_events_are_within_the_episode(subject, path, sink);
}

/// Applies the rules on the ground and the physics rate of one evaluation by options, the table at this path,
/// which runs in these engines.
pub fn evaluation_in(subject: &Subject, path: &str, engines: &[EngineName], sink: &mut Sink) {
    for engine in engines {
        contact_time::contact_is_slower_than_steps(subject, path, *engine, false, sink);
    }
    // A rate that is too low is to be raised to a suitable one.
    if !sink.diagnostics.iter().any(|found| found.code == "E0521") {
        rates::rates_divide_that_of_an_evaluation(subject, path, sink);
    }
    // A ground is reported once.
    engines.iter().find_map(|engine| cells::cells_are_small(subject, path, *engine, sink));
}

/// The rules in the order in which they report.
const RULES: &[fn(&Subject, &mut Sink)] = &[
    rates::rates_divide_the_physics_rate,
    steps::times_are_whole_steps,
    scheduled::events_are_within_the_episode,
    delay::delays_fit_the_history,
    signals::terms_find_their_signals,
    selectors::selectors_match,
    observation::joints_are_measured_once,
    observation::scales_fit_the_joints,
    phase::phase_actions_are_there,
    field::fields_have_cells,
    conditions::conditions_can_be_listed,
    budget::batches_divide_the_rollout,
    fine_tuning::policies_are_trained,
    fine_tuning::fine_tuning_weighs_terms,
    fine_tuning::fine_tuning_changes_the_world,
    budget::the_actor_has_its_turn,
    budget::the_stop_comes_after_an_update,
    budget::the_stop_comes_before_the_end,
    budget::whole_updates_keep_to_the_budget,
    device::devices_suit_the_backend,
    limits::exploration_stays_within_limits,
    gains::servos_move_their_joints,
    servo::servos_bear_their_delay,
    weights::weights_are_not_zero,
    weights::weights_are_positive,
    weights::no_weight_dominates,
    scales::scales_are_moderate,
    contact_time::contacts_are_slower_than_steps,
    softness::soft_contacts_support_the_feet,
    cells::cells_are_small_for_the_soles,
    negligible::values_have_an_effect,
    plausible::values_are_plausible,
];
