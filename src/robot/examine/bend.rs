//! E0426 where the frame of the base is right: a leg that is bent with all joints at zero while the other one
//! is not, for example because an MJCF file gives a `ref` to one knee only.

use nalgebra::{Isometry3, Unit, Vector3};

use crate::robot::checks::Issue;
use crate::robot::kinematics::{Kinematics, rotation_about};
use crate::robot::legs::own;
use crate::robot::model::Robot;

/// Largest distance in m and sine of an angle between images of each other, as for mirror images (E0405).
const ALIKE: f64 = 2e-3;
/// Smallest bend in rad that is reported.
const LEAST: f64 = 0.01;

/// A joint of one leg that is bent at zero against its image.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// The joint of the left leg.
    joint: usize,
    /// Its image on the right leg.
    image: usize,
    /// The angle in rad about the left joint's axis from the image's leg to the left one.
    angle: f64,
}

/// The joint below which the legs are no longer images of each other, if a turn about it makes all of the
/// rest fit. `None` if the legs differ from the base on, as they do where the base is turned.
pub fn of(robot: &Robot) -> Option<Bend> {
    let mut kinematics = Kinematics::new(robot);
    kinematics.place(&Isometry3::identity(), &vec![0.0; robot.joints()]);
    let [left, right] = [0, 1].map(|side| {
        let mut leg = own(&kinematics, side);
        leg.reverse();
        leg
    });
    let sole = |side: usize| kinematics.sole(side).translation.vector;
    if left.is_empty() || left.len() != right.len() {
        return None;
    }
    let place = |joint: usize| kinematics.pose(joint).translation.vector;
    let axis = |joint: usize| *kinematics.axis(joint);
    let images = |one: usize, other: usize| {
        let axes = axis(one).cross(&mirrored(&axis(other))).norm();
        (place(one) - mirrored(&place(other))).norm() < ALIKE && axes < ALIKE
    };
    let equal = left.iter().zip(&right).take_while(|(left, right)| images(**left, **right)).count();
    let last = equal.checked_sub(1)?;
    let (joint, image) = (left[last], right[last]);
    // Where the rest of both legs is, seen from the joint.
    let points = |leg: &[usize], side: usize| -> Vec<Vector3<f64>> {
        leg[equal..].iter().map(|joint| place(*joint)).chain([sole(side)]).collect()
    };
    let (left, right) = (points(&left, 0), points(&right, 1));
    let own = |point: &Vector3<f64>| point - place(joint);
    let others: Vec<Vector3<f64>> = right.iter().map(|point| own(&mirrored(point))).collect();
    let axis = Unit::try_new(axis(joint), 1e-9)?;
    let (first, other) = (own(left.first()?), others.first()?);
    let across = |vector: &Vector3<f64>| vector - axis.dot(vector) * axis.into_inner();
    let (from, to) = (across(other), across(&first));
    let angle = libm::atan2(axis.dot(&from.cross(&to)), from.dot(&to));
    let turn = rotation_about(&axis, angle);
    let fits = left.iter().zip(&others).all(|(point, other)| (own(point) - turn * other).norm() < ALIKE);
    (fits && angle.abs() > LEAST).then_some(Bend { joint, image, angle })
}

/// The reflection in the x-z plane of the base.
fn mirrored(vector: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(vector.x, -vector.y, vector.z)
}

impl Bend {
    /// The bend as the reason that the feet do not lie left and right.
    pub fn issue(&self, robot: &Robot) -> Issue {
        let name = |joint: usize| &robot.links[joint].joint.name;
        let (joint, image) = (name(self.joint), name(self.image));
        Issue {
            code: "E0426",
            path: format!("links.{}.joint", self.joint),
            message: format!(
                "with all joints at zero, the left leg is bent at `{joint}` by {:.2} rad more than the right \
                 one at `{image}`",
                self.angle.abs()
            ),
            help: format!(
                "give both joints the same zero: in an MJCF file the same `ref`; in the robot's file turn \
                 the `origin` of one of them by {:.4} rad about its axis, and shift its limits and its \
                 `default_position` as much",
                self.angle.abs()
            ),
        }
    }
}
