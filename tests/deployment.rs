//! Evaluation and deployment with policies whose behaviour is known: a network of zeros commands the default
//! pose under position control and nothing at all under torque control.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

use std::collections::BTreeMap;
use std::sync::Mutex;

use specforge::deploy::{Contract, Policy, PolicyError, Provenance, Transfer};
use specforge::diag::{Sink, Sources};
use specforge::env::{Blueprint, Randomized};
use specforge::evaluate::follower::{Count, Follower, Measured};
use specforge::evaluate::{Condition, Evaluation, EvaluationError, Protocol, Subject, episodes, followed};
use specforge::kinds::{self, motion::Motion};
use specforge::learn::{Activation, Layer, Network};
use specforge::robot::{Robot, embedded, file, from_table};
use specforge::sim::open;
use specforge::spec::decode::{self, Decoder, Registry};
use specforge::spec::{Kind, Quantity, Section, Table, Value};
use specforge::stream::Stream;

const TORQUE: &str = "kind = \"torque\"\nrate = \"250 Hz\"\nstd = \"10 %\"\ndelay = \"4 ms\"";
const POSITION: &str =
    "kind = \"position\"\nrate = \"250 Hz\"\nservo_rate = \"500 Hz\"\nstiffness = \"100 %\"\nstd = \"3 %\"";

fn robot(name: &str) -> Robot {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(name, embedded(name).unwrap());
    let table = decode::document(&sources, source, file::PARAMS, &mut sink).unwrap().table;
    from_table(name, &table).0.unwrap()
}

/// A decoded table of a kind; `name` stands for a kind that is not written.
fn section(kinds: &[&'static Kind], name: &str, text: &str) -> Table {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(
        name,
        if text.contains("kind") { text.to_owned() } else { format!("kind = \"{name}\"\n{text}") },
    );
    let node = specforge::syntax::parse(&sources, source, &mut sink).unwrap();
    let registry = Registry { noun: "kind", kinds, extra: &[], reserved: &["kind"] };
    let table = Decoder::new(&mut sink).of_kind(&node, &registry, name, None);
    table.unwrap_or_else(|| panic!("{name}: {sink:?}"))
}

fn number(si: f64) -> Value {
    Value::Quantity(Quantity { si, text: si.to_string() })
}

fn terms(kinds: &[&'static Kind], rows: &[(&str, &str)]) -> Value {
    Value::Table(
        rows.iter().map(|(name, text)| ((*name).into(), Value::Table(section(kinds, name, text)))).collect(),
    )
}

/// TOCABI that stands, under this action.
fn blueprint(action: &str) -> Blueprint {
    let mut rewards = terms(&kinds::reward::kinds(), &[("base_orientation", "k = \"13.2 /rad\"")]);
    if let Value::Table(rewards) = &mut rewards
        && let Some(Value::Table(term)) = rewards.get_mut("base_orientation")
    {
        term.insert("weight".into(), number(0.3));
    }
    let observe = [
        ("base_orientation", ""),
        ("joint_position", "noise = { normal = [\"0 rad\", \"1e-4 rad\"] }"),
        ("joint_velocity", "low_pass = \"4 Hz\""),
        ("phase", ""),
        ("command", ""),
    ];
    let physics =
        Table::from([("engine".into(), Value::Text("rapier".into())), ("rate".into(), number(500.0))]);
    let one = |kinds: &[&'static Kind], name: &str, text: &str| Value::Table(section(kinds, name, text));
    let fields = Table::from([
        ("physics".into(), Value::Table(physics)),
        ("terrain".into(), one(&kinds::terrain::kinds(), "flat", "friction = 1.0")),
        ("task".into(), one(&kinds::task::kinds(), "stand", "episode = \"1.2 s\"")),
        ("initial".into(), one(&kinds::initial::kinds(), "default_pose", "")),
        ("observe".into(), terms(&kinds::observe::kinds(), &observe)),
        ("reward".into(), rewards),
        ("terminate".into(), terms(&kinds::terminate::kinds(), &[("base_height", "below = \"0.6 m\"")])),
        ("action".into(), one(&kinds::action::kinds(), "action", action)),
    ]);
    Blueprint::new(fields, robot("tocabi"), None).unwrap()
}

fn zeros(inputs: usize, outputs: usize) -> Network {
    let layer = Layer { weight: vec![0.0; inputs * outputs], bias: vec![0.0; outputs], inputs, outputs };
    Network { layers: vec![layer], activation: Activation::Relu }
}

fn policy(action: &str) -> Policy {
    let blueprint = blueprint(action);
    let sizes = blueprint.sizes();
    Policy::new(zeros(sizes.observation, sizes.action), blueprint, Provenance::of_build(None)).unwrap()
}

fn evaluate(policy: &Policy, protocol: &Protocol, threads: usize) -> Evaluation {
    let (network, blueprint) = (&policy.network, &policy.blueprint);
    let subject = Subject { network, blueprint, engine: open("rapier").unwrap(), contact_time: None };
    episodes(&subject, protocol, threads, &|_| true).unwrap()
}

fn mujoco(policy: &Policy, protocol: Protocol) -> Evaluation {
    let transfer = Transfer { engine: "mujoco".into(), rate: 2000.0, contact_time: None, protocol };
    transfer.run(policy, open("mujoco").unwrap(), 2, &Count(&|_| true)).unwrap()
}

#[test]
fn holding_the_default_pose_stands_in_both_engines_with_the_same_figures() {
    let protocol = Protocol::of(3);
    let policy = Policy::from_bytes(&policy(POSITION).to_bytes()).unwrap();
    let weight = policy.blueprint.robot.total_mass() * 9.81;
    let results = [evaluate(&policy, &protocol, 2), mujoco(&policy, protocol)];
    assert_eq!(results[0].engine, "rapier");
    assert_eq!(
        (results[1].engine.as_str(), results[1].physics_rate, results[1].control_rate),
        ("mujoco", 2000.0, 250.0)
    );
    for result in &results {
        assert_eq!(result.episodes.len(), 3);
        for episode in &result.episodes {
            assert!(episode.survived && episode.end == "time_out", "{}: {}", result.engine, episode.end);
            assert!((episode.duration - 1.2).abs() < 1e-9);
            assert!(episode.flight < 0.05 && episode.distance.abs() < 0.1, "{}: {episode:?}", result.engine);
            let drift = episode.drift.expect("it is measured");
            assert!(drift >= episode.distance.abs() && drift < 0.1, "{}: {drift}", result.engine);
            assert!(episode.peak_foot_force > 0.4 * weight && episode.peak_foot_force < 3.0 * weight);
            // A reward of 0.3 * exp(-13.2 angle) per control step.
            let reward = episode.reward_per_second["base_orientation"];
            assert!(reward > 30.0 && reward < 75.0, "{}: {reward} per second", result.engine);
        }
        assert_eq!(result.trace.time.len(), 300);
        assert_eq!(result.trace.joints.len(), 12);
    }
    let [one, other] = results.map(|result| result.episodes[0].torque_rms);
    // How dry joint friction shares the load between the legs is not unique.
    assert!((one / other - 1.0).abs() < 0.25, "torque rms {one} N m in rapier, {other} N m in MuJoCo");
}

#[test]
fn without_torque_the_robot_falls_and_the_episode_says_why() {
    let result = evaluate(&policy(TORQUE), &Protocol { time_limit: Some(3.0), ..Protocol::of(2) }, 1);
    for episode in &result.episodes {
        assert!(!episode.survived && episode.duration < 3.0, "{episode:?}");
        assert_eq!((episode.end.as_str(), episode.torque_rms), ("base_height", 0.0));
    }
    assert_eq!(result.time_limit, 3.0);
}

#[test]
fn a_policy_that_explores_acts_with_the_deviation_of_its_training_and_the_same_way_every_time() {
    let policy = policy(TORQUE);
    let protocol = Protocol { time_limit: Some(0.4), explore: true, ..Protocol::of(4) };
    let explored = evaluate(&policy, &protocol, 1);
    assert_eq!(explored, evaluate(&policy, &protocol, 3));
    // The network's output is zero, so what is left is the exploration: a share of each joint's effort limit.
    let joints = policy.blueprint.robot.joints();
    let deviations = policy.blueprint.deviations();
    let limits = policy.blueprint.robot.links.iter().map(|link| link.joint.effort_limit);
    let square: f64 = limits.zip(&deviations).map(|(limit, std)| (limit * std) * (limit * std)).sum();
    let expected = (square / joints as f64).sqrt();
    let found = explored.episodes.iter().map(|episode| episode.torque_rms).sum::<f64>() / 4.0;
    assert!((found / expected - 1.0).abs() < 0.1, "{found} N m instead of {expected}");
    assert_ne!(explored.episodes[0].torque_rms, explored.episodes[1].torque_rms);
}

#[test]
fn an_evaluation_does_not_depend_on_threads_and_its_episodes_differ() {
    let policy = policy(POSITION);
    let protocol = Protocol { time_limit: Some(0.2), noise: true, ..Protocol::of(4) };
    let one = evaluate(&policy, &protocol, 1);
    assert_eq!(one, evaluate(&policy, &protocol, 3));
    assert_ne!(one.episodes[0].torque_rms, one.episodes[2].torque_rms);
    let other = evaluate(&policy, &Protocol { seed: 7, ..protocol }, 1);
    assert_ne!(one.episodes[0].torque_rms, other.episodes[0].torque_rms);
}

/// A ground from its text.
fn ground(text: &str) -> Option<Table> {
    Some(section(&kinds::terrain::kinds(), "terrain", text))
}

const BOX: &str = "kind = \"box_obstacle\"\nfriction = 1.0\nheight = \"1 cm\"\ndistance = \"60 cm\"";

#[test]
fn an_evaluation_on_ground_of_its_own_tells_of_the_obstacle() {
    let policy = policy(POSITION);
    let level = evaluate(&policy, &Protocol { time_limit: Some(0.4), ..Protocol::of(1) }, 1);
    assert_eq!((level.obstacle, level.episodes[0].crossed), (None, None));
    let protocol = Protocol { time_limit: Some(0.4), terrain: ground(BOX), ..Protocol::of(1) };
    let ahead = evaluate(&policy, &protocol, 1);
    assert_eq!(ahead.obstacle.map(|edges| edges.map(|edge| (edge * 1e9).round() / 1e9)), Some([0.4, 0.8]));
    assert_eq!(ahead.episodes[0].crossed, Some(false));
    let ratio = ahead.episodes[0].torque_rms / level.episodes[0].torque_rms;
    assert!((ratio - 1.0).abs() < 0.01, "it stands before the box: {ratio}");
    assert_eq!(mujoco(&policy, protocol.clone()).episodes[0].crossed, Some(false));
    // A box that lies behind the robot has been passed from the start.
    let behind = BOX.replace("60 cm", "0 cm") + "\nlength = \"1 cm\"\nwidth = \"1 cm\"";
    let protocol = Protocol { perturbation: 0.0, terrain: ground(&behind), ..protocol };
    let passed = evaluate(&policy, &protocol, 1);
    let furthest = passed.trace.base_position.iter().map(|place| place[0]).fold(0.0, f64::max);
    assert_eq!(passed.episodes[0].crossed, Some(furthest > 0.005));
}

#[test]
fn the_trace_tells_the_ankle_torques_and_where_the_soles_are() {
    let result = evaluate(&policy(POSITION), &Protocol { time_limit: Some(0.4), ..Protocol::of(1) }, 1);
    let trace = &result.trace;
    let ankles = (0..12).filter(|joint| trace.joints[*joint].contains("AnklePitch")).collect::<Vec<_>>();
    assert_eq!(ankles.len(), 2);
    let torques = trace.torque.iter().flat_map(|row| ankles.iter().map(|joint| row[*joint].abs()));
    assert_eq!(result.episodes[0].peak_ankle_torque, Some(torques.fold(0.0, f64::max)));
    assert_eq!(trace.foot_position.len(), trace.time.len());
    for [left, right] in &trace.foot_position {
        assert!(
            left[2].abs() < 5e-3 && right[2].abs() < 5e-3,
            "both soles are on the ground: {left:?} {right:?}"
        );
        assert!(left[1] > 0.05 && right[1] < -0.05, "left and right of the base: {left:?} {right:?}");
    }
}

#[test]
fn every_episode_of_a_grid_of_speeds_is_measured_against_its_own_command() {
    let text = "kind = \"speeds\"\nfrom = \"0.1 m/s\"\nto = \"0.3 m/s\"\nstep = \"0.1 m/s\"\nrepeats = 2\n\
                time_limit = \"0.2 s\"";
    let table = section(&kinds::evaluate::kinds(), "speeds", text);
    let result = evaluate(&policy(POSITION), &Protocol::new(Section::new(&table)), 2);
    assert_eq!(result.command, None);
    let commands: Vec<Option<f64>> = result.episodes.iter().map(|episode| episode.command).collect();
    assert_eq!(commands, [0.1, 0.1, 0.2, 0.2, 0.3, 0.3].map(Some));
    for episode in &result.episodes {
        let asked = episode.command.expect("every episode has its own");
        assert!(
            (episode.speed_error - (episode.speed - asked).abs()).abs() < 1e-12 && episode.speed_error > 0.05
        );
    }
    let alike = evaluate(&policy(POSITION), &Protocol { time_limit: Some(0.04), ..Protocol::of(2) }, 1);
    assert!(alike.episodes.iter().all(|episode| episode.command.is_none()), "the evaluation has it");
}

/// The protocol of parameter sets, and what it measures in an engine.
fn sets(names: &str, engine: &str, text: &str) -> Evaluation {
    let text = format!("kind = \"parameter_sets\"\ntime_limit = \"0.4 s\"\nparameters = {names}\n{text}");
    let table = section(&kinds::evaluate::kinds(), "sets", &text);
    let policy = policy(POSITION);
    let subject = Subject {
        network: &policy.network,
        blueprint: &policy.blueprint,
        engine: open(engine).unwrap(),
        contact_time: None,
    };
    episodes(&subject, &Protocol::new(Section::new(&table)), 2, &|_| true).unwrap()
}

#[test]
fn a_parameter_set_is_the_robot_that_its_factors_say() {
    for engine in ["rapier", "mujoco"] {
        // The standing force on the feet is the weight.
        let masses = sets("[\"link_mass\"]", engine, "sets = 6");
        let weight = policy(POSITION).blueprint.robot.total_mass() * 9.81;
        for episode in &masses.episodes {
            let factor = episode.parameters["link_mass"];
            assert!(
                (0.7..1.3).contains(&factor) && episode.parameters.len() == 1,
                "{:?}",
                episode.parameters
            );
            let lowest = 0.5 * factor * weight;
            assert!(
                episode.peak_foot_force > 0.9 * lowest,
                "{engine}: {} N of {lowest} N",
                episode.peak_foot_force
            );
        }
        let heaviest = |first: &specforge::evaluate::Episode, second: &specforge::evaluate::Episode| {
            first.parameters["link_mass"] > second.parameters["link_mass"]
                && first.torque_rms > second.torque_rms
        };
        let mut sorted = masses.episodes.clone();
        sorted.sort_by(|a, b| b.parameters["link_mass"].total_cmp(&a.parameters["link_mass"]));
        assert!(heaviest(&sorted[0], &sorted[5]), "{engine}: heavier robots need more torque");
        assert!(masses.trace.foot_position.is_empty());
    }
}

#[test]
fn robots_with_longer_and_shorter_legs_start_on_the_ground_and_stand() {
    for engine in ["rapier", "mujoco"] {
        let legs = sets("[\"leg_length\"]", engine, "sets = 4\nscale = [0.7, 1.3]");
        for episode in &legs.episodes {
            let factor = episode.parameters["leg_length"];
            assert!(episode.survived && episode.flight < 0.05, "{engine}, legs of {factor}: {episode:?}");
        }
        // The trace is that of the first set: its base is as much higher as its legs are longer.
        let (robot, factor) = (robot("tocabi"), legs.episodes[0].parameters["leg_length"]);
        let mut stretched = robot.clone();
        stretched.stretch_legs(factor);
        let height = legs.trace.base_position[0][2];
        assert!(
            (height - stretched.standing_height).abs() < 0.01,
            "{engine}: {height} m for a factor of {factor}"
        );
        assert!((stretched.standing_height - robot.standing_height).abs() > 0.01);
    }
}

#[test]
fn sets_are_the_same_for_every_policy_and_follow_from_their_seed() {
    let names = "[\"link_mass\", \"action_delay\"]";
    let of = |names: &str, text: &str| {
        let found = sets(names, "rapier", &format!("sets = 3\n{text}"));
        found.episodes.into_iter().map(|episode| episode.parameters).collect::<Vec<_>>()
    };
    assert_eq!(of(names, ""), of(names, ""));
    assert_ne!(of(names, ""), of(names, "seed = 7"));
    assert_ne!(of(names, ""), of(names, "sampling = \"uniform\""));
}

#[test]
fn an_evaluation_draws_rows_of_its_own() {
    let policy = policy(POSITION);
    let text = "impulse = \"20 N*s\"\nduration = \"0.1 s\"\nevery = \"0.2 s\"";
    let Value::Table(rows) = terms(&kinds::randomize::kinds(), &[("push", text)]) else {
        unreachable!("a table")
    };
    let run = |randomized: Randomized| {
        let condition = Condition { randomized, ..Condition::default() };
        let protocol = Protocol { conditions: vec![condition], time_limit: Some(0.3), ..Protocol::default() };
        evaluate(&policy, &protocol, 1).trace.base_position
    };
    let [still, trained] = [Randomized::Nothing, Randomized::AsTrained].map(run);
    assert_eq!(still, trained, "training draws nothing");
    assert_ne!(still, run(Randomized::By(std::sync::Arc::new(rows))));
}

#[test]
fn episodes_start_standing_at_the_phases_of_the_initial_table_in_turn() {
    let mut policy = policy(POSITION);
    let start = section(&kinds::initial::kinds(), "default_pose", "phases = [0.25, 0.75]");
    policy.blueprint.fields.insert("initial".into(), Value::Table(start));
    let protocol = Protocol { time_limit: Some(0.04), perturbation: 0.0, ..Protocol::of(2) };
    let result = evaluate(&policy, &protocol, 1);
    let rate = result.control_rate;
    // The first control step is over when the first row is written; a cycle of standing takes 2 s.
    assert!((result.trace.phase[0] - 0.25 - 0.5 / rate).abs() < 1e-9, "{}", result.trace.phase[0]);
    assert_eq!(policy.blueprint.starts(), [0.25, 0.75]);
    let none = section(&kinds::initial::kinds(), "default_pose", "phases = []");
    policy.blueprint.fields.insert("initial".into(), Value::Table(none));
    assert_eq!(policy.blueprint.starts(), [0.0]);
}

#[test]
fn an_evaluation_stops_when_it_is_told_to() {
    let policy = policy(POSITION);
    let (network, blueprint) = (&policy.network, &policy.blueprint);
    let subject = Subject { network, blueprint, engine: open("rapier").unwrap(), contact_time: None };
    let protocol = Protocol { time_limit: Some(0.04), ..Protocol::of(50) };
    let result = episodes(&subject, &protocol, 1, &|finished| finished < 2);
    assert!(matches!(result, Err(EvaluationError::Interrupted)));
}

/// A follower that stops after a number of episodes and hands what it was told to the next run.
struct Relay {
    earlier: BTreeMap<usize, Measured>,
    taken: Mutex<BTreeMap<usize, Measured>>,
    stop: usize,
}

impl Follower for Relay {
    fn known(&self) -> BTreeMap<usize, Measured> {
        self.earlier.clone()
    }

    fn takes(&self, index: usize, measured: &Measured, done: usize) -> bool {
        assert!(!self.earlier.contains_key(&index), "episode {index} was measured before");
        self.taken.lock().unwrap().insert(index, measured.clone());
        done < self.stop
    }
}

#[test]
fn an_interrupted_evaluation_goes_on_where_it_stopped_and_ends_the_same() {
    let policy = policy(POSITION);
    let (network, blueprint) = (&policy.network, &policy.blueprint);
    let subject = Subject { network, blueprint, engine: open("rapier").unwrap(), contact_time: None };
    let protocol = Protocol { time_limit: Some(0.04), noise: true, ..Protocol::of(7) };
    let relay = |earlier, stop| Relay { earlier, taken: Mutex::default(), stop };
    let first = relay(BTreeMap::new(), 3);
    assert!(matches!(followed(&subject, &protocol, 1, &first), Err(EvaluationError::Interrupted)));
    let taken = first.taken.into_inner().unwrap();
    assert_eq!(taken.len(), 3);
    let second = relay(taken, usize::MAX);
    let whole = followed(&subject, &protocol, 2, &second).unwrap();
    assert_eq!(second.taken.into_inner().unwrap().len(), 4);
    assert_eq!(whole, evaluate(&policy, &protocol, 1));
}

#[test]
fn the_contract_lists_every_input_and_output_and_survives_the_file() {
    for (action, scale, unit) in [(TORQUE, 289.0, "N*m"), (POSITION, 1.75, "rad")] {
        let policy = policy(action);
        let again = Policy::from_bytes(&policy.to_bytes()).unwrap();
        assert_eq!((&again.contract, &again.network), (&policy.contract, &policy.network));
        assert_eq!(again.to_bytes(), policy.to_bytes());
        let contract = &again.contract;
        assert_eq!((contract.inputs.len(), contract.outputs.len()), (30, 13));
        assert!(
            contract
                .inputs
                .iter()
                .enumerate()
                .all(|(index, input)| input.index == index && input.rate == 250.0)
        );
        let knee = &contract.outputs[3];
        assert_eq!((knee.joint.as_deref(), knee.unit.as_str()), (Some("L_Knee_Joint"), unit));
        assert!((knee.scale - scale).abs() < 1e-9, "{}", knee.scale);
        assert_eq!(contract.outputs[12].limits, [0.0, 1.0]);
        // A filter of 4 Hz sampled at 500 Hz.
        let share = 0.002 / (1.0 / (std::f64::consts::TAU * 4.0) + 0.002);
        assert!((contract.filter.share - share).abs() < 1e-12);
        assert_eq!(contract.symmetry.mirror[0].image, "R_HipYaw_Joint");
    }
    assert!(policy(TORQUE).contract.law.sentence.contains("held for 4 ms, delayed 4 ms"));
    assert!(policy(TORQUE).contract.law.stiffness.is_empty());
    assert_eq!(policy(POSITION).contract.law.stiffness[3], 3700.0);
}

#[test]
fn the_contract_of_a_standing_policy_says_how_its_phase_moves() {
    let policy = policy(TORQUE);
    let contract = &policy.contract;
    let signals: Vec<&str> = contract.inputs.iter().map(|input| input.signal.as_str()).collect();
    assert!(signals.contains(&"phase_sin") && signals.contains(&"phase_cos"), "{signals:?}");
    // As a reader of the contract advances the phase: a / (period * control rate) per control step.
    let step = 1.0 / (contract.phase.period * contract.rates.control);
    let phase = evaluate(&policy, &Protocol::of(1), 1).trace.phase;
    let moved = phase.windows(2).map(|pair| (pair[1] - pair[0]).rem_euclid(1.0));
    assert!(
        phase.len() > 10 && moved.clone().all(|moved| (moved - step).abs() < 1e-9),
        "{:?}",
        moved.take(3).collect::<Vec<_>>()
    );
}

#[test]
fn a_phase_action_that_is_a_share_of_the_cycle_speeds_it_up_by_the_seconds_of_the_period() {
    let motion = Motion { name: "walk".into(), period: 1.8, speed: 0.2, samples: Vec::new() };
    let contract = |action: &str| {
        let Blueprint { fields, robot, .. } = blueprint(action);
        Contract::new(&fields, &robot, Some(&motion), Provenance::of_build(None))
    };
    let (time, share) = (contract(TORQUE), contract(&format!("{TORQUE}\nphase_action = \"share\"")));
    assert_eq!((time.phase.gain, share.phase.gain), (1.0, 1.8));
    assert!(share.difference(&time).is_some_and(|words| words.starts_with("phase")));
    let [time_text, share_text] = [&time, &share].map(|contract| serde_json::to_string(contract).unwrap());
    assert!(!time_text.contains("\"gain\""), "contracts of before say nothing of it");
    assert_eq!(serde_json::from_str::<Contract>(&time_text).unwrap(), time);
    assert_eq!(serde_json::from_str::<Contract>(&share_text).unwrap(), share);
}

#[test]
fn a_policy_that_does_not_fit_is_refused_with_its_code() {
    let good = policy(TORQUE);
    let wide = Policy::new(zeros(31, 13), good.blueprint.clone(), Provenance::default()).unwrap_err();
    assert_eq!(wide.code(), "E0502");
    let mut broken = zeros(30, 13);
    broken.layers[0].bias[0] = f32::NAN;
    let broken = Policy::new(broken, good.blueprint.clone(), Provenance::default()).unwrap_err();
    assert_eq!(broken.code(), "R0001");
    // A scale that was changed in the file.
    let mut changed = good.clone();
    changed.contract.inputs[5].scale *= 2.0;
    let changed = Policy::from_bytes(&changed.to_bytes()).unwrap_err();
    assert!(matches!(&changed, PolicyError::Contract(text) if text.starts_with("input 5")), "{changed}");
    // Another robot.
    assert_eq!(good.check_robot(&robot("atlas")).unwrap_err().code(), "R0002");
    assert!(good.check_robot(&robot("tocabi")).is_ok());
    let bytes = good.to_bytes();
    assert_eq!(Policy::from_bytes(&bytes[..bytes.len() / 2]).unwrap_err().code(), "R0002");
}

#[test]
fn a_network_for_another_observation_is_not_evaluated() {
    let blueprint = blueprint(TORQUE);
    let network = Network::orthogonal(&[29, 8, 13], Activation::Relu, &mut Stream::new("test"));
    let subject = Subject {
        network: &network,
        blueprint: &blueprint,
        engine: open("rapier").unwrap(),
        contact_time: None,
    };
    let result = episodes(&subject, &Protocol::default(), 1, &|_| true);
    assert!(matches!(result, Err(EvaluationError::Shape { side: "inputs", expected: 30, found: 29 })));
}

#[test]
fn a_transfer_reads_its_table_and_writes_the_robot_as_mjcf() {
    let text =
        "kind = \"transfer\"\nengine = \"mujoco\"\nrate = \"1000 Hz\"\nepisodes = 5\ncontact_time = \"5 ms\"";
    let table = section(&kinds::deploy::kinds(), "mujoco", text);
    let transfer = Transfer::new(Section::new(&table));
    assert_eq!(
        (transfer.rate, transfer.contact_time, transfer.protocol.conditions.len()),
        (1000.0, Some(0.005), 5)
    );
    let randomized = |protocol: &Protocol| protocol.conditions[0].randomized.clone();
    assert!(randomized(&transfer.protocol) == Randomized::Nothing && !transfer.protocol.noise);
    let drawn =
        section(&kinds::deploy::kinds(), "mujoco", &format!("{text}\nrandomize = true\nnoise = true"));
    let protocol = Transfer::new(Section::new(&drawn)).protocol;
    assert!(randomized(&protocol) == Randomized::AsTrained && protocol.noise);
    let xml = transfer.mjcf(&policy(TORQUE)).unwrap();
    assert!(
        xml.contains("timestep=\"0.001\"")
            && xml.contains("solref=\"0.005 1\"")
            && xml.contains("L_Knee_Joint")
    );
}
