//! A made-up suite: two controls, two standard deviations, three seeds, with every evaluation that figures
//! are drawn from.

use std::collections::BTreeMap;

use specforge::evaluate::outcome::{Episode, Evaluation};
use specforge::plan::{AxisRecord, RunRecord, SuiteRecord};
use specforge::report::model::{Arm, Measured, ReportInput};
use specforge::spec::claim::Claim;
use specforge::stream::Stream;

use super::{made_up_claims, synthetic};

const CONTROLS: [&str; 2] = ["torque", "position"];
const STDS: [&str; 2] = ["10 %", "5 %"];
/// The scaled parameters; the first two decide over the failures.
pub const PARAMETERS: [&str; 8] = [
    "action_delay",
    "leg_length",
    "motor_constant",
    "link_mass",
    "link_inertia",
    "link_com",
    "joint_damping",
    "joint_friction",
];

const CLAIMS: &str = r#"
[[claim]]
id     = "torque_survives"
text   = "The torque policy survives half of its episodes"
metric = "evaluate.nominal.survival"
arm    = "control=torque,std=10 %"
expect = "a > 50 %"
paper  = { where = "Exp. 1", value = "it always survives" }

[[claim]]
id     = "position_is_fast"
text   = "The position policy keeps the commanded speed"
metric = "evaluate.nominal.speed_error"
arm    = "control=position,std=10 %"
expect = "a < 0.05 m/s"

[[claim]]
id      = "torque_survives_more"
text    = "The torque policy survives more than the position policy"
metric  = "evaluate.nominal.survival"
compare = { a = "control=torque", b = "control=position" }
over    = "each"
expect  = "a > b"
"#;

fn claims() -> Vec<Claim> {
    made_up_claims::decoded(CLAIMS)
}

/// The whole input.
pub fn suite() -> ReportInput {
    let mut input = synthetic::input();
    let originals = std::mem::take(&mut input.arms);
    for (control, original) in CONTROLS.iter().zip(&originals) {
        for (place, std) in STDS.iter().enumerate() {
            input.arms.extend((1..=3).map(|seed| run(original, (control, std), (place, seed))));
        }
    }
    let axis = |name: &str, points: [&str; 2]| AxisRecord {
        name: name.into(),
        points: points.map(str::to_owned).into(),
    };
    input.suite = Some(SuiteRecord {
        name: "made_up".into(),
        axes: vec![axis("control", CONTROLS), axis("std", STDS)],
        arms: 4,
        seeds: vec![1, 2, 3],
        claims: claims(),
        claims_count: false,
    });
    input.name = "made_up".into();
    input.summary = "What a made-up comparison looks like".into();
    input.template = "report.md.j2".into();
    input
}

fn run(original: &Arm, (control, std): (&str, &str), (place, seed): (usize, u64)) -> Arm {
    let mut arm = original.clone();
    let name = format!("control={control},std={std}");
    arm.name = format!("{name},seed={seed}");
    let points = vec![("control".to_owned(), control.to_owned()), ("std".to_owned(), std.to_owned())];
    arm.run = Some(RunRecord { id: format!("{control}{place}{seed}"), arm: name, points, seed });
    let factor = 1.0 + 0.05 * seed as f64 - 0.1 * place as f64;
    for update in &mut arm.updates {
        update.return_mean = update.return_mean.map(|mean| factor * mean);
        update.wall_s *= 1.0 + 0.1 * seed as f64;
    }
    // Every arm is fine-tuned: it begins lower than it ended, and comes back.
    arm.fine_tuning = arm.updates.iter().take(60).cloned().collect();
    let (last, end) =
        (arm.updates.last().and_then(|update| update.return_mean), arm.fine_tuning.len() as f64);
    for (at, update) in arm.fine_tuning.iter_mut().enumerate() {
        update.return_mean = last.map(|last| last * (0.6 + 0.4 * (at as f64 / end)));
    }
    let quality = if control == "torque" { 0.9 } else { 0.45 } - 0.05 * place as f64;
    let nominal = arm.evaluations[0].evaluation.clone();
    let mut mujoco = nominal.clone();
    mujoco.engine = "mujoco".into();
    mujoco.trace.foot_force.iter_mut().flatten().for_each(|force| force[2] *= 1.2);
    let mut over = nominal.clone();
    over.obstacle = Some([1.3, 1.7]);
    over.trace.foot_position = over.trace.base_position.iter().map(|base| [*base, *base]).collect();
    let bump = if control == "torque" { 10.0 } else { 70.0 };
    for (time, torque) in over.trace.time.iter().zip(&mut over.trace.torque) {
        torque[4] += bump * libm::exp(-8.0 * (time - 2.4) * (time - 2.4));
    }
    arm.evaluations = [
        ("evaluate.nominal", nominal.clone()),
        ("evaluate.flat", nominal.clone()),
        ("evaluate.box", over),
        ("evaluate.grid", grid(&nominal, quality, seed)),
        ("evaluate.sets", sets(&nominal, quality)),
        ("deploy.mujoco", mujoco),
    ]
    .map(|(stage, evaluation)| Measured { stage: stage.into(), evaluation })
    .into();
    let mut tuned = arm.stages.last().expect("there are stages").clone();
    (tuned.stage, tuned.fingerprint) = ("fine_tune".to_owned(), format!("{}/fine_tune", arm.name));
    let mut stages = vec![tuned];
    for measured in &arm.evaluations {
        let mut record = arm.stages.last().expect("there are stages").clone();
        record.stage = measured.stage.clone();
        record.fingerprint = format!("{}/{}", arm.name, measured.stage);
        stages.push(record);
    }
    arm.stages.retain(|record| !stages.iter().any(|stage| stage.stage == record.stage));
    arm.stages.extend(stages);
    arm.failures.clear();
    arm
}

/// 25 speeds over a box.
fn grid(nominal: &Evaluation, quality: f64, seed: u64) -> Evaluation {
    let mut stream = Stream::new(&format!("test/grid/{quality}/{seed}"));
    let episode = |index: usize| {
        let command = 0.02 * (index + 1) as f64;
        let survived = stream.uniform() < 1.3 * quality - 0.6 * command;
        let speed_error = 0.1 * stream.uniform() + 0.2 * command * (1.0 - quality);
        Episode { command: Some(command), survived, speed_error, ..nominal.episodes[0].clone() }
    };
    Evaluation { episodes: (0..25).map(episode).collect(), ..nominal.clone() }
}

/// Parameter sets that the arms share; a longer delay and both extremes of the leg's length make a robot
/// fall.
fn sets(nominal: &Evaluation, quality: f64) -> Evaluation {
    let mut draws = Stream::new("test/sets");
    let mut luck = Stream::new(&format!("test/sets/{quality}"));
    let episode = |index: usize| {
        let parameters: BTreeMap<String, f64> =
            PARAMETERS.iter().map(|name| ((*name).to_owned(), 0.7 + 0.6 * draws.uniform())).collect();
        let scaled = |name: &str| (parameters[name] - 1.0) / 0.3;
        let danger = 2.2 * scaled("action_delay") + 1.6 * scaled("leg_length") * scaled("leg_length");
        let survived = danger + 0.6 * luck.normal() < 3.6 * quality;
        let reward = 190.0 * quality.sqrt() - 6.0 * danger + 4.0 * luck.normal();
        Episode {
            stream: format!("1000/set/{index}"),
            survived,
            reward_per_second: [("all".to_owned(), reward)].into(),
            parameters,
            ..nominal.episodes[0].clone()
        }
    };
    Evaluation { episodes: (0..160).map(episode).collect(), ..nominal.clone() }
}
