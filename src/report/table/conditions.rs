//! The conditions of an evaluation in words: commands, parameter sets, ground, randomization.

use super::setup::{drawn, lookup, other_ground};
use crate::kinds::evaluate::{Setting, Spread};
use crate::kinds::fine_tune::{FineTuning, Trained};
use crate::kinds::task::Walk;
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::flat::Flat;
use crate::outcome::Evaluation;
use crate::report::model::{Arm, Measured};
use crate::report::wording::{number, value};
use crate::spec::decode::default_value;
use crate::spec::marks::below;
use crate::spec::typed::{HasKinds, InSection, Keys};
use crate::spec::{Param, Section, Value};

/// `25 speeds from 0.02 to 0.5 m/s, box obstacle`; `None` for a single command on the training ground without
/// randomization.
pub fn conditions(arm: &Arm, measured: &Measured) -> Option<String> {
    let table = table(arm, &measured.stage);
    let evaluation = &measured.evaluation;
    let policy = table.and_then(|table| policy(arm, table));
    let ground = table.and_then(|table| ground(arm, table));
    let [contact, draws] = [contact, draws].map(|of| table.and_then(of));
    let parts = [speeds(evaluation), sets(evaluation), ground, contact, draws, policy];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// The same with the differences that do not make it another task: the spread of the starts, noise,
/// exploration and the time limit, where these are not the usual ones.
pub fn all_conditions(arm: &Arm, measured: &Measured) -> Option<String> {
    let parts: Vec<String> =
        conditions(arm, measured).into_iter().chain(variations(arm, &measured.stage)).collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// `perturbation 0.2 rad, observation noise`; `None` if all of it is as usual.
pub fn variations(arm: &Arm, stage: &str) -> Option<String> {
    let table = table(arm, stage)?;
    let usual = |name: &str| Spread::PARAMS.iter().find(|param| param.name == name).and_then(default_value);
    let perturbation = table.get(Spread::perturbation.name);
    let perturbation = perturbation
        .filter(|own| canonical(own) != usual(Spread::perturbation.name).as_ref().and_then(canonical));
    let limit = table.get(Setting::time_limit.name);
    let episode = lookup(arm, &Walk::episode.path());
    let limit = limit.filter(|own| episode.is_some_and(|episode| canonical(own) != canonical(episode)));
    let is_on = |key: &str| matches!(table.get(key), Some(Value::Flag(true)));
    let parts = [
        perturbation.map(|own| format!("perturbation {}", value(own))),
        is_on(Spread::noise.name).then(|| "observation noise".to_owned()),
        is_on(Spread::explore.name).then(|| "exploring".to_owned()),
        limit.map(|own| format!("time limit {}", value(own))),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// A number in SI units.
fn canonical(value: &Value) -> Option<f64> {
    match value {
        Value::Quantity(quantity) => Some(quantity.si),
        Value::Count(count) => Some(*count as f64),
        _ => None,
    }
}

/// The engine, size and conditions of an evaluation.
pub fn circumstances(arm: &Arm, measured: &Measured) -> String {
    let evaluation = &measured.evaluation;
    let place = format!("in {} at {} Hz", evaluation.engine, number(evaluation.physics_rate));
    let episodes =
        format!("{} episodes of up to {} s", evaluation.episodes.len(), number(evaluation.time_limit));
    let asked = evaluation.command.map(|_| command(evaluation));
    [Some(place), Some(episodes), asked, all_conditions(arm, measured)]
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

/// `box obstacle (height 1 cm, distance 2 m)`: the keys that have no default or another value than that, and
/// the friction if it is not that of the training.
fn ground(arm: &Arm, table: Section) -> Option<String> {
    let ground = table.below(Setting::terrain)?;
    let kind = ground.kind()?;
    let params = (Ground::KINDS.all)().into_iter().find(|known| known.name == kind)?.params;
    let trained = lookup(arm, &below(Ground::SECTION, Flat::friction.name)).and_then(canonical);
    let told = |param: &&Param| {
        let own = ground.get(param.name)?;
        let usual = if param.name == Flat::friction.name {
            trained == canonical(own)
        } else {
            default_value(param).is_some_and(|default| default.canonical() == own.canonical())
        };
        (!usual).then(|| format!("{} {}", param.name, value(own)))
    };
    let told: Vec<String> = params.iter().filter_map(|param| told(&param)).collect();
    Some(with_figures(kind, &told.join(", ")))
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
    fn conditions_name_friction_distance_spread_noise_and_exploration_that_are_not_the_usual_ones() {
        let number = |text: &str, si: f64| Value::Quantity(Quantity { si, text: text.into() });
        let text = |text: &str| Value::Text(text.into());
        let told = |rows: Vec<(&str, Value)>| {
            let rows = rows.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
            let mut fields = nested(&["evaluate", "course"], Value::Table(rows));
            fields.extend(nested(&["terrain", "friction"], number("1.0", 1.0)));
            fields.extend(nested(&["task", "episode"], number("16 s", 16.0)));
            let arm = Arm { fields, ..Arm::default() };
            let evaluation = Evaluation::default();
            let measured = Measured { stage: "evaluate.course".into(), evaluation };
            let words = all_conditions(&arm, &measured);
            assert!(words.is_some() || circumstances(&arm, &measured).ends_with("up to 0 s"));
            words.unwrap_or_default()
        };
        let ground = |rows: &[(&str, Value)]| {
            let rows = rows.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
            vec![("terrain", Value::Table(rows))]
        };
        let flat = |friction: f64| {
            told(ground(&[("kind", text("flat")), ("friction", number(&friction.to_string(), friction))]))
        };
        assert_eq!([flat(1.0), flat(0.3)], ["flat", "flat (friction 0.3)"]);
        let far = ("distance", number("1.2 m", 1.2));
        let wide = |si: f64| ("length", number(&format!("{si} m"), si));
        let kind = ("kind", text("box_obstacle"));
        assert_eq!(told(ground(&[kind.clone(), far.clone(), wide(0.4)])), "box obstacle (distance 1.2 m)");
        assert_eq!(told(ground(&[kind, far, wide(0.5)])), "box obstacle (length 0.5 m, distance 1.2 m)");
        let field = ("kind", text("height_field"));
        assert_eq!(told(ground(&[field, ("seed", Value::Count(7))])), "height field (seed 7)");
        assert_eq!(told(vec![("perturbation", number("0.01 rad", 0.01))]), "");
        assert_eq!(told(vec![("perturbation", number("0.5 rad", 0.5))]), "perturbation 0.5 rad");
        assert_eq!(
            told(vec![("noise", Value::Flag(true)), ("explore", Value::Flag(false))]),
            "observation noise"
        );
        assert_eq!(told(vec![("explore", Value::Flag(true))]), "exploring");
        assert_eq!(told(vec![("time_limit", number("16 s", 16.0))]), "");
        assert_eq!(told(vec![("time_limit", number("4 s", 4.0))]), "time limit 4 s");
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
