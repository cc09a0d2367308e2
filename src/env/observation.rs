//! The policy's inputs: their layout, normalisation and mirroring. Used by training, pre-training,
//! evaluation, export and transfer.

use crate::kinds::learn::Ppo;
use crate::kinds::learn::ppo::Symmetry;
use crate::kinds::observe::Observations;
use crate::kinds::observe::{Input, KINDS, Readings, Subject};
use crate::kinds::task::Task;
use crate::robot::Robot;
use crate::spec::{Section, Table};

/// The compiled `[observe]` section for one robot.
///
/// With `learn.symmetry = "phase_mirror"`, readings with a phase of 1/2 or more are mirrored at the plane y =
/// 0: roll and yaw change sign, left and right joints are exchanged, and the observed phase is phase - 1/2.
/// Actions for such readings are mirrored back by [`Observation::reflect`].
#[derive(Clone, Debug)]
pub struct Observation {
    inputs: Vec<Input>,
    places: Vec<Place>,
    mirror: Vec<(usize, f64)>,
    mirrored: bool,
}

/// Source of a number in the vector.
#[derive(Clone, Copy, Debug)]
struct Place {
    read: fn(&Readings, usize) -> f64,
    index: usize,
    offset: f64,
    scale: f64,
    clip: f64,
}

impl Observation {
    /// The layout of decoded fields: reads `observe`, `task.command.speed` and `learn.symmetry`.
    pub fn new(fields: &Table, robot: &Robot) -> Self {
        let fields = Section::new(fields);
        let subject = Subject { robot, command: commands(fields) };
        let mut inputs = Vec::new();
        let mut places = Vec::new();
        for entry in KINDS {
            let terms = fields.within::<Observations>().into_iter().flat_map(|section| section.sections());
            for (_, term) in terms.filter(|(name, term)| term.kind().unwrap_or(name) == entry.kind.name) {
                for (index, input) in (entry.inputs)(term, &subject).into_iter().enumerate() {
                    let Input { offset, scale, clip, .. } = input;
                    places.push(Place { read: entry.read, index, offset, scale, clip });
                    inputs.push(input);
                }
            }
        }
        let mirrored = is_mirrored(fields);
        Self { inputs, places, mirror: robot.mirror.clone(), mirrored }
    }

    /// The inputs in order.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// Number of inputs.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether the policy has no inputs.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether readings at this phase are mirrored.
    pub fn reflects(&self, phase: f64) -> bool {
        self.mirrored && phase >= 0.5
    }

    /// Whether the layout mirrors the second half of the cycle.
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Writes the normalised inputs for readings as measured (`mirror: None`).
    pub fn write(&self, readings: &Readings, vector: &mut [f32]) {
        let mut seen = *readings;
        if self.reflects(readings.phase) {
            let [roll, pitch, yaw] = readings.attitude;
            seen.attitude = [-roll, pitch, -yaw];
            seen.phase = readings.phase - 0.5;
            seen.mirror = Some(&self.mirror);
        }
        for (place, number) in self.places.iter().zip(vector) {
            let raw = (place.read)(&seen, place.index);
            *number = normalised(raw, place.offset, place.scale, place.clip);
        }
    }

    /// Mirrors an action for a mirrored observation back to the robot's own sides, in place; the same call
    /// mirrors a robot's action. Numbers after the joints (the phase action) are unchanged.
    pub fn reflect<T: Copy + std::ops::Mul<Output = T> + From<f32>>(&self, action: &mut [T]) {
        for (joint, &(image, sign)) in self.mirror.iter().enumerate() {
            let sign = T::from(sign as f32);
            if image == joint {
                action[joint] = sign * action[joint];
            } else if image > joint {
                let back = T::from(self.mirror[image].1 as f32);
                (action[joint], action[image]) = (sign * action[image], back * action[joint]);
            }
        }
    }
}

/// A normalised input; a number that is not finite becomes zero.
pub(super) fn normalised(raw: f64, offset: f64, scale: f64, clip: f64) -> f32 {
    let number = ((raw - offset) / scale).clamp(-clip, clip);
    if number.is_finite() { number as f32 } else { 0.0 }
}

/// Range of the commanded speed in m/s.
fn commands(fields: Section) -> [f64; 2] {
    Task::commanded(fields).map_or([0.0; 2], |command| command.speed.bounds())
}

/// Whether `learn.symmetry` is `phase_mirror`.
pub(super) fn is_mirrored(fields: Section) -> bool {
    fields.at(Ppo::symmetry) == Some(Symmetry::PhaseMirror)
}
