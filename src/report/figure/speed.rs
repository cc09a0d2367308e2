//! Forward speed of every arm in every engine: episodes as dots, means with intervals, and the command.

use super::Figure;
use crate::kinds::task::Task;
use crate::report::metric::Metric;
use crate::report::model::ReportInput;
use crate::report::plot::{Anchor, Area, Axis, Drawing, Ink, Panel, Stroke, axis::written};
use crate::report::source::sources;
use crate::report::verdict::asked_speed;
use crate::report::wording::labels;
use crate::stream::Stream;

/// The figure's name.
pub const ID: &str = "speed";

/// A row of the figure.
struct Row {
    label: String,
    ink: Ink,
    speeds: Vec<f64>,
    asked: Option<f64>,
    mean: f64,
    interval: Option<[f64; 2]>,
}

/// The figure, if the task has a speed and there are evaluations.
pub fn figure(input: &ReportInput) -> Option<Figure> {
    let rows = rows(input);
    if rows.is_empty() {
        return None;
    }
    let height = 44.0 + 34.0 * rows.len() as f64;
    let mut drawing = Drawing::new(880.0, height + 52.0, "Forward speed");
    let area = Area { left: 190.0, top: 34.0, width: 520.0, height: height - 34.0 };
    let values = rows.iter().flat_map(|row| row.speeds.iter().copied().chain(row.asked));
    let panel = Panel {
        area,
        x: Axis::from_zero("mean forward speed of an episode (m/s)", values, 6),
        y: Axis { label: String::new(), range: [0.0, rows.len() as f64], ticks: Vec::new() },
    };
    panel.frame(&mut drawing, "");
    for (value, _) in &panel.x.ticks {
        let x = panel.place(*value, 0.0)[0];
        drawing.line(&[[x, area.top], [x, area.bottom()]], Stroke::solid(Ink::Grid, 1.0));
    }
    for (place, row) in rows.iter().enumerate() {
        draw(&mut drawing, &panel, (rows.len() - place) as f64 - 0.5, row);
    }
    drawing.text([area.left, 20.0], "dashed: speed asked for", Ink::Muted, Anchor::Start).size = 11.0;
    drawing.text([area.right() + 10.0, 20.0], "mean [95 %]", Ink::Muted, Anchor::Start).size = 11.0;
    let n: Vec<String> = rows.iter().map(|row| format!("{}: n = {}", row.label, row.speeds.len())).collect();
    Some(Figure {
        id: ID.to_string(),
        title: "Forward speed".to_string(),
        caption: format!("Episodes (dots), their mean and its 95 % bootstrap interval; {}.", n.join("; ")),
        drawing,
        sources: sources(input, |arm| {
            arm.evaluations.iter().map(|measured| measured.stage.clone()).collect()
        }),
    })
}

fn rows(input: &ReportInput) -> Vec<Row> {
    let names = labels(&input.arms);
    let Some(speed) = Metric::named("speed") else { return Vec::new() };
    let mut rows = Vec::new();
    for (place, arm) in input.arms.iter().enumerate().filter(|(_, arm)| speed.suits(arm.kind::<Task>())) {
        for measured in arm.evaluations.iter().filter(|measured| !measured.evaluation.episodes.is_empty()) {
            let estimate = speed.estimate(&measured.evaluation);
            rows.push(Row {
                label: format!("{}, {}", names[place], arm.place_of(measured)),
                ink: Ink::Arm(place),
                speeds: speed.values(&measured.evaluation),
                asked: asked_speed(arm, &measured.evaluation),
                mean: estimate.value.unwrap_or(0.0),
                interval: estimate.interval().map(|ends| [ends.low, ends.high]),
            });
        }
    }
    rows
}

fn draw(drawing: &mut Drawing, panel: &Panel, height: f64, row: &Row) {
    let [_, y] = panel.place(0.0, height);
    drawing.text([panel.area.left - 12.0, y + 4.0], &row.label, row.ink, Anchor::End);
    if let Some(asked) = row.asked {
        let x = panel.place(asked, height)[0];
        drawing.line(&[[x, y - 15.0], [x, y + 15.0]], Stroke::dashed(Ink::Reference, 1.6));
    }
    let mut stream = Stream::new("report/speed/jitter");
    for speed in &row.speeds {
        let x = panel.place(*speed, height)[0];
        drawing.dot([x, y + 14.0 * (stream.uniform() - 0.5)], 2.6, row.ink, 0.3);
    }
    if let Some([low, high]) = row.interval {
        let (low, high) = (panel.place(low, height)[0], panel.place(high, height)[0]);
        drawing.line(&[[low, y], [high, y]], Stroke::solid(Ink::Text, 2.0));
        for end in [low, high] {
            drawing.line(&[[end, y - 5.0], [end, y + 5.0]], Stroke::solid(Ink::Text, 2.0));
        }
    }
    drawing.dot([panel.place(row.mean, height)[0], y], 4.5, row.ink, 1.0);
    let interval = row
        .interval
        .map_or(String::new(), |[low, high]| format!(" [{}, {}]", written(low, 2), written(high, 2)));
    let text = format!("{}{interval}", written(row.mean, 2));
    drawing.text([panel.area.right() + 10.0, y + 4.0], text, Ink::Text, Anchor::Start);
}
