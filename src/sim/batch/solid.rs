//! Contacts of one shape of one robot with boxes and height fields.
//!
//! A height field is a prism below each of its triangles, as in MuJoCo. Each prism has one contact with a
//! shape, along the direction in which the two overlap least; a box has contacts at all corners of the
//! overlap of the touching faces.
//!
//! MuJoCo 3.14 to 3.17 finds the same contacts with a field only if the geoms have a margin. Without one, its
//! search for the least overlap of a box and a prism stops early: it mistakes a new corner of the box for one
//! that it has already visited, because the prism's corners have no index (`mjc_prism_support`,
//! `engine_collision_convex.c`).

use super::convex::{
    Face, Hit, P, PARALLEL, Polytope, Solid, add, axpy, cross, dot, nearest_places, on_lines, sub, times,
    unit,
};
use super::cylinder;
use super::figures::ShapeKind;
use super::model::{Block, Field, Ground};

/// Cosine of the angle within which an edge's direction counts as that of a face, and the share of the depth
/// within which it does not count as better.
const ALIKE: f64 = 0.99;
const HARDLY: f64 = 0.05;
/// Margin in m, far above rounding, from which on depths along directions of any length decide.
const SURE: f64 = 1e-9;
/// Margin in m by which an edge must be better than a face to be chosen; smaller differences are rounding.
const HAIR: f64 = 1e-10;

/// Whether a sphere may touch a box or the field (broad phase).
pub fn near(ground: &Ground, centre: P, radius: f64) -> bool {
    let block = |block: &Block| {
        let beyond: P =
            std::array::from_fn(|i| ((centre[i] - block.centre[i]).abs() - block.half[i]).max(0.0));
        dot(beyond, beyond) < radius * radius
    };
    let field = |field: &Field| {
        let [x, y] = field.half();
        centre[0].abs() < x + radius && centre[1].abs() < y + radius && centre[2] - radius < field.top()
    };
    ground.boxes.iter().any(block) || ground.field.as_ref().is_some_and(field)
}

/// The contacts of a shape.
pub fn collide(solid: &Solid, ground: &Ground, hits: &mut Vec<Hit>) {
    for block in &ground.boxes {
        meet(solid, &Polytope::block(block), Manifold::Face, hits);
    }
    if let Some(field) = &ground.field {
        prisms(solid, field, hits);
    }
}

/// Number of contacts of a pair.
#[derive(Clone, Copy, PartialEq)]
enum Manifold {
    /// The deepest one.
    Point,
    /// All corners of the overlap of two faces.
    Face,
}

/// The prisms below a shape.
fn prisms(solid: &Solid, field: &Field, hits: &mut Vec<Hit>) {
    let reach: P = std::array::from_fn(|axis| solid.extent(axis));
    let [low, high] = [sub(solid.centre, reach), add(solid.centre, reach)];
    let half = field.half();
    let cells = |axis: usize| {
        let last = field.counts[axis] - 1;
        let first = ((low[axis] + half[axis]) / field.cell).floor().max(0.0) as usize;
        let end = ((high[axis] + half[axis]) / field.cell).ceil().max(0.0) as usize;
        first.min(last)..end.min(last)
    };
    for column in cells(1) {
        for row in cells(0) {
            for upper in [false, true] {
                let triangle = field.triangle(row, column, upper);
                if triangle.iter().any(|corner| corner[2] >= low[2]) {
                    meet(solid, &Polytope::prism(&triangle, field.bottom), Manifold::Point, hits);
                }
            }
        }
    }
}

impl Field {
    /// The triangle of a cell in which y is ahead of x, or the other one, counter-clockwise from above.
    fn triangle(&self, row: usize, column: usize, upper: bool) -> [P; 3] {
        let half = self.half();
        let at = |row: usize, column: usize| {
            let height = self.heights[row * self.counts[1] + column];
            [row as f64 * self.cell - half[0], column as f64 * self.cell - half[1], height]
        };
        let (low, high) = (at(row, column), at(row + 1, column + 1));
        if upper { [low, high, at(row, column + 1)] } else { [low, at(row + 1, column), high] }
    }
}

impl Solid {
    /// Half its extent along a world axis.
    fn extent(&self, axis: usize) -> f64 {
        let [x, y, z] = self.axes.map(|column| column[axis].abs());
        match self.kind {
            ShapeKind::Box => x * self.size[0] + y * self.size[1] + z * self.size[2],
            ShapeKind::Capsule => z * self.size[1] + self.size[0],
            ShapeKind::Cylinder => z * self.size[1] + self.size[0],
            ShapeKind::Sphere => self.size[0],
        }
    }
}

fn meet(solid: &Solid, ground: &Polytope, manifold: Manifold, hits: &mut Vec<Hit>) {
    match solid.kind {
        ShapeKind::Box => box_meets(solid, ground, manifold, hits),
        ShapeKind::Sphere => hits.extend(ball_meets(solid.centre, solid.size[0], ground)),
        ShapeKind::Capsule => capsule_meets(solid, ground, manifold, hits),
        ShapeKind::Cylinder => hits.extend(cylinder::meets(solid, ground)),
    }
}

/// A sphere: the contact is along the line from the nearest point of the surface.
fn ball_meets(centre: P, radius: f64, ground: &Polytope) -> Option<Hit> {
    let nearest = ground.nearest(centre);
    let apart = sub(centre, nearest);
    let length = dot(apart, apart).sqrt();
    let inside = ground.contains(centre);
    let distance = if inside { -length - radius } else { length - radius };
    if distance >= 0.0 {
        return None;
    }
    let direction = unit(apart).map(|n| if inside { times(-1.0, n) } else { n });
    let normal = direction.unwrap_or([0.0, 0.0, 1.0]);
    Some(Hit { point: add(nearest, times(0.5 * distance, normal)), normal, distance })
}

/// A capsule: the contact is at the point of its centre line that is nearest to the ground; with a face
/// manifold also at the other end. A line that is in the ground leaves it along the direction of least
/// overlap.
fn capsule_meets(solid: &Solid, ground: &Polytope, manifold: Manifold, hits: &mut Vec<Hit>) {
    let [radius, half, _] = solid.size;
    let along = times(half, solid.axes[2]);
    let ends = [add(solid.centre, along), sub(solid.centre, along)];
    let other = if let Some([overlap, _]) = least_overlaps(solid, [[0.0; 3], [0.0; 3], along], ground) {
        let end = if dot(along, overlap.normal) > 0.0 { 1 } else { 0 };
        let point = match overlap.feature {
            Feature::Edges(_, line) => {
                on_lines(ends, ground.edges[line].map(|corner| ground.corners[corner]))[0]
            }
            Feature::Ground(_) | Feature::Own => ends[end],
        };
        let middle = axpy(0.5 * (overlap.depth - radius), overlap.normal, point);
        hits.push(Hit { point: middle, normal: overlap.normal, distance: -overlap.depth - radius });
        ends[1 - end]
    } else {
        let mut best: Option<(f64, Hit)> = None;
        let mut offer = |place: f64, hit: Option<Hit>| {
            if let Some(hit) =
                hit.filter(|hit| best.as_ref().is_none_or(|(_, best)| hit.distance < best.distance))
            {
                best = Some((place, hit));
            }
        };
        for (place, end) in [1.0, -1.0].into_iter().zip(ends) {
            offer(place, ball_meets(end, radius, ground));
        }
        // Between the ends: where the line crosses an edge.
        for [from, to] in ground.edges() {
            let (from, to) = (ground.corners[*from], ground.corners[*to]);
            let place = nearest_places([ends[1], ends[0]], [from, to])[0];
            if place > 0.0 && place < 1.0 {
                let point = add(ends[1], times(place, sub(ends[0], ends[1])));
                offer(2.0 * place - 1.0, ball_meets(point, radius, ground));
            }
        }
        let Some((place, hit)) = best else { return };
        hits.push(hit);
        if place > 0.0 { ends[1] } else { ends[0] }
    };
    if manifold == Manifold::Face {
        hits.extend(ball_meets(other, radius, ground));
    }
}

/// The features that define the direction of an overlap.
#[derive(Clone, Copy)]
enum Feature {
    /// A face of the ground.
    Ground(usize),
    /// A face of the box.
    Own,
    /// An axis of the box and an edge of the ground.
    Edges(usize, usize),
}

/// The least overlap of two solids: depth, normal out of the ground, and features.
#[derive(Clone, Copy)]
struct Overlap {
    depth: f64,
    normal: P,
    feature: Feature,
}

/// The least overlap of a box with the ground (separating axis theorem) and the least one along a face
/// normal; `None` if they are separated. A box without extent along some of its axes is a line or a plate.
fn least_overlaps(solid: &Solid, arms: [P; 3], ground: &Polytope) -> Option<[Overlap; 2]> {
    // Depths along a direction and against it.
    let depths = |normal: P, [low, high]: [f64; 2]| {
        let reach: f64 = arms.iter().map(|arm| dot(*arm, normal).abs()).sum();
        let centre = dot(solid.centre, normal);
        [high - (centre - reach), -low - (-centre - reach)]
    };
    let mut best = Overlap { depth: f64::INFINITY, normal: [0.0; 3], feature: Feature::Own };
    for (index, face) in ground.faces().iter().enumerate() {
        let [depth, _] = depths(face.normal, ground.range(face.normal));
        if depth <= 0.0 {
            return None;
        }
        if depth < best.depth - HAIR {
            best = Overlap { depth, normal: face.normal, feature: Feature::Ground(index) };
        }
    }
    for axis in solid.axes {
        for (normal, depth) in [axis, times(-1.0, axis)].into_iter().zip(depths(axis, ground.range(axis))) {
            if depth <= 0.0 {
                return None;
            }
            if depth < best.depth - HAIR {
                best = Overlap { depth, normal, feature: Feature::Own };
            }
        }
    }
    let face = best;
    for (line, [from, to]) in ground.edges().iter().enumerate() {
        let raw = sub(ground.corners[*to], ground.corners[*from]);
        for (index, axis) in solid.axes.iter().enumerate() {
            let crossed = cross(*axis, raw);
            match compared(depths(crossed, ground.range(crossed)), crossed, raw, best.depth) {
                Compared::Apart => return None,
                Compared::Deeper => continue,
                Compared::Close => {}
            }
            let Some(along) = unit(raw) else { continue };
            let Some(normal) = unit(cross(*axis, along)) else { continue };
            let (range, line_at) = (ground.range(normal), dot(ground.corners[*from], normal));
            // Whether no corner lies beyond the edge.
            let supports = [range[1] <= line_at + 1e-9, -range[0] <= -line_at + 1e-9];
            let both = [normal, times(-1.0, normal)].into_iter().zip(depths(normal, range));
            for ((normal, depth), supports) in both.zip(supports) {
                if depth <= 0.0 {
                    return None;
                }
                if supports && depth < best.depth - HAIR {
                    best = Overlap { depth, normal, feature: Feature::Edges(index, line) };
                }
            }
        }
    }
    Some([best, face])
}

/// What depths along a direction and against it tell without the root and the divisions of a unit vector.
enum Compared {
    /// The solids are separated.
    Apart,
    /// Both depths are greater than the least one so far.
    Deeper,
    /// Neither is certain.
    Close,
}

/// Compares depths along `direction`, which is orthogonal to the edge `raw` and has a length of its own.
fn compared(depths: [f64; 2], direction: P, raw: P, least: f64) -> Compared {
    let (square, length) = (dot(direction, direction), dot(raw, raw));
    // No direction, or nearly none, is left to the vectors of unit length.
    if length <= PARALLEL || square < 1e3 * PARALLEL * length {
        return Compared::Close;
    }
    let is_beyond = |depth: f64, bound: f64| depth * depth > bound * bound * square;
    if depths.iter().any(|depth| *depth < 0.0 && is_beyond(*depth, SURE)) {
        Compared::Apart
    } else if depths.iter().all(|depth| *depth > 0.0 && is_beyond(*depth, least + SURE)) {
        Compared::Deeper
    } else {
        Compared::Close
    }
}

/// A box: the contact is along the direction of least overlap.
fn box_meets(solid: &Solid, ground: &Polytope, manifold: Manifold, hits: &mut Vec<Hit>) {
    let arms: [P; 3] = std::array::from_fn(|axis| times(solid.size[axis], solid.axes[axis]));
    let Some([best, face]) = least_overlaps(solid, arms, ground) else { return };
    // Like MuJoCo's boxes: a face has several points, so it is preferred if an edge along nearly the same
    // direction is only slightly better (`mjc_BoxBox`, `engine_collision_box.c`).
    let is_face = manifold == Manifold::Face
        && dot(best.normal, face.normal) > ALIKE
        && best.depth > (1.0 - HARDLY) * face.depth;
    let Overlap { depth, normal, feature } = if is_face { face } else { best };
    let lowest = |skip: usize| {
        (0..3).filter(|axis| *axis != skip).fold(solid.centre, |point, axis| {
            let down = if dot(arms[axis], normal) > 0.0 { -1.0 } else { 1.0 };
            add(point, times(down, arms[axis]))
        })
    };
    let middle = |point: P, side: f64| Hit {
        point: add(point, times(0.5 * side * depth, normal)),
        normal,
        distance: -depth,
    };
    match feature {
        Feature::Edges(index, line) => {
            let point = lowest(index);
            let own = [sub(point, arms[index]), add(point, arms[index])];
            let edge = ground.edges[line].map(|corner| ground.corners[corner]);
            let [a, b] = on_lines(own, edge);
            hits.push(Hit { point: times(0.5, add(a, b)), normal, distance: -depth });
        }
        Feature::Ground(index) if manifold == Manifold::Face => {
            let face = &ground.faces[index];
            let reference: Vec<P> =
                face.corners[..face.count].iter().map(|corner| ground.corners[*corner]).collect();
            overlap_of_faces(&reference, normal, &own_face(solid, &arms, normal), 1.0, hits);
        }
        Feature::Own if manifold == Manifold::Face => {
            let reference = own_face(solid, &arms, normal);
            let against = |face: &Face| dot(face.normal, normal);
            let incident = ground.faces().iter().max_by(|a, b| against(a).total_cmp(&against(b)));
            if let Some(face) = incident {
                let incident: Vec<P> =
                    face.corners[..face.count].iter().map(|corner| ground.corners[*corner]).collect();
                overlap_of_faces(&reference, normal, &incident, -1.0, hits);
            }
        }
        Feature::Ground(_) | Feature::Own => {
            let own = own_face(solid, &arms, normal);
            let top = &ground.faces[0];
            let along = |a: P, b: P| dot(a, b).abs() > 1.0 - 1e-12;
            let lies = solid.axes.iter().any(|axis| along(*axis, normal)) && along(top.normal, normal);
            let single = match feature {
                Feature::Ground(_) => middle(lowest(3), 1.0),
                _ => middle(ground.furthest(normal), -1.0),
            };
            // Two touching faces have no deepest point: the middle of their overlap is used.
            let corners: Vec<P> =
                top.corners[..top.count].iter().map(|corner| ground.corners[*corner]).collect();
            let mut shared = Vec::new();
            if lies {
                overlap_of_faces(&corners, normal, &own, 1.0, &mut shared);
            }
            let share = 1.0 / shared.len() as f64;
            let sum = shared.iter().fold([0.0; 3], |sum, hit| add(sum, hit.point));
            hits.push(if shared.is_empty() { single } else { Hit { point: times(share, sum), ..single } });
        }
    }
}

/// The face of a box whose normal is most opposed to a direction.
fn own_face(solid: &Solid, arms: &[P; 3], normal: P) -> Vec<P> {
    let against = |axis: usize| dot(solid.axes[axis], normal).abs();
    let axis = (1..3).fold(0, |best, axis| if against(axis) > against(best) { axis } else { best });
    let side = if dot(solid.axes[axis], normal) > 0.0 { -1.0 } else { 1.0 };
    let centre = add(solid.centre, times(side, arms[axis]));
    let (u, v) = (arms[(axis + 1) % 3], arms[(axis + 2) % 3]);
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(a, b)| add(centre, add(times(a, u), times(b, v))))
        .to_vec()
}

/// Contacts at the corners of one face clipped by the sides of another (Sutherland and Hodgman 1974). The
/// reference face belongs to the ground (`side` 1) or to the box (-1); the normal points out of the ground.
fn overlap_of_faces(reference: &[P], normal: P, incident: &[P], side: f64, hits: &mut Vec<Hit>) {
    let middle =
        times(1.0 / reference.len() as f64, reference.iter().fold([0.0; 3], |sum, corner| add(sum, *corner)));
    let mut clipped = incident.to_vec();
    for (index, from) in reference.iter().enumerate() {
        let to = reference[(index + 1) % reference.len()];
        let mut inwards = cross(normal, sub(to, *from));
        if dot(inwards, sub(middle, *from)) < 0.0 {
            inwards = times(-1.0, inwards);
        }
        let height = |point: &P| dot(inwards, sub(*point, *from));
        let mut kept = Vec::with_capacity(clipped.len() + 1);
        for (index, point) in clipped.iter().enumerate() {
            let next = clipped[(index + 1) % clipped.len()];
            let (here, there) = (height(point), height(&next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(add(*point, times(here / (here - there), sub(next, *point))));
            }
        }
        clipped = kept;
    }
    for point in clipped {
        let depth = side * dot(normal, sub(reference[0], point));
        if depth > 0.0 {
            hits.push(Hit { point: add(point, times(0.5 * side * depth, normal)), normal, distance: -depth });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upright(kind: ShapeKind, centre: P, size: P) -> Solid {
        Solid { kind, centre, axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], size }
    }

    fn hits(solid: &Solid, ground: &Ground) -> Vec<Hit> {
        let mut hits = Vec::new();
        collide(solid, ground, &mut hits);
        hits
    }

    fn block() -> Ground {
        let block = Block { centre: [0.0, 0.0, 0.5], half: [1.0, 2.0, 0.5] };
        Ground { boxes: vec![block], ..Ground::default() }
    }

    #[test]
    fn a_box_on_a_box_has_the_corners_of_what_they_share() {
        let found = hits(&upright(ShapeKind::Box, [1.0, 0.0, 1.09], [0.2, 0.1, 0.1]), &block());
        assert_eq!(found.len(), 4);
        for hit in &found {
            assert!((hit.distance + 0.01).abs() < 1e-12 && hit.normal == [0.0, 0.0, 1.0], "{hit:?}");
            assert!((hit.point[2] - 0.995).abs() < 1e-12, "{hit:?}");
        }
        let reach = found.iter().map(|hit| hit.point[0]).fold(f64::NEG_INFINITY, f64::max);
        assert!((reach - 1.0).abs() < 1e-12, "the part beyond the edge hangs in the air");
        assert!(hits(&upright(ShapeKind::Box, [1.0, 0.0, 1.11], [0.2, 0.1, 0.1]), &block()).is_empty());
    }

    #[test]
    fn a_sphere_and_a_capsule_touch_a_box_along_the_shortest_line() {
        let found = hits(&upright(ShapeKind::Sphere, [1.06, 0.0, 1.08], [0.11, 0.0, 0.0]), &block());
        assert_eq!(found.len(), 1);
        assert!((found[0].distance + 0.01).abs() < 1e-12);
        assert!((found[0].normal[0] - 0.6).abs() < 1e-12 && (found[0].normal[2] - 0.8).abs() < 1e-12);
        let lying = Solid {
            axes: [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
            ..upright(ShapeKind::Capsule, [0.0, 0.0, 1.05], [0.06, 0.3, 0.0])
        };
        let found = hits(&lying, &block());
        assert_eq!(found.len(), 2, "both ends");
        assert!(found.iter().all(|hit| (hit.distance + 0.01).abs() < 1e-12));
    }

    /// The least overlaps by unit vectors alone: every direction, one after the other.
    fn plainly(solid: &Solid, arms: [P; 3], ground: &Polytope) -> Option<[Overlap; 2]> {
        let overlap = |normal: P| {
            let reach: f64 = arms.iter().map(|arm| dot(*arm, normal).abs()).sum();
            dot(ground.furthest(normal), normal) - (dot(solid.centre, normal) - reach)
        };
        let both = |normal: P| [normal, times(-1.0, normal)];
        let of_ground =
            ground.faces().iter().enumerate().map(|(index, face)| (face.normal, Feature::Ground(index)));
        let own = solid.axes.into_iter().flat_map(both).map(|normal| (normal, Feature::Own));
        let mut best = Overlap { depth: f64::INFINITY, normal: [0.0; 3], feature: Feature::Own };
        for (normal, feature) in of_ground.chain(own) {
            let depth = overlap(normal);
            if depth <= 0.0 {
                return None;
            }
            if depth < best.depth - HAIR {
                best = Overlap { depth, normal, feature };
            }
        }
        let face = best;
        for (line, edge) in ground.edges().iter().enumerate() {
            let [from, to] = edge.map(|corner| ground.corners[corner]);
            let Some(along) = unit(sub(to, from)) else { continue };
            for (index, axis) in solid.axes.iter().enumerate() {
                let Some(normal) = unit(cross(*axis, along)) else { continue };
                for normal in both(normal) {
                    let depth = overlap(normal);
                    if depth <= 0.0 {
                        return None;
                    }
                    let supports = dot(ground.furthest(normal), normal) <= dot(from, normal) + 1e-9;
                    if supports && depth < best.depth - HAIR {
                        best = Overlap { depth, normal, feature: Feature::Edges(index, line) };
                    }
                }
            }
        }
        Some([best, face])
    }

    #[test]
    fn what_is_skipped_changes_no_bit_of_an_overlap() {
        let mut stream = crate::stream::Stream::new("test/least_overlaps");
        let mut number = |scale: f64| scale * stream.normal();
        let [mut apart, mut by_edges] = [0, 0];
        for round in 0..4000 {
            let along = if round % 4 == 0 { [0.0, 0.0, 1.0] } else { [number(0.1), number(0.1), 1.0] };
            let z = unit(along).expect("it points up");
            let x = unit(cross([0.0, 1.0, 0.0], z)).expect("it is not along y");
            let axes = [x, cross(z, x), z];
            let centre = [number(0.1), number(0.1), 0.01 + number(0.02)];
            let solid = Solid { kind: ShapeKind::Box, centre, axes, size: [0.15, 0.08, 0.014] };
            let arms: [P; 3] = std::array::from_fn(|axis| times(solid.size[axis], solid.axes[axis]));
            let mut relief = || number(if round % 3 == 0 { 0.0 } else { 0.01 });
            let top = [[0.0, 0.0, relief()], [0.1, 0.0, relief()], [0.1, 0.1, relief()]];
            let ground = Polytope::prism(&top, -0.1);
            let bits = |found: Option<[Overlap; 2]>| {
                found.map(|both| both.map(|one| (one.depth.to_bits(), one.normal.map(f64::to_bits))))
            };
            let found = least_overlaps(&solid, arms, &ground);
            apart += usize::from(found.is_none());
            by_edges +=
                usize::from(found.is_some_and(|[best, _]| matches!(best.feature, Feature::Edges(..))));
            assert_eq!(bits(found), bits(plainly(&solid, arms, &ground)), "{solid:?} {top:?}");
        }
        assert!(apart > 400 && by_edges > 40, "every case occurs: {apart} {by_edges}");
    }

    #[test]
    fn a_flat_field_carries_a_box_corner_by_corner() {
        let field = Field::new(0.1, [5, 5], vec![0.2; 25], -0.1);
        let ground = Ground { field: Some(field), ..Ground::default() };
        // The sole is tilted slightly so that each prism has a lowest corner.
        let found = hits(&upright(ShapeKind::Box, [0.01, 0.02, 0.24], [0.04, 0.03, 0.05]), &ground);
        assert!(!found.is_empty());
        for hit in &found {
            assert!(hit.distance < 0.0 && hit.distance > -0.05, "{hit:?}");
        }
        assert!(hits(&upright(ShapeKind::Box, [0.01, 0.02, 0.26], [0.04, 0.03, 0.05]), &ground).is_empty());
        let ball = hits(&upright(ShapeKind::Sphere, [0.03, 0.01, 0.24], [0.05, 0.0, 0.0]), &ground);
        assert!(
            ball.iter().any(|hit| (hit.distance + 0.01).abs() < 1e-12 && hit.normal[2] > 0.999),
            "{ball:?}"
        );
    }
}

/// Comparison with MuJoCo: a free shape over a height field, in random poses.
#[cfg(all(test, feature = "mujoco"))]
mod against_mujoco {
    use mujoco_rs::prelude::{MjData, MjModel};

    use super::*;
    use crate::stream::Stream;

    /// Random heights in m over 5 x 5 points, 0.1 m apart.
    fn heights() -> Vec<f64> {
        let mut stream = Stream::new("test/batch/solid");
        (0..25).map(|_| 0.05 * f64::from((stream.uniform() * 64.0) as u32) / 64.0).collect()
    }

    /// MuJoCo's height field with these heights.
    fn field(heights: &[f64], margin: f64) -> String {
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let row =
            |y: usize| (0..5).map(|x| (heights[x * 5 + y] - low).to_string()).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..5).rev().map(row).collect();
        format!(
            "<mujoco><asset><hfield name=\"f\" nrow=\"5\" ncol=\"5\" size=\"0.2 0.2 {} \
             0.1\" elevation=\"{}\"/></asset>\
             <option ccd_iterations=\"200\" ccd_tolerance=\"1e-10\"/><worldbody>\
             <geom type=\"hfield\" hfield=\"f\" pos=\"0 0 {low}\" margin=\"{margin}\"/>",
            high - low,
            rows.join(" "),
        )
    }

    /// A kind of shape, MuJoCo's name for it, its size.
    type Probe = (ShapeKind, &'static str, P);

    /// Contacts in random poses, and how many of MuJoCo's are found.
    fn compared((kind, name, size): Probe, world: &str, ground: &Ground, poses: usize) -> [usize; 2] {
        let text = format!(
            "{world}<body><freejoint/><geom type=\"{name}\" size=\"{} {} {}\"/></body></worldbody></mujoco>",
            size[0], size[1], size[2]
        );
        let model = std::sync::Arc::new(MjModel::from_xml_string(&text).expect("MuJoCo takes it"));
        let mut data = MjData::try_new(model).expect("there is memory");
        let mut stream = Stream::new(&format!("test/batch/solid/{name}"));
        let (mut all, mut same) = (0, 0);
        for _ in 0..poses {
            let mut within = |bound: f64| bound * (2.0 * stream.uniform() - 1.0);
            let turn = nalgebra::UnitQuaternion::from_euler_angles(within(0.3), within(0.3), within(3.0));
            let centre = [within(0.08), within(0.08), 0.055 + within(0.015)];
            data.qpos_mut()[..3].copy_from_slice(&centre);
            data.qpos_mut()[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
            data.forward();
            let matrix = turn.to_rotation_matrix();
            let column = |index: usize| [matrix[(0, index)], matrix[(1, index)], matrix[(2, index)]];
            let solid = Solid { kind, centre, axes: [column(0), column(1), column(2)], size };
            let mut hits = Vec::new();
            collide(&solid, ground, &mut hits);
            // The normal points from the first geom of the pair to the second.
            let out = if data.contact().iter().any(|contact| contact.geom[0] == 0) { 1.0 } else { -1.0 };
            for contact in data.contact().iter().filter(|contact| contact.dist < -1e-6) {
                // MuJoCo's direction of least overlap for a round shape is exact to the square root of its
                // tolerance.
                let near = |hit: &Hit| {
                    (hit.distance - contact.dist).abs() < 1e-7
                        && (0..3).all(|axis| (hit.normal[axis] - out * contact.frame[axis]).abs() < 1e-3)
                        && (0..3).all(|axis| (hit.point[axis] - contact.pos[axis]).abs() < 1e-4)
                };
                all += 1;
                same += usize::from(hits.iter().any(near));
            }
        }
        println!("{name}: {same} of {all}");
        [all, same]
    }

    const BOX: Probe = (ShapeKind::Box, "box", [0.08, 0.05, 0.02]);
    const OTHERS: [Probe; 3] = [
        (ShapeKind::Sphere, "sphere", [0.04, 0.0, 0.0]),
        (ShapeKind::Capsule, "capsule", [0.03, 0.06, 0.0]),
        (ShapeKind::Cylinder, "cylinder", [0.06, 0.03, 0.0]),
    ];

    fn on_a_field(probe: Probe, margin: f64) -> [usize; 2] {
        let heights = heights();
        let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let world = field(&heights, margin);
        let ground = Ground { field: Some(Field::new(0.1, [5, 5], heights, low - 0.1)), ..Ground::default() };
        compared(probe, &world, &ground, 200)
    }

    #[test]
    fn contacts_with_a_field_are_mujocos() {
        for probe in [BOX].into_iter().chain(OTHERS) {
            let [all, same] = on_a_field(probe, 1e-9);
            assert!(all > 200 && same * 100 >= all * 99, "{}: {same} of {all} contacts", probe.1);
        }
    }

    /// When this fails, MuJoCo has fixed its bug: remove the margin of the other tests and the note in
    /// docs/explanation/batch_engine.md.
    #[test]
    fn without_a_margin_mujoco_stops_early() {
        let [all, same] = on_a_field(BOX, 0.0);
        assert!(same * 2 < all, "{same} of {all} contacts");
    }

    #[test]
    fn contacts_with_a_box_are_mujocos() {
        let world = "<mujoco><option ccd_iterations=\"200\" ccd_tolerance=\"1e-10\"/><worldbody>\
                     <geom type=\"box\" size=\"0.03 4 0.02\" pos=\"0.02 0 0.02\" margin=\"1e-9\"/>";
        let block = Block { centre: [0.02, 0.0, 0.02], half: [0.03, 4.0, 0.02] };
        let ground = Ground { boxes: vec![block], ..Ground::default() };
        // Capsules and cylinders have more contacts there, which MuJoCo selects by its own rules.
        for probe in [BOX, OTHERS[0]] {
            let [all, same] = compared(probe, world, &ground, 300);
            assert!(all > 200 && same * 100 >= all * 99, "{}: {same} of {all} contacts", probe.1);
        }
    }
}
