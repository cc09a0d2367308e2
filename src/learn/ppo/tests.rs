//! One update against libtorch's autograd, by every arithmetic of this machine.

use tch::{Device, Kind, Tensor};

use super::*;
use crate::learn::toy;

fn numbers(stream: &str, count: usize, scale: f64) -> Vec<f32> {
    let mut stream = Stream::new(stream);
    (0..count).map(|_| (scale * stream.normal()) as f32).collect()
}

/// One environment of 40 steps with random numbers, two actions.
fn records(actor: &Network) -> Records {
    records_of(0, actor)
}

fn records_of(environment: usize, actor: &Network) -> Records {
    let numbers = |name: &str, count: usize, scale: f64| numbers(&format!("{name}/{environment}"), count, scale);
    let observations = numbers("test/ppo/observations", 40 * 2, 1.0);
    let mut means = vec![0.0; 40 * 2];
    actor.forward(&observations, &mut means, &mut crate::learn::Scratch::default());
    let noise = numbers("test/ppo/noise", 40 * 2, 0.1);
    Records {
        states: observations.clone(),
        observations,
        actions: means.iter().zip(noise).map(|(mean, noise)| mean + noise).collect(),
        // The policy before the update was another one, so that ratios differ from 1 and some are clipped.
        means: means.iter().zip(numbers("test/ppo/means", 40 * 2, 0.02)).map(|(mean, moved)| mean + moved).collect(),
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

/// Sum of the squares of all gradients.
fn squares(parameters: &[Tensor]) -> f64 {
    parameters.iter().map(|parameter| parameter.grad().square().sum(Kind::Double).double_value(&[])).sum()
}

/// The parameters after one step of Adam from zero moments with the step sizes of the hidden layers and of the last, the
/// gradient shortened as one with these squares is to a norm of 0.5.
fn stepped(parameters: &[Tensor], [hidden, last]: [f64; 2], squares: f64) -> Vec<Vec<f32>> {
    let shrink = (0.5 / (squares.sqrt() + 1e-6)).min(1.0);
    let of_last = parameters.len() - 2;
    let step = |(index, parameter): (usize, &Tensor)| {
        let slope = parameter.grad() * shrink;
        let rate = if index < of_last { hidden } else { last };
        let moved = parameter.detach() - rate * &slope / (slope.abs() + 1e-5);
        Vec::<f32>::try_from(moved.flatten(0, -1)).unwrap()
    };
    parameters.iter().enumerate().map(step).collect()
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
fn an_update_that_runs_away_is_made_again_with_a_smaller_step_size() {
    use_one_thread();
    Arithmetic::here().into_iter().for_each(is_made_again);
}

fn is_made_again(arithmetic: Arithmetic) {
    let (target, far) = (0.02, 8e-4);
    let mut actor = Network::orthogonal(&[2, 24, 24, 2], crate::learn::Activation::Relu, &mut Stream::new("actor"));
    actor.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
    let critic = Network::orthogonal(&[2, 24, 24, 1], crate::learn::Activation::Relu, &mut Stream::new("critic"));
    let mut records = records(&actor);
    actor.forward(&records.observations, &mut records.means, &mut crate::learn::Scratch::default());
    let improved = |start| {
        let settings = Settings {
            rollout: 40,
            environments: 1,
            minibatch: 10,
            epochs: 3,
            rate: crate::learn::settings::Rate::Steered { target, start },
            warm_up: 0,
            std: vec![0.02, 0.02],
            ..toy::settings()
        };
        let mut learner = Learner::on(arithmetic, [&actor, &critic], &settings);
        let outcome =
            learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1)).unwrap();
        (learner, outcome)
    };
    let (found, outcome) = improved(far);
    // Halved until no minibatch finds the policy five targets away.
    let halvings = libm::log2(far / outcome.rate);
    assert!(halvings >= 1.0 && halvings.fract() == 0.0, "{outcome:?}");
    assert!(outcome.divergence > 0.0 && outcome.divergence < 5.0 * target, "{outcome:?}");
    // Nothing of what was taken back is left: neither in the parameters nor in the moments.
    let (expected, straight) = improved(outcome.rate);
    assert_eq!((outcome.divergence, outcome.epochs), (straight.divergence, straight.epochs));
    assert_eq!(flat(&found.actor.network()), flat(&expected.actor.network()));
    assert_eq!((found.actor.adam(), found.rate), (expected.actor.adam(), expected.rate));
    assert_ne!(flat(&found.actor.network()), flat(&actor));
}

#[test]
fn an_update_at_the_smallest_step_size_ends_within_a_pass_instead() {
    use_one_thread();
    let settings = Settings {
        rollout: 40,
        environments: 1,
        minibatch: 10,
        epochs: 3,
        rate: crate::learn::settings::Rate::Steered { target: 1e-12, start: 1e-6 },
        warm_up: 0,
        std: vec![0.1, 0.1],
        ..toy::settings()
    };
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new("network"))
    });
    let mut records = records(&actor);
    actor.forward(&records.observations, &mut records.means, &mut crate::learn::Scratch::default());
    let mut learner = Learner::on(Arithmetic::Slices, [&actor, &critic], &settings);
    let outcome =
        learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1)).unwrap();
    assert!(outcome.rate == 1e-6 && outcome.epochs == 1 && outcome.divergence > 5e-12, "{outcome:?}");
    assert_eq!(learner.actor.adam().steps, 1);
}

#[test]
fn a_minibatch_that_passes_in_stretches_is_one_minibatch() {
    use_one_thread();
    let settings = Settings {
        rollout: 40 * 30,
        environments: 30,
        minibatch: 1100,
        epochs: 2,
        rate: crate::learn::settings::Rate::Constant(1e-3),
        value_rate: 1e-3,
        warm_up: 0,
        std: vec![0.1, 0.1],
        ..toy::settings()
    };
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new("network"))
    });
    let records: Vec<Records> = (0..30).map(|environment| records_of(environment, &actor)).collect();
    let records: Vec<&Records> = records.iter().collect();
    let improved = |arithmetic: Arithmetic| {
        let mut learner = Learner::on(arithmetic, [&actor, &critic], &settings);
        let outcome =
            learner.improve(&records, &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1)).unwrap();
        (learner, outcome)
    };
    // The others take all rows at once.
    let (found, outcome) = improved(Arithmetic::Slices);
    assert!(Arithmetic::Slices.stretch(1100) < 1100);
    for arithmetic in &Arithmetic::here()[1..] {
        assert_eq!(arithmetic.stretch(1100), 1100);
        let (expected, whole) = improved(*arithmetic);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-4 * b.abs();
        assert!(close(outcome.value_loss, whole.value_loss) && close(outcome.divergence, whole.divergence));
        assert!(close(outcome.actor_norm, whole.actor_norm) && close(outcome.critic_norm, whole.critic_norm));
        assert_eq!(outcome.clip_fraction, whole.clip_fraction);
        assert_close(&found.actor.network(), &flat(&expected.actor.network()), &actor, 1e-3);
        assert_close(&found.critic.network(), &flat(&expected.critic.network()), &critic, 1e-3);
    }
}

#[test]
fn one_update_equals_the_same_update_written_with_autograd() {
    use_one_thread();
    for (arithmetic, threads) in Arithmetic::here().into_iter().flat_map(|by| [(by, 1), (by, 2)]) {
        equals_autograd(|_| {}, arithmetic, threads);
        equals_autograd(|settings| settings.critic_hidden_follows = true, arithmetic, threads);
        equals_autograd(|settings| settings.norm_of_both = true, arithmetic, threads);
        let with_coefficient = |settings: &mut Settings| {
            settings.norm_of_both = true;
            settings.value_coefficient = 3.0;
        };
        equals_autograd(with_coefficient, arithmetic, threads);
    }
}

fn equals_autograd(change: impl Fn(&mut Settings), arithmetic: Arithmetic, threads: usize) {
    let (rate, value_rate) = (1e-3, 2e-3);
    let mut settings = Settings {
        rollout: 40,
        environments: 1,
        minibatch: 40,
        epochs: 1,
        rate: crate::learn::settings::Rate::Constant(rate),
        value_rate,
        warm_up: 0,
        std: vec![0.1, 0.1],
        ..toy::settings()
    };
    change(&mut settings);
    let network = |name: &str, outputs| {
        let mut network =
            Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new(name));
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
        network
    };
    let (actor, critic) = (network("test/ppo/actor", 2), network("test/ppo/critic", 1));
    let records = records(&actor);
    let mut learner = Learner::on(arithmetic, [&actor, &critic], &settings);
    let outcome =
        learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(threads)).unwrap();

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

    let clipped = ((&ratio - 1.0).abs().gt(0.2)).to_kind(Kind::Float).mean(Kind::Float).double_value(&[]);
    assert!(clipped > 0.0 && (outcome.clip_fraction - clipped).abs() < 1e-6);
    let moved = ((&mean - tensor(&records.means)) / 0.1).square().sum(Kind::Float).double_value(&[]);
    assert!((outcome.divergence - 0.5 * moved / 40.0).abs() < 1e-4 * outcome.divergence);

    let parameters_of_critic = parameters(&critic);
    let value = forward(&parameters_of_critic, &tensor(&records.states)).squeeze_dim(1);
    let loss = (value - Tensor::from_slice(&records.targets)).square().mean(Kind::Float);
    (loss * settings.value_coefficient).backward();

    let [mut of_actor, mut of_critic] = [squares(&parameters_of_actor), squares(&parameters_of_critic)];
    assert!((outcome.actor_norm - of_actor.sqrt()).abs() < 1e-4 * outcome.actor_norm, "{outcome:?}");
    assert!((outcome.critic_norm - of_critic.sqrt()).abs() < 1e-4 * outcome.critic_norm, "{outcome:?}");
    if settings.norm_of_both {
        of_actor += of_critic;
        of_critic = of_actor;
    }
    let hidden = if settings.critic_hidden_follows { rate } else { value_rate };
    let expected = stepped(&parameters_of_actor, [rate; 2], of_actor);
    assert_close(&learner.actor.network(), &expected, &actor, rate);
    let expected = stepped(&parameters_of_critic, [hidden, value_rate], of_critic);
    assert_close(&learner.critic.network(), &expected, &critic, hidden);
}

#[test]
fn both_norms_together_leave_the_critic_its_own_while_the_actor_warms_up_or_is_done() {
    use_one_thread();
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new("network"))
    });
    let mut records = records(&actor);
    actor.forward(&records.observations, &mut records.means, &mut crate::learn::Scratch::default());
    let improved = |norm_of_both, (start, target), warm_up| {
        let settings = Settings {
            rollout: 40,
            environments: 1,
            minibatch: 10,
            epochs: 3,
            rate: crate::learn::settings::Rate::Steered { target, start },
            warm_up,
            std: vec![0.02, 0.02],
            norm_of_both,
            ..toy::settings()
        };
        let mut learner = Learner::new(&actor, &critic, &settings);
        let outcome =
            learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1)).unwrap();
        (learner, outcome)
    };
    let equal = |[(a, _), (b, _)]: [&(Learner, Outcome); 2]| flat(&a.critic.network()) == flat(&b.critic.network());
    let warming = [true, false].map(|both| improved(both, (1e-4, 0.02), 1));
    assert!(equal([&warming[0], &warming[1]]) && flat(&warming[0].0.actor.network()) == flat(&actor));
    let acting = [true, false].map(|both| improved(both, (1e-4, 0.02), 0));
    assert!(!equal([&acting[0], &acting[1]]));
    assert_ne!(flat(&acting[0].0.actor.network()), flat(&acting[1].0.actor.network()));
    // It runs away, is taken back with the critic, and learns as if it had begun with the smaller step size.
    let (found, outcome) = improved(true, (8e-2, 0.02), 0);
    assert!(outcome.rate < 8e-2, "{outcome:?}");
    let straight = improved(true, (outcome.rate, 0.02), 0).0;
    assert_eq!(flat(&found.actor.network()), flat(&straight.actor.network()));
    assert_eq!(flat(&found.critic.network()), flat(&straight.critic.network()));
    assert_eq!(found.critic.adam(), straight.critic.adam());
}

#[test]
fn a_gradient_that_is_no_number_ends_the_update() {
    use_one_thread();
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(&[2, 24, 24, outputs], crate::learn::Activation::Relu, &mut Stream::new("network"))
    });
    for (arithmetic, norm_of_both) in Arithmetic::here().into_iter().flat_map(|by| [(by, true), (by, false)]) {
        let settings =
            Settings { rollout: 40, environments: 1, warm_up: 0, std: vec![0.1, 0.1], norm_of_both, ..toy::settings() };
        for of_actor in [true, false] {
            let mut records = records(&actor);
            let numbers = if of_actor { &mut records.advantages } else { &mut records.targets };
            numbers[7] = f32::NAN;
            let mut learner = Learner::on(arithmetic, [&actor, &critic], &settings);
            let outcome = learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1));
            assert_eq!(outcome, Err(Unfinished::Diverged), "{arithmetic:?}");
        }
    }
}
