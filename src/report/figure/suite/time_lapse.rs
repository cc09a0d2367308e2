//! Time-lapse strips of a few policies of a suite: one for each point of its first axis whose trace is in the
//! store.

use super::View;
use crate::report::figure::{Figure, time_lapse};
use crate::report::group::{Group, varying};
use crate::report::model::{Arm, Measured};
use crate::report::plot::axis::written;
use crate::report::plot::{Anchor, Drawing, Ink};
use crate::report::source::Source;
use crate::report::wording::arm_in_words;
use crate::sim::Terrain;

/// Most strips.
const STRIPS: usize = 3;
/// Height of a strip with its title in pixels.
const HEIGHT: f64 = time_lapse::HEIGHT + 8.0;

/// The figure, if a run has a trace; records of runs have none.
pub fn figure(view: &View) -> Option<Figure> {
    let axes = varying(view.input, &view.groups);
    let mut points: Vec<Option<&str>> = Vec::new();
    let mut shown: Vec<(&Arm, &Measured)> = Vec::new();
    for group in &view.groups {
        let point = axes.first().and_then(|(axis, _)| group.point(axis));
        if shown.len() < STRIPS
            && !points.contains(&point)
            && let Some(found) = traced(group)
        {
            points.push(point);
            shown.push(found);
        }
    }
    let has_motion = shown.iter().any(|(arm, _)| arm.motion.is_some());
    let height = HEIGHT * shown.len() as f64;
    let mut drawing = Drawing::new(time_lapse::WIDTH, height + 48.0, "Time-lapse");
    let mut said = Vec::new();
    for (place, (arm, measured)) in shown.iter().enumerate() {
        let top = HEIGHT * place as f64 + 8.0;
        let name = arm_in_words(&arm.name);
        drawing.text([14.0, top + 8.0], &name, Ink::Text, Anchor::Start).bold = true;
        let seconds = time_lapse::strip(&mut drawing, top, arm, measured)?;
        let engine = &measured.evaluation.engine;
        said.push(format!("{} s of `{}` in {engine} ({name})", written(seconds, 2), measured.stage));
    }
    time_lapse::key(&mut drawing, height + 30.0, has_motion);
    let source =
        |(arm, measured): &(&Arm, &Measured)| Source { arm: arm.name.clone(), stage: measured.stage.clone() };
    (!shown.is_empty()).then(|| Figure {
        id: view.id(),
        title: "Time-lapse".to_owned(),
        caption: time_lapse::in_words(
            &format!("over one episode (n = 1) of each policy: {}", said.join("; ")),
            has_motion,
        ),
        sources: shown.iter().map(source).collect(),
        drawing,
    })
}

/// The first run of an arm with a trace, on uneven ground if there is one.
fn traced<'a>(group: &Group<'a>) -> Option<(&'a Arm, &'a Measured)> {
    group.runs.iter().find_map(|run| {
        let run: &'a Arm = run;
        let uneven = |measured: &&Measured| time_lapse::ground_of(run, &measured.stage) != Terrain::Flat;
        let first = time_lapse::traced(run).find(uneven).or_else(|| time_lapse::traced(run).next())?;
        Some((run, first))
    })
}
