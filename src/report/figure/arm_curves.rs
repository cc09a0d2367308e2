//! Learning curves of a suite: the mean over an arm's seeds, with a band.

use super::{Figure, learning_curves};
use crate::report::model::{Arm, ReportInput};
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke, palette};
use crate::report::statistics::mean::bootstrap;
use crate::report::statistics::summary::mean;
use crate::report::statistics::{CONFIDENCE, Interval};
use crate::report::suite::{Group, groups, table, varying};
use crate::stream::Stream;

/// Places on the sample axis at which the seeds are compared.
const PLACES: usize = 48;
/// More curves than this go into panels of their own, one for each point of the first axis.
const TOGETHER: usize = 6;
/// Up to this many seeds are drawn one by one.
const SINGLE: usize = 5;

/// The mean curve of an arm with its interval over seeds.
struct Curve {
    samples: Vec<f64>,
    mean: Vec<f64>,
    interval: Vec<Option<Interval>>,
    single: Vec<Vec<(f64, f64)>>,
}

/// The figure, when at least one run has learned.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let groups = groups(input);
    let curves: Vec<Option<Curve>> = groups.iter().map(curve).collect();
    if curves.iter().all(Option::is_none) {
        return None;
    }
    let panels = panels(input, &groups);
    let columns = panels.len().min(2);
    let rows = panels.len().div_ceil(columns);
    let mut drawing = Drawing::new(940.0, 60.0 + 250.0 * rows as f64, "Learning curves");
    let grid = Area { left: 64.0, top: 34.0, width: 700.0, height: 250.0 * rows as f64 - 50.0 };
    let heights = curves.iter().flatten().flat_map(|curve| curve.mean.iter().copied());
    let last = curves.iter().flatten().filter_map(|curve| curve.samples.last()).copied().fold(0.0, f64::max);
    let [x, y] = [Axis::over("samples (M)", [0.0, last.max(1e-6)], 5), Axis::from_zero("return", heights, 5)];
    for (at, (title, axis, arms)) in panels.iter().enumerate() {
        let area = grid.cell([columns, rows], [at % columns, at / columns], [220.0, 74.0]);
        let panel = Panel { area, x: x.clone(), y: y.clone() };
        panel.frame(&mut drawing, title);
        let mut ends = Vec::new();
        for (place, index) in arms.iter().enumerate() {
            let Some(curve) = &curves[*index] else { continue };
            draw(&panel, &mut drawing, curve, place);
            let name = groups[*index].name_without(axis);
            ends.extend(curve.mean.last().map(|end| (*end, name, Ink::Arm(place))));
        }
        panel.end_labels(&mut drawing, &ends);
    }
    Some(Figure {
        id: learning_curves::ID.to_string(),
        title: "Learning curves".to_string(),
        caption: caption(&groups),
        drawing,
        sources: table::sources(&groups, "learner"),
    })
}

/// Title, axes that the title names, and arms of each panel.
fn panels<'a>(input: &'a ReportInput, groups: &[Group<'_>]) -> Vec<(String, Vec<&'a str>, Vec<usize>)> {
    let axes = varying(input, groups);
    let all = || vec![("Return of an episode".to_owned(), Vec::new(), (0..groups.len()).collect())];
    let Some((axis, points)) = axes.first().filter(|_| groups.len() > TOGETHER && axes.len() > 1) else { return all() };
    let of_point = |point: &&str| {
        let arms = (0..groups.len()).filter(|at| groups[*at].point(axis) == Some(*point)).collect();
        (format!("{axis}={point}"), vec![*axis], arms)
    };
    points.iter().map(of_point).collect()
}

/// The curves of an arm's runs brought to common places.
fn curve(group: &Group<'_>) -> Option<Curve> {
    let single: Vec<Vec<(f64, f64)>> = group.runs.iter().map(|run| points(run)).filter(|run| run.len() > 1).collect();
    let last = single.iter().filter_map(|run| run.last()).map(|(samples, _)| *samples).reduce(f64::min)?;
    let first = single.iter().filter_map(|run| run.first()).map(|(samples, _)| *samples).fold(0.0, f64::max);
    let place = |at: usize| first + (last - first) * at as f64 / (PLACES - 1) as f64;
    let samples: Vec<f64> = (0..PLACES).map(place).collect();
    let mut stream = Stream::new(&format!("report/bootstrap/{}/learning_curves", group.name));
    let at = |place: &f64| -> Vec<f64> { single.iter().filter_map(|run| interpolated(run, *place)).collect() };
    let values: Vec<Vec<f64>> = samples.iter().map(at).collect();
    let means = values.iter().map(|values| mean(values).unwrap_or(f64::NAN)).collect();
    let interval = values.iter().map(|values| bootstrap(&[values], CONFIDENCE, &mut stream)).collect();
    Some(Curve { samples, mean: means, interval, single })
}

/// Samples in millions and return of each update in which episodes ended.
fn points(run: &Arm) -> Vec<(f64, f64)> {
    run.updates.iter().filter_map(|update| Some((update.samples as f64 / 1e6, update.return_mean?))).collect()
}

/// The value of a curve between its points.
fn interpolated(curve: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = curve.iter().position(|(place, _)| *place >= x).unwrap_or(curve.len() - 1).max(1);
    let ((x0, y0), (x1, y1)) = (curve.get(after - 1)?, curve.get(after)?);
    let share = if x1 > x0 { ((x - x0) / (x1 - x0)).clamp(0.0, 1.0) } else { 1.0 };
    Some(y0 + share * (y1 - y0))
}

fn draw(panel: &Panel, drawing: &mut Drawing, curve: &Curve, place: usize) {
    let ink = Ink::Arm(place);
    let with_interval = curve.samples.iter().zip(&curve.interval);
    let band: Vec<(f64, f64, f64)> =
        with_interval.filter_map(|(x, interval)| interval.map(|ends| (*x, ends.low, ends.high))).collect();
    if band.len() > 1 {
        panel.band(drawing, &band, ink, 0.16);
    }
    if (2..=SINGLE).contains(&curve.single.len()) {
        curve.single.iter().for_each(|run| panel.line(drawing, run, Stroke::solid(ink, 0.8).faint(0.45)));
    }
    let means: Vec<(f64, f64)> = curve.samples.iter().copied().zip(curve.mean.iter().copied()).collect();
    // Colours begin again after the last; the second time round the lines are broken.
    let stroke = if place < palette::ARMS { Stroke::solid(ink, 1.9) } else { Stroke::dashed(ink, 1.9) };
    panel.line(drawing, &means, stroke);
}

fn caption(groups: &[Group<'_>]) -> String {
    let counts: Vec<usize> =
        groups.iter().map(|group| group.runs.iter().filter(|run| !run.updates.is_empty()).count()).collect();
    let (least, most) = (counts.iter().min().unwrap_or(&0), counts.iter().max().unwrap_or(&0));
    let n = if least == most { format!("n = {most}") } else { format!("n = {least} to {most}") };
    format!(
        "Mean return over the training episodes that ended in an update, with exploration noise, averaged over the seeds of each arm ({n}). \
         Bands: 95 % bootstrap intervals over seeds; thin lines: single runs."
    )
}

#[cfg(test)]
mod tests {
    use super::interpolated;

    #[test]
    fn a_curve_is_read_between_its_points_and_held_at_its_ends() {
        let curve = [(1.0, 10.0), (2.0, 20.0), (4.0, 40.0)];
        assert_eq!(interpolated(&curve, 1.5), Some(15.0));
        assert_eq!(interpolated(&curve, 3.0), Some(30.0));
        assert_eq!(interpolated(&curve, 0.0), Some(10.0));
        assert_eq!(interpolated(&curve, 9.0), Some(40.0));
    }
}
