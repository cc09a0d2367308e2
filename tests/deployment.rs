//! Evaluation and deployment with policies whose behaviour is known: a network of zeros commands the default
//! pose under position control and nothing at all under torque control.

#![cfg(all(feature = "rapier", feature = "mujoco"))]

use specforge::deploy::{Policy, PolicyError, Provenance, Transfer};
use specforge::diag::{Sink, Sources};
use specforge::env::Blueprint;
use specforge::evaluate::{Evaluation, EvaluationError, Protocol, Subject, episodes};
use specforge::kinds;
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
    let source =
        sources.add(name, if text.contains("kind") { text.to_owned() } else { format!("kind = \"{name}\"\n{text}") });
    let node = specforge::syntax::parse(&sources, source, &mut sink).unwrap();
    let registry = Registry { noun: "kind", kinds, extra: &[], reserved: &["kind"] };
    let table = Decoder::new(&mut sink).of_kind(&node, &registry, name, None);
    table.unwrap_or_else(|| panic!("{name}: {sink:?}"))
}

fn number(si: f64) -> Value {
    Value::Quantity(Quantity { si, text: si.to_string() })
}

fn terms(kinds: &[&'static Kind], rows: &[(&str, &str)]) -> Value {
    Value::Table(rows.iter().map(|(name, text)| ((*name).into(), Value::Table(section(kinds, name, text)))).collect())
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
    let physics = Table::from([("engine".into(), Value::Text("rapier".into())), ("rate".into(), number(500.0))]);
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
    transfer.run(policy, open("mujoco").unwrap(), 2, &|_| true).unwrap()
}

#[test]
fn holding_the_default_pose_stands_in_both_engines_with_the_same_figures() {
    let protocol = Protocol { episodes: 3, ..Protocol::default() };
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
    let result = evaluate(&policy(TORQUE), &Protocol { episodes: 2, time_limit: Some(3.0), ..Protocol::default() }, 1);
    for episode in &result.episodes {
        assert!(!episode.survived && episode.duration < 3.0, "{episode:?}");
        assert_eq!((episode.end.as_str(), episode.torque_rms), ("base_height", 0.0));
    }
    assert_eq!(result.time_limit, 3.0);
}

#[test]
fn an_evaluation_does_not_depend_on_threads_and_its_episodes_differ() {
    let policy = policy(POSITION);
    let protocol = Protocol { episodes: 4, time_limit: Some(0.2), noise: true, ..Protocol::default() };
    let one = evaluate(&policy, &protocol, 1);
    assert_eq!(one, evaluate(&policy, &protocol, 3));
    assert_ne!(one.episodes[0].torque_rms, one.episodes[2].torque_rms);
    let other = evaluate(&policy, &Protocol { seed: 7, ..protocol }, 1);
    assert_ne!(one.episodes[0].torque_rms, other.episodes[0].torque_rms);
}

#[test]
fn episodes_start_standing_at_the_phases_of_the_initial_table_in_turn() {
    let mut policy = policy(POSITION);
    let start = section(&kinds::initial::kinds(), "default_pose", "phases = [0.25, 0.75]");
    policy.blueprint.fields.insert("initial".into(), Value::Table(start));
    let protocol = Protocol { episodes: 2, time_limit: Some(0.04), perturbation: 0.0, ..Protocol::default() };
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
    let protocol = Protocol { episodes: 50, time_limit: Some(0.04), ..Protocol::default() };
    let result = episodes(&subject, &protocol, 1, &|finished| finished < 2);
    assert!(matches!(result, Err(EvaluationError::Interrupted)));
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
        assert!(contract.inputs.iter().enumerate().all(|(index, input)| input.index == index && input.rate == 250.0));
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
    let subject =
        Subject { network: &network, blueprint: &blueprint, engine: open("rapier").unwrap(), contact_time: None };
    let result = episodes(&subject, &Protocol::default(), 1, &|_| true);
    assert!(matches!(result, Err(EvaluationError::Shape { side: "inputs", expected: 30, found: 29 })));
}

#[test]
fn a_transfer_reads_its_table_and_writes_the_robot_as_mjcf() {
    let text = "kind = \"transfer\"\nengine = \"mujoco\"\nrate = \"1000 Hz\"\nepisodes = 5\ncontact_time = \"5 ms\"";
    let table = section(&kinds::deploy::kinds(), "mujoco", text);
    let transfer = Transfer::new(Section::new(&table));
    assert_eq!((transfer.rate, transfer.contact_time, transfer.protocol.episodes), (1000.0, Some(0.005), 5));
    assert!(!transfer.protocol.randomize && !transfer.protocol.noise);
    let drawn = section(&kinds::deploy::kinds(), "mujoco", &format!("{text}\nrandomize = true\nnoise = true"));
    let Protocol { randomize, noise, .. } = Transfer::new(Section::new(&drawn)).protocol;
    assert!(randomize && noise);
    let xml = transfer.mjcf(&policy(TORQUE)).unwrap();
    assert!(xml.contains("timestep=\"0.001\"") && xml.contains("solref=\"0.005 1\"") && xml.contains("L_Knee_Joint"));
}
