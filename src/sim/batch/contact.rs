//! Contacts with the ground, found as in MuJoCo and turned into constraints.

#![expect(
    clippy::needless_range_loop,
    reason = "indices run over axes, rows and columns in step, as the equations do"
)]

use super::convex::Solid;
use super::figures::{Figures, IMPEDANCE, ShapeKind, Topology, WIDTH};
use super::lane::{Kernel, Lane, Mask};
use super::math::{Columns, V3, add, axpy, composed, cross, cross_add, dot, scaled, splat3, sub, turned};
use super::model::{Ground, Plane};
use super::solid;
use super::work::{Motion, Work};

/// Smallest friction coefficient (MuJoCo's `mjMINMU`).
const SMALLEST_FRICTION: f64 = 1e-5;
/// Largest number of contacts of a box with a plane.
const CORNERS: f64 = 4.0;

/// Computes the contacts of a step.
pub struct Touch<'a, L: Lane> {
    pub topology: &'a Topology,
    pub figures: &'a Figures<L>,
    pub ground: &'a Ground,
    pub state: &'a Motion<L>,
    pub work: &'a mut Work<L>,
}

impl<L: Lane> Kernel<L> for Touch<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { topology, figures, ground, state, work } = self;
        work.contacts.clear();
        let mut shape = 0;
        while shape < topology.shapes.len() {
            let body = topology.shapes[shape].body;
            let mut end = shape + 1;
            while end < topology.shapes.len() && topology.shapes[end].body == body {
                end += 1;
            }
            let [x, y, z, radius] = figures.around[body];
            let centre = add(work.place[body], turned(&work.turn[body], [x, y, z]));
            let centre = add(state.position, centre);
            for plane in &ground.planes {
                let plane = Surface::new(plane);
                let near = plane.height(centre).lt(radius);
                if near.any() {
                    for index in shape..end {
                        let at = At::new(topology, figures, work, index);
                        planar(&at, &plane, near, figures, state, work);
                    }
                }
            }
            if !ground.boxes.is_empty() || ground.field.is_some() {
                let cluster = Cluster { shapes: shape..end, centre };
                uneven(topology, figures, ground, state, work, &cluster);
            }
            shape = end;
        }
    }
}

/// A plane in all lanes.
struct Surface<L> {
    point: V3<L>,
    normal: V3<L>,
}

impl<L: Lane> Surface<L> {
    #[inline(always)]
    fn new(plane: &Plane) -> Self {
        Self { point: splat3(plane.point), normal: splat3(plane.normal) }
    }

    /// Height of a world point above the plane.
    #[inline(always)]
    fn height(&self, point: V3<L>) -> L {
        dot(self.normal, sub(point, self.point))
    }
}

/// A shape in its current pose: position relative to the base's origin, axes.
struct At<L> {
    body: usize,
    foot: Option<usize>,
    kind: ShapeKind,
    place: V3<L>,
    turn: Columns<L>,
    size: V3<L>,
    friction: L,
}

impl<L: Lane> At<L> {
    #[inline(always)]
    fn new(topology: &Topology, figures: &Figures<L>, work: &Work<L>, index: usize) -> Self {
        let shape = &topology.shapes[index];
        let r = work.turn[shape.body];
        Self {
            body: shape.body,
            foot: shape.foot,
            kind: shape.kind,
            place: add(work.place[shape.body], turned(&r, figures.shape_place[index])),
            turn: if shape.plain { r } else { composed(&r, &figures.shape_turn[index]) },
            size: figures.shape_size[index],
            friction: figures.shape_friction[index],
        }
    }
}

/// A touching point: lanes, position relative to the base's origin, normal, distance (negative inside).
struct Touching<L: Lane> {
    lanes: L::Mask,
    p: V3<L>,
    n: V3<L>,
    distance: L,
}

impl<L: Lane> Touching<L> {
    /// A contact at a point of the shape: MuJoCo puts it halfway between the surfaces.
    #[inline(always)]
    fn halfway(lanes: L::Mask, point: V3<L>, n: V3<L>, distance: L) -> Self {
        Self { lanes, p: axpy(L::splat(-0.5) * distance, n, point), n, distance }
    }
}

/// Contacts of a shape with a plane.
#[inline(always)]
fn planar<L: Lane>(
    at: &At<L>,
    plane: &Surface<L>,
    near: L::Mask,
    figures: &Figures<L>,
    state: &Motion<L>,
    work: &mut Work<L>,
) {
    let n = plane.normal;
    let height = plane.height(add(state.position, at.place));
    match at.kind {
        ShapeKind::Box => {
            let ([a, b, c], [u, v, w]) = (at.size, at.turn);
            let arms: [V3<L>; 3] = [scaled(a, u), scaled(b, v), scaled(c, w)];
            let rise = [dot(n, arms[0]), dot(n, arms[1]), dot(n, arms[2])];
            let mut found = L::zero();
            for corner in 0..8 {
                let lift = corner_of(corner, rise);
                let distance = height + lift;
                let lanes = distance.le(L::zero()).and(lift.le(L::zero())).and(found.lt(L::splat(CORNERS)));
                if lanes.any() {
                    found = found + L::keep(lanes, L::splat(1.0));
                    let mut point = at.place;
                    for i in 0..3 {
                        point[i] = point[i] + corner_of(corner, [arms[0][i], arms[1][i], arms[2][i]]);
                    }
                    constrain(at, &Touching::halfway(lanes.and(near), point, n, distance), figures, work);
                }
            }
        }
        ShapeKind::Sphere => {
            let distance = height - at.size[0];
            constrain(
                at,
                &Touching::halfway(near, axpy(-at.size[0], n, at.place), n, distance),
                figures,
                work,
            );
        }
        ShapeKind::Capsule => {
            let axis = at.turn[2];
            let rise = at.size[1] * dot(n, axis);
            for (end, rise) in [(at.size[1], rise), (-at.size[1], -rise)] {
                let distance = height + rise - at.size[0];
                let point = axpy(-at.size[0], n, axpy(end, axis, at.place));
                constrain(at, &Touching::halfway(near, point, n, distance), figures, work);
            }
        }
        ShapeKind::Cylinder => cylinder(at, n, height, near, figures, work),
    }
}

/// Corner of a box with these half edges: bit `k` of its index selects the end of edge `k`.
#[inline(always)]
fn corner_of<L: Lane>(corner: usize, edges: [L; 3]) -> L {
    let [x, y, z] = edges;
    let x = if corner & 1 == 1 { x } else { -x };
    let y = if corner & 2 == 2 { y } else { -y };
    let z = if corner & 4 == 4 { z } else { -z };
    x + y + z
}

/// Contacts of a cylinder with a plane, as MuJoCo's `mjc_PlaneCylinder`: the lowest points of both rims and
/// two more of the lower one.
#[inline(always)]
fn cylinder<L: Lane>(
    at: &At<L>,
    n: V3<L>,
    height: L,
    near: L::Mask,
    figures: &Figures<L>,
    work: &mut Work<L>,
) {
    let (zero, half) = (L::zero(), L::splat(0.5));
    let [radius, length, _] = at.size;
    let along = dot(n, at.turn[2]);
    let down = zero.lt(along);
    let [x, y, z] = at.turn[2];
    let axis = [L::select(down, -x, x), L::select(down, -y, y), L::select(down, -z, z)];
    let along = L::select(down, -along, along);
    // The component of -n orthogonal to the axis.
    let across = sub(scaled(along, axis), n);
    let square = dot(across, across);
    let upright = square.lt(L::splat(1e-30));
    let scale = radius / L::select(upright, L::splat(1.0), square).sqrt();
    let ([x, y, z], [u, v, w]) = (scaled(radius, at.turn[0]), scaled(scale, across));
    let rim = [L::select(upright, x, u), L::select(upright, y, v), L::select(upright, z, w)];
    let drop = dot(rim, n);
    let axis = scaled(length, axis);
    let end = along * length;
    let lower = add(at.place, axis);
    let distance = height + end + drop;
    let lowest = near.and(distance.le(zero));
    constrain(at, &Touching::halfway(lowest, add(lower, rim), n, distance), figures, work);
    constrain(
        at,
        &Touching::halfway(lowest, add(sub(at.place, axis), rim), n, height - end + drop),
        figures,
        work,
    );
    let drop = -(drop * half);
    let sideways = cross(rim, axis);
    let length = dot(sideways, sideways);
    let none = length.lt(L::splat(1e-30));
    let unit = L::splat(1.0) / L::select(none, L::splat(1.0), length).sqrt();
    let sideways = scaled(unit * radius * L::splat(0.866_025_403_784_438_6), sideways);
    let middle = axpy(-half, rim, lower);
    let distance = height + end + drop;
    constrain(at, &Touching::halfway(lowest, add(middle, sideways), n, distance), figures, work);
    constrain(at, &Touching::halfway(lowest, sub(middle, sideways), n, distance), figures, work);
}

/// Adds a contact as a constraint, in the lanes in which the shape is in the ground.
#[inline(always)]
fn constrain<L: Lane>(at: &At<L>, touching: &Touching<L>, figures: &Figures<L>, work: &mut Work<L>) {
    let Touching { lanes, p, n, distance } = *touching;
    let active = lanes.and(distance.lt(L::zero()));
    if !active.any() {
        return;
    }
    let (one, world) = (L::splat(1.0), &figures.world[0]);
    let [w, v] = work.velocity[at.body];
    let v = cross_add(w, p, v);
    let impedance = impedance(distance);
    let resistance = ((one - impedance) * figures.weight[at.body] / impedance).max(L::splat(1e-15));
    let d = L::keep(active, one / resistance);
    let pull = world.contact_k * impedance * distance;
    let friction = at.friction.max(L::splat(SMALLEST_FRICTION));
    let contact = work.contacts.next();
    (contact.body, contact.foot, contact.active) = (at.body, at.foot, active);
    (contact.p, contact.n, contact.d) = (p, n, d);
    contact.friction = friction;
    contact.share = one / friction.fma(friction, one);
    for i in 0..3 {
        contact.reference[i] = -world.contact_b.fma(v[i], pull * n[i]);
    }
}

/// MuJoCo's impedance at a penetration depth, for the default `solimp`.
#[inline(always)]
pub fn impedance<L: Lane>(depth: L) -> L {
    let (one, two) = (L::splat(1.0), L::splat(2.0));
    let x = (depth.abs() / L::splat(WIDTH)).min(one);
    let low = two * x * x;
    let rest = one - x;
    let high = one - two * rest * rest;
    let y = L::select(x.le(L::splat(0.5)), low, high);
    y.fma(L::splat(IMPEDANCE[1] - IMPEDANCE[0]), L::splat(IMPEDANCE[0]))
}

/// The shapes of a body and the centre of their bounding sphere in the world.
struct Cluster<L> {
    shapes: std::ops::Range<usize>,
    centre: V3<L>,
}

/// Contacts with boxes and height fields, found lane by lane.
#[inline(always)]
fn uneven<L: Lane>(
    topology: &Topology,
    figures: &Figures<L>,
    ground: &Ground,
    state: &Motion<L>,
    work: &mut Work<L>,
    cluster: &Cluster<L>,
) {
    let number = |values: &[L], index: usize, lane: usize| L::numbers(values)[index * L::LANES + lane];
    let body = topology.shapes[cluster.shapes.start].body;
    let radius = figures.around[body][3];
    let mut near = [false; 64];
    let mut any = false;
    for lane in 0..L::LANES {
        let at: [f64; 3] = std::array::from_fn(|axis| number(&cluster.centre, axis, lane));
        near[lane] = solid::near(ground, at, number(&[radius], 0, lane));
        any |= near[lane];
    }
    if !any {
        return;
    }
    let mut hits = Vec::new();
    for index in cluster.shapes.clone() {
        let at = At::new(topology, figures, work, index);
        // The hits of all lanes: the first ones in the first value and so on.
        let mut touches: Vec<Touching<L>> = Vec::new();
        for lane in (0..L::LANES).filter(|lane| near[*lane]) {
            let three =
                |values: &V3<L>| -> [f64; 3] { std::array::from_fn(|axis| number(values, axis, lane)) };
            let origin = three(&state.position);
            let place = three(&at.place);
            let solid = Solid {
                kind: at.kind,
                centre: std::array::from_fn(|axis| origin[axis] + place[axis]),
                axes: [three(&at.turn[0]), three(&at.turn[1]), three(&at.turn[2])],
                size: three(&at.size),
            };
            hits.clear();
            solid::collide(&solid, ground, &mut hits);
            for (index, hit) in hits.iter().enumerate() {
                if index == touches.len() {
                    let (z, lanes) = ([L::zero(); 3], L::Mask::splat(true));
                    touches.push(Touching { lanes, p: z, n: z, distance: L::zero() });
                }
                let touch = &mut touches[index];
                for axis in 0..3 {
                    L::numbers_mut(&mut touch.p)[axis * L::LANES + lane] = hit.point[axis] - origin[axis];
                    L::numbers_mut(&mut touch.n)[axis * L::LANES + lane] = hit.normal[axis];
                }
                L::numbers_mut(std::slice::from_mut(&mut touch.distance))[lane] = hit.distance;
            }
        }
        for touching in &touches {
            constrain(&at, touching, figures, work);
        }
    }
}
