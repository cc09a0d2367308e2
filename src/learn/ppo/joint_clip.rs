//! Joint gradient clipping: actor and critic take their steps together, and each minibatch's gradients are
//! clipped by the norm of both, as with a single optimiser over the parameters of both networks.

use super::super::backend::{Loss, Sums, TrainableMlp};
use super::super::clock::timed;
use super::course::{ActorCourse, CriticCourse, finite};
use super::{Outcome, Passes, Pupil, Unfinished, Update, side_by_side};

/// Trains both networks under one bound on the joint norm of their gradients.
pub(super) struct JointGradientClip<'a, M: TrainableMlp, L: Loss<M>> {
    pub actor: Pupil<'a, M, L>,
    pub critic: Pupil<'a, M, L>,
}

/// CPU time in s of actor and critic.
type Cpu = [f64; 2];

impl<M: TrainableMlp, L: Loss<M>> JointGradientClip<'_, M, L> {
    /// Returns the outcomes of actor and critic. When the policy moves too far, both return to their state
    /// before the update and learn again with a smaller step size.
    pub fn improve(mut self, mut update: Update) -> Result<[Passes; 2], Unfinished> {
        let rate = &update.settings.rate;
        let before =
            rate.is_steered().then(|| (self.actor.network.snapshot(), self.critic.network.snapshot()));
        let mut cpu = Cpu::default();
        loop {
            let [of_actor, of_critic] = self.pass_over(update, &mut cpu)?;
            let smaller = rate.steer(update.rate, of_actor.divergence);
            match &before {
                Some((actor, critic)) if rate.overrun(of_actor.divergence) && smaller < update.rate => {
                    self.actor.network.restore(actor);
                    self.critic.network.restore(critic);
                }
                _ => {
                    let passes = |outcome, cpu| Passes { outcome, cpu };
                    return Ok([passes(of_actor, cpu[0]), passes(of_critic, cpu[1])]);
                }
            }
            update.rate = smaller;
        }
    }

    /// The passes. After the actor's last pass, and during the warm-up, the critic's gradient is clipped by
    /// its own norm.
    fn pass_over(&mut self, update: Update, cpu: &mut Cpu) -> Result<[Outcome; 2], Unfinished> {
        let mut actor_course = ActorCourse::new(update.settings, update.rate);
        let mut critic_course = CriticCourse::new(update.settings, update.rate);
        let mut acting = !update.is_warm_up();
        for epoch in 0..update.settings.epochs {
            let order = update.order(epoch);
            self.actor.loss.shuffle(order.clone());
            self.critic.loss.shuffle(order);
            for minibatch in update.minibatches() {
                update.goes_on()?;
                let rows = minibatch.len();
                let [of_actor, of_critic] = self.differentiate(minibatch, acting, update.pace.threads, cpu);
                acting = acting && !actor_course.runs_away(&of_actor, rows);
                let own = finite(self.critic.network.gradient_norm())?;
                let mut both = own;
                if acting {
                    let norm = finite(self.actor.network.gradient_norm())?;
                    both = norm.hypot(own);
                    self.actor.network.step(both, actor_course.rule);
                    actor_course.stepped(&of_actor, rows, norm);
                }
                self.critic.network.step(both, critic_course.rule);
                critic_course.stepped(&of_critic, own);
            }
            acting = acting && !actor_course.ends_a_pass();
        }
        Ok([actor_course.outcome(), critic_course.outcome()])
    }

    /// Computes both gradients over a minibatch, or the critic's alone.
    fn differentiate(
        &mut self,
        minibatch: std::ops::Range<usize>,
        acting: bool,
        threads: usize,
        cpu: &mut Cpu,
    ) -> [Sums; 2] {
        let Self { actor, critic } = self;
        let [(of_actor, actor_cpu), (of_critic, critic_cpu)] = if acting {
            let part = minibatch.clone();
            side_by_side(threads, || timed_gradient(actor, part), || timed_gradient(critic, minibatch))
        } else {
            [(Sums::default(), 0.0), timed_gradient(critic, minibatch)]
        };
        *cpu = [cpu[0] + actor_cpu, cpu[1] + critic_cpu];
        [of_actor, of_critic]
    }
}

/// A network's gradient over a minibatch, and the CPU time in s that it took.
fn timed_gradient<M: TrainableMlp, L: Loss<M>>(
    pupil: &mut Pupil<M, L>,
    minibatch: std::ops::Range<usize>,
) -> (Sums, f64) {
    M::prepare_thread();
    timed(|| pupil.differentiate(minibatch))
}
