//! What the stages of a plan that must run will take: their work, at the rates of finished stages of the same
//! kind, engine and robot in the store, or else at those of the project's own page.
//! Trainings and fine-tunings count as one kind, evaluations and transfers as another.

use std::collections::{BTreeMap, BTreeSet};

use super::manifest::Manifest;
use super::store::Store;
use crate::bounded;
use crate::evaluate::protocol::Protocol;
use crate::kinds::action::Position;
use crate::kinds::deploy::Transfer;
use crate::kinds::evaluate::Setting;
use crate::kinds::physics::Physics;
use crate::kinds::pretrain::Pretraining;
use crate::kinds::task::Task;
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::height_field::HeightField;
use crate::plan::expected::Expected;
use crate::plan::why::State;
use crate::plan::{Fingerprint, Plan, Stage, StageKind, budgets, render};
use crate::sim::{EngineFacts, EngineName};
use crate::spec::Section;
use crate::spec::typed::Declared;

/// Source of the rates that are used where the store has no measurement.
const PAGE: &str = "docs/experiments/2026-11-26-batch-engine-speed.md";
/// How many finished stages of a kind are read.
const READ: usize = 256;
/// CPU time in us of a training sample besides its physics: the learner, inference, observations, rewards.
const SAMPLE_US: f64 = 29.0;
/// The same of a control step of an evaluation, which has no learner.
const CONTROL_US: f64 = 8.0;
/// The same of a sample in a pass of a pre-training.
const PASS_US: f64 = 4.9;

/// Stages whose costs are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Family {
    Pretraining,
    Training,
    Evaluation,
}

impl Family {
    fn of(kind: StageKind) -> Option<Self> {
        match kind {
            StageKind::Pretrain => Some(Self::Pretraining),
            StageKind::Learner | StageKind::FineTune => Some(Self::Training),
            StageKind::Evaluate | StageKind::Transfer => Some(Self::Evaluation),
            _ => None,
        }
    }

    /// Its name, and what is counted.
    fn words(self) -> [&'static str; 2] {
        match self {
            Self::Pretraining => ["pre-training", "sample and pass"],
            Self::Training => ["training", "sample"],
            Self::Evaluation => ["evaluation", "control step"],
        }
    }
}

/// The work of a stage.
#[derive(Clone, Debug, PartialEq)]
struct Work {
    family: Family,
    robot: String,
    /// `None` for pre-trainings.
    engine: Option<EngineName>,
    /// Physics steps per control step.
    substeps: f64,
    /// Whether the ground is a height field, whose contacts take most of the time.
    is_on_field: bool,
    /// Number of samples, passes of samples, or control steps.
    amount: f64,
}

impl Work {
    /// The work of a stage in this environment, on this robot.
    fn of(stage: &Stage, env: Option<&Stage>, robot: &str) -> Option<Self> {
        let family = Family::of(stage.kind)?;
        let fields = Section::new(&stage.fields);
        let robot = robot.to_owned();
        if family == Family::Pretraining {
            let pretraining: Pretraining = fields.part()?;
            let lesson = pretraining.lesson();
            let amount = lesson.samples as f64 * lesson.epochs as f64;
            let (engine, substeps, is_on_field) = (None, 0.0, false);
            return Some(Self { family, robot, engine, substeps, is_on_field, amount });
        }
        let world = Section::new(&env?.fields);
        let (control, physics) = (world.at(Position::rate)?, world.at(Physics::rate)?);
        let steps = |section: &str| {
            let protocol = Protocol::known(fields.section(section)?)?;
            let limit = protocol.time_limit.or_else(|| Some(world.part::<Task>()?.episode()))?;
            Some(protocol.conditions.len() as f64 * limit * control)
        };
        let usual = world.at(Physics::engine);
        let (engine, physics, amount) = match stage.kind {
            StageKind::Evaluate => (
                fields.at(Setting::engine).or(usual),
                fields.at(Setting::rate).unwrap_or(physics),
                steps("evaluate")?,
            ),
            StageKind::Transfer => {
                (fields.at(Transfer::engine), fields.at(Transfer::rate).unwrap_or(physics), steps("deploy")?)
            }
            _ => (usual, physics, budgets::samples(stage)? as f64),
        };
        let ground = world.within::<Ground>().and_then(|ground| ground.kind());
        let is_on_field = ground == Some(HeightField::KIND.name);
        Some(Self { family, robot, engine, substeps: physics / control, is_on_field, amount })
    }

    fn is_like(&self, other: &Self) -> bool {
        let key = |work: &Self| (work.family, work.engine, work.is_on_field);
        self.robot == other.robot && key(self) == key(other)
    }

    /// CPU time in s per unit of work by the project's own measurements.
    fn usual_rate(&self) -> f64 {
        let step = |facts: &EngineFacts| if self.is_on_field { facts.field_step_us } else { facts.step_us };
        let physics = self.engine.map_or(0.0, |engine| self.substeps * step(engine.facts()));
        let rest = match self.family {
            Family::Pretraining => PASS_US,
            Family::Training => SAMPLE_US,
            Family::Evaluation => CONTROL_US,
        };
        1e-6 * (rest + physics)
    }
}

/// A finished stage.
#[derive(Clone, Debug)]
struct Measured {
    work: Work,
    cpu_s: f64,
}

/// CPU time in s per unit of work, and how many finished stages it is the mean of; zero if it is not from the
/// store. Stages of the same physics rate go before others.
fn rate(work: &Work, measured: &[Measured]) -> (f64, usize) {
    let like: Vec<&Measured> = measured.iter().filter(|other| other.work.is_like(work)).collect();
    let same: Vec<&Measured> =
        like.iter().filter(|other| other.work.substeps == work.substeps).copied().collect();
    let used = if same.is_empty() { like } else { same };
    let amount: f64 = used.iter().map(|other| other.work.amount).sum();
    match amount > 0.0 {
        true => (used.iter().map(|other| other.cpu_s).sum::<f64>() / amount, used.len()),
        false => (work.usual_rate(), 0),
    }
}

/// The expected times of the stages that are not in the store.
pub fn expected(store: &Store, plan: &Plan, statuses: &render::Statuses) -> Expected {
    let open = plan.stages().filter(|stage| statuses[&stage.fingerprint].state != State::Cached);
    let work = |stage: &Stage| {
        let input = |of: &Stage, kind| {
            plan.inputs(of).into_iter().map(|(input, _)| input).find(|input| input.kind == kind)
        };
        let env = input(stage, StageKind::Env);
        let robot = input(env.unwrap_or(stage), StageKind::Robot)?;
        Work::of(stage, env, &name(robot)?)
    };
    let open: Vec<(&Fingerprint, Work)> =
        open.filter_map(|stage| Some((&stage.fingerprint, work(stage)?))).collect();
    let families: Vec<Family> = open.iter().map(|(_, work)| work.family).collect();
    let measured = if open.is_empty() { Vec::new() } else { finished(store, &families) };
    let mut expected = Expected::default();
    let (mut own, mut usual) = (BTreeSet::new(), BTreeSet::new());
    for (key, work) in open {
        let (rate, count) = rate(&work, &measured);
        expected.seconds.insert(key.clone(), rate * work.amount);
        let lines = if count > 0 { &mut own } else { &mut usual };
        lines.insert(line(&work, rate, count));
    }
    let source = format!("rates not measured in this store are from {PAGE}");
    let source = Some(source).filter(|_| !usual.is_empty());
    expected.rates = own.into_iter().chain(usual).chain(source).collect();
    expected
}

/// `training: 55.3 us per sample in batch on atlas (2 finished in this store)`
fn line(work: &Work, rate: f64, count: usize) -> String {
    let [family, unit] = work.family.words();
    let engine = work.engine.map(|engine| format!(" in {}", engine.word())).unwrap_or_default();
    let ground = if work.is_on_field { " on a height field" } else { "" };
    let source = match count {
        0 => " (not measured in this store)".to_owned(),
        count => format!(" on {} ({count} finished in this store)", work.robot),
    };
    format!("{family}: {:.1} us per {unit}{engine}{ground}{source}", 1e6 * rate)
}

/// The finished stages of these families in the store, as far as their robots and engines are known.
fn finished(store: &Store, families: &[Family]) -> Vec<Measured> {
    let mut inputs: BTreeMap<Fingerprint, Option<Stage>> = BTreeMap::new();
    let mut input = |kind: StageKind, of: &Stage| {
        let key = of.recipe.inputs.get(kind.name())?;
        let read = || Some(store.manifest(kind, key).ok()??.stage);
        inputs.entry(key.clone()).or_insert_with(read).clone()
    };
    let kinds = StageKind::ALL
        .into_iter()
        .filter(|kind| Family::of(*kind).is_some_and(|family| families.contains(&family)));
    let mut found = Vec::new();
    for (kind, key) in
        kinds.flat_map(|kind| store.keys(kind).into_iter().take(READ).map(move |key| (kind, key)))
    {
        let Ok(Some(manifest)) = store.manifest(kind, &key) else { continue };
        let env = input(StageKind::Env, &manifest.stage);
        let robot = input(StageKind::Robot, env.as_ref().unwrap_or(&manifest.stage));
        let work = robot.and_then(|robot| Work::of(&manifest.stage, env.as_ref(), &name(&robot)?));
        if let Some(work) = work.filter(|work| work.amount > 0.0) {
            let cpu_s = cpu_s(store, &manifest, work.amount);
            found.push(Measured { work, cpu_s });
        }
    }
    found
}

/// The name of a robot's model.
fn name(robot: &Stage) -> Option<String> {
    Some(robot.recipe.content.get("name")?.as_str()?.to_owned())
}

/// The CPU time of a finished stage; of a training that continued a shorter one, of both.
fn cpu_s(store: &Store, manifest: &Manifest, amount: f64) -> f64 {
    let folder = store.folder(manifest.stage.kind, &manifest.stage.fingerprint);
    let summary = bounded::text(&folder.join("summary.json"), bounded::RECORD).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap_or_default();
    let per_sample = summary["cpu_us_per_sample"].as_f64();
    per_sample.map_or(manifest.provenance.cpu_s, |us| 1e-6 * us * amount)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn training(robot: &str, substeps: f64) -> Work {
        let (family, engine) = (Family::Training, Some(EngineName::Batch));
        Work { family, robot: robot.into(), engine, substeps, is_on_field: false, amount: 1e6 }
    }

    #[test]
    fn measured_rates_go_before_the_projects_own_and_those_of_the_same_physics_rate_first() {
        let measured = |work: Work, cpu_s| Measured { work, cpu_s };
        let known = [
            measured(training("atlas", 4.0), 50.0),
            measured(training("atlas", 4.0), 70.0),
            measured(training("g1", 8.0), 90.0),
        ];
        assert_eq!(rate(&training("atlas", 4.0), &known), (60e-6, 2));
        assert_eq!(rate(&training("g1", 4.0), &known), (90e-6, 1));
        let (own, count) = rate(&training("tocabi", 2.0), &known);
        assert!((own - 34e-6).abs() < 1e-9 && count == 0, "33.7 us were measured: {own}");
        let on_field = Work { is_on_field: true, ..training("atlas", 4.0) };
        let (rate_on_field, count) = rate(&on_field, &known);
        assert!(rate_on_field > 2.0 * own && count == 0, "a field takes longer: {rate_on_field}");
        let evaluation = Work { family: Family::Evaluation, ..training("atlas", 4.0) };
        assert_eq!(rate(&evaluation, &known).1, 0);
        let told = line(&training("atlas", 4.0), 60e-6, 2);
        assert_eq!(told, "training: 60.0 us per sample in batch on atlas (2 finished in this store)");
    }
}
