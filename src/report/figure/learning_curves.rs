//! Learning curves: return, episode length and single support against samples, return against wall time.

use super::Figure;
use super::standing::{self, Level, levels};
use crate::kinds::task::Walk;
use crate::plan::Training;
use crate::report::model::{Arm, ReportInput, Update};
use crate::report::plot::panel::label_room;
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::returns::Returns;
use crate::report::source::sources;
use crate::report::wording::{direct_labels, labels, number};
use crate::statistics::summary::median;

/// The figure's name.
pub const ID: &str = "learning_curves";
/// The name of the corresponding figure for fine-tuning.
pub const TUNING_ID: &str = "fine_tuning_curves";

/// Width of the drawing in pixels, unless long names make it wider.
const WIDTH: f64 = 880.0;
/// Room on the left for the ticks and label of an axis.
const LEFT: f64 = 64.0;
/// Room for them between two panels.
const BETWEEN: f64 = 56.0;
/// Room to the right of a panel with unnamed lines.
const NO_LABELS: f64 = 18.0;
/// Minimum width of a panel.
const NARROWEST: f64 = 289.0;

/// Share of the samples over which the running median extends.
const SMOOTHED: f64 = 0.02;

/// What a panel shows of every update.
#[derive(Clone, Copy, PartialEq)]
enum Quantity {
    Return,
    ReturnByWallTime,
    Length,
    SingleSupport,
}

/// The panels, by row and column.
const PANELS: [[Quantity; 2]; 2] =
    [[Quantity::Return, Quantity::Length], [Quantity::ReturnByWallTime, Quantity::SingleSupport]];

impl Quantity {
    fn title(self, returns: Returns) -> String {
        match self {
            Self::Return => format!("{} against samples", returns.title()),
            Self::ReturnByWallTime => format!("{} against wall time", returns.title()),
            Self::Length => "Length of an episode against samples".to_owned(),
            Self::SingleSupport => "Share of steps in single support".to_owned(),
        }
    }

    fn label(self, returns: Returns) -> &'static str {
        match self {
            Self::Return | Self::ReturnByWallTime => returns.label(),
            Self::Length => "length (s)",
            Self::SingleSupport => "share of the steps (%)",
        }
    }

    fn value(self, returns: Returns, arm: &Arm, update: &Update) -> Option<f64> {
        match self {
            Self::Return | Self::ReturnByWallTime => returns.value(arm, update),
            Self::Length => update.length_mean_s,
            Self::SingleSupport => Some(100.0 * update.single_support?),
        }
    }

    fn is_by_wall_time(self) -> bool {
        self == Self::ReturnByWallTime
    }

    fn is_return(self) -> bool {
        matches!(self, Self::Return | Self::ReturnByWallTime)
    }
}

/// The input of the figure.
struct View<'a> {
    input: &'a ReportInput,
    training: Training,
    returns: Returns,
    /// The lines of standing still.
    levels: Vec<Level>,
}

/// The figure of a training, if at least one arm has learned in it.
pub fn figure(input: &ReportInput, training: Training) -> Option<Figure> {
    if input.arms.iter().all(|arm| arm.updates_of(training).is_empty()) {
        return None;
    }
    let (id, title) = match training {
        Training::First => (ID, "Learning curves"),
        Training::FineTuning => (TUNING_ID, "Learning curves of the fine-tuning"),
    };
    // A single arm is named in the caption, several arms at the ends of their lines.
    let room = if input.arms.len() > 1 { label_room(&direct_labels(&input.arms)) } else { NO_LABELS };
    let width = (0.5 * (WIDTH - LEFT - BETWEEN - 2.0 * room)).max(NARROWEST);
    let grid = Area { left: LEFT, top: 34.0, width: 2.0 * width + room + BETWEEN, height: 478.0 };
    let mut drawing = Drawing::new(grid.right() + room, 560.0, title);
    let returns = Returns::of(&input.arms);
    let values = input.arms.iter().map(|arm| standing::standing(arm, training, returns)).enumerate();
    let view = View { input, training, returns, levels: levels(values) };
    for (row, quantities) in PANELS.iter().enumerate() {
        for (column, quantity) in quantities.iter().enumerate() {
            let area = grid.cell([2, 2], [column, row], [room + BETWEEN, 78.0]);
            view.panel(&mut drawing, area, *quantity);
        }
    }
    Some(Figure {
        id: id.to_string(),
        title: title.to_string(),
        caption: view.caption(),
        drawing,
        sources: sources(input, |arm| {
            arm.stage(training.stage()).map(|stage| stage.stage.clone()).into_iter().collect()
        }),
    })
}

impl View<'_> {
    /// Draws a panel, if any update has its quantity.
    fn panel(&self, drawing: &mut Drawing, area: Area, quantity: Quantity) {
        let (arms, returns) = (&self.input.arms, self.returns);
        let by_wall_time = quantity.is_by_wall_time();
        let place =
            |update: &Update| if by_wall_time { update.wall_s / 60.0 } else { update.samples as f64 / 1e6 };
        let curve = |arm: &Arm| -> Vec<Point> {
            let point = |update: &Update| {
                let (samples, y) = (update.samples as f64, quantity.value(returns, arm, update)?);
                Some(Point { samples, x: place(update), y })
            };
            arm.updates_of(self.training).iter().filter_map(point).collect()
        };
        let curves: Vec<Vec<Point>> = arms.iter().map(curve).collect();
        if curves.iter().all(Vec::is_empty) {
            return;
        }
        let limit = if quantity == Quantity::Length { episode_limit(self.input) } else { None };
        let levels = if quantity.is_return() { self.levels.as_slice() } else { &[] };
        let last = arms.iter().flat_map(|arm| arm.updates_of(self.training)).map(place).fold(0.0, f64::max);
        let x_label =
            if by_wall_time { "wall time (min)".to_string() } else { samples_label(arms, self.training) };
        let heights = curves.iter().flatten().map(|point| point.y).chain(limit);
        let panel = Panel {
            area,
            x: Axis::over(x_label, [0.0, last.max(1e-6)], 6),
            y: Axis::from_zero(
                quantity.label(returns),
                heights.chain(levels.iter().map(|level| level.value)),
                5,
            ),
        };
        panel.frame(drawing, &quantity.title(returns));
        if let Some(limit) = limit {
            panel.level(drawing, limit, Stroke::dashed(Ink::Reference, 1.2));
        }
        for (place, curve) in curves.iter().enumerate() {
            let raw: Vec<(f64, f64)> = curve.iter().map(|point| (point.x, point.y)).collect();
            panel.line(drawing, &raw, Stroke::solid(Ink::Arm(place), 0.8).faint(0.35));
        }
        let names = direct_labels(arms);
        let mut ends = Vec::new();
        for (place, curve) in curves.iter().enumerate() {
            let smooth = running_median(curve);
            panel.line(drawing, &smooth, Stroke::solid(Ink::Arm(place), 1.8));
            ends.extend(smooth.last().map(|(_, y)| (*y, names[place].clone(), Ink::Arm(place))));
        }
        standing::draw(drawing, &panel, levels, |arm| names[arm].clone());
        if arms.len() > 1 {
            panel.end_labels(drawing, &ends);
        }
    }

    fn caption(&self) -> String {
        let arms = &self.input.arms;
        let names = labels(arms);
        let of_arm = |(arm, name): (&Arm, &String)| {
            let updates = arm.updates_of(self.training);
            let hours = updates.last().map_or(0.0, |update| update.simulated_s / 3600.0);
            format!("{name}: {} updates, {} simulated hours", updates.len(), number(hours))
        };
        let each: Vec<String> = arms.iter().zip(&names).map(of_arm).collect();
        let begins = match self.training {
            Training::First => "",
            Training::FineTuning => " The fine-tuning begins with the policies of the first training.",
        };
        let has_support =
            arms.iter().flat_map(|arm| arm.updates_of(self.training)).any(|u| u.single_support.is_some());
        let support = match has_support {
            true => " Single support: exactly one foot touches the ground, over all steps of an update.",
            false => "",
        };
        let standing = if self.levels.is_empty() { "" } else { standing::CAPTION };
        format!(
            "Means over the training episodes that ended in each update, with exploration noise; one run \
             (seed) per arm ({}). Faint: every update; lines: running medians over {} % of the samples. \
             Dashed in the panel of the length: the time limit of an episode.{standing}{support}{begins}{}",
            each.join("; "),
            100.0 * SMOOTHED,
            self.returns.remark()
        )
    }
}

/// A point of a curve.
struct Point {
    samples: f64,
    x: f64,
    y: f64,
}

/// The median of the points around each point, within [`SMOOTHED`] of the curve's samples.
fn running_median(curve: &[Point]) -> Vec<(f64, f64)> {
    let reach = 0.5 * SMOOTHED * curve.last().map_or(0.0, |point| point.samples);
    let around = |point: &Point| {
        let first = curve.partition_point(|other| other.samples < point.samples - reach);
        let end = curve.partition_point(|other| other.samples <= point.samples + reach);
        let heights: Vec<f64> = curve[first..end].iter().map(|point| point.y).collect();
        Some((point.x, median(&heights)?))
    };
    curve.iter().filter_map(around).collect()
}

/// The longest time limit of the arms' tasks, in s.
fn episode_limit(input: &ReportInput) -> Option<f64> {
    let limits = input.arms.iter().filter_map(|arm| arm.section().at(Walk::episode));
    limits.reduce(f64::max)
}

/// The label of the sample axis, with the simulated time per million samples if all arms agree on it.
fn samples_label(arms: &[Arm], training: Training) -> String {
    let hours = |arm: &Arm| {
        let last = arm
            .updates_of(training)
            .last()
            .filter(|update| update.samples > 0 && update.simulated_s > 0.0)?;
        Some(number(last.simulated_s / 3600.0 / (last.samples as f64 / 1e6)))
    };
    let ratios: Vec<String> = arms.iter().filter_map(hours).collect();
    match ratios.first() {
        Some(first) if ratios.iter().all(|ratio| ratio == first) => {
            format!("samples (M); 1 M samples = {first} simulated hours")
        }
        _ => "samples (M)".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_runs_over_a_share_of_the_samples_and_ignores_single_outliers() {
        let point = |index: u32| {
            let samples = f64::from(index) * 1000.0;
            Point { samples, x: samples / 1e6, y: if index % 7 == 3 { 0.0 } else { samples } }
        };
        let curve: Vec<Point> = (1..=1000).map(point).collect();
        let smooth = running_median(&curve);
        assert_eq!(smooth.len(), curve.len());
        let off = |(smooth, point): (&(f64, f64), &Point)| (smooth.1 - point.samples).abs();
        assert!(smooth.iter().zip(&curve).map(off).fold(0.0, f64::max) < 11_000.0);
        let few = running_median(&curve[..1]);
        assert_eq!(few, [(0.001, 1000.0)], "a single point is its own median");
    }
}
