//! The result of an evaluation, as stored in `evaluation.json` and read by reports.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The result of running one policy for a number of episodes in one engine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Name of the engine.
    pub engine: String,
    /// Physics rate in Hz.
    pub physics_rate: f64,
    /// Control rate in Hz.
    pub control_rate: f64,
    /// Commanded forward speed in m/s; absent for tasks without a command.
    pub command: Option<f64>,
    /// Time limit of an episode in s.
    pub time_limit: f64,
    /// Where along x the obstacle begins and ends, in m from the start; absent without an obstacle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<[f64; 2]>,
    /// Time in s at which the last scheduled push of an episode begins; absent without one, and in the files of
    /// stages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub push: Option<f64>,
    /// One entry per episode.
    pub episodes: Vec<Episode>,
    /// Signals of one episode, for figures; empty if only the record of the run is left.
    #[serde(default)]
    pub trace: Trace,
}

impl Evaluation {
    /// The episodes that ended because the simulation diverged (NaN, infinity or absurd values).
    pub fn diverged(&self) -> impl Iterator<Item = &Episode> {
        self.episodes.iter().filter(|episode| episode.end == EXPLODED)
    }
}

/// The end of an episode in which the simulation diverged.
pub const EXPLODED: &str = "exploded";

/// The measurements of one episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// Name of its random stream.
    pub stream: String,
    /// Whether it reached the time limit.
    pub survived: bool,
    /// Why it ended: `time_out` or the name of a termination.
    pub end: String,
    /// Its duration in s.
    pub duration: f64,
    /// Share of the time in single support.
    pub single_support: f64,
    /// Share of the time in single support on the left foot.
    pub left_support: f64,
    /// Share of the time in single support on the right foot.
    pub right_support: f64,
    /// Share of the time in flight (no foot on the ground).
    pub flight: f64,
    /// Touch-downs of the left and the right foot (contacts shorter than 20 ms are not counted).
    pub steps: [u32; 2],
    /// Flights that begin on one foot and end on the other, at least 20 ms long.
    pub alternating_flights: u32,
    /// Share of the foot changes (a touch-down of the foot other than the last) that had such a flight.
    pub flight_per_step: f64,
    /// The same over the second half of the time limit, after the start from rest (0 if not reached).
    #[serde(default)]
    pub steady_flight_per_step: f64,
    /// Foot changes up to the last one without such a flight: the start from standing, if running follows.
    #[serde(default)]
    pub starting_steps: u32,
    /// Mean forward speed in m/s over the episode.
    pub speed: f64,
    /// Mean forward speed in m/s over the second half of the time limit (0 if not reached).
    pub steady_speed: f64,
    /// Absolute difference of mean and commanded speed in m/s.
    pub speed_error: f64,
    /// Distance travelled along x in m.
    pub distance: f64,
    /// Largest horizontal distance in m of the base from where it started; absent in records of versions that
    /// did not measure it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<f64>,
    /// Reward per second by term.
    pub reward_per_second: BTreeMap<String, f64>,
    /// Whether the base ever was beyond the far edge of the obstacle; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crossed: Option<bool>,
    /// Largest absolute torque in N m commanded to an ankle pitch joint; absent for legs without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_ankle_torque: Option<f64>,
    /// Share of control steps that end in self-collision; absent if not recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub self_collision: Option<f64>,
    /// Largest vertical force on a foot in N (8 ms mean).
    pub peak_foot_force: f64,
    /// Root mean square of the joint torques in N m, over time and joints.
    pub torque_rms: f64,
    /// Largest distance of a joint from the reference motion in rad, and of the base height in m.
    pub tracking_error: [f64; 2],
    /// Scale factors of this episode by name of the randomization: 0.7 is 70 % of the nominal value. Empty if
    /// the protocol scales nothing.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Commanded forward speed in m/s if it differs between the episodes; otherwise absent, see the
    /// evaluation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<f64>,
}

/// Signals of one episode, one row per control step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// Time in s.
    pub time: Vec<f64>,
    /// Phase of the motion cycle.
    pub phase: Vec<f64>,
    /// Base position in m.
    pub base_position: Vec<[f64; 3]>,
    /// Base orientation w x y z.
    pub base_orientation: Vec<[f64; 4]>,
    /// Joint positions in rad.
    pub position: Vec<Vec<f64>>,
    /// Commanded torques in N m.
    pub torque: Vec<Vec<f64>>,
    /// Force on the left and the right foot in N, world frame.
    pub foot_force: Vec<[[f64; 3]; 2]>,
    /// Scheduled contacts of the left and the right foot.
    pub schedule: Vec<[bool; 2]>,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Position in m of the centre of the left and the right sole; empty if the episode was randomized.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foot_position: Vec<[[f64; 3]; 2]>,
}
