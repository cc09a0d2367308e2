//! `show FILE` without options: a one-screen overview of the experiment.

use serde_json::json;

use crate::check::Checked;
use crate::control::words;
use crate::env::Observation;
use crate::escape::terminal::one_line;
use crate::kinds::deploy::Deployment;
use crate::kinds::evaluate::Evaluation;
use crate::kinds::learn::{Learner, Ppo};
use crate::kinds::observe::Observations;
use crate::kinds::physics::Physics;
use crate::kinds::randomize::Rows;
use crate::kinds::reward::Rewards;
use crate::kinds::task::Task;
use crate::kinds::terminate::Terminations;
use crate::robot::stated;
use crate::spec::typed::{Declared, InSection};
use crate::spec::{Experiment, Value};

/// The overview.
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
        let simulated = stated::loaded(robot, &experiment.table);
        let payload = simulated.total_mass() - robot.total_mass();
        let with = if payload > 0.0 { format!(" with a payload of {payload:.2} kg") } else { String::new() };
        let mass = simulated.total_mass();
        rows.push(("robot", format!("{}, {mass:.2} kg{with}, {} joints", robot.name, robot.joints())));
    }
    if let Some(Physics { engine, rate }) = experiment.part() {
        rows.push((Physics::SECTION, format!("{} at {rate} Hz", engine.word())));
    }
    if let Some(task) = experiment.part::<Task>() {
        let motion = task.motion().map(|motion| format!(" after the motion `{motion}`")).unwrap_or_default();
        rows.push((Task::SECTION, format!("{}{motion}, episodes of {} s", task.kind(), task.episode())));
    }
    if let Some(law) = words::law(&experiment.table) {
        rows.push(("law", law));
    }
    if let Some(exploration) = words::exploration(&experiment.table) {
        rows.push(("exploration", exploration));
    }
    if let Some(robot) =
        checked.robot.as_ref().filter(|_| experiment.section(Observations::SECTION).is_some())
    {
        rows.push((
            "observation",
            format!("{} numbers (`--signals`)", Observation::new(&experiment.table, robot).len()),
        ));
    }
    let sections =
        [Rewards::SECTION, Terminations::SECTION, Rows::SECTION, Evaluation::SECTION, Deployment::SECTION];
    for section in sections {
        if let Some(Value::Table(terms)) = experiment.table.get(section)
            && !terms.is_empty()
        {
            rows.push((section, terms.keys().cloned().collect::<Vec<_>>().join(", ")));
        }
    }
    if let Some(Learner::Ppo(learn)) = experiment.part() {
        rows.push((Learner::SECTION, format!("{} from {} samples", Ppo::KIND.name, learn.samples)));
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
