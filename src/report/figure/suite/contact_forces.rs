//! Vertical foot forces of one policy per arm in two evaluations, such as in two engines, over one time
//! window.

use super::{View, evaluated};
use crate::report::figure::contact_forces::{has_forces, highest, panel, peak};
use crate::report::figure::{Entry, Figure, legend};
use crate::report::group::Group;
use crate::report::model::{Arm, Measured};
use crate::report::plot::axis::written;
use crate::report::plot::{Anchor, Area, Drawing, Ink, Stroke};
use crate::report::source::Source;
use crate::report::wording::shortened;
use crate::statistics::summary::mean;

/// Most arms that are drawn.
const ARMS: usize = 4;

/// A policy with both evaluations.
struct Twice<'a> {
    arm: &'a Arm,
    name: String,
    sides: [&'a Measured; 2],
}

/// The figure, if a run has traces of foot forces in two evaluations.
pub fn figure(view: &View) -> Option<Figure> {
    let twice: Vec<Twice> = view.groups.iter().filter_map(|group| of_group(view, group)).collect();
    if twice.is_empty() {
        return None;
    }
    let shown = &twice[..twice.len().min(ARMS)];
    let rows = shown.len();
    let height = 70.0 + 200.0 * rows as f64;
    let mut drawing = Drawing::new(880.0, height, "Vertical foot forces");
    let entries = [("left foot", Ink::Left), ("right foot", Ink::Right)]
        .map(|(text, ink)| Entry { stroke: Stroke::solid(ink, 1.8), text: text.to_string() });
    legend(&mut drawing, [64.0, 22.0], &entries);
    drawing.text([290.0, 22.0], "bars: scheduled contact; dashed: body weight", Ink::Muted, Anchor::Start);
    let grid = Area { left: 64.0, top: 62.0, width: 796.0, height: height - 112.0 };
    let top = highest(shown.iter().flat_map(|twice| twice.sides));
    for (row, twice) in shown.iter().enumerate() {
        for (column, measured) in twice.sides.into_iter().enumerate() {
            let area = grid.cell([2, rows], [column, row], [64.0, 72.0]);
            let ratio = twice
                .window_ratio()
                .map_or(String::new(), |ratio| format!(": peak \u{d7} {}", written(ratio, 2)));
            let title = match column {
                0 => format!("{}, {}", twice.name, twice.words(0)),
                _ => format!("the same, {}{ratio}", twice.words(1)),
            };
            panel(&mut drawing, area, twice.arm, Some(measured), title, top, column == 0);
        }
    }
    let source = |twice: &Twice| {
        twice.sides.map(|side| Source { arm: twice.arm.name.clone(), stage: side.stage.clone() })
    };
    Some(Figure {
        id: view.id(),
        title: "Vertical foot forces".to_string(),
        caption: caption(shown, twice.len()),
        drawing,
        sources: shown.iter().flat_map(source).collect(),
    })
}

fn caption(shown: &[Twice], count: usize) -> String {
    let ratio = |twice: &Twice| {
        let number = |value: Option<f64>| value.map_or("\u{2013}".to_owned(), |value| written(value, 2));
        let (window, episodes) = (number(twice.window_ratio()), number(twice.episode_ratio()));
        let n = twice.sides.map(|side| side.evaluation.episodes.len().to_string());
        format!(
            "{}: {window} in the window, {episodes} between the mean peaks of n = {} episodes",
            twice.name,
            n.join(" and ")
        )
    };
    let ratios: Vec<String> = shown.iter().map(ratio).collect();
    let rest = count - shown.len();
    let rest = if rest > 0 { format!(" {rest} more arms are not drawn.") } else { String::new() };
    format!(
        "Vertical force of the ground on each foot over two cycles from the middle of one episode per panel \
         (n = 1 each) of the first seed of an arm. \
         Largest force of the second panel over that of the first: {}.{rest}",
        ratios.join("; ")
    )
}

impl Twice<'_> {
    /// `rapier`, or the stage if both sides use the same engine.
    fn words(&self, side: usize) -> &str {
        let [first, second] = self.sides;
        let same = first.evaluation.engine == second.evaluation.engine;
        if same { &self.sides[side].stage } else { &self.sides[side].evaluation.engine }
    }

    /// Largest force in the window, second side over first side.
    fn window_ratio(&self) -> Option<f64> {
        let [first, second] = self.sides.map(peak);
        (first > 0.0).then(|| second / first)
    }

    /// The same ratio for each episode's largest force, averaged over the episodes.
    fn episode_ratio(&self) -> Option<f64> {
        let of = |side: &Measured| {
            mean(&side.evaluation.episodes.iter().map(|episode| episode.peak_foot_force).collect::<Vec<_>>())
        };
        let [first, second] = self.sides.map(of);
        Some(second? / first.filter(|force| *force > 0.0)?)
    }
}

/// The first run of an arm with both evaluations: the named ones, or the first two in different engines.
fn of_group<'a>(view: &View, group: &Group<'a>) -> Option<Twice<'a>> {
    group.runs.iter().find_map(|run| {
        let sides = match view.wanted.about.as_slice() {
            [first, second] => [evaluated(run, first)?, evaluated(run, second)?],
            _ => {
                let first = run.evaluations.iter().find(|measured| has_forces(measured))?;
                let other = |measured: &&Measured| {
                    has_forces(measured) && measured.evaluation.engine != first.evaluation.engine
                };
                [first, run.evaluations.iter().find(other)?]
            }
        };
        let name = shortened(group.name, 40);
        sides.iter().all(|side| has_forces(side)).then_some(Twice { arm: run, name, sides })
    })
}
