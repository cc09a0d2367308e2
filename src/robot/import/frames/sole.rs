//! The plane on which a foot rests: the facet of its convex hull below its middle, along the leg.
//!
//! Works on shapes in the frame of a link, independent of the target frames: all results rotate with the
//! shapes.

use nalgebra::{Matrix3, Point2, Unit, Vector3};

use super::super::feet::SOLE_DEPTH;
use crate::robot::{Collision, Shape, Support};

/// Number of points that approximate the rim of a cylinder.
const RIM: u32 = 64;
/// Distance tolerance in m of points in a plane.
const PLANAR: f64 = 1e-5;
/// Minimum share of the area near the ground in one plane for a flat sole.
const FLAT: f64 = 0.6;
/// Angle tolerance in rad between a face of a shape and the facet.
const FACE: f64 = 1e-3;
/// Maximum number of steps of the search for the facet.
const STEPS: usize = 500;

/// A sphere of a hull; a corner has radius zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    /// In the link's frame, in m.
    pub centre: Vector3<f64>,
    /// In m.
    pub radius: f64,
}

/// The hull of a shape.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    balls: Vec<Ball>,
    /// Normals of exactly known flat faces, with their areas in m^2.
    faces: Vec<(Vector3<f64>, f64)>,
    /// Whether it is a mesh, whose points are rounded.
    mesh: bool,
}

/// The underside of a foot in the frame of its link.
#[derive(Clone, Debug)]
pub(super) struct Sole {
    /// Unit normal that points into the foot.
    pub normal: Vector3<f64>,
    /// Whether most of the area near the ground is in one plane.
    pub flat: bool,
    /// Whether a mesh is part of it.
    pub mesh: bool,
    /// The shapes that reach the ground.
    pub balls: Vec<Ball>,
}

impl Piece {
    /// The hull of a collision shape.
    pub fn of(collision: &Collision) -> Self {
        let pose = &collision.pose;
        let at = |x: f64, y: f64, z: f64| (pose * nalgebra::Point3::new(x, y, z)).coords;
        let ball = |centre: Vector3<f64>, radius: f64| Ball { centre, radius };
        let along = |axis: Vector3<f64>| pose.rotation * axis;
        match &collision.shape {
            Shape::Box(half) => {
                let sign = |corner: u32, bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let corner = |corner: u32| {
                    at(sign(corner, 0) * half.x, sign(corner, 1) * half.y, sign(corner, 2) * half.z)
                };
                let faces = [
                    (Vector3::x(), half.y * half.z),
                    (Vector3::y(), half.x * half.z),
                    (Vector3::z(), half.x * half.y),
                ];
                let faces = faces.map(|(axis, quarter)| (along(axis), 4.0 * quarter));
                Self {
                    balls: (0..8).map(|index| ball(corner(index), 0.0)).collect(),
                    faces: faces.into(),
                    mesh: false,
                }
            }
            Shape::Sphere(radius) => {
                Self { balls: vec![ball(at(0.0, 0.0, 0.0), *radius)], ..Self::default() }
            }
            Shape::Capsule(half, radius) => {
                let ends = [-half, *half].map(|z| ball(at(0.0, 0.0, z), *radius));
                Self { balls: ends.into(), ..Self::default() }
            }
            Shape::Cylinder(half, radius) => {
                let rim = (0..RIM)
                    .map(|step| libm::sincos(std::f64::consts::TAU * f64::from(step) / f64::from(RIM)));
                let balls = rim.flat_map(|(sine, cosine)| {
                    [-half, *half].map(|z| ball(at(radius * cosine, radius * sine, z), 0.0))
                });
                let area = std::f64::consts::PI * radius * radius;
                Self { balls: balls.collect(), faces: vec![(along(Vector3::z()), area)], mesh: false }
            }
        }
    }

    /// The hull of a mesh's points, in the link's frame.
    pub fn mesh(points: impl Iterator<Item = Vector3<f64>>) -> Self {
        Self {
            balls: points.map(|centre| Ball { centre, radius: 0.0 }).collect(),
            faces: Vec::new(),
            mesh: true,
        }
    }

    fn middle(&self) -> Vector3<f64> {
        self.balls.iter().map(|ball| ball.centre).sum::<Vector3<f64>>() / self.balls.len().max(1) as f64
    }

    /// Its extent along a direction in m.
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        let reach = |ball: &Ball| ball.centre.dot(direction) + ball.radius;
        self.balls.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The middle of a foot's shapes in the link's frame; `None` without shapes.
pub(super) fn middle(pieces: &[Piece]) -> Option<Vector3<f64>> {
    (!pieces.is_empty()).then(|| pieces.iter().map(Piece::middle).sum::<Vector3<f64>>() / pieces.len() as f64)
}

/// The furthest point of a foot's shapes along a direction, in the link's frame.
pub(super) fn furthest(pieces: &[Piece], direction: &Vector3<f64>) -> Option<Vector3<f64>> {
    let balls = pieces.iter().flat_map(|piece| &piece.balls);
    let reach = |ball: &Ball| ball.centre.dot(direction) + ball.radius;
    balls.max_by(|a, b| reach(a).total_cmp(&reach(b))).map(|ball| ball.centre + direction * ball.radius)
}

/// The underside of a foot; `down` points roughly to the ground. `None` if its shapes do not span a plane,
/// for example one sphere or one capsule.
pub(super) fn sole(pieces: &[Piece], down: &Unit<Vector3<f64>>) -> Option<Sole> {
    let balls: Vec<Ball> = pieces.iter().flat_map(|piece| piece.balls.iter().copied()).collect();
    let middle = middle(pieces)?;
    let mut outwards = down.into_inner();
    for _ in 0..20 {
        let points: Vec<Vector3<f64>> =
            balls.iter().map(|ball| ball.centre + outwards * ball.radius - middle).collect();
        let next = facet(&points, down)?;
        let change = (next - outwards).norm();
        outwards = next;
        if change < 1e-14 {
            break;
        }
    }
    let lowest = pieces.iter().map(|piece| piece.reach(&outwards)).fold(f64::NEG_INFINITY, f64::max);
    let touching: Vec<&Piece> =
        pieces.iter().filter(|piece| lowest - piece.reach(&outwards) < SOLE_DEPTH).collect();
    // A sphere at the end of a shank touches the ground in a point, regardless of the hull's facet.
    if touching.len() < 3 && stands_on_a_ball(pieces, down) {
        return None;
    }
    let faces = touching.iter().flat_map(|piece| &piece.faces);
    let along = |(normal, area): &(Vector3<f64>, f64)| (normal * normal.dot(&outwards).signum(), *area);
    let same = faces.map(along).filter(|(normal, _)| (normal - outwards).norm() < FACE);
    let exact = same.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(normal, _)| normal);
    outwards = exact.unwrap_or(outwards);
    // A cylinder on its side has no flat face below.
    let round = touching.iter().any(|piece| {
        piece.balls.len() == 2 * RIM as usize
            && !piece.mesh
            && piece.faces.iter().all(|(axis, _)| axis.dot(&outwards).abs() < 1.0 - FACE)
    });
    let near = |depth: f64| area(&balls, &outwards, lowest_of(&balls, &outwards) - depth);
    let flat = !round && near(PLANAR) > FLAT * near(SOLE_DEPTH);
    Some(Sole {
        normal: -outwards,
        flat,
        mesh: touching.iter().any(|piece| piece.mesh),
        balls: touching.iter().flat_map(|piece| piece.balls.iter().copied()).collect(),
    })
}

/// Whether a single sphere reaches furthest down.
fn stands_on_a_ball(pieces: &[Piece], down: &Unit<Vector3<f64>>) -> bool {
    let lowest = pieces.iter().map(|piece| piece.reach(down)).fold(f64::NEG_INFINITY, f64::max);
    let near: Vec<&Piece> = pieces.iter().filter(|piece| lowest - piece.reach(down) < SOLE_DEPTH).collect();
    matches!(near.as_slice(), [piece] if matches!(piece.balls.as_slice(), [ball] if ball.radius > 0.0))
}

fn lowest_of(balls: &[Ball], outwards: &Vector3<f64>) -> f64 {
    balls.iter().map(|ball| ball.centre.dot(outwards) + ball.radius).fold(f64::NEG_INFINITY, f64::max)
}

/// Area in m^2 of the hull of the spheres beyond a height along a direction, projected along it.
fn area(balls: &[Ball], outwards: &Vector3<f64>, height: f64) -> f64 {
    let [u, v] = across(outwards);
    let near = balls.iter().filter(|ball| ball.centre.dot(outwards) + ball.radius > height);
    Support::around(near.map(|ball| Point2::new(ball.centre.dot(&u), ball.centre.dot(&v))).collect()).area()
}

/// Two unit vectors that complete a unit vector to a right-handed frame (u, v, direction).
pub(super) fn across(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = direction.iamin();
    let mut other = Vector3::zeros();
    other[least] = 1.0;
    let u = (other - direction * direction[least]).normalize();
    [u, direction.cross(&u)]
}

/// The outward normal of the facet of a hull hit by the ray from the origin along `down`; the origin is
/// inside. `None` if the hull has no area seen along `down`.
///
/// Starts with a triangle around the ray and replaces its points by points further out, as in portal
/// refinement.
fn facet(points: &[Vector3<f64>], down: &Unit<Vector3<f64>>) -> Option<Vector3<f64>> {
    let [u, v] = across(down);
    // x and y perpendicular to the ray, z along it.
    let seen: Vec<Vector3<f64>> =
        points.iter().map(|point| Vector3::new(point.dot(&u), point.dot(&v), point.dot(down))).collect();
    let size = seen.iter().map(Vector3::norm).fold(0.0, f64::max);
    if size <= 0.0 {
        return None;
    }
    // Around everything and far behind it: none of these points remains if the hull has an area.
    let start = [(0.0, 10.0), (-9.0, -5.0), (9.0, -5.0)];
    let mut triangle = start.map(|(x, y)| Vector3::new(x * size, y * size, -1e3 * size));
    let mut plane = through(&triangle)?;
    for _ in 0..STEPS {
        let above = |point: &Vector3<f64>| point.z - plane.x - plane.y * point.x - plane.z * point.y;
        let furthest = seen.iter().max_by(|a, b| above(a).total_cmp(&above(b)))?;
        if above(furthest) <= 1e-13 * size {
            break;
        }
        let next = (0..3).filter_map(|corner| {
            let mut exchanged = triangle;
            exchanged[corner] = *furthest;
            Some((holds(&exchanged)?, exchanged))
        });
        let (_, next) = next.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let Some(next_plane) = through(&next) else { break };
        (triangle, plane) = (next, next_plane);
    }
    let inside = triangle.iter().all(|corner| corner.z > -100.0 * size);
    inside.then(|| (down.into_inner() - u * plane.y - v * plane.z).normalize())
}

/// The plane `z = t + a x + b y` through three points: t, a, b.
fn through(triangle: &[Vector3<f64>; 3]) -> Option<Vector3<f64>> {
    let rows = triangle.map(|point| Vector3::new(1.0, point.x, point.y).transpose());
    let heights = Vector3::from(triangle.map(|point| point.z));
    Matrix3::from_rows(&rows).lu().solve(&heights).filter(|plane| plane.iter().all(|entry| entry.is_finite()))
}

/// The smallest barycentric coordinate of the origin, seen from above: negative if it is outside.
fn holds(triangle: &[Vector3<f64>; 3]) -> Option<f64> {
    let cross = |a: &Vector3<f64>, b: &Vector3<f64>| a.x * b.y - a.y * b.x;
    let [a, b, c] = triangle;
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    let whole: f64 = parts.iter().sum();
    let shares = parts.map(|part| part / whole);
    shares.iter().all(|share| share.is_finite()).then(|| shares.into_iter().fold(f64::INFINITY, f64::min))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    use super::*;
    use crate::stream::Stream;

    fn turned(shapes: &[(Shape, Vector3<f64>)], turn: &UnitQuaternion<f64>) -> Vec<Piece> {
        let place = |at: &Vector3<f64>| {
            turn * Isometry3::from_parts(Translation3::from(*at), UnitQuaternion::identity())
        };
        shapes
            .iter()
            .map(|(shape, at)| Piece::of(&Collision { shape: shape.clone(), pose: place(at) }))
            .collect()
    }

    #[test]
    fn the_normal_of_a_sole_turns_with_its_shapes() {
        let mut stream = Stream::new("test/sole");
        let toe_and_heel = [
            (Shape::Box(Vector3::new(0.05, 0.04, 0.01)), Vector3::new(0.1, 0.0, -0.05)),
            (Shape::Box(Vector3::new(0.05, 0.04, 0.02)), Vector3::new(-0.02, 0.0, -0.04)),
        ];
        let balls = [(-0.05, 0.03), (-0.05, -0.03), (0.12, 0.03), (0.12, -0.03)]
            .map(|(x, y)| (Shape::Sphere(0.005), Vector3::new(x, y, -0.03)));
        let skids = [0.03, -0.03]
            .map(|y| (Shape::Box(Vector3::new(0.1, 0.005, 0.005)), Vector3::new(0.02, y, -0.03)));
        let disc = [(Shape::Cylinder(0.01, 0.06), Vector3::new(0.0, 0.0, -0.03))];
        for shapes in [&toe_and_heel[..], &balls, &skids, &disc] {
            for _ in 0..20 {
                let direction = Vector3::new(stream.normal(), stream.normal(), stream.normal());
                let turn = UnitQuaternion::from_scaled_axis(direction);
                // The leg is slightly inclined.
                let down = Unit::new_normalize(turn * Vector3::new(0.2, -0.1, -1.0));
                let sole = sole(&turned(shapes, &turn), &down).expect("it has a sole");
                assert!((sole.normal - turn * Vector3::z()).norm() < 1e-12, "{:?}", sole.normal);
                assert!(sole.flat);
            }
        }
    }

    #[test]
    fn what_touches_in_a_point_or_a_line_has_no_sole() {
        let down = -Vector3::z_axis();
        let still = UnitQuaternion::identity();
        let lying = UnitQuaternion::from_scaled_axis(Vector3::y() * 1.5);
        assert!(sole(&[], &down).is_none());
        assert!(sole(&turned(&[(Shape::Sphere(0.03), Vector3::zeros())], &still), &down).is_none());
        assert!(sole(&turned(&[(Shape::Capsule(0.1, 0.03), Vector3::zeros())], &lying), &down).is_none());
        let log = sole(&turned(&[(Shape::Cylinder(0.1, 0.03), Vector3::zeros())], &lying), &down);
        assert!(log.is_none_or(|log| !log.flat));
    }

    #[test]
    fn a_ball_at_the_end_of_a_shank_has_no_sole_however_the_leg_leans() {
        let shapes = [
            (Shape::Sphere(0.03), Vector3::new(0.0, 0.0, -0.3)),
            (Shape::Capsule(0.1, 0.02), Vector3::new(0.0, 0.0, -0.1)),
        ];
        for lean in [0.0, 0.3, -0.8] {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, lean, 0.0));
            assert!(sole(&turned(&shapes, &turn), &-Vector3::z_axis()).is_none(), "{lean}");
        }
    }

    #[test]
    fn a_sole_of_uneven_balls_is_not_flat() {
        let balls = [(-0.05, 0.03, 0.0), (-0.05, -0.03, 0.001), (0.12, 0.03, 0.002), (0.12, -0.03, 0.0)]
            .map(|(x, y, z)| (Shape::Sphere(0.005), Vector3::new(x, y, z)));
        let sole =
            sole(&turned(&balls, &UnitQuaternion::identity()), &-Vector3::z_axis()).expect("it has a sole");
        assert!(!sole.flat && sole.normal.z > 0.99);
    }
}
