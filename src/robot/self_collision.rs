//! Detects self-collisions, which the engines ignore.
//!
//! This runs in every control step of training, so most pairs are decided without the geometry library: by
//! bounding spheres, then by a separating plane along one of a few directions. Both are exact if they find
//! "apart"; all other pairs are passed to the library.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3, distance_squared};
use parry3d::query::intersection_test;
use parry3d::shape::SharedShape;

use super::kinematics::Kinematics;
use super::model::{Collision, Foot, Robot, Shape};
use super::solid::{pose, sole, solid};

/// Two bodies: 0 is the base, 1 the first link.
pub type Pair = [usize; 2];

/// Minimum gap in m between two shapes to skip the library, which uses `f32`: at the size of a robot its
/// error is below 1e-6 m.
const CLEAR: f64 = 1e-4;

/// The solids of a robot, and the pairs of bodies to check.
#[derive(Clone)]
pub struct SelfCollision {
    kinematics: Kinematics,
    bodies: Vec<Vec<Piece>>,
    pairs: Vec<Pair>,
}

/// One solid of a body. All shapes are symmetric about their centre.
#[derive(Clone)]
struct Piece {
    solid: SharedShape,
    /// Pose of the library's solid in the body frame.
    solid_place: Isometry3<f64>,
    shape: Shape,
    /// Pose of the shape in the body frame.
    place: Isometry3<f64>,
    /// Radius of the bounding sphere in m.
    radius: f64,
    /// Centre and axes of the shape in the robot's frame, in the pose to check.
    centre: Point3<f64>,
    axes: Matrix3<f64>,
}

impl Piece {
    fn of(collision: &Collision) -> Self {
        let (solid, solid_place) = solid(collision);
        Self::new(collision.shape.clone(), collision.pose, solid, solid_place)
    }

    /// As in the engines, a foot is represented by its sole's box.
    fn of_foot(foot: &Foot) -> Self {
        let (solid, place) = sole(foot);
        Self::new(Shape::Box(foot.half_extents), place, solid, place)
    }

    fn new(shape: Shape, place: Isometry3<f64>, solid: SharedShape, solid_place: Isometry3<f64>) -> Self {
        let radius = match &shape {
            Shape::Box(half) => half.norm(),
            Shape::Capsule(half, radius) => half + radius,
            Shape::Cylinder(half, radius) => libm::hypot(*half, *radius),
            Shape::Sphere(radius) => *radius,
        };
        Self { solid, solid_place, shape, place, radius, centre: Point3::origin(), axes: Matrix3::identity() }
    }

    fn move_with(&mut self, body: &Isometry3<f64>) {
        self.centre = body * Point3::from(self.place.translation.vector);
        self.axes = (body.rotation * self.place.rotation).to_rotation_matrix().into_inner();
    }

    /// Extent of the shape from its centre along a direction, times the direction's length.
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let local = self.axes.tr_mul(direction);
        match &self.shape {
            Shape::Box(half) => local.abs().dot(half),
            Shape::Capsule(half, radius) => local.z.abs() * half + radius * direction.norm(),
            Shape::Cylinder(half, radius) => local.z.abs() * half + radius * local.xy().norm(),
            Shape::Sphere(radius) => radius * direction.norm(),
        }
    }
}

impl std::fmt::Debug for SelfCollision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SelfCollision").field("pairs", &self.pairs).finish_non_exhaustive()
    }
}

impl SelfCollision {
    /// The pairs of bodies that must not collide: not connected by a joint, and apart in the default pose.
    pub fn pairs(robot: &Robot) -> Vec<Pair> {
        let candidates = Self::unconnected(robot);
        candidates.pairs.iter().filter(|pair| !candidates.meets(**pair)).copied().collect()
    }

    /// The other pairs of bodies that are not connected by a joint: those that overlap in the default pose.
    pub fn overlapping(robot: &Robot) -> Vec<Pair> {
        let candidates = Self::unconnected(robot);
        candidates.pairs.iter().filter(|pair| candidates.meets(**pair)).copied().collect()
    }

    /// A robot in its default pose, with all pairs of bodies that are not connected by a joint.
    fn unconnected(robot: &Robot) -> Self {
        let bodies = robot.links.len() + 1;
        let parent = |body: usize| robot.links[body - 1].parent.map_or(0, |link| link + 1);
        let pairs = (1..bodies).flat_map(|second| (0..second).map(move |first| [first, second]));
        let mut candidates = Self::new(robot, pairs.filter(|pair| parent(pair[1]) != pair[0]).collect());
        candidates.place(&robot.default_pose());
        candidates
    }

    /// Whether any body besides the feet, which always have soles, has a collision shape.
    pub fn is_measurable(robot: &Robot) -> bool {
        let is_foot = |link: usize| robot.feet.iter().any(|foot| foot.link == link);
        let mut others =
            robot.links.iter().enumerate().filter(|(link, _)| !is_foot(*link)).map(|(_, link)| &link.body);
        !robot.base.collisions.is_empty() || others.any(|body| !body.collisions.is_empty())
    }

    /// A robot with the pairs of bodies to check.
    pub fn new(robot: &Robot, pairs: Vec<Pair>) -> Self {
        let trunk = robot.base.collisions.iter().map(Piece::of).collect();
        let links = robot.links.iter().enumerate().map(|(index, link)| {
            match robot.feet.iter().find(|foot| foot.link == index) {
                Some(foot) => vec![Piece::of_foot(foot)],
                None => link.body.collisions.iter().map(Piece::of).collect(),
            }
        });
        let bodies = std::iter::once(trunk).chain(links).collect();
        Self { kinematics: Kinematics::new(robot), bodies, pairs }
    }

    /// The first colliding pair at these joint positions in rad.
    pub fn find(&mut self, position: &[f64]) -> Option<Pair> {
        self.place(position);
        self.pairs.iter().find(|pair| self.meets(**pair)).copied()
    }

    fn place(&mut self, position: &[f64]) {
        self.kinematics.place_links(&Isometry3::identity(), position);
        for (body, pieces) in self.bodies.iter_mut().enumerate() {
            let pose = if body == 0 { self.kinematics.base() } else { self.kinematics.pose(body - 1) };
            pieces.iter_mut().for_each(|piece| piece.move_with(pose));
        }
    }

    /// The names of both bodies.
    pub fn names(robot: &Robot, pair: Pair) -> [&str; 2] {
        pair.map(|body| body.checked_sub(1).map_or(&robot.base, |link| &robot.links[link].body).name.as_str())
    }

    fn meets(&self, [first, second]: Pair) -> bool {
        let pose =
            |body: usize| if body == 0 { self.kinematics.base() } else { self.kinematics.pose(body - 1) };
        self.bodies[first].iter().any(|a| {
            self.bodies[second]
                .iter()
                .any(|b| !are_apart(a, b) && intersect([a, b], [pose(first), pose(second)]))
        })
    }
}

/// Whether the bounding spheres do not touch, or a plane separates the shapes: perpendicular to the line
/// between their centres or to an axis of one of them.
fn are_apart(a: &Piece, b: &Piece) -> bool {
    let reach = a.radius + b.radius + CLEAR;
    if distance_squared(&a.centre, &b.centre) > reach * reach {
        return true;
    }
    let between = b.centre - a.centre;
    let gap =
        |direction: &Vector3<f64>| between.dot(direction).abs() - a.reach(direction) - b.reach(direction);
    let axes = a.axes.column_iter().chain(b.axes.column_iter());
    gap(&between) > CLEAR * between.norm() || axes.into_iter().any(|axis| gap(&axis.into_owned()) > CLEAR)
}

/// Whether the library finds that the shapes intersect.
fn intersect([a, b]: [&Piece; 2], [of_a, of_b]: [&Isometry3<f64>; 2]) -> bool {
    let [at_a, at_b] = [pose(&(of_a * a.solid_place)), pose(&(of_b * b.solid_place))];
    intersection_test(&at_a, &*a.solid, &at_b, &*b.solid).is_ok_and(|found| found.intersecting)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::tests::robot;
    use crate::stream::Stream;

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
            // A positive roll of the left hip moves the foot outwards.
            position[left] -= inwards;
            position[right] += inwards;
            guard.find(&position).map(|pair| SelfCollision::names(&robot, pair))
        };
        assert_eq!(rolled(-0.3), None);
        assert_eq!(rolled(0.0), None);
        let met = rolled(0.3).expect("both feet are on the middle line");
        assert!(met[0].starts_with("L_") != met[1].starts_with("L_"), "{met:?}");
    }

    /// A shape a few centimetres off the origin of its body.
    fn piece(shape: Shape, body: &Isometry3<f64>) -> Piece {
        let mut piece = Piece::of(&Collision { shape, pose: Isometry3::translation(0.0, 0.02, 0.05) });
        piece.move_with(body);
        piece
    }

    #[test]
    fn a_cylinder_stands_along_z() {
        let inside = |x: f64, z: f64| {
            let [at, aside] = [Isometry3::identity(), Isometry3::translation(x, 0.0, z)];
            let [a, b] = [piece(Shape::Cylinder(0.5, 0.1), &at), piece(Shape::Sphere(0.01), &aside)];
            !are_apart(&a, &b) && intersect([&a, &b], [&at, &aside])
        };
        assert!(inside(0.0, 0.48) && !inside(0.0, 0.53) && inside(0.09, 0.0) && !inside(0.12, 0.0));
    }

    #[test]
    fn shapes_that_are_taken_for_apart_do_not_intersect_and_most_of_those_apart_are_found() {
        let shapes = [
            Shape::Box(Vector3::new(0.12, 0.05, 0.03)),
            Shape::Capsule(0.15, 0.05),
            Shape::Cylinder(0.1, 0.06),
            Shape::Sphere(0.08),
        ];
        let mut stream = Stream::new("test/self_collision");
        let mut draw = |scale: f64| Vector3::from_fn(|_, _| scale * (2.0 * stream.uniform() - 1.0));
        let (mut apart, mut found) = (0, 0);
        for index in 0..4000 {
            let places = [(); 2].map(|()| Isometry3::new(draw(0.15), draw(3.0)));
            let [a, b] = [(index, 0), (index / 4, 1)]
                .map(|(shape, side)| piece(shapes[shape % 4].clone(), &places[side]));
            let together = intersect([&a, &b], [&places[0], &places[1]]);
            assert!(!(together && are_apart(&a, &b)), "{:?} and {:?} at {places:?}", a.shape, b.shape);
            apart += usize::from(!together);
            found += usize::from(are_apart(&a, &b));
        }
        assert!((1000..3000).contains(&apart) && found > apart * 8 / 10, "{found} of {apart}");
    }
}
