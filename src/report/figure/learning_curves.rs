//! Learning curves: return and episode length against samples and against wall time.

use super::Figure;
use crate::kinds::task::Walk;
use crate::plan::Training;
use crate::report::model::{Arm, ReportInput, Update};
use crate::report::plot::panel::label_room;
use crate::report::plot::{Area, Axis, Drawing, Ink, Panel, Stroke};
use crate::report::returns::Returns;
use crate::report::source::sources;
use crate::report::wording::{direct_labels, labels, number};

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

/// A quantity of an update, shown in a panel.
struct Quantity {
    title: &'static str,
    label: &'static str,
    of: fn(Returns, &Arm, &Update) -> Option<f64>,
}

fn quantities(returns: Returns) -> [Quantity; 2] {
    [
        Quantity { title: returns.title(), label: returns.label(), of: Returns::value },
        Quantity {
            title: "Length of an episode",
            label: "length (s)",
            of: |_, _, update| update.length_mean_s,
        },
    ]
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
    for (column, quantity) in quantities(Returns::of(&input.arms)).iter().enumerate() {
        for (row, wall) in [false, true].into_iter().enumerate() {
            let area = grid.cell([2, 2], [column, row], [room + BETWEEN, 78.0]);
            panel(&mut drawing, (input, training), area, (quantity, wall));
        }
    }
    Some(Figure {
        id: id.to_string(),
        title: title.to_string(),
        caption: caption(input, training),
        drawing,
        sources: sources(input, |arm| {
            arm.stage(training.stage()).map(|stage| stage.stage.clone()).into_iter().collect()
        }),
    })
}

fn panel(
    drawing: &mut Drawing,
    (input, training): (&ReportInput, Training),
    area: Area,
    (quantity, wall): (&Quantity, bool),
) {
    let returns = Returns::of(&input.arms);
    let place = |update: &Update| if wall { update.wall_s / 60.0 } else { update.samples as f64 / 1e6 };
    let curve = |arm: &Arm| -> Vec<(f64, f64)> {
        let point = |update: &Update| Some((place(update), (quantity.of)(returns, arm, update)?));
        arm.updates_of(training).iter().filter_map(point).collect()
    };
    let curves: Vec<Vec<(f64, f64)>> = input.arms.iter().map(curve).collect();
    let limit = if quantity.label == "length (s)" { episode_limit(input) } else { None };
    let last = input.arms.iter().flat_map(|arm| arm.updates_of(training)).map(place).fold(0.0, f64::max);
    let x_label = if wall { "wall time (min)".to_string() } else { samples_label(&input.arms, training) };
    let heights = curves.iter().flatten().map(|(_, y)| *y).chain(limit);
    let panel = Panel {
        area,
        x: Axis::over(x_label, [0.0, last.max(1e-6)], 6),
        y: Axis::from_zero(quantity.label, heights, 5),
    };
    let title = format!("{} against {}", quantity.title, if wall { "wall time" } else { "samples" });
    panel.frame(drawing, &title);
    if let Some(limit) = limit {
        panel.level(drawing, limit, Stroke::dashed(Ink::Reference, 1.2));
    }
    let names = direct_labels(&input.arms);
    let mut ends = Vec::new();
    for (place, curve) in curves.iter().enumerate() {
        panel.line(drawing, curve, Stroke::solid(Ink::Arm(place), 1.8));
        ends.extend(curve.last().map(|(_, y)| (*y, names[place].clone(), Ink::Arm(place))));
    }
    if input.arms.len() > 1 {
        panel.end_labels(drawing, &ends);
    }
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

fn caption(input: &ReportInput, training: Training) -> String {
    let names = labels(&input.arms);
    let of_arm = |(arm, name): (&Arm, &String)| {
        let updates = arm.updates_of(training);
        let hours = updates.last().map_or(0.0, |update| update.simulated_s / 3600.0);
        format!("{name}: {} updates, {} simulated hours", updates.len(), number(hours))
    };
    let arms: Vec<String> = input.arms.iter().zip(&names).map(of_arm).collect();
    let begins = match training {
        Training::First => "",
        Training::FineTuning => " The fine-tuning begins with the policies of the first training.",
    };
    format!(
        "Means over the training episodes that ended in each update, with exploration noise; one run (seed) \
         per arm ({}). Dashed: the time limit of an episode.{begins}{}",
        arms.join("; "),
        Returns::of(&input.arms).remark()
    )
}
