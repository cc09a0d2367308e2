//! Measures one episode by accumulating its signals step by step.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::gait::Gait;
use crate::kinds::Signals;
use crate::outcome::{Episode, Trace};
use crate::robot::Kinematics;

/// Span in s over which a foot force is averaged before its peak is taken: contacts are rigid, and the force
/// of a single step is not meaningful.
const PEAK_SPAN: f64 = 0.008;

/// Measurements of one episode.
#[derive(Clone, Debug)]
pub struct Meter {
    terms: Vec<String>,
    term_sums: Vec<f64>,
    time_limit: f64,
    step: f64,
    start: [f64; 3],
    /// Forward position at the end of every control step, in m.
    forward: Vec<f64>,
    /// Largest horizontal distance from the start so far, in m.
    drift: f64,
    contacts: Vec<[bool; 2]>,
    vertical: Vec<[f64; 2]>,
    torque_squares: f64,
    torques: usize,
    command: f64,
    tracking: [f64; 2],
    /// Far edge of the obstacle along x, in m.
    far_edge: Option<f64>,
    /// The pitch joints of the ankles.
    ankles: Vec<usize>,
    ankle_torque: f64,
    soles: Option<Kinematics>,
    collisions: usize,
    trace: Option<Trace>,
}

impl Meter {
    /// A meter of an episode that starts now; with `trace`, all signals are recorded.
    pub fn new(signals: &Signals, terms: &[String], time_limit: f64, trace: Option<&[String]>) -> Self {
        Self {
            terms: terms.to_vec(),
            term_sums: vec![0.0; terms.len()],
            time_limit,
            step: signals.step,
            start: signals.base_position,
            forward: Vec::new(),
            drift: 0.0,
            contacts: Vec::new(),
            vertical: Vec::new(),
            torque_squares: 0.0,
            torques: 0,
            command: signals.command_speed,
            tracking: [0.0; 2],
            far_edge: None,
            ankles: Vec::new(),
            ankle_torque: 0.0,
            soles: None,
            collisions: 0,
            trace: trace.map(|joints| Trace { joints: joints.to_vec(), ..Trace::default() }),
        }
    }

    /// The same meter on ground with an obstacle that ends at this x in m.
    pub fn beyond(self, far_edge: Option<f64>) -> Self {
        Self { far_edge, ..self }
    }

    /// The same meter for a robot with these ankle pitch joints.
    pub fn with_ankles(self, ankles: Vec<usize>) -> Self {
        Self { ankles, ..self }
    }

    /// The same meter, with the soles' positions in the trace.
    pub fn with_soles(self, kinematics: Kinematics) -> Self {
        Self { soles: Some(kinematics), ..self }
    }

    /// Adds the state after a control step and the weighted reward terms of that step.
    pub fn add(&mut self, signals: &Signals, terms: &[f64]) {
        self.term_sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        let [x, y, _] = signals.base_position;
        self.forward.push(x);
        self.drift = self.drift.max(libm::hypot(x - self.start[0], y - self.start[1]));
        self.contacts.push(signals.foot_contact);
        self.vertical.push(signals.foot_force.map(|force| force[2]));
        self.torque_squares += signals.torque.iter().map(|torque| torque * torque).sum::<f64>();
        self.torques += signals.torque.len();
        let ankles = self.ankles.iter().map(|joint| signals.torque[*joint].abs());
        self.ankle_torque = ankles.fold(self.ankle_torque, f64::max);
        self.command = signals.command_speed;
        self.collisions += usize::from(signals.self_collision);
        let reference = signals.reference;
        let apart = signals.position.iter().zip(&reference.position).map(|(is, should)| (is - should).abs());
        self.tracking[0] = apart.fold(self.tracking[0], f64::max);
        self.tracking[1] = self.tracking[1].max((signals.base_height - reference.base_height).abs());
        if let Some(trace) = &mut self.trace {
            record(trace, signals);
            trace.foot_position.extend(self.soles.as_mut().map(|kinematics| soles(kinematics, signals)));
        }
    }

    /// The episode's results and, if recorded, its trace; `end` is why it ended.
    pub fn finish(self, stream: &str, end: &str, survived: bool) -> (Episode, Option<Trace>) {
        let duration = self.forward.len() as f64 * self.step;
        let gait = Gait::of(&self.contacts, self.step);
        let distance = self.forward.last().map_or(0.0, |last| last - self.start[0]);
        let per_second = |value: f64| if duration > 0.0 { value / duration } else { 0.0 };
        let speed = per_second(distance);
        let episode = Episode {
            stream: stream.to_owned(),
            survived,
            end: end.to_owned(),
            duration,
            single_support: gait.left_support + gait.right_support,
            left_support: gait.left_support,
            right_support: gait.right_support,
            flight: gait.flight,
            steps: gait.steps,
            alternating_flights: gait.alternating_flights,
            flight_per_step: gait.flight_per_step,
            steady_flight_per_step: Gait::of(&self.contacts[self.middle()..], self.step).flight_per_step,
            starting_steps: gait.starting_steps,
            speed,
            steady_speed: self.steady_speed(),
            speed_error: (speed - self.command).abs(),
            distance,
            drift: Some(self.drift),
            reward_per_second: self
                .terms
                .iter()
                .cloned()
                .zip(self.term_sums.iter().map(|sum| per_second(*sum)))
                .collect(),
            crossed: self.far_edge.map(|edge| self.forward.iter().any(|x| *x > edge)),
            peak_ankle_torque: (!self.ankles.is_empty()).then_some(self.ankle_torque),
            self_collision: Some(self.collisions as f64 / self.forward.len().max(1) as f64),
            peak_foot_force: self.peak_force(),
            torque_rms: libm::sqrt(self.torque_squares / self.torques.max(1) as f64),
            tracking_error: self.tracking,
            ..Episode::default()
        };
        (episode, self.trace)
    }

    /// Mean speed from the middle of the time limit to the end; 0 if the episode ended before.
    fn steady_speed(&self) -> f64 {
        let middle = self.middle();
        if middle == 0 || self.forward.len() <= middle {
            return 0.0;
        }
        let (from, to) = (self.forward[middle - 1], self.forward[self.forward.len() - 1]);
        (to - from) / ((self.forward.len() - middle) as f64 * self.step)
    }

    /// Number of control steps in the first half of the time limit, at most those of the episode.
    fn middle(&self) -> usize {
        ((self.time_limit / 2.0 / self.step).round() as usize).min(self.contacts.len())
    }

    fn peak_force(&self) -> f64 {
        let width = ((PEAK_SPAN / self.step).round() as usize).clamp(1, self.vertical.len().max(1));
        let means = self.vertical.windows(width).flat_map(|window| {
            [0, 1].map(|foot| window.iter().map(|force| force[foot]).sum::<f64>() / width as f64)
        });
        means.fold(0.0, f64::max)
    }
}

fn record(trace: &mut Trace, signals: &Signals) {
    trace.time.push(signals.time);
    trace.phase.push(signals.phase);
    trace.base_position.push(signals.base_position);
    trace.base_orientation.push(signals.base_orientation);
    trace.position.push(signals.position.to_vec());
    trace.torque.push(signals.torque.to_vec());
    trace.foot_force.push(signals.foot_force);
    trace.schedule.push(signals.reference.contact);
}

/// Positions of the soles' centres.
fn soles(kinematics: &mut Kinematics, signals: &Signals) -> [[f64; 3]; 2] {
    let [w, x, y, z] = signals.base_orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let base = Isometry3::from_parts(Translation3::from(signals.base_position), turn);
    kinematics.place(&base, signals.position);
    [0, 1].map(|side| kinematics.sole(side).translation.vector.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds::motion::Frame;

    fn signals<'a>(reference: &'a Frame, joints: &'a [f64]) -> Signals<'a> {
        Signals {
            step: 0.004,
            time: 0.0,
            standing_start: true,
            phase: 0.0,
            phase_step: 0.0,
            reference,
            command_speed: 0.5,
            base_position: [1.0, 0.0, 0.9],
            base_height: 0.9,
            stature: 1.0,
            base_orientation: [1.0, 0.0, 0.0, 0.0],
            base_velocity: [0.0; 3],
            mean_velocity: [0.0; 3],
            base_rate: [0.0; 3],
            position: joints,
            velocity: joints,
            previous_velocity: joints,
            torque: joints,
            previous_torque: joints,
            foot_force: [[0.0; 3]; 2],
            previous_foot_force: [[0.0; 3]; 2],
            foot_contact: [true, false],
            body_contact: false,
            self_collision: false,
        }
    }

    #[test]
    fn figures_are_those_computed_by_hand() {
        let reference = Frame { position: vec![0.5, 0.0], base_height: 0.85, ..Frame::default() };
        let joints = [3.0, 4.0];
        let mut now = signals(&reference, &joints);
        let names = ["a".to_owned(), "b".to_owned()];
        let mut meter = Meter::new(&now, &names, 0.8, Some(&names)).beyond(Some(1.3)).with_ankles(vec![1]);
        for step in 1..=200 {
            // 0.25 m/s in the first half, 0.75 m/s in the second.
            now.base_position[0] += if step <= 100 { 0.001 } else { 0.003 };
            // To the side and back again.
            now.base_position[1] = if step == 100 { 2.0 } else { 0.0 };
            now.foot_force[1][2] = if step == 50 { 3000.0 } else { 1000.0 };
            now.self_collision = step > 150;
            meter.add(&now, &[0.25, -0.5]);
        }
        let (episode, trace) = meter.finish("s", "time_out", true);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
        close(episode.duration, 0.8);
        close(episode.distance, 0.4);
        // 0.1 m forward and 2 m to the side.
        close(episode.drift.expect("it is measured"), libm::hypot(0.1, 2.0));
        close(episode.speed, 0.5);
        close(episode.speed_error, 0.0);
        close(episode.steady_speed, 0.75);
        close(episode.single_support, 1.0);
        close(episode.reward_per_second["a"], 62.5);
        close(episode.reward_per_second["b"], -125.0);
        // Two control steps of 4 ms: (3000 + 1000) / 2.
        close(episode.peak_foot_force, 2000.0);
        close(episode.torque_rms, libm::sqrt(12.5));
        close(episode.tracking_error[0], 4.0);
        close(episode.tracking_error[1], 0.05);
        // From 1 m it goes 0.4 m.
        assert_eq!((episode.crossed, episode.peak_ankle_torque), (Some(true), Some(4.0)));
        assert_eq!(episode.self_collision, Some(0.25));
        assert_eq!(trace.unwrap().time.len(), 200);
    }

    #[test]
    fn an_episode_that_falls_early_has_no_steady_speed() {
        let reference = Frame::default();
        let now = signals(&reference, &[]);
        let mut meter = Meter::new(&now, &[], 16.0, None);
        meter.add(&now, &[]);
        let (episode, trace) = meter.finish("s", "base_height", false);
        assert_eq!((episode.steady_speed, episode.survived, trace), (0.0, false, None));
        assert_eq!((episode.crossed, episode.peak_ankle_torque), (None, None));
    }
}
