//! The frame of a foot: z is the normal of the sole, x points forward.
//!
//! Works in the frame of the foot's link. A frame that follows the convention is preserved exactly.

use nalgebra::{Matrix3, Vector3};

use super::sole::{Ball, Sole};
use super::turn::{nearest_permutation, upright};

/// Angle tolerance in rad between z and the normal of a flat sole for the frame to be preserved.
const EXACT: f64 = 1e-4;
/// The same for a sole from a mesh, whose points are rounded.
const MESH: f64 = 1e-2;
/// The same for a sole that is not flat and thus has no exact normal.
const UNEVEN: f64 = 0.1;
/// Relative rounding error of an area or volume.
const ROUNDING: f64 = 1e-6;
/// Relative excess over the smallest rectangle around a flat sole, and over the smallest box around another
/// one.
const LARGER: [f64; 2] = [1e-3, 0.05];
/// Minimum relative reduction of an uneven sole's box for a new frame.
const UNEVEN_GAIN: f64 = 0.01;

/// Directions of the base in the foot link's frame, in the default pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    /// Up.
    pub up: Vector3<f64>,
    /// Forward.
    pub forward: Vector3<f64>,
}

/// The foot's frame relative to its link; `None` if that is preserved.
pub(super) fn frame(sole: Option<&Sole>, base: &Directions) -> Option<Matrix3<f64>> {
    match sole {
        Some(sole) => of_sole(sole, base),
        None => without_sole(base),
    }
}

fn without_sole(base: &Directions) -> Option<Matrix3<f64>> {
    let level = upright(&base.up, &base.forward)?;
    let follows =
        |frame: &Matrix3<f64>| angle(&frame.column(2).into(), &base.up) <= UNEVEN && ahead(frame, &level);
    let keeps = [Matrix3::identity(), nearest_permutation(&level)].into_iter().find(follows);
    keeps.or(Some(level)).filter(|frame| *frame != Matrix3::identity())
}

fn of_sole(sole: &Sole, base: &Directions) -> Option<Matrix3<f64>> {
    let tolerance = match (sole.flat, sole.mesh) {
        (true, false) => EXACT,
        (true, true) => MESH,
        (false, _) => UNEVEN,
    };
    // Exact normals are preserved; others that are nearly vertical are replaced by `up`.
    let exact = sole.flat && !sole.mesh;
    let z = if !exact && angle(&sole.normal, &base.up) <= tolerance { base.up } else { sole.normal };
    let level = upright(&z, &base.forward)?;
    let size = |frame: &Matrix3<f64>| size(&sole.balls, frame, !exact);
    let gain = if exact { ROUNDING } else { UNEVEN_GAIN };
    let as_small = |frame: &Matrix3<f64>, other: &Matrix3<f64>| size(frame) <= size(other) * (1.0 + gain);
    // A frame that is level in the pose is more reliable than the underside of a mesh, which can have any
    // shape.
    let stands = upright(&base.up, &base.forward).filter(|_| sole.mesh);
    let is_level = |frame: &Matrix3<f64>| {
        let level = stands.as_ref().filter(|_| angle(&frame.column(2).into(), &base.up) <= MESH);
        level.is_some_and(|level| ahead(frame, level) && as_small(frame, level))
    };
    let follows = |frame: &Matrix3<f64>| {
        let along = angle(&frame.column(2).into(), &sole.normal) <= tolerance;
        is_level(frame) || (along && ahead(frame, &level) && as_small(frame, &level))
    };
    if let Some(kept) = [Matrix3::identity(), nearest_permutation(&level)].into_iter().find(follows) {
        return (kept != Matrix3::identity()).then_some(kept);
    }
    let along = along_edges(sole, &level);
    let larger = if exact { LARGER[0] } else { LARGER[1] };
    let frame = if size(&level) <= size(&along) * (1.0 + larger) { level } else { along };
    Some(frame).filter(|frame| (frame - Matrix3::identity()).norm() > ROUNDING)
}

/// Whether x points in the same quadrant as that of another frame.
fn ahead(frame: &Matrix3<f64>, level: &Matrix3<f64>) -> bool {
    frame.column(0).dot(&level.column(0)) > std::f64::consts::FRAC_1_SQRT_2 - 1e-9
}

/// The area (m^2) of the rectangle around spheres along x and y of a frame, or the volume (m^3) of the box.
fn size(balls: &[Ball], frame: &Matrix3<f64>, volume: bool) -> f64 {
    let extent = |axis: usize| {
        let along = |ball: &Ball| ball.centre.dot(&frame.column(axis));
        let high = balls.iter().map(|ball| along(ball) + ball.radius).fold(f64::NEG_INFINITY, f64::max);
        let low = balls.iter().map(|ball| along(ball) - ball.radius).fold(f64::INFINITY, f64::min);
        high - low
    };
    (0..if volume { 3 } else { 2 }).map(extent).product()
}

/// The frame with the same z, and x nearest to that of `level`, along the smallest rectangle around the sole:
/// one side is on an edge of the hull.
fn along_edges(sole: &Sole, level: &Matrix3<f64>) -> Matrix3<f64> {
    let [x, y, z] = [0, 1, 2].map(|axis| Vector3::from(level.column(axis)));
    let seen = sole.balls.iter().map(|ball| nalgebra::Point2::new(ball.centre.dot(&x), ball.centre.dot(&y)));
    let hull = crate::robot::Support::around(seen.collect());
    let corners = hull.corners();
    let edges = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(from, to)| to - from);
    let frames = edges.filter_map(|edge| {
        let along = (x * edge.x + y * edge.y).try_normalize(1e-12)?;
        let quarter = [along, z.cross(&along), -along, -z.cross(&along)];
        let forward = quarter.into_iter().max_by(|a, b| a.dot(&x).total_cmp(&b.dot(&x)))?;
        upright(&z, &forward)
    });
    let smallest = frames.min_by(|a, b| size(&sole.balls, a, false).total_cmp(&size(&sole.balls, b, false)));
    smallest.unwrap_or(*level)
}

/// The angle in rad between unit vectors.
pub(super) fn angle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}
