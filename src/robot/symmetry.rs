//! The mirror map of a robot (reflection in the x-z plane), and its standing height: what follows from
//! the model's geometry and is not written in its file.

use nalgebra::{Isometry3, Vector3};

use super::kinematics::Kinematics;
use super::model::Robot;

/// Distance in m, and length of the difference of unit axes, up to which joints count as mirror images.
const TOLERANCE: f64 = 2e-3;

/// A joint without a mirror image.
#[derive(Clone, Debug, PartialEq)]
pub struct Unpaired {
    /// Its name.
    pub joint: String,
    /// The joint that is its counterpart by name, and how far in m that one is from the image.
    pub nearest: Option<(String, f64)>,
}

/// Mirror images of all joints: index and sign of the coordinate. A reflection turns a rotation about
/// `(x, y, z)` into one about `(-x, y, -z)`, so with like axes on both sides yaw and roll change sign and
/// pitch keeps it. Where several joints share a place and an axis, the one that is called like the image
/// (`left_hip`, `right_hip`) is taken.
pub fn mirror_map(robot: &Robot) -> Result<Vec<(usize, f64)>, Unpaired> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let name = |index: usize| robot.links[index].joint.name.as_str();
    let reflected = |index: usize| {
        let position = kinematics.pose(index).translation.vector;
        Vector3::new(position.x, -position.y, position.z)
    };
    let image = |index: usize| {
        let (position, axis) = (reflected(index), kinematics.axis(index));
        let axis = Vector3::new(-axis.x, axis.y, -axis.z);
        let matching = (0..robot.joints()).filter_map(|other| {
            let apart = (kinematics.pose(other).translation.vector - position).norm();
            let along = kinematics.axis(other).dot(&axis);
            (apart < TOLERANCE && (axis * along.signum() - kinematics.axis(other)).norm() < TOLERANCE)
                .then_some((other, along.signum()))
        });
        let matching: Vec<(usize, f64)> = matching.collect();
        let called = counterpart(name(index));
        matching.iter().find(|(other, _)| name(*other) == called).or(matching.first()).copied()
    };
    let unpaired = |index: usize| {
        let called = counterpart(name(index));
        let other = (0..robot.joints()).find(|other| name(*other) == called);
        let apart = |other: usize| (kinematics.pose(other).translation.vector - reflected(index)).norm();
        Unpaired { joint: name(index).to_owned(), nearest: other.map(|other| (called.clone(), apart(other))) }
    };
    let map: Vec<(usize, f64)> =
        (0..robot.joints()).map(|index| image(index).ok_or_else(|| unpaired(index))).collect::<Result<_, _>>()?;
    match (0..map.len()).find(|&index| map[map[index].0] != (index, map[index].1)) {
        Some(index) => Err(unpaired(index)),
        None => Ok(map),
    }
}

/// The name with left and right exchanged: `left_hip` is `right_hip`, `L_Knee` is `R_Knee`, `waist` is `waist`.
pub fn counterpart(name: &str) -> String {
    for (left, right) in [("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT")] {
        for (from, to) in [(left, right), (right, left)] {
            if name.contains(from) {
                return name.replacen(from, to, 1);
            }
        }
    }
    let exchanged = |word: &str| {
        Some(match word {
            "l" => "r",
            "r" => "l",
            "L" => "R",
            "R" => "L",
            _ => return None,
        })
    };
    let mut exchange = true;
    let words = name.split_inclusive(['_', '-', '.', ' ']).map(|piece| {
        let (word, mark) = piece.split_at(piece.trim_end_matches(['_', '-', '.', ' ']).len());
        match exchanged(word).filter(|_| exchange) {
            Some(other) => {
                exchange = false;
                format!("{other}{mark}")
            }
            None => piece.to_owned(),
        }
    });
    words.collect()
}

/// A joint's image as a robot file writes it: `-right_hip`.
pub fn written(robot: &Robot, (image, sign): (usize, f64)) -> String {
    format!("{}{}", if sign < 0.0 { "-" } else { "" }, robot.links[image].joint.name)
}

/// Whether mirroring twice is the identity.
pub fn is_involution(mirror: &[(usize, f64)]) -> bool {
    mirror.iter().enumerate().all(|(index, &(image, sign))| mirror.get(image) == Some(&(index, sign)))
}

/// A joint vector's mirror image.
pub fn mirrored(mirror: &[(usize, f64)], vector: &[f64]) -> Vec<f64> {
    mirror.iter().map(|&(image, sign)| sign * vector[image]).collect()
}

/// Height in m of the base origin above flat ground on which the lower sole stands in the default
/// pose, base upright.
pub fn standing_height(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    -(0..2).map(|side| kinematics.sole(side).translation.z).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{names, tests::robot};

    #[test]
    fn left_and_right_are_exchanged_in_names_of_every_habit() {
        for (name, other) in [
            ("left_hip_yaw_joint", "right_hip_yaw_joint"),
            ("RIGHT_KNEE", "LEFT_KNEE"),
            ("LeftAnkle", "RightAnkle"),
            ("L_Knee_Joint", "R_Knee_Joint"),
            ("r_leg_kny", "l_leg_kny"),
            ("shoulder.L", "shoulder.R"),
            ("waist_yaw", "waist_yaw"),
        ] {
            assert_eq!(counterpart(name), other);
            assert_eq!(counterpart(other), name);
        }
    }

    #[test]
    fn geometry_and_names_agree_on_the_shipped_robots() {
        for name in names() {
            let robot = robot(name);
            for (index, (image, _)) in robot.mirror.iter().enumerate() {
                let joint = |index: usize| robot.links[index].joint.name.as_str();
                assert_eq!(counterpart(joint(index)), joint(*image), "{name}");
            }
        }
    }

    #[test]
    fn joints_on_one_axis_are_told_apart_by_their_names() {
        let mut robot = robot("tocabi");
        // A second yaw joint in the place of the first one, on both sides: geometry alone cannot pair them.
        for side in [0, 6] {
            robot.links[side + 1].joint.axis = robot.links[side].joint.axis;
            robot.links[side + 1].joint.origin = Isometry3::identity();
        }
        let map = mirror_map(&robot).unwrap();
        assert_eq!([map[0].0, map[1].0, map[6].0, map[7].0], [6, 7, 0, 1]);
    }

    #[test]
    fn a_joint_without_an_image_names_its_counterpart() {
        let mut robot = robot("tocabi");
        robot.links[0].joint.origin.translation.vector.y += 0.1;
        let unpaired = mirror_map(&robot).unwrap_err();
        let (other, apart) = unpaired.nearest.unwrap();
        assert_eq!((unpaired.joint.as_str(), other.as_str()), ("L_HipYaw_Joint", "R_HipYaw_Joint"));
        assert!((apart - 0.1).abs() < 1e-9);
    }
}
