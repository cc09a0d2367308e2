//! The stiffness of a body's contacts, J' K J, as a 6 x 6 matrix of spatial motions.

use super::constraint::Contact;
use super::lane::Lane;
use super::math::{V3, add, axpy, cross, dot, symmetric, zero3};

/// A symmetric matrix from spatial motions to spatial forces, in blocks.
#[derive(Clone, Copy)]
pub struct Stiffness<L> {
    /// From rotation to moment: xx, yy, zz, xy, xz, yz.
    pub turn: [L; 6],
    /// From rotation to force, by rows.
    pub mixed: [V3<L>; 3],
    /// From translation to force.
    pub slide: [L; 6],
}

impl<L: Lane> Stiffness<L> {
    #[inline(always)]
    pub fn zero() -> Self {
        let z = L::zero();
        Self { turn: [z; 6], mixed: [zero3(); 3], slide: [z; 6] }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for k in 0..6 {
            self.turn[k] = self.turn[k] + other.turn[k];
            self.slide[k] = self.slide[k] + other.slide[k];
        }
        for k in 0..3 {
            self.mixed[k] = add(self.mixed[k], other.mixed[k]);
        }
    }

    /// Moment and force for a motion.
    #[inline(always)]
    pub fn times(&self, turn: V3<L>, slide: V3<L>) -> [V3<L>; 2] {
        let [a, b, c] = self.mixed;
        let moment = axpy(slide[0], a, axpy(slide[1], b, axpy(slide[2], c, symmetric(&self.turn, turn))));
        [moment, add([dot(a, turn), dot(b, turn), dot(c, turn)], symmetric(&self.slide, slide))]
    }

    /// Adds the stiffness of a contact.
    #[inline(always)]
    pub fn touch(&mut self, contact: &Contact<L>) {
        let (n, p, along) = (contact.n, contact.p, contact.along);
        // In the middle of the cone: along the generator g = n - mu t, and across n and t.
        let g = axpy(-contact.friction, along, n);
        let b = cross(n, along);
        let entry = |i: usize, j: usize| {
            let middle = (contact.across * b[i]).fma(b[j], g[i] * g[j]);
            let bottom = if i == j { L::splat(1.0) } else { L::zero() };
            contact.stiffness * L::select(contact.sticks, bottom, middle)
        };
        let (xx, yy, zz, xy, xz, yz) =
            (entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2));
        let moment = [cross(p, [xx, xy, xz]), cross(p, [xy, yy, yz]), cross(p, [xz, yz, zz])];
        let column = |i: usize| cross(p, [moment[0][i], moment[1][i], moment[2][i]]);
        let (x, y, z) = (column(0), column(1), column(2));
        let slide = [xx, yy, zz, xy, xz, yz];
        let turn = [x[0], y[1], z[2], y[0], z[0], z[1]];
        self.add(&Self { turn, mixed: moment, slide });
    }
}
