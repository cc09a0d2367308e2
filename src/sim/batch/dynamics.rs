//! The equations of motion without constraints: kinematics, bias forces, mass matrix.
//!
//! Generalised velocities are the angular and linear velocity of the base's origin in world axes, then the
//! joints. Spatial quantities are (angular, linear) in world axes about the base's origin, so that those of
//! different bodies can be added directly.

use super::figures::{Figures, Topology};
use super::lane::{Kernel, Lane};
use super::math::{
    Inertia, V3, add, axpy, composed, cross, cross_add, dot, rotation, sin_cos, turned, zero3,
};
use super::work::{Motion, Work};

/// Computes the mass matrix and the unconstrained forces.
pub struct Smooth<'a, L: Lane> {
    pub topology: &'a Topology,
    pub figures: &'a Figures<L>,
    pub state: &'a Motion<L>,
    pub work: &'a mut Work<L>,
}

impl<L: Lane> Kernel<L> for Smooth<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { topology, figures, state, work } = self;
        forward(topology, figures, state, work);
        backward(topology, figures, state, work);
    }
}

/// Two axes after a rotation about the third.
#[inline(always)]
fn swung<L: Lane>(u: V3<L>, x: V3<L>, sine: L, cosine: L) -> [V3<L>; 2] {
    let mut both = [u, x];
    for i in 0..3 {
        both[0][i] = cosine.fma(u[i], sine * x[i]);
        both[1][i] = sine.fnma(u[i], cosine * x[i]);
    }
    both
}

/// From the base to the ends: poses, velocities, and the force that each body needs on its own.
#[inline(always)]
fn forward<L: Lane>(topology: &Topology, figures: &Figures<L>, state: &Motion<L>, work: &mut Work<L>) {
    let r = rotation(state.orientation);
    let v = [state.rate, state.velocity];
    // The acceleration of a free base due to its velocity alone, with gravity as an upward acceleration.
    let mut upward = cross(state.velocity, state.rate);
    upward[2] = upward[2] + figures.world[0].gravity;
    let a = [zero3(), upward];
    let inertia = Inertia::of(&r, &figures.tensor[0], figures.mass[0], turned(&r, figures.com[0]));
    (work.turn[0], work.place[0], work.velocity[0], work.bias[0]) = (r, zero3(), v, a);
    work.force[0] = inertia.force(&v, &a);
    work.inertia[0] = inertia;
    for joint in 0..topology.tree.joints() {
        let (body, parent) = (joint + 1, topology.tree.parent[joint]);
        let mut r = work.turn[parent];
        let p = axpy(
            figures.place[joint][0],
            r[0],
            axpy(figures.place[joint][1], r[1], axpy(figures.place[joint][2], r[2], work.place[parent])),
        );
        if !topology.plain[joint] {
            r = composed(&r, &figures.turn[joint]);
        }
        let (sine, cosine) = sin_cos(state.joints[joint]);
        let axis = match topology.axis[joint] {
            0 => {
                [r[1], r[2]] = swung(r[1], r[2], sine, cosine);
                r[0]
            }
            1 => {
                [r[2], r[0]] = swung(r[2], r[0], sine, cosine);
                r[1]
            }
            _ => {
                [r[0], r[1]] = swung(r[0], r[1], sine, cosine);
                r[2]
            }
        };
        let lever = cross(p, axis);
        work.axes[joint] = [axis[0], axis[1], axis[2], lever[0], lever[1], lever[2]];
        let rate = state.joint_rates[joint];
        let [w, v] = work.velocity[parent];
        let [aw, av] = work.bias[parent];
        // The axis moves with the parent: v x s.
        let (da, dl) = (cross(w, axis), cross_add(v, axis, cross(w, lever)));
        let a = [axpy(rate, da, aw), axpy(rate, dl, av)];
        let v = [axpy(rate, axis, w), axpy(rate, lever, v)];
        let c = axpy(
            figures.com[body][0],
            r[0],
            axpy(figures.com[body][1], r[1], axpy(figures.com[body][2], r[2], p)),
        );
        let inertia = Inertia::of(&r, &figures.tensor[body], figures.mass[body], c);
        (work.turn[body], work.place[body], work.velocity[body], work.bias[body]) = (r, p, v, a);
        work.force[body] = inertia.force(&v, &a);
        work.inertia[body] = inertia;
    }
}

/// From the ends to the base: forces of the joints, composite inertias, rows of the mass matrix.
#[inline(always)]
fn backward<L: Lane>(topology: &Topology, figures: &Figures<L>, state: &Motion<L>, work: &mut Work<L>) {
    let tree = &topology.tree;
    for joint in (0..tree.joints()).rev() {
        let (body, parent) = (joint + 1, tree.parent[joint]);
        let s = work.axes[joint];
        let (sa, sl) = ([s[0], s[1], s[2]], [s[3], s[4], s[5]]);
        let [fa, fl] = work.force[body];
        let bias = dot(sa, fa) + dot(sl, fl);
        let effort = figures.effort[joint];
        let torque = state.torque[joint].min(effort).max(-effort);
        work.smooth[6 + joint] = torque - figures.damping[joint].fma(state.joint_rates[joint], bias);
        let inertia = work.inertia[body];
        let [ma, ml] = inertia.times(sa, sl);
        let (row, entries) = (tree.rows[joint], &mut work.mass.rows);
        for i in 0..3 {
            (entries[row.at(i)], entries[row.at(3 + i)]) = (ma[i], ml[i]);
        }
        for (index, above) in tree.above[joint].iter().enumerate() {
            let s = &work.axes[*above];
            entries[row.at(6 + index)] = dot(ma, [s[0], s[1], s[2]]) + dot(ml, [s[3], s[4], s[5]]);
        }
        entries[row.diagonal()] = (dot(ma, sa) + dot(ml, sl)) + figures.armature[joint];
        work.inertia[parent].add(&inertia);
        let [pa, pl] = work.force[parent];
        work.force[parent] = [add(pa, fa), add(pl, fl)];
    }
    let [fa, fl] = work.force[0];
    let moment = cross(turned(&work.turn[0], figures.com[0]), state.push);
    for i in 0..3 {
        work.smooth[i] = moment[i] - fa[i];
        work.smooth[3 + i] = state.push[i] - fl[i];
    }
    let (z, Inertia { i, h, m }) = (L::zero(), work.inertia[0]);
    work.mass.base = [
        [i[0], z, z, z, z, z],
        [i[3], i[1], z, z, z, z],
        [i[4], i[5], i[2], z, z, z],
        [z, h[2], -h[1], m, z, z],
        [-h[2], z, h[0], z, m, z],
        [h[1], -h[0], z, z, z, m],
    ];
}
