//! A made-up comparison of two running policies: plausible curves and traces without a simulator.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use specforge::evaluate::outcome::{Episode, Evaluation, Trace};
use specforge::kinds::motion::{Frame, Motion};
use specforge::learn::finding::Finding;
use specforge::report::model::{Arm, Failure, Measured, Pretrain, ReportInput, StageRecord, Update};
use specforge::report::request::Request;
use specforge::robot::{Body, Foot, Joint, Link, Robot};
use specforge::spec::{Quantity, Sampler, Table, Value};
use specforge::stream::Stream;

/// Duration of a cycle of the made-up gait in s.
const PERIOD: f64 = 0.72;
/// Its forward speed in m/s.
const SPEED: f64 = 0.8;

/// The whole input.
pub fn input() -> ReportInput {
    ReportInput {
        name: "atlas_run_torque".into(),
        summary: "Atlas runs under direct joint torque commands".into(),
        request: Request::for_spec("specs/atlas_run_torque.toml", Some("quick")),
        template: "report.md.j2".into(),
        tool_version: "0.1.0".into(),
        commit: "0123456789abcdef0123456789abcdef01234567".into(),
        arms: vec![arm("torque", 1.0), arm("position", 0.4)],
        suite: None,
        figures: vec![],
        deviations: vec![],
        question: String::new(),
        reasons: vec!["The paper's robot weighs more".into()],
        baselines: vec![],
    }
}

fn text(value: &str) -> Value {
    Value::Text(value.into())
}

fn quantity(si: f64, text: &str) -> Value {
    Value::Quantity(Quantity { si, text: text.into() })
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

fn fields(control: &str) -> Table {
    let mut action = table([
        ("kind", text(control)),
        ("rate", quantity(250.0, "250 Hz")),
        ("std", quantity(0.1, "10 %")),
        ("delay", quantity(0.004, "4 ms")),
    ]);
    if control == "position" {
        action.insert("stiffness".into(), quantity(0.125, "12.5 %"));
        action.insert("servo_rate".into(), quantity(500.0, "500 Hz"));
    }
    let command = table([("speed", Value::Sampler(Sampler::Uniform([0.4, 1.2])))]);
    let nominal = table([("kind", text("episodes")), ("episodes", Value::Count(32))]);
    table([
        ("robot", Value::Table(table([("model", text("atlas"))]))),
        ("physics", Value::Table(table([("engine", text("rapier")), ("rate", quantity(500.0, "500 Hz"))]))),
        (
            "task",
            Value::Table(table([
                ("kind", text("run")),
                ("motion", text("run_gait")),
                ("episode", quantity(16.0, "16 s")),
                ("command", Value::Table(command)),
            ])),
        ),
        ("action", Value::Table(action)),
        ("pretrain", Value::Table(table([("kind", text("tracking")), ("samples", Value::Count(200_000))]))),
        (
            "learn",
            Value::Table(table([
                ("kind", text("ppo")),
                ("samples", Value::Count(3_000_000)),
                ("rollout", Value::Count(16_384)),
                ("environments", Value::Count(64)),
                ("minibatch", Value::Count(1024)),
                ("epochs", Value::Count(4)),
                ("seed", Value::Count(1)),
            ])),
        ),
        ("evaluate", Value::Table(table([("nominal", Value::Table(nominal))]))),
    ])
}

fn arm(control: &str, quality: f64) -> Arm {
    let name = format!("atlas_run_{control}");
    let mut arm = Arm {
        summary: format!("Atlas runs under {control} control"),
        spec: format!("specs/{name}.toml"),
        law: match control {
            "torque" => "tau = clamp(10 % * effort_limit * a, +-effort_limit), held for 4 ms".into(),
            _ => {
                "tau = clamp(12.5 % * (Kp * (q_default + a - q) - Kd * qd), +-effort_limit), at 500 Hz".into()
            }
        },
        fields: fields(control),
        origins: BTreeMap::from([
            ("learn.samples".to_string(), "specs/base/task/run.toml:37 (profile quick)".to_string()),
            ("action.std".to_string(), "specs/base/action/torque.toml:8".to_string()),
        ]),
        robot: Some(robot()),
        motion: Some(motion()),
        updates: updates(quality),
        fine_tuning: Vec::new(),
        findings: Some(findings(control)),
        baseline: None,
        budget_share: None,
        allow: BTreeMap::new(),
        pretrain: Some(Pretrain {
            rmse_nm: 7.4 + quality,
            label_rms_nm: 40.4,
            samples: 200_000,
            cpu_s: 11.2,
        }),
        evaluations: vec![
            measured("evaluate.nominal", "rapier", &name, quality),
            measured("deploy.mujoco", "mujoco", &name, quality * 0.9),
        ],
        stages: stages(&name),
        failures: vec![],
        policies: Vec::new(),
        run: None,
        name,
    };
    if control == "position" {
        arm.evaluations.truncate(1);
        arm.failures.push(Failure {
            stage: "deploy.mujoco".into(),
            reason: "the library of MuJoCo is missing".into(),
        });
    }
    arm
}

/// One that ended and one that did not.
fn findings(control: &str) -> Vec<Finding> {
    let finding = |code: &str, message: &str, since, until| {
        let (code, message) = (code.into(), message.into());
        Finding { code, subject: String::new(), message, since, until }
    };
    match control {
        "position" => vec![
            finding(
                "W0601",
                "the policy jumps: update 6 moved it by a KL divergence of 14.6, 730 times the target of \
                 0.020",
                114_688,
                Some(131_072),
            ),
            finding(
                "W0606",
                "the robot does not step: it is on one foot in 0.4 % of the steps, the reference in 64 %",
                819_200,
                None,
            ),
        ],
        _ => vec![],
    }
}

fn stages(arm: &str) -> Vec<StageRecord> {
    let record = |(stage, fields, inputs, wall): (&str, &[&str], &[&str], f64)| StageRecord {
        stage: stage.into(),
        fingerprint: blake3_like(arm, stage),
        fields: fields.iter().map(|field| field.to_string()).collect(),
        inputs: inputs.iter().map(|input| input.to_string()).collect(),
        tool_version: "0.1.0".into(),
        commit: "0123456789abcdef0123456789abcdef01234567".into(),
        wall_s: wall,
        cpu_s: 1.9 * wall,
        finished: "2026-01-31 12:00 UTC".into(),
    };
    [
        ("robot", &["robot"][..], &[][..], 0.01),
        ("env", &["physics", "task", "reward"], &["robot"], 0.02),
        ("controller", &["action"], &["robot"], 0.01),
        ("pretrain", &["pretrain", "action", "learn.policy"], &["robot", "controller"], 8.3),
        ("learner", &["learn"], &["env", "controller", "pretrain"], 302.0),
        ("evaluate.nominal", &["evaluate.nominal"], &["env", "controller", "learner"], 12.4),
        ("deploy.policy", &["deploy.policy"], &["env", "controller", "learner"], 0.1),
        ("deploy.mujoco", &["deploy.mujoco"], &["env", "deploy.policy"], 9.7),
    ]
    .map(record)
    .into()
}

/// A digest that is always the same for an arm and a stage.
fn blake3_like(arm: &str, stage: &str) -> String {
    let mut stream = Stream::new(&format!("test/fingerprint/{arm}/{stage}"));
    (0..8).map(|_| format!("{:08x}", stream.below(1 << 32))).collect()
}

fn updates(quality: f64) -> Vec<Update> {
    let mut stream = Stream::new(&format!("test/updates/{quality}"));
    (1..=183u64)
        .map(|update| {
            let samples = update * 16_384;
            let share = samples as f64 / 3e6;
            let growth = quality / (1.0 + libm::exp(-9.0 * (share - 0.42))) + 0.04;
            let noise = |stream: &mut Stream, size: f64| 1.0 + size * stream.normal();
            let length = 16.0 * growth * noise(&mut stream, 0.03);
            let fallen = (64.0 * (1.0 - growth)).max(0.0) as u64;
            Update {
                update,
                samples,
                simulated_s: samples as f64 / 250.0,
                wall_s: samples as f64 / (9800.0 + 600.0 * quality),
                cpu_s: samples as f64 / 5000.0,
                return_mean: (update > 2).then_some(length.min(16.0) * 250.0 * 1.28),
                length_mean_s: (update > 2).then_some(length.min(16.0)),
                single_support: Some(0.8 * growth / (1.0 + growth)),
                kl: Some(0.011 * noise(&mut stream, 0.1)),
                clip_fraction: Some(0.12),
                explained_variance: Some((0.5 + 0.45 * share).min(0.97)),
                learning_rate: Some(6e-5),
                samples_per_s: Some(9800.0),
                terms: BTreeMap::new(),
                ends: BTreeMap::from([
                    ("time_out".to_string(), (40.0 * growth) as u64),
                    ("contact_schedule".to_string(), fallen * 2 / 3),
                    ("base_tilt".to_string(), fallen / 4),
                    ("base_height".to_string(), fallen / 8),
                ]),
            }
        })
        .collect()
}

fn measured(stage: &str, engine: &str, arm: &str, quality: f64) -> Measured {
    let mut stream = Stream::new(&format!("test/episodes/{arm}/{engine}"));
    let episodes = (0..32).map(|index| episode(index, quality, &mut stream)).collect();
    let (rate, trace) = (if engine == "mujoco" { 2000.0 } else { 500.0 }, trace(quality));
    let evaluation = Evaluation {
        push: None,
        engine: engine.into(),
        physics_rate: rate,
        control_rate: 250.0,
        command: Some(SPEED),
        time_limit: 16.0,
        obstacle: None,
        episodes,
        trace,
    };
    Measured { stage: stage.into(), evaluation }
}

fn episode(index: usize, quality: f64, stream: &mut Stream) -> Episode {
    let survived = stream.uniform() < 0.15 + 0.85 * quality;
    let duration = if survived { 16.0 } else { 2.0 + 9.0 * stream.uniform() };
    let speed = SPEED * (0.55 + 0.42 * quality) + 0.03 * stream.normal();
    let steps = (duration / PERIOD) as u32;
    Episode {
        stream: format!("1/evaluate/nominal/{index}"),
        survived,
        end: if survived { "time_out".into() } else { "base_tilt".into() },
        duration,
        single_support: 0.62,
        left_support: 0.31 + 0.01 * stream.normal(),
        right_support: 0.31 + 0.01 * stream.normal(),
        flight: 0.36 * quality,
        steps: [steps, steps],
        alternating_flights: (2.0 * f64::from(steps) * quality) as u32,
        flight_per_step: (quality * (0.99 + 0.01 * stream.uniform())).min(1.0),
        steady_flight_per_step: if survived { quality.min(1.0) } else { 0.0 },
        starting_steps: 2,
        speed,
        steady_speed: if survived { speed + 0.02 } else { 0.0 },
        speed_error: (speed - SPEED).abs(),
        distance: speed * duration,
        reward_per_second: BTreeMap::from([
            ("joint_tracking".to_string(), 70.0 * quality + stream.normal()),
            ("velocity_tracking".to_string(), 55.0 * quality + stream.normal()),
            ("contact_schedule".to_string(), 45.0 * quality + stream.normal()),
            ("torque_change".to_string(), 20.0 + stream.normal()),
        ]),
        peak_foot_force: 2900.0 - 600.0 * quality + 80.0 * stream.normal(),
        torque_rms: 88.0 - 14.0 * quality + stream.normal(),
        tracking_error: [0.35 - 0.1 * quality, 0.06],
        ..Episode::default()
    }
}

/// Joint positions of one leg at a phase: yaw, roll, pitch, knee, ankle pitch, ankle roll.
fn leg(phase: f64) -> [f64; 6] {
    let hip = -0.35 - 0.42 * libm::cos(TAU * phase);
    let knee = 0.75 + 0.5 * libm::cos(TAU * (phase - 0.72));
    [0.0, 0.0, hip, knee, -hip - knee, 0.0]
}

fn joints(phase: f64) -> Vec<f64> {
    leg(phase).into_iter().chain(leg(phase + 0.5)).collect()
}

fn load(phase: f64) -> f64 {
    let stance = (phase.rem_euclid(1.0) - 0.02) / 0.34;
    if (0.0..1.0).contains(&stance) { libm::sin(0.5 * TAU * stance) } else { 0.0 }
}

fn trace(quality: f64) -> Trace {
    let mut stream = Stream::new(&format!("test/trace/{quality}"));
    let mut trace = Trace {
        joints: robot().links.iter().map(|link| link.joint.name.clone()).collect(),
        ..Trace::default()
    };
    let roughness = 26.0 * (1.2 - quality);
    for row in 0..(6.0 * 250.0) as usize {
        let time = row as f64 / 250.0;
        let phase = (time / PERIOD).rem_euclid(1.0);
        let bounce = 0.03 * libm::cos(2.0 * TAU * (phase - 0.19));
        trace.time.push(time);
        trace.phase.push(phase);
        trace.base_position.push([SPEED * (0.55 + 0.42 * quality) * time, 0.0, 0.87 - bounce]);
        let lean = 0.5 * (0.06 + 0.02 * libm::sin(TAU * phase));
        trace.base_orientation.push([libm::cos(lean), 0.0, libm::sin(lean), 0.0]);
        let position = joints(phase + 0.01 * libm::sin(TAU * phase));
        trace.position.push(position);
        let torque = (0..12).map(|joint| {
            let own = if joint < 6 { phase } else { phase + 0.5 };
            let size = [10.0, 60.0, 120.0, 240.0, 130.0, 20.0][joint % 6];
            size * (load(own) - 0.2 * libm::cos(TAU * own)) + roughness * stream.normal()
        });
        trace.torque.push(torque.collect());
        let vertical = |own: f64| (2400.0 * load(own) * (1.0 + 0.02 * stream_free_wiggle(own))).max(0.0);
        trace.foot_force.push([[0.0, 0.0, vertical(phase)], [0.0, 0.0, vertical(phase + 0.5)]]);
        let scheduled = |own: f64| (0.0..0.35).contains(&own.rem_euclid(1.0));
        trace.schedule.push([scheduled(phase), scheduled(phase + 0.5)]);
    }
    trace
}

fn stream_free_wiggle(phase: f64) -> f64 {
    libm::sin(17.0 * TAU * phase)
}

fn motion() -> Motion {
    let frame = |index: usize| {
        let phase = index as f64 / 40.0;
        Frame {
            position: joints(phase),
            velocity: vec![0.0; 12],
            acceleration: vec![0.0; 12],
            base_height: 0.87 - 0.03 * libm::cos(2.0 * TAU * (phase - 0.19)),
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            ..Frame::default()
        }
    };
    Motion { name: "run_gait".into(), period: PERIOD, speed: SPEED, samples: (0..40).map(frame).collect() }
}

/// A biped with two legs of six joints, about as tall and heavy as Atlas.
fn robot() -> Robot {
    let body = |name: String, mass: f64, com: [f64; 3]| Body {
        name,
        mass,
        com: Point3::from(com),
        inertia: Matrix3::identity() * (0.02 * mass),
        collisions: vec![],
    };
    let names = ["yaw", "roll", "pitch", "knee", "ankle_pitch", "ankle_roll"];
    let axes = [
        Vector3::z_axis(),
        Vector3::x_axis(),
        Vector3::y_axis(),
        Vector3::y_axis(),
        Vector3::y_axis(),
        Vector3::x_axis(),
    ];
    let drops = [0.0, 0.0, -0.05, -0.38, -0.42, 0.0];
    let limits = [110.0, 180.0, 260.0, 400.0, 220.0, 90.0];
    let mut links = vec![];
    for (side, prefix) in [(1.0, "left"), (-1.0, "right")] {
        for joint in 0..6 {
            let first = joint == 0;
            let sideways = if first { 0.09 * side } else { 0.0 };
            let axis = axes[joint];
            links.push(Link {
                body: body(format!("{prefix}_{}", names[joint]), 4.0, [0.0, 0.0, -0.1]),
                parent: (!first).then(|| links.len() - 1),
                joint: Joint {
                    name: format!("{prefix}_{}", names[joint]),
                    origin: Isometry3::from_parts(
                        Translation3::new(0.0, sideways, drops[joint]),
                        UnitQuaternion::identity(),
                    ),
                    axis,
                    lower: -2.5,
                    upper: 2.5,
                    effort_limit: limits[joint],
                    velocity_limit: 12.0,
                    damping: 0.1,
                    friction: 0.0,
                    armature: 0.0,
                    stiffness_gain: 1000.0,
                    damping_gain: 10.0,
                    default_position: 0.0,
                },
            });
        }
    }
    let foot = |link| Foot {
        link,
        half_extents: Vector3::new(0.13, 0.06, 0.02),
        centre: Point3::new(0.04, 0.0, -0.05),
        friction: 1.0,
    };
    Robot {
        name: "atlas".into(),
        base: body("pelvis".into(), 60.0, [0.0, 0.0, 0.3]),
        links,
        feet: [foot(5), foot(11)],
        mirror: (0..12).map(|joint| ((joint + 6) % 12, 1.0)).collect(),
        standing_height: 0.9,
    }
}
