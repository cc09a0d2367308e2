//! Updates on every backend of this build.

#[cfg(feature = "torch")]
mod autograd;

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
    let numbers =
        |name: &str, count: usize, scale: f64| numbers(&format!("{name}/{environment}"), count, scale);
    let observations = numbers("test/ppo/observations", 40 * 2, 1.0);
    let mut means = vec![0.0; 40 * 2];
    actor.forward(&observations, &mut means, &mut crate::learn::Scratch::default());
    let noise = numbers("test/ppo/noise", 40 * 2, 0.1);
    Records {
        states: observations.clone(),
        observations,
        actions: means.iter().zip(noise).map(|(mean, noise)| mean + noise).collect(),
        // The policy before the update differs, so ratios differ from 1 and some are clipped.
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

fn flat(network: &Network) -> Vec<Vec<f32>> {
    network.layers.iter().flat_map(|layer| [layer.weight.clone(), layer.bias.clone()]).collect()
}

#[test]
fn an_update_that_runs_away_is_made_again_with_a_smaller_step_size() {
    is_made_again(Native);
    #[cfg(feature = "torch")]
    Torch::available().into_iter().for_each(is_made_again);
}

fn is_made_again<B: Backend>(backend: B) {
    let (target, far) = (0.02, 8e-4);
    let mut actor =
        Network::orthogonal(&[2, 24, 24, 2], crate::learn::Activation::Relu, &mut Stream::new("actor"));
    actor.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
    let critic =
        Network::orthogonal(&[2, 24, 24, 1], crate::learn::Activation::Relu, &mut Stream::new("critic"));
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
        let mut learner = Learner::new(backend, [&actor, &critic], &settings);
        let outcome = learner
            .improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1))
            .unwrap();
        (learner, outcome)
    };
    let (found, outcome) = improved(far);
    // Halved until no minibatch is five targets away from the old policy.
    let halvings = libm::log2(far / outcome.rate);
    assert!(halvings >= 1.0 && halvings.fract() == 0.0, "{outcome:?}");
    assert!(outcome.divergence > 0.0 && outcome.divergence < 5.0 * target, "{outcome:?}");
    // Nothing remains of the update that was undone: neither in the parameters nor in the moments.
    let (expected, straight) = improved(outcome.rate);
    assert_eq!((outcome.divergence, outcome.epochs), (straight.divergence, straight.epochs));
    assert_eq!(flat(&found.actor.network()), flat(&expected.actor.network()));
    assert_eq!((found.actor.adam(), found.rate), (expected.actor.adam(), expected.rate));
    assert_ne!(flat(&found.actor.network()), flat(&actor));
}

#[test]
fn an_update_at_the_smallest_step_size_ends_within_a_pass_instead() {
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
        Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new("network"),
        )
    });
    let mut records = records(&actor);
    actor.forward(&records.observations, &mut records.means, &mut crate::learn::Scratch::default());
    let mut learner = Learner::new(Native, [&actor, &critic], &settings);
    let outcome = learner
        .improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1))
        .unwrap();
    assert!(outcome.rate == 1e-6 && outcome.epochs == 1 && outcome.divergence > 5e-12, "{outcome:?}");
    assert_eq!(learner.actor.adam().steps, 1);
}

#[test]
fn both_norms_together_leave_the_critic_its_own_while_the_actor_warms_up_or_is_done() {
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new("network"),
        )
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
        let mut learner = Learner::new(Native, [&actor, &critic], &settings);
        let outcome = learner
            .improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1))
            .unwrap();
        (learner, outcome)
    };
    let equal = |[(a, _), (b, _)]: [&(Learner<Native>, Outcome); 2]| {
        flat(&a.critic.network()) == flat(&b.critic.network())
    };
    let warming = [true, false].map(|both| improved(both, (1e-4, 0.02), 1));
    assert!(equal([&warming[0], &warming[1]]) && flat(&warming[0].0.actor.network()) == flat(&actor));
    let acting = [true, false].map(|both| improved(both, (1e-4, 0.02), 0));
    assert!(!equal([&acting[0], &acting[1]]));
    assert_ne!(flat(&acting[0].0.actor.network()), flat(&acting[1].0.actor.network()));
    // The actor moves too far, both networks are reset, and learn as if they had begun with the smaller step
    // size.
    let (found, outcome) = improved(true, (8e-2, 0.02), 0);
    assert!(outcome.rate < 8e-2, "{outcome:?}");
    let straight = improved(true, (outcome.rate, 0.02), 0).0;
    assert_eq!(flat(&found.actor.network()), flat(&straight.actor.network()));
    assert_eq!(flat(&found.critic.network()), flat(&straight.critic.network()));
    assert_eq!(found.critic.adam(), straight.critic.adam());
}

#[test]
fn a_gradient_that_is_no_number_ends_the_update() {
    ends_at_a_gradient_that_is_no_number(Native);
    #[cfg(feature = "torch")]
    Torch::available().into_iter().for_each(ends_at_a_gradient_that_is_no_number);
}

fn ends_at_a_gradient_that_is_no_number<B: Backend>(backend: B) {
    let [actor, critic] = [2, 1].map(|outputs| {
        Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new("network"),
        )
    });
    for (norm_of_both, of_actor) in [(true, true), (true, false), (false, true), (false, false)] {
        let settings = Settings {
            rollout: 40,
            environments: 1,
            warm_up: 0,
            std: vec![0.1, 0.1],
            norm_of_both,
            ..toy::settings()
        };
        let mut records = records(&actor);
        let numbers = if of_actor { &mut records.advantages } else { &mut records.targets };
        numbers[7] = f32::NAN;
        let mut learner = Learner::new(backend, [&actor, &critic], &settings);
        let outcome =
            learner.improve(&[&records], &settings, Place { update: 0, share: 0.0 }, Pace::to_the_end(1));
        assert_eq!(outcome, Err(Unfinished::Diverged), "{backend:?}");
    }
}

/// Three rollouts with one learner; returns the networks and outcomes after each.
fn course<B: Backend>(backend: B, settings: &Settings) -> Vec<(Vec<Vec<f32>>, Outcome)> {
    let network = |name: &str, outputs| {
        let mut network = Network::orthogonal(
            &[2, 24, 24, outputs],
            crate::learn::Activation::Relu,
            &mut Stream::new(name),
        );
        network.layers[2].weight.iter_mut().for_each(|x| *x *= 50.0);
        network
    };
    let [actor, critic] = [network("test/ppo/actor", 2), network("test/ppo/critic", 1)];
    let mut learner = Learner::new(backend, [&actor, &critic], settings);
    let update = |update: usize| {
        let records = records_of(update, &actor);
        let place = Place { update: update as u64, share: 0.0 };
        let outcome = learner.improve(&[&records], settings, place, Pace::to_the_end(1)).unwrap();
        (learner.networks().iter().flat_map(flat).collect(), Outcome { cpu: [0.0; 2], ..outcome })
    };
    (0..3).map(update).collect()
}

#[cfg(feature = "torch")]
#[test]
fn backends_agree_update_by_update() {
    let rate = 1e-3;
    let settings = Settings {
        rollout: 40,
        environments: 1,
        minibatch: 16,
        epochs: 2,
        rate: settings::Rate::Constant(rate),
        value_rate: rate,
        warm_up: 1,
        std: vec![0.1, 0.1],
        ..toy::settings()
    };
    for settings in [settings.clone(), Settings { norm_of_both: true, ..settings }] {
        let native = course(Native, &settings);
        for backend in Torch::available() {
            for (update, ((found, of_native), (expected, of_torch))) in
                native.iter().zip(course(backend, &settings)).enumerate()
            {
                let apart = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0, f32::max);
                // A step of Adam moves a parameter by about the step size.
                assert!(apart < 0.02 * rate as f32, "{backend:?}, update {update}: {apart:e}");
                let close = |a: f64, b: f64| (a - b).abs() <= 1e-4 * b.abs();
                assert!(close(of_native.divergence, of_torch.divergence), "{of_native:?} {of_torch:?}");
                assert!(close(of_native.actor_norm, of_torch.actor_norm), "{of_native:?} {of_torch:?}");
                assert!(close(of_native.critic_norm, of_torch.critic_norm), "{of_native:?} {of_torch:?}");
                assert!(close(of_native.value_loss, of_torch.value_loss), "{of_native:?} {of_torch:?}");
                // One of 80 samples may be exactly at the bound.
                assert!((of_native.clip_fraction - of_torch.clip_fraction).abs() < 0.02);
            }
        }
    }
}

#[test]
fn an_update_gives_the_same_bits_again() {
    let settings =
        Settings { rollout: 40, environments: 1, minibatch: 16, std: vec![0.1, 0.1], ..toy::settings() };
    assert_eq!(course(Native, &settings), course(Native, &settings));
}
