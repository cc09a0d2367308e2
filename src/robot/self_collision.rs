//! Whether a robot's links are inside each other: the engines let them pass through each other.

use nalgebra::{Isometry3, Point3, distance_squared};
use parry3d::query::intersection_test;
use parry3d::shape::SharedShape;

use super::kinematics::Kinematics;
use super::model::Robot;
use super::solid::{pose, sole, solid};

/// Two bodies: 0 is the base, 1 the first link.
pub type Pair = [usize; 2];

/// The solids of a robot and the pairs of its bodies that are looked at.
#[derive(Clone)]
pub struct SelfCollision {
    kinematics: Kinematics,
    bodies: Vec<Vec<Piece>>,
    pairs: Vec<Pair>,
}

/// One solid of a body.
#[derive(Clone)]
struct Piece {
    shape: SharedShape,
    /// In the body frame.
    place: Isometry3<f64>,
    /// Its bounding sphere in the body frame, in m.
    centre: Point3<f64>,
    radius: f64,
}

impl Piece {
    fn new((shape, place): (SharedShape, Isometry3<f64>)) -> Self {
        let sphere = shape.compute_local_bounding_sphere();
        let [x, y, z] = sphere.center.to_array().map(f64::from);
        Self { centre: place * Point3::new(x, y, z), radius: f64::from(sphere.radius), shape, place }
    }
}

impl std::fmt::Debug for SelfCollision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SelfCollision").field("pairs", &self.pairs).finish_non_exhaustive()
    }
}

impl SelfCollision {
    /// The pairs of bodies that may not meet: neither hangs on the other, and in the default pose they are apart.
    pub fn pairs(robot: &Robot) -> Vec<Pair> {
        let candidates = Self::unconnected(robot);
        candidates.pairs.iter().filter(|pair| !candidates.meets(**pair)).copied().collect()
    }

    /// The other pairs of which neither body hangs on the other: in the default pose they are inside each other.
    pub fn overlapping(robot: &Robot) -> Vec<Pair> {
        let candidates = Self::unconnected(robot);
        candidates.pairs.iter().filter(|pair| candidates.meets(**pair)).copied().collect()
    }

    /// A robot in its default pose, with all pairs of bodies of which neither hangs on the other.
    fn unconnected(robot: &Robot) -> Self {
        let bodies = robot.links.len() + 1;
        let parent = |body: usize| robot.links[body - 1].parent.map_or(0, |link| link + 1);
        let pairs = (1..bodies).flat_map(|second| (0..second).map(move |first| [first, second]));
        let mut candidates = Self::new(robot, pairs.filter(|pair| parent(pair[1]) != pair[0]).collect());
        candidates.kinematics.place(&Isometry3::identity(), &robot.default_pose());
        candidates
    }

    /// Whether any body but the feet, of which the soles are known, has a shape that can meet another.
    pub fn is_measurable(robot: &Robot) -> bool {
        let is_foot = |link: usize| robot.feet.iter().any(|foot| foot.link == link);
        let mut others = robot.links.iter().enumerate().filter(|(link, _)| !is_foot(*link)).map(|(_, link)| &link.body);
        !robot.base.collisions.is_empty() || others.any(|body| !body.collisions.is_empty())
    }

    /// A robot whose pairs of these bodies are looked at.
    pub fn new(robot: &Robot, pairs: Vec<Pair>) -> Self {
        let trunk = robot.base.collisions.iter().map(solid).map(Piece::new).collect();
        let links = robot.links.iter().enumerate().map(|(index, link)| {
            match robot.feet.iter().find(|foot| foot.link == index) {
                // As in the engines: a foot is its sole's box.
                Some(foot) => vec![Piece::new(sole(foot))],
                None => link.body.collisions.iter().map(solid).map(Piece::new).collect(),
            }
        });
        let bodies = std::iter::once(trunk).chain(links).collect();
        Self { kinematics: Kinematics::new(robot), bodies, pairs }
    }

    /// The first pair that is inside each other at these joint positions in rad.
    pub fn find(&mut self, position: &[f64]) -> Option<Pair> {
        self.kinematics.place(&Isometry3::identity(), position);
        self.pairs.iter().find(|pair| self.meets(**pair)).copied()
    }

    /// The names of both bodies.
    pub fn names(robot: &Robot, pair: Pair) -> [&str; 2] {
        pair.map(|body| body.checked_sub(1).map_or(&robot.base, |link| &robot.links[link].body).name.as_str())
    }

    fn place(&self, body: usize) -> &Isometry3<f64> {
        if body == 0 { self.kinematics.base() } else { self.kinematics.pose(body - 1) }
    }

    fn meets(&self, [first, second]: Pair) -> bool {
        let places = [self.place(first), self.place(second)];
        let of_second = |a: &Piece| self.bodies[second].iter().any(|b| meet([a, b], places));
        self.bodies[first].iter().any(of_second)
    }
}

fn meet([a, b]: [&Piece; 2], [of_a, of_b]: [&Isometry3<f64>; 2]) -> bool {
    let reach = a.radius + b.radius;
    if distance_squared(&(of_a * a.centre), &(of_b * b.centre)) > reach * reach {
        return false;
    }
    let [at_a, at_b] = [pose(&(of_a * a.place)), pose(&(of_b * b.place))];
    intersection_test(&at_a, &*a.shape, &at_b, &*b.shape).is_ok_and(|found| found.intersecting)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;

    fn joint(robot: &Robot, name: &str) -> usize {
        robot.links.iter().position(|link| link.joint.name == name).expect("the robot has this joint")
    }

    #[test]
    fn no_robot_is_inside_itself_where_it_stands_and_both_legs_are_looked_at() {
        for name in crate::robot::names() {
            let robot = robot(name);
            let pairs = SelfCollision::pairs(&robot);
            let feet = [robot.feet[0].link + 1, robot.feet[1].link + 1];
            assert!(pairs.contains(&feet) || pairs.contains(&[feet[1], feet[0]]), "{name}: {pairs:?}");
            assert_eq!(SelfCollision::new(&robot, pairs).find(&robot.default_pose()), None, "{name}");
        }
    }

    #[test]
    fn self_collisions_of_soles_alone_are_not_measurable() {
        let mut robot = robot("tocabi");
        assert!(SelfCollision::is_measurable(&robot));
        robot.base.collisions.clear();
        assert!(SelfCollision::is_measurable(&robot));
        for link in &mut robot.links {
            link.body.collisions.clear();
        }
        assert!(!SelfCollision::is_measurable(&robot));
    }

    #[test]
    fn legs_that_roll_inwards_meet_and_legs_that_roll_outwards_do_not() {
        let robot = robot("tocabi");
        let mut guard = SelfCollision::new(&robot, SelfCollision::pairs(&robot));
        let [left, right] = ["L_HipRoll_Joint", "R_HipRoll_Joint"].map(|name| joint(&robot, name));
        let mut rolled = |inwards: f64| {
            let mut position = robot.default_pose();
            // A positive roll of the left hip takes the foot outwards.
            position[left] -= inwards;
            position[right] += inwards;
            guard.find(&position).map(|pair| SelfCollision::names(&robot, pair))
        };
        assert_eq!(rolled(-0.3), None);
        assert_eq!(rolled(0.0), None);
        let met = rolled(0.3).expect("both feet are on the middle line");
        assert!(met[0].starts_with("L_") != met[1].starts_with("L_"), "{met:?}");
    }

    #[test]
    fn a_cylinder_stands_along_z() {
        let collision = |shape| super::super::model::Collision { shape, pose: Isometry3::translation(0.0, 0.0, 1.0) };
        let cylinder = Piece::new(solid(&collision(super::super::model::Shape::Cylinder(0.5, 0.1))));
        let probe = Piece::new(solid(&collision(super::super::model::Shape::Sphere(0.01))));
        let inside = |x: f64, z: f64| {
            let [at, aside] = [Isometry3::identity(), Isometry3::translation(x, 0.0, z)];
            meet([&cylinder, &probe], [&at, &aside])
        };
        assert!(inside(0.0, 0.48) && !inside(0.0, 0.53) && inside(0.09, 0.0) && !inside(0.12, 0.0));
    }
}
