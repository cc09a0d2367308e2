//! The PPO update (Schulman et al. 2017): several passes of Adam over a rollout.
//!
//! Actor and critic are separate networks with independent losses, so they learn on two threads when there are two;
//! the result is the same on one.

mod course;
mod slices;
mod tensors;
#[cfg(test)]
mod tests;
mod together;

use std::ops::Range;

use self::course::{ActorCourse, CriticCourse, finite};
use self::slices::Slices;
use self::tensors::Tensors;
use super::clock::timed;
use super::device::Arithmetic;
use super::gradient::{State, Trainee, Workspace, Workspaces, use_one_thread};
use super::lane::Records;
use super::multiply::Before;
use super::network::Network;
use super::pace::Pace;
use super::settings::Settings;
use crate::crash;
use crate::stream::Stream;

/// Both networks with their optimisers, and the steered step size.
pub struct Learner {
    /// The actor.
    pub actor: Trainee,
    /// The critic.
    pub critic: Trainee,
    /// The actor's step size when it is steered by the KL divergence.
    pub rate: f64,
    /// Where both are.
    pub arithmetic: Arithmetic,
}

/// Place of an update in the training.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the update.
    pub update: u64,
    /// Share of all samples that were learned from before it.
    pub share: f64,
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// KL divergence of the policy after the update's last pass from the one before the update, averaged over that
    /// pass's minibatches; zero in the warm-up.
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
    /// CPU time in s of the actor and of the critic, which learn side by side when there are two threads.
    pub cpu: [f64; 2],
}

/// Why an update has no end. The networks are somewhere in the middle of it then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfinished {
    /// A network's parameters or a gradient became NaN or infinite.
    Diverged,
    /// It was asked to stop.
    Interrupted,
}

/// A network's inputs and what its loss is made of, over a rollout: sample `i` is step `i % horizon` of environment
/// `i / horizon`.
trait Samples: Send {
    /// Takes the samples in this order from now on.
    fn shuffle(&mut self, order: Vec<usize>);
    /// Begins a minibatch, a part of the order.
    fn begin(&mut self, minibatch: Range<usize>);
    /// Brings the inputs of a stretch of the minibatch into the workspace; lets the network see them, writes the slopes
    /// of the loss over the minibatch with respect to its outputs and adds to the sums.
    fn slopes(&mut self, stretch: Range<usize>, network: &Trainee, space: &mut Workspace, sums: &mut Sums);
}

/// Sums over a minibatch.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// The actor's: KL divergence from the policy before the update.
    divergence: f64,
    /// The actor's: samples whose probability ratio is beyond the clip.
    clipped: f64,
    /// The critic's: squared errors.
    error: f64,
}

impl Learner {
    /// Networks with fresh moments, in the processor's memory.
    pub fn new(actor: &Network, critic: &Network, settings: &Settings) -> Self {
        Self::on(Arithmetic::Slices, [actor, critic], settings)
    }

    /// The same where that arithmetic is done: actor, critic.
    pub fn on(arithmetic: Arithmetic, networks: [&Network; 2], settings: &Settings) -> Self {
        let [actor, critic] = networks.map(|network| Trainee::on(arithmetic, network));
        Self { actor, critic, rate: settings.rate.start(), arithmetic }
    }

    /// Both networks with their moments, to come back to after an update without an end: actor, critic.
    pub fn state(&self) -> [State; 2] {
        [self.actor.state(), self.critic.state()]
    }

    /// Comes back to a state of these networks.
    pub fn restore(&mut self, [actor, critic]: &[State; 2]) {
        self.actor.restore(actor);
        self.critic.restore(critic);
    }

    /// Learns from a rollout.
    pub fn improve(
        &mut self,
        records: &[&Records],
        settings: &Settings,
        place: Place,
        pace: Pace,
    ) -> Result<Outcome, Unfinished> {
        let at = (place, settings.rate.at(place.share, self.rate));
        let [inputs, states] = [self.actor.inputs(), self.critic.inputs()];
        let [(actor, actor_cpu), (critic, critic_cpu)] = match self.arithmetic {
            Arithmetic::Slices => {
                let rollouts = [Slices::of_actor(records, settings), Slices::of_critic(records, settings)];
                self.improve_on(rollouts, settings, at, pace)
            }
            Arithmetic::Tensors(device) => {
                let actor = Tensors::of_actor(records, settings, (device, inputs));
                let critic = Tensors::of_critic(records, settings, (device, states));
                self.improve_on([actor, critic], settings, at, pace)
            }
        }?;
        if actor.epochs > 0 {
            self.rate = settings.rate.steer(actor.rate, actor.divergence);
        }
        let cpu = [actor_cpu, critic_cpu];
        Ok(Outcome { critic_norm: critic.critic_norm, value_loss: critic.value_loss, cpu, ..actor })
    }

    /// Outcome and CPU time in s of the actor and of the critic.
    fn improve_on(
        &mut self,
        [of_actor, of_critic]: [impl Samples; 2],
        settings: &Settings,
        at: (Place, f64),
        pace: Pace,
    ) -> Result<[(Outcome, f64); 2], Unfinished> {
        let (actor, critic) = (&mut self.actor, &mut self.critic);
        if settings.norm_of_both {
            return together::improve([actor, critic], [of_actor, of_critic], settings, at, pace);
        }
        let actor = || timed(|| improve_actor(actor, of_actor, settings, at, pace));
        let critic = || timed(|| improve_critic(critic, of_critic, settings, at, pace));
        let [actor, critic] = side_by_side(pace.threads, actor, critic);
        Ok([(actor.0?, actor.1), (critic.0?, critic.1)])
    }
}

/// Whether nothing asks the update to stop.
fn goes_on(pace: Pace) -> Result<(), Unfinished> {
    if (pace.stop)() { Err(Unfinished::Interrupted) } else { Ok(()) }
}

/// Does both, on two threads if there are two.
fn side_by_side<T: Send>(threads: usize, first: impl FnOnce() -> T + Send, second: impl FnOnce() -> T) -> [T; 2] {
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

/// The minibatches of one pass, in the order of a random stream; the same for actor and critic.
fn order(settings: &Settings, update: u64, epoch: usize, samples: usize) -> Vec<usize> {
    Stream::new(&settings.stream(&format!("shuffle/{update}/{epoch}"))).permutation(samples)
}

/// Parts of this length of a range, the last one shorter.
fn parts(whole: Range<usize>, length: usize) -> impl Iterator<Item = Range<usize>> {
    whole.clone().step_by(length.max(1)).map(move |start| start..(start + length).min(whole.end))
}

/// Computes the gradient of the loss over a minibatch, one stretch after the other.
fn differentiate(
    network: &mut Trainee,
    rollout: &mut impl Samples,
    spaces: &mut Workspaces,
    minibatch: Range<usize>,
) -> Sums {
    let mut sums = Sums::default();
    let mut before = Before::Nothing;
    let length = network.arithmetic().stretch(minibatch.len());
    rollout.begin(minibatch.clone());
    for stretch in parts(minibatch, length) {
        let space = spaces.of(network, stretch.len());
        rollout.slopes(stretch, network, space, &mut sums);
        network.backward(space, before);
        before = Before::Sum;
    }
    sums
}

/// Learns from the rollout, again with a smaller step size from where it began whenever the policy runs away.
fn improve_actor(
    actor: &mut Trainee,
    mut rollout: impl Samples,
    settings: &Settings,
    (place, mut rate): (Place, f64),
    pace: Pace,
) -> Result<Outcome, Unfinished> {
    use_one_thread();
    if place.update < settings.warm_up {
        return Ok(Outcome { rate, ..Outcome::default() });
    }
    let mut spaces = Workspaces::default();
    let before = settings.rate.is_steered().then(|| actor.state());
    loop {
        let outcome = pass_over(actor, &mut rollout, &mut spaces, settings, (place, rate), pace)?;
        let smaller = settings.rate.steer(rate, outcome.divergence);
        match &before {
            Some(before) if settings.rate.overrun(outcome.divergence) && smaller < rate => actor.restore(before),
            _ => return Ok(outcome),
        }
        rate = smaller;
    }
}

/// Passes over the rollout until there are enough of them, or the policy is far enough, or a minibatch finds that it
/// has run away; then that minibatch's divergence is the outcome's.
fn pass_over(
    actor: &mut Trainee,
    rollout: &mut impl Samples,
    spaces: &mut Workspaces,
    settings: &Settings,
    (place, rate): (Place, f64),
    pace: Pace,
) -> Result<Outcome, Unfinished> {
    let mut course = ActorCourse::new(settings, rate);
    let samples = settings.batch();
    'passes: for epoch in 0..settings.epochs {
        rollout.shuffle(order(settings, place.update, epoch, samples));
        for minibatch in parts(0..samples, settings.minibatch) {
            goes_on(pace)?;
            let rows = minibatch.len();
            let sums = differentiate(actor, rollout, spaces, minibatch);
            if course.runs_away(&sums, rows) {
                break 'passes;
            }
            let norm = finite(actor.gradient_norm())?;
            actor.step(norm, course.rule);
            course.stepped(&sums, (rows, norm));
        }
        if course.ends_a_pass() {
            break;
        }
    }
    Ok(course.outcome())
}

fn improve_critic(
    critic: &mut Trainee,
    mut rollout: impl Samples,
    settings: &Settings,
    (place, rate): (Place, f64),
    pace: Pace,
) -> Result<Outcome, Unfinished> {
    use_one_thread();
    let samples = settings.batch();
    let mut spaces = Workspaces::default();
    let mut course = CriticCourse::new(settings, rate);
    for epoch in 0..settings.epochs {
        rollout.shuffle(order(settings, place.update, epoch, samples));
        for minibatch in parts(0..samples, settings.minibatch) {
            goes_on(pace)?;
            let sums = differentiate(critic, &mut rollout, &mut spaces, minibatch);
            let norm = finite(critic.gradient_norm())?;
            critic.step(norm, course.rule);
            course.stepped(&sums, norm);
        }
    }
    Ok(course.outcome())
}
