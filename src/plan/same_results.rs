//! E0806 and E0816: compared results must come from different stages, which the keys of the plan show. Two
//! arms of a suite may differ in values that the stage of a claim never reads; both then have the same
//! result.

use std::collections::BTreeMap;

use super::draft::Training;
use super::fingerprint::Fingerprint;
use super::graph::{ArmRecord, Plan};
use super::stage::StageKind;
use crate::diag::Diagnostic;
use crate::kinds::action::Action;
use crate::kinds::task::Task;
use crate::spec::claim::cases::twin;
use crate::spec::claim::{Case, Claim, Over, Points, cases, keys};
use crate::spec::section::{Header, Report};
use crate::spec::suggest::listed;
use crate::spec::typed::InSection as _;
use crate::spec::{Section, Table, Value};

/// Largest number of differing keys that a message names.
const NAMED: usize = 4;

/// Keys of a spec that affect only its name and report.
const UNREAD: [&str; 3] = [Header::name.name, Header::summary.name, Report::SECTION];

/// The claims of a suite that compare a result with itself, one error each.
pub fn claims(plan: &Plan, claims: &[Claim]) -> Vec<Diagnostic> {
    let arms = arms(plan);
    claims.iter().filter_map(|claim| Comparing { plan, arms: &arms, claim }.trouble()).collect()
}

/// Whether two specs have different tasks or action spaces. They train different policies then, so none of
/// their results is the same, and no plan is needed to know that.
pub fn train_other_policies(own: &Table, other: &Table) -> bool {
    let kinds = |spec| {
        let spec = Section::new(spec);
        [
            spec.within::<Task>().and_then(|task| task.kind()),
            spec.within::<Action>().and_then(|action| action.kind()),
        ]
    };
    kinds(own) != kinds(other)
}

/// What is wrong with a comparison of two arms of a plan: all their common results are the same. `None` if
/// one differs, or if there is nothing to compare.
pub fn specs(plan: &Plan, own: &str, other: &str) -> Option<Diagnostic> {
    let arm = |name: &str| plan.arms.iter().find(|arm| arm.name == name);
    let [own, other] = [arm(own)?, arm(other)?];
    let shared: Vec<&String> = own.stages.keys().filter(|name| other.stages.contains_key(*name)).collect();
    let shared: Vec<&String> = shared.into_iter().filter(|name| is_measured(plan, own, name)).collect();
    if shared.is_empty() || shared.iter().any(|name| own.stages[*name] != other.stages[*name]) {
        return None;
    }
    let message = format!(
        "`{}` and `{}` have the same results: every difference of the two is 0",
        own.name, other.name
    );
    let names = listed(shared.iter().map(|name| name.as_str()));
    let help = format!(
        "{}: write a value that {names} read{}, or remove the entry",
        differing(&own.fields.table(), &other.fields.table()),
        if shared.len() == 1 { "s" } else { "" }
    );
    Some(Diagnostic::error("E0816", message).help(help))
}

/// An arm of a suite with its runs by seed.
struct Runs<'a> {
    points: &'a Points,
    by_seed: BTreeMap<u64, &'a ArmRecord>,
}

/// The arms of a suite's plan, in their order.
fn arms(plan: &Plan) -> Vec<Runs<'_>> {
    let mut arms: Vec<Runs> = Vec::new();
    for record in &plan.arms {
        let Some(run) = &record.run else { continue };
        if arms.last().is_none_or(|arm| *arm.points != *run.points) {
            arms.push(Runs { points: &run.points, by_seed: BTreeMap::new() });
        }
        arms.last_mut().into_iter().for_each(|arm| {
            arm.by_seed.insert(run.seed, record);
        });
    }
    arms
}

/// Inputs of the value of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Origin<'a> {
    own: &'a Fingerprint,
    /// The baseline's stage.
    base: Option<&'a Fingerprint>,
}

/// A claim against the plan of its suite.
struct Comparing<'a> {
    plan: &'a Plan,
    arms: &'a [Runs<'a>],
    claim: &'a Claim,
}

impl<'a> Comparing<'a> {
    fn trouble(&self) -> Option<Diagnostic> {
        let points: Vec<&Points> = self.arms.iter().map(|arm| arm.points).collect();
        let cases = cases(self.claim, &points);
        let own_baseline = cases.iter().flat_map(|case| [Some(case.a), case.b]).flatten();
        own_baseline.into_iter().find_map(|arm| self.of_its_own_baseline(arm, &points)).or_else(|| {
            let same = cases.iter().find_map(|case| self.of_one_result(case, &points));
            same.or_else(|| self.counted_twice(&cases, &points))
        })
    }

    /// E0816: the baseline of an arm's runs is the metric's own stage.
    fn of_its_own_baseline(&self, arm: usize, points: &[&Points]) -> Option<Diagnostic> {
        let baseline = self.claim.baseline.as_ref()?;
        let origins = self.origins(arm, points);
        if origins.is_empty() || origins.values().any(|origin| origin.base != Some(origin.own)) {
            return None;
        }
        let value = if baseline.relative { "1" } else { "0" };
        let (stage, base, own) = (&self.claim.metric.stage, &baseline.stage, name(points[arm]));
        let key = self.claim.key_of_baseline();
        let (message, help) = match baseline.twin.as_ref().and_then(|pattern| twin(pattern, points, arm)) {
            Some(other) => (
                format!(
                    "`{stage}` of the arm `{own}` and `{base}` of its twin `{}` are one stage: the value of \
                     every run is {value}",
                    name(points[other])
                ),
                self.advice(arm, other),
            ),
            None => (
                format!(
                    "`{stage}` and its `baseline` `{base}` are one stage: the value of every run of `{own}` \
                     is {value}"
                ),
                format!("write a value in `[{base}]` that differs from `[{stage}]`, or remove `baseline`"),
            ),
        };
        Some(self.at(key, Diagnostic::error("E0816", message), "the same result").help(help))
    }

    /// E0806: both sides of a comparison have the same result.
    fn of_one_result(&self, case: &Case, points: &[&Points]) -> Option<Diagnostic> {
        let other = case.b?;
        if !self.are_alike(case.a, other, points) {
            return None;
        }
        let [own, twin] = [case.a, other].map(|arm| name(points[arm]));
        let stage = &self.claim.metric.stage;
        let message = format!("the arms `{own}` and `{twin}` have the same `{stage}`: their difference is 0");
        let error = self.at(
            keys::Claim::compare.name,
            Diagnostic::error("E0806", message),
            "one result on both sides",
        );
        Some(error.help(self.advice(case.a, other)))
    }

    /// E0806: comparisons that are counted or pooled must have different results.
    fn counted_twice(&self, cases: &[Case], points: &[&Points]) -> Option<Diagnostic> {
        let over = self.claim.over.as_ref()?;
        if !over.is_joint() && over.count().is_none() {
            return None;
        }
        let is_same = |one: usize, other: usize| one == other || self.are_alike(one, other, points);
        let sides = |first: &Case, second: &Case| {
            let b = first.b.zip(second.b).map(|(one, other)| is_same(one, other));
            [Some(is_same(first.a, second.a)), b].into_iter().flatten().collect::<Vec<bool>>()
        };
        // Pooled results must be independent, side by side; counted comparisons must differ in at least one
        // side.
        let are_same = |first: &Case, second: &Case| match over.is_joint() {
            true => sides(first, second).contains(&true),
            false => !sides(first, second).contains(&false),
        };
        let (first, second) = cases.iter().enumerate().find_map(|(place, first)| {
            let second = cases[place + 1..].iter().find(|second| are_same(first, second))?;
            Some((first, second))
        })?;
        let is_first = first.a != second.a && is_same(first.a, second.a);
        let side = |case: &Case| if is_first { case.a } else { case.b.unwrap_or(case.a) };
        let [one, other] = [first, second].map(side);
        let [one_name, other_name] = [one, other].map(|arm| name(points[arm]));
        let stage = &self.claim.metric.stage;
        let message = format!(
            "the arms `{one_name}` and `{other_name}` have the same `{stage}`, which would count twice"
        );
        let remark = match over {
            Over::AtLeast(_) | Over::AtMost(_) => "one comparison, counted twice",
            _ => "one result, taken for two",
        };
        let error = self.at(keys::Claim::over.name, Diagnostic::error("E0806", message), remark);
        Some(error.help(self.advice(one, other)).help("or name one of these arms in the claim"))
    }

    /// Whether two arms have runs with a common seed, and each such pair has the same result.
    fn are_alike(&self, one: usize, other: usize, points: &[&Points]) -> bool {
        let [one, other] = [one, other].map(|arm| self.origins(arm, points));
        let mut common = one.iter().filter_map(|(seed, own)| Some((own, other.get(seed)?))).peekable();
        common.peek().is_some() && common.all(|(own, other)| own == other)
    }

    /// The stages behind the values of an arm's runs, by seed; runs without one of the stages are left out.
    fn origins(&self, arm: usize, points: &[&Points]) -> BTreeMap<u64, Origin<'a>> {
        let baseline = self.claim.baseline.as_ref();
        let compared = match baseline.and_then(|baseline| baseline.twin.as_ref()) {
            Some(pattern) => twin(pattern, points, arm),
            None => Some(arm),
        };
        let origin = |(seed, run): (&u64, &&'a ArmRecord)| {
            let own = run.stages.get(stage_of(&self.claim.metric.stage))?;
            let base = match baseline {
                Some(baseline) => {
                    Some(self.arms[compared?].by_seed.get(seed)?.stages.get(stage_of(&baseline.stage))?)
                }
                None => None,
            };
            Some((*seed, Origin { own, base }))
        };
        self.arms[arm].by_seed.iter().filter_map(origin).collect()
    }

    /// The differences of two arms, and how to make their results differ.
    fn advice(&self, one: usize, other: usize) -> String {
        let [one, other] = [one, other].map(|arm| self.arms[arm].by_seed.values().next().copied());
        let stage = &self.claim.metric.stage;
        let (Some(one), Some(other)) = (one, other) else {
            return format!("vary a value that `{stage}` reads");
        };
        let trains =
            |name: &str| [Training::First, Training::FineTuning].iter().any(|own| own.stage() == name);
        let is_candidate = |name: &&String| {
            is_measured(self.plan, one, name)
                && trains(name) == trains(stage_of(stage))
                && other.stages.get(*name).is_some_and(|key| *key != one.stages[*name])
        };
        let others: Vec<&str> = one.stages.keys().filter(is_candidate).map(|name| written(name)).collect();
        let differing = differing(&one.fields.table(), &other.fields.table());
        let vary = format!("vary a value that `{stage}` reads");
        match others.as_slice() {
            [] => format!("{differing}: {vary}"),
            others => {
                format!(
                    "{differing}: measure a stage that reads it, {}, or {vary}",
                    listed(others.iter().copied())
                )
            }
        }
    }

    fn at(&self, key: &str, error: Diagnostic, remark: &str) -> Diagnostic {
        match self.claim.place(key) {
            Some(span) => error.at(span, remark),
            None => error,
        }
    }
}

/// The name in a plan of a claim's stage.
fn stage_of(stage: &str) -> &str {
    let trainings = [Training::First, Training::FineTuning];
    trainings.iter().find(|training| training.section() == stage).map_or(stage, |training| training.stage())
}

/// The name in a claim of a plan's stage.
fn written(stage: &str) -> &str {
    let trainings = [Training::First, Training::FineTuning];
    trainings.iter().find(|training| training.stage() == stage).map_or(stage, |training| training.section())
}

/// Whether a claim can refer to a stage of an arm: a training, an evaluation or a transfer.
fn is_measured(plan: &Plan, arm: &ArmRecord, name: &str) -> bool {
    let kind = arm.stages.get(name).and_then(|key| plan.stage(key)).map(|stage| stage.kind);
    let measured = [StageKind::Learner, StageKind::FineTune, StageKind::Evaluate, StageKind::Transfer];
    kind.is_some_and(|kind| measured.contains(&kind))
}

/// `control=torque,std=1 %`.
fn name(points: &Points) -> String {
    points.iter().map(|(axis, point)| format!("{axis}={point}")).collect::<Vec<_>>().join(",")
}

/// `they differ in `evaluate.pushed.force``.
fn differing(one: &Table, other: &Table) -> String {
    let mut paths = Vec::new();
    paths_that_differ(one, other, "", &mut paths);
    paths.retain(|path| !UNREAD.iter().any(|key| path.split('.').next() == Some(key)));
    let more = paths.len().saturating_sub(NAMED);
    let shown = listed(paths.iter().take(NAMED).map(String::as_str));
    match (paths.len(), more) {
        (0, _) => "they differ in no value that a stage reads".to_owned(),
        (_, 0) => format!("they differ in {shown}"),
        _ => format!("they differ in {shown} and {more} more"),
    }
}

fn paths_that_differ(one: &Table, other: &Table, above: &str, paths: &mut Vec<String>) {
    let mut keys: Vec<&String> = one.keys().chain(other.keys()).collect();
    keys.sort();
    keys.dedup();
    for key in keys {
        let path = if above.is_empty() { key.clone() } else { format!("{above}.{key}") };
        match (one.get(key), other.get(key)) {
            (Some(Value::Table(one)), Some(Value::Table(other))) => {
                paths_that_differ(one, other, &path, paths)
            }
            (one, other) if one != other => paths.push(path),
            _ => {}
        }
    }
}
