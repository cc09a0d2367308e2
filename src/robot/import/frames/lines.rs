//! Joints as lines: the position of a joint's origin along its axis is arbitrary and does not change the
//! robot.
//!
//! Finds the plane in which the axes of both legs mirror each other when their origins do not, and moves
//! origins along the axes until they do. Works in the file's base frame, joints at zero.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::super::welded::Welded;
use super::legs::Legs;
use super::turn;
use crate::robot::symmetry::TOLERANCE;

/// Minimum length of the sum or difference of two unit axes to define a direction.
const PARALLEL: f64 = 0.1;
/// Tolerance of mirrored points, relative to their distance: soles and masses are less precise than joints.
const PLACES: f64 = 0.25;

/// A plane of symmetry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Unit normal, from the second leg to the first one.
    pub normal: Vector3<f64>,
    /// Distance from the origin along the normal in m.
    offset: f64,
    /// Largest deviation of an axis, in m or as the difference of unit vectors.
    miss: f64,
}

impl Plane {
    fn image(&self, place: &Vector3<f64>) -> Vector3<f64> {
        place - self.normal * (2.0 * (place.dot(&self.normal) - self.offset))
    }
}

/// The joints of both legs from the hips down, as pairs that should mirror each other.
fn pairs(legs: &Legs) -> impl Iterator<Item = [usize; 2]> {
    legs.own[0].iter().zip(&legs.own[1]).map(|(first, second)| [*first, *second])
}

/// The plane in which the axes of the legs' joints mirror each other. `places` are pairs of points that
/// certainly mirror each other, such as the middles of both soles.
pub(super) fn plane(legs: &Legs, places: &[[Vector3<f64>; 2]]) -> Option<Plane> {
    if legs.own[0].len() != legs.own[1].len() || places.is_empty() {
        return None;
    }
    let mut normals: Vec<Vector3<f64>> = Vec::new();
    for [first, second] in pairs(legs) {
        let (u, v) = (legs.axes[first], legs.axes[second]);
        normals.extend([u - v, u + v].into_iter().filter(|normal| normal.norm() > PARALLEL));
    }
    normals.extend(places.iter().map(|[first, second]| first - second));
    let way: Vector3<f64> = places.iter().map(|[first, second]| first - second).sum();
    let towards = |normal: Vector3<f64>| {
        let normal = normal.try_normalize(1e-3)?;
        Some(if normal.dot(&way) < 0.0 { -normal } else { normal })
    };
    let planes = normals.into_iter().filter_map(towards).filter_map(|normal| mirrored(legs, places, normal));
    planes.min_by(|a, b| a.miss.total_cmp(&b.miss))
}

/// The plane with this normal, if the legs' axes mirror each other in it.
fn mirrored(legs: &Legs, places: &[[Vector3<f64>; 2]], normal: Vector3<f64>) -> Option<Plane> {
    let point = |joint: usize| legs.straight[joint].translation.vector;
    let reflected = |vector: Vector3<f64>| vector - normal * (2.0 * vector.dot(&normal));
    let mut miss: f64 = 0.0;
    // For each pair: the vector from the first axis's image, in a plane through the origin, to the second
    // axis, perpendicular to it; and its change per unit of the plane's offset.
    let mut ways: Vec<[Vector3<f64>; 2]> = Vec::new();
    for [first, second] in pairs(legs) {
        let (image, axis) = (reflected(legs.axes[first]), legs.axes[second]);
        miss = miss.max((image * image.dot(&axis).signum() - axis).norm());
        let across = |vector: Vector3<f64>| vector - axis * vector.dot(&axis);
        ways.push([across(point(second) - reflected(point(first))), across(normal * 2.0)]);
    }
    let told: f64 = ways.iter().map(|[_, shift]| shift.norm_squared()).sum();
    let offset = if told > 1e-2 {
        ways.iter().map(|[way, shift]| way.dot(shift)).sum::<f64>() / told
    } else {
        // Pitch joints alone do not determine the offset.
        let middle = |a: Vector3<f64>, b: Vector3<f64>| 0.5 * (a + b).dot(&normal);
        let own: Vec<f64> = pairs(legs).map(|[first, second]| middle(point(first), point(second))).collect();
        let known: Vec<f64> = places.iter().map(|[first, second]| middle(*first, *second)).collect();
        agreed(&own).unwrap_or_else(|| known.iter().sum::<f64>() / known.len() as f64)
    };
    let misses = ways.iter().map(|[way, shift]| (way - shift * offset).norm());
    let plane = Plane { normal, offset, miss: misses.fold(miss, f64::max) };
    let sides = places.iter().all(|[first, second]| {
        (plane.image(first) - second).norm() <= PLACES * (first - second).norm().max(4.0 * TOLERANCE)
    });
    (plane.miss < TOLERANCE && sides).then_some(plane)
}

/// The mean of the largest group of similar numbers, if it is a majority.
fn agreed(numbers: &[f64]) -> Option<f64> {
    let near =
        |number: f64| numbers.iter().copied().filter(move |other| (other - number).abs() < 0.5 * TOLERANCE);
    let most = numbers.iter().copied().max_by_key(|number| near(*number).count())?;
    let count = near(most).count();
    (2 * count > numbers.len()).then(|| near(most).sum::<f64>() / count as f64)
}

/// Moves the origins of the legs' joints along their axes until each pair mirrors each other; returns a
/// remark. Of a pair, the joint that is further from its neighbours moves.
pub(super) fn slide(
    welded: &mut Welded,
    legs: &Legs,
    soles: [Option<Vector3<f64>>; 2],
    plane: &Plane,
) -> Option<String> {
    let mut points: Vec<Vector3<f64>> = legs.straight.iter().map(|pose| pose.translation.vector).collect();
    let mut slid = Vec::new();
    for pair in pairs(legs) {
        let [first, second] = pair;
        let images = [plane.image(&points[second]), plane.image(&points[first])];
        let by = [0, 1].map(|side| (images[side] - points[pair[side]]).dot(&legs.axes[pair[side]]));
        if by[1].abs() < TOLERANCE {
            continue;
        }
        let away = |side: usize| {
            let joint = pair[side];
            let parent = welded.links[joint].parent.map(|parent| points[parent]);
            let children = welded.links.iter().enumerate().filter(|(_, link)| link.parent == Some(joint));
            let sole = soles[side].filter(|_| joint == legs.feet[side]);
            let neighbours = children.map(|(child, _)| points[child]).chain(parent).chain(sole);
            neighbours.map(|place| (place - points[joint]).dot(&legs.axes[joint]).abs()).sum::<f64>()
        };
        let side = usize::from(away(1) > away(0));
        let joint = [first, second][side];
        let shift =
            welded.links[joint].hinge.axis.map_or(Vector3::zeros(), |axis| axis.into_inner() * by[side]);
        let frame = Isometry3::from(Translation3::from(shift));
        turn::express(&mut welded.links[joint].body, &frame);
        welded.links[joint].origin *= frame;
        let back = frame.inverse();
        for child in welded.links.iter_mut().filter(|child| child.parent == Some(joint)) {
            child.origin = back * child.origin;
        }
        points[joint] += legs.axes[joint] * by[side];
        slid.push(format!("`{}` by {:.1} mm", welded.links[joint].hinge.name, 1e3 * by[side].abs()));
    }
    (!slid.is_empty()).then(|| {
        format!(
            "origins of joints were moved along their own axes, so that left and right mirror each other: {}",
            slid.join(", ")
        )
    })
}
