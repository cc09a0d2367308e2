//! The parents of `specs/base/`, included in the program.

/// A parent: its name and its text.
type Parent = (&'static str, &'static str);

/// The common parent of all experiments.
const BIPED: &str = include_str!("../../specs/base/biped.toml");

/// The tasks.
const TASKS: [Parent; 4] = [
    ("run", include_str!("../../specs/base/run.toml")),
    ("squat", include_str!("../../specs/base/squat.toml")),
    ("stand", include_str!("../../specs/base/stand.toml")),
    ("walk", include_str!("../../specs/base/walk.toml")),
];

/// The actions.
const ACTIONS: [Parent; 2] = [
    ("position", include_str!("../../specs/base/position.toml")),
    ("torque", include_str!("../../specs/base/torque.toml")),
];

/// Optional parents: initial and final parts of a training, self-collision terms, the squat's settings,
/// servos for training, and robot-specific settings (Atlas: soft gains; G1: light joints and 1.5 times the
/// samples for walking).
const OTHERS: [Parent; 17] = [
    ("atlas", include_str!("../../specs/base/atlas.toml")),
    ("atlas_servo", include_str!("../../specs/base/atlas_servo.toml")),
    ("atlas_squat", include_str!("../../specs/base/atlas_squat.toml")),
    ("balance", include_str!("../../specs/base/balance.toml")),
    ("g1", include_str!("../../specs/base/g1.toml")),
    ("g1_servo", include_str!("../../specs/base/g1_servo.toml")),
    ("g1_squat", include_str!("../../specs/base/g1_squat.toml")),
    ("g1_walk", include_str!("../../specs/base/g1_walk.toml")),
    ("legs_apart", include_str!("../../specs/base/legs_apart.toml")),
    ("low_exploration", include_str!("../../specs/base/low_exploration.toml")),
    ("low_exploration_longer", include_str!("../../specs/base/low_exploration_longer.toml")),
    ("on_track", include_str!("../../specs/base/on_track.toml")),
    ("run_both_engines", include_str!("../../specs/base/run_both_engines.toml")),
    ("servo", include_str!("../../specs/base/servo.toml")),
    ("tocabi_servo", include_str!("../../specs/base/tocabi_servo.toml")),
    ("tocabi_squat", include_str!("../../specs/base/tocabi_squat.toml")),
    ("walk_apart", include_str!("../../specs/base/walk_apart.toml")),
];

/// The names of the tasks, sorted.
pub fn tasks() -> Vec<&'static str> {
    TASKS.iter().map(|(name, _)| *name).collect()
}

/// The names of the actions, sorted.
pub fn actions() -> Vec<&'static str> {
    ACTIONS.iter().map(|(name, _)| *name).collect()
}

/// The text of a parent.
pub fn parent(name: &str) -> Option<&'static str> {
    let known = [("biped", BIPED)]
        .into_iter()
        .chain(TASKS)
        .chain(ACTIONS)
        .chain(OTHERS)
        .find(|(known, _)| *known == name);
    known.map(|(_, text)| text)
}

/// The profiles in which a parent of this family writes the key at a path, sorted.
pub fn profiles_with(family: &[&str], path: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for text in family.iter().filter_map(|name| parent(name)) {
        let document: toml_edit::DocumentMut = text.parse().expect("the shipped parents are TOML");
        let profiles = document.get("profile").and_then(|profiles| profiles.as_table_like());
        for (profile, table) in profiles.iter().flat_map(|profiles| profiles.iter()) {
            let value = path.iter().try_fold(table, |table, key| table.get(key));
            found.extend(value.map(|_| profile.to_owned()));
        }
    }
    found.sort();
    found.dedup();
    found
}

/// The names of the parents of a spec; later ones win.
pub fn family<'a>(task: &'a str, action: &'a str, robot: &'a str) -> Vec<&'a str> {
    let own: &[&str] = match (robot, task) {
        ("tocabi", "squat") => &["balance", "tocabi_squat"],
        ("tocabi", "walk") => &["low_exploration", "balance"],
        ("atlas", "squat") => &["balance", "atlas_squat"],
        ("atlas", "walk") => &["low_exploration", "low_exploration_longer", "balance", "atlas"],
        ("g1", "squat") => &["g1", "balance", "g1_squat"],
        ("g1", "walk") => &["g1", "low_exploration", "low_exploration_longer", "g1_walk", "balance"],
        ("g1", "run") => &["g1", "run_both_engines"],
        ("g1", _) => &["g1"],
        (_, "run") => &["run_both_engines"],
        (_, "squat") => &["balance"],
        (_, "walk") => &["low_exploration", "low_exploration_longer", "balance"],
        _ => &[],
    };
    ["biped", task, action]
        .into_iter()
        .chain([servo(task, action, robot), own, apart(task, action, robot)].concat())
        .collect()
}

/// The parents that prevent self-collisions of the legs.
fn apart(task: &str, action: &str, robot: &str) -> &'static [&'static str] {
    match (task, action, robot) {
        ("run", "position", _) => &["legs_apart"],
        ("walk", _, "tocabi" | "atlas") => &["walk_apart"],
        ("walk", "torque", _) | ("walk", _, "g1") => &["legs_apart", "on_track"],
        ("walk", ..) => &["legs_apart"],
        _ => &[],
    }
}

/// The parents that set the servo for training.
fn servo(task: &str, action: &str, robot: &str) -> &'static [&'static str] {
    match (action, task, robot) {
        (_, "stand", _) | ("torque", ..) => &[],
        (_, _, "tocabi") => &["servo", "tocabi_servo"],
        (_, _, "atlas") => &["servo", "atlas_servo"],
        (_, _, "g1") => &["servo", "g1_servo"],
        _ => &["servo"],
    }
}
