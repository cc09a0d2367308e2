//! The motion `clip`: recorded joint angles, mapped to the robot's leg joints by function.

use nalgebra::Isometry3;

use super::fourier::Series;
use super::{Formula, Frame, MOST_ANGLE, Motion, MotionError, SAMPLES};
use crate::quantity;
use crate::robot::{Kinematics, Leg, Robot};
use crate::spec::typed::prelude::*;

kind! {
    pub struct Clip = "clip" {
        /// CSV file in the folder of the motion file: joint angles in rad and contacts.
        file: String,
        /// Duration of a cycle.
        #[range(0.1, 60.0)]
        period: Quantified<Second>,
        /// Mean forward speed of the recording.
        #[range(-10.0, 10.0)]
        speed: Quantified<MetrePerSecond>,
    }
}

/// Harmonics of the base's height, which the recording does not contain.
const HEIGHT_HARMONICS: usize = 6;

/// Columns of the file.
const COLUMNS: [&str; 14] = [
    "L_hip_yaw",
    "L_hip_roll",
    "L_hip_pitch",
    "L_knee",
    "L_ankle_pitch",
    "L_ankle_roll",
    "R_hip_yaw",
    "R_hip_roll",
    "R_hip_pitch",
    "R_knee",
    "R_ankle_pitch",
    "R_ankle_roll",
    "contact_L",
    "contact_R",
];

impl Clip {
    /// The text of the recording: not a key of motion files, but stages have it next to them.
    pub const TEXT: Key<Self, String> = Key::new("clip");
}

impl Formula for Clip {
    fn motion(&self, robot: &Robot, recording: Option<&str>) -> Result<Motion, MotionError> {
        played(self, robot, recording)
    }

    fn period(&self) -> f64 {
        self.period
    }
}

/// The recording on the robot's joints.
fn played(clip: &Clip, robot: &Robot, text: Option<&str>) -> Result<Motion, MotionError> {
    let file = &clip.file;
    let text = text.ok_or_else(|| MotionError::Clip(format!("{file} was not read")))?;
    let rows = rows(text).map_err(|flaw| MotionError::Clip(flaw.in_file(file)))?;
    let (period, speed) = (clip.period, clip.speed);
    let mut samples: Vec<Frame> = (0..SAMPLES).map(|index| still(robot, &rows, index)).collect();
    for side in 0..2 {
        let leg = Leg::of(robot, side).ok_or(MotionError::SixJoints)?;
        for (column, (joint, sign)) in leg.joints().into_iter().enumerate() {
            let knots: Vec<f64> = rows.iter().map(|row| sign * row[6 * side + column]).collect();
            let spline = Spline::through(&knots);
            let limits = &robot.links[joint].joint;
            for (index, frame) in samples.iter_mut().enumerate() {
                let [angle, rate, acceleration] = spline.at(index as f64 / SAMPLES as f64);
                frame.position[joint] = angle.clamp(limits.lower, limits.upper);
                frame.velocity[joint] = rate / period;
                frame.acceleration[joint] = acceleration / (period * period);
            }
        }
    }
    place_base(robot, period, speed, &mut samples);
    Ok(Motion { name: String::new(), period, speed, samples })
}

/// A sample at rest, with the contacts of the row at or before it.
fn still(robot: &Robot, rows: &[[f64; 14]], index: usize) -> Frame {
    let row = &rows[index * rows.len() / SAMPLES];
    Frame {
        position: robot.default_pose(),
        velocity: vec![0.0; robot.joints()],
        acceleration: vec![0.0; robot.joints()],
        base_orientation: [1.0, 0.0, 0.0, 0.0],
        contact: [row[12] > 0.5, row[13] > 0.5],
        ..Frame::default()
    }
}

/// An error in a clip's file, with its line.
#[derive(Debug)]
struct Flaw {
    line: Option<usize>,
    what: String,
}

impl Flaw {
    fn of_file(what: String) -> Self {
        Self { line: None, what }
    }

    /// `run_clip.csv:17: WHAT`
    fn in_file(&self, file: &str) -> String {
        match self.line {
            Some(line) => format!("{file}:{line}: {}", self.what),
            None => format!("{file}: {}", self.what),
        }
    }
}

/// The rows of a clip, at equal intervals of the cycle. Lines that start with `#` are comments, the first
/// other line names the columns.
fn rows(text: &str) -> Result<Vec<[f64; 14]>, Flaw> {
    let mut lines =
        text.lines().zip(1..).filter(|(line, _)| !line.starts_with('#') && !line.trim().is_empty());
    let header: Vec<&str> = lines.next().unwrap_or_default().0.split(',').map(str::trim).collect();
    let mut places = [0; 14];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        let found = header.iter().position(|name| *name == column);
        *place = found.ok_or_else(|| Flaw::of_file(format!("the column `{column}` is missing")))?;
    }
    let read = |(line, number)| row(line, &places).map_err(|what| Flaw { line: Some(number), what });
    let rows: Vec<[f64; 14]> = lines.map(read).collect::<Result<_, _>>()?;
    if rows.len() < 4 {
        return Err(Flaw::of_file(format!("{} rows are too few for a cycle", rows.len())));
    }
    if rows.iter().all(|row| row[12..].iter().all(|contact| *contact == 0.0)) {
        let what = "`contact_L` and `contact_R` are 0 in every row: a cycle needs ground contact somewhere";
        return Err(Flaw::of_file(what.to_owned()));
    }
    Ok(rows)
}

/// The numbers of a line: angles in rad within a few turns, contacts 0 or 1.
fn row(line: &str, places: &[usize; 14]) -> Result<[f64; 14], String> {
    let fields: Vec<&str> = line.split(',').collect();
    let mut row = [0.0; 14];
    for (index, (value, (place, column))) in row.iter_mut().zip(places.iter().zip(COLUMNS)).enumerate() {
        let number =
            fields.get(*place).and_then(|field| field.trim().parse::<f64>().ok()).filter(|x| x.is_finite());
        *value = number.ok_or_else(|| format!("`{column}` has no number"))?;
        let shown = quantity::number(*value);
        if index >= 12 && *value != 0.0 && *value != 1.0 {
            return Err(format!("`{column}` is {shown}, and a contact is 0 or 1"));
        }
        if value.abs() > MOST_ANGLE {
            return Err(format!(
                "`{column}` is {shown} rad, not between -{MOST_ANGLE} rad and {MOST_ANGLE} rad"
            ));
        }
    }
    Ok(row)
}

/// Sets the base's height such that the lowest corner of a foot in contact touches the ground, interpolated
/// linearly in flight; smoothed, so that it has a velocity and an acceleration.
fn place_base(robot: &Robot, period: f64, speed: f64, samples: &mut [Frame]) {
    let mut kinematics = Kinematics::new(robot);
    let mut heights: Vec<Option<f64>> = Vec::with_capacity(samples.len());
    for frame in samples.iter() {
        kinematics.place(&Isometry3::identity(), &frame.position);
        let feet = (0..2).filter(|side| frame.contact[*side]).map(|side| -kinematics.lowest_corner(side));
        heights.push(feet.reduce(f64::max));
    }
    let series = Series::fit(&bridged(&heights, robot.standing_height), HEIGHT_HARMONICS);
    for (index, frame) in samples.iter_mut().enumerate() {
        let [height, rate, acceleration] = series.at(index as f64 / SAMPLES as f64);
        frame.base_height = height;
        frame.base_velocity = [speed, 0.0, rate / period];
        frame.base_acceleration = [0.0, 0.0, acceleration / (period * period)];
    }
}

/// Fills the gaps of a periodic signal by linear interpolation; without any value it is constant.
fn bridged(values: &[Option<f64>], constant: f64) -> Vec<f64> {
    let count = values.len();
    let nearest = |index: usize, step: usize| {
        (0..count).find_map(|away| values[(index + away * step) % count].map(|value| (away as f64, value)))
    };
    let filled = (0..count).map(|index| match (nearest(index, count - 1), nearest(index, 1)) {
        (Some((0.0, value)), _) => value,
        (Some((before, low)), Some((after, high))) => (low * after + high * before) / (before + after),
        _ => constant,
    });
    filled.collect()
}

/// The periodic cubic spline through equally spaced knots over a phase in `[0, 1)`: twice continuously
/// differentiable.
struct Spline {
    knots: Vec<f64>,
    /// Second derivatives at the knots, for a knot spacing of one.
    curvatures: Vec<f64>,
}

impl Spline {
    fn through(knots: &[f64]) -> Self {
        let count = knots.len();
        let mut curvatures = vec![0.0; count];
        // The equations `m[i-1] + 4 m[i] + m[i+1] = 6 (y[i-1] - 2 y[i] + y[i+1])` are diagonally dominant:
        // each Gauss-Seidel sweep halves the error at least.
        for _ in 0..80 {
            for index in 0..count {
                let (before, after) = ((index + count - 1) % count, (index + 1) % count);
                let bend = knots[before] - 2.0 * knots[index] + knots[after];
                curvatures[index] = (6.0 * bend - curvatures[before] - curvatures[after]) / 4.0;
            }
        }
        Self { knots: knots.to_vec(), curvatures }
    }

    /// The value and its first and second derivative with respect to the phase.
    fn at(&self, phase: f64) -> [f64; 3] {
        let count = self.knots.len();
        let place = phase * count as f64;
        let index = (place as usize).min(count - 1);
        let (right, after) = (place - index as f64, (index + 1) % count);
        let left = 1.0 - right;
        let (low, high) = (self.knots[index], self.knots[after]);
        let (bend_low, bend_high) = (self.curvatures[index], self.curvatures[after]);
        let value = left * low
            + right * high
            + ((left * left * left - left) * bend_low + (right * right * right - right) * bend_high) / 6.0;
        let slope = high - low
            + ((3.0 * right * right - 1.0) * bend_high - (3.0 * left * left - 1.0) * bend_low) / 6.0;
        let curvature = left * bend_low + right * bend_high;
        [value, slope * count as f64, curvature * (count * count) as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_follows_a_sine_and_its_derivatives() {
        let knots: Vec<f64> = (0..24).map(|i| libm::sin(std::f64::consts::TAU * i as f64 / 24.0)).collect();
        let spline = Spline::through(&knots);
        let phase = 0.135;
        let tau = std::f64::consts::TAU;
        let [value, slope, curvature] = spline.at(phase);
        assert!((value - libm::sin(tau * phase)).abs() < 1e-4);
        assert!((slope - tau * libm::cos(tau * phase)).abs() < 1e-2);
        assert!((curvature + tau * tau * libm::sin(tau * phase)).abs() < 0.5);
        assert!((spline.at(3.0 / 24.0)[0] - knots[3]).abs() < 1e-15);
    }

    #[test]
    fn gaps_are_bridged_across_the_end_of_the_cycle() {
        let values = [None, Some(1.0), Some(2.0), None, None];
        let bridged = bridged(&values, 0.0);
        // The gap from index 2 (value 2) to index 1 of the next cycle (value 1) has four steps.
        let expected = [1.25, 1.0, 2.0, 1.75, 1.5];
        assert!(bridged.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{bridged:?}");
    }

    #[test]
    fn a_clip_without_a_column_or_a_number_is_refused_by_name() {
        let header = COLUMNS.join(",");
        let error = |text: &str| rows(text).unwrap_err().in_file("a.csv");
        assert!(error(&header.replace("L_knee", "knee")).contains("`L_knee`"));
        assert_eq!(
            error(&format!("# mine\n{header}\n{}x", "0,".repeat(13))),
            "a.csv:3: `contact_R` has no number"
        );
        assert!(error(&header).contains("0 rows"));
    }

    #[test]
    fn numbers_that_are_no_angles_or_contacts_are_refused_with_their_line() {
        let header = COLUMNS.join(",");
        let row = |knee: &str, contact: &str| format!("0,0,0,{knee},0,0,0,0,0,0,0,0,0,{contact}\n");
        let error = |rows_of: &str| rows(&format!("{header}\n{rows_of}")).unwrap_err().in_file("a.csv");
        let good = row("0.5", "1").repeat(4);
        assert!(rows(&format!("{header}\n{good}")).is_ok());
        let far = error(&format!("{good}{}", row("1e308", "1")));
        assert_eq!(far, "a.csv:6: `L_knee` is 1e308 rad, not between -20 rad and 20 rad");
        for knee in ["inf", "nan", ""] {
            assert_eq!(error(&format!("{good}{}", row(knee, "1"))), "a.csv:6: `L_knee` has no number");
        }
        let half = error(&format!("{}{good}", row("0", "0.5")));
        assert_eq!(half, "a.csv:2: `contact_R` is 0.5, and a contact is 0 or 1");
        assert!(error(&row("0.5", "0").repeat(4)).contains("0 in every row"));
    }
}
