//! A time-lapse of stick figures from the side, with the reference motion at the same phases.

use std::ops::Range;

use super::skeleton::{Posture, Skeleton, crown, skeleton};
use super::{Entry, Figure, legend, window};
use crate::env::ground;
use crate::kinds::evaluate::Setting;
use crate::kinds::fine_tune::Trained;
use crate::kinds::motion::{Frame, Motion};
use crate::kinds::terrain::Ground;
use crate::outcome::Trace;
use crate::plan::tuned;
use crate::report::model::{Arm, Measured, ReportInput};
use crate::report::plot::{Anchor, Drawing, Ink, Point, Stroke, axis::written};
use crate::report::source::Source;
use crate::report::wording::labels;
use crate::robot::Robot;
use crate::sim::Terrain;
use crate::spec::Section;
use crate::spec::typed::{InSection, Part};

/// Prefix of the figures' names.
pub const ID: &str = "time_lapse";

/// Number of stick figures.
const POSES: usize = 12;
/// Vertical force in N above which a foot counts as in contact.
const CONTACT: f64 = 10.0;
/// Distance between two figures in pixels.
const SPACING: f64 = 72.0;
/// Distance in m before and behind an obstacle that a strip shows.
const AROUND: f64 = 0.4;
/// Points of the line of uneven ground under a figure.
const GROUND_POINTS: usize = 37;

/// Height of a strip with its remarks in pixels.
pub const HEIGHT: f64 = 270.0;
/// Width of a strip in pixels.
pub const WIDTH: f64 = 912.0;

/// The figure for an arm's first evaluation with a trace.
pub fn figure(input: &ReportInput, arm: usize) -> Option<Figure> {
    let name = &labels(&input.arms)[arm];
    let arm = &input.arms[arm];
    let measured = traced(arm).next()?;
    let mut drawing = Drawing::new(WIDTH, HEIGHT + 48.0, format!("Time-lapse of {}", arm.name));
    let seconds = strip(&mut drawing, 0.0, arm, measured)?;
    key(&mut drawing, HEIGHT + 30.0, arm.motion.is_some());
    Some(Figure {
        id: format!("{ID}_{}", arm.name),
        title: format!("Time-lapse: {name}"),
        caption: caption(arm, &measured.evaluation.engine, seconds),
        drawing,
        sources: vec![Source { arm: arm.name.clone(), stage: measured.stage.clone() }],
    })
}

/// The evaluations of an arm with a trace that stick figures can be drawn from.
pub fn traced(arm: &Arm) -> impl Iterator<Item = &Measured> {
    let robot = arm.robot.as_ref();
    arm.evaluations
        .iter()
        .filter(move |measured| robot.is_some_and(|robot| is_complete(&measured.evaluation.trace, robot)))
}

/// Draws the strip of an evaluation below `top`; returns the duration that it shows, in s.
pub fn strip(drawing: &mut Drawing, top: f64, arm: &Arm, measured: &Measured) -> Option<f64> {
    let robot = arm.robot.as_ref()?;
    let (trace, terrain) = (&measured.evaluation.trace, ground_of(arm, &measured.stage));
    let rows = shown(trace, &terrain, arm.motion.as_ref());
    let (first, last) = (rows.start, rows.end - 1);
    let (scale, ground) = (150.0 / tallest(robot), top + 226.0);
    let strip = Strip { robot, trace, terrain, scale, top, ground };
    if strip.terrain == Terrain::Flat {
        drawing.line(&[[14.0, ground], [898.0, ground]], Stroke::solid(Ink::Muted, 1.0));
    }
    for pose in 0..POSES {
        let row = first + (last - first) * pose / (POSES - 1);
        let centre = 24.0 + SPACING * (pose as f64 + 0.5);
        strip.pose(drawing, centre, row, first, arm.motion.as_ref());
    }
    Some(trace.time[last] - trace.time[first])
}

/// The rows that a strip shows: the passage of an obstacle; else two cycles of the motion, or at least its
/// last one.
fn shown(trace: &Trace, terrain: &Terrain, motion: Option<&Motion>) -> Range<usize> {
    let reaches = |x: f64| trace.base_position.iter().position(|base| base[0] >= x);
    if let Some([front, end]) = terrain.obstacle()
        && let Some(start) = reaches(front - AROUND)
    {
        let end = reaches(end + AROUND).unwrap_or(trace.time.len() - 1);
        if end > start {
            return start..end + 1;
        }
    }
    window::cycles(trace, 2, motion.map_or(0.0, |motion| motion.period).max(1.6))
}

/// The ground of an evaluation.
pub fn ground_of(arm: &Arm, stage: &str) -> Terrain {
    let spec = arm.section();
    let setting = stage.split_once('.').and_then(|(section, name)| spec.section(section)?.section(name));
    let own = setting.and_then(|setting| Ground::of_section(setting.section(Ground::SECTION)?));
    let is_first = setting.is_some_and(|setting| setting.value(Setting::policy) == Some(Trained::Learner));
    let trained = || match is_first {
        true => spec.part::<Ground>(),
        false => Section::new(&tuned(&arm.fields)).part(),
    };
    own.or_else(trained).map_or(Terrain::Flat, |ground| ground::terrain(&ground))
}

/// Whether a trace has the rows that a stick figure requires.
fn is_complete(trace: &Trace, robot: &Robot) -> bool {
    let rows = trace.time.len();
    rows > 1
        && trace.base_position.len() == rows
        && trace.base_orientation.len() == rows
        && trace.position.len() == rows
        && trace.foot_force.len() == rows
        && trace.position.iter().all(|position| position.len() == robot.joints())
}

/// Crown height of the standing robot in m.
fn tallest(robot: &Robot) -> f64 {
    robot.standing_height + crown(robot)
}

fn caption(arm: &Arm, engine: &str, seconds: f64) -> String {
    let shown = format!("over {} s of one episode (n = 1) in {engine}", written(seconds, 2));
    in_words(&shown, arm.motion.is_some())
}

/// The caption of a strip that shows this.
pub fn in_words(shown: &str, reference: bool) -> String {
    let reference = if reference { "; thin: the reference motion at the same phase" } else { "" };
    format!(
        "{POSES} moments, evenly spaced {shown}, seen from the right side and set beside each other; under \
         each figure the time and the distance travelled since the first{reference}. Marks above: foot on the \
         ground (more than {CONTACT} N)."
    )
}

/// The legend at a height in pixels.
pub fn key(drawing: &mut Drawing, y: f64, reference: bool) {
    let entry = |ink, width, text: &str| Entry { stroke: Stroke::solid(ink, width), text: text.to_string() };
    let mut entries = vec![entry(Ink::Left, 2.6, "left leg"), entry(Ink::Right, 2.6, "right leg")];
    if reference {
        entries.push(entry(Ink::Reference, 1.0, "reference motion"));
    }
    legend(drawing, [24.0, y], &entries);
}

/// The position of a figure in the strip: the world's `x` and the ground's height `rise`, both in m, are at
/// `centre` in pixels and on the ground line.
struct Place {
    centre: f64,
    x: f64,
    rise: f64,
}

struct Strip<'a> {
    robot: &'a Robot,
    trace: &'a Trace,
    terrain: Terrain,
    /// Pixels per metre.
    scale: f64,
    /// Upper edge in pixels.
    top: f64,
    /// Height of the ground in pixels.
    ground: f64,
}

impl Strip<'_> {
    fn pose(&self, drawing: &mut Drawing, centre: f64, row: usize, first: usize, motion: Option<&Motion>) {
        let base = self.trace.base_position[row];
        let rise = self.terrain.height(base[0], base[1]);
        let at = Place { centre, x: base[0], rise };
        self.uneven(drawing, &at, base[1]);
        if let Some(motion) = motion {
            let mut frame = Frame::default();
            motion.at(self.trace.phase.get(row).copied().unwrap_or(0.0), &mut frame);
            let posture = Posture {
                base_position: [base[0], 0.0, rise + frame.base_height],
                base_orientation: frame.base_orientation,
                position: &frame.position,
            };
            if frame.position.len() == self.robot.joints() {
                self.figure(drawing, &skeleton(self.robot, &posture), &at, true);
            }
        }
        let posture = Posture {
            base_position: base,
            base_orientation: self.trace.base_orientation[row],
            position: &self.trace.position[row],
        };
        self.figure(drawing, &skeleton(self.robot, &posture), &at, false);
        self.remarks(drawing, centre, row, first);
    }

    /// Draws the uneven ground under a figure, along the line of travel.
    fn uneven(&self, drawing: &mut Drawing, at: &Place, y: f64) {
        if self.terrain == Terrain::Flat {
            return;
        }
        let reach = 0.48 * SPACING / self.scale;
        let point = |index: usize| {
            let x = at.x + reach * (2.0 * index as f64 / (GROUND_POINTS - 1) as f64 - 1.0);
            self.place(at, [x, self.terrain.height(x, y)])
        };
        let points: Vec<Point> = (0..GROUND_POINTS).map(point).collect();
        drawing.line(&points, Stroke::solid(Ink::Muted, 1.0));
    }

    /// Pixels of a point of the world.
    fn place(&self, at: &Place, [x, z]: [f64; 2]) -> Point {
        [at.centre + self.scale * (x - at.x), self.ground - self.scale * (z - at.rise)]
    }

    /// Draws a stick figure.
    fn figure(&self, drawing: &mut Drawing, skeleton: &Skeleton, at: &Place, reference: bool) {
        let place = |point: &[f64; 2]| self.place(at, *point);
        let polyline = |points: &[[f64; 2]]| -> Vec<Point> { points.iter().map(place).collect() };
        let stroke = |ink, width| {
            if reference { Stroke::solid(Ink::Reference, 1.0).faint(0.8) } else { Stroke::solid(ink, width) }
        };
        drawing.line(&polyline(&skeleton.legs[0]), stroke(Ink::Left, 2.6));
        let trunk = polyline(&skeleton.trunk);
        drawing.line(&trunk, stroke(Ink::Text, 3.0));
        if !reference && let Some(crown) = trunk.last() {
            drawing.dot([crown[0], crown[1] - 7.0], 7.0, Ink::Text, 1.0);
        }
        drawing.line(&polyline(&skeleton.legs[1]), stroke(Ink::Right, 2.6));
    }

    /// Time, distance and contacts of a pose.
    fn remarks(&self, drawing: &mut Drawing, centre: f64, row: usize, first: usize) {
        let time = self.trace.time[row] - self.trace.time[first];
        let distance = self.trace.base_position[row][0] - self.trace.base_position[first][0];
        let (time, distance) = (format!("{} s", written(time, 2)), format!("{} m", written(distance, 2)));
        drawing.text([centre, self.ground + 20.0], time, Ink::Text, Anchor::Middle).size = 11.0;
        drawing.text([centre, self.ground + 35.0], distance, Ink::Muted, Anchor::Middle).size = 11.0;
        let contact = self.trace.foot_force[row].map(|force| force[2] > CONTACT);
        for (on, ink, offset) in [(contact[0], Ink::Left, -8.0), (contact[1], Ink::Right, 8.0)] {
            if on {
                let (left, top) = (centre + offset - 6.0, self.top + 20.0);
                drawing.rectangle([left, top], [left + 12.0, top + 7.0], ink, 1.0);
            }
        }
        if contact == [false, false] {
            drawing.text([centre, self.top + 28.0], "flight", Ink::Muted, Anchor::Middle).size = 11.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(count: usize, speed: f64) -> Trace {
        let time: Vec<f64> = (0..count).map(|row| row as f64 * 0.01).collect();
        let base_position = time.iter().map(|time| [speed * time, 0.0, 0.9]).collect();
        Trace { time, base_position, ..Trace::default() }
    }

    #[test]
    fn an_obstacle_is_shown_while_the_robot_passes_it() {
        let obstacle = Terrain::BoxObstacle { centre: 2.0, half_length: 0.2, half_width: 1.0, height: 0.01 };
        // At 1 m/s from 1.8 - 0.4 m to 2.2 + 0.4 m.
        let rows = shown(&trace(500, 1.0), &obstacle, None);
        assert!(rows.start.abs_diff(140) <= 1 && rows.end.abs_diff(261) <= 1, "{rows:?}");
        assert_eq!(shown(&trace(180, 1.0), &obstacle, None).end, 180, "it ends on the obstacle");
        let before = shown(&trace(500, 0.1), &obstacle, None);
        assert_eq!(before, shown(&trace(500, 0.1), &Terrain::Flat, None), "it never reaches the obstacle");
    }

    #[test]
    fn an_evaluation_has_its_own_ground_or_that_of_its_training() {
        use crate::env::tests::Recipe;
        use crate::spec::{Quantity, Table, Value};
        let mut fields = Recipe::new("tocabi", Some("walk")).fields();
        let number = |si: f64| Value::Quantity(Quantity { si, text: si.to_string() });
        let kind = Value::Text("slope".to_owned());
        let slope = [("kind", kind), ("friction", number(1.0)), ("angle", number(0.1))];
        let slope: Table = slope.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let table = |name: &str, value: Value| Value::Table(Table::from([(name.to_owned(), value)]));
        fields.insert("evaluate".into(), table("up", table("terrain", Value::Table(slope))));
        let arm = Arm { fields, ..Arm::default() };
        assert_eq!(ground_of(&arm, "evaluate.up"), Terrain::Slope { angle: 0.1 });
        assert_eq!(ground_of(&arm, "evaluate.nominal"), Terrain::Flat);
    }
}
