//! A lane: the running episode of one environment and what is recorded of it in one rollout. A squad: the
//! lanes of the environments that step together.

use super::advantage::{Discount, Track, estimate};
use super::settings::Settings;
use crate::env::{Crew, End, Sizes, Stance, Step, View};

/// Environments that step together, with the lane of each.
pub struct Squad {
    /// The environments.
    pub(super) crew: Box<dyn Crew>,
    /// What is recorded of each.
    pub(super) lanes: Vec<Lane>,
}

/// The running episode of one environment with the records of the current rollout. Buffers are reused between
/// rollouts; a rollout allocates only the rare bootstrap states and a growing action log.
pub struct Lane {
    /// Index of the environment among all.
    pub(super) index: usize,
    /// The running episode.
    pub(super) episode: Episode,
    /// The records, one entry (or row) per control step.
    pub records: Records,
    /// Sums over the rollout.
    pub tally: Tally,
    /// The first episode of the rollout in which the simulation diverged (NaN or infinity).
    pub(super) exploded: Option<Episode>,
    /// Where the rollout began.
    began: Began,
}

/// Where a rollout began in a running episode.
#[derive(Clone, Debug, Default)]
struct Began {
    /// That episode without its actions.
    episode: Episode,
    /// Length of its action list at that time.
    length: usize,
    /// All its actions, once it has ended.
    actions: Option<Vec<f32>>,
}

/// A running episode: what has to be stored to reach the same state by replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Episode {
    /// Number of episodes that this environment began before.
    pub number: u64,
    /// All actions of this episode, one row per control step.
    pub actions: Vec<f32>,
    /// Sum of the rewards so far.
    pub reward: f64,
    /// Control steps so far.
    pub steps: u64,
}

/// The records of a rollout in one environment; rows are control steps.
#[derive(Clone, Debug, Default)]
pub struct Records {
    /// The actor's inputs.
    pub observations: Vec<f32>,
    /// The critic's inputs.
    pub states: Vec<f32>,
    /// The sampled actions, before clipping.
    pub actions: Vec<f32>,
    /// The actor's outputs.
    pub means: Vec<f32>,
    /// Rewards, scaled for learning.
    pub rewards: Vec<f64>,
    /// The critic's values, one more than steps: the last belongs to the state after the rollout.
    pub values: Vec<f32>,
    /// For a step that ended its episode, the value of the continuation.
    pub ends: Vec<Option<f32>>,
    /// Advantages of the actions.
    pub advantages: Vec<f32>,
    /// The critic's targets.
    pub targets: Vec<f32>,
    /// Steps that ended at a time limit, with the critic's inputs at that moment in `timeout_states`.
    pub(super) timeouts: Vec<usize>,
    pub(super) timeout_states: Vec<f32>,
}

/// Sums over the control steps and the finished episodes of a rollout.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Control steps.
    pub steps: u64,
    /// Finished episodes.
    pub episodes: u64,
    /// Sum of the returns of the finished episodes.
    pub episode_reward: f64,
    /// Sum of the control steps of the finished episodes.
    pub episode_steps: u64,
    /// Sum of the rewards.
    pub reward: f64,
    /// Sum of each reward term.
    pub terms: Vec<f64>,
    /// Control steps that did not end in a failure. A failing step is paid nothing.
    pub sound: u64,
    /// Sum and sum of squares of each reward term over the sound steps.
    pub moments: Vec<[f64; 2]>,
    /// Control steps after which the foot contacts are known.
    pub stances: u64,
    /// Control steps in single support, of the robot and of the reference.
    pub single_support: [u64; 2],
    /// Number of episodes that ended by each cause, then by the time limit, then by divergence of the
    /// simulation.
    pub ends: Vec<u64>,
}

/// Position of a reward that is NaN or infinite: environment, episode, control step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotANumber {
    /// Index of the environment.
    pub environment: usize,
    /// Number of its episode.
    pub episode: u64,
    /// Control step in the episode.
    pub step: u64,
}

impl Squad {
    /// One squad for each crew, before the first episodes.
    pub fn all(crews: Vec<Box<dyn Crew>>, settings: &Settings) -> Vec<Self> {
        let mut first = 0;
        let mut squads = Vec::new();
        for crew in crews {
            let lanes = (0..crew.count()).map(|slot| Lane::new(crew.view(slot), first + slot, settings));
            let lanes: Vec<Lane> = lanes.collect();
            first += lanes.len();
            squads.push(Self { crew, lanes });
        }
        squads
    }

    /// As [`Squad::all`], at the beginning of the first episodes.
    pub fn begun(crews: Vec<Box<dyn Crew>>, settings: &Settings) -> Vec<Self> {
        let mut squads = Self::all(crews, settings);
        for squad in &mut squads {
            (0..squad.lanes.len()).for_each(|slot| squad.begin(slot, settings));
        }
        squads
    }

    /// Environments in the middle of these episodes, which are restarted and replayed action by action.
    /// `None` if `stop` returns true between two control steps.
    pub fn replayed(
        self,
        episodes: Vec<Episode>,
        settings: &Settings,
        stop: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let mut squad = self;
        for (slot, episode) in episodes.iter().enumerate() {
            squad.lanes[slot].episode.number = episode.number;
            squad.begin(slot, settings);
        }
        let width = squad.crew.view(0).sizes().action;
        let steps = episodes.iter().map(|episode| episode.actions.len() / width).max().unwrap_or(0);
        for step in 0..steps {
            if stop() {
                return None;
            }
            for (slot, episode) in episodes.iter().enumerate() {
                if let Some(action) = episode.actions.chunks_exact(width).nth(step) {
                    squad.crew.act(slot, action);
                }
            }
            squad.crew.step();
        }
        squad.lanes.iter_mut().zip(episodes).for_each(|(lane, episode)| lane.episode = episode);
        Some(squad)
    }

    /// Starts the next episode of an environment.
    fn begin(&mut self, slot: usize, settings: &Settings) {
        let lane = &mut self.lanes[slot];
        lane.episode = Episode { number: lane.episode.number, ..Episode::default() };
        self.crew.begin(slot, &lane.stream_of(&lane.episode, settings));
    }

    /// Starts a rollout: clears the sums.
    pub(super) fn clear(&mut self) {
        for (slot, lane) in self.lanes.iter_mut().enumerate() {
            lane.clear(self.crew.view(slot));
        }
    }

    /// Applies the recorded actions of this step of the rollout in all environments and records the results.
    pub(super) fn advance(&mut self, step: usize, settings: &Settings) -> Result<(), NotANumber> {
        for (slot, lane) in self.lanes.iter().enumerate() {
            self.crew.act(slot, lane.action(step, settings));
        }
        self.crew.step();
        for slot in 0..self.lanes.len() {
            let outcome = self.crew.outcome(slot);
            self.lanes[slot].record(step, outcome, self.crew.view(slot), settings)?;
            if outcome.end.is_some() {
                let Lane { episode, began, .. } = &mut self.lanes[slot];
                let actions = std::mem::take(&mut episode.actions);
                began.actions.get_or_insert(actions);
                episode.number += 1;
                self.begin(slot, settings);
            }
        }
        Ok(())
    }
}

impl Lane {
    fn new(view: &dyn View, index: usize, settings: &Settings) -> Self {
        let records = Records::new(view.sizes(), settings);
        Self {
            index,
            episode: Episode::default(),
            records,
            tally: Tally::new(view),
            exploded: None,
            began: Began::default(),
        }
    }

    /// Name of an episode's random stream.
    pub(super) fn stream_of(&self, episode: &Episode, settings: &Settings) -> String {
        settings.stream(&format!("env/{}/episode/{}", self.index, episode.number))
    }

    /// Starts a rollout: clears its sums.
    fn clear(&mut self, view: &dyn View) {
        self.tally = Tally::new(view);
        self.exploded = None;
        self.records.timeouts.clear();
        self.records.timeout_states.clear();
        let Episode { number, reward, steps, .. } = self.episode;
        let episode = Episode { number, reward, steps, actions: Vec::new() };
        self.began = Began { episode, length: self.episode.actions.len(), actions: None };
    }

    /// The episode that was running when the current rollout began, in its state at that time.
    pub(super) fn at_start(&self) -> Episode {
        let Began { episode, length, actions } = &self.began;
        let actions = actions.as_ref().unwrap_or(&self.episode.actions);
        Episode { actions: actions[..*length].to_vec(), ..episode.clone() }
    }

    /// The recorded action of a step of the rollout.
    fn action(&self, step: usize, settings: &Settings) -> &[f32] {
        let width = settings.std.len();
        &self.records.actions[step * width..(step + 1) * width]
    }

    /// Records the result of an action of the rollout.
    fn record(
        &mut self,
        step: usize,
        outcome: Step,
        view: &dyn View,
        settings: &Settings,
    ) -> Result<(), NotANumber> {
        let Step { reward, end } = outcome;
        let width = settings.std.len();
        self.episode.actions.extend_from_slice(&self.records.actions[step * width..(step + 1) * width]);
        let reward = if end == Some(End::Exploded) { 0.0 } else { reward };
        if !reward.is_finite() {
            let Self { index, episode, .. } = self;
            return Err(NotANumber { environment: *index, episode: episode.number, step: episode.steps });
        }
        self.episode.reward += reward;
        self.episode.steps += 1;
        self.records.rewards[step] = settings.reward_scale * reward;
        self.records.ends[step] = end.map(|_| 0.0);
        self.tally.step(reward, view.term_values());
        self.tally.stand(view.stance());
        if matches!(end, None | Some(End::TimeOut)) {
            self.tally.pay(view.term_values());
        }
        let Some(end) = end else { return Ok(()) };
        if end == End::TimeOut && !settings.limits_are_failures {
            let start = self.records.timeout_states.len();
            let width = self.records.state_width();
            self.records.timeouts.push(step);
            self.records.timeout_states.resize(start + width, 0.0);
            observe_state(view, settings.privileged, &mut self.records.timeout_states[start..]);
        }
        self.tally.end(end, &self.episode);
        if end == End::Exploded && self.exploded.is_none() {
            self.exploded = Some(self.episode.clone());
        }
        Ok(())
    }

    /// Estimates advantages and targets from the recorded rewards and values.
    pub(super) fn estimate(&mut self, discount: Discount) {
        let Records { rewards, values, ends, advantages, targets, .. } = &mut self.records;
        let (last_value, values) = values.split_last().expect("there is a value after the last step");
        let track = Track { rewards, values, ends, last_value: *last_value };
        estimate(track, discount, advantages, targets);
    }
}

/// Writes the critic's inputs of the current state.
pub(super) fn observe_state(view: &dyn View, privileged: bool, row: &mut [f32]) {
    if privileged { view.observe_privileged(row) } else { view.observe(row) }
}

impl Records {
    /// Width of the critic's inputs.
    pub(super) fn state_width(&self) -> usize {
        self.states.len() / self.values.len()
    }

    fn new(sizes: Sizes, settings: &Settings) -> Self {
        let steps = settings.horizon();
        let state = if settings.privileged { sizes.privileged } else { sizes.observation };
        Self {
            observations: vec![0.0; steps * sizes.observation],
            // One more row, for the state after the rollout.
            states: vec![0.0; (steps + 1) * state],
            actions: vec![0.0; steps * sizes.action],
            means: vec![0.0; steps * sizes.action],
            rewards: vec![0.0; steps],
            values: vec![0.0; steps + 1],
            ends: vec![None; steps],
            advantages: vec![0.0; steps],
            targets: vec![0.0; steps],
            timeouts: Vec::new(),
            timeout_states: Vec::new(),
        }
    }
}

impl Tally {
    fn new(environment: &dyn View) -> Self {
        let terms = vec![0.0; environment.terms().len()];
        let moments = vec![[0.0; 2]; terms.len()];
        let ends = vec![0; environment.causes().len() + 2];
        Self { terms, moments, ends, ..Self::default() }
    }

    fn step(&mut self, reward: f64, terms: &[f64]) {
        self.steps += 1;
        self.reward += reward;
        // A diverged state can make a reward term NaN or infinite; it is counted as an explosion.
        self.terms
            .iter_mut()
            .zip(terms)
            .filter(|(_, term)| term.is_finite())
            .for_each(|(sum, term)| *sum += term);
    }

    /// Adds a sound step to the moments of the reward terms.
    fn pay(&mut self, terms: &[f64]) {
        self.sound += 1;
        for ([sum, squares], term) in self.moments.iter_mut().zip(terms) {
            *sum += term;
            *squares += term * term;
        }
    }

    fn stand(&mut self, stance: Option<Stance>) {
        let Some(Stance { feet, reference }) = stance else { return };
        self.stances += 1;
        for (count, [left, right]) in self.single_support.iter_mut().zip([feet, reference]) {
            *count += u64::from(left != right);
        }
    }

    /// Standard deviation of each reward term over the sound steps.
    pub fn term_deviations(&self) -> impl Iterator<Item = f64> + '_ {
        let count = self.sound.max(1) as f64;
        self.moments
            .iter()
            .map(move |[sum, squares]| (squares / count - (sum / count).powi(2)).max(0.0).sqrt())
    }

    fn end(&mut self, end: End, episode: &Episode) {
        self.episodes += 1;
        self.episode_reward += episode.reward;
        self.episode_steps += episode.steps;
        let causes = self.ends.len() - 2;
        self.ends[match end {
            End::Terminated(cause) => cause.min(causes.saturating_sub(1)),
            End::TimeOut => causes,
            End::Exploded => causes + 1,
        }] += 1;
    }

    /// Number of episodes that ended by divergence of the simulation.
    pub fn exploded(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Adds the sums of another environment.
    pub fn add(&mut self, other: &Self) {
        self.steps += other.steps;
        self.episodes += other.episodes;
        self.episode_reward += other.episode_reward;
        self.episode_steps += other.episode_steps;
        self.reward += other.reward;
        self.terms.iter_mut().zip(&other.terms).for_each(|(sum, term)| *sum += term);
        self.sound += other.sound;
        for ([sum, squares], [own, own_squares]) in self.moments.iter_mut().zip(&other.moments) {
            *sum += own;
            *squares += own_squares;
        }
        self.stances += other.stances;
        self.single_support.iter_mut().zip(&other.single_support).for_each(|(sum, count)| *sum += count);
        self.ends.iter_mut().zip(&other.ends).for_each(|(sum, count)| *sum += count);
    }
}
