//! The output of `evaluate`: one line per evaluation for programs, the tables of a report for people.

use std::fmt::Write;
use std::path::Path;

use serde_json::json;

use super::conditions::Conditions;
use crate::cli::{Format, Global, output};
use crate::deploy::Policy;
use crate::deploy::contract::robot_digest;
use crate::env::Randomized;
use crate::escape::terminal::one_line;
use crate::evaluate::Protocol;
use crate::kinds::task::Task;
use crate::kinds::terrain::Ground;
use crate::outcome::Evaluation;
use crate::report::crossing;
use crate::report::metric::average;
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::rates;
use crate::report::table::evaluation as tables;
use crate::report::table::{Cell, Table};
use crate::report::verdict::judge;
use crate::report::warning::of_evaluations;
use crate::report::wording::with_interval;
use crate::robot;
use crate::spec::Section;

/// Line width if standard output is not a terminal.
const WIDTH: usize = 120;

/// Engine and command: `rapier, 0.2 m/s`.
pub fn place(engine: &str, command: Option<f64>) -> String {
    command.map_or_else(|| engine.to_owned(), |speed| format!("{engine}, {speed} m/s"))
}

/// An evaluation as JSON.
pub fn line(evaluation: &Evaluation) -> serde_json::Value {
    let mean = |name| average(evaluation, name);
    json!({
        "engine": evaluation.engine,
        "physics_rate": evaluation.physics_rate,
        "command": evaluation.command,
        "episodes": evaluation.episodes.len(),
        "survival": mean("survival"),
        "mean_time_to_fall_s": mean("time_to_fall"),
        "single_support": mean("single_support"),
        "left_support": mean("left_support"),
        "right_support": mean("right_support"),
        "speed": mean("speed"),
        "speed_error": mean("speed_error"),
        "distance": mean("distance"),
        "drift": mean("drift"),
        "reward_per_s": mean("reward_per_s"),
        "peak_foot_force": mean("peak_foot_force"),
        "torque_rms": mean("torque_rms"),
    })
}

/// Prints the tables, the verdicts and remarks on them; programs have received their lines already.
pub fn tell(
    path: &Path,
    policy: &Policy,
    conditions: &Conditions,
    evaluations: Vec<Evaluation>,
    global: &Global,
) {
    let measured = evaluations.into_iter().map(|evaluation| {
        let evaluation = Evaluation { push: conditions.push, ..evaluation };
        let stage = place(&evaluation.engine, evaluation.command);
        Measured { stage, evaluation }
    });
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut arm = Arm {
        name,
        fields: policy.blueprint.fields.clone(),
        robot: Some(policy.blueprint.robot.clone()),
        motion: policy.blueprint.motion.clone(),
        evaluations: measured.collect(),
        ..Arm::default()
    };
    crossing::forget(&mut arm);
    let mut warnings = of_evaluations(&arm, &arm.name);
    warnings.extend(crossing::unmeasurable(&[&arm]));
    warnings.extend(beyond_training(&arm));
    if global.format != Format::Json {
        let arms = ReportInput { arms: vec![arm], ..ReportInput::default() };
        output::data(&text(policy, &conditions.protocol, &arms));
    }
    for warning in warnings.into_iter().chain(stranger(policy)) {
        output::note(global, &format!("warning: {warning}"));
    }
}

/// Header, table and verdicts.
fn text(policy: &Policy, protocol: &Protocol, input: &ReportInput) -> String {
    let arm = &input.arms[0];
    let contract = &policy.contract;
    let mut text = one_line(&format!(
        "{}: {} on {} under {} control at {} Hz, trained in {} at {} Hz by specforge {} ({:.12})",
        arm.name,
        arm.kind::<Task>(),
        contract.robot.name,
        contract.law.kind,
        contract.rates.control,
        policy.blueprint.engine(),
        contract.rates.measurement,
        contract.provenance.version,
        contract.provenance.commit,
    ));
    let rates = rates::in_words(arm.evaluations.iter().map(|measured| &measured.evaluation));
    text += &one_line(&format!("{}, physics {rates}", conditions(policy, protocol)));
    let mut table = tables::evaluation(input);
    for (head, measured) in table.columns.iter_mut().skip(1).zip(&arm.evaluations) {
        *head = measured.stage.clone();
    }
    lay_out(&table, output::width().unwrap_or(WIDTH), &mut text);
    text.push('\n');
    for measured in &arm.evaluations {
        let verdict = judge(arm, &measured.evaluation);
        let missed =
            verdict.criteria.iter().filter(|criterion| !criterion.holds).map(|criterion| &*criterion.text);
        let missed = missed.collect::<Vec<_>>().join("; ");
        let missed = match (&verdict.unjudged, missed.is_empty()) {
            (Some(reason), _) => format!(": {reason}"),
            (None, true) => String::new(),
            (None, false) => format!(" (not met: {missed})"),
        };
        text += &one_line(&format!("{}: {}{missed}", measured.stage, verdict.phrase()));
    }
    text.push_str(
        "In brackets 95 % intervals: Wilson's for the survival, bootstrap over the episodes for means.",
    );
    text
}

/// The conditions of all evaluations: `32 episodes each, seed 1000, ground slope, randomized`.
fn conditions(policy: &Policy, protocol: &Protocol) -> String {
    let ground = policy.blueprint.part::<Ground>().kind();
    let mut text =
        format!("{} episodes each, seed {}, ground {ground}", protocol.conditions.len(), protocol.seed);
    let drawn = protocol.conditions.first().map(|condition| &condition.randomized);
    let (randomized, pushed) = match drawn {
        Some(Randomized::AsTrained) => (true, false),
        Some(Randomized::By(_)) => (false, true),
        _ => (false, false),
    };
    let marks = [
        (randomized, ", randomized"),
        (pushed, ", pushed"),
        (protocol.noise, ", with noise"),
        (protocol.explore, ", exploring"),
    ];
    marks.iter().filter(|(holds, _)| *holds).for_each(|(_, words)| text.push_str(words));
    text
}

/// Writes a table in aligned columns, in blocks as wide as a line allows.
fn lay_out(table: &Table, width: usize, text: &mut String) {
    let shown = |cell: &Cell| match cell {
        Cell::Text(text) => text.clone(),
        Cell::Number(estimate) => with_interval(estimate, false),
    };
    let cells: Vec<Vec<String>> =
        table.rows.iter().map(|row| row.cells.iter().map(shown).collect()).collect();
    let count = |text: &String| text.chars().count();
    let label = table.rows.iter().map(|row| count(&row.label)).max().unwrap_or(0);
    let heads = &table.columns[1..];
    let widths: Vec<usize> = (0..heads.len())
        .map(|at| cells.iter().map(|row| count(&row[at])).chain([count(&heads[at])]).max().unwrap_or(0) + 2)
        .collect();
    let mut first = 0;
    while first < heads.len() {
        text.push('\n');
        let (mut last, mut used) = (first, label);
        while last < heads.len() && (last == first || used + widths[last] <= width) {
            used += widths[last];
            last += 1;
        }
        let mut row = |name: &str, row: &[String]| {
            let _ = write!(text, "{name:<label$}");
            for at in first..last {
                let _ = write!(text, "{:>1$}", row[at], widths[at]);
            }
            text.push('\n');
        };
        row("", heads);
        table.rows.iter().zip(&cells).for_each(|(one, cells)| row(&one.label, cells));
        first = last;
    }
}

/// A remark if commanded speeds are outside of the range of the training.
fn beyond_training(arm: &Arm) -> Option<String> {
    let [low, high] = Task::commanded(Section::new(&arm.fields))?.speed.bounds();
    let commands = arm.evaluations.iter().filter_map(|measured| measured.evaluation.command);
    let mut outside: Vec<f64> = commands.filter(|speed| !(low..=high).contains(speed)).collect();
    outside.sort_by(f64::total_cmp);
    outside.dedup();
    let trained = if low == high { format!("{low} m/s") } else { format!("{low} to {high} m/s") };
    let verb = if outside.len() == 1 { "is" } else { "are" };
    let outside: Vec<String> = outside.iter().map(f64::to_string).collect();
    let outside = outside.join(", ");
    (!outside.is_empty()).then(|| format!("{outside} m/s {verb} outside of the trained speeds, {trained}"))
}

/// A remark if the policy's robot differs from the built-in one of the same name.
fn stranger(policy: &Policy) -> Option<String> {
    let own = &policy.contract.robot;
    let shipped = robot::shipped(&own.name)?;
    (robot_digest(&shipped) != own.digest).then(|| {
        format!(
            "the robot in the policy ({:.2} kg) has other figures than the `{}` of this specforge ({:.2} \
             kg), for \
             example a payload; it was evaluated on its own",
            own.total_mass,
            own.name,
            shipped.total_mass(),
        )
    })
}
