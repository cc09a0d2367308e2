//! The mirror map of a robot (reflection in the x-z plane) and its standing height, which follow from the
//! model's geometry and are not in its file.

use nalgebra::{Isometry3, Vector3};

use super::kinematics::Kinematics;
use super::legs;
use super::model::Robot;

/// Tolerance for mirrored joints: distance in m between axes as lines, and length of the difference of unit
/// axes.
pub const TOLERANCE: f64 = 2e-3;

/// A joint without a mirror image.
#[derive(Clone, Debug, PartialEq)]
pub struct Unpaired {
    /// Its name.
    pub joint: String,
    /// The closest candidate: its counterpart by name.
    pub nearest: Option<Nearest>,
}

/// A joint that should be a mirror image but is not.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Its name.
    pub joint: String,
    /// Distance in m between its axis, as a line, and that of the image.
    pub apart: f64,
    /// Angle in rad between both axes.
    pub angle: f64,
}

impl Nearest {
    /// How it differs from the image: a clause.
    pub fn in_words(&self) -> String {
        let Self { joint, apart, angle } = self;
        match (*apart >= TOLERANCE, *angle >= TOLERANCE) {
            (_, true) => format!("the axis of `{joint}` is {:.1} deg off the image", angle.to_degrees()),
            (true, false) => format!("the axis of `{joint}` is {:.1} mm off the image", 1e3 * apart),
            (false, false) => format!("`{joint}` hangs on another body than the image"),
        }
    }
}

/// The axis of a joint as a line: the position of a joint's origin along its axis does not affect the robot.
#[derive(Clone, Copy, Debug)]
struct Line {
    point: Vector3<f64>,
    axis: Vector3<f64>,
}

impl Line {
    /// The image in the x-z plane. A reflection turns a rotation about `(x, y, z)` into one about
    /// `(-x, y, -z)`.
    fn image(&self) -> Self {
        let Self { point, axis } = self;
        Self { point: Vector3::new(point.x, -point.y, point.z), axis: Vector3::new(-axis.x, axis.y, -axis.z) }
    }

    /// Distance in m of another line's point from this line.
    fn apart(&self, other: &Self) -> f64 {
        let way = other.point - self.point;
        (way - self.axis * way.dot(&self.axis)).norm()
    }

    /// The relative sign of two lines, if they are the same.
    fn same(&self, other: &Self) -> Option<f64> {
        let sign = self.axis.dot(&other.axis).signum();
        (self.apart(other) < TOLERANCE && (self.axis * sign - other.axis).norm() < TOLERANCE).then_some(sign)
    }

    /// Angle in rad between both lines, regardless of direction.
    fn angle(&self, other: &Self) -> f64 {
        libm::atan2(self.axis.cross(&other.axis).norm(), self.axis.dot(&other.axis).abs())
    }
}

/// Mirror images of all joints: index and sign of the coordinate. If both sides have the same axes, yaw and
/// roll change sign and pitch does not.
///
/// Joints are compared as lines. The parent of a joint's image is the image of its parent, and the image of a
/// leg's joint belongs to the other leg. Of several candidates, the one named like the image (`left_hip`,
/// `right_hip`) is used, or else the one with the nearest origin.
pub fn mirror_map(robot: &Robot) -> Result<Vec<(usize, f64)>, Unpaired> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let legs = [0, 1].map(|side| legs::own(&kinematics, side));
    let side_of = |joint: usize| legs.iter().position(|leg| leg.contains(&joint));
    let lines: Vec<Line> = (0..robot.joints())
        .map(|joint| Line { point: kinematics.pose(joint).translation.vector, axis: *kinematics.axis(joint) })
        .collect();
    let name = |index: usize| robot.links[index].joint.name.as_str();
    let unpaired = |index: usize| {
        let called = counterpart(name(index));
        let image = lines[index].image();
        let other = (0..robot.joints()).find(|other| name(*other) == called);
        let nearest = other.map(|other| Nearest {
            joint: called.clone(),
            apart: lines[other].apart(&image),
            angle: lines[other].angle(&image),
        });
        Unpaired { joint: name(index).to_owned(), nearest }
    };
    let mut map: Vec<(usize, f64)> = Vec::with_capacity(robot.joints());
    for index in 0..robot.joints() {
        let image = lines[index].image();
        let parent = robot.links[index].parent.map(|parent| map[parent].0);
        let across = side_of(index).map(|side| 1 - side);
        let matching: Vec<(usize, f64)> = (0..robot.joints())
            .filter(|other| robot.links[*other].parent == parent && side_of(*other) == across)
            .filter_map(|other| Some((other, lines[other].same(&image)?)))
            .collect();
        let called = counterpart(name(index));
        let away = |other: usize| (lines[other].point - image.point).norm();
        let nearest = || matching.iter().min_by(|a, b| away(a.0).total_cmp(&away(b.0)));
        let found = matching.iter().find(|(other, _)| name(*other) == called).or_else(nearest).copied();
        map.push(found.ok_or_else(|| unpaired(index))?);
    }
    match (0..map.len()).find(|&index| map[map[index].0] != (index, map[index].1)) {
        Some(index) => Err(unpaired(index)),
        None => Ok(map),
    }
}

/// Left (1) or right (-1), if a name contains it: `left_foot`, `LeftFoot`, `l_foot`, `LAnklePitch`, `foot.R`.
pub fn side_of(name: &str) -> Option<i32> {
    let lower = name.to_lowercase();
    match (lower.contains("left"), lower.contains("right")) {
        (true, false) => return Some(1),
        (false, true) => return Some(-1),
        (true, true) => return None,
        (false, false) => {}
    }
    let mut letters = name.chars();
    let camel = letters.next().filter(|_| letters.next().is_some_and(char::is_uppercase));
    let camel = camel.filter(|_| letters.next().is_some_and(char::is_lowercase));
    let words = || name.split(['_', '-', '.', ' ', '/', ':']);
    let is = |letter: char| {
        camel == Some(letter.to_ascii_uppercase())
            || words().any(|word| word.len() == 1 && word.eq_ignore_ascii_case(&letter.to_string()))
    };
    match (is('l'), is('r')) {
        (true, false) => Some(1),
        (false, true) => Some(-1),
        _ => None,
    }
}

/// The name with left and right swapped: `left_hip` is `right_hip`, `L_Knee` is `R_Knee`, `waist` is
/// unchanged.
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

/// A joint's image in the notation of robot files: `-right_hip`.
pub fn written(robot: &Robot, image: usize, sign: f64) -> String {
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

/// Height in m of the base origin above flat ground that touches the lower sole in the default pose, base
/// upright.
pub fn standing_height(robot: &Robot) -> f64 {
    let kinematics = Kinematics::new(robot);
    -(0..2).map(|side| kinematics.sole(side).translation.z).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;

    use super::*;
    use crate::robot::kinematics::rotation_about;
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
    fn names_say_their_side_in_every_habit() {
        for name in
            ["left_foot", "LeftFoot", "LEFT_KNEE", "l_foot", "L_Foot_Link", "LAnklePitch", "foot.L", "leg-l"]
        {
            assert_eq!(side_of(name), Some(1), "{name}");
            let other = name.replace("left", "right").replace("Left", "Right").replace("LEFT", "RIGHT");
            let other = if other == name {
                name.replacen("l_", "r_", 1)
                    .replacen("L_", "R_", 1)
                    .replacen("LA", "RA", 1)
                    .replace(".L", ".R")
                    .replace("-l", "-r")
            } else {
                other
            };
            assert_eq!(side_of(&other), Some(-1), "{other}");
        }
        for name in ["foot", "link_1", "left_to_right_bar", "LED", "Leg", "Roller"] {
            assert_eq!(side_of(name), None, "{name}");
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
        // Replace the first yaw joint by a second one on both sides: geometry alone cannot pair them.
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
        let nearest = unpaired.nearest.unwrap();
        assert_eq!((unpaired.joint.as_str(), nearest.joint.as_str()), ("L_HipYaw_Joint", "R_HipYaw_Joint"));
        assert!((nearest.apart - 0.1).abs() < 1e-9 && nearest.angle < 1e-9);
        assert_eq!(nearest.in_words(), "the axis of `R_HipYaw_Joint` is 100.0 mm off the image");
    }

    /// Moves the origin of a joint along its axis, which does not change the robot.
    fn slide(robot: &mut Robot, joint: usize, by: f64) {
        let shift = robot.links[joint].joint.axis.into_inner() * by;
        robot.links[joint].joint.origin *= Translation3::from(shift);
        robot.links[joint].body.com -= shift;
        for collision in &mut robot.links[joint].body.collisions {
            collision.pose.translation.vector -= shift;
        }
        for child in robot.links.iter_mut().filter(|link| link.parent == Some(joint)) {
            child.joint.origin.translation.vector -= shift;
        }
        for foot in robot.feet.iter_mut().filter(|foot| foot.link == joint) {
            foot.centre -= shift;
        }
    }

    #[test]
    fn where_along_its_axis_a_joint_has_its_origin_does_not_matter() {
        for name in names() {
            let plain = robot(name);
            for joint in 0..plain.joints() {
                let mut slid = plain.clone();
                slide(&mut slid, joint, 0.3);
                assert_eq!(mirror_map(&slid).as_ref(), Ok(&plain.mirror), "{name}: {joint}");
                assert!((standing_height(&slid) - plain.standing_height).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_leg_is_not_its_own_image() {
        // Turned by 90 degrees about z, each leg with only pitch joints is in the plane of symmetry.
        let mut robot = robot("tocabi");
        let turn = rotation_about(&Vector3::z(), std::f64::consts::FRAC_PI_2);
        for link in robot.links.iter_mut().filter(|link| link.parent.is_none()) {
            link.joint.origin = turn * link.joint.origin;
            link.joint.origin.translation.vector.y = 0.0;
        }
        assert!(mirror_map(&robot).is_err());
    }
}
