//! The conditions of an evaluation in words: commands, parameter sets, ground, randomization.

use super::setup::{drawn, other_ground};
use crate::kinds::evaluate::{Setting, Spread};
use crate::kinds::fine_tune::{FineTuning, Trained};
use crate::kinds::terrain::box_obstacle::BoxObstacle;
use crate::kinds::terrain::height_field::HeightField;
use crate::kinds::terrain::slope::Slope;
use crate::outcome::Evaluation;
use crate::report::model::{Arm, Measured};
use crate::report::wording::{number, value};
use crate::spec::{Section, Value};

/// `25 speeds from 0.02 to 0.5 m/s, box obstacle`; `None` for a single command on the training ground without
/// randomization.
pub fn conditions(arm: &Arm, measured: &Measured) -> Option<String> {
    let table = table(arm, &measured.stage);
    let evaluation = &measured.evaluation;
    let policy = table.and_then(|table| policy(arm, table));
    let [ground, contact, draws] = [ground, contact, draws].map(|of| table.and_then(of));
    let parts = [speeds(evaluation), sets(evaluation), ground, contact, draws, policy];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// The engine, size and conditions of an evaluation.
pub fn circumstances(arm: &Arm, measured: &Measured) -> String {
    let evaluation = &measured.evaluation;
    let place = format!("in {} at {} Hz", evaluation.engine, number(evaluation.physics_rate));
    let episodes =
        format!("{} episodes of up to {} s", evaluation.episodes.len(), number(evaluation.time_limit));
    let asked = evaluation.command.map(|_| command(evaluation));
    [Some(place), Some(episodes), asked, conditions(arm, measured)]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(", ")
}

/// The command, for an evaluation without such conditions.
pub fn command(evaluation: &Evaluation) -> String {
    evaluation.command.map_or_else(|| "\u{2013}".to_owned(), |speed| format!("{} m/s", number(speed)))
}

/// The spec's table of a stage `evaluate.NAME` or `deploy.NAME`.
fn table<'a>(arm: &'a Arm, stage: &str) -> Option<Section<'a>> {
    let (section, name) = stage.split_once('.')?;
    arm.section().section(section)?.section(name)
}

fn speeds(evaluation: &Evaluation) -> Option<String> {
    let mut speeds: Vec<f64> = evaluation.episodes.iter().filter_map(|episode| episode.command).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    let (first, last) = (speeds.first()?, speeds.last()?);
    Some(format!("{} speeds from {} to {} m/s", speeds.len(), number(*first), number(*last)))
}

fn sets(evaluation: &Evaluation) -> Option<String> {
    let parameters = evaluation.episodes.first()?.parameters.len();
    let plural = if parameters == 1 { "" } else { "s" };
    (parameters > 0).then(|| format!("{} sets of {parameters} parameter{plural}", evaluation.episodes.len()))
}

/// The dimensions of grounds that are printed.
const SIZES: [&str; 4] =
    [BoxObstacle::height.name, HeightField::amplitude.name, HeightField::cell.name, Slope::angle.name];

/// `box obstacle (height 1 cm)`.
fn ground(table: Section) -> Option<String> {
    let ground = table.below(Setting::terrain)?;
    let size = |key: &&str| Some(format!("{key} {}", value(ground.get(key)?)));
    let sizes: Vec<String> = SIZES.iter().filter_map(size).collect();
    Some(with_figures(ground.kind()?, &sizes.join(", ")))
}

/// The contact stiffness, if the evaluation sets its own.
fn contact(table: Section) -> Option<String> {
    table.get(Setting::contact_time.name).map(|time| format!("contact time {}", value(time)))
}

/// A name with its values in brackets.
fn with_figures(name: &str, figures: &str) -> String {
    let name = name.replace('_', " ");
    if figures.is_empty() { name } else { format!("{name} ({figures})") }
}

/// Which of two policies is evaluated. The fine-tuned one uses the ground of its fine-tuning unless the
/// evaluation sets another. `None` for the last policy if all training used one ground.
fn policy(arm: &Arm, table: Section) -> Option<String> {
    arm.section().within::<FineTuning>()?;
    match (table.value(Setting::policy), other_ground(arm)) {
        (Some(Trained::Learner), _) => Some("before the fine-tuning".to_owned()),
        (_, Some(ground)) => Some(format!("after the fine-tuning on a {ground}")),
        (named, None) => named.map(|_| "after the fine-tuning".to_owned()),
    }
}

fn draws(table: Section) -> Option<String> {
    match table.get(Spread::randomize.name)? {
        Value::Flag(true) => Some("randomized".to_owned()),
        Value::Table(rows) if !rows.is_empty() => {
            let figures = |row: &Value| match row {
                Value::Table(row) => drawn(&Section::new(row)),
                _ => String::new(),
            };
            let told = rows.iter().map(|(name, row)| with_figures(name, &figures(row)));
            Some(told.collect::<Vec<_>>().join(" and "))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::Episode;
    use crate::spec::{Quantity, Table};

    fn nested(path: &[&str], value: Value) -> Table {
        let (first, rest) = path.split_first().expect("a path");
        let inner = if rest.is_empty() { value } else { Value::Table(nested(rest, value)) };
        Table::from([((*first).to_owned(), inner)])
    }

    fn words(fields: Table, episodes: Vec<Episode>) -> Option<String> {
        let evaluation = Evaluation { episodes, ..Evaluation::default() };
        let arm = Arm { fields, ..Arm::default() };
        conditions(&arm, &Measured { stage: "evaluate.course".into(), evaluation })
    }

    #[test]
    fn conditions_are_told_in_words_and_the_usual_ones_are_not() {
        assert_eq!(words(Table::new(), vec![Episode::default()]), None);
        let own = |key: &str, value: Value| nested(&["evaluate", "course", key], value);
        let box_obstacle =
            own("terrain", Value::Table(nested(&["kind"], Value::Text("box_obstacle".into()))));
        let at = |speed: f64| Episode { command: Some(speed), ..Episode::default() };
        let course = words(box_obstacle, vec![at(0.02), at(0.02), at(0.5)]);
        assert_eq!(course.as_deref(), Some("2 speeds from 0.02 to 0.5 m/s, box obstacle"));
        let set =
            Episode { parameters: BTreeMap::from([("link_mass".to_owned(), 0.9)]), ..Episode::default() };
        assert_eq!(words(Table::new(), vec![set; 3]).as_deref(), Some("3 sets of 1 parameter"));
        let push = own("randomize", Value::Table(nested(&["push"], Value::Flag(true))));
        assert_eq!(words(push, Vec::new()).as_deref(), Some("push"));
        assert_eq!(words(own("randomize", Value::Flag(true)), Vec::new()).as_deref(), Some("randomized"));
        assert_eq!(words(own("randomize", Value::Flag(false)), Vec::new()), None);
        let tuned = |policy: &str, first: &str| {
            let ground = |kind: &str| nested(&["terrain", "kind"], Value::Text(kind.into()));
            let mut fields = own("policy", Value::Text(policy.into()));
            fields.extend(ground(first));
            fields.insert("fine_tune".into(), Value::Table(ground("height_field")));
            words(fields, Vec::new())
        };
        assert_eq!(tuned("learner", "flat").as_deref(), Some("before the fine-tuning"));
        assert_eq!(tuned("fine_tune", "flat").as_deref(), Some("after the fine-tuning on a height field"));
        assert_eq!(tuned("fine_tune", "height_field").as_deref(), Some("after the fine-tuning"));
        let mut usual = own("episodes", Value::Count(32));
        usual.extend(nested(&["fine_tune", "samples"], Value::Count(1)));
        assert_eq!(words(usual, Vec::new()), None, "the last policy where all of it was trained");
        assert_eq!(command(&Evaluation { command: Some(0.2), ..Evaluation::default() }), "0.2 m/s");
    }

    #[test]
    fn evaluations_of_one_kind_are_told_apart_by_their_figures() {
        let quantity = |text: &str| Value::Quantity(Quantity { si: 0.0, text: text.into() });
        let own = |path: &[&str], text: &str| {
            let path = [&["evaluate", "course"], path].concat();
            words(nested(&path, quantity(text)), Vec::new()).expect("a condition")
        };
        assert_eq!(own(&["randomize", "push", "impulse"], "20 N*s"), "push (impulse 20 N*s)");
        assert_eq!(own(&["randomize", "payload", "mass"], "5 kg"), "payload (mass 5 kg)");
        assert_eq!(own(&["contact_time"], "40 ms"), "contact time 40 ms");
        let box_of = |height: &str| {
            let kind = ("kind".to_owned(), Value::Text("box_obstacle".into()));
            let ground = Value::Table(Table::from([kind, ("height".to_owned(), quantity(height))]));
            words(nested(&["evaluate", "course", "terrain"], ground), Vec::new())
        };
        assert_eq!(box_of("1 cm").as_deref(), Some("box obstacle (height 1 cm)"));
    }

    #[test]
    fn circumstances_name_engine_rate_number_and_command() {
        let evaluation = Evaluation {
            engine: "rapier".into(),
            physics_rate: 500.0,
            time_limit: 16.0,
            command: Some(0.2),
            episodes: vec![Episode::default(); 32],
            ..Evaluation::default()
        };
        let fields = nested(&["evaluate", "course", "randomize"], Value::Flag(true));
        let arm = Arm { fields, ..Arm::default() };
        let told = circumstances(&arm, &Measured { stage: "evaluate.course".into(), evaluation });
        assert_eq!(told, "in rapier at 500 Hz, 32 episodes of up to 16 s, 0.2 m/s, randomized");
    }
}
