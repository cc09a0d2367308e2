//! A metric against the commanded speed, one panel per arm: success rates with Wilson intervals, other
//! metrics with their episodes.

use std::collections::BTreeMap;

use super::{View, policies};
use crate::outcome::{Episode, Evaluation};
use crate::report::figure::Figure;
use crate::report::metric::Metric;
use crate::report::model::Measured;
use crate::report::plot::axis::written;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::wording::{capitalised, shortened};
use crate::statistics::proportion::wilson;
use crate::statistics::summary::mean;
use crate::statistics::{CONFIDENCE, Interval};

/// Panels per row.
const COLUMNS: usize = 3;
/// Size of a panel and the gaps to the right and below, in pixels.
const PANEL: [f64; 2] = [250.0, 128.0];
const GAP: [f64; 2] = [34.0, 58.0];

/// The values of an arm over its policies, by commanded speed in mm/s.
type BySpeed = BTreeMap<i64, Vec<f64>>;

/// The figure, if an arm was evaluated at several speeds: for the named metric, or for survival.
pub fn figure(view: &View) -> Option<Figure> {
    let (stage, metric) = match view.wanted.about.first() {
        Some(about) => {
            about.rsplit_once('.').map(|(stage, metric)| (stage.to_owned(), Metric::named(metric)))?
        }
        None => (view.stage(has_speeds)?, Metric::named("survival")),
    };
    let metric = metric?;
    let arms = arms(view, &stage, &metric);
    let speeds = || arms.iter().flat_map(|(_, _, values)| values.keys().map(|speed| *speed as f64 / 1000.0));
    let last = speeds().reduce(f64::max)?;
    let scale = if metric.unit == "%" { 100.0 } else { 1.0 };
    let all = arms.iter().flat_map(|(_, _, values)| values.values().flatten()).map(|value| scale * value);
    let y = if metric.unit == "%" { Axis::over("", [0.0, 100.0], 4) } else { Axis::from_zero("", all, 4) };
    let columns = arms.len().min(COLUMNS);
    let rows = arms.len().div_ceil(columns);
    let (width, height) = (PANEL[0] + GAP[0], PANEL[1] + GAP[1]);
    let grid = Area {
        left: 60.0,
        top: 44.0,
        width: columns as f64 * width - GAP[0],
        height: rows as f64 * height - GAP[1],
    };
    let mut drawing = Drawing::new(grid.right() + 24.0, grid.bottom() + 46.0, "Against the commanded speed");
    for (at, (name, _, values)) in arms.iter().enumerate() {
        let (column, row) = (at % columns, at / columns);
        let area = grid.cell([columns, rows], [column, row], GAP);
        let label = if column == 0 { axis_label(&metric) } else { String::new() };
        let x_label = if at + columns >= arms.len() { "commanded speed (m/s)" } else { "" };
        let panel =
            Panel { area, x: Axis::over(x_label, [0.0, 1.04 * last], 5), y: Axis { label, ..y.clone() } };
        panel.frame(&mut drawing, "");
        drawing.text([area.left, area.top - 22.0], name, Ink::Text, Anchor::Start).bold = true;
        let summary =
            drawing.text([area.left, area.top - 8.0], together(&metric, values), Ink::Muted, Anchor::Start);
        summary.size = 11.0;
        draw(&mut drawing, &panel, &metric, values);
    }
    Some(Figure {
        id: view.id(),
        title: format!("{} against the commanded speed", capitalised(metric.label)),
        caption: caption(&metric, &stage, &arms),
        drawing,
        sources: view.sources(&stage),
    })
}

fn axis_label(metric: &Metric) -> String {
    if metric.unit.is_empty() {
        metric.label.to_owned()
    } else {
        format!("{} ({})", metric.label, metric.unit)
    }
}

fn caption(metric: &Metric, stage: &str, arms: &[(String, usize, BySpeed)]) -> String {
    let n = |(_, count, values): &(String, usize, BySpeed)| {
        let episodes: usize = values.values().map(Vec::len).sum();
        format!("n = {episodes} episodes at {} speeds, {}", values.len(), policies(*count))
    };
    let all: Vec<String> = arms.iter().map(n).collect();
    let n = match all.first().filter(|first| all.iter().all(|n| n == *first)) {
        Some(n) => format!("Each arm: {n}"),
        None => {
            arms.iter().zip(&all).map(|((name, ..), n)| format!("{name}: {n}")).collect::<Vec<_>>().join("; ")
        }
    };
    let how = match metric.unit {
        "%" => {
            "Dots: the share of an arm's episodes at a speed; bars: Wilson's 95 % interval, as if they were \
             drawn at random: they are a grid, so it is a scale for the eye."
        }
        _ => "Dots: episodes; line: their mean at each speed.",
    };
    format!("{} in `{stage}`. {how} {n}.", capitalised(metric.label))
}

/// Whether the episodes of an evaluation have different speeds.
fn has_speeds(measured: &Measured) -> bool {
    let evaluation = &measured.evaluation;
    let mut speeds = evaluation.episodes.iter().map(|episode| millimetres(evaluation, episode));
    let first = speeds.next().flatten();
    first.is_some() && speeds.any(|speed| speed.is_some() && speed != first)
}

/// The commanded speed of an episode, in whole mm/s.
fn millimetres(evaluation: &Evaluation, episode: &Episode) -> Option<i64> {
    episode.command.or(evaluation.command).map(|speed| libm::round(1000.0 * speed) as i64)
}

/// Name, number of policies and values of every arm with values.
fn arms(view: &View, stage: &str, metric: &Metric) -> Vec<(String, usize, BySpeed)> {
    let measured = view.measured(stage);
    let arm = |(place, group): (usize, &crate::report::group::Group<'_>)| {
        let own: Vec<&Evaluation> = measured
            .iter()
            .filter(|(at, ..)| *at == place)
            .map(|(.., measured)| &measured.evaluation)
            .collect();
        let mut values = BySpeed::new();
        for evaluation in &own {
            for (value, episode) in metric.values(evaluation).into_iter().zip(&evaluation.episodes) {
                let speed = millimetres(evaluation, episode);
                speed.into_iter().for_each(|speed| values.entry(speed).or_default().push(value));
            }
        }
        (shortened(group.name, 36), own.len(), values)
    };
    view.groups.iter().enumerate().map(arm).filter(|(.., values)| !values.is_empty()).collect()
}

/// The result over all speeds: `15 of 25, 60 % [41, 77]`.
fn together(metric: &Metric, values: &BySpeed) -> String {
    let all: Vec<f64> = values.values().flatten().copied().collect();
    match metric.unit {
        "%" if is_success(&all) => {
            let (share, interval) = share(&all);
            let n = all.iter().filter(|value| **value > 0.5).count();
            let percent = |share: f64| written(100.0 * share, 0);
            let (low, high) = (percent(interval.low), percent(interval.high));
            format!("{n} of {}: {} % [{low}, {high}]", all.len(), percent(share))
        }
        unit => {
            let scale = if unit == "%" { 100.0 } else { 1.0 };
            mean(&all)
                .map_or(String::new(), |mean| format!("mean {} {unit}", written(scale * mean, metric.digits)))
        }
    }
}

fn is_success(values: &[f64]) -> bool {
    values.iter().all(|value| *value == 0.0 || *value == 1.0)
}

fn share(values: &[f64]) -> (f64, Interval) {
    let successes = values.iter().filter(|value| **value > 0.5).count();
    (successes as f64 / values.len() as f64, wilson(successes as u64, values.len() as u64, CONFIDENCE))
}

fn draw(drawing: &mut Drawing, panel: &Panel, metric: &Metric, values: &BySpeed) {
    let scale = if metric.unit == "%" { 100.0 } else { 1.0 };
    let ink = Ink::Arm(0);
    let success = metric.unit == "%" && values.values().all(|values| is_success(values));
    let mut means = Vec::new();
    for (speed, values) in values {
        let speed = *speed as f64 / 1000.0;
        // Marks the speed of each episode, whatever its outcome.
        let foot = panel.place(speed, panel.y.range[0]);
        drawing.line(&[foot, [foot[0], foot[1] - 4.0]], Stroke::solid(Ink::Muted, 1.0));
        if success {
            let (share, interval) = share(values);
            let ends = [interval.low, interval.high].map(|end| panel.place(speed, scale * end));
            drawing.line(&ends, Stroke::solid(ink, 2.2).faint(0.35));
            drawing.dot(panel.place(speed, scale * share), 3.2, ink, 1.0);
        } else {
            let dots = values.iter().map(|value| panel.place(speed, scale * value));
            dots.for_each(|at| drawing.dot(at, 2.4, ink, 0.45));
            means.extend(mean(values).map(|mean| (speed, scale * mean)));
        }
    }
    panel.line(drawing, &means, Stroke::solid(ink, 1.6));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluation(speeds: &[f64]) -> Evaluation {
        let episode =
            |speed: &f64| Episode { command: Some(*speed), survived: *speed < 0.3, ..Episode::default() };
        Evaluation {
            command: Some(0.2),
            episodes: speeds.iter().map(episode).collect(),
            ..Evaluation::default()
        }
    }

    #[test]
    fn an_episode_of_its_own_speed_is_told_from_those_of_the_evaluation() {
        let measured = |speeds: &[f64]| Measured { evaluation: evaluation(speeds), ..Measured::default() };
        assert!(has_speeds(&measured(&[0.02, 0.04])));
        assert!(!has_speeds(&measured(&[0.04, 0.04])));
        let plain =
            Evaluation { episodes: vec![Episode::default()], command: Some(0.3), ..Evaluation::default() };
        assert_eq!(millimetres(&plain, &plain.episodes[0]), Some(300));
    }

    #[test]
    fn a_share_of_experiment_5_has_its_published_interval() {
        let values = BySpeed::from([(20, vec![1.0; 15]), (40, vec![0.0; 10])]);
        let metric = Metric::named("survival").expect("a metric");
        assert_eq!(together(&metric, &values), "15 of 25: 60 % [41, 77]");
    }
}
