//! Checks claims against their suite: arms, metrics, tests, units and seeds (E0204, E0803 to E0807, E0816,
//! E1001, W0504, W0510, W0511, W1001 to W1004).
//!
//! Uses axes, arms and decoded specs, but no measurements.

mod arms;
mod bounds;
mod effect;
mod holm;
pub(super) mod measure;
mod power;
mod range;
mod reach;
mod resolution;
mod returns;
mod sample;
#[cfg(test)]
mod tests;
mod training;
mod trivial;
mod values;

use std::collections::BTreeMap;

use crate::diag::{Diagnostic, Sink, Span};
use crate::robot::Robot;
use crate::spec::claim::{Case, Claim, Points, keys};
use crate::spec::{Table, claim};
use crate::syntax::Node;
use sample::Lone;

/// What claims can refer to.
#[derive(Clone, Debug, Default)]
pub struct Scope<'a> {
    /// Every axis and its points, in the order of the suite.
    pub axes: Vec<(&'a str, Vec<&'a str>)>,
    /// The arms.
    pub arms: Vec<ArmScope<'a>>,
    /// Where the seeds are given.
    pub seeds: Option<Span>,
    /// Whether a failed claim fails the run: `claims = "count"`.
    pub counted: bool,
    /// Whether a profile or an argument changes the arms, for example for a quick look.
    pub shortened: bool,
}

impl<'a> Scope<'a> {
    /// The points of each arm.
    fn points(&self) -> Vec<&'a Points> {
        self.arms.iter().map(|arm| arm.points).collect()
    }
}

/// An arm of the suite.
#[derive(Clone, Copy, Debug)]
pub struct ArmScope<'a> {
    /// Its points, by axis.
    pub points: &'a Points,
    /// Its decoded spec; stages are looked up in it.
    pub fields: &'a Table,
    /// Its robot, if it could be read.
    pub robot: Option<&'a Robot>,
    /// Its number of seeds.
    pub runs: usize,
}

/// Decodes and checks the `[[claim]]` tables of a suite; returns the valid claims, in order.
pub fn claims(nodes: &[Node], scope: &Scope, sink: &mut Sink) -> Vec<Claim> {
    let decoded: Vec<Claim> = nodes.iter().filter_map(|node| claim::decode(node, sink)).collect();
    let mut names: BTreeMap<String, Span> = BTreeMap::new();
    let (mut sound, mut lone) = (Vec::new(), BTreeMap::<Lone, Vec<String>>::new());
    for claim in decoded {
        let mut own = Sink::default();
        repeated(&claim, &mut names, &mut own);
        if let Some(found) = check(&claim, scope, &mut own) {
            lone.entry(found).or_default().push(claim.id.clone());
        }
        let good = !own.has_errors();
        own.diagnostics.into_iter().for_each(|found| sink.emit(found));
        if good {
            sound.push(claim);
        }
    }
    holm::can_be_established(&sound, scope, sink);
    power::is_large_enough(&sound, scope, sink);
    let header = nodes.first().map(|node| node.span);
    lone.into_iter()
        .for_each(|(found, ids)| sink.emit(sample::one_seed(found, &ids, scope.seeds.or(header))));
    sound
}

/// Reports mistakes in claims that do not depend on the arms' specs: in keys and names, and, given a scope
/// with known axes, in the arms that they name.
pub fn alone(nodes: &[Node], axes: Option<&Scope>, sink: &mut Sink) {
    let mut names = BTreeMap::new();
    for claim in nodes.iter().filter_map(|node| claim::decode(node, sink)).collect::<Vec<_>>() {
        repeated(&claim, &mut names, sink);
        sample::statistic(&claim, sink);
        measure::metric(&claim, sink);
        if let Some(scope) = axes {
            arms::names_are_known(&claim, scope, sink);
        }
    }
}

/// Checks one claim: names before their uses, so that one cause gives one error.
fn check(claim: &Claim, scope: &Scope, sink: &mut Sink) -> Option<Lone> {
    let statistic = sample::statistic(claim, sink);
    let metric = measure::metric(claim, sink);
    let cases = arms::cases_of(claim, scope, sink)?;
    let mut lone = None;
    if let (Some(statistic), Some(metric)) = (statistic, metric) {
        sample::suits(claim, statistic, metric, sink);
        sample::states_an_effect(claim, statistic, metric, sink);
        measure::units(claim, statistic, metric, sink);
        if !sink.has_errors() {
            if bounds::assumed_values_are_possible(claim, metric, &cases, sink) {
                effect::lies_where_expected(claim, statistic, sink);
            }
            bounds::number_is_possible(claim, statistic, metric, sink);
            bounds::distances_are_possible(claim, statistic, metric, &cases, sink);
            bounds::samples_are_in_the_training(claim, statistic, metric, scope, &cases, sink);
            resolution::numbers_can_be_told_from_nothing(claim, statistic, metric, scope, &cases, sink);
        }
        lone = sample::runs(claim, statistic, scope, &cases, sink);
    }
    if let Some(metric) = metric {
        measure::produced(claim, metric, scope, &cases, sink);
        returns::measure_the_same(claim, metric, scope, &cases, sink);
        returns::are_possible(claim, metric, scope, &cases, sink);
        values::baseline_is_another_stage(claim, scope, &cases, sink);
        values::until_is_in_the_training(claim, metric, scope, &cases, sink);
    }
    if let (Some(statistic), Some(metric), false) = (statistic, metric, sink.has_errors()) {
        reach::can_be_decided(claim, metric, statistic, scope, &cases, sink);
        trivial::something_can_refute_it(claim, metric, scope, &cases, sink);
    }
    lone
}

/// E0104: two claims with the same name.
fn repeated(claim: &Claim, names: &mut BTreeMap<String, Span>, sink: &mut Sink) {
    let Some(place) = claim.place(keys::Claim::id.name) else { return };
    if let Some(first) = names.get(&claim.id) {
        let error = Diagnostic::error("E0104", format!("the claim `{}` stands twice", claim.id))
            .at(place, "again here");
        sink.emit(
            error.note(*first, "first written here").help("give it another `id`, or remove one of the two"),
        );
    } else {
        names.insert(claim.id.clone(), place);
    }
}

/// A diagnostic at a key.
fn at(claim: &Claim, key: &str, diagnostic: Diagnostic, remark: &str) -> Diagnostic {
    match claim.place(key) {
        Some(span) => diagnostic.at(span, remark),
        None => diagnostic,
    }
}

/// The arms of some cases, each once.
fn arms_in<'s>(cases: &[Case], scope: &'s Scope) -> Vec<&'s ArmScope<'s>> {
    let mut places: Vec<usize> = cases.iter().flat_map(|case| [Some(case.a), case.b]).flatten().collect();
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|place| &scope.arms[place]).collect()
}

/// `control=torque,std=1 %`.
fn name(points: &Points) -> String {
    points.iter().map(|(axis, point)| format!("{axis}={point}")).collect::<Vec<_>>().join(",")
}
