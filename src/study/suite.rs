//! From a suite's file to its plan: every arm is checked and lowered; what arms share is stored once.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::findings::{Findings, Log};
use super::plan::{self, Reported};
use super::{Refusal, Study};
use crate::check::{self, CheckedArm, CheckedSuite};
use crate::diag::{Diagnostic, Sources, Span};
use crate::kinds::learn::Ppo;
use crate::plan::{
    self as graph, Arm, AxisRecord, PlanError, ReportedSuite, Request, Runs, Shared, SuiteRecord, lower,
    neutral, same_results,
};
use crate::robot::Robot;
use crate::spec::claim::keys;
use crate::spec::section::Header;
use crate::spec::suite::{Axis, ClaimPolicy, Suite};
use crate::spec::typed::InSection as _;
use crate::spec::{Claim, LoadOptions, Section, Table, Value};

/// Loads and checks a suite; `Err` if it has errors.
pub fn checked(path: &Path, options: &LoadOptions, log: &mut Log) -> Result<CheckedSuite, Refusal> {
    let checked = check::suite(path, options);
    log.add(Findings::of(checked.sources.clone(), checked.sink.diagnostics.clone()).in_file(path))?;
    if checked.suite.is_none() { Err(Refusal::Invalid) } else { Ok(checked) }
}

/// The plan of a suite.
pub fn read(path: &Path, options: &LoadOptions, log: &mut Log) -> Result<Study, Refusal> {
    let checked = checked(path, options, log)?;
    let Some((suite, arms)) = checked.sound() else { return Err(Refusal::Invalid) };
    let root = arms.first().and_then(|arm| arm.arm.experiment.root.as_deref());
    let project = plan::project(path, root);
    let request = plan::request(path, &project, options);
    let mut arms = lowered(suite, arms, &checked);
    arms.iter_mut().for_each(|arm| arm.request = request.clone());
    let reported = ReportedSuite { record: record(&checked, suite), fields: fields(suite, &checked.claims) };
    let located = |error: &PlanError| {
        let arm = |name: &str| checked.arms.iter().find(|arm| arm.arm.name == name);
        let place = error.place().and_then(|(name, path)| arm(name)?.arm.experiment.marks.nearest(path));
        (checked.sources.clone(), place.map(|mark| mark.key))
    };
    let reported =
        Reported { name: &suite.name, suite: Some(reported), baselines: checked.baselines.clone() };
    let planned = plan::lowered(&arms, reported, project, located, log)?;
    // With a reduced variant such claims just stay open.
    let mut same =
        if options.varies() { Vec::new() } else { same_results::claims(&planned.plan, &checked.claims) };
    if let [first, ..] = suite.profiles.as_slice() {
        let help =
            format!("the suite has profiles, under which they may differ: for example `--profile {first}`");
        same.iter_mut().for_each(|found| found.help.push(help.clone()));
    }
    same.extend(idle_axes(&checked));
    log.add(Findings::of(checked.sources.clone(), same).in_file(path))?;
    Ok(Study { profiles: suite.profiles.clone(), ..planned })
}

/// E0806 and E0816: the claims of a valid suite that compare a result with itself, by stage fingerprints.
pub fn same_results(checked: &CheckedSuite) -> Vec<Diagnostic> {
    let Some((suite, arms)) = checked.sound().filter(|_| !checked.claims.is_empty()) else {
        return Vec::new();
    };
    let plan = lower(&lowered(suite, arms, checked), None);
    plan.map_or_else(|_| Vec::new(), |plan| same_results::claims(&plan, &checked.claims))
}

/// W0701: axes that change no stage of any arm, although another key is not what overrides them (W0524).
pub fn idle_axes(checked: &CheckedSuite) -> Vec<Diagnostic> {
    let Some((suite, arms)) = checked.sound().filter(|_| checked.arms.len() > 1) else { return Vec::new() };
    let told = checked.sink.diagnostics.iter().filter(|found| found.code == "W0524");
    let told: Vec<Span> = told.flat_map(|found| &found.labels).map(|label| label.span).collect();
    let is_told = |axis: &Axis| {
        let mut places = axis.points.iter().map(|point| point.place);
        places.any(|place| told.iter().any(|span| span.source == place.source && span.start == place.start))
    };
    let sweep = &suite.sweep;
    let alone = (0..sweep.axes.len()).filter(|axis| !sweep.zips.iter().any(|zip| zip.contains(axis)));
    let groups: Vec<Vec<usize>> = alone.map(|axis| vec![axis]).chain(sweep.zips.iter().cloned()).collect();
    let names = groups.iter().map(|group| group.iter().map(|axis| sweep.axes[*axis].name.clone()).collect());
    let names: Vec<Vec<String>> = names.collect();
    let idle_of = |arms: &[CheckedArm], names: &[Vec<String>]| {
        let mut lowered = lowered(suite, arms, checked);
        for arm in &mut lowered {
            neutral::remove_overridden(&mut arm.fields);
            arm.runs.iter_mut().for_each(|runs| runs.seeds.truncate(1));
        }
        lower(&lowered, None).map_or_else(|_| Vec::new(), |plan| graph::idle_axes(&plan, names))
    };
    // Nearly every axis has two arms that differ, and lowering all arms takes long.
    let may_be_idle = |names: &Vec<String>| {
        let pair = first_pair(arms, names);
        pair.is_some_and(|pair| !idle_of(&pair, std::slice::from_ref(names)).is_empty())
    };
    let (groups, names): (Vec<_>, Vec<_>) =
        groups.into_iter().zip(names).filter(|(_, names)| may_be_idle(names)).unzip();
    if groups.is_empty() {
        return Vec::new();
    }
    let idle = idle_of(arms, &names).into_iter().map(|index| &groups[index]);
    let idle = idle.filter(|group| !group.iter().any(|axis| is_told(&sweep.axes[*axis])));
    idle.filter_map(|group| {
        let axis = &sweep.axes[group[0]];
        let message =
            format!("the axis `{}` has no effect: all its points are the same experiment", axis.name);
        let allowed = arms.first().is_some_and(|arm| arm.arm.experiment.allow.contains_key("W0701"));
        let help = "vary a key that a stage reads and that no other key overrides, or remove the axis";
        let warning = Diagnostic::warning("W0701", message).at(axis.place, "no stage differs").help(help);
        (!allowed).then_some(warning)
    })
    .collect()
}

/// The first and the last of the first arms that differ from each other in these axes only.
fn first_pair(arms: &[CheckedArm], axes: &[String]) -> Option<[CheckedArm; 2]> {
    let mut rows: BTreeMap<Vec<&(String, String)>, (usize, usize)> = BTreeMap::new();
    for (index, arm) in arms.iter().enumerate() {
        let others = arm.arm.points.iter().filter(|(axis, _)| !axes.contains(axis)).collect();
        rows.entry(others).or_insert((index, index)).1 = index;
    }
    let (first, last) = rows.into_values().filter(|(first, last)| first < last).min()?;
    Some([first, last].map(|index| arms[index].clone()))
}

/// Axes and seeds, for the plan and the report.
pub fn record(checked: &CheckedSuite, suite: &Suite) -> SuiteRecord {
    let axis = |axis: &crate::spec::suite::Axis| AxisRecord {
        name: axis.name.clone(),
        points: axis.points.iter().map(|point| point.name.clone()).collect(),
    };
    let seeds = suite.sweep.seeds.iter().flatten().map(|(seed, _)| *seed).collect();
    SuiteRecord {
        name: suite.name.clone(),
        axes: suite.sweep.axes.iter().map(axis).collect(),
        arms: checked.arms.len(),
        seeds,
        claims: checked.claims.clone(),
        claims_count: suite.policy == ClaimPolicy::Count,
    }
}

/// The fields of the suite that the report needs.
fn fields(suite: &Suite, claims: &[Claim]) -> Table {
    let text = |text: &String| Value::Text(text.clone());
    let own = [(Header::name.name, text(&suite.name)), (Header::summary.name, text(&suite.summary))];
    let mut fields: Table = own.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
    if !claims.is_empty() {
        let claims = claims.iter().map(|claim| Value::Table(claim.fields.clone())).collect();
        fields.insert(keys::Claim::SECTION.to_owned(), Value::List(claims));
    }
    fields.insert("report".to_owned(), Value::Table(suite.report.clone()));
    fields
}

/// `sweep.seeds, specs/studies/x.toml:5`
fn seed_origin(suite: &Suite, checked: &CheckedSuite) -> Option<String> {
    let (_, place) = suite.sweep.seeds.as_ref()?.first()?;
    let [start, _] = checked.sources.positions(*place);
    Some(format!("sweep.seeds, {}:{}", checked.sources.get(place.source).name.display(), start.line))
}

/// Converts the arms of a suite for the plan; robots and motions shared by arms are converted once.
pub fn lowered(suite: &Suite, arms: &[CheckedArm], checked: &CheckedSuite) -> Vec<Arm> {
    let mut lowering =
        Lowering { suite, sources: &checked.sources, seeds: seed_origin(suite, checked), robots: Vec::new() };
    arms.iter().filter_map(|arm| lowering.arm(arm)).collect()
}

struct Lowering<'a> {
    suite: &'a Suite,
    sources: &'a Sources,
    seeds: Option<String>,
    robots: Vec<(Arc<Robot>, Shared<serde_json::Value>)>,
}

impl Lowering<'_> {
    fn arm(&mut self, checked: &CheckedArm) -> Option<Arm> {
        let experiment = &checked.arm.experiment;
        let seeds = match self.suite.sweep.seeds_of(&checked.arm.points) {
            Some(seeds) => seeds,
            None => Section::new(&experiment.table).at(Ppo::seed).into_iter().collect(),
        };
        let robot = |robot: &Robot| serde_json::to_value(robot).expect("a robot is plain data");
        Some(Arm {
            name: checked.arm.name.clone(),
            fields: experiment.table.clone(),
            origins: experiment.origin_texts(self.sources),
            robot: known(&mut self.robots, checked.robot.as_ref()?, robot),
            motion: checked.motion.clone().map(Shared::from),
            request: Request::default(),
            allow: experiment.allow.clone(),
            runs: Some(Runs { points: checked.arm.points.clone(), seeds, origin: self.seeds.clone() }),
        })
    }
}

/// Converts a value, or returns the earlier conversion of it.
fn known<T, U: Clone>(
    made: &mut Vec<(Arc<T>, Shared<U>)>,
    value: &Arc<T>,
    make: impl Fn(&T) -> U,
) -> Shared<U> {
    if let Some((_, known)) = made.iter().find(|(of, _)| Arc::ptr_eq(of, value)) {
        return known.clone();
    }
    let new = Shared::from(make(value));
    made.push((value.clone(), new.clone()));
    new
}
