//! The training loop: alternates rollouts and updates, with metrics, checkpoints and interruption.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::ScopedJoinHandle;
use std::time::{Duration, Instant};

use super::beside::{Beside, EVENTS, METRICS};
use super::checkpoint::{Checkpoint, Progress, replace};
use super::clock::{Clock, timed};
use super::dump::{Broken, kept};
use super::error::LearnError;
use super::health::measure::measure;
use super::health::{Monitor, Norms};
use super::inference::Inference;
use super::journal::Journal;
use super::lane::{Episode, Lane, NotANumber, Records, Squad, Tally};
use super::metrics::{Names, Summary, UpdateMetrics, explained_variance};
use super::network::Network;
use super::pace::Pace;
use super::ppo::{Improve, Outcome, Place, Unfinished, check_backend, learner};
use super::rollout::{Halt, Policy, collect};
use super::settings::Settings;
use super::tensorboard::{self, EventFile};
use crate::bounded;
use crate::crash;
use crate::env::{Crew, View};
use crate::finite;
use crate::stream::Stream;

/// The episode that ended a training, in the scratch folder.
const BROKEN: &str = "broken_episode.json";

/// Observes a training and may end it.
pub trait Watch: Sync {
    /// Called after each update.
    fn update(&self, metrics: &UpdateMetrics);
    /// Called when a file of an interrupted training was changed or lost and is rebuilt.
    fn rebuilt(&self, _file: &str) {}
    /// Called after each update and frequently in between, on every thread. If it returns true, the training
    /// discards the unfinished update, writes a checkpoint of the last finished one, and ends.
    fn interrupted(&self) -> bool;
}

/// Inputs of a training other than its environments.
#[derive(Clone, Copy)]
pub struct Training<'a> {
    /// All numbers.
    pub settings: &'a Settings,
    /// The initial networks.
    pub start: Start<'a>,
    /// An existing folder for checkpoint and metrics. A checkpoint in it is resumed.
    pub scratch: &'a Path,
    /// Number of threads, asked before each update; the result does not depend on it.
    pub threads: &'a (dyn Fn() -> usize + Sync),
    /// Observer of the training.
    pub watch: &'a dyn Watch,
}

/// The initial networks of a training; a missing one is random. Both begin with fresh moments of Adam.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start<'a> {
    /// The pre-trained actor, or that of the training to be fine-tuned.
    pub actor: Option<&'a Network>,
    /// The critic of the training to be fine-tuned.
    pub critic: Option<&'a Network>,
}

/// Result of a training.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The policy's mean.
    pub actor: Network,
    /// The critic.
    pub critic: Network,
    /// Summary of the training.
    pub summary: Summary,
    /// `metrics.jsonl` in the scratch folder.
    pub metrics: PathBuf,
    /// The TensorBoard events.
    pub events: PathBuf,
    /// The first episodes in which the simulation diverged, in the scratch folder.
    pub exploded: Vec<PathBuf>,
    /// The checkpoint in the scratch folder if the training ended before its schedule.
    pub checkpoint: Option<PathBuf>,
}

impl Trained {
    /// Writes `actor.safetensors`, `critic.safetensors`, `metrics.jsonl`, TensorBoard's events,
    /// `summary.json`, the exploded episodes and the checkpoint, if there is one, into a folder.
    pub fn save(&self, folder: &Path) -> Result<(), LearnError> {
        replace(&folder.join("actor.safetensors"), &self.actor.to_safetensors("actor"))?;
        replace(&folder.join("critic.safetensors"), &self.critic.to_safetensors("critic"))?;
        for path in self.exploded.iter().chain([&self.metrics, &self.events]).chain(&self.checkpoint) {
            let bytes = bounded::bytes(path, bounded::ARTEFACT)
                .map_err(|error| LearnError::at(path)(error.into()))?;
            replace(&folder.join(path.file_name().expect("a file has a name")), &bytes)?;
        }
        let summary = finite::to_string_pretty(&self.summary);
        let summary = summary.map_err(|found| LearnError::not_finite("summary.json", found))?;
        replace(&folder.join("summary.json"), summary.as_bytes())
    }
}

/// Trains a policy. `crews` have [`Settings::environments`] equal environments in total.
pub fn train(training: Training, crews: Vec<Box<dyn Crew>>) -> Result<Trained, LearnError> {
    let mut session = Session::start(training, crews)?;
    let end = training.settings.end();
    while session.progress.update < end {
        let metrics = match session.update() {
            Err(LearnError::Interrupted) => {
                session.save_last()?;
                return Err(LearnError::Interrupted);
            }
            metrics => metrics?,
        };
        training.watch.update(&metrics);
        let (done, stop) = (session.progress.update, training.watch.interrupted());
        if done < end && (stop || done.is_multiple_of(training.settings.checkpoint_every)) {
            session.save()?;
        }
        if done < end && stop {
            return Err(LearnError::Interrupted);
        }
    }
    if end < training.settings.updates() {
        // A longer training with the same schedule resumes from it.
        session.save()?;
    }
    session.finish()
}

/// A training in memory.
struct Session<'a> {
    training: Training<'a>,
    squads: Vec<Squad>,
    learner: Box<dyn Improve>,
    networks: [Network; 2],
    names: Names,
    journal: Journal,
    events: EventFile,
    monitor: Monitor,
    progress: Progress,
    clock: Clock,
    /// Number of updates in the checkpoint in the scratch folder; zero without one.
    saved: u64,
}

impl<'a> Session<'a> {
    fn start(training: Training<'a>, crews: Vec<Box<dyn Crew>>) -> Result<Self, LearnError> {
        let settings = training.settings;
        check(training, &crews)?;
        check_backend(settings.backend, settings.device)?;
        let view = crews[0].view(0);
        let names = names(view);
        let checkpoint = Checkpoint::load(training.scratch, settings, view.sizes())?;
        let path = training.scratch.join(METRICS);
        let progress = checkpoint
            .as_ref()
            .map_or(Progress { rate: settings.rate.start(), ..Progress::default() }, |c| c.progress);
        let journal = Journal::open(path, progress.lines)?;
        let kept = beside(checkpoint.as_ref(), training)?;
        let mut clock = Clock::resumed(progress.wall, progress.cpu);
        let known = journal.all()?;
        let events = EventFile::open(training.scratch, &known, progress.wall, kept)?;
        let mut monitor = Monitor::new(Norms::new(settings, view));
        known.iter().for_each(|metrics| drop(monitor.observe(metrics)));
        let (networks, learner, squads) = match checkpoint {
            Some(Checkpoint { trainees, episodes, .. }) => {
                let (squads, cpu) = replay(Squad::all(crews, settings), episodes, training)?;
                clock.cpu += cpu;
                let learner = resumed(&trainees, progress.rate, training)?;
                (trainees.map(|(network, _)| network), learner, squads)
            }
            None => {
                let networks = initial(training, view);
                let learner = learner(networks.each_ref(), settings)?;
                (networks, learner, Squad::begun(crews, settings))
            }
        };
        let saved = progress.update;
        Ok(Self {
            training,
            squads,
            learner,
            networks,
            names,
            journal,
            events,
            monitor,
            progress,
            clock,
            saved,
        })
    }

    /// The lanes of all environments, in the order of their indices.
    fn lanes(&self) -> impl Iterator<Item = &Lane> {
        lanes(&self.squads)
    }

    /// One rollout and one update.
    fn update(&mut self) -> Result<UpdateMetrics, LearnError> {
        let watch = self.training.watch;
        let pace = Pace { threads: (self.training.threads)().max(1), stop: &|| watch.interrupted() };
        let start = Instant::now();
        let update = self.progress.update;
        let share = update as f64 / self.training.settings.updates() as f64;
        let settings = &self.training.settings.exploring(share);
        let [actor, critic] = self.networks.each_ref().map(Inference::new);
        let policy = Policy { actor: &actor, critic: &critic, update };
        let spent = collect(&mut self.squads, policy, settings, pace).map_err(|halt| match halt {
            Halt::Fault(fault) => self.dump(fault),
            Halt::Interrupted => LearnError::Interrupted,
        })?;
        self.clock.cpu += spent.all;
        let view = self.squads[0].crew.view(0);
        let mut tally = self.squads[0].lanes[0].tally.clone();
        self.lanes().skip(1).for_each(|lane| tally.add(&lane.tally));
        self.keep_exploded(&tally)?;
        let records: Vec<&Records> = lanes(&self.squads).map(|lane| &lane.records).collect();
        let mut measured =
            UpdateMetrics { explained_variance: explained_variance(&records), ..self.of_rollout(&tally) };
        measure(&mut measured, &records, view.outputs(), &settings.std, &actor);
        let place = Place { update, share };
        let outcome = match self.learner.improve(&records, settings, place, pace) {
            Err(Unfinished::Diverged) => return Err(LearnError::Gradient { update }),
            Err(Unfinished::Interrupted) => return Err(LearnError::Interrupted),
            Ok(outcome) => outcome,
        };
        self.networks = self.learner.networks();
        self.clock.cpu += outcome.cpu.iter().sum::<f64>();
        if let Some(name) = ["actor", "critic"]
            .iter()
            .zip(&self.networks)
            .find_map(|(n, net)| (!net.is_finite()).then_some(n))
        {
            return Err(LearnError::Diverged {
                update,
                what: format!("a weight of the {name} is not a number"),
            });
        }
        self.progress.update += 1;
        let samples_per_s = settings.batch() as f64 / start.elapsed().as_secs_f64().max(1e-9);
        let mut metrics = UpdateMetrics { samples_per_s, ..self.metrics(measured, outcome) };
        finite::check(&metrics).map_err(|found| LearnError::Diverged { update, what: found.to_string() })?;
        metrics.warnings = self.monitor.observe(&metrics);
        self.journal.add(&metrics)?;
        self.events.add(&metrics)?;
        Ok(metrics)
    }

    fn of_rollout(&self, tally: &Tally) -> UpdateMetrics {
        UpdateMetrics::of_rollout(tally, &self.names, self.training.settings)
    }

    /// The metrics of a rollout with those of the update that learned from it.
    fn metrics(&self, measured: UpdateMetrics, outcome: Outcome) -> UpdateMetrics {
        let settings = self.training.settings;
        let samples = self.samples();
        UpdateMetrics {
            update: self.progress.update - 1,
            samples,
            samples_total: settings.updates() * settings.batch() as u64,
            simulated_s: samples as f64 * settings.step,
            wall_s: self.clock.wall(),
            cpu_s: self.clock.cpu,
            learner_cpu_s: outcome.cpu.iter().sum(),
            kl: outcome.divergence,
            clip_fraction: outcome.clip_fraction,
            value_loss: outcome.value_loss,
            learning_rate: outcome.rate,
            epochs: outcome.epochs,
            actor_gradient_norm: outcome.actor_norm,
            critic_gradient_norm: outcome.critic_norm,
            ..measured
        }
    }

    fn samples(&self) -> u64 {
        self.progress.update * self.training.settings.batch() as u64
    }

    /// Writes a checkpoint of the last finished update, during the next one.
    fn save_last(&mut self) -> Result<(), LearnError> {
        if self.progress.update == self.saved {
            return Ok(());
        }
        self.save_with(self.lanes().map(Lane::at_start).collect())
    }

    /// Writes a checkpoint after an update.
    fn save(&mut self) -> Result<(), LearnError> {
        self.save_with(self.lanes().map(|lane| lane.episode.clone()).collect())
    }

    fn save_with(&mut self, episodes: Vec<Episode>) -> Result<(), LearnError> {
        self.journal.sync()?;
        self.events.sync()?;
        let scratch = self.training.scratch;
        let beside = Beside::of(scratch).map_err(LearnError::at(scratch))?;
        let progress = Progress {
            update: self.progress.update,
            rate: self.learner.rate(),
            wall: self.clock.wall(),
            cpu: self.clock.cpu,
            lines: self.journal.lines,
        };
        let [actor, critic] = self.networks.clone();
        let [of_actor, of_critic] = self.learner.moments();
        let trainees = [(actor, of_actor), (critic, of_critic)];
        Checkpoint { trainees, episodes, progress, beside }.save(scratch, self.training.settings)?;
        self.saved = progress.update;
        Ok(())
    }

    fn finish(self) -> Result<Trained, LearnError> {
        self.journal.sync()?;
        let metrics = self.training.scratch.join(METRICS);
        let last = Journal::last(&metrics, |metrics| metrics.episodes > 0);
        let summary = Summary::new(self.samples(), &self.clock, self.training.settings, last.as_ref());
        let summary = Summary { warnings: Some(self.monitor.findings().to_vec()), ..summary };
        let [actor, critic] = self.networks;
        let exploded = kept(self.training.scratch)?;
        let events = self.training.scratch.join(tensorboard::NAME);
        let is_stopped = self.progress.update < self.training.settings.updates();
        let checkpoint = is_stopped.then(|| Checkpoint::path(self.training.scratch));
        Ok(Trained { actor, critic, summary, metrics, events, exploded, checkpoint })
    }

    /// Writes an episode whose reward is NaN or infinite, so that it can be replayed.
    fn dump(&self, fault: NotANumber) -> LearnError {
        let Training { settings, scratch, .. } = self.training;
        let holds = |squad: &&Squad| squad.lanes.iter().any(|lane| lane.index == fault.environment);
        let squad = self.squads.iter().find(holds).expect("a fault names an environment of the training");
        let slot = fault.environment - squad.lanes[0].index;
        let lane = &squad.lanes[slot];
        let dump = scratch.join(BROKEN);
        let terms = Some((self.names.terms.as_slice(), squad.crew.view(slot).term_values()));
        match (Broken { terms, ..broken(lane, &lane.episode, settings) }).write(&dump) {
            Ok(()) => {
                let NotANumber { environment, episode, step } = fault;
                LearnError::Reward { environment, episode, step, dump }
            }
            Err(error) => error,
        }
    }

    /// Stores the exploded episodes of a rollout, and ends a training that cannot learn: when every finished
    /// episode has exploded, and at least as many as there are environments.
    fn keep_exploded(&self, tally: &Tally) -> Result<(), LearnError> {
        let Training { settings, scratch, .. } = self.training;
        let mut dump = None;
        let exploded = self.lanes().filter_map(|lane| Some((lane, lane.exploded.as_ref()?)));
        let exploded: Vec<_> = exploded.collect();
        for (lane, episode) in &exploded {
            let kept = broken(lane, episode, settings).keep(scratch, lane.index)?;
            dump = dump.or(kept);
        }
        let (episodes, update) = (tally.episodes, self.progress.update);
        let lost = tally.exploded() == episodes && episodes >= settings.environments as u64;
        let Some((lane, episode)) = exploded.first().filter(|_| lost) else { return Ok(()) };
        let dump = match dump {
            Some(dump) => dump,
            // Enough are stored.
            None => {
                let dump = scratch.join(BROKEN);
                broken(lane, episode, settings).write(&dump)?;
                dump
            }
        };
        Err(LearnError::Exploded { update, episodes, dump })
    }
}

fn lanes(squads: &[Squad]) -> impl Iterator<Item = &Lane> {
    squads.iter().flat_map(|squad| &squad.lanes)
}

/// Checks the files next to the checkpoint of a resumed training, and removes those that it does not list.
/// Returns how many bytes of TensorBoard's events belong to the checkpoint.
fn beside(checkpoint: Option<&Checkpoint>, training: Training) -> Result<Option<u64>, LearnError> {
    let scratch = training.scratch;
    let unknown = Beside::default();
    let known = checkpoint.map_or(&unknown, |checkpoint| &checkpoint.beside);
    let mut kept = None;
    if checkpoint.is_some() {
        let path = Checkpoint::path(scratch);
        known.check(scratch).map_err(|reason| LearnError::Checkpoint { path, reason })?;
        kept = known.events(scratch);
        if kept.is_none() {
            training.watch.rebuilt(EVENTS);
        }
    }
    known.sweep(scratch).map_err(LearnError::at(scratch))?;
    Ok(kept)
}

/// An episode of a lane in its stored form.
fn broken<'a>(lane: &Lane, episode: &'a Episode, settings: &Settings) -> Broken<'a> {
    Broken { stream: lane.stream_of(episode, settings), episode, width: settings.std.len(), terms: None }
}

/// Checks that settings, environments and initial networks fit each other.
fn check(training: Training, crews: &[Box<dyn Crew>]) -> Result<(), LearnError> {
    let Training { settings, start, .. } = training;
    let (found, asked) = (crews.iter().map(|crew| crew.count()).sum::<usize>(), settings.environments);
    if found != asked || found == 0 {
        return Err(LearnError::Shape(format!(
            "the settings ask for {asked} environments, there are {found}"
        )));
    }
    let sizes = crews[0].view(0).sizes();
    let (found, asked) = (settings.std.len(), sizes.action);
    if found != asked {
        return Err(LearnError::Shape(format!("there are {found} standard deviations for {asked} actions")));
    }
    let states = if settings.privileged { sizes.privileged } else { sizes.observation };
    fits("actor", start.actor, &settings.policy.widths(sizes.observation, sizes.action))?;
    fits("critic", start.critic, &settings.value.widths(states, 1))
}

/// Checks that an initial network has the required layers.
fn fits(name: &str, start: Option<&Network>, asked: &[usize]) -> Result<(), LearnError> {
    match start.map(Network::widths) {
        Some(found) if found != asked => Err(LearnError::Shape(format!(
            "the {name} to begin with has layers {found:?}, the spec asks for {asked:?}"
        ))),
        _ => Ok(()),
    }
}

fn names(environment: &dyn View) -> Names {
    let ends = environment.causes().iter().cloned().chain(["time_out".to_owned(), "exploded".to_owned()]);
    Names { terms: environment.terms().to_vec(), ends: ends.collect() }
}

/// The networks before the first update: actor, critic.
fn initial(training: Training, environment: &dyn View) -> [Network; 2] {
    let Training { settings, start, .. } = training;
    let sizes = environment.sizes();
    let random = |name: &str, shape: &super::settings::Shape, inputs, outputs| {
        let mut stream = Stream::new(&settings.stream(&format!("initial/{name}")));
        Network::orthogonal(&shape.widths(inputs, outputs), shape.activation, &mut stream)
    };
    let (policy, value) = (&settings.policy, &settings.value);
    let actor =
        start.actor.cloned().unwrap_or_else(|| random("actor", policy, sizes.observation, sizes.action));
    let inputs = if settings.privileged { sizes.privileged } else { sizes.observation };
    let critic = start.critic.cloned().unwrap_or_else(|| random("critic", value, inputs, 1));
    [Network { activation: policy.activation, ..actor }, Network { activation: value.activation, ..critic }]
}

/// A learner with the networks and the moments of a checkpoint.
fn resumed(
    [(actor, of_actor), (critic, of_critic)]: &[(Network, super::adam::Adam); 2],
    rate: f64,
    training: Training,
) -> Result<Box<dyn Improve>, LearnError> {
    let mut learner = learner([actor, critic], training.settings)?;
    learner.set_rate(rate);
    if learner.set_moments([of_actor, of_critic]) {
        Ok(learner)
    } else {
        Err(LearnError::Checkpoint {
            path: Checkpoint::path(training.scratch),
            reason: "its moments do not fit its networks".to_owned(),
        })
    }
}

/// Interval at which a replay checks for an interruption.
const PATIENCE: Duration = Duration::from_millis(20);

/// Brings all environments back to their running episodes, in parallel. An interruption ends it after the
/// current episodes; the checkpoint stays unchanged.
fn replay(
    squads: Vec<Squad>,
    episodes: Vec<Episode>,
    training: Training,
) -> Result<(Vec<Squad>, f64), LearnError> {
    let settings = training.settings;
    let threads = (training.threads)().max(1);
    let mut episodes = episodes.into_iter();
    let mut work: Vec<(Squad, Vec<Episode>)> = Vec::new();
    for squad in squads {
        let own = episodes.by_ref().take(squad.lanes.len()).collect();
        work.push((squad, own));
    }
    let chunk = work.len().div_ceil(threads).max(1);
    let mut chunks = Vec::new();
    while !work.is_empty() {
        let rest = work.split_off(chunk.min(work.len()));
        chunks.push(std::mem::replace(&mut work, rest));
    }
    let stop = AtomicBool::new(false);
    let stopped = || stop.load(Ordering::Relaxed);
    let again = |(squad, episodes): (Squad, _)| squad.replayed(episodes, settings, &stopped);
    let part = crash::part();
    let again = |chunk: Vec<_>| {
        timed(|| {
            part.join();
            chunk.into_iter().map(again).collect::<Option<Vec<Squad>>>()
        })
    };
    let again = &again;
    std::thread::scope(|scope| {
        let handles: Vec<_> = chunks.into_iter().map(|chunk| scope.spawn(move || again(chunk))).collect();
        loop {
            if training.watch.interrupted() {
                stop.store(true, Ordering::Relaxed);
                return Err(LearnError::Interrupted);
            }
            if handles.iter().all(ScopedJoinHandle::is_finished) {
                break;
            }
            std::thread::sleep(PATIENCE);
        }
        let mut squads = Vec::new();
        let mut cpu = 0.0;
        for handle in handles {
            let (chunk, seconds) = crash::joined(handle.join());
            squads.extend(chunk.ok_or(LearnError::Interrupted)?);
            cpu += seconds;
        }
        Ok((squads, cpu))
    })
}
