//! The PPO update (Schulman et al. 2017): several passes of Adam over a rollout.
//!
//! Actor and critic are separate networks with independent losses, so they learn on two threads when there are two;
//! the result is the same on one.

use super::adam::Rule;
use super::clock::timed;
use super::gradient::{Trainee, Workspace, numbers_mut, use_one_thread};
use super::lane::Records;
use super::network::Network;
use super::settings::{Normalisation, Settings};
use crate::stream::Stream;

/// Both networks with their optimisers, and the steered step size.
pub struct Learner {
    /// The actor.
    pub actor: Trainee,
    /// The critic.
    pub critic: Trainee,
    /// The actor's step size when it is steered by the KL divergence.
    pub rate: f64,
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
    /// CPU time in s over both threads.
    pub cpu: f64,
}

/// A network's parameters or a gradient became NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diverged;

/// A rollout as one list of samples: sample `i` is step `i % horizon` of environment `i / horizon`.
#[derive(Clone, Copy)]
struct Batch<'a> {
    records: &'a [&'a Records],
    horizon: usize,
}

impl Learner {
    /// Networks with fresh moments.
    pub fn new(actor: &Network, critic: &Network, settings: &Settings) -> Self {
        Self { actor: Trainee::new(actor), critic: Trainee::new(critic), rate: settings.rate.start() }
    }

    /// Learns from a rollout.
    pub fn improve(
        &mut self,
        records: &[&Records],
        settings: &Settings,
        place: Place,
        threads: usize,
    ) -> Result<Outcome, Diverged> {
        let batch = Batch { records, horizon: settings.horizon() };
        let rate = settings.rate.at(place.share, self.rate);
        let (actor, critic) = (&mut self.actor, &mut self.critic);
        let mut actor = || timed(|| improve_actor(actor, batch, settings, (place, rate)));
        let mut critic = || timed(|| improve_critic(critic, batch, settings, place));
        let ((actor, actor_cpu), (critic, critic_cpu)) = if threads > 1 {
            std::thread::scope(|scope| {
                let handle = scope.spawn(actor);
                let critic = critic();
                (handle.join().expect("the actor's thread does not panic"), critic)
            })
        } else {
            (actor(), critic())
        };
        let (actor, critic) = (actor?, critic?);
        if actor.epochs > 0 {
            self.rate = settings.rate.steer(rate, actor.divergence);
        }
        let cpu = actor_cpu + critic_cpu;
        Ok(Outcome { rate, critic_norm: critic.critic_norm, value_loss: critic.value_loss, cpu, ..actor })
    }
}

/// The minibatches of one pass, in the order of a random stream; the same for actor and critic.
fn order(settings: &Settings, update: u64, epoch: usize, samples: usize) -> Vec<usize> {
    Stream::new(&settings.stream(&format!("shuffle/{update}/{epoch}"))).permutation(samples)
}

/// Buffers for the full minibatches and for a smaller last one.
fn workspaces(trainee: &Trainee, minibatch: usize, samples: usize) -> [Workspace; 2] {
    [trainee.workspace(minibatch.min(samples)), trainee.workspace(samples % minibatch.min(samples))]
}

fn improve_actor(
    actor: &mut Trainee,
    batch: Batch,
    settings: &Settings,
    (place, rate): (Place, f64),
) -> Result<Outcome, Diverged> {
    use_one_thread();
    let mut outcome = Outcome::default();
    if place.update < settings.warm_up {
        return Ok(outcome);
    }
    let rule = Rule { rate, epsilon: settings.adam_epsilon, bound: settings.max_grad_norm };
    let samples = batch.samples();
    let mut spaces = workspaces(actor, settings.minibatch, samples);
    let whole = (settings.advantages == Normalisation::Batch).then(|| moments(&batch.advantages(0..samples)));
    let (mut steps, mut seen) = (0.0, 0);
    'passes: for epoch in 0..settings.epochs {
        let mut divergence = 0.0;
        for minibatch in order(settings, place.update, epoch, samples).chunks(spaces[0].rows()) {
            let space = if minibatch.len() == spaces[0].rows() { &mut spaces[0] } else { &mut spaces[1] };
            let surrogate = surrogate(actor, space, (batch, minibatch), settings, whole);
            let moved = surrogate.divergence / minibatch.len() as f64;
            if settings.rate.overrun(moved) {
                outcome.epochs += 1;
                outcome.divergence = moved;
                break 'passes;
            }
            seen += minibatch.len();
            actor.backward(space);
            let norm = actor.step(rule);
            if !norm.is_finite() {
                return Err(Diverged);
            }
            outcome.actor_norm += norm;
            outcome.clip_fraction += surrogate.clipped;
            divergence += surrogate.divergence;
            steps += 1.0;
        }
        outcome.epochs += 1;
        outcome.divergence = divergence / samples as f64;
        if settings.rate.exhausted(outcome.divergence) {
            break;
        }
    }
    outcome.actor_norm /= f64::max(steps, 1.0);
    outcome.clip_fraction /= seen.max(1) as f64;
    Ok(outcome)
}

/// Sums over a minibatch.
struct Surrogate {
    divergence: f64,
    clipped: f64,
}

/// Writes the slopes of `-mean min(r A, clamp(r, 1 - clip, 1 + clip) A)` with respect to the actor's outputs.
fn surrogate(
    actor: &Trainee,
    space: &mut Workspace,
    (batch, minibatch): (Batch, &[usize]),
    settings: &Settings,
    whole: Option<(f64, f64)>,
) -> Surrogate {
    batch.gather(minibatch, numbers_mut(&mut space.inputs), |records| &records.observations);
    actor.forward(space);
    let advantages = batch.advantages(minibatch.iter().copied());
    let (mean, deviation) = whole.unwrap_or_else(|| moments(&advantages));
    let width = settings.std.len();
    let precisions: Vec<f64> = settings.std.iter().map(|std| 1.0 / (std * std)).collect();
    let (outputs, slopes) = space.slopes_mut();
    let mut sums = Surrogate { divergence: 0.0, clipped: 0.0 };
    let rows = outputs.chunks_exact(width).zip(slopes.chunks_exact_mut(width));
    for ((sample, advantage), (output, slope)) in minibatch.iter().zip(advantages).zip(rows) {
        let (records, step) = batch.at(*sample);
        let row = step * width..(step + 1) * width;
        let (action, old) = (&records.actions[row.clone()], &records.means[row]);
        // log r = sum of ((a - mu_old)^2 - (a - mu)^2) / (2 std^2); the normal density's constants cancel.
        let mut log_ratio = 0.0;
        for dimension in 0..width {
            let moved = f64::from(output[dimension]) - f64::from(old[dimension]);
            let drawn = f64::from(action[dimension]) - f64::from(old[dimension]);
            log_ratio += 0.5 * precisions[dimension] * moved * (2.0 * drawn - moved);
            sums.divergence += 0.5 * precisions[dimension] * moved * moved;
        }
        let ratio = libm::exp(log_ratio);
        let advantage = (f64::from(advantage) - mean) / (deviation + 1e-8);
        sums.clipped += f64::from(u8::from((ratio - 1.0).abs() > settings.clip));
        let beyond = if advantage > 0.0 { ratio > 1.0 + settings.clip } else { ratio < 1.0 - settings.clip };
        let pull = if beyond { 0.0 } else { -advantage * ratio / minibatch.len() as f64 };
        for dimension in 0..width {
            let distance = f64::from(action[dimension]) - f64::from(output[dimension]);
            slope[dimension] = (pull * precisions[dimension] * distance) as f32;
        }
    }
    sums
}

fn improve_critic(critic: &mut Trainee, batch: Batch, settings: &Settings, place: Place) -> Result<Outcome, Diverged> {
    use_one_thread();
    let rule = Rule { rate: settings.value_rate, epsilon: settings.adam_epsilon, bound: settings.max_grad_norm };
    let samples = batch.samples();
    let mut spaces = workspaces(critic, settings.minibatch, samples);
    let mut outcome = Outcome::default();
    let mut steps = 0.0;
    for epoch in 0..settings.epochs {
        for minibatch in order(settings, place.update, epoch, samples).chunks(spaces[0].rows()) {
            let space = if minibatch.len() == spaces[0].rows() { &mut spaces[0] } else { &mut spaces[1] };
            batch.gather(minibatch, numbers_mut(&mut space.inputs), |records| &records.states);
            critic.forward(space);
            let (values, slopes) = space.slopes_mut();
            // The loss is half the mean squared error: the paper's authors' value coefficient.
            for ((sample, value), slope) in minibatch.iter().zip(values).zip(slopes) {
                let (records, step) = batch.at(*sample);
                let error = value - records.targets[step];
                *slope = error / minibatch.len() as f32;
                outcome.value_loss += f64::from(error) * f64::from(error);
            }
            critic.backward(space);
            let norm = critic.step(rule);
            if !norm.is_finite() {
                return Err(Diverged);
            }
            outcome.critic_norm += norm;
            steps += 1.0;
        }
    }
    outcome.critic_norm /= steps;
    outcome.value_loss /= (settings.epochs * samples) as f64;
    Ok(outcome)
}

impl<'a> Batch<'a> {
    fn samples(&self) -> usize {
        self.records.len() * self.horizon
    }

    fn at(&self, sample: usize) -> (&'a Records, usize) {
        (self.records[sample / self.horizon], sample % self.horizon)
    }

    fn advantages(&self, samples: impl Iterator<Item = usize>) -> Vec<f32> {
        samples.map(|sample| self.at(sample)).map(|(records, step)| records.advantages[step]).collect()
    }

    /// Copies the rows of a minibatch.
    fn gather(&self, minibatch: &[usize], rows: &mut [f32], of: impl Fn(&Records) -> &Vec<f32>) {
        let width = rows.len() / minibatch.len();
        for (sample, row) in minibatch.iter().zip(rows.chunks_exact_mut(width)) {
            let (records, step) = self.at(*sample);
            row.copy_from_slice(&of(records)[step * width..(step + 1) * width]);
        }
    }
}

/// Mean and standard deviation (with n - 1).
fn moments(values: &[f32]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().map(|x| f64::from(*x)).sum::<f64>() / count;
    let squares = values.iter().map(|x| (f64::from(*x) - mean) * (f64::from(*x) - mean)).sum::<f64>();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use tch::{Device, Kind, Tensor};

    use super::*;
    use crate::learn::toy;

    fn numbers(stream: &str, count: usize, scale: f64) -> Vec<f32> {
        let mut stream = Stream::new(stream);
        (0..count).map(|_| (scale * stream.normal()) as f32).collect()
    }

    /// One environment of 40 steps with random numbers, two actions.
    fn records(actor: &Network) -> Records {
        let observations = numbers("test/ppo/observations", 40 * 2, 1.0);
        let mut means = vec![0.0; 40 * 2];
        actor.forward(&observations, &mut means, &mut crate::learn::Scratch::default());
        let noise = numbers("test/ppo/noise", 40 * 2, 0.1);
        Records {
            states: observations.clone(),
            observations,
            actions: means.iter().zip(noise).map(|(mean, noise)| mean + noise).collect(),
            // The policy before the update was another one, so that ratios differ from 1 and some are clipped.
            means: means
                .iter()
                .zip(numbers("test/ppo/means", 40 * 2, 0.02))
                .map(|(mean, moved)| mean + moved)
                .collect(),
            advantages: numbers("test/ppo/advantages", 40, 3.0),
            targets: numbers("test/ppo/targets", 40, 1.0),
            ..Records::default()
        }
    }

    /// A network's parameters as torch tensors that ask for gradients.
    fn parameters(network: &Network) -> Vec<Tensor> {
        let of_layer = |layer: &crate::learn::Layer| {
            let shape = [layer.outputs as i64, layer.inputs as i64];
            [Tensor::from_slice(&layer.weight).view(shape), Tensor::from_slice(&layer.bias)]
        };
        network.layers.iter().flat_map(of_layer).map(|tensor| tensor.set_requires_grad(true)).collect()
    }

    fn forward(parameters: &[Tensor], input: &Tensor) -> Tensor {
        let mut x = input.shallow_clone();
        for (index, pair) in parameters.chunks_exact(2).enumerate() {
            x = x.matmul(&pair[0].tr()) + &pair[1];
            if 2 * index + 2 < parameters.len() {
                x = x.relu();
            }
        }
        x
    }

    /// The parameters after one step of Adam from zero moments, the gradient shortened to a norm of 0.5.
    fn stepped(parameters: &[Tensor], rate: f64) -> Vec<Vec<f32>> {
        let gradients: Vec<Tensor> = parameters.iter().map(Tensor::grad).collect();
        let squares: f64 = gradients.iter().map(|g| g.square().sum(Kind::Double).double_value(&[])).sum();
        let shrink = (0.5 / (squares.sqrt() + 1e-6)).min(1.0);
        let step = |(parameter, gradient): (&Tensor, &Tensor)| {
            let slope = gradient * shrink;
            let moved = parameter.detach() - rate * &slope / (slope.abs() + 1e-5);
            Vec::<f32>::try_from(moved.flatten(0, -1)).unwrap()
        };
        parameters.iter().zip(&gradients).map(step).collect()
    }

    fn flat(network: &Network) -> Vec<Vec<f32>> {
        network.layers.iter().flat_map(|layer| [layer.weight.clone(), layer.bias.clone()]).collect()
    }

    fn assert_close(found: &Network, expected: &[Vec<f32>], start: &Network, rate: f64) {
        for ((found, expected), start) in
            flat(found).iter().flatten().zip(expected.iter().flatten()).zip(flat(start).iter().flatten())
        {
            assert!((found - expected).abs() < 0.02 * rate as f32, "{found} is not {expected}, from {start}");
        }
        assert_ne!(&flat(found), &flat(start));
    }

    #[test]
    fn an_update_ends_within_a_pass_once_a_minibatch_finds_the_policy_far_away() {
        use_one_thread();
        let start = 1e-2;
        let settings = Settings {
            rollout: 40,
            environments: 1,
            minibatch: 10,
            epochs: 3,
            rate: crate::learn::settings::Rate::Steered { target: 0.02, start },
            warm_up: 0,
            std: vec![0.1, 0.1],
            ..toy::settings()
        };
        let mut actor = Network::orthogonal(&[2, 24, 24, 2], crate::learn::Activation::Relu, &mut Stream::new("actor"));
        actor.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
        let critic = Network::orthogonal(&[2, 24, 24, 1], crate::learn::Activation::Relu, &mut Stream::new("critic"));
        let mut records = records(&actor);
        actor.forward(&records.observations, &mut records.means, &mut crate::learn::Scratch::default());
        let mut learner = Learner::new(&actor, &critic, &settings);
        let outcome = learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, 1).unwrap();
        assert!(outcome.epochs == 1 && outcome.divergence > 5.0 * 0.02, "{outcome:?}");
        assert!(outcome.clip_fraction <= 1.0);
        // Adam's first step moves a parameter by its step size; a whole pass would have made four.
        let pairs = flat(&learner.actor.network()).concat().into_iter().zip(flat(&actor).concat());
        let farthest = pairs.map(|(found, start)| (found - start).abs()).fold(0.0, f32::max);
        assert!(farthest > 0.9 * start as f32 && farthest < 1.1 * start as f32, "{farthest}");
    }

    #[test]
    fn one_update_equals_the_same_update_written_with_autograd() {
        use_one_thread();
        let rate = 1e-3;
        let settings = Settings {
            rollout: 40,
            environments: 1,
            minibatch: 40,
            epochs: 1,
            rate: crate::learn::settings::Rate::Constant(rate),
            value_rate: rate,
            warm_up: 0,
            std: vec![0.1, 0.1],
            ..toy::settings()
        };
        let network = |name: &str, outputs| {
            let mut network =
                Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new(name));
            network.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
            network
        };
        let (actor, critic) = (network("test/ppo/actor", 2), network("test/ppo/critic", 1));
        let records = records(&actor);
        let mut learner = Learner::new(&actor, &critic, &settings);
        let outcome = learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, 2).unwrap();

        let tensor = |values: &[f32]| Tensor::from_slice(values).to_device(Device::Cpu).view([40, -1]);
        let parameters_of_actor = parameters(&actor);
        let mean = forward(&parameters_of_actor, &tensor(&records.observations));
        let log_probability = |mean: &Tensor| {
            ((tensor(&records.actions) - mean) / 0.1).square().sum_dim_intlist(1i64, false, Kind::Float) * -0.5
        };
        let ratio = (log_probability(&mean) - log_probability(&tensor(&records.means))).exp();
        let advantages = Tensor::from_slice(&records.advantages);
        let advantages = (&advantages - advantages.mean(Kind::Float)) / (advantages.std(true) + 1e-8);
        let objective = (&ratio * &advantages).minimum(&(ratio.clamp(0.8, 1.2) * &advantages));
        (-objective.mean(Kind::Float)).backward();
        assert_close(&learner.actor.network(), &stepped(&parameters_of_actor, rate), &actor, rate);

        let clipped = ((&ratio - 1.0).abs().gt(0.2)).to_kind(Kind::Float).mean(Kind::Float).double_value(&[]);
        assert!(clipped > 0.0 && (outcome.clip_fraction - clipped).abs() < 1e-6);
        let moved = ((&mean - tensor(&records.means)) / 0.1).square().sum(Kind::Float).double_value(&[]);
        assert!((outcome.divergence - 0.5 * moved / 40.0).abs() < 1e-4 * outcome.divergence);

        let parameters_of_critic = parameters(&critic);
        let value = forward(&parameters_of_critic, &tensor(&records.states)).squeeze_dim(1);
        let loss = (value - Tensor::from_slice(&records.targets)).square().mean(Kind::Float);
        (loss * 0.5).backward();
        assert_close(&learner.critic.network(), &stepped(&parameters_of_critic, rate), &critic, rate);
    }
}
