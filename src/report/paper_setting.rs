//! How a run's setting differs from the paper's: rates, delay, observation, randomization, motion, commands, exploration,
//! learner. The reward has a table of its own.

use serde_json::Value as Json;

use super::model::Arm;
use super::table::setup::{field, lookup, randomized};
use crate::spec::Sampler;

/// A part of the setting, as the beginning of a sentence.
pub type Topic = &'static str;

const RATES: Topic = "The rates and the engine are";
const DELAY: Topic = "The delay and the observation are";
const MOTION: Topic = "The reference motion and the commands are";
const EXPLORATION: Topic = "The exploration is";
const LEARNER: Topic = "The learner's figures are";
const RANDOMIZATION: Topic = "The randomization is";
const ROBOT: Topic = "The robot is";

/// Every part, in the order of the sentences.
pub const TOPICS: [Topic; 7] = [ROBOT, RATES, DELAY, RANDOMIZATION, MOTION, EXPLORATION, LEARNER];

/// A value of the paper's.
struct Printed {
    topic: Topic,
    /// A section and the kind that it must have for the value to count; empty for all specs.
    only: (&'static str, &'static str),
    path: &'static str,
    /// The values that it may have, as canonical JSON in SI units; none where no spec can have the paper's.
    values: &'static [&'static str],
    /// The same as a reader sees it.
    words: &'static str,
}

const fn row(topic: Topic, path: &'static str, values: &'static [&'static str], words: &'static str) -> Printed {
    Printed { topic, only: ("", ""), path, values, words }
}

impl Printed {
    const fn of(self, section: &'static str, kind: &'static str) -> Self {
        Self { only: (section, kind), ..self }
    }
}

/// The paper's values, as `specs/base/` spells them, and with a "by the authors' code" those that it does not print.
const TABLE: &[Printed] = &[
    row(ROBOT, "robot.model", &["\"tocabi\"", "\"atlas\""], "TOCABI or Atlas"),
    row(RATES, "action.rate", &["250"], "250 Hz"),
    row(RATES, "action.servo_rate", &["2000"], "2000 Hz").of("action", "position"),
    row(RATES, "physics.rate", &["2000"], "2000 Hz"),
    row(RATES, "physics.engine", &["\"mujoco\""], "mujoco"),
    row(DELAY, "action.delay", &["0.004"], "4 ms"),
    row(DELAY, "observe.joint_position.noise", &["{\"normal\":[0,0.0001]}"], "normal with 1e-4 rad"),
    row(DELAY, "observe.joint_velocity.low_pass", &["4"], "4 Hz"),
    row(MOTION, "task.motion", &[], "the walk of a model-based controller, of which no clip is public")
        .of("task", "walk"),
    row(MOTION, "task.motion", &["\"run_clip\""], "the motion-capture clip `run_clip`").of("task", "run"),
    row(MOTION, "task.motion", &["\"squat\""], "`squat`").of("task", "squat"),
    row(MOTION, "task.episode", &["16"], "16 s"),
    row(MOTION, "task.command.speed", &["{\"uniform\":[0,0.5]}"], "0 to 0.5 m/s by the authors' code")
        .of("task", "walk"),
    row(MOTION, "task.command.speed", &["{\"uniform\":[0,1]}"], "0 to 1 m/s by the authors' code").of("task", "run"),
    row(MOTION, "task.command.every", &["4"], "4 s by the authors' code"),
    row(MOTION, "task.command.ramp", &["1"], "1 s by the authors' code"),
    row(EXPLORATION, "action.std", &["0.2", "0.1", "0.05"], "20, 10 or 5 % of the effort limit").of("action", "torque"),
    row(
        EXPLORATION,
        "action.std",
        &["0.01", "0.005", "0.0025", "0.00125"],
        "1, 0.5, 0.25 or 0.125 % of half the range",
    )
    .of("action", "position"),
    row(LEARNER, "learn.environments", &["8"], "8 by the authors' code"),
    row(LEARNER, "learn.rollout", &["16384"], "16 384"),
    row(LEARNER, "learn.minibatch", &["128"], "128"),
    row(LEARNER, "learn.epochs", &["3"], "3 by the authors' code"),
    row(LEARNER, "learn.warm_up", &["0"], "none"),
    row(LEARNER, "learn.learning_rate", &["{\"linear\":[5e-5,1e-6]}"], "linear from 5e-5 to 1e-6"),
    row(LEARNER, "learn.policy.hidden", &["[256,256]"], "[256, 256]"),
];

/// What is scaled for every episode, and between which factors.
const SCALED: [(&str, [f64; 2]); 7] = [
    ("action_delay", [0.5, 1.5]),
    ("joint_damping", [0.6, 1.4]),
    ("joint_friction", [0.6, 1.4]),
    ("link_com", [0.6, 1.4]),
    ("link_inertia", [0.6, 1.4]),
    ("link_mass", [0.6, 1.4]),
    ("motor_constant", [1.0, 1.1]),
];

/// Joints of two legs: who has no more has a welded upper body.
const LEG_JOINTS: usize = 12;

/// What a part of an arm's setting has in another way, in words; `None` where it is the paper's.
pub fn differences(arm: &Arm, topic: Topic) -> Option<String> {
    let counts = |row: &&Printed| row.topic == topic && (row.only.0.is_empty() || arm.kind(row.only.0) == row.only.1);
    let mut found: Vec<String> = TABLE.iter().filter(counts).filter_map(|row| difference(arm, row)).collect();
    match topic {
        RANDOMIZATION => found.extend(randomization(arm)),
        ROBOT if arm.robot.as_ref().is_some_and(|robot| robot.joints() <= LEG_JOINTS) => {
            found.push("its upper body is welded, not held in place by servos".to_owned());
        }
        _ => {}
    }
    (!found.is_empty()).then(|| found.join("; "))
}

/// `` `action.rate` 125 Hz, not 250 Hz ``; `None` for the paper's value, and where the spec has no such key.
fn difference(arm: &Arm, Printed { path, values, words, .. }: &Printed) -> Option<String> {
    let own = lookup(arm, path)?.canonical();
    let is_own = |text: &str| serde_json::from_str(text).is_ok_and(|printed: Json| same(&own, &printed));
    (!values.iter().any(|text| is_own(text)))
        .then(|| format!("`{path}` {}, not {words}", field(arm, path).unwrap_or_default()))
}

/// Whether two values are the same, counts and numbers alike.
fn same(one: &Json, other: &Json) -> bool {
    match (one, other) {
        (Json::Array(one), Json::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| same(one, other))
        }
        (Json::Object(one), Json::Object(other)) => {
            one.len() == other.len()
                && one.iter().all(|(key, one)| other.get(key).is_some_and(|other| same(one, other)))
        }
        _ => match (one.as_f64(), other.as_f64()) {
            (Some(one), Some(other)) => (one - other).abs() <= 1e-9 * other.abs(),
            _ => one == other,
        },
    }
}

/// What is drawn in another way. The policies whose parameter sets the paper varies it trains without any.
fn randomization(arm: &Arm) -> Vec<String> {
    let spec = arm.section();
    let varies = spec.section("evaluate").is_some_and(|evaluate| {
        evaluate.sections().any(|(_, protocol)| protocol.text_if("kind") == Some("parameter_sets"))
    });
    let rows = randomized(arm);
    match (varies, rows.is_empty(), spec.has("task")) {
        (true, true, _) | (_, _, false) => return Vec::new(),
        (false, true, _) => {
            return vec!["nothing is drawn, where the paper scales seven parameters of every episode".into()];
        }
        (true, ..) => return vec!["figures are drawn, where the paper draws none for this experiment".into()],
        _ => {}
    }
    let own = |name: &str| rows.iter().find(|(kind, _)| *kind == name).and_then(|(_, row)| row.sampler_if("scale"));
    let of_paper = SCALED.iter().filter_map(|(name, range)| match own(name) {
        None => Some(format!("no `{name}`")),
        Some(Sampler::Uniform(own)) if own == *range => None,
        Some(_) => Some(format!("`{name}` not scaled by {} to {}", range[0], range[1])),
    });
    let new = rows.iter().filter(|(kind, _)| !SCALED.iter().any(|(name, _)| name == kind));
    of_paper.chain(new.map(|(kind, _)| format!("`{kind}`, not in the paper"))).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::kinds::vocabulary::vocabulary;
    use crate::robot::tests::robot;
    use crate::spec::{LoadOptions, load};

    fn arm(spec: &str, profile: &str) -> Arm {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs").join(spec);
        let options = LoadOptions { profile: Some(profile.to_owned()), ..LoadOptions::default() };
        let loaded = load(&path, &options, &vocabulary());
        let fields = loaded.experiment.unwrap_or_else(|| panic!("{spec}: {:?}", loaded.sink.diagnostics)).table;
        Arm { fields, robot: Some(robot("tocabi")), ..Arm::default() }
    }

    fn told(arm: &Arm) -> Vec<String> {
        TOPICS.iter().filter_map(|topic| differences(arm, topic)).collect()
    }

    #[test]
    fn the_paper_s_profile_has_the_paper_s_values_but_for_the_engine_the_body_and_the_clip_of_the_walk() {
        let expected = ["its upper body is welded, not held in place by servos", "`physics.engine` batch, not mujoco"];
        let squat = told(&arm("tocabi_squat_torque.toml", "paper"));
        assert_eq!(squat, expected);
        let run = told(&arm("tocabi_run_position.toml", "paper"));
        assert_eq!(run, expected);
        let walk = told(&arm("tocabi_walk_torque.toml", "paper"));
        assert_eq!(walk[..2], expected);
        assert!(walk.len() == 3 && walk[2].starts_with("`task.motion` walk, not the walk of a"), "{walk:?}");
    }

    #[test]
    fn small_profiles_tell_rates_randomization_filter_and_learner() {
        let quick = told(&arm("tocabi_run_position.toml", "quick")).join("\n");
        for words in [
            "`action.rate` 125 Hz, not 250 Hz",
            "`action.servo_rate` 500 Hz, not 2000 Hz",
            "`physics.rate` 500 Hz, not 2000 Hz",
            "`action.delay` 0 ms, not 4 ms",
            "nothing is drawn, where the paper scales seven parameters of every episode",
            "`task.motion` run_gait, not the motion-capture clip `run_clip`",
            "`task.command.speed` uniform [0.4, 1.2], not 0 to 1 m/s by the authors' code",
            "`learn.minibatch` 1024, not 128",
            "`learn.epochs` 4, not 3",
            "`learn.warm_up` 6, not none",
        ] {
            assert!(quick.contains(words), "{words} is not in\n{quick}");
        }
        let g1 = told(&arm("g1_walk_torque.toml", "desk")).join("\n");
        assert!(g1.contains("`robot.model` g1, not TOCABI or Atlas"), "{g1}");
        assert!(g1.contains("`observe.joint_velocity.low_pass` 20 Hz, not 4 Hz"), "{g1}");
        assert!(
            !g1.contains("is drawn") && !g1.contains("not scaled"),
            "on the desk the paper's ranges are drawn: {g1}"
        );
    }
}
