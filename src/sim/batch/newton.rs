//! MuJoCo's constraint problem and its solution: Newton's method on the primal with an exact line search.
//!
//! Accelerations minimise 1/2 (x - x0)' M (x - x0) + s(J x - a), with x0 the acceleration without constraints
//! and s quadratic, linear or conic by row. The stiffness J' s'' J of a body's contacts is a 6 x 6 matrix of
//! that body, so the Hessian has the sparsity of M, and a step costs about one factorisation. Every lane
//! stops by its own criteria and does not change while others continue.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are not inlined into code for an instruction set (see the module above)"
)]

use super::constraint::Contact;
use super::contact::impedance;
use super::figures::{Figures, Topology};
use super::lane::{Kernel, Lane, Mask};
use super::math::{V3, add, axpy, cross_add, dot, inverse_root, nearly_inverse_root, scaled, sub, zero3};
use super::scratch::Scratch;
use super::stiffness::Stiffness;
use super::tree::{Limb, Matrix, Tree, block, block_mut, by_length};
use super::work::{Motion, Work};

/// Largest number of Newton steps, as in the MuJoCo model.
const STEPS: usize = 50;
/// Largest number of evaluations of a line search.
const EVALUATIONS: usize = 24;
/// A line search ends where the slope has fallen to this share.
const FLATTER: f64 = 0.1;
/// Square in (m/s^2)^2 that keeps the length of a tangential gap above zero.
const TINY: f64 = 1e-20;

/// Computes the accelerations of a step and the forces that cause them.
pub struct Solve<'a, L: Lane> {
    pub topology: &'a Topology,
    pub figures: &'a Figures<L>,
    pub state: &'a Motion<L>,
    pub work: &'a mut Work<L>,
}

/// The angular and the linear part of a joint's axis.
#[inline(always)]
fn parts<L: Lane>(s: &[L; 6]) -> [V3<L>; 2] {
    [[s[0], s[1], s[2]], [s[3], s[4], s[5]]]
}

impl<L: Lane> Kernel<L> for Solve<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { topology, figures, state, work } = self;
        let tree = &topology.tree;
        let Work { axes, mass, smooth, scratch, contacts, solver, .. } = work;
        let contacts = contacts.all_mut();
        rows(figures, state, solver);
        carry(topology, contacts, solver);
        solver.acceleration.copy_from_slice(&state.warm);
        mass.times(tree, &solver.acceleration, &mut solver.inertial);
        motions(topology, axes, &solver.acceleration, &solver.carries, &mut solver.motion);
        for contact in contacts.iter_mut() {
            let [a, l] = solver.motion[contact.body];
            contact.gap = sub(cross_add(a, contact.p, l), contact.reference);
        }
        let world = &figures.world[0];
        let mut live = L::zero().lt(state.due);
        let mut steps = 0;
        loop {
            gradient(topology, figures, axes, smooth, contacts, solver);
            let mut square = solver.gradient[0] * solver.gradient[0];
            for g in &solver.gradient[1..] {
                square = g.fma(*g, square);
            }
            live = live.and(world.small_gradient.lt(square));
            if steps == STEPS || !live.any() {
                break;
            }
            steps += 1;
            hessian(topology, axes, mass, contacts, solver);
            solver.hessian.factor(tree, scratch);
            for i in 0..solver.search.len() {
                solver.search[i] = -solver.gradient[i];
            }
            solver.hessian.solve(tree, &mut solver.search);
            mass.times(tree, &solver.search, &mut solver.inertial_search);
            motions(topology, axes, &solver.search, &solver.carries, &mut solver.motion);
            for contact in contacts.iter_mut() {
                let [a, l] = solver.motion[contact.body];
                contact.change = cross_add(a, contact.p, l);
                contact.normal_change = dot(contact.n, contact.change);
                let tangent = axpy(-contact.normal_change, contact.n, contact.change);
                contact.product = dot(contact.tangent, tangent);
                contact.square_change = dot(tangent, tangent);
            }
            let mut slope = solver.gradient[0] * solver.search[0];
            for i in 1..solver.search.len() {
                slope = solver.gradient[i].fma(solver.search[i], slope);
            }
            let length = search(figures, smooth, contacts, solver, live, slope);
            advance(contacts, solver, live, length);
            // A step that could gain less than the tolerance is the last, as in MuJoCo.
            live = live.and(world.small_decrement.lt(slope.abs()));
        }
        for i in 0..solver.total.len() {
            solver.total[i] = solver.inertial[i] - solver.gradient[i];
        }
        solver.foot_force = [zero3(); 2];
        solver.body_touch = L::zero();
        for contact in contacts.iter() {
            match contact.foot {
                Some(foot) => solver.foot_force[foot] = add(solver.foot_force[foot], contact.force),
                None => solver.body_touch = L::select(contact.active, L::splat(1.0), solver.body_touch),
            }
        }
    }
}

/// Computes the rows of the joints: friction, and limits if any lane is beyond one; records whether any is.
#[inline(always)]
fn rows<L: Lane>(figures: &Figures<L>, state: &Motion<L>, solver: &mut Scratch<L>) {
    let (zero, one, world) = (L::zero(), L::splat(1.0), &figures.world[0]);
    solver.limited = false;
    for joint in 0..state.joints.len() {
        let rate = state.joint_rates[joint];
        solver.friction_gap[joint] = world.row_b.fma(rate, state.warm[6 + joint]);
        let below = state.joints[joint] - figures.lower[joint];
        let above = figures.upper[joint] - state.joints[joint];
        let depth = below.min(above);
        let active = depth.lt(zero);
        if active.any() {
            solver.limited = true;
            let sign = L::select(below.le(above), one, -one);
            let impedance = impedance(depth);
            let resistance =
                ((one - impedance) * figures.joint_weight[joint] / impedance).max(L::splat(1e-15));
            solver.limit_sign[joint] = sign;
            solver.limit_d[joint] = L::keep(active, one / resistance);
            solver.limit_reference[joint] = -world.row_b.fma(sign * rate, world.row_k * impedance * depth);
        } else {
            solver.limit_sign[joint] = one;
            solver.limit_d[joint] = zero;
            solver.limit_reference[joint] = zero;
        }
    }
}

/// Finds the bodies with contacts, their own or those of their descendants.
#[inline(always)]
fn carry<L: Lane>(topology: &Topology, contacts: &[Contact<L>], solver: &mut Scratch<L>) {
    solver.carries.fill(false);
    for contact in contacts {
        solver.carries[contact.body] = true;
    }
    for joint in (0..topology.tree.joints()).rev() {
        if solver.carries[joint + 1] {
            solver.carries[topology.tree.parent[joint]] = true;
        }
    }
}

/// Spatial accelerations of the bodies with contacts, for accelerations x of the tree.
#[inline(always)]
fn motions<L: Lane>(
    topology: &Topology,
    axes: &[[L; 6]],
    x: &[L],
    carries: &[bool],
    motion: &mut [[V3<L>; 2]],
) {
    motion[0] = [[x[0], x[1], x[2]], [x[3], x[4], x[5]]];
    for (joint, &parent) in topology.tree.parent.iter().enumerate() {
        if carries[joint + 1] {
            let [sa, sl] = parts(&axes[joint]);
            let [a, l] = motion[parent];
            motion[joint + 1] = [axpy(x[6 + joint], sa, a), axpy(x[6 + joint], sl, l)];
        }
    }
}

/// Forces of the constraints, and the remaining gradient.
#[inline(always)]
fn gradient<L: Lane>(
    topology: &Topology,
    figures: &Figures<L>,
    axes: &[[L; 6]],
    smooth: &[L],
    contacts: &mut [Contact<L>],
    solver: &mut Scratch<L>,
) {
    let (zero, joints) = (L::zero(), axes.len());
    for i in 0..solver.gradient.len() {
        solver.gradient[i] = solver.inertial[i] - smooth[i];
    }
    for joint in 0..joints {
        let (most, d) = (figures.friction[joint], figures.friction_d[joint]);
        let force = -(d * solver.friction_gap[joint]);
        let bounded = force.min(most).max(-most);
        solver.diagonal[joint] = L::keep(force.abs().lt(most), d);
        solver.gradient[6 + joint] = solver.gradient[6 + joint] - bounded;
    }
    if solver.limited {
        for joint in 0..joints {
            let sign = solver.limit_sign[joint];
            let gap = sign * solver.acceleration[6 + joint] - solver.limit_reference[joint];
            let d = L::keep(gap.lt(zero), solver.limit_d[joint]);
            solver.diagonal[joint] = solver.diagonal[joint] + d;
            solver.gradient[6 + joint] = (d * gap).fma(sign, solver.gradient[6 + joint]);
        }
    }
    if !solver.carries[0] {
        return;
    }
    for body in 0..=joints {
        if solver.carries[body] {
            solver.wrench[body] = [zero3(); 2];
        }
    }
    for contact in contacts.iter_mut() {
        cone(contact);
        let [moment, force] = solver.wrench[contact.body];
        solver.wrench[contact.body] =
            [cross_add(contact.p, contact.force, moment), add(force, contact.force)];
    }
    for joint in (0..joints).rev() {
        if solver.carries[joint + 1] {
            let [moment, force] = solver.wrench[joint + 1];
            solver.gradient[6 + joint] = solver.gradient[6 + joint] - along(&axes[joint], moment, force);
            let parent = topology.tree.parent[joint];
            let [pm, pf] = solver.wrench[parent];
            solver.wrench[parent] = [add(pm, moment), add(pf, force)];
        }
    }
    let [moment, force] = solver.wrench[0];
    for i in 0..3 {
        solver.gradient[i] = solver.gradient[i] - moment[i];
        solver.gradient[3 + i] = solver.gradient[3 + i] - force[i];
    }
}

/// The force of a contact for its gap: zero above the cone, along the cone's normal in the middle, linear at
/// the bottom.
#[inline(always)]
fn cone<L: Lane>(contact: &mut Contact<L>) {
    let (mu, n, gap) = (contact.friction, contact.n, contact.gap);
    let normal = dot(n, gap);
    let tangent = axpy(-normal, n, gap);
    let square = dot(tangent, tangent) + L::splat(TINY);
    let inverse = inverse_root(square);
    let length = square * inverse;
    let along = scaled(inverse, tangent);
    let free = (mu * length).le(normal);
    let sticks = mu.fma(normal, length).le(L::zero());
    let d = L::keep(free.not(), contact.d);
    let stiffness = d * contact.share;
    let inside = mu.fnma(length, normal);
    let push = stiffness * inside;
    let pull = push * mu;
    for i in 0..3 {
        contact.force[i] = L::select(sticks, -(d * gap[i]), pull.fma(along[i], -(push * n[i])));
    }
    (contact.normal, contact.tangent, contact.square) = (normal, tangent, square);
    (contact.along, contact.sticks) = (along, sticks);
    contact.stiffness = L::select(sticks, d, stiffness);
    contact.across = -(inside * mu * inverse);
}

/// No body.
const NONE: usize = usize::MAX;

/// M + J' K J and the second derivatives of the joints' rows.
#[inline(always)]
fn hessian<L: Lane>(
    topology: &Topology,
    axes: &[[L; 6]],
    mass: &Matrix<L>,
    contacts: &[Contact<L>],
    solver: &mut Scratch<L>,
) {
    // A body without contacts of its own uses those of its first descendant that has some.
    solver.source.fill(NONE);
    for contacts in contacts.chunk_by(|a, b| a.body == b.body) {
        let (body, mut stiffness) = (contacts[0].body, Stiffness::zero());
        for contact in contacts {
            stiffness.touch(contact);
        }
        match solver.source[body] {
            NONE => (solver.source[body], solver.stiffness[body]) = (body, stiffness),
            _ => solver.stiffness[body].add(&stiffness),
        }
    }
    for limb in topology.tree.limbs.iter().rev() {
        by_length!(limb, hessian_limb(limb, &topology.tree, axes, &mass.rows[limb.range()], solver));
    }
    let base = &mut solver.hessian.base;
    *base = mass.base;
    if solver.source[0] != NONE {
        let Stiffness { turn, mixed, slide } = &solver.stiffness[solver.source[0]];
        for (block, [xx, yy, zz, xy, xz, yz]) in [(0, turn), (3, slide)] {
            for (i, j, entry) in [(0, 0, xx), (1, 1, yy), (2, 2, zz), (1, 0, xy), (2, 0, xz), (2, 1, yz)] {
                base[block + i][block + j] = base[block + i][block + j] + *entry;
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                base[3 + i][j] = base[3 + i][j] + mixed[i][j];
            }
        }
    }
}

/// The rows of a limb.
#[inline(always)]
fn hessian_limb<L: Lane, const N: usize>(
    limb: &Limb,
    tree: &Tree,
    axes: &[[L; 6]],
    mass: &[L],
    solver: &mut Scratch<L>,
) {
    let Scratch { hessian, stiffness, source, diagonal, .. } = solver;
    let (mass_outer, mass_own) = block::<L, N>(limb, mass);
    let (outer, own) = block_mut::<L, N>(limb, &mut hessian.rows[limb.range()]);
    let (mass_base, mass_above) = mass_outer.split_first_chunk::<6>().expect("a base has six columns");
    let (base, above) = outer.split_first_chunk_mut::<6>().expect("a base has six columns");
    let own_axes = axes[limb.first..].first_chunk::<N>().expect("every joint has an axis");
    let diagonal = diagonal[limb.first..].first_chunk::<N>().expect("every joint has a diagonal");
    for k in (0..N).rev() {
        let (body, parent) = (limb.first + k + 1, tree.parent[limb.first + k]);
        let carried = source[body];
        if carried == NONE {
            for i in 0..6 {
                base[i][k] = mass_base[i][k];
            }
            for i in 0..above.len() {
                above[i][k] = mass_above[i][k];
            }
            for i in 0..k {
                own[i][k] = mass_own[i][k];
            }
            own[k][k] = mass_own[k][k] + diagonal[k];
            continue;
        }
        let [turn, slide] = parts(&own_axes[k]);
        let [moment, force] = stiffness[carried].times(turn, slide);
        for i in 0..3 {
            base[i][k] = mass_base[i][k] + moment[i];
            base[3 + i][k] = mass_base[3 + i][k] + force[i];
        }
        for i in 0..above.len() {
            above[i][k] = mass_above[i][k] + along(&axes[limb.above[i]], moment, force);
        }
        for i in 0..k {
            own[i][k] = mass_own[i][k] + along(&own_axes[i], moment, force);
        }
        own[k][k] = mass_own[k][k] + (along(&own_axes[k], moment, force) + diagonal[k]);
        match source[parent] {
            NONE => source[parent] = carried,
            other => {
                let carried = stiffness[carried];
                stiffness[other].add(&carried);
            }
        }
    }
}

/// Projection of a moment and a force onto an axis.
#[inline(always)]
fn along<L: Lane>(axis: &[L; 6], moment: V3<L>, force: V3<L>) -> L {
    let [turn, slide] = parts(axis);
    dot(moment, turn) + dot(force, slide)
}

/// Length of the step along the search direction at which the slope is nearly zero: Newton's method in a
/// bracket.
#[inline(always)]
fn search<L: Lane>(
    figures: &Figures<L>,
    smooth: &[L],
    contacts: &[Contact<L>],
    solver: &mut Scratch<L>,
    live: L::Mask,
    slope: L,
) -> L {
    let (zero, one) = (L::zero(), L::splat(1.0));
    let (mut linear, mut quadratic) = (zero, zero);
    for i in 0..solver.search.len() {
        let search = solver.search[i];
        linear = (solver.inertial[i] - smooth[i]).fma(search, linear);
        quadratic = solver.inertial_search[i].fma(search, quadratic);
    }
    let flat = slope.abs() * L::splat(FLATTER);
    let (mut low, mut high) = (zero, L::splat(1e10));
    let mut length = one;
    let mut open = live;
    for evaluation in 1..=EVALUATIONS {
        let (first, second) = slopes(figures, contacts, solver, length, linear, quadratic);
        open = open.and(flat.lt(first.abs()));
        let falling = first.lt(zero);
        low = L::select(falling, length, low);
        high = L::select(falling, high, length);
        if evaluation == EVALUATIONS || !open.any() {
            break;
        }
        let next = length - first / second;
        let outside = next.le(low).or(high.le(next));
        let middle = L::select(high.lt(L::splat(1e9)), L::splat(0.5) * (low + high), low + low);
        length = L::select(open, L::select(outside, middle, next), length);
    }
    // No evaluations are left: take the end of the bracket towards which the cost decreases.
    L::select(open.and(zero.lt(low)), low, length)
}

/// Slope and curvature of the cost at a length of the step.
#[inline(always)]
fn slopes<L: Lane>(
    figures: &Figures<L>,
    contacts: &[Contact<L>],
    solver: &Scratch<L>,
    length: L,
    linear: L,
    quadratic: L,
) -> (L, L) {
    let zero = L::zero();
    let (mut first, mut second) = (length.fma(quadratic, linear), quadratic);
    for joint in 0..solver.friction_gap.len() {
        let (s, d, most) = (solver.search[6 + joint], figures.friction_d[joint], figures.friction[joint]);
        let force = d * length.fma(s, solver.friction_gap[joint]);
        first = force.min(most).max(-most).fma(s, first);
        second = L::keep(force.abs().lt(most), d).fma(s * s, second);
    }
    if solver.limited {
        for (joint, sign) in solver.limit_sign.iter().enumerate() {
            let s = *sign * solver.search[6 + joint];
            let gap = *sign * solver.acceleration[6 + joint] - solver.limit_reference[joint];
            let gap = length.fma(s, gap);
            let pull = L::keep(gap.lt(zero), solver.limit_d[joint]) * s;
            first = pull.fma(gap, first);
            second = pull.fma(s, second);
        }
    }
    for contact in contacts {
        let mu = contact.friction;
        let normal = length.fma(contact.normal_change, contact.normal);
        let product = length.fma(contact.square_change, contact.product);
        let square = length.fma(contact.product + product, contact.square).max(L::splat(TINY));
        let inverse = nearly_inverse_root(square);
        let tangent = square * inverse;
        let free = (mu * tangent).le(normal);
        let sticks = mu.fma(normal, tangent).le(zero);
        let d = L::keep(free.not(), contact.d);
        let stiffness = d * contact.share;
        let inside = mu.fnma(tangent, normal);
        // Change of the tangential length, and of `inside`.
        let along = product * inverse;
        let change = mu.fnma(along, contact.normal_change);
        let curved = inside * mu * inverse * (contact.square_change - along * along);
        let middle = [stiffness * inside * change, stiffness * change.fma(change, -curved)];
        let bottom = [
            d * normal.fma(contact.normal_change, product),
            d * contact.normal_change.fma(contact.normal_change, contact.square_change),
        ];
        first = first + L::select(sticks, bottom[0], middle[0]);
        second = second + L::select(sticks, bottom[1], middle[1]);
    }
    (first, second)
}

/// Takes the step in the active lanes.
#[inline(always)]
fn advance<L: Lane>(contacts: &mut [Contact<L>], solver: &mut Scratch<L>, live: L::Mask, length: L) {
    let step = |from: &mut L, along: L| *from = L::select(live, length.fma(along, *from), *from);
    for i in 0..solver.search.len() {
        step(&mut solver.acceleration[i], solver.search[i]);
        step(&mut solver.inertial[i], solver.inertial_search[i]);
    }
    for joint in 0..solver.friction_gap.len() {
        step(&mut solver.friction_gap[joint], solver.search[6 + joint]);
    }
    for contact in contacts {
        for i in 0..3 {
            step(&mut contact.gap[i], contact.change[i]);
        }
    }
}
