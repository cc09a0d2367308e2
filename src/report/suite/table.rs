//! The tables of a suite: one row per arm, each number summarising the arm's seeds.

use super::tried;
use crate::kinds::task::Task;
use crate::plan::Training;
use crate::report::estimate::Estimate;
use crate::report::group::{Group, sources};
use crate::report::metric::{Metric, average};
use crate::report::model::{Arm, Measured, Update};
use crate::report::returns::Returns;
use crate::report::table::conditions::circumstances;
use crate::report::table::learning::late_episodes;
use crate::report::table::{Cell, Table, setup};
use crate::report::wording::{arm_in_words, count, listed};
use crate::spec::suite::Wanted;
use crate::statistics::summary::interquartile_mean;

/// The metrics shown for a suite, if they suit its tasks.
const SHOWN: &[&str] = &[
    "survival",
    "single_support",
    "speed_error",
    "distance",
    "flight_per_step",
    "joint_error",
    "peak_foot_force",
    "crossed",
    "torque_rms",
    "self_collision",
];

/// Metrics that are shown only if the suite has this figure.
const BESIDE: &[(&str, &str)] = &[("peak_ankle_torque", "ankle_torque")];

/// Whether a metric is shown for a suite with these figures.
fn is_shown(metric: &Metric, figures: &[String]) -> bool {
    let named = |figure: &str| figures.iter().any(|name| Wanted::parse(name).name == figure);
    SHOWN.contains(&metric.name) || BESIDE.iter().any(|(name, figure)| *name == metric.name && named(figure))
}

/// What all arms have in common.
pub fn shared(groups: &[Group<'_>]) -> Table {
    let mut table = Table::new("setup", "What all arms have in common", ["", "value"].map(String::from));
    for (label, cells) in lines(groups) {
        if let (true, Some(Some(value))) = (cells.windows(2).all(|pair| pair[0] == pair[1]), cells.first()) {
            table.row("", label, [Cell::Text(value.clone())]);
        }
    }
    let counts = tried::counts(groups);
    if !counts.is_empty() {
        table.row("", "settings of the action space", [Cell::Text(tried::words(&counts))]);
    }
    table
}

/// Differences between the arms. A sweep over several axes has one table per axis for the settings that this
/// axis alone determines, with one row per point, and a table of arms for all others.
pub fn differing(groups: &[Group<'_>], axes: &[&str]) -> Vec<Table> {
    let mut lines = lines(groups);
    lines.retain(|(_, cells)| cells.windows(2).any(|pair| pair[0] != pair[1]));
    let mut tables = Vec::new();
    for axis in if axes.len() > 1 { axes } else { &[] } {
        let points: Vec<&str> = groups.iter().filter_map(|group| group.point(axis)).collect();
        // The index of the first arm at each point.
        let firsts: Vec<usize> =
            points.iter().map(|point| points.iter().position(|one| one == point).unwrap_or(0)).collect();
        let decided = |cells: &[Option<String>]| {
            points.len() == cells.len()
                && cells.iter().zip(&firsts).all(|(cell, first)| *cell == cells[*first])
        };
        let (of_axis, rest) = lines.into_iter().partition(|(_, cells)| decided(cells));
        lines = rest;
        let rows = firsts.iter().enumerate().filter(|(at, first)| at == *first);
        let rows: Vec<(usize, &str)> = rows.map(|(at, _)| (at, points[at])).collect();
        tables.extend(arms(&format!("arms_{axis}"), axis, &of_axis, &rows));
    }
    let rows: Vec<(usize, &str)> = groups.iter().map(|group| group.name).enumerate().collect();
    tables.extend(arms("arms", "arm", &lines, &rows));
    tables
}

/// A setting with its value in every arm.
type Cells = (&'static str, Vec<Option<String>>);

/// One column per setting, and one row for each arm in `rows`; `None` without settings.
fn arms(id: &str, head: &str, lines: &[Cells], rows: &[(usize, &str)]) -> Option<Table> {
    let heads = [head.to_owned()].into_iter().chain(lines.iter().map(|(label, _)| (*label).to_owned()));
    let mut table = Table::new(id, "The arms", heads);
    for (at, name) in rows {
        let cell =
            |cells: &Vec<Option<String>>| Cell::Text(cells[*at].clone().unwrap_or_else(|| "\u{2013}".into()));
        table.row("", &arm_in_words(name), lines.iter().map(|(_, cells)| cell(cells)));
    }
    (!lines.is_empty()).then_some(table)
}

/// The settings, each with its value in the first run of every arm.
fn lines(groups: &[Group<'_>]) -> Vec<Cells> {
    let firsts: Vec<&Arm> = groups.iter().filter_map(|group| group.runs.first().copied()).collect();
    let lines = setup::LINES.iter().filter(|(label, _)| *label != "seed");
    let lines = lines.map(|(label, of)| (*label, firsts.iter().map(|arm| of(arm)).collect::<Vec<_>>()));
    lines.filter(|(_, cells)| cells.iter().any(Option::is_some)).collect()
}

/// One row per arm that learned in this training.
pub fn learning(groups: &[Group<'_>], training: Training) -> Table {
    let returns = Returns::of(groups.iter().flat_map(|group| group.runs.iter().copied()));
    let (unit, digits) = returns.format();
    let heads = [
        "arm",
        "runs",
        "samples",
        &format!("{}, last tenth", returns.label()),
        "episode length, last tenth (s)",
        "CPU time of a run (s)",
    ];
    let (id, title) = match training {
        Training::First => ("learning", "Learning"),
        Training::FineTuning => ("fine_tuning", "Fine-tuning"),
    };
    let mut table = Table::new(id, title, heads.map(String::from));
    let has_learned = |run: &&&Arm| !run.updates_of(training).is_empty();
    for group in groups.iter().filter(|group| group.runs.iter().any(|run| has_learned(&run))) {
        let learned = group.runs.iter().filter(has_learned).count();
        let last = |run: &Arm, of: fn(&Update) -> f64| run.updates_of(training).last().map(of);
        let samples = group.values(|run| last(run, |update| update.samples as f64));
        let fewest = samples.iter().copied().fold(f64::INFINITY, f64::min);
        let name = |quantity: &str| format!("{id}/{quantity}");
        let late_returns =
            group.values(|run| late_episodes(run.updates_of(training), |update| returns.value(run, update)));
        let lengths =
            group.values(|run| late_episodes(run.updates_of(training), |update| update.length_mean_s));
        let cpu = group.values(|run| last(run, |update| update.cpu_s));
        let cells = [
            Cell::Text(format!("{learned} of {}", group.runs.len())),
            Cell::Text(count(fewest as u64)),
            Estimate::mean(&late_returns, unit, digits, &name("return")).into(),
            Estimate::mean(&lengths, "s", 2, &name("length")).into(),
            Estimate::mean(&cpu, "s", 0, &name("cpu")).into(),
        ];
        let of_arm = sources(std::slice::from_ref(group), training.stage());
        table.row_from(group.name, &arm_in_words(group.name), cells, of_arm);
    }
    table.sources = sources(groups, training.stage());
    table
}

/// The stages in which any run was evaluated, in run order.
pub fn stages(groups: &[Group<'_>]) -> Vec<String> {
    let mut stages: Vec<String> = Vec::new();
    for measured in groups.iter().flat_map(|group| &group.runs).flat_map(|run| &run.evaluations) {
        if !measured.evaluation.episodes.is_empty() && !stages.contains(&measured.stage) {
            stages.push(measured.stage.clone());
        }
    }
    stages
}

/// The mean of a metric over the episodes of each evaluated run.
pub fn values(group: &Group<'_>, stage: &str, metric: &str) -> Vec<f64> {
    group.values(|run| average(&measured(run, stage)?.evaluation, metric))
}

fn measured<'a>(run: &'a Arm, stage: &str) -> Option<&'a Measured> {
    run.evaluations
        .iter()
        .find(|measured| measured.stage == stage && !measured.evaluation.episodes.is_empty())
}

/// One table per evaluation: means over seeds of each run's mean over its episodes.
pub fn outcomes(groups: &[Group<'_>], figures: &[String]) -> Vec<Table> {
    let cell = |group: &Group<'_>, stage: &str, metric: &Metric| {
        Estimate::mean(&values(group, stage, metric.name), metric.unit, metric.digits, metric.name)
    };
    per_stage(groups, figures, "", cell)
}

/// Interquartile means of the same for arms with at least four seeds; with fewer they equal the means.
pub fn interquartile(groups: &[Group<'_>], figures: &[String]) -> Vec<Table> {
    if groups.iter().all(|group| group.runs.len() < 4) {
        return Vec::new();
    }
    let cell = |group: &Group<'_>, stage: &str, metric: &Metric| {
        let values = values(group, stage, metric.name);
        let estimate = Estimate::maybe(interquartile_mean(&values), metric.unit, metric.digits);
        Estimate { n: Some(values.len()), ..estimate }
    };
    per_stage(groups, figures, "interquartile means of ", cell)
}

fn per_stage(
    groups: &[Group<'_>],
    figures: &[String],
    what: &str,
    cell: impl Fn(&Group<'_>, &str, &Metric) -> Estimate,
) -> Vec<Table> {
    let table = |stage: &String| {
        let has = |metric: &Metric, run: &Arm| {
            let measured =
                measured(run, stage).is_some_and(|measured| metric.is_measured(&measured.evaluation));
            measured && metric.suits(run.kind::<Task>())
        };
        let suits = |metric: &Metric| {
            is_shown(metric, figures)
                && groups.iter().flat_map(|group| &group.runs).any(|run| has(metric, run))
        };
        let metrics: Vec<Metric> = Metric::tabled().filter(suits).collect();
        let unit = |metric: &Metric| {
            if metric.unit.is_empty() { String::new() } else { format!(" ({})", metric.unit) }
        };
        let heads = metrics.iter().map(|metric| format!("{}{}", metric.label, unit(metric)));
        let id = format!(
            "{}{}",
            what.split(' ').next().unwrap_or_default(),
            if what.is_empty() { "" } else { "_" }
        );
        let title = format!("{what}`{stage}`");
        let mut table = Table::new(
            &format!("{id}{}", stage.replace('.', "_")),
            &title,
            ["arm".to_owned(), "seeds".to_owned()].into_iter().chain(heads),
        );
        for group in groups.iter().filter(|group| asks_for(group, stage)) {
            let seeds = values(group, stage, "survival").len();
            let cells = metrics.iter().map(|metric| Cell::from(cell(group, stage, metric)));
            let cells = [Cell::Text(seeds.to_string())].into_iter().chain(cells);
            let of_arm = sources(std::slice::from_ref(group), stage);
            table.row_from(group.name, &arm_in_words(group.name), cells, of_arm);
        }
        table.sources = sources(groups, stage);
        table.note = note(groups, stage);
        table
    };
    stages(groups).iter().map(table).collect()
}

/// Whether an arm's specs define a stage, even if it was not run.
fn asks_for(group: &Group<'_>, stage: &str) -> bool {
    group.runs.iter().any(|run| setup::has(run, stage) || measured(run, stage).is_some())
}

/// The conditions of an evaluation: once if all arms agree, else per arm.
fn note(groups: &[Group<'_>], stage: &str) -> String {
    let mut told: Vec<(String, Vec<&str>)> = Vec::new();
    for group in groups {
        let of_first = group.runs.iter().find_map(|run| Some(circumstances(run, measured(run, stage)?)));
        let Some(words) = of_first else { continue };
        match told.iter_mut().find(|(known, _)| *known == words) {
            Some((_, arms)) => arms.push(group.name),
            None => told.push((words, vec![group.name])),
        }
    }
    let sentence = |(words, arms): &(String, Vec<&str>)| match told.len() {
        1 => format!("Each policy {words}."),
        _ => {
            let arms: Vec<String> = arms.iter().map(|arm| arm_in_words(arm)).collect();
            format!("{}: each policy {words}.", listed(&arms))
        }
    };
    told.iter().map(sentence).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::outcome::{Episode, Evaluation};
    use crate::spec::{Quantity, Value};

    /// An arm of a sweep over robots and settings.
    fn arm(robot: &str, std: &str, samples: u64) -> Arm {
        let std = Value::Quantity(Quantity { si: 0.0, text: std.to_owned() });
        let tables = [
            ("robot", "model", Value::Text(robot.to_owned())),
            ("action", "std", std),
            ("learn", "samples", Value::Count(samples)),
        ];
        let table = |key: &str, value| Value::Table(BTreeMap::from([(key.to_owned(), value)]));
        let fields = tables.map(|(name, key, value)| (name.to_owned(), table(key, value)));
        Arm { fields: fields.into(), ..Arm::default() }
    }

    #[test]
    fn what_one_axis_decides_is_told_once_per_point_and_the_rest_per_arm() {
        let sweep = [("a", "x", 1), ("a", "y", 1), ("b", "x", 1), ("b", "y", 2)];
        let runs = sweep.map(|(robot, std, samples)| arm(robot, std, samples * 1_000_000));
        let points = sweep.map(|(robot, std, _)| {
            [("robot", robot), ("std", std)].map(|(a, p)| (a.to_owned(), p.to_owned()))
        });
        let names = sweep.map(|(robot, std, _)| format!("robot={robot},std={std}"));
        let group = |at: usize| Group { name: &names[at], points: &points[at], runs: vec![&runs[at]] };
        let groups: Vec<Group<'_>> = (0..4).map(group).collect();
        let told = |table: &Table| {
            let labels: Vec<&str> = table.rows.iter().map(|row| row.label.as_str()).collect();
            format!("{}: {} ({})", table.id, table.columns[..2].join(", "), labels.join(", "))
        };
        let tables: Vec<String> = differing(&groups, &["robot", "std"]).iter().map(told).collect();
        assert_eq!(
            tables,
            [
                "arms_robot: robot, robot (a, b)",
                "arms_std: std, exploration std (x, y)",
                "arms: arm, training budget (a, std x, a, std y, b, std x, b, std y)"
            ]
        );
        let one: Vec<String> = differing(&groups[..2], &["std"]).iter().map(told).collect();
        assert_eq!(one, ["arms: arm, exploration std (a, std x, a, std y)"]);
    }

    #[test]
    fn an_evaluation_has_a_row_for_every_arm_that_asks_for_it_and_for_no_other() {
        let empty = || Value::Table(BTreeMap::new());
        let asking = || Arm {
            fields: BTreeMap::from([(
                "evaluate".to_owned(),
                Value::Table([("box".to_owned(), empty())].into()),
            )]),
            ..Arm::default()
        };
        let evaluation = Evaluation { episodes: vec![Episode::default()], ..Evaluation::default() };
        let measured = Measured { stage: "evaluate.box".to_owned(), evaluation };
        let runs = [Arm { evaluations: vec![measured], ..asking() }, asking(), Arm::default()];
        let names = ["measured", "missing", "of another kind"];
        let group = |(run, name)| Group { name, points: &[], runs: vec![run] };
        let groups: Vec<Group<'_>> = runs.iter().zip(names).map(group).collect();
        let tables = outcomes(&groups, &[]);
        let labels: Vec<&str> = tables[0].rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!((tables.len(), labels), (1, vec!["measured", "missing"]));
    }

    #[test]
    fn crossing_is_shown_on_an_obstacle_and_the_ankles_beside_their_figure() {
        let measured = |stage: &str, crossed| {
            let episode = Episode { crossed, peak_ankle_torque: Some(90.0), ..Episode::default() };
            let evaluation = Evaluation { episodes: vec![episode], ..Evaluation::default() };
            Measured { stage: stage.to_owned(), evaluation }
        };
        let run = Arm {
            evaluations: vec![measured("evaluate.flat", None), measured("evaluate.box", Some(true))],
            ..Arm::default()
        };
        let groups = [Group { name: "arm", points: &[], runs: vec![&run] }];
        let shown = |figures: &[String], head: &str| -> Vec<bool> {
            let tables = outcomes(&groups, figures).into_iter();
            tables.map(|table| table.columns.iter().any(|column| column.starts_with(head))).collect()
        };
        assert_eq!(shown(&[], "crossed"), [false, true]);
        assert_eq!(shown(&[], "peak ankle"), [false, false]);
        let figures = ["ankle_torque:evaluate.flat,evaluate.box".to_owned()];
        assert_eq!(shown(&figures, "peak ankle"), [true, true]);
    }
}
