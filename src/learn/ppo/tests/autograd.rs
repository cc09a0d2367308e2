//! Comparison of one update with libtorch's autograd.

use tch::{Device, Kind, Tensor};

use super::*;

/// A network's parameters as torch tensors that require gradients.
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

/// The parameters after one step of Adam from zero moments with the step sizes of the hidden layers and of
/// the last, the gradient clipped to a norm of 0.5 by this sum of squares.
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

fn assert_close(found: &Network, expected: &[Vec<f32>], start: &Network, rate: f64) {
    for ((found, expected), start) in
        flat(found).iter().flatten().zip(expected.iter().flatten()).zip(flat(start).iter().flatten())
    {
        assert!((found - expected).abs() < 0.02 * rate as f32, "{found} is not {expected}, from {start}");
    }
    assert_ne!(&flat(found), &flat(start));
}

#[test]
fn a_minibatch_that_passes_in_blocks_is_one_minibatch() {
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
        Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new("network"),
        )
    });
    let records: Vec<Records> = (0..30).map(|environment| records_of(environment, &actor)).collect();
    let records: Vec<&Records> = records.iter().collect();
    let place = Place { update: 0, share: 0.0 };
    let mut in_blocks = Learner::new(Native, [&actor, &critic], &settings);
    assert!(in_blocks.actor.block_rows(1100) < 1100);
    let outcome = in_blocks.improve(&records, &settings, place, Pace::to_the_end(1)).unwrap();
    for backend in Torch::available() {
        let mut at_once = Learner::new(backend, [&actor, &critic], &settings);
        assert_eq!(at_once.actor.block_rows(1100), 1100);
        let whole = at_once.improve(&records, &settings, place, Pace::to_the_end(1)).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-4 * b.abs();
        assert!(close(outcome.value_loss, whole.value_loss) && close(outcome.divergence, whole.divergence));
        assert!(close(outcome.actor_norm, whole.actor_norm) && close(outcome.critic_norm, whole.critic_norm));
        assert_eq!(outcome.clip_fraction, whole.clip_fraction);
        assert_close(&in_blocks.actor.network(), &flat(&at_once.actor.network()), &actor, 1e-3);
        assert_close(&in_blocks.critic.network(), &flat(&at_once.critic.network()), &critic, 1e-3);
    }
}

#[test]
fn one_update_equals_the_same_update_written_with_autograd() {
    for threads in [1, 2] {
        equals_autograd_in_every_setting(Native, threads);
        Torch::available().into_iter().for_each(|backend| equals_autograd_in_every_setting(backend, threads));
    }
}

fn equals_autograd_in_every_setting<B: Backend>(backend: B, threads: usize) {
    equals_autograd(|_| {}, backend, threads);
    equals_autograd(|settings| settings.critic_hidden_follows = true, backend, threads);
    equals_autograd(|settings| settings.norm_of_both = true, backend, threads);
    let with_coefficient = |settings: &mut Settings| {
        settings.norm_of_both = true;
        settings.value_coefficient = 3.0;
    };
    equals_autograd(with_coefficient, backend, threads);
}

fn equals_autograd<B: Backend>(change: impl Fn(&mut Settings), backend: B, threads: usize) {
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
        let mut network = Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new(name),
        );
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
        network
    };
    let (actor, critic) = (network("test/ppo/actor", 2), network("test/ppo/critic", 1));
    let records = records(&actor);
    let mut learner = Learner::new(backend, [&actor, &critic], &settings);
    let outcome = learner
        .improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(threads))
        .unwrap();

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
