//! One whole PPO update against the same update by PyTorch's autograd in double precision
//! (`tests/reference/make_ppo_update.py`): advantages with failures and time-outs, surrogate, KL divergence,
//! clipping, gradient norms, Adam, several passes over minibatches, early end, actor and critic.

use std::path::{Path, PathBuf};

use serde_json::Value;
use specforge::learn::advantage::{Discount, Track, estimate};
use specforge::learn::backend::Backend;
use specforge::learn::backend::native::Native;
#[cfg(feature = "torch")]
use specforge::learn::backend::torch::Torch;
use specforge::learn::lane::Records;
use specforge::learn::pace::Pace;
use specforge::learn::ppo::{Improve, Learner, Outcome, Place};
use specforge::learn::settings::{self, Device, Normalisation, Rate, Shape};
use specforge::learn::{Activation, Layer, Network, Round, Scratch, Settings};
use specforge::stream::Stream;

const ENVIRONMENTS: usize = 3;
const STEPS: usize = 40;
const SAMPLES: usize = ENVIRONMENTS * STEPS;
const OBSERVED: usize = 30;
const TRUTHS: usize = 4;
const ACTIONS: usize = 13;
const SEED: u64 = 3;
/// Environment and step.
const FAILURES: [(usize, usize); 3] = [(0, 12), (1, 7), (1, 8)];
const TIMEOUTS: [(usize, usize); 2] = [(0, 25), (1, 39)];

fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name)
}

fn read(name: &str) -> Value {
    let text = std::fs::read_to_string(reference(name)).expect("it is committed");
    serde_json::from_str(&text).expect("it is JSON")
}

/// Numbers in [-1, 1), multiples of 2^-15, as the script makes them.
fn uniform(seed: u32, count: usize) -> Vec<f32> {
    let mut state = seed;
    let next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as f32 / 32_768.0 - 1.0
    };
    std::iter::repeat_with(next).take(count).collect()
}

fn network(seed: u32, widths: &[usize]) -> Network {
    let pairs = widths.windows(2).enumerate();
    let layer = |(index, pair): (usize, &[usize])| {
        let factor = if index + 2 < widths.len() { 0.25 } else { 0.125 };
        let seed = seed + 2 * index as u32;
        let scaled =
            |seed, count, factor: f32| uniform(seed, count).into_iter().map(|x| factor * x).collect();
        let (weight, bias) = (scaled(seed, pair[0] * pair[1], factor), scaled(seed + 1, pair[1], 0.125));
        Layer { weight, bias, inputs: pair[0], outputs: pair[1] }
    };
    Network { layers: pairs.map(layer).collect(), activation: Activation::Relu }
}

fn forward(network: &Network, inputs: &[f32]) -> Vec<f32> {
    let mut outputs = vec![0.0; inputs.len() / network.inputs() * network.outputs()];
    network.forward(inputs, &mut outputs, &mut Scratch::default());
    outputs
}

struct Inputs {
    observations: Vec<f32>,
    truths: Vec<f32>,
    noise: Vec<f32>,
    rewards: Vec<f32>,
    last_states: Vec<f32>,
    timeout_states: Vec<f32>,
}

impl Inputs {
    fn new() -> Self {
        let state = OBSERVED + TRUTHS;
        Self {
            observations: uniform(1, SAMPLES * OBSERVED),
            truths: uniform(2, SAMPLES * TRUTHS),
            noise: uniform(3, SAMPLES * ACTIONS),
            rewards: uniform(4, SAMPLES).into_iter().map(|x| x + 0.5).collect(),
            last_states: uniform(5, ENVIRONMENTS * state),
            timeout_states: uniform(6, TIMEOUTS.len() * state),
        }
    }

    /// What one environment recorded, with its advantages.
    fn records(&self, environment: usize, actor: &Network, critic: &Network, discount: Discount) -> Records {
        let rows =
            |values: &[f32], width: usize| values[environment * STEPS * width..][..STEPS * width].to_vec();
        let (observations, truths) = (rows(&self.observations, OBSERVED), rows(&self.truths, TRUTHS));
        let pairs = observations.chunks_exact(OBSERVED).zip(truths.chunks_exact(TRUTHS));
        let mut states: Vec<f32> = pairs.flat_map(|(own, truths)| [own, truths].concat()).collect();
        states.extend(&self.last_states[environment * (OBSERVED + TRUTHS)..][..OBSERVED + TRUTHS]);
        let means = forward(actor, &observations);
        let actions =
            means.iter().zip(rows(&self.noise, ACTIONS)).map(|(mean, noise)| mean + 0.125 * noise).collect();
        let values = forward(critic, &states);
        let mut ends = vec![None; STEPS];
        let at_limit = forward(critic, &self.timeout_states);
        let of_this = |(owner, _): &&(usize, usize)| *owner == environment;
        FAILURES.iter().filter(of_this).for_each(|(_, step)| ends[*step] = Some(0.0));
        let limits = TIMEOUTS.iter().zip(at_limit).filter(|(end, _)| of_this(end));
        limits.for_each(|((_, step), value)| ends[*step] = Some(value));
        let rewards: Vec<f64> = rows(&self.rewards, 1).into_iter().map(f64::from).collect();
        let (mut advantages, mut targets) = (vec![0.0; STEPS], vec![0.0; STEPS]);
        let track =
            Track { rewards: &rewards, values: &values[..STEPS], ends: &ends, last_value: values[STEPS] };
        estimate(track, discount, &mut advantages, &mut targets);
        let mut records = Records::default();
        (records.observations, records.states, records.means, records.actions) =
            (observations, states, means, actions);
        (records.rewards, records.values, records.ends) = (rewards, values, ends);
        (records.advantages, records.targets) = (advantages, targets);
        records
    }
}

fn settings(case: &Value) -> Settings {
    let number = |key: &str| case[key].as_f64().unwrap_or_else(|| panic!("`{key}` is a number"));
    let count = |key: &str| number(key) as usize;
    let shape = || Shape { hidden: vec![32, 32], activation: Activation::Relu };
    Settings {
        samples: SAMPLES as u64,
        stop_at: None,
        rollout: SAMPLES,
        environments: ENVIRONMENTS,
        minibatch: count("minibatch"),
        epochs: count("epochs"),
        rate: match case["kl_target"].as_f64() {
            Some(target) => Rate::Steered { target, start: number("rate") },
            None => Rate::Constant(number("rate")),
        },
        gamma: number("gamma"),
        lambda: number("lambda"),
        clip: number("clip"),
        advantages: if case["normalise"] == "batch" {
            Normalisation::Batch
        } else {
            Normalisation::Minibatch
        },
        reward_scale: 1.0,
        warm_up: 0,
        policy: shape(),
        value: shape(),
        value_rate: number("value_rate"),
        critic_hidden_follows: false,
        value_coefficient: 0.5,
        privileged: true,
        max_grad_norm: number("max_grad_norm"),
        norm_of_both: false,
        adam_epsilon: 1e-5,
        seed: SEED,
        checkpoint_every: 1,
        std: vec![0.1; ACTIONS],
        std_decay: None,
        limits_are_failures: false,
        step: 0.008,
        round: Round::First,
        backend: settings::Backend::Native,
        device: Device::Cpu,
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn flat(network: &Network) -> Vec<f64> {
    let layers = network.layers.iter().flat_map(|layer| layer.weight.iter().chain(&layer.bias));
    layers.map(|x| f64::from(*x)).collect()
}

/// Largest difference of two lists.
fn distance(found: impl IntoIterator<Item = f64>, expected: &[f64]) -> f64 {
    let found: Vec<f64> = found.into_iter().collect();
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

struct Updated {
    outcome: Outcome,
    next_rate: f64,
    actor: Vec<f64>,
    critic: Vec<f64>,
    advantages: Vec<f64>,
    targets: Vec<f64>,
}

fn updated<B: Backend>(settings: &Settings, backend: B, threads: usize) -> Updated {
    let actor = network(100, &[OBSERVED, 32, 32, ACTIONS]);
    let critic = network(200, &[OBSERVED + TRUTHS, 32, 32, 1]);
    let discount = Discount { gamma: settings.gamma, lambda: settings.lambda };
    let inputs = Inputs::new();
    let records: Vec<Records> =
        (0..ENVIRONMENTS).map(|e| inputs.records(e, &actor, &critic, discount)).collect();
    let mut learner = Learner::new(backend, [&actor, &critic], settings);
    let place = Place { update: 0, share: 0.0 };
    let outcome = learner
        .improve(&records.iter().collect::<Vec<_>>(), settings, place, Pace::to_the_end(threads))
        .expect("it is finite");
    let [of_actor, of_critic] = learner.networks();
    let all = |of: fn(&Records) -> &Vec<f32>| records.iter().flat_map(of).map(|x| f64::from(*x)).collect();
    Updated {
        outcome,
        next_rate: learner.rate,
        actor: flat(&of_actor),
        critic: flat(&of_critic),
        advantages: all(|records| &records.advantages),
        targets: all(|records| &records.targets),
    }
}

#[test]
fn the_inputs_and_the_orders_are_those_of_the_script() {
    let orders: Vec<Vec<usize>> = (0..4)
        .map(|epoch| Stream::new(&format!("{SEED}/train/shuffle/0/{epoch}")).permutation(SAMPLES))
        .collect();
    if std::env::var_os("SPECFORGE_BLESS").is_some() {
        let text = serde_json::to_string(&orders).expect("numbers");
        std::fs::write(reference("ppo_orders.json"), format!("{text}\n")).expect("it can be written");
    }
    assert_eq!(read("ppo_orders.json"), serde_json::json!(orders));
    let Inputs { observations, truths, noise, rewards, last_states, timeout_states } = Inputs::new();
    let named = [
        ("observations", observations),
        ("truths", truths),
        ("noise", noise),
        ("rewards", rewards),
        ("last_states", last_states),
        ("timeout_states", timeout_states),
    ];
    let sums = &read("ppo_update.json")["sums"];
    for (name, values) in named {
        let sum: f64 = values.iter().map(|x| f64::from(*x)).sum();
        assert!((sum - sums[name].as_f64().expect("a number")).abs() < 1e-9, "{name}: {sum}");
    }
}

#[test]
fn a_whole_update_equals_that_of_pytorch() {
    equals_that_of_pytorch(Native);
    #[cfg(feature = "torch")]
    Torch::available().into_iter().for_each(equals_that_of_pytorch);
}

fn equals_that_of_pytorch<B: Backend>(backend: B) {
    let reference = read("ppo_update.json");
    for (name, case) in reference["cases"].as_object().expect("a table") {
        let name = format!("{name}, {backend:?}");
        let (settings, expected) = (settings(&case["settings"]), &case["outcome"]);
        let every = case["settings"]["every"].as_u64().expect("a count") as usize;
        let found = updated(&settings, backend, 2);
        let number = |key: &str| expected[key].as_f64().expect("a number");

        // Advantages are f32 numbers of a size of 10.
        assert!(distance(found.advantages.clone(), &numbers(&case["advantages"])) < 5e-6, "{name}");
        assert!(distance(found.targets.clone(), &numbers(&case["targets"])) < 5e-6, "{name}");

        // A step of Adam moves a parameter by about the step size; the update has 4 to 12 of them.
        let (rate, value_rate) = (number_of(&case["settings"], "rate"), settings.value_rate);
        let actor = distance(found.actor.iter().copied().step_by(every), &numbers(&case["actor"])) / rate;
        let critic =
            distance(found.critic.iter().copied().step_by(every), &numbers(&case["critic"])) / value_rate;
        println!("{name}: parameters differ by {actor:.1e} and {critic:.1e} of a step size");
        assert!(actor < 5e-4 && critic < 5e-4, "{name}: {actor} and {critic} of a step size");

        let start =
            [network(100, &[OBSERVED, 32, 32, ACTIONS]), network(200, &[OBSERVED + TRUTHS, 32, 32, 1])];
        let moved = distance(flat(&start[0]).into_iter().step_by(every), &numbers(&case["actor"])) / rate;
        assert!(moved > 3.0, "{name}: the update moves parameters by {moved} step sizes");

        let outcome = found.outcome;
        let relative = |found: f64, key: &str| {
            let difference = (found - number(key)).abs() / number(key).abs();
            println!("{name}: {key} {found:.9}, differs by {difference:.1e}");
            assert!(difference < 2e-6, "{name}: {key} is {found}, expected {}", number(key));
        };
        relative(outcome.divergence, "divergence");
        relative(outcome.actor_norm, "actor_norm");
        relative(outcome.critic_norm, "critic_norm");
        relative(outcome.value_loss, "value_loss");
        relative(found.next_rate, "next_rate");
        assert_eq!(outcome.epochs, number("epochs") as u64, "{name}");
        assert!(
            (outcome.clip_fraction - number("clip_fraction")).abs() < 1e-12,
            "{name}: {}",
            outcome.clip_fraction
        );
        assert!(outcome.clip_fraction > 0.05, "{name}: samples are clipped");
    }
}

fn number_of(table: &Value, key: &str) -> f64 {
    table[key].as_f64().expect("a number")
}

#[test]
fn the_cases_bound_the_gradient_end_early_and_have_a_smaller_last_minibatch() {
    let cases = &read("ppo_update.json")["cases"];
    let whole = &cases["minibatch_normalised"];
    let norms = numbers(&whole["outcome"]["actor_norms"]);
    assert_eq!(norms.len(), 9);
    assert!(norms.iter().any(|norm| *norm > 0.5), "no gradient was shortened: {norms:?}");
    let early = &cases["batch_normalised"];
    assert!(number_of(&early["outcome"], "epochs") < number_of(&early["settings"], "epochs"));
    assert_ne!(SAMPLES % number_of(&early["settings"], "minibatch") as usize, 0);
}

#[test]
fn an_update_with_another_constant_is_told_apart() {
    // A hundred times what the comparison above tolerates.
    let case = &read("ppo_update.json")["cases"]["minibatch_normalised"];
    let expected = numbers(&case["actor"]);
    let changed: [fn(&mut Settings); 5] = [
        |settings| settings.clip = 0.25,
        |settings| settings.lambda = 0.96,
        |settings| settings.adam_epsilon = 1e-8,
        |settings| settings.max_grad_norm = 10.0,
        |settings| settings.advantages = Normalisation::Batch,
    ];
    for (index, change) in changed.into_iter().enumerate() {
        let mut settings = settings(&case["settings"]);
        change(&mut settings);
        let difference = distance(updated(&settings, Native, 1).actor, &expected) / 1e-3;
        assert!(difference > 5e-2, "change {index} moves parameters by only {difference} of a step size");
    }
}
