//! Actor and critic in step: each minibatch's gradients are shortened by the norm of both together, as where one
//! optimiser of the authors' code bounds the parameters of both networks.

use super::super::clock::timed;
use super::super::gradient::{Trainee, Workspaces, use_one_thread};
use super::super::pace::Pace;
use super::super::settings::Settings;
use super::course::{ActorCourse, CriticCourse, finite};
use super::{Outcome, Place, Samples, Sums, Unfinished, differentiate, goes_on, order, parts, side_by_side};

/// A network on its way through the passes.
struct Walk<'a, S> {
    network: &'a mut Trainee,
    rollout: &'a mut S,
    spaces: Workspaces,
    /// CPU time in s.
    cpu: f64,
}

impl<S: Samples> Walk<'_, S> {
    fn differentiate(&mut self, minibatch: std::ops::Range<usize>) -> Sums {
        use_one_thread();
        let (sums, cpu) = timed(|| differentiate(self.network, self.rollout, &mut self.spaces, minibatch));
        self.cpu += cpu;
        sums
    }
}

/// Outcome and CPU time in s of the actor and of the critic; both go back to where the update began when the policy
/// runs away, and learn again with a smaller step size.
pub(super) fn improve(
    [actor, critic]: [&mut Trainee; 2],
    [mut of_actor, mut of_critic]: [impl Samples; 2],
    settings: &Settings,
    (place, mut rate): (Place, f64),
    pace: Pace,
) -> Result<[(Outcome, f64); 2], Unfinished> {
    let before = settings.rate.is_steered().then(|| [actor.state(), critic.state()]);
    let mut cpu = [0.0; 2];
    loop {
        let walk = |network, rollout| Walk { network, rollout, spaces: Workspaces::default(), cpu: 0.0 };
        let mut walks = (walk(actor, &mut of_actor), walk(critic, &mut of_critic));
        let [of_actor, of_critic] = pass_over((&mut walks.0, &mut walks.1), settings, (place, rate), pace)?;
        cpu = [cpu[0] + walks.0.cpu, cpu[1] + walks.1.cpu];
        let smaller = settings.rate.steer(rate, of_actor.divergence);
        match &before {
            Some([actor_before, critic_before]) if settings.rate.overrun(of_actor.divergence) && smaller < rate => {
                actor.restore(actor_before);
                critic.restore(critic_before);
            }
            _ => return Ok([(of_actor, cpu[0]), (of_critic, cpu[1])]),
        }
        rate = smaller;
    }
}

/// The passes; once the actor has ended its own, or while it warms up, the critic goes on with its own norm.
fn pass_over<S: Samples>(
    (actor, critic): (&mut Walk<S>, &mut Walk<S>),
    settings: &Settings,
    (place, rate): (Place, f64),
    pace: Pace,
) -> Result<[Outcome; 2], Unfinished> {
    let mut courses = (ActorCourse::new(settings, rate), CriticCourse::new(settings, rate));
    let mut acting = place.update >= settings.warm_up;
    let samples = settings.batch();
    for epoch in 0..settings.epochs {
        let order = order(settings, place.update, epoch, samples);
        actor.rollout.shuffle(order.clone());
        critic.rollout.shuffle(order);
        for minibatch in parts(0..samples, settings.minibatch) {
            goes_on(pace)?;
            let rows = minibatch.len();
            let [of_actor, of_critic] = if acting {
                let part = minibatch.clone();
                side_by_side(pace.threads, || actor.differentiate(part), || critic.differentiate(minibatch))
            } else {
                [Sums::default(), critic.differentiate(minibatch)]
            };
            acting = acting && !courses.0.runs_away(&of_actor, rows);
            let own = finite(critic.network.gradient_norm())?;
            let mut both = own;
            if acting {
                let norm = finite(actor.network.gradient_norm())?;
                both = norm.hypot(own);
                actor.network.step(both, courses.0.rule);
                courses.0.stepped(&of_actor, (rows, norm));
            }
            critic.network.step(both, courses.1.rule);
            courses.1.stepped(&of_critic, own);
        }
        acting = acting && !courses.0.ends_a_pass();
    }
    Ok([courses.0.outcome(), courses.1.outcome()])
}
