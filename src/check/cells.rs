//! W0527: cells of a height field that are large for the soles, in an engine that gives each of them one
//! contact.

use super::Subject;
use super::subject::short;
use crate::diag::{Diagnostic, Sink};
use crate::kinds::evaluate::Setting;
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::height_field::HeightField;
use crate::robot::Robot;
use crate::sim::EngineName;
use crate::spec::marks;
use crate::spec::typed::{Declared, InSection};
use crate::spec::value::KIND;

/// Share of a sole's length from which on robots fall on a level field: with cells as long as 0.56 of its
/// sole G1 does in MuJoCo, with 0.67 and 0.77 TOCABI and Atlas do not.
const LARGE: f64 = 0.5;

/// Cells are small enough for the soles.
pub fn cells_are_small_for_the_soles(subject: &Subject, sink: &mut Sink) {
    let mut told = Vec::new();
    for (path, engine) in subject.tables_with_engines() {
        let ground = ground(subject, &path);
        if !told.contains(&ground) && cells_are_small(subject, &path, engine, sink).is_some() {
            told.push(ground);
        }
    }
}

/// The same for the table at this path, which runs in this engine; `None` if there is nothing to say.
pub(super) fn cells_are_small(
    subject: &Subject,
    path: &str,
    engine: EngineName,
    sink: &mut Sink,
) -> Option<()> {
    let ground = ground(subject, path);
    let is_field = subject.kind(&ground) == Some(HeightField::KIND.name);
    let cell = subject.section(&ground)?.value(HeightField::cell)?;
    let sole = subject.robot.map(shortest_sole)?;
    if !is_field || !engine.facts().touches_cells_in_points || cell < LARGE * sole {
        return None;
    }
    let key = HeightField::cell.below(&ground);
    let message = format!(
        "the cells of `{ground}` are {} long and the robot's soles {}: in engine `{}` a sole has one \
         contact with each, so the robot tips over",
        subject.written(&key),
        millimetres(sole),
        engine.word()
    );
    let mut diagnostic = Diagnostic::warning("W0527", message);
    let at = [key, marks::below(&ground, KIND)].into_iter().find_map(|at| subject.place(&at));
    if let Some(place) = at {
        diagnostic = diagnostic.at(place, "");
    }
    let most = millimetres(LARGE * sole);
    sink.emit(diagnostic.help(format!("use cells well below {most}, or the engine `rapier`")));
    Some(())
}

/// The path of the ground of a table that runs an engine.
fn ground(subject: &Subject, path: &str) -> String {
    let own = Setting::terrain.below(path);
    if subject.section(&own).is_some() { own } else { Ground::SECTION.to_owned() }
}

/// Length in m of the shorter of the two soles.
fn shortest_sole(robot: &Robot) -> f64 {
    let length = |foot: &crate::robot::model::Foot| 2.0 * foot.half_extents.x.max(foot.half_extents.y);
    robot.feet.iter().map(length).fold(f64::INFINITY, f64::min)
}

fn millimetres(length: f64) -> String {
    format!("{} mm", short((1e3 * length).round()))
}

#[cfg(test)]
mod tests {
    use super::super::subject::sample::found;
    use super::*;

    #[test]
    fn cells_half_as_long_as_a_sole_are_w0527_where_they_are_touched_in_points() {
        let robot = crate::robot::tests::robot("g1");
        let codes = |engine: &str, cell: &str, more: &str| -> Vec<&'static str> {
            let text = format!(
                "physics.engine = \"{engine}\"\n\
                 terrain = {{ kind = \"height_field\", cell = {cell}, length = 24.0, width = 6.0 }}\n{more}"
            );
            let found = found(cells_are_small_for_the_soles, &text, Some(&robot));
            found.iter().map(|found| found.code).collect()
        };
        assert_eq!(codes("batch", "0.1", ""), ["W0527"]);
        assert!(codes("batch", "0.08", "").is_empty() && codes("rapier", "0.1", "").is_empty());
        let transfer = "[deploy.mujoco]\nkind = \"transfer\"\nengine = \"mujoco\"";
        assert_eq!(codes("rapier", "0.1", transfer), ["W0527"], "a transfer has the ground of the training");
        assert_eq!(codes("batch", "0.1", transfer), ["W0527"], "a ground is reported once");
        let even = format!("{transfer}\nterrain = {{ kind = \"flat\" }}");
        assert!(codes("rapier", "0.1", &even).is_empty());
    }
}
