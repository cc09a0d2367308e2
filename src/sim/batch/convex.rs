//! Convex solids of a robot and of the ground, and the geometry of their points, edges and faces.

use super::figures::ShapeKind;
use super::model::Block;

/// A vector in m.
pub(super) type P = [f64; 3];

/// A shape in the world: centre, axes as columns, size as in [`super::figures::Figures`].
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    pub kind: ShapeKind,
    pub centre: P,
    pub axes: [P; 3],
    pub size: P,
}

/// A contact: halfway between the surfaces, normal out of the ground, distance (negative inside), in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub point: P,
    pub normal: P,
    pub distance: f64,
}

/// Squared lengths below this have no direction.
pub(super) const PARALLEL: f64 = 1e-16;

#[inline]
pub(super) fn add(a: P, b: P) -> P {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
pub(super) fn sub(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(super) fn times(s: f64, a: P) -> P {
    [s * a[0], s * a[1], s * a[2]]
}

/// `s a + b`.
#[inline]
pub(super) fn axpy(s: f64, a: P, b: P) -> P {
    add(times(s, a), b)
}

#[inline]
pub(super) fn dot(a: P, b: P) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(super) fn cross(a: P, b: P) -> P {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(super) fn unit(a: P) -> Option<P> {
    let square = dot(a, a);
    (square > PARALLEL).then(|| times(1.0 / square.sqrt(), a))
}

/// A convex solid of the ground.
pub(super) struct Polytope {
    pub(super) corners: [P; 8],
    pub(super) count: usize,
    pub(super) faces: [Face; 6],
    sides: usize,
    pub(super) edges: [[usize; 2]; 12],
    lines: usize,
}

/// A face: its outward normal and its corners, counter-clockwise from outside.
#[derive(Clone, Copy, Default)]
pub(super) struct Face {
    pub(super) normal: P,
    pub(super) corners: [usize; 4],
    pub(super) count: usize,
}

impl Polytope {
    pub(super) fn block(block: &Block) -> Self {
        let end = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |corner: usize| {
            std::array::from_fn(|axis| block.centre[axis] + end(corner, axis) * block.half[axis])
        };
        let mut faces = [Face::default(); 6];
        for (index, face) in faces.iter_mut().enumerate() {
            let (axis, upper) = (index / 2, index % 2);
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let base = upper << axis;
            face.normal[axis] = if upper == 1 { 1.0 } else { -1.0 };
            face.corners = if upper == 1 {
                [base, base | u, base | u | v, base | v]
            } else {
                [base, base | v, base | u | v, base | u]
            };
            face.count = 4;
        }
        let mut edges = [[0; 2]; 12];
        let pairs = (0..3).flat_map(|axis| {
            (0..8).filter(move |at| at >> axis & 1 == 0).map(move |at| [at, at | 1 << axis])
        });
        edges.iter_mut().zip(pairs).for_each(|(edge, pair)| *edge = pair);
        Self { corners: std::array::from_fn(corner), count: 8, faces, sides: 6, edges, lines: 12 }
    }

    /// The prism between a triangle and a depth.
    pub(super) fn prism(top: &[P; 3], bottom: f64) -> Self {
        let mut corners = [[0.0; 3]; 8];
        for (index, corner) in top.iter().enumerate() {
            corners[index] = *corner;
            corners[3 + index] = [corner[0], corner[1], bottom];
        }
        let mut faces = [Face::default(); 6];
        let up = cross(sub(top[1], top[0]), sub(top[2], top[0]));
        faces[0] = Face { normal: unit(up).unwrap_or([0.0, 0.0, 1.0]), corners: [0, 1, 2, 0], count: 3 };
        faces[1] = Face { normal: [0.0, 0.0, -1.0], corners: [3, 5, 4, 0], count: 3 };
        for side in 0..3 {
            let next = (side + 1) % 3;
            let along = sub(top[next], top[side]);
            let normal = unit([along[1], -along[0], 0.0]).unwrap_or([1.0, 0.0, 0.0]);
            faces[2 + side] = Face { normal, corners: [side, side + 3, next + 3, next], count: 4 };
        }
        let mut edges = [[0; 2]; 12];
        for side in 0..3 {
            edges[side] = [side, (side + 1) % 3];
            edges[3 + side] = [side, side + 3];
            edges[6 + side] = [3 + side, 3 + (side + 1) % 3];
        }
        Self { corners, count: 6, faces, sides: 5, edges, lines: 9 }
    }

    pub(super) fn corners(&self) -> &[P] {
        &self.corners[..self.count]
    }

    pub(super) fn faces(&self) -> &[Face] {
        &self.faces[..self.sides]
    }

    pub(super) fn edges(&self) -> &[[usize; 2]] {
        &self.edges[..self.lines]
    }

    /// The corner that is furthest along a direction.
    pub(super) fn furthest(&self, direction: P) -> P {
        let further =
            |best: P, corner: &P| if dot(*corner, direction) > dot(best, direction) { *corner } else { best };
        self.corners().iter().fold(self.corners[0], further)
    }

    /// The least and the greatest coordinate of its corners along a direction.
    #[inline]
    pub(super) fn range(&self, direction: P) -> [f64; 2] {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in self.corners() {
            let place = dot(*corner, direction);
            if place < range[0] {
                range[0] = place;
            }
            if place > range[1] {
                range[1] = place;
            }
        }
        range
    }

    pub(super) fn contains(&self, point: P) -> bool {
        self.faces().iter().all(|face| dot(face.normal, sub(point, self.corners[face.corners[0]])) <= 0.0)
    }

    /// The nearest point of the surface.
    pub(super) fn nearest(&self, point: P) -> P {
        let mut best = (f64::INFINITY, point);
        for face in self.faces() {
            let at = |index: usize| self.corners[face.corners[index]];
            for last in 2..face.count {
                let candidate = nearest_of_triangle(point, [at(0), at(last - 1), at(last)]);
                let apart = sub(candidate, point);
                if dot(apart, apart) < best.0 {
                    best = (dot(apart, apart), candidate);
                }
            }
        }
        best.1
    }
}

/// The nearest point of a triangle (Ericson, Real-Time Collision Detection, section 5.1.5).
fn nearest_of_triangle(p: P, [a, b, c]: [P; 3]) -> P {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return add(a, times(d1 / (d1 - d3), ab));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return add(a, times(d2 / (d2 - d6), ac));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return add(b, times((d4 - d3) / ((d4 - d3) + (d5 - d6)), sub(c, b)));
    }
    let share = 1.0 / (va + vb + vc);
    add(a, add(times(vb * share, ab), times(vc * share, ac)))
}

/// The closest points of two segments.
pub(super) fn on_lines(one: [P; 2], other: [P; 2]) -> [P; 2] {
    let [s, t] = nearest_places(one, other);
    let at = |[from, to]: [P; 2], place: f64| axpy(place, sub(to, from), from);
    [at(one, s), at(other, t)]
}

/// Parameters of the closest points of two segments, as shares of their lengths (Ericson, section 5.1.9).
pub(super) fn nearest_places([p1, q1]: [P; 2], [p2, q2]: [P; 2]) -> [f64; 2] {
    let (d1, d2, r) = (sub(q1, p1), sub(q2, p2), sub(p1, p2));
    let (a, e, f) = (dot(d1, d1), dot(d2, d2), dot(d2, r));
    let (b, c) = (dot(d1, d2), dot(d1, r));
    let denominator = a * e - b * b;
    let mut s =
        if denominator > PARALLEL * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.5 };
    let mut t = if e > 0.0 { (b * s + f) / e } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = if a > 0.0 { ((b * t - c) / a).clamp(0.0, 1.0) } else { 0.0 };
    }
    [s, t]
}
