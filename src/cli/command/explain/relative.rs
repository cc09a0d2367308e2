//! Units relative to the robot: what they amount to for the built-in robots, and the keys that take them.

use serde_json::json;

use super::Page;
use crate::kinds::keys::keys;
use crate::quantity::Measure;
use crate::robot::{GRAVITY, Proportions, names, shipped};
use crate::spec::Ty;

/// The page of a unit relative to the robot: `mgh/rad`.
pub fn page(word: &str) -> Option<Page> {
    let measure = Measure::ALL.into_iter().find(|measure| measure.unit() == word)?;
    let of_robots = names().filter_map(|name| Some((name, Proportions::of(&shipped(name)?))));
    let sizes: Vec<String> = of_robots
        .map(|(name, robot)| {
            let (size, unit) = size(measure, &robot);
            format!("  {name:<8} {size:.0} {unit}, as h = {:.2} m\n", robot.stands)
        })
        .collect();
    let mut paths: Vec<String> = keys()
        .into_iter()
        .filter(|key| matches!(key.param.ty, Ty::Ratio(share) if share.measure == Some(measure)))
        .map(|key| key.path)
        .collect();
    paths.dedup();
    let listed: String = paths.iter().map(|path| format!("  {path}\n")).collect();
    let text = format!(
        "# {word}\n\nA unit of {}: m is its mass, g the acceleration of gravity and h the height of its pelvis \
         (1.11 times that of its hips' pitch axes).\nWith it a number means the same for robots of any size, \
         for example `\"{}\"`. `specforge show` prints the share of the robot's own figures that it amounts \
         to.\n\n1 {word} is:\n{}\nKeys that take it:\n{listed}",
        measure.name(),
        measure.example(),
        sizes.concat(),
    );
    let facts = json!({ "dimension": measure.name(), "keys": paths });
    Some(Page { what: "unit", name: word.to_owned(), text, facts })
}

/// The size of the unit for a robot, in SI units.
fn size(measure: Measure, robot: &Proportions) -> (f64, &'static str) {
    match measure {
        Measure::Torque => (robot.torque, "N*m"),
        Measure::Stiffness => (robot.torque, "N*m/rad"),
        Measure::Damping => (robot.torque * (robot.stands / GRAVITY).sqrt(), "N*m*s/rad"),
    }
}
