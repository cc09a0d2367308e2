//! The support polygon: the convex hull of the corners of the soles in contact, seen from above.
//!
//! A robot at rest on level ground stands as long as its centre of mass is above the polygon. Independent of
//! forces; the caller decides which soles are in contact.

use nalgebra::{Point2, Vector2};

use super::Robot;
use super::kinematics::Kinematics;

/// A support polygon in the world's x-y plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    corners: Vec<Point2<f64>>,
}

impl Support {
    /// The polygon of the left and the right sole, each if it is in contact.
    pub fn new(kinematics: &Kinematics, contact: [bool; 2]) -> Self {
        let carrying = (0..2).filter(|side| contact[*side]);
        Self::around(carrying.flat_map(|side| kinematics.corners(side)).map(|corner| corner.xy()).collect())
    }

    /// Distance in m of the centre of mass, in the default pose, inside the border of the polygon of both
    /// soles; negative outside.
    pub fn standing_margin(robot: &Robot) -> f64 {
        let kinematics = Kinematics::new(robot);
        Self::new(&kinematics, [true; 2]).margin(&kinematics.com().xy())
    }

    /// The convex hull of points (Andrew's monotone chain, 1979).
    pub fn around(mut points: Vec<Point2<f64>>) -> Self {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            return Self { corners: points };
        }
        let mut corners = half_hull(points.iter());
        corners.extend(half_hull(points.iter().rev()));
        Self { corners }
    }

    /// The corners in m, counter-clockwise; none without a contact.
    pub fn corners(&self) -> &[Point2<f64>] {
        &self.corners
    }

    /// Area in m^2.
    pub fn area(&self) -> f64 {
        self.edges().map(|(from, to)| from.coords.perp(&to.coords)).sum::<f64>() / 2.0
    }

    /// Signed distance in m of a point from the border: positive inside, negative outside, minus infinity
    /// without a contact.
    pub fn margin(&self, point: &Point2<f64>) -> f64 {
        let distance = self.edges().map(|(from, to)| distance(point, from, to)).fold(f64::INFINITY, f64::min);
        let inside = self.corners.len() > 2 && self.edges().all(|(from, to)| turn(from, to, point) >= 0.0);
        if inside { distance } else { -distance }
    }

    /// The edges, counter-clockwise.
    fn edges(&self) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
        self.corners.iter().zip(self.corners.iter().cycle().skip(1))
    }
}

/// The points of one side of the hull without the last: every turn is to the left.
fn half_hull<'a>(points: impl Iterator<Item = &'a Point2<f64>>) -> Vec<Point2<f64>> {
    let mut chain: Vec<Point2<f64>> = Vec::new();
    for point in points {
        while let [.., before, last] = chain.as_slice()
            && turn(before, last, point) <= 0.0
        {
            chain.pop();
        }
        chain.push(*point);
    }
    chain.pop();
    chain
}

/// Twice the area of a triangle, positive when it is counter-clockwise.
fn turn(from: &Point2<f64>, to: &Point2<f64>, point: &Point2<f64>) -> f64 {
    (to - from).perp(&(point - from))
}

/// Distance of a point from a segment, which may be a point.
fn distance(point: &Point2<f64>, from: &Point2<f64>, to: &Point2<f64>) -> f64 {
    let (along, arm): (Vector2<f64>, Vector2<f64>) = (to - from, point - from);
    let square = along.norm_squared();
    let share = if square > 0.0 { (arm.dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (arm - along * share).norm()
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use proptest::prelude::*;

    use super::*;
    use crate::robot::kinematics::rotation_about;
    use crate::robot::tests::robot;

    /// A rectangle of 2 m by 1 m at the origin, with a point inside and one in the middle of an edge.
    fn rectangle() -> Support {
        let corners = [(2.0, 1.0), (0.0, 0.0), (1.0, 0.5), (2.0, 0.0), (0.0, 1.0), (1.0, 0.0)];
        Support::around(corners.map(|(x, y)| Point2::new(x, y)).to_vec())
    }

    #[test]
    fn the_hull_of_a_rectangle_is_its_four_corners() {
        let corners: Vec<(f64, f64)> =
            rectangle().corners().iter().map(|corner| (corner.x, corner.y)).collect();
        assert_eq!(corners, [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]);
        assert_eq!(rectangle().area(), 2.0);
    }

    #[test]
    fn the_margin_is_the_distance_from_the_border() {
        for (x, y, margin) in [
            (0.5, 0.4, 0.4),
            (1.8, 0.5, 0.2),
            (2.0, 0.5, 0.0),
            (1.0, -0.25, -0.25),
            // Beyond a corner the corner is nearest: 3, 4, 5.
            (5.0, 5.0, -5.0),
        ] {
            assert!((rectangle().margin(&Point2::new(x, y)) - margin).abs() < 1e-15, "{x} {y}");
        }
    }

    #[test]
    fn without_contact_nothing_is_inside() {
        let kinematics = Kinematics::new(&robot("tocabi"));
        let flying = Support::new(&kinematics, [false, false]);
        assert_eq!((flying.corners().len(), flying.area()), (0, 0.0));
        assert_eq!(flying.margin(&Point2::origin()), f64::NEG_INFINITY);
    }

    #[test]
    fn one_sole_supports_its_own_area_and_two_the_ground_between_them_too() {
        // TOCABI's soles: 0.30 m by 0.17 m, their centres 0.205 m apart.
        let kinematics = Kinematics::new(&robot("tocabi"));
        for side in [[true, false], [false, true]] {
            assert!((Support::new(&kinematics, side).area() - 0.30 * 0.17).abs() < 1e-9);
        }
        let both = Support::new(&kinematics, [true, true]);
        assert!((both.area() - 0.30 * (0.17 + 0.205)).abs() < 1e-6, "{}", both.area());
        let com = kinematics.com().xy();
        assert!(both.margin(&com) > 0.1 && Support::new(&kinematics, [true, false]).margin(&com) < 0.0);
    }

    #[test]
    fn the_margin_turns_and_moves_with_the_robot() {
        let robot = robot("atlas");
        let mut kinematics = Kinematics::new(&robot);
        let before = Support::new(&kinematics, [true, true]).margin(&kinematics.com().xy());
        let turn = rotation_about(&nalgebra::Vector3::z(), 2.1);
        let base = Isometry3::from_parts(nalgebra::Translation3::new(7.0, -3.0, 0.2), turn);
        kinematics.place(&base, &robot.default_pose());
        let after = Support::new(&kinematics, [true, true]).margin(&kinematics.com().xy());
        assert!((before - after).abs() < 1e-12, "{before} {after}");
    }

    proptest! {
        #[test]
        fn no_point_is_outside_its_hull(points in prop::collection::vec((-1.0..1.0, -1.0..1.0), 1..12)) {
            let points: Vec<Point2<f64>> =
                points.into_iter().map(|(x, y): (f64, f64)| Point2::new(x, y)).collect();
            let hull = Support::around(points.clone());
            for point in &points {
                prop_assert!(hull.margin(point) > -1e-12, "{point} is outside {hull:?}");
            }
            for corner in hull.corners() {
                prop_assert!(points.contains(corner) && hull.margin(corner).abs() < 1e-12);
            }
            prop_assert!(hull.area() >= 0.0);
        }
    }
}
