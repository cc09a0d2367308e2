//! Vectors, rotations and spatial inertias in lanes, and a sine with the same bits on all processors.

use super::lane::{Lane, Mask};

/// A vector of three.
pub type V3<L> = [L; 3];
/// A rotation, by columns.
pub type Columns<L> = [V3<L>; 3];

#[inline(always)]
pub fn zero3<L: Lane>() -> V3<L> {
    [L::zero(); 3]
}

/// The same vector in every lane.
#[inline(always)]
pub fn splat3<L: Lane>(v: [f64; 3]) -> V3<L> {
    [L::splat(v[0]), L::splat(v[1]), L::splat(v[2])]
}

#[inline(always)]
pub fn cross<L: Lane>(a: V3<L>, b: V3<L>) -> V3<L> {
    [a[2].fnma(b[1], a[1] * b[2]), a[0].fnma(b[2], a[2] * b[0]), a[1].fnma(b[0], a[0] * b[1])]
}

/// `a x b + c`.
#[inline(always)]
pub fn cross_add<L: Lane>(a: V3<L>, b: V3<L>, c: V3<L>) -> V3<L> {
    [
        a[2].fnma(b[1], a[1].fma(b[2], c[0])),
        a[0].fnma(b[2], a[2].fma(b[0], c[1])),
        a[1].fnma(b[0], a[0].fma(b[1], c[2])),
    ]
}

#[inline(always)]
pub fn dot<L: Lane>(a: V3<L>, b: V3<L>) -> L {
    a[0].fma(b[0], a[1].fma(b[1], a[2] * b[2]))
}

#[inline(always)]
pub fn add<L: Lane>(a: V3<L>, b: V3<L>) -> V3<L> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub fn sub<L: Lane>(a: V3<L>, b: V3<L>) -> V3<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub fn scaled<L: Lane>(s: L, a: V3<L>) -> V3<L> {
    [s * a[0], s * a[1], s * a[2]]
}

/// `s a + b`.
#[inline(always)]
pub fn axpy<L: Lane>(s: L, a: V3<L>, b: V3<L>) -> V3<L> {
    [s.fma(a[0], b[0]), s.fma(a[1], b[1]), s.fma(a[2], b[2])]
}

/// A vector rotated by a rotation.
#[inline(always)]
pub fn turned<L: Lane>(r: &Columns<L>, v: V3<L>) -> V3<L> {
    axpy(v[0], r[0], axpy(v[1], r[1], scaled(v[2], r[2])))
}

/// The product of two rotations.
#[inline(always)]
pub fn composed<L: Lane>(r: &Columns<L>, s: &Columns<L>) -> Columns<L> {
    [turned(r, s[0]), turned(r, s[1]), turned(r, s[2])]
}

/// The rotation of a unit quaternion w x y z.
#[inline(always)]
pub fn rotation<L: Lane>([w, x, y, z]: [L; 4]) -> Columns<L> {
    let (one, two) = (L::splat(1.0), L::splat(2.0));
    [
        [one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)],
        [two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)],
        [two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)],
    ]
}

/// A symmetric matrix [xx, yy, zz, xy, xz, yz] times a vector.
#[inline(always)]
pub fn symmetric<L: Lane>(s: &[L; 6], v: V3<L>) -> V3<L> {
    [
        s[0].fma(v[0], s[3].fma(v[1], s[4] * v[2])),
        s[3].fma(v[0], s[1].fma(v[1], s[5] * v[2])),
        s[4].fma(v[0], s[5].fma(v[1], s[2] * v[2])),
    ]
}

/// Spatial inertia about a point: rotational inertia, first moment, mass.
#[derive(Clone, Copy)]
pub struct Inertia<L> {
    pub i: [L; 6],
    pub h: V3<L>,
    pub m: L,
}

impl<L: Lane> Inertia<L> {
    pub fn zero() -> Self {
        Self { i: [L::zero(); 6], h: zero3(), m: L::zero() }
    }

    /// Inertia of a body whose frame has these columns, from the tensor about its centre of mass in its own
    /// axes and the centre of mass relative to the point in world axes.
    #[inline(always)]
    pub fn of(r: &Columns<L>, tensor: &[L; 6], mass: L, c: V3<L>) -> Self {
        let t = tensor;
        let a = [turned(r, [t[0], t[3], t[4]]), turned(r, [t[3], t[1], t[5]]), turned(r, [t[4], t[5], t[2]])];
        let e = |i: usize, j: usize| a[0][i].fma(r[0][j], a[1][i].fma(r[1][j], a[2][i] * r[2][j]));
        let h = scaled(mass, c);
        let (xx, yy, zz) = (h[0] * c[0], h[1] * c[1], h[2] * c[2]);
        Self {
            i: [
                e(0, 0) + (yy + zz),
                e(1, 1) + (xx + zz),
                e(2, 2) + (xx + yy),
                h[0].fnma(c[1], e(0, 1)),
                h[0].fnma(c[2], e(0, 2)),
                h[1].fnma(c[2], e(1, 2)),
            ],
            h,
            m: mass,
        }
    }

    /// Momentum (angular, linear) of a motion.
    #[inline(always)]
    pub fn times(&self, w: V3<L>, v: V3<L>) -> [V3<L>; 2] {
        let hw = cross(self.h, w);
        let angular = cross_add(self.h, v, symmetric(&self.i, w));
        [angular, [self.m.fma(v[0], -hw[0]), self.m.fma(v[1], -hw[1]), self.m.fma(v[2], -hw[2])]]
    }

    /// Force (moment, force) that a body of this inertia needs to move with `v` and accelerate with `a`.
    #[inline(always)]
    pub fn force(&self, v: &[V3<L>; 2], a: &[V3<L>; 2]) -> [V3<L>; 2] {
        let [fa, fl] = self.times(a[0], a[1]);
        let [ha, hl] = self.times(v[0], v[1]);
        [cross_add(v[0], ha, cross_add(v[1], hl, fa)), cross_add(v[0], hl, fl)]
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for k in 0..6 {
            self.i[k] = self.i[k] + other.i[k];
        }
        self.h = add(self.h, other.h);
        self.m = self.m + other.m;
    }
}

/// Inverse square root of a positive normal number, within 1e-11: two steps of Halley's iteration. A division
/// and a square root take three times as long in 512 bits.
#[inline(always)]
pub fn nearly_inverse_root<L: Lane>(x: L) -> L {
    let halley = |y: L| {
        let rest = (x * y).fnma(y, L::splat(1.0));
        (y * rest).fma(L::splat(0.375).fma(rest, L::splat(0.5)), y)
    };
    halley(halley(x.rough_inverse_root()))
}

/// Inverse square root of a positive normal number, within two units in the last place.
#[inline(always)]
pub fn inverse_root<L: Lane>(x: L) -> L {
    let y = nearly_inverse_root(x);
    let rest = (x * y).fnma(y, L::splat(1.0));
    (y * L::splat(0.5)).fma(rest, y)
}

/// Sine and cosine, for angles below 1e5 rad within two units in the last place (Cody and Waite's reduction,
/// the polynomials of Moshier's cephes).
#[inline(always)]
pub fn sin_cos<L: Lane>(x: L) -> (L, L) {
    let s = L::splat;
    // Adding and subtracting 1.5 * 2^52 rounds to the nearest integer, ties to even.
    let magic = s(6_755_399_441_055_744.0);
    let round = |y: L| (y + magic) - magic;
    let n = round(x * s(std::f64::consts::FRAC_2_PI));
    let r = n.fnma(s(1.570_796_326_734_125_6), x);
    let r = n.fnma(s(6.077_100_506_303_966e-11), r);
    let r = n.fnma(s(2.022_266_248_795_950_6e-21), r);
    let z = r * r;
    let sp = polynomial(
        z,
        &[
            1.589_623_015_765_465_7e-10,
            -2.505_074_776_285_780_7e-8,
            2.755_731_362_138_572_5e-6,
            -1.984_126_982_958_954e-4,
            8.333_333_333_322_118e-3,
            -1.666_666_666_666_663e-1,
        ],
    );
    let cp = polynomial(
        z,
        &[
            -1.135_853_652_138_768_2e-11,
            2.087_570_084_197_473e-9,
            -2.755_731_417_929_674e-7,
            2.480_158_728_885_170_5e-5,
            -1.388_888_888_887_305_6e-3,
            4.166_666_666_666_66e-2,
        ],
    );
    let sine = (r * z).fma(sp, r);
    let cosine = (z * z).fma(cp, s(0.5).fnma(z, s(1.0)));
    // A quarter of n minus the nearest integer is 0, 1/4, 1/2 or -1/2, -1/4: the quadrant.
    let quarter = n * s(0.25);
    let f = quarter - round(quarter);
    let size = f.abs();
    let odd = s(0.2).lt(size).and(size.lt(s(0.3)));
    let half = s(0.3).lt(size);
    let a = L::select(odd, cosine, sine);
    let b = L::select(odd, sine, cosine);
    let negative_sine = half.or(odd.and(f.lt(L::zero())));
    let negative_cosine = half.or(odd.and(L::zero().lt(f)));
    (L::select(negative_sine, -a, a), L::select(negative_cosine, -b, b))
}

#[inline(always)]
fn polynomial<L: Lane>(z: L, coefficients: &[f64; 6]) -> L {
    let mut sum = L::splat(coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum.fma(z, L::splat(*coefficient));
    }
    sum
}
