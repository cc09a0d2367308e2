//! E0520 and E0521: what the batch engine cannot simulate.

use super::Subject;
use super::subject::duration;
use crate::diag::{Diagnostic, Sink};
use crate::robot::{Robot, Shape};

/// Time constant of contacts in s where a spec names none.
const CONTACT_TIME: f64 = 0.02;

/// Where a spec simulates: the path that names the engine, the engine, and the paths of the ground and of the table.
fn arenas<'a>(subject: &Subject<'a>) -> Vec<(String, &'a str, String, String)> {
    let trained = subject.text("physics.engine");
    let mut arenas: Vec<_> = trained
        .map(|engine| ("physics.engine".to_owned(), engine, "terrain".to_owned(), "physics".to_owned()))
        .into_iter()
        .collect();
    let tuned = subject.section("fine_tune").map(|_| "fine_tune".to_owned());
    for path in tuned.into_iter().chain(subject.protocols().into_iter().map(|(path, _)| path)) {
        let (key, own) = (format!("{path}.engine"), format!("{path}.terrain"));
        let ground = if subject.section(&own).is_some() { own } else { "terrain".to_owned() };
        if let Some(engine) = subject.text(&key) {
            arenas.push((key, engine, ground, path));
        } else if let Some(engine) = trained {
            arenas.push(("physics.engine".to_owned(), engine, ground, path));
        }
    }
    arenas.retain(|(_, engine, ..)| *engine == "batch");
    arenas
}

/// What the engine does not support on a kind of ground, with what else would help.
fn unsupported(robot: Option<&Robot>, ground: &str) -> Option<(String, &'static str)> {
    if ground == "height_field" {
        return Some(("height fields".to_owned(), ""));
    }
    let robot = robot.filter(|_| ground == "box_obstacle")?;
    // A foot's link has the box of its sole and nothing else.
    let is_foot = |index: usize| robot.feet.iter().any(|foot| foot.link == index);
    let links = robot.links.iter().enumerate().filter(|(index, _)| !is_foot(*index)).map(|(_, link)| &link.body);
    let mut bodies = std::iter::once(&robot.base).chain(links);
    let round = bodies.find(|body| body.collisions.iter().any(|one| matches!(one.shape, Shape::Cylinder(..))))?;
    Some((format!("cylinders (of `{}`) on `box_obstacle`", round.name), ", or give the link a capsule or a box"))
}

/// The ground and the shapes are those that the engine supports.
pub fn the_batch_engine_supports_it(subject: &Subject, sink: &mut Sink) {
    let mut told = Vec::new();
    for (key, _, ground, _) in arenas(subject) {
        let kind = subject.kind(&ground).unwrap_or_default();
        let Some((what, else_)) = unsupported(subject.robot, kind) else { continue };
        if told.contains(&(key.clone(), ground.clone())) {
            continue;
        }
        let mut diagnostic = Diagnostic::error("E0520", format!("engine `batch` does not support {what}"));
        if let Some(place) = subject.place(&key) {
            diagnostic = diagnostic.at(place, format!("the ground is `{ground}`"));
        }
        let fix = format!("set `{key} = \"mujoco\"` or `\"rapier\"`, which support it{else_}");
        sink.emit(diagnostic.help(fix));
        told.push((key, ground));
    }
}

/// A contact's time constant is at least two physics steps.
pub fn contacts_are_slower_than_steps(subject: &Subject, sink: &mut Sink) {
    for (_, _, _, path) in arenas(subject) {
        let key = format!("{path}.contact_time");
        let own = subject.number(&key);
        let rate = subject.number(&format!("{path}.rate")).or_else(|| subject.number("physics.rate"));
        let Some(step) = rate.filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate) else { continue };
        let time = own.unwrap_or(CONTACT_TIME);
        if time >= 2.0 * step * (1.0 - 1e-9) {
            continue;
        }
        // Without a key of its own, a rate that the training has is named once, there.
        let has_rate = path == "physics" || subject.number(&format!("{path}.rate")).is_some();
        if own.is_none() && !has_rate {
            continue;
        }
        let message = format!(
            "contacts with a time constant of {} need physics steps of at most {} in engine `batch`, not {}",
            duration(time),
            duration(time / 2.0),
            duration(step)
        );
        let mut diagnostic = Diagnostic::error("E0521", message);
        let at = if own.is_some() { key } else { format!("{path}.rate") };
        if let Some(place) = subject.place(&at) {
            diagnostic = diagnostic.at(place, "too few steps for a contact");
        }
        let hertz = (2.0 / time).ceil();
        sink.emit(
            diagnostic.help(format!("set the physics rate to at least \"{hertz} Hz\", or a longer `contact_time`")),
        );
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::super::subject::sample::found;
    use super::*;
    use crate::robot::Collision;

    fn barrel() -> Robot {
        let mut robot = crate::robot::shipped("tocabi").expect("it is shipped");
        let barrel = Collision { shape: Shape::Cylinder(0.2, 0.1), pose: Isometry3::identity() };
        robot.base.collisions.push(barrel);
        robot
    }

    fn codes(text: &str, robot: &Robot) -> Vec<&'static str> {
        found(the_batch_engine_supports_it, text, Some(robot)).iter().map(|found| found.code).collect()
    }

    #[test]
    fn a_height_field_and_a_cylinder_on_a_box_are_e0520_in_the_batch_engine_only() {
        let spec =
            |engine: &str, kind: &str| format!("[physics]\nengine = \"{engine}\"\n[terrain]\nkind = \"{kind}\"\n");
        let plain = crate::robot::shipped("tocabi").expect("it is shipped");
        assert_eq!(codes(&spec("batch", "height_field"), &plain), ["E0520"]);
        assert_eq!(codes(&spec("batch", "box_obstacle"), &barrel()), ["E0520"]);
        for (engine, kind) in
            [("batch", "flat"), ("batch", "slope"), ("mujoco", "height_field"), ("rapier", "box_obstacle")]
        {
            assert!(codes(&spec(engine, kind), &barrel()).is_empty(), "{engine} on {kind}");
        }
        assert!(codes(&spec("batch", "box_obstacle"), &plain).is_empty());
        let transfer = format!("{}[deploy.there]\nengine = \"batch\"\n", spec("rapier", "height_field"));
        assert_eq!(codes(&transfer, &plain), ["E0520"]);
        let tuned = format!("{}[fine_tune]\nengine = \"batch\"\n", spec("rapier", "height_field"));
        assert_eq!(codes(&tuned, &plain), ["E0520"]);
        let own = format!(
            "{}[evaluate.rough]\nepisodes = 2\n[evaluate.rough.terrain]\nkind = \"height_field\"\n",
            spec("batch", "flat")
        );
        assert_eq!(codes(&own, &plain), ["E0520"]);
    }

    #[test]
    fn a_contact_within_two_steps_is_e0521() {
        let codes = |text: &str| -> Vec<&'static str> {
            found(contacts_are_slower_than_steps, text, None).iter().map(|found| found.code).collect()
        };
        let spec =
            |engine: &str, rate: f64, more: &str| format!("[physics]\nengine = \"{engine}\"\nrate = {rate:?}\n{more}");
        assert_eq!(codes(&spec("batch", 90.0, "")), ["E0521"]);
        assert!(codes(&spec("batch", 100.0, "")).is_empty());
        let stiff = "[evaluate.stiff]\nepisodes = 2\ncontact_time = 0.003\n";
        assert_eq!(codes(&spec("batch", 500.0, stiff)), ["E0521"]);
        assert!(codes(&spec("batch", 1000.0, stiff)).is_empty());
        assert!(codes(&spec("mujoco", 500.0, stiff)).is_empty());
        // Named once, where the rate is.
        assert_eq!(codes(&spec("batch", 50.0, "[evaluate.nominal]\nepisodes = 2\n")), ["E0521"]);
    }
}
