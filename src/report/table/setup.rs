//! The setup: robot, task, low-level control law and budget of every arm, and the differences between arms.

use super::{Cell, Table};
use crate::escape::markdown::code;
use crate::kinds::action::{Action, Position};
use crate::kinds::fine_tune;
use crate::kinds::learn::ppo::{SteeredRate, in_whole_updates};
use crate::kinds::learn::{Learner, Ppo};
use crate::kinds::physics::Physics;
use crate::kinds::pretrain::{Lesson, Pretraining};
use crate::kinds::randomize::{PER, Rows};
use crate::kinds::task::{Command, Task, Walk};
use crate::kinds::terrain::Ground;
use crate::kinds::terrain::height_field::HeightField;
use crate::report::fields;
use crate::report::model::{Arm, ReportInput};
use crate::report::wording::{count, labels, number, value};
use crate::robot::Support;
use crate::spec::marks;
use crate::spec::section;
use crate::spec::typed::InSection;
use crate::spec::value::KIND;
use crate::spec::{Section, Table as Fields, Value};

/// A row: its label, and its value for an arm.
pub type Line = (&'static str, fn(&Arm) -> Option<String>);

/// The rows of the table, in order.
pub const LINES: &[Line] = &[
    ("robot", robot),
    ("default pose", stance),
    ("task", task),
    ("reference motion", motion),
    ("commanded speed", command),
    ("low-level law", law),
    ("exploration std", |arm| field(arm, &Position::std.path())),
    ("delay of the command", |arm| field(arm, &Position::delay.path())),
    ("rates", rates),
    ("randomization", randomization),
    ("pre-training", pretraining),
    ("training budget", budget),
    ("share of the baseline's samples", scale),
    ("learner", learner),
    ("fine-tuning", fine_tuning),
    ("seed", |arm| field(arm, &Ppo::seed.path())),
];

/// The setup table.
pub fn setup(input: &ReportInput) -> Table {
    let mut table =
        Table::new("setup", "What was run", [String::new()].into_iter().chain(labels(&input.arms)));
    table.row("", "spec", input.arms.iter().map(|arm| Cell::Text(code(&arm.spec))));
    for (label, of) in LINES {
        let cells: Vec<Option<String>> = input.arms.iter().map(of).collect();
        if cells.iter().any(Option::is_some) {
            table.row(
                "",
                label,
                cells.into_iter().map(|cell| Cell::Text(cell.unwrap_or_else(|| "\u{2013}".into()))),
            );
        }
    }
    table
}

/// The table of spec values that differ between arms.
pub fn differences(input: &ReportInput) -> Table {
    let mut table = Table::new(
        "differences",
        "What differs between the arms",
        ["spec value".to_string()].into_iter().chain(labels(&input.arms)),
    );
    table.note = "All values that differ between the arms:".to_owned();
    for path in fields::differing(&input.arms) {
        let cell = |arm: &Arm| Cell::Text(field(arm, &path).unwrap_or_else(|| "\u{2013}".to_string()));
        table.row("", &format!("`{path}`"), input.arms.iter().map(cell));
    }
    table
}

/// Whether the spec has a table or a value at a path.
pub fn has(arm: &Arm, path: &str) -> bool {
    lookup(arm, path).is_some()
}

/// The value at a path.
pub fn lookup<'a>(arm: &'a Arm, path: &str) -> Option<&'a Value> {
    let (above, key) = path.rsplit_once('.').unwrap_or(("", path));
    let mut section: Section<'a> = arm.section();
    for part in above.split('.').filter(|part| !part.is_empty()) {
        section = section.section(part)?;
    }
    section.get(key)
}

/// The value at a path, as its author wrote it.
pub fn field(arm: &Arm, path: &str) -> Option<String> {
    lookup(arm, path).map(value)
}

/// The kind of a section.
fn kind<Owner: InSection>(arm: &Arm) -> Option<String> {
    field(arm, &marks::below(Owner::SECTION, KIND))
}

fn robot(arm: &Arm) -> Option<String> {
    let Some(robot) = &arm.robot else { return field(arm, &section::Robot::model.path()) };
    Some(format!("{}, {} kg, {} joints", robot.name, number(robot.total_mass()), robot.joints()))
}

/// `base 0.92 m high, centre of mass 61 mm inside the soles' support polygon`.
fn stance(arm: &Arm) -> Option<String> {
    let robot = arm.robot.as_ref()?;
    let margin = 1e3 * Support::standing_margin(robot);
    let side = if margin < 0.0 { "outside" } else { "inside" };
    let height = number(robot.standing_height);
    Some(format!(
        "base {height} m high, centre of mass {:.0} mm {side} the soles' support polygon",
        margin.abs()
    ))
}

fn task(arm: &Arm) -> Option<String> {
    let episode =
        field(arm, &Walk::episode.path()).map_or(String::new(), |text| format!(", episodes of {text}"));
    kind::<Task>(arm).map(|kind| format!("{kind}{episode}"))
}

fn motion(arm: &Arm) -> Option<String> {
    let name = field(arm, &Walk::motion.path())?;
    let Some(motion) = &arm.motion else { return Some(name) };
    Some(format!("{name}: cycle {} s, {} m/s", number(motion.period), number(motion.speed)))
}

fn command(arm: &Arm) -> Option<String> {
    field(arm, &Command::speed.below(&Walk::command.path()))
        .map(|text| format!("{text} m/s"))
        .map(|text| text.replace("m/s m/s", "m/s"))
}

fn law(arm: &Arm) -> Option<String> {
    if arm.law.is_empty() { kind::<Action>(arm) } else { Some(format!("`{}`", arm.law)) }
}

fn rates(arm: &Arm) -> Option<String> {
    let policy = field(arm, &Position::rate.path())?;
    let servo =
        field(arm, &Position::servo_rate.path()).map_or(String::new(), |rate| format!(", servo {rate}"));
    let physics = field(arm, &Physics::rate.path()).map_or(String::new(), |rate| format!(", physics {rate}"));
    let engine = field(arm, &Physics::engine.path()).map_or(String::new(), |engine| format!(" in {engine}"));
    Some(format!("policy {policy}{servo}{physics}{engine}"))
}

/// The randomizations of the spec by kind.
pub fn randomized(arm: &Arm) -> Vec<(&str, Section<'_>)> {
    let rows = arm.section().within::<Rows>().into_iter().flat_map(|rows| rows.sections());
    rows.map(|(name, row)| (row.kind().unwrap_or(name), row)).collect()
}

/// The target and distribution of a randomization: `uniform [0.6, 1.4]`, `impulse 20 N*s, duration 0.1 s`.
pub fn drawn(row: &Section) -> String {
    let told = row.table().iter().filter(|(key, _)| ![KIND, PER].contains(&key.as_str()));
    let words =
        told.map(|(key, own)| if key == "scale" { value(own) } else { format!("{key} {}", value(own)) });
    words.collect::<Vec<_>>().join(", ")
}

/// The per-episode randomization of the training, grouped by range; `none` if nothing is randomized.
fn randomization(arm: &Arm) -> Option<String> {
    if arm.kind::<Task>().is_empty() {
        return None;
    }
    let mut ranges: Vec<(String, Vec<String>)> = Vec::new();
    for (kind, row) in randomized(arm) {
        let (range, name) = (drawn(&row), kind.replace('_', " "));
        match ranges.iter_mut().find(|(known, _)| *known == range) {
            Some((_, names)) => names.push(name),
            None => ranges.push((range, vec![name])),
        }
    }
    let words = ranges.iter().map(|(range, names)| format!("{}: {range}", names.join(", ")));
    Some(if ranges.is_empty() { "none".to_owned() } else { words.collect::<Vec<_>>().join("; ") })
}

fn pretraining(arm: &Arm) -> Option<String> {
    let kind = kind::<Pretraining>(arm)?.replace('_', " ");
    let samples =
        field(arm, &Lesson::samples.path()).map_or(String::new(), |samples| format!(", {samples} samples"));
    Some(format!("{kind}{samples}"))
}

/// The number of samples of the spec's first training.
pub fn learning_samples(arm: &Arm) -> Option<u64> {
    samples(arm, &Ppo::samples.path())
}

/// The total number of samples in the spec, including any fine-tuning.
pub fn budget_samples(arm: &Arm) -> Option<u64> {
    budget_of(&arm.fields)
}

/// The same of a decoded spec.
pub fn budget_of(fields: &Fields) -> Option<u64> {
    let fields = Section::new(fields);
    let first = fields.at(Ppo::samples)?;
    let first = fields.at(Ppo::stop_at).map_or(first, |stop| first.min(stop));
    Some(first.saturating_add(fields.at(fine_tune::Ppo::samples).unwrap_or(0)))
}

/// The total number of samples that the trainings of a spec take: each ends after a whole update.
pub fn trained_samples(arm: &Arm) -> Option<u64> {
    let rollout = samples(arm, &Ppo::rollout.path())?;
    let first = samples(arm, &Ppo::samples.path())?;
    let first = samples(arm, &Ppo::stop_at.path()).map_or(first, |stop| first.min(stop));
    let tuning = samples(arm, &fine_tune::Ppo::samples.path()).unwrap_or(0);
    Some(
        [first, tuning]
            .map(|samples| in_whole_updates(samples, rollout))
            .into_iter()
            .fold(0, u64::saturating_add),
    )
}

fn samples(arm: &Arm, path: &str) -> Option<u64> {
    match lookup(arm, path)? {
        Value::Count(samples) => Some(*samples),
        _ => None,
    }
}

/// `4.0 M samples, 4005888 in whole updates of 8192 = 8.89 simulated hours, 1.0 M of them fine-tuning`.
fn budget(arm: &Arm) -> Option<String> {
    let all = budget_samples(arm)?;
    let taken = trained_samples(arm).unwrap_or(all);
    let hours = arm
        .control_rate()
        .map_or(String::new(), |rate| format!(" = {} simulated hours", number(taken as f64 / rate / 3600.0)));
    let whole = Some(taken).filter(|whole| *whole != all).zip(field(arm, &Ppo::rollout.path()));
    let whole =
        whole.map_or(String::new(), |(whole, rollout)| format!(", {whole} in whole updates of {rollout}"));
    let schedule = samples(arm, &Ppo::stop_at.path()).and(learning_samples(arm)).filter(|whole| *whole > all);
    let schedule =
        schedule.map_or(String::new(), |whole| format!(", the first of a schedule of {}", count(whole)));
    let tuning = samples(arm, &fine_tune::Ppo::samples.path())
        .map_or(String::new(), |samples| format!(", {} of them fine-tuning", count(samples)));
    Some(format!("{} samples{whole}{hours}{schedule}{tuning}", count(all)))
}

/// The kind of ground of the fine-tuning, if it differs from that of the first training.
pub fn other_ground(arm: &Arm) -> Option<String> {
    let ground = lookup(arm, &fine_tune::Ppo::terrain.path())
        .filter(|ground| Some(*ground) != lookup(arm, Ground::SECTION))?;
    let Value::Table(ground) = ground else { return None };
    Some(Section::new(ground).kind()?.replace('_', " "))
}

/// `1 M samples on a height field`, and other differences from the first training.
fn fine_tuning(arm: &Arm) -> Option<String> {
    let samples = field(arm, &fine_tune::Ppo::samples.path())?;
    let ground = other_ground(arm).map_or(String::new(), |ground| format!(" on {ground}"));
    let part = |path: String, word: &str| field(arm, &path).map(|text| format!("{word} {text}"));
    let terrain = fine_tune::Ppo::terrain.path();
    let weights = arm.section().at(fine_tune::Ppo::weights).map(|weights| {
        let terms = weights.iter().map(|(term, weight)| format!("`{term}` {}", number(*weight)));
        format!("weight of {}", terms.collect::<Vec<_>>().join(", "))
    });
    let parts = [
        part(fine_tune::Ppo::engine.path(), "in"),
        part(HeightField::amplitude.below(&terrain), "amplitude"),
        part(HeightField::cell.below(&terrain), "cell"),
        part(fine_tune::Ppo::warm_up.path(), "warm-up"),
        part(fine_tune::Ppo::std.path(), "exploration std"),
        part(SteeredRate::kl_target.below(&fine_tune::Ppo::learning_rate.path()), "KL target"),
        weights,
    ];
    let rest: Vec<String> = parts.into_iter().flatten().collect();
    Some([vec![format!("{samples} samples{ground}")], rest].concat().join(", "))
}

fn scale(arm: &Arm) -> Option<String> {
    arm.budget_share.map(|share| format!("{} %", number(100.0 * share)))
}

fn learner(arm: &Arm) -> Option<String> {
    let kind = kind::<Learner>(arm)?;
    let part = |path: String, word: &str| field(arm, &path).map(|text| format!("{word} {text}"));
    let parts = [
        part(Ppo::environments.path(), "environments"),
        part(Ppo::rollout.path(), "rollout"),
        part(Ppo::minibatch.path(), "minibatch"),
        part(Ppo::epochs.path(), "epochs"),
    ];
    Some([Some(kind)].into_iter().chain(parts).flatten().collect::<Vec<_>>().join(", "))
}
