//! The contact of a cylinder with a convex solid of the ground.
//!
//! The overlap along a direction is the sum of two support functions. Its minimum is along the normal of a
//! ground face, of a cap, of an edge against the side or the rim, or of a corner against the side; each is
//! tried.

use super::convex::{Hit, P, Polytope, Solid, add, axpy, cross, dot, on_lines, sub, times, unit};

/// Number of directions across an edge that are sampled before the best one is refined.
const DIRECTIONS: usize = 24;
/// Iterations of the golden-section search: until the minimum is exact up to rounding.
const REFINEMENTS: usize = 40;
/// Ratio of the golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Sine below which a direction counts as parallel to the cylinder's axis.
const ALONG: f64 = 1e-9;

/// Heights closer than this are equal, in m.
const SAME: f64 = 1e-9;

/// The feature of the ground that touches the cylinder, which determines the point of contact.
#[derive(Clone, Copy)]
enum Feature {
    /// A face, or an edge against the rim: the contact is at the deepest point of the cylinder.
    Cylinder,
    /// A corner, or anything against a cap: the contact is at the highest point of the ground.
    Corner,
    /// An edge against the side: the contact is where the edge passes the axis.
    Side([P; 2]),
}

/// The directions tried so far, and the one with the least overlap.
struct Search<'a> {
    solid: &'a Solid,
    ground: &'a Polytope,
    least: Option<(f64, P, Feature)>,
}

impl Search<'_> {
    /// The overlap along a unit vector out of the ground.
    fn overlap(&self, normal: P) -> f64 {
        dot(self.ground.furthest(normal), normal) - dot(self.solid.centre, normal) + self.solid.reach(normal)
    }

    /// Tries a direction; returns false if the two are separated along it.
    fn offer(&mut self, normal: Option<P>, feature: Feature) -> bool {
        let Some(normal) = normal else { return true };
        let depth = self.overlap(normal);
        if depth > 0.0 && self.least.is_none_or(|(least, ..)| depth < least) {
            self.least = Some((depth, normal, feature));
        }
        depth > 0.0
    }

    /// The best direction across an edge against the rim, including that orthogonal to the axis.
    fn across(&self, along: P, outwards: P) -> Option<P> {
        let other = cross(along, outwards);
        let at = |angle: f64| add(times(libm::cos(angle), outwards), times(libm::sin(angle), other));
        let step = std::f64::consts::TAU / DIRECTIONS as f64;
        let overlaps: Vec<f64> = (0..DIRECTIONS).map(|index| self.overlap(at(step * index as f64))).collect();
        let best = (1..DIRECTIONS)
            .fold(0, |best, index| if overlaps[index] < overlaps[best] { index } else { best });
        let (mut low, mut high) = (step * (best as f64 - 1.0), step * (best as f64 + 1.0));
        for _ in 0..REFINEMENTS {
            let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            if self.overlap(at(left)) < self.overlap(at(right)) {
                high = right;
            } else {
                low = left;
            }
        }
        unit(at(0.5 * (low + high)))
    }
}

/// The contact of a cylinder, along the direction of least overlap with the ground.
pub(super) fn meets(solid: &Solid, ground: &Polytope) -> Option<Hit> {
    let axis = solid.axes[2];
    let mut search = Search { solid, ground, least: None };
    for face in ground.faces() {
        if !search.offer(Some(face.normal), Feature::Cylinder) {
            return None;
        }
    }
    for normal in [axis, times(-1.0, axis)] {
        if !search.offer(Some(normal), Feature::Corner) {
            return None;
        }
    }
    for corner in ground.corners() {
        let from = sub(solid.centre, *corner);
        let side = axpy(-dot(from, axis), axis, from);
        // If the two are separated, a corner may be nearest to the rim or a cap.
        let nearest = sub(solid.nearest(*corner), *corner);
        if !search.offer(unit(side), Feature::Corner) || !search.offer(unit(nearest), Feature::Corner) {
            return None;
        }
    }
    for edge in ground.edges() {
        let ends = edge.map(|corner| ground.corners()[corner]);
        let Some(along) = unit(sub(ends[1], ends[0])) else { continue };
        let Some(normal) = unit(cross(axis, along)) else { continue };
        for normal in [normal, times(-1.0, normal)] {
            if search.overlap(normal) <= 0.0 {
                return None;
            }
            // Parallel edges share their directions; the outermost one touches.
            if dot(ground.furthest(normal), normal) <= dot(ends[0], normal) + SAME {
                search.offer(Some(normal), Feature::Side(ends));
            }
        }
        if !search.offer(search.across(along, normal), Feature::Cylinder) {
            return None;
        }
    }
    let (depth, normal, feature) = search.least?;
    let half = times(solid.size[1], axis);
    let point = match feature {
        Feature::Cylinder => axpy(0.5 * depth, normal, solid.lowest(normal)),
        Feature::Corner => axpy(-0.5 * depth, normal, ground.furthest(normal)),
        Feature::Side(edge) => {
            let line = [sub(solid.centre, half), add(solid.centre, half)];
            axpy(-0.5 * depth, normal, on_lines(line, edge)[1])
        }
    };
    Some(Hit { point, normal, distance: -depth })
}

impl Solid {
    /// Extent of the cylinder from its centre along a unit vector, in m.
    fn reach(&self, normal: P) -> f64 {
        let [radius, half, _] = self.size;
        let along = dot(self.axes[2], normal);
        half * along.abs() + radius * (1.0 - along * along).max(0.0).sqrt()
    }

    /// The point of the cylinder that is furthest against a unit vector; for a cap that faces it, the cap's
    /// centre.
    fn lowest(&self, normal: P) -> P {
        let [radius, half, _] = self.size;
        let axis = self.axes[2];
        let along = dot(axis, normal);
        let across = axpy(-along, axis, normal);
        let end = axpy(if along > 0.0 { -half } else { half }, axis, self.centre);
        let length = dot(across, across).sqrt();
        if length < ALONG { end } else { axpy(-radius / length, across, end) }
    }

    /// The point of the cylinder that is nearest to a point; the point itself if it is inside.
    fn nearest(&self, point: P) -> P {
        let [radius, half, _] = self.size;
        let axis = self.axes[2];
        let from = sub(point, self.centre);
        let along = dot(from, axis);
        let across = axpy(-along, axis, from);
        let length = dot(across, across).sqrt();
        let across = if length > radius { times(radius / length, across) } else { across };
        add(self.centre, axpy(along.clamp(-half, half), axis, across))
    }
}
