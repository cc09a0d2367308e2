//! Reference motions: `specs/motions/NAME.toml` together with a robot gives a [`Motion`].

pub mod clip;
mod fourier;
mod gait;
pub mod run_gait;
pub mod squat;
pub mod walk;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::diag::{Sink, SourceId, Sources};
use crate::quantity;
use crate::robot::{Robot, leg_length, legs};
use crate::spec::typed::Declared;
use crate::spec::{Decoded, Kind, Section, decode};

/// Samples of a cycle; divisible by 24, so that contact schedules in twelfths and clips of 24 frames coincide
/// with samples.
pub const SAMPLES: usize = 720;

/// The keys of a motion file, which define the motion of a robot.
pub trait Formula {
    /// The motion for a robot; `recording` is the text of a clip's CSV file.
    fn motion(&self, robot: &Robot, recording: Option<&str>) -> Result<Motion, MotionError>;

    /// Duration of a cycle in s, which is that of the motion of any robot.
    fn period(&self) -> f64;
}

/// The section that holds the keys of a motion file in a stage.
pub const SECTION: &str = "motion";

/// An entry of the motion registry.
pub struct MotionKind {
    /// Its descriptor.
    pub kind: &'static Kind,
    /// Builds the motion for a robot from the decoded motion file and, for a clip, the text of its CSV file.
    pub build: fn(Section, &Robot, Option<&str>) -> Result<Motion, MotionError>,
    /// Reads the duration of a cycle in s; `None` if a key is missing.
    period: fn(Section) -> Option<f64>,
}

impl MotionKind {
    const fn of<File: Declared + Formula>() -> Self {
        Self {
            kind: File::KIND,
            build: |section, robot, recording| section.read::<File>().motion(robot, recording),
            period: |section| Some(File::of_table(section.table())?.period()),
        }
    }
}

/// Every motion kind, sorted by name.
pub static KINDS: &[&MotionKind] = &[
    &MotionKind::of::<clip::Clip>(),
    &MotionKind::of::<run_gait::RunGait>(),
    &MotionKind::of::<squat::Squat>(),
    &MotionKind::of::<walk::Walk>(),
];

/// Their descriptors.
pub fn kinds() -> Vec<&'static Kind> {
    KINDS.iter().map(|entry| entry.kind).collect()
}

/// Largest difference in rad up to which a motion counts as its own mirror image.
pub const MIRROR_TOLERANCE: f64 = 1e-3;

/// Why a motion does not fit a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// The file's kind is not in the registry.
    #[error("unknown motion kind `{0}`")]
    UnknownKind(String),
    /// The legs do not have the structure that the motion needs.
    #[error("the motion needs legs with three pitch joints, hip, knee and \
        ankle{}", oblique_in_words(oblique.as_ref()))]
    Legs {
        /// The leg joint whose axis is not parallel to an axis of the base, and the angle in rad to the
        /// nearest one.
        oblique: Option<(String, f64)>,
    },
    /// The legs do not have the structure of the recording.
    #[error("a clip needs legs with one yaw, two roll and three pitch joints")]
    SixJoints,
    /// A foot's position is out of the leg's reach.
    #[error("the foot's place at phase {phase:.3} is out of reach by {:.2} mm", 1e3 * residual)]
    OutOfReach {
        /// Phase of the motion.
        phase: f64,
        /// The remaining error, m and rad together.
        residual: f64,
    },
    /// A joint would exceed its limits.
    #[error("joint `{joint}` would be at {position:.3} rad at phase {phase:.3}, outside its limits")]
    OutsideLimits {
        /// The joint's name.
        joint: String,
        /// Its position in rad.
        position: f64,
        /// Phase of the motion.
        phase: f64,
    },
    /// The clip's file is invalid: location and reason.
    #[error("{0}")]
    Clip(String),
    /// The motion has a value that no robot can follow.
    #[error("{0}")]
    Values(String),
}

impl MotionError {
    /// The error for legs without the structure that the motion needs.
    fn legs(robot: &Robot) -> Self {
        Self::Legs { oblique: legs::oblique(robot) }
    }
}

/// Describes a joint with an oblique axis, as the end of a sentence.
fn oblique_in_words(oblique: Option<&(String, f64)>) -> String {
    oblique.map_or_else(String::new, |(joint, angle)| {
        format!(
            ", and joint `{joint}` is {:.0} deg off every axis of the base with all joints at zero",
            angle.to_degrees()
        )
    })
}

/// The motion that a decoded motion file (a table with its `kind`) describes for a robot; `clip` is the text
/// of a clip's CSV file.
pub fn build(name: &str, file: Section, robot: &Robot, clip: Option<&str>) -> Result<Motion, MotionError> {
    let kind = file.kind().unwrap_or_default();
    let entry = KINDS.iter().find(|entry| entry.kind.name == kind);
    let entry = entry.ok_or_else(|| MotionError::UnknownKind(kind.to_owned()))?;
    let motion = (entry.build)(file, robot, clip)?;
    motion.check().map_err(MotionError::Values)?;
    Ok(Motion { name: name.to_owned(), ..motion })
}

/// Duration in s of a cycle of a decoded motion file; `None` if its kind is unknown or a key is missing.
pub fn period(file: Section) -> Option<f64> {
    let kind = file.kind()?;
    (KINDS.iter().find(|entry| entry.kind.name == kind)?.period)(file)
}

/// Reads a motion file, whose text is in the sources. `None` after an error, which is then in the sink.
pub fn load(sources: &Sources, source: SourceId, sink: &mut Sink) -> Option<Decoded> {
    decode::document_of_kind(sources, source, &kinds(), sink)
}

/// A motion included with specforge, for a robot; `None` if the name is unknown.
pub fn shipped(name: &str, robot: &Robot) -> Option<Result<Motion, MotionError>> {
    let file = format!("{name}.toml");
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let source = sources.add(format!("specs/motions/{file}"), embedded(&file)?);
    let decoded = load(&sources, source, &mut sink)?;
    let section = Section::new(&decoded.table);
    Some(build(name, section, robot, section.value(clip::Clip::file).as_deref().and_then(embedded)))
}

/// Factor from the lengths of a motion file, which refer to this leg length in m, to the robot's.
fn scale(reference_leg_length: f64, robot: &Robot) -> Result<f64, MotionError> {
    Ok(leg_length(robot).ok_or_else(|| MotionError::legs(robot))? / reference_leg_length)
}

/// The files included with specforge, by name within `specs/motions/`.
static EMBEDDED: [(&str, &str); 7] = [
    ("run_clip.csv", include_str!("../../../specs/motions/run_clip.csv")),
    ("run_clip.toml", include_str!("../../../specs/motions/run_clip.toml")),
    ("run_gait.toml", include_str!("../../../specs/motions/run_gait.toml")),
    ("run_gait_short_flight.toml", include_str!("../../../specs/motions/run_gait_short_flight.toml")),
    ("squat.toml", include_str!("../../../specs/motions/squat.toml")),
    ("walk.toml", include_str!("../../../specs/motions/walk.toml")),
    ("walk_g1.toml", include_str!("../../../specs/motions/walk_g1.toml")),
];

/// The text of a file of `specs/motions/` included with specforge.
pub fn embedded(file: &str) -> Option<&'static str> {
    EMBEDDED.iter().find(|(known, _)| *known == file).map(|(_, text)| *text)
}

/// The names of the motions included with specforge, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().filter_map(|(file, _)| file.strip_suffix(".toml"))
}

/// A periodic reference motion of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Its name.
    pub name: String,
    /// Duration of a cycle in s.
    pub period: f64,
    /// Mean forward speed in m/s.
    pub speed: f64,
    /// Samples at phases `i / samples.len()`.
    pub samples: Vec<Frame>,
}

/// A reference motion at one phase. Joint vectors are in joint order, feet are left, right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Joint positions in rad.
    pub position: Vec<f64>,
    /// Joint velocities in rad/s at the nominal cadence.
    pub velocity: Vec<f64>,
    /// Joint accelerations in rad/s^2 at the nominal cadence.
    pub acceleration: Vec<f64>,
    /// Height of the base origin above flat ground in m.
    pub base_height: f64,
    /// Orientation of the base, unit quaternion w x y z.
    pub base_orientation: [f64; 4],
    /// Velocity of the base origin in m/s, heading frame.
    pub base_velocity: [f64; 3],
    /// Angular velocity of the base in rad/s, heading frame.
    pub base_rate: [f64; 3],
    /// Acceleration of the base origin in m/s^2, heading frame.
    pub base_acceleration: [f64; 3],
    /// Scheduled contact of each foot.
    pub contact: [bool; 2],
}

/// Largest joint position in rad: a few turns.
pub const MOST_ANGLE: f64 = 20.0;
/// Largest forward speed in m/s.
const MOST_SPEED: f64 = 10.0;
/// Duration of a cycle in s, shortest and longest.
const PERIODS: [f64; 2] = [0.05, 600.0];
/// Largest distance of the base from the ground in m.
const MOST_HEIGHT: f64 = 20.0;
/// Largest velocity of a joint or the base, in rad/s or m/s.
const MOST_RATE: f64 = 1e4;
/// Largest acceleration of a joint or the base, in rad/s^2 or m/s^2.
const MOST_ACCELERATION: f64 = 1e7;

impl Motion {
    /// Checks that its values are within wide bounds that no robot reaches; the error names the first that is
    /// not.
    pub fn check(&self) -> Result<(), String> {
        let within = |what: &str, value: f64, low: f64, high: f64| match (low..=high).contains(&value) {
            true => Ok(()),
            false => Err(format!(
                "its {what} is {}, not between {} and {}",
                quantity::number(value),
                quantity::number(low),
                quantity::number(high)
            )),
        };
        within("period in s", self.period, PERIODS[0], PERIODS[1])?;
        within("speed in m/s", self.speed, -MOST_SPEED, MOST_SPEED)?;
        if self.samples.is_empty() {
            return Err("it has no samples".to_owned());
        }
        let all = |what: &str, values: &[f64], most: f64| {
            values.iter().try_for_each(|value| within(what, *value, -most, most))
        };
        for frame in &self.samples {
            all("joint position in rad", &frame.position, MOST_ANGLE)?;
            all("joint velocity in rad/s", &frame.velocity, MOST_RATE)?;
            all("joint acceleration in rad/s^2", &frame.acceleration, MOST_ACCELERATION)?;
            all("base height in m", &[frame.base_height], MOST_HEIGHT)?;
            all("base velocity in m/s", &frame.base_velocity, MOST_RATE)?;
            all("base rate in rad/s", &frame.base_rate, MOST_RATE)?;
            all("base acceleration in m/s^2", &frame.base_acceleration, MOST_ACCELERATION)?;
            let norm = frame.base_orientation.iter().map(|x| x * x).sum();
            within("norm of a base orientation", libm::sqrt(norm), 0.99, 1.01)?;
        }
        Ok(())
    }

    /// Largest difference in rad between a joint and its mirror image half a cycle later. `mirror` has the index
    /// and the sign of each joint's image; every sample must have as many joints.
    pub fn asymmetry(&self, mirror: &[(usize, f64)]) -> f64 {
        let mut later = Frame::default();
        let mut largest: f64 = 0.0;
        for (index, frame) in self.samples.iter().enumerate() {
            self.at(index as f64 / self.samples.len() as f64 + 0.5, &mut later);
            for (joint, &(image, sign)) in mirror.iter().enumerate() {
                largest = largest.max((frame.position[joint] - sign * later.position[image]).abs());
            }
        }
        largest
    }

    /// Writes the reference at a phase into `frame`, interpolated linearly between samples; the contacts are
    /// those of the sample at or before the phase. Allocates only when `frame` is empty.
    pub fn at(&self, phase: f64, frame: &mut Frame) {
        self.state_at(phase, frame);
        let between = self.between(phase);
        between.mix_all(|frame| &frame.acceleration, &mut frame.acceleration);
        frame.base_acceleration = between.mix(|frame| frame.base_acceleration);
    }

    /// As [`Motion::at`] without accelerations, which stay unchanged: what an environment needs in every
    /// control step.
    pub fn state_at(&self, phase: f64, frame: &mut Frame) {
        let between = self.between(phase);
        between.mix_all(|frame| &frame.position, &mut frame.position);
        between.mix_all(|frame| &frame.velocity, &mut frame.velocity);
        frame.base_height = between.mix(|frame| [frame.base_height])[0];
        frame.base_velocity = between.mix(|frame| frame.base_velocity);
        frame.base_rate = between.mix(|frame| frame.base_rate);
        let mut orientation = between.mix(|frame| frame.base_orientation);
        let norm = libm::sqrt(orientation.iter().map(|x| x * x).sum());
        orientation.iter_mut().for_each(|x| *x /= norm);
        frame.base_orientation = orientation;
        frame.contact = between.low.contact;
    }

    /// Writes only the joint velocities in rad/s at a phase.
    pub fn velocity_at(&self, phase: f64, velocity: &mut Vec<f64>) {
        self.between(phase).mix_all(|frame| &frame.velocity, velocity);
    }

    fn between(&self, phase: f64) -> Between<'_> {
        let count = self.samples.len();
        let place = (phase - libm::floor(phase)) * count as f64;
        let index = (place as usize).min(count - 1);
        Between {
            low: &self.samples[index],
            high: &self.samples[(index + 1) % count],
            share: place - index as f64,
        }
    }
}

/// A position between two samples.
struct Between<'a> {
    low: &'a Frame,
    high: &'a Frame,
    /// Share of the way from `low` to `high`.
    share: f64,
}

impl Between<'_> {
    fn mix<const N: usize>(&self, of: impl Fn(&Frame) -> [f64; N]) -> [f64; N] {
        let (low, high) = (of(self.low), of(self.high));
        std::array::from_fn(|index| low[index] + self.share * (high[index] - low[index]))
    }

    fn mix_all(&self, of: impl Fn(&Frame) -> &Vec<f64>, out: &mut Vec<f64>) {
        out.clear();
        out.extend(of(self.low).iter().zip(of(self.high)).map(|(low, high)| low + self.share * (high - low)));
    }
}
