//! Learning curves of a suite: the mean over an arm's seeds with a band, against samples (and simulated
//! hours) and wall-clock hours.

use super::View;
use crate::plan::Training;
use crate::report::figure::standing::{self, levels};
use crate::report::figure::{Figure, learning_curves};
use crate::report::group::{self, Group, varying};
use crate::report::model::{Arm, Update};
use crate::report::plot::panel::label_room;
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke, palette};
use crate::report::returns::Returns;
use crate::report::suite::interval::over_seeds;
use crate::report::wording::{number, shortened};
use crate::statistics::mean::bootstrap;
use crate::statistics::summary::mean;
use crate::statistics::{CONFIDENCE, Interval};
use crate::stream::Stream;

/// Number of bins on an axis: a run is averaged within each, and the seeds are compared at the centres.
const PARTS: usize = 48;
/// More curves than this are split into separate panels.
const TOGETHER: usize = 6;
/// The same limit for several axes: one row for each point of the first.
const CROSSED: usize = 3;
/// Curves per row if there is only one axis.
const ABREAST: usize = 4;
/// Up to this many seeds are drawn individually.
const SINGLE: usize = 5;
/// Height of a row of panels and of the gap below it, in pixels.
const ROW: [f64; 2] = [176.0, 52.0];
/// Room between two panels of a row.
const BETWEEN: f64 = 50.0;
/// Room for the axis labels below the last row.
const BELOW: f64 = 78.0;

/// The quantity on the horizontal axis.
#[derive(Clone, Copy)]
struct Effort {
    label: &'static str,
    of: fn(&Update) -> f64,
}

const SAMPLES: Effort = Effort { label: "samples (M)", of: |update| update.samples as f64 / 1e6 };
const SIMULATED: Effort = Effort { label: "simulated hours", of: |update| update.simulated_s / 3600.0 };
const WALL: Effort = Effort { label: "wall hours", of: |update| update.wall_s / 3600.0 };

/// What is drawn: the return of one of the trainings.
#[derive(Clone, Copy)]
struct Learned {
    training: Training,
    returns: Returns,
}

/// The mean curve of an arm with its interval over seeds.
struct Curve {
    places: Vec<f64>,
    mean: Vec<f64>,
    interval: Vec<Option<Interval>>,
    single: Vec<Vec<(f64, f64)>>,
}

impl Curve {
    /// The highest point of the individually drawn runs.
    fn peak(&self) -> Option<f64> {
        let drawn = self.single.iter().filter(|_| (2..=SINGLE).contains(&self.single.len()));
        drawn.flatten().map(|(_, height)| *height).reduce(f64::max)
    }

    /// The end of its longest run.
    fn end(&self) -> f64 {
        self.single.iter().filter_map(|run| run.last()).map(|(place, _)| *place).fold(0.0, f64::max)
    }
}

/// The figure of the requested training, if at least one run has learned in it.
pub fn figure(view: &View) -> Option<Figure> {
    let groups = &view.groups;
    let training = match view.wanted.about.first() {
        Some(about) if about == Training::FineTuning.section() => Training::FineTuning,
        _ => Training::First,
    };
    let hours = hours_per_million(groups, training);
    let returns = Returns::of(groups.iter().flat_map(|group| group.runs.iter().copied()));
    let learned = Learned { training, returns };
    let efforts = if hours.is_some() { vec![SAMPLES, WALL] } else { vec![SAMPLES, SIMULATED, WALL] };
    let curves: Vec<Vec<Option<Curve>>> = efforts
        .iter()
        .map(|effort| groups.iter().map(|group| curve(group, *effort, learned)).collect())
        .collect();
    let drawn = || curves.iter().flatten().flatten();
    drawn().next()?;
    let has_curve = |arm: usize| curves.iter().any(|of_effort| of_effort[arm].is_some());
    let rows = drawn_rows(rows(view, returns), has_curve);
    let names: Vec<Vec<String>> = rows.iter().map(|row| row.names(groups)).collect();
    let inks: Vec<Vec<usize>> = rows.iter().map(|row| row.inks(groups, training)).collect();
    let room = label_room(&names.concat());
    let width = if efforts.len() == 2 { 320.0 } else { 226.0 };
    let columns = efforts.len();
    let height = rows.len() as f64 * (ROW[0] + ROW[1]) - ROW[1];
    let grid = Area {
        left: 64.0,
        top: 34.0,
        width: columns as f64 * width + (columns - 1) as f64 * BETWEEN,
        height,
    };
    let title = match training {
        Training::First => "Learning curves",
        Training::FineTuning => "Learning curves of the fine-tuning",
    };
    let mut drawing = Drawing::new(grid.right() + room, grid.bottom() + BELOW, title);
    let heights = drawn().flat_map(|curve| curve.mean.iter().copied().chain(curve.peak()));
    let standing =
        |group: &Group| group.runs.iter().find_map(|run| standing::standing(run, training, returns));
    let still: Vec<Option<f64>> = groups.iter().map(standing).collect();
    let y = Axis::from_zero(
        returns.label(),
        heights.chain((0..groups.len()).filter(|arm| has_curve(*arm)).filter_map(|arm| still[arm])),
        5,
    );
    for (across, effort) in efforts.iter().enumerate() {
        for (down, row) in rows.iter().enumerate() {
            // The points of the first axis may have different budgets; rows of the same point share an axis
            // range.
            let beside = |other: &&Row| row.named.is_empty() || other.title == row.title;
            let same = |arm: &usize| rows.iter().filter(beside).any(|other| other.arms.contains(arm));
            let arms = (0..groups.len()).filter(same);
            let ends = arms.filter_map(|arm| curves[across][arm].as_ref()).map(Curve::end);
            let last = ends.fold(0.0, f64::max);
            let (first, lowest) = (across == 0, down + 1 == rows.len());
            let area = grid.cell([columns, rows.len()], [across, down], [BETWEEN, ROW[1]]);
            let x = Axis::over(if lowest { effort.label } else { "" }, [0.0, last.max(1e-6)], 5);
            let y = Axis { label: if first { y.label.clone() } else { String::new() }, ..y.clone() };
            let panel = Panel { area, x, y };
            panel.frame(&mut drawing, if first { &row.title } else { "" });
            if let Some(hours) = hours.filter(|_| first && lowest) {
                panel.second_scale(
                    &mut drawing,
                    &Axis::over(SIMULATED.label, [0.0, hours * last.max(1e-6)], 5),
                );
            }
            let levels = levels(row.arms.iter().enumerate().map(|(place, arm)| (place, still[*arm])));
            standing::draw(&mut drawing, &panel, &levels, |place| names[down][place].clone());
            let ends = draw_all(&mut drawing, &panel, row, &inks[down], &curves[across]);
            if across + 1 == columns {
                let ink = |place: usize| Ink::Arm(inks[down][place]);
                let named =
                    ends.into_iter().map(|(place, end)| (end, names[down][place].clone(), ink(place)));
                panel.end_labels(&mut drawing, &named.collect::<Vec<_>>());
            }
        }
    }
    Some(Figure {
        id: view.id(),
        title: title.to_string(),
        caption: caption(groups, hours, learned)
            + shared(&inks)
            + if still.iter().any(Option::is_some) { standing::CAPTION } else { "" },
        drawing,
        sources: group::sources(groups, training.stage()),
    })
}

/// A row of panels: its title, the axes named in the title, and its arms.
struct Row<'a> {
    title: String,
    named: Vec<&'a str>,
    arms: Vec<usize>,
}

impl Row<'_> {
    fn names(&self, groups: &[Group<'_>]) -> Vec<String> {
        self.arms.iter().map(|arm| shortened(&groups[*arm].name_without(&self.named), 34)).collect()
    }

    /// The ink of each arm, by index: that of the row's first arm that has learned in exactly the same runs.
    fn inks(&self, groups: &[Group<'_>], training: Training) -> Vec<usize> {
        let trained = |arm: &usize| -> Option<Vec<&str>> {
            let records = groups[*arm].runs.iter().map(|run| run.stage(training.stage()));
            records.map(|record| record.map(|record| record.fingerprint.as_str())).collect()
        };
        let runs: Vec<Option<Vec<&str>>> = self.arms.iter().map(trained).collect();
        let same = |place: usize| runs.iter().position(|one| one.is_some() && *one == runs[place]);
        (0..runs.len()).map(|place| same(place).unwrap_or(place)).collect()
    }
}

/// The caption's remark on arms with a shared training: their curve is drawn once.
fn shared(inks: &[Vec<usize>]) -> &'static str {
    let twice = |inks: &Vec<usize>| inks.iter().enumerate().any(|(place, ink)| place != *ink);
    if inks.iter().any(twice) { " Names of one colour in a row share a training and its curve." } else { "" }
}

fn rows<'a>(view: &View<'a>, returns: Returns) -> Vec<Row<'a>> {
    let (axes, count) = (varying(view.input, &view.groups), view.groups.len());
    let plain = |(row, arms): (usize, &[usize])| Row {
        title: if row == 0 { returns.title().to_owned() } else { String::new() },
        named: Vec::new(),
        arms: arms.to_vec(),
    };
    let Some((axis, points)) = axes.first().filter(|_| count > CROSSED && axes.len() > 1) else {
        let abreast = if count > TOGETHER { ABREAST } else { count.max(1) };
        return (0..count).collect::<Vec<_>>().chunks(abreast).enumerate().map(plain).collect();
    };
    let of_point = |point: &&'a str| {
        let arms: Vec<usize> = (0..count).filter(|at| view.groups[*at].point(axis) == Some(*point)).collect();
        let row = |arms: &[usize]| Row {
            title: format!("{axis}={point}"),
            named: vec![*axis],
            arms: arms.to_vec(),
        };
        arms.chunks(abreast(arms.len(), palette::ARMS)).map(row).collect::<Vec<_>>()
    };
    points.iter().flat_map(of_point).collect()
}

/// Curves per row, such that no colour repeats within a row and the rows are about equally full.
fn abreast(count: usize, colours: usize) -> usize {
    let rows = count.div_ceil(colours).max(1);
    count.div_ceil(rows).max(1)
}

/// The rows with curves: in an incomplete suite, those of the arms that have learned. The first keeps the
/// title.
fn drawn_rows(mut rows: Vec<Row>, has_curve: impl Fn(usize) -> bool) -> Vec<Row> {
    let title = rows.first().map(|row| row.title.clone()).unwrap_or_default();
    rows.retain(|row| row.arms.iter().any(|arm| has_curve(*arm)));
    if let Some(first) = rows.first_mut().filter(|row| row.title.is_empty()) {
        first.title = title;
    }
    rows
}

/// Draws the curves of a row; returns the position of each in the row and its last value.
fn draw_all(
    drawing: &mut Drawing,
    panel: &Panel,
    row: &Row,
    inks: &[usize],
    curves: &[Option<Curve>],
) -> Vec<(usize, f64)> {
    let mut ends = Vec::new();
    for (place, arm) in row.arms.iter().enumerate() {
        let Some(curve) = &curves[*arm] else { continue };
        if inks[place] == place {
            draw(panel, drawing, curve, place);
        }
        ends.extend(curve.mean.last().map(|end| (place, *end)));
    }
    ends
}

/// Simulated hours per million samples, if all runs agree to 0.1 %.
fn hours_per_million(groups: &[Group<'_>], training: Training) -> Option<f64> {
    let ratio = |run: &&Arm| {
        let last = run.updates_of(training).last().filter(|update| update.samples > 0)?;
        Some(last.simulated_s / 3600.0 / (last.samples as f64 / 1e6))
    };
    let ratios: Vec<f64> = groups.iter().flat_map(|group| &group.runs).filter_map(ratio).collect();
    let first = *ratios.first()?;
    ratios
        .iter()
        .all(|ratio| (ratio - first).abs() <= 1e-3 * first)
        .then_some(first)
        .filter(|hours| *hours > 0.0)
}

/// The curves of an arm's runs, resampled at common positions.
fn curve(group: &Group<'_>, effort: Effort, learned: Learned) -> Option<Curve> {
    let Learned { training, returns } = learned;
    let points = |run: &&Arm| -> Vec<(f64, f64)> {
        let point = |update: &Update| Some(((effort.of)(update), returns.value(run, update)?));
        run.updates_of(training).iter().filter_map(point).collect()
    };
    let runs: Vec<Vec<(f64, f64)>> = group.runs.iter().map(points).filter(|run| run.len() > 1).collect();
    let last = runs.iter().filter_map(|run| run.last()).map(|(place, _)| *place).reduce(f64::min)?;
    let width = last / PARTS as f64;
    let single: Vec<Vec<(f64, f64)>> = runs.iter().map(|run| averaged(run, width)).collect();
    // A run has no return before its first episode has ended.
    let first = single.iter().filter_map(|run| run.first()).map(|(place, _)| *place).fold(0.0, f64::max);
    let middles = (0..PARTS).map(|part| (part as f64 + 0.5) * width);
    let places: Vec<f64> = middles.filter(|place| *place >= first).collect();
    let mut stream = Stream::new(&format!("report/bootstrap/{}/{}", group.name, bands(training)));
    let at =
        |place: &f64| -> Vec<f64> { single.iter().filter_map(|run| interpolated(run, *place)).collect() };
    let values: Vec<Vec<f64>> = places.iter().map(at).collect();
    let means = values.iter().map(|values| mean(values).unwrap_or(f64::NAN)).collect();
    let interval = values.iter().map(|values| bootstrap(&[values], CONFIDENCE, &mut stream)).collect();
    Some(Curve { places, mean: means, interval, single })
}

/// The means of a curve over bins of this width; empty bins are omitted.
fn averaged(curve: &[(f64, f64)], width: f64) -> Vec<(f64, f64)> {
    let part = |place: f64| (place / width).ceil() as i64;
    let parts = curve.chunk_by(|(a, _), (b, _)| part(*a) == part(*b));
    let middle = |points: &[(f64, f64)]| {
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        (mean(|point| point.0), mean(|point| point.1))
    };
    let averaged: Vec<(f64, f64)> = parts.map(middle).collect();
    if averaged.len() > 1 { averaged } else { curve.to_vec() }
}

/// Linear interpolation of a curve.
fn interpolated(curve: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = curve.iter().position(|(place, _)| *place >= x).unwrap_or(curve.len() - 1).max(1);
    let ((x0, y0), (x1, y1)) = (curve.get(after - 1)?, curve.get(after)?);
    let share = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 1.0 };
    Some(y0 + share * (y1 - y0))
}

fn draw(panel: &Panel, drawing: &mut Drawing, curve: &Curve, place: usize) {
    let ink = Ink::Arm(place);
    let with_interval = curve.places.iter().zip(&curve.interval);
    let band: Vec<(f64, f64, f64)> =
        with_interval.filter_map(|(x, interval)| interval.map(|ends| (*x, ends.low, ends.high))).collect();
    if band.len() > 1 {
        panel.band(drawing, &band, ink, 0.16);
    }
    if (2..=SINGLE).contains(&curve.single.len()) {
        curve.single.iter().for_each(|run| panel.line(drawing, run, Stroke::solid(ink, 0.8).faint(0.45)));
    }
    let means: Vec<(f64, f64)> = curve.places.iter().copied().zip(curve.mean.iter().copied()).collect();
    panel.line(drawing, &means, Stroke::solid(ink, 1.9));
}

/// Suffix of the random streams' names for the bands.
fn bands(training: Training) -> &'static str {
    match training {
        Training::First => learning_curves::ID,
        Training::FineTuning => learning_curves::TUNING_ID,
    }
}

fn caption(groups: &[Group<'_>], hours: Option<f64>, learned: Learned) -> String {
    let Learned { training, returns } = learned;
    let has_learned = |run: &&&Arm| !run.updates_of(training).is_empty();
    let counts: Vec<usize> =
        groups.iter().map(|group| group.runs.iter().filter(has_learned).count()).collect();
    let (least, most) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
    let n = if least == most { format!("n = {most}") } else { format!("n = {least} to {most}") };
    let hours = hours
        .map_or(String::new(), |hours| format!(" A million samples are {} simulated hours.", number(hours)));
    let begins = match training {
        Training::First => "",
        Training::FineTuning => " The fine-tuning begins with the policies of the first training.",
    };
    format!(
        "Mean return over the training episodes that ended in an update, with exploration noise, averaged \
         over the seeds of each arm ({n}); \
         the wall time is that of the machine and of what else ran on it. Every point is the mean over a \
         {PARTS}th of the axis. A mean begins where all of its seeds have one and ends with the first of \
         them that ends, against wall hours the fastest. Bands: {}; thin lines: single \
         runs.{begins}{}{hours}",
        over_seeds(groups),
        returns.remark()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_read_between_its_points_and_held_at_its_ends() {
        let curve = [(1.0, 10.0), (2.0, 20.0), (4.0, 40.0)];
        assert_eq!(interpolated(&curve, 1.5), Some(15.0));
        assert_eq!(interpolated(&curve, 3.0), Some(30.0));
        assert_eq!(interpolated(&curve, 0.0), Some(10.0));
        assert_eq!(interpolated(&curve, 9.0), Some(40.0));
    }

    #[test]
    fn a_mean_begins_where_all_of_its_runs_have_a_return() {
        let run = |from: u64| Arm {
            updates: (0..96)
                .map(|update| Update {
                    samples: update * 1_000_000,
                    return_mean: (update >= from).then_some(5.0),
                    ..Update::default()
                })
                .collect(),
            ..Arm::default()
        };
        let (early, late) = (run(2), run(40));
        let group = Group { name: "arm", points: &[], runs: vec![&early, &late] };
        let learned = Learned { training: Training::First, returns: Returns::of([]) };
        let curve = curve(&group, SAMPLES, learned).expect("a curve");
        assert!(curve.places[0] >= 40.0 && curve.places[0] < 43.0, "{:?}", curve.places);
        assert_eq!((curve.mean.len(), curve.interval.len()), (curve.places.len(), curve.places.len()));
        assert!(curve.single[0][0].0 < 4.0, "the runs are drawn from their own first");
    }

    #[test]
    fn a_run_is_averaged_over_parts_of_the_axis() {
        let curve = [(0.5, 1.0), (1.0, 3.0), (1.5, 10.0), (3.5, 7.0)];
        assert_eq!(averaged(&curve, 1.0), [(0.75, 2.0), (1.5, 10.0), (3.5, 7.0)]);
        assert_eq!(averaged(&curve, 0.1), curve);
        assert_eq!(averaged(&curve, 9.0), curve, "one point is not a curve");
    }

    #[test]
    fn many_curves_of_a_point_are_spread_over_rows_that_are_about_equally_full() {
        assert_eq!([0, 1, 6, 7, 12, 15].map(|count| abreast(count, 6)), [1, 1, 6, 4, 6, 5]);
    }

    #[test]
    fn a_row_without_curves_is_left_out_and_the_first_has_the_title() {
        let row = |title: &str, arms: [usize; 2]| Row {
            title: title.to_owned(),
            named: Vec::new(),
            arms: arms.to_vec(),
        };
        let rows = || vec![row("return", [0, 1]), row("", [2, 3]), row("", [4, 5])];
        let titles = |from: usize| -> Vec<String> {
            drawn_rows(rows(), |arm| arm >= from).into_iter().map(|row| row.title).collect()
        };
        assert_eq!(titles(1), ["return", "", ""]);
        assert_eq!(titles(3), ["return", ""]);
        assert!(titles(6).is_empty());
    }

    #[test]
    fn arms_with_the_same_runs_have_one_ink() {
        use crate::report::model::StageRecord;
        let run = |fingerprint: &str| -> &'static Arm {
            let learner = StageRecord {
                stage: Training::First.stage().to_owned(),
                fingerprint: fingerprint.to_owned(),
                ..StageRecord::default()
            };
            Box::leak(Box::new(Arm { stages: vec![learner], ..Arm::default() }))
        };
        let unknown: &'static Arm = Box::leak(Box::new(Arm::default()));
        let runs = [
            vec![run("a"), run("b")],
            vec![run("c")],
            vec![run("a"), run("b")],
            vec![run("a")],
            vec![unknown],
        ];
        let groups = runs.map(|runs| Group { name: "arm", points: &[], runs });
        let row = Row { title: String::new(), named: Vec::new(), arms: vec![4, 0, 1, 2, 3] };
        let inks = row.inks(&groups, Training::First);
        assert_eq!(inks, [0, 1, 2, 1, 4]);
        assert!(shared(&[inks]).contains("share") && shared(&[vec![0, 1, 2]]).is_empty());
    }

    #[test]
    fn simulated_hours_are_told_once_where_all_runs_agree_on_them() {
        let run = |rate: f64| Arm {
            updates: vec![Update { samples: 9_000_000, simulated_s: 9e6 / rate, ..Update::default() }],
            ..Arm::default()
        };
        let (fast, slow) = (run(250.0), run(125.0));
        let group = |runs: Vec<&'static Arm>| Group { name: "a", points: &[], runs };
        let [fast, slow]: [&'static Arm; 2] = [Box::leak(Box::new(fast)), Box::leak(Box::new(slow))];
        let hours = hours_per_million(&[group(vec![fast, fast])], Training::First).expect("one rate");
        assert!((hours - 10.0 / 9.0).abs() < 1e-12, "{hours}");
        assert_eq!(hours_per_million(&[group(vec![fast]), group(vec![slow])], Training::First), None);
    }
}
