//! The PPO update (Schulman et al. 2017): several passes of Adam over a rollout.
//!
//! Actor and critic are separate networks with independent losses, so they learn on two threads if available;
//! one thread gives the same result.

mod course;
mod joint_clip;
#[cfg(test)]
mod tests;

use std::ops::Range;

use self::course::{ActorCourse, CriticCourse, finite};
use self::joint_clip::JointGradientClip;
use super::adam::Adam;
use super::backend::native::{Native, check_processor};
#[cfg(feature = "torch")]
use super::backend::torch::Torch;
use super::backend::{Backend, Beta, Loss, Sums, TrainableMlp, Workspaces};
use super::clock::timed;
use super::error::LearnError;
use super::lane::Records;
use super::network::Network;
use super::pace::Pace;
use super::settings::{self, Settings};
use crate::crash;
use crate::stream::Stream;

/// Both networks with their optimisers, and the adapted step size.
pub struct Learner<B: Backend> {
    backend: B,
    /// The actor.
    pub actor: B::Mlp,
    /// The critic.
    pub critic: B::Mlp,
    /// The actor's step size when it is adapted to the KL divergence.
    pub rate: f64,
}

/// A learner on any backend, as a training uses it.
pub trait Improve: Send {
    /// Learns from a rollout on up to two threads. An interruption leaves the networks unchanged.
    fn improve(
        &mut self,
        records: &[&Records],
        settings: &Settings,
        place: Place,
        pace: Pace,
    ) -> Result<Outcome, Unfinished>;

    /// The current networks: actor, critic.
    fn networks(&self) -> [Network; 2];

    /// Their Adam states.
    fn moments(&self) -> [Adam; 2];

    /// Replaces their Adam states; returns false if one belongs to another number of parameters.
    #[must_use]
    fn set_moments(&mut self, moments: [&Adam; 2]) -> bool;

    /// The actor's step size when it is adapted.
    fn rate(&self) -> f64;

    /// Sets the actor's step size when a training is resumed.
    fn set_rate(&mut self, rate: f64);
}

/// A learner of these networks (actor, critic) with fresh moments, on the backend and the device of the
/// settings. Fails as [`check_backend`] does.
pub fn learner(networks: [&Network; 2], settings: &Settings) -> Result<Box<dyn Improve>, LearnError> {
    check_backend(settings.backend, settings.device)?;
    match settings.backend {
        settings::Backend::Native => Ok(Box::new(Learner::new(Native, networks, settings))),
        #[cfg(feature = "torch")]
        settings::Backend::Torch => {
            Ok(Box::new(Learner::new(Torch::on(settings.device)?, networks, settings)))
        }
        #[cfg(not(feature = "torch"))]
        settings::Backend::Torch => Err(LearnError::Backend),
    }
}

/// Fails if this build or machine lacks the backend or the device: without libtorch (R0005), without a CUDA
/// device or without the instructions that the native backend's bits need (R0006).
pub fn check_backend(backend: settings::Backend, device: settings::Device) -> Result<(), LearnError> {
    match backend {
        settings::Backend::Native => check_processor(),
        #[cfg(feature = "torch")]
        settings::Backend::Torch => Torch::on(device).map(drop),
        #[cfg(not(feature = "torch"))]
        settings::Backend::Torch => {
            let _ = device;
            Err(LearnError::Backend)
        }
    }
}

/// Position of an update in the training.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the update.
    pub update: u64,
    /// Share of all samples that were used before it.
    pub share: f64,
}

/// Outcome of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// KL divergence of the policy after the update's last pass from the one before the update, averaged over
    /// that pass's minibatches; zero in the warm-up.
    pub divergence: f64,
    /// Share of the samples whose probability ratio was beyond the clip, over all passes.
    pub clip_fraction: f64,
    /// Passes of the actor.
    pub epochs: u64,
    /// The actor's step size.
    pub rate: f64,
    /// Mean norm of the actor's gradient.
    pub actor_norm: f64,
    /// Mean norm of the critic's gradient.
    pub critic_norm: f64,
    /// Mean squared error of the critic over all passes.
    pub value_loss: f64,
    /// CPU time in s of the actor and of the critic, which learn in parallel when there are two threads.
    pub cpu: [f64; 2],
}

/// Reasons why an update did not finish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// A network's parameters or a gradient became NaN or infinite; the networks are in an intermediate
    /// state.
    Diverged,
    /// The update was interrupted; the networks are as before it.
    Interrupted,
}

/// One update: what its passes share.
#[derive(Clone, Copy)]
struct Update<'a> {
    settings: &'a Settings,
    /// Index of the update.
    index: u64,
    /// The actor's step size.
    rate: f64,
    pace: Pace<'a>,
}

impl Update<'_> {
    /// Fails if the update should stop.
    fn goes_on(&self) -> Result<(), Unfinished> {
        if (self.pace.stop)() { Err(Unfinished::Interrupted) } else { Ok(()) }
    }

    /// Whether only the critic learns.
    fn is_warm_up(&self) -> bool {
        self.index < self.settings.warm_up
    }

    /// The samples of one pass in the order of a random stream, the same for actor and critic.
    fn order(&self, epoch: usize) -> Vec<usize> {
        let name = self.settings.stream(&format!("shuffle/{}/{epoch}", self.index));
        Stream::new(&name).permutation(self.settings.batch())
    }

    /// The minibatches of a pass, as parts of its order.
    fn minibatches(&self) -> impl Iterator<Item = Range<usize>> {
        parts(0..self.settings.batch(), self.settings.minibatch)
    }
}

/// Outcome of one network's passes.
struct Passes {
    outcome: Outcome,
    /// CPU time in s.
    cpu: f64,
}

impl<B: Backend> Learner<B> {
    /// Learns from copies of these networks (actor, critic), with fresh moments.
    pub fn new(backend: B, networks: [&Network; 2], settings: &Settings) -> Self {
        let [actor, critic] = networks.map(|network| backend.mlp(network));
        Self { backend, actor, critic, rate: settings.rate.start() }
    }

    /// The outcomes of the actor's and the critic's passes.
    fn passes(&mut self, records: &[&Records], update: Update) -> Result<[Passes; 2], Unfinished> {
        let Update { settings, pace: Pace { threads, .. }, .. } = update;
        let actor_loss = self.backend.actor_loss(records, settings, self.actor.inputs());
        let critic_loss = self.backend.critic_loss(records, settings, self.critic.inputs());
        let actor = Pupil::new(&mut self.actor, actor_loss);
        let critic = Pupil::new(&mut self.critic, critic_loss);
        if settings.norm_of_both {
            return JointGradientClip { actor, critic }.improve(update);
        }
        let [of_actor, of_critic] =
            side_by_side(threads, || actor.improve_actor(update), || critic.improve_critic(update));
        Ok([of_actor?, of_critic?])
    }
}

impl<B: Backend> Improve for Learner<B> {
    fn improve(
        &mut self,
        records: &[&Records],
        settings: &Settings,
        place: Place,
        pace: Pace,
    ) -> Result<Outcome, Unfinished> {
        let update =
            Update { settings, index: place.update, rate: settings.rate.at(place.share, self.rate), pace };
        let before = (self.actor.snapshot(), self.critic.snapshot());
        let passes = self.passes(records, update);
        if let Err(Unfinished::Interrupted) = passes {
            self.actor.restore(&before.0);
            self.critic.restore(&before.1);
        }
        let [of_actor, of_critic] = passes?;
        if of_actor.outcome.epochs > 0 {
            self.rate = settings.rate.steer(of_actor.outcome.rate, of_actor.outcome.divergence);
        }
        let Outcome { critic_norm, value_loss, .. } = of_critic.outcome;
        Ok(Outcome { critic_norm, value_loss, cpu: [of_actor.cpu, of_critic.cpu], ..of_actor.outcome })
    }

    fn networks(&self) -> [Network; 2] {
        [self.actor.network(), self.critic.network()]
    }

    fn moments(&self) -> [Adam; 2] {
        [self.actor.adam(), self.critic.adam()]
    }

    fn set_moments(&mut self, [actor, critic]: [&Adam; 2]) -> bool {
        self.actor.set_adam(actor) && self.critic.set_adam(critic)
    }

    fn rate(&self) -> f64 {
        self.rate
    }

    fn set_rate(&mut self, rate: f64) {
        self.rate = rate;
    }
}

/// Runs both closures, on two threads if there are two.
fn side_by_side<T: Send>(
    threads: usize,
    first: impl FnOnce() -> T + Send,
    second: impl FnOnce() -> T,
) -> [T; 2] {
    if threads < 2 {
        return [first(), second()];
    }
    let part = crash::part();
    std::thread::scope(|scope| {
        let handle = scope.spawn(move || {
            part.join();
            first()
        });
        let second = second();
        [crash::joined(handle.join()), second]
    })
}

/// Splits a range into parts of this length, the last one shorter.
fn parts(whole: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    whole.clone().step_by(length.max(1)).map(move |start| start..(start + length).min(whole.end))
}

/// A network with its loss over an update.
struct Pupil<'a, M: TrainableMlp, L: Loss<M>> {
    network: &'a mut M,
    loss: L,
    workspaces: Workspaces<M>,
}

impl<'a, M: TrainableMlp, L: Loss<M>> Pupil<'a, M, L> {
    fn new(network: &'a mut M, loss: L) -> Self {
        Self { network, loss, workspaces: Workspaces::default() }
    }

    /// Computes the gradient of the loss over a minibatch, block by block.
    fn differentiate(&mut self, minibatch: Range<usize>) -> Sums {
        let mut sums = Sums::default();
        let mut beta = Beta::Zero;
        let rows = self.network.block_rows(minibatch.len());
        self.loss.begin(minibatch.clone());
        for block in parts(minibatch, rows) {
            let space = self.workspaces.of(self.network, block.len());
            self.loss.differentiate(block, self.network, space, &mut sums);
            self.network.backward(space, beta);
            beta = Beta::One;
        }
        sums
    }

    /// Trains the actor; whenever the policy moves too far, again from the start of the update with a smaller
    /// step size.
    fn improve_actor(mut self, mut update: Update) -> Result<Passes, Unfinished> {
        M::prepare_thread();
        if update.is_warm_up() {
            return Ok(Passes { outcome: Outcome { rate: update.rate, ..Outcome::default() }, cpu: 0.0 });
        }
        let rate = &update.settings.rate;
        let (outcome, cpu): (Result<Outcome, Unfinished>, f64) = timed(|| {
            let before = rate.is_steered().then(|| self.network.snapshot());
            loop {
                let outcome = self.pass_as_actor(update)?;
                let smaller = rate.steer(update.rate, outcome.divergence);
                match &before {
                    Some(before) if rate.overrun(outcome.divergence) && smaller < update.rate => {
                        self.network.restore(before);
                    }
                    _ => return Ok(outcome),
                }
                update.rate = smaller;
            }
        });
        Ok(Passes { outcome: outcome?, cpu })
    }

    /// Passes over the rollout until all are done, the policy has moved far enough, or a minibatch shows that
    /// it has moved too far; then the outcome has that minibatch's divergence.
    fn pass_as_actor(&mut self, update: Update) -> Result<Outcome, Unfinished> {
        let mut course = ActorCourse::new(update.settings, update.rate);
        'passes: for epoch in 0..update.settings.epochs {
            self.loss.shuffle(update.order(epoch));
            for minibatch in update.minibatches() {
                update.goes_on()?;
                let rows = minibatch.len();
                let sums = self.differentiate(minibatch);
                if course.runs_away(&sums, rows) {
                    break 'passes;
                }
                let norm = finite(self.network.gradient_norm())?;
                self.network.step(norm, course.rule);
                course.stepped(&sums, rows, norm);
            }
            if course.ends_a_pass() {
                break;
            }
        }
        Ok(course.outcome())
    }

    /// Trains the critic.
    fn improve_critic(mut self, update: Update) -> Result<Passes, Unfinished> {
        M::prepare_thread();
        let (outcome, cpu): (Result<Outcome, Unfinished>, f64) = timed(|| {
            let mut course = CriticCourse::new(update.settings, update.rate);
            for epoch in 0..update.settings.epochs {
                self.loss.shuffle(update.order(epoch));
                for minibatch in update.minibatches() {
                    update.goes_on()?;
                    let sums = self.differentiate(minibatch);
                    let norm = finite(self.network.gradient_norm())?;
                    self.network.step(norm, course.rule);
                    course.stepped(&sums, norm);
                }
            }
            Ok(course.outcome())
        });
        Ok(Passes { outcome: outcome?, cpu })
    }
}
