//! `show FILE` alone: what this experiment is, on one screen.

use serde_json::json;

use crate::check::Checked;
use crate::control::words;
use crate::env::Observation;
use crate::escape::terminal::one_line;
use crate::spec::{Experiment, Value};

/// The lines that a person wants to see first.
pub fn show(checked: &Checked, as_json: bool) -> String {
    let Some(experiment) = &checked.experiment else { return String::new() };
    let rows = rows(checked, experiment);
    if as_json {
        let object: serde_json::Map<_, _> =
            rows.into_iter().map(|(key, value)| (key.to_owned(), json!(value))).collect();
        return super::pretty(&object.into());
    }
    let mut text = one_line(&format!("{}: {}", experiment.name, experiment.summary));
    for (key, value) in rows.iter().filter(|(key, _)| *key != "name" && *key != "summary") {
        text += &one_line(&format!("  {key:<12} {value}"));
    }
    text
}

fn rows(checked: &Checked, experiment: &Experiment) -> Vec<(&'static str, String)> {
    let mut rows = vec![("name", experiment.name.clone()), ("summary", experiment.summary.clone())];
    if experiment.is_abstract {
        rows.push(("abstract", "a parent for other specs; it cannot be run".to_owned()));
    }
    if let Some(robot) = &checked.robot {
        rows.push(("robot", format!("{}, {:.2} kg, {} joints", robot.name, robot.total_mass(), robot.joints())));
    }
    if let Some(physics) = experiment.section("physics") {
        rows.push(("physics", format!("{} at {} Hz", physics.text("engine"), physics.si("rate"))));
    }
    if let Some(task) = experiment.section("task") {
        let motion = task.text_if("motion").map(|motion| format!(" after the motion `{motion}`")).unwrap_or_default();
        rows.push(("task", format!("{}{motion}, episodes of {} s", task.text("kind"), task.si("episode"))));
    }
    if let Some(law) = words::law(&experiment.table) {
        rows.push(("law", law));
    }
    if let Some(exploration) = words::exploration(&experiment.table) {
        rows.push(("exploration", exploration));
    }
    if let Some(robot) = checked.robot.as_ref().filter(|_| experiment.section("observe").is_some()) {
        rows.push((
            "observation",
            format!("{} numbers (`--signals`)", Observation::new(&experiment.table, robot).len()),
        ));
    }
    for section in ["reward", "terminate", "randomize", "evaluate", "deploy"] {
        if let Some(Value::Table(terms)) = experiment.table.get(section)
            && !terms.is_empty()
        {
            rows.push((section, terms.keys().cloned().collect::<Vec<_>>().join(", ")));
        }
    }
    if let Some(learn) = experiment.section("learn") {
        rows.push(("learn", format!("{} from {} samples", learn.text("kind"), learn.count("samples"))));
    }
    if !experiment.compare.is_empty() {
        let names: Vec<String> = experiment.compare.iter().map(|path| path.display().to_string()).collect();
        rows.push(("beside", names.join(", ")));
    }
    if !experiment.profiles.is_empty() {
        rows.push(("profiles", experiment.profiles.join(", ")));
    }
    rows
}
