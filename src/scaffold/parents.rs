//! The parents of `specs/base/`, included in the program.

/// A parent: its path in `specs/base/` without the ending, and its text.
type Parent = (&'static str, &'static str);

/// The common parents of all experiments, the first of them first.
pub const COMMON: [Parent; 2] = [
    ("budget/small", include_str!("../../specs/base/budget/small.toml")),
    ("biped", include_str!("../../specs/base/biped.toml")),
];

/// The tasks.
const TASKS: [Parent; 4] = [
    ("task/run", include_str!("../../specs/base/task/run.toml")),
    ("task/squat", include_str!("../../specs/base/task/squat.toml")),
    ("task/stand", include_str!("../../specs/base/task/stand.toml")),
    ("task/walk", include_str!("../../specs/base/task/walk.toml")),
];

/// The actions.
const ACTIONS: [Parent; 2] = [
    ("action/position", include_str!("../../specs/base/action/position.toml")),
    ("action/torque", include_str!("../../specs/base/action/torque.toml")),
];

/// Exceptions of robots.
const ROBOTS: [Parent; 1] = [("robot/soft_gains", include_str!("../../specs/base/robot/soft_gains.toml"))];

/// The names of the tasks, sorted.
pub fn tasks() -> Vec<&'static str> {
    names(&TASKS)
}

/// The names of the actions, sorted.
pub fn actions() -> Vec<&'static str> {
    names(&ACTIONS)
}

/// All parents, each after those that it extends.
pub fn parents() -> impl Iterator<Item = (&'static str, &'static str)> {
    COMMON.into_iter().chain(TASKS).chain(ACTIONS).chain(ROBOTS)
}

/// The parents of a spec, as paths in `specs/base/` without the ending; later ones win. The spec names those
/// after the common ones. `own` is an exception of its robot.
pub fn family(task: &str, action: &str, own: Option<&str>) -> Vec<String> {
    let common = COMMON.iter().map(|(path, _)| (*path).to_owned());
    common.chain([format!("task/{task}"), format!("action/{action}")]).chain(own.map(str::to_owned)).collect()
}

/// The file names of parents.
fn names(parents: &[Parent]) -> Vec<&'static str> {
    parents.iter().map(|(path, _)| path.rsplit_once('/').map_or(*path, |(_, name)| name)).collect()
}
