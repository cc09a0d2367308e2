//! The parents of `specs/base/`, as they come with the program.

/// A parent: its name and its text.
type Parent = (&'static str, &'static str);

/// What all experiments share.
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
    let known = [("biped", BIPED)].into_iter().chain(TASKS).chain(ACTIONS).find(|(known, _)| *known == name);
    known.map(|(_, text)| text)
}

/// The texts of the parents of a spec, each before those that win over it.
pub fn family(task: &str, action: &str) -> Vec<&'static str> {
    ["biped", task, action].into_iter().filter_map(parent).collect()
}
