//! Which way a robot faces: evidence from its feet, its knees, the names of its sides and the file's own
//! frame.

use nalgebra::Vector3;

use super::legs::Legs;
use super::sole::Sole;
use crate::robot::symmetry::side_of;

/// Minimum distance of a foot's middle from the ankle, relative to foot length, to locate the toes.
const TOES: f64 = 0.05;
/// Minimum distance of a knee from the line between hip and ankle, relative to leg length, to tell which way
/// it bends.
const BENT: f64 = 0.02;
/// Minimum middle of a knee's range in rad to tell which way it bends.
const RANGE: f64 = 0.2;
/// Minimum cosine of the angle between a pitch joint and the lateral axis.
const PITCH: f64 = 0.9;

/// The evidence for facing along a direction: 1 for, -1 against, 0 undecided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Evidence {
    /// Feet extend further in front of their ankles than behind.
    pub toes: i32,
    /// The names of the bodies and joints of both sides.
    pub names: i32,
    /// Knees bend forward.
    pub knees: i32,
    /// The x axis of the file's frame.
    pub file: i32,
    /// The feet as named by the user.
    pub asked: i32,
}

impl Evidence {
    /// The facing direction; `None` if undecidable. What the user says counts only if the rest is
    /// contradictory, because a mistake in it would swap the robot's sides.
    pub fn decide(&self) -> Option<i32> {
        let weak = match (self.knees, self.file) {
            (knees, file) if knees == file || file == 0 => knees,
            (0, file) => file,
            _ => 0,
        };
        let both = if self.knees == self.file { self.file } else { 0 };
        let decided = match (self.toes, self.names) {
            (0, 0) => weak,
            (toes, 0) if both == -toes => 0,
            (toes, 0) => toes,
            (0, names) => names,
            (toes, names) if toes == names => toes,
            _ => both,
        };
        [decided, self.asked].into_iter().find(|way| *way != 0)
    }

    /// The evidence for both directions as text.
    pub fn in_words(&self) -> String {
        let kinds = [
            ("the feet", self.toes),
            ("the knees", self.knees),
            ("the names of left and right", self.names),
            ("the x axis of its frame", self.file),
        ];
        let side = |way: i32| -> Vec<&str> {
            kinds.iter().filter(|(_, vote)| *vote == way).map(|(kind, _)| *kind).collect()
        };
        match (side(1).join(" and "), side(-1).join(" and ")) {
            (ahead, behind) if ahead.is_empty() && behind.is_empty() => {
                "neither feet, knees nor names say which way is forward".to_owned()
            }
            (ahead, behind) => format!("{ahead} point one way, {behind} the other"),
        }
    }
}

/// The evidence of geometry and names for facing along `forward` (base frame, unit), with `lateral` pointing
/// from the second leg to the first one.
pub(super) fn evidence(
    legs: &Legs,
    soles: &[Option<Sole>; 2],
    forward: &Vector3<f64>,
    lateral: &Vector3<f64>,
) -> Evidence {
    Evidence {
        toes: toes(legs, soles, forward),
        names: names(legs),
        knees: knees(legs, forward, lateral),
        ..Evidence::default()
    }
}

/// The sign of a number, or 0 below the threshold.
fn sign(value: f64, clear: f64) -> i32 {
    if value > clear {
        1
    } else if value < -clear {
        -1
    } else {
        0
    }
}

fn toes(legs: &Legs, soles: &[Option<Sole>; 2], forward: &Vector3<f64>) -> i32 {
    let mut offset = 0.0;
    let mut length = 0.0;
    for (foot, sole) in legs.feet.iter().zip(soles) {
        let Some(sole) = sole else { continue };
        let pose = &legs.posed[*foot];
        let along = |centre: &Vector3<f64>| (pose.rotation * centre).dot(forward);
        let toe =
            sole.balls.iter().map(|ball| along(&ball.centre) + ball.radius).fold(f64::NEG_INFINITY, f64::max);
        let heel =
            sole.balls.iter().map(|ball| along(&ball.centre) - ball.radius).fold(f64::INFINITY, f64::min);
        offset += 0.5 * (toe + heel);
        length += toe - heel;
    }
    sign(offset, TOES * length)
}

fn knees(legs: &Legs, forward: &Vector3<f64>, lateral: &Vector3<f64>) -> i32 {
    let mut votes = 0;
    for side in 0..2 {
        let pitch = |joint: &&usize| legs.axes[**joint].dot(lateral).abs() > PITCH;
        let joints: Vec<usize> = legs.own[side].iter().filter(pitch).copied().collect();
        let [hip, knee, rest @ ..] = joints.as_slice() else { continue };
        let ankle = rest.first().copied().unwrap_or(legs.feet[side]);
        let place = |joint: usize| legs.posed[joint].translation.vector;
        let leg = place(ankle) - place(*hip);
        let bend = place(*knee) - place(*hip);
        let off = bend - leg * (bend.dot(&leg) / leg.norm_squared().max(1e-12));
        let bent = sign(off.dot(forward), BENT * leg.norm());
        let swung = || {
            // With straight legs the knee's range tells where the shank swings: backward, if the knee bends
            // forward.
            let at = |joint: usize| legs.straight[joint].translation.vector;
            let middle = legs.middle_of_range(*knee).filter(|middle| middle.abs() > RANGE)?;
            let swing = legs.axes[*knee].cross(&(at(ankle) - at(*knee))) * middle;
            Some(-sign(swing.dot(forward), 0.0))
        };
        votes += if bent != 0 { bent } else { swung().unwrap_or(0) };
    }
    votes.signum()
}

/// The evidence of names: if the first leg is the left one, `lateral` points left and the way is forward.
fn names(legs: &Legs) -> i32 {
    let votes = |side: usize| legs.names[side].iter().filter_map(|name| side_of(name)).sum::<i32>();
    match (votes(0).signum(), votes(1).signum()) {
        (1, -1) => 1,
        (-1, 1) => -1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evidence_decides_by_its_weight() {
        let all = |toes, names, knees, file, asked| Evidence { toes, names, knees, file, asked }.decide();
        // A root facing backward in an otherwise human-like robot.
        assert_eq!(all(1, 1, 1, -1, 0), Some(1));
        // Symmetric feet: the names decide, or the knees together with the file, or the file alone.
        assert_eq!(all(0, 1, -1, -1, 0), Some(1));
        assert_eq!(all(0, 0, 1, 1, 0), Some(1));
        assert_eq!(all(0, 0, 0, 1, 0), Some(1));
        assert_eq!(all(0, 0, 1, 0, 0), Some(1));
        // Contradictions that the user must settle.
        assert_eq!(all(0, 0, -1, 1, 0), None);
        assert_eq!(all(0, 0, -1, 1, 1), Some(1));
        assert_eq!(all(1, -1, 0, 0, 0), None);
        assert_eq!(all(1, -1, 0, 0, -1), Some(-1));
        assert_eq!(all(1, -1, -1, -1, 0), Some(-1));
        assert_eq!(all(1, 0, -1, -1, 0), None);
        // A mistake in --feet does not swap the sides.
        assert_eq!(all(1, 0, 1, 1, -1), Some(1));
        assert_eq!(all(0, 0, 0, 0, 0), None);
    }
}
