//! Pre-training and reinforcement learning.

use std::collections::BTreeMap;

use super::{Job, Work, WorkError, blueprint, bytes, failed, part, section};
use crate::env::{Blueprint, Mode, RobotCrew};
use crate::exec::events::Event;
use crate::kinds::fine_tune::FineTuning;
use crate::kinds::pretrain::Pretraining;
use crate::learn::finding::{Finding, cure};
use crate::learn::pretrain::{Lesson, pretrain, residual};
use crate::learn::{Network, Settings, Start, Training, UpdateMetrics, Watch, train};
use crate::robot::Robot;
use crate::sim;
use crate::spec::Section;
use crate::spec::typed::InSection;

/// `actor.safetensors` and `pretrain.json`: the actor fitted to labels.
pub struct Pretrain;

impl Work for Pretrain {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let robot: Robot = job.read("robot", "robot.json")?;
        let motion = match job.inputs.contains_key("motion") {
            true => Some(job.read("motion", "motion.json")?),
            false => None,
        };
        let threads = job.threads.now();
        let pretraining: Option<Pretraining> = Section::new(job.fields).part();
        let total = pretraining.map_or(1, |pretraining| pretraining.lesson().epochs);
        let interrupted = |share: f64| {
            let (stage, done) = (job.plan.label(job.stage), (share * total as f64).round() as u64);
            job.events.emit(Event::Progress {
                stage,
                done,
                total,
                unit: "passes".into(),
                note: String::new(),
            });
            job.interrupt.is_set()
        };
        let motion = motion.as_ref();
        let lesson = Lesson { fields: job.fields, robot: &robot, motion, threads, interrupted: &interrupted };
        let fitted = pretrain(&lesson)?;
        if let Some(message) = residual::large(&fitted.report, &robot) {
            job.finding("W0609", message, &format!("{}; `specforge explain W0609` says more", residual::FIX));
        }
        Ok(fitted.save(job.output)?)
    }
}

/// `actor.safetensors`, `critic.safetensors`, `metrics.jsonl` and `summary.json`: the trained policy.
pub struct Learner;

impl Work for Learner {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let blueprint = blueprint(job)?;
        let settings = Settings::new(&part(job)?, blueprint.deviations(), 1.0 / blueprint.control_rate());
        let pretrained = match job.inputs.contains_key("pretrain") {
            true => Some(network(job, "pretrain", "actor")?),
            false => None,
        };
        trained(job, &blueprint, &settings, Start { actor: pretrained.as_ref(), critic: None })
    }
}

/// The same files: the policy of another training, trained further in this environment.
pub struct FineTune;

impl Work for FineTune {
    fn run(&self, job: &Job) -> Result<(), WorkError> {
        let blueprint = blueprint(job)?;
        let tuning = section(job, FineTuning::SECTION)?;
        let step = 1.0 / blueprint.control_rate();
        let settings = Settings::fine_tuning(&part(job)?, tuning, blueprint.deviations(), step);
        let (actor, critic) = (network(job, "learner", "actor")?, network(job, "learner", "critic")?);
        trained(job, &blueprint, &settings, Start { actor: Some(&actor), critic: Some(&critic) })
    }
}

/// Trains, and writes the results.
fn trained(job: &Job, blueprint: &Blueprint, settings: &Settings, start: Start) -> Result<(), WorkError> {
    let training = Training {
        settings,
        start,
        scratch: job.scratch,
        threads: &|| job.threads.now(),
        watch: &Follower { job, total: settings.end() * settings.batch() as u64 },
    };
    let engine = sim::open(blueprint.engine())?;
    let scene = blueprint.scene(engine, &Mode::Training).map_err(failed)?;
    let crews = RobotCrew::divided(&scene, settings.environments, job.threads.now());
    let trained = train(training, crews)?;
    Ok(trained.save(job.output)?)
}

/// A network of an input: `actor` or `critic`.
fn network(job: &Job, role: &str, name: &str) -> Result<Network, WorkError> {
    let path = job.input(role, &format!("{name}.safetensors"))?;
    Network::from_safetensors(name, &bytes(&path)?).map_err(failed)
}

/// Reports the events of a training, and tells it when to stop.
struct Follower<'a> {
    job: &'a Job<'a>,
    total: u64,
}

impl Watch for Follower<'_> {
    fn update(&self, metrics: &UpdateMetrics) {
        let stage = self.job.plan.label(self.job.stage);
        let note = match (metrics.return_mean, metrics.length_mean_s) {
            (Some(sum), Some(length)) => format!("return {sum:.0}, episodes of {length:.1} s"),
            _ => String::new(),
        };
        let (done, total) = (metrics.samples, self.total);
        self.job.events.emit(Event::Progress {
            stage: stage.clone(),
            done,
            total,
            unit: "samples".into(),
            note,
        });
        let mut values = BTreeMap::from([
            ("update".to_owned(), metrics.update as f64),
            ("samples".to_owned(), metrics.samples as f64),
            ("kl".to_owned(), metrics.kl),
            ("clip_fraction".to_owned(), metrics.clip_fraction),
            ("explained_variance".to_owned(), metrics.explained_variance),
            ("learning_rate".to_owned(), metrics.learning_rate),
            ("samples_per_s".to_owned(), metrics.samples_per_s),
        ]);
        values.extend(metrics.return_mean.map(|value| ("return_mean".to_owned(), value)));
        values.extend(metrics.length_mean_s.map(|value| ("length_mean_s".to_owned(), value)));
        self.job.events.emit(Event::Metric { stage, values });
        self.warn(&metrics.warnings);
    }

    fn rebuilt(&self, file: &str) {
        self.job
            .warning(format!("{file} beside the checkpoint had changed; it is made again from the metrics"));
    }

    fn interrupted(&self) -> bool {
        self.job.interrupt.is_set()
    }
}

impl Follower<'_> {
    /// Reports findings, one warning per code, because neighbouring joints often share a problem.
    fn warn(&self, findings: &[Finding]) {
        for same in findings.chunk_by(|a, b| a.code == b.code) {
            let Finding { code, message, .. } = &same[0];
            let others: Vec<String> = same[1..].iter().map(|other| format!("`{}`", other.subject)).collect();
            let others =
                if others.is_empty() { String::new() } else { format!("; so are {}", others.join(", ")) };
            let help = format!("{}; `specforge explain {code}` says more", cure(code));
            self.job.finding(code, format!("{message}{others}"), &help);
        }
    }
}
