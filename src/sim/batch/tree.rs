//! The tree of joints, and symmetric matrices that are zero where its branches do not meet.
//!
//! Joints are counted depth first. A *limb* is a run of joints without a branch, at most [`LONGEST`] of them; every
//! row of a matrix has entries for the base (6), for the joints above its limb, and for its own limb. L'DL
//! factorisation of such a matrix needs no entries beyond these (Featherstone 2008, section 6.5).

#![expect(clippy::needless_range_loop, reason = "indices run over axes, rows and columns in step, as the equations do")]

use super::lane::{Kernel, Lane};

/// Joints of the longest limb: loops over them are unrolled.
pub const LONGEST: usize = 6;

/// A run of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Its first joint.
    pub first: usize,
    /// Number of joints.
    pub joints: usize,
    /// The joints above it, from the base down.
    pub above: Vec<usize>,
    /// Where its rows begin in a matrix.
    pub row: usize,
}

impl Limb {
    /// Entries of a row before the limb's own.
    #[inline(always)]
    pub fn outer(&self) -> usize {
        6 + self.above.len()
    }
    /// The entry of a vector to which column `j` of the rows belongs, for a column before the limb's own.
    #[inline(always)]
    fn column(&self, j: usize) -> usize {
        if j < 6 { j } else { 6 + self.above[j - 6] }
    }
    #[inline(always)]
    pub fn width(&self) -> usize {
        self.outer() + self.joints
    }
}

/// The shape of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Parent body of each joint; body 0 is the base, body `i + 1` that of joint `i`.
    pub parent: Vec<usize>,
    /// Its limbs; those above come first.
    pub limbs: Vec<Limb>,
    /// Where the row of each joint begins in a matrix, and its number of entries up to and with the diagonal.
    pub rows: Vec<(usize, usize)>,
    /// The joints above each joint, from the base down.
    pub above: Vec<Vec<usize>>,
    /// Numbers of a matrix below its base block.
    pub entries: usize,
}

impl Tree {
    /// The order in which the joints of a tree are counted depth first, children by their own numbers.
    pub fn depth_first(parent: &[usize]) -> Vec<usize> {
        let below = |body: usize| (0..parent.len()).rev().filter(move |joint| parent[*joint] == body);
        let mut open: Vec<usize> = below(0).collect();
        let mut order = Vec::with_capacity(parent.len());
        while let Some(joint) = open.pop() {
            order.push(joint);
            open.extend(below(joint + 1));
        }
        order
    }

    /// The tree of joints that are counted depth first.
    pub fn new(parent: Vec<usize>) -> Self {
        let joints = parent.len();
        let children = |body: usize| parent.iter().filter(|one| **one == body).count();
        let mut above: Vec<Vec<usize>> = Vec::with_capacity(joints);
        for &body in &parent {
            let path = match body.checked_sub(1) {
                None => Vec::new(),
                Some(joint) => above[joint].iter().copied().chain([joint]).collect(),
            };
            above.push(path);
        }
        let (mut limbs, mut rows, mut entries) = (Vec::<Limb>::new(), Vec::with_capacity(joints), 0);
        let mut first = 0;
        while first < joints {
            let mut count = 1;
            while count < LONGEST
                && first + count < joints
                && parent[first + count] == first + count
                && children(first + count) == 1
            {
                count += 1;
            }
            let limb = Limb { first, joints: count, above: above[first].clone(), row: entries };
            for k in 0..count {
                rows.push((entries + k * limb.width(), limb.outer() + k + 1));
            }
            entries += count * limb.width();
            limbs.push(limb);
            first += count;
        }
        Self { parent, limbs, rows, above, entries }
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.parent.len()
    }
}

/// A symmetric matrix of a tree, its lower half; after [`Matrix::factor`] its L'DL factors with 1/D on the diagonal.
#[derive(Clone)]
pub struct Matrix<L> {
    /// Angular, then linear.
    pub base: [[L; 6]; 6],
    /// The rows of the joints.
    pub rows: Vec<L>,
}

impl<L: Lane> Matrix<L> {
    pub fn zero(tree: &Tree) -> Self {
        Self { base: [[L::zero(); 6]; 6], rows: vec![L::zero(); tree.entries] }
    }

    #[inline(always)]
    pub fn copy(&mut self, other: &Self) {
        self.base = other.base;
        self.rows.copy_from_slice(&other.rows);
    }

    /// The product with a vector.
    pub fn times(&self, tree: &Tree, x: &[L], y: &mut [L]) {
        L::call(Times { matrix: self, tree, x, y });
    }

    /// Factorises in place; `scratch` has six numbers for every entry of the longest row.
    pub fn factor(&mut self, tree: &Tree, scratch: &mut [L]) {
        L::call(Factor { matrix: self, tree, scratch });
    }

    /// Solves with the factors, in place.
    pub fn solve(&self, tree: &Tree, x: &mut [L]) {
        L::call(Solve { matrix: self, tree, x });
    }
}

/// Calls a function with the limb's number of joints as a constant.
macro_rules! by_length {
    ($limb:expr, $function:ident($($argument:expr),*)) => {
        match $limb.joints {
            1 => $function::<L, 1>($($argument),*),
            2 => $function::<L, 2>($($argument),*),
            3 => $function::<L, 3>($($argument),*),
            4 => $function::<L, 4>($($argument),*),
            5 => $function::<L, 5>($($argument),*),
            _ => $function::<L, 6>($($argument),*),
        }
    };
}

struct Times<'a, L> {
    matrix: &'a Matrix<L>,
    tree: &'a Tree,
    x: &'a [L],
    y: &'a mut [L],
}

impl<L: Lane> Kernel<L> for Times<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { matrix, tree, x, y } = self;
        let base = &matrix.base;
        let mut sum = [L::zero(); 6];
        for i in 0..6 {
            for j in 0..i {
                sum[i] = base[i][j].fma(x[j], sum[i]);
                sum[j] = base[i][j].fma(x[i], sum[j]);
            }
            sum[i] = base[i][i].fma(x[i], sum[i]);
        }
        y[..6].copy_from_slice(&sum);
        for limb in &tree.limbs {
            let rows = &matrix.rows[limb.row..limb.row + limb.joints * limb.width()];
            by_length!(limb, times_limb(limb, rows, x, y));
        }
    }
}

#[inline(always)]
fn times_limb<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &[L], y: &mut [L]) {
    let (outer, first) = (limb.outer(), 6 + limb.first);
    let own: [L; N] = std::array::from_fn(|k| x[first + k]);
    let mut sum = [L::zero(); N];
    for j in 0..outer {
        let at = limb.column(j);
        let (xj, mut yj) = (x[at], y[at]);
        for k in 0..N {
            let entry = rows[k * (outer + N) + j];
            sum[k] = entry.fma(xj, sum[k]);
            yj = entry.fma(own[k], yj);
        }
        y[at] = yj;
    }
    for k in 0..N {
        for i in 0..k {
            let entry = rows[k * (outer + N) + outer + i];
            sum[k] = entry.fma(own[i], sum[k]);
            sum[i] = entry.fma(own[k], sum[i]);
        }
        sum[k] = rows[k * (outer + N) + outer + k].fma(own[k], sum[k]);
    }
    y[first..first + N].copy_from_slice(&sum);
}

struct Factor<'a, L> {
    matrix: &'a mut Matrix<L>,
    tree: &'a Tree,
    scratch: &'a mut [L],
}

impl<L: Lane> Kernel<L> for Factor<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { matrix, tree, scratch } = self;
        for limb in tree.limbs.iter().rev() {
            by_length!(limb, factor_limb(limb, tree, matrix, scratch));
        }
        let mut a = matrix.base;
        for k in (0..6).rev() {
            let inverse = L::splat(1.0) / a[k][k];
            a[k][k] = inverse;
            for i in (0..k).rev() {
                let s = a[k][i] * inverse;
                for j in 0..=i {
                    a[i][j] = s.fnma(a[k][j], a[i][j]);
                }
                a[k][i] = s;
            }
        }
        matrix.base = a;
    }
}

/// Eliminates the joints of a limb and takes them off the rows above.
#[inline(always)]
fn factor_limb<L: Lane, const N: usize>(limb: &Limb, tree: &Tree, matrix: &mut Matrix<L>, scratch: &mut [L]) {
    let outer = limb.outer();
    let width = outer + N;
    let rows = &mut matrix.rows[limb.row..limb.row + N * width];
    let mut a = [[L::zero(); N]; N];
    for k in 0..N {
        for i in 0..=k {
            a[k][i] = rows[k * width + outer + i];
        }
    }
    for k in (0..N).rev() {
        let inverse = L::splat(1.0) / a[k][k];
        a[k][k] = inverse;
        for i in (0..k).rev() {
            let s = a[k][i] * inverse;
            for j in 0..=i {
                a[i][j] = s.fnma(a[k][j], a[i][j]);
            }
            a[k][i] = s;
        }
    }
    // The columns before division by D go to the scratch, N for each column.
    let scratch = &mut scratch[..outer * N];
    for j in 0..outer {
        let mut v: [L; N] = std::array::from_fn(|k| rows[k * width + j]);
        for k in (0..N).rev() {
            for i in 0..k {
                v[i] = a[k][i].fnma(v[k], v[i]);
            }
        }
        for k in 0..N {
            scratch[j * N + k] = v[k];
            rows[k * width + j] = v[k] * a[k][k];
        }
    }
    for k in 0..N {
        for i in 0..=k {
            rows[k * width + outer + i] = a[k][i];
        }
    }
    for i in 0..6 {
        let scaled: [L; N] = std::array::from_fn(|k| rows[k * width + i]);
        for j in 0..=i {
            let mut b = matrix.base[i][j];
            for k in 0..N {
                b = scaled[k].fnma(scratch[j * N + k], b);
            }
            matrix.base[i][j] = b;
        }
    }
    for (index, &joint) in limb.above.iter().enumerate() {
        let scaled: [L; N] = std::array::from_fn(|k| matrix.rows[limb.row + k * width + 6 + index]);
        let (start, count) = tree.rows[joint];
        let row = &mut matrix.rows[start..start + count];
        for (j, entry) in row.iter_mut().enumerate() {
            let mut b = *entry;
            for k in 0..N {
                b = scaled[k].fnma(scratch[j * N + k], b);
            }
            *entry = b;
        }
    }
}

struct Solve<'a, L> {
    matrix: &'a Matrix<L>,
    tree: &'a Tree,
    x: &'a mut [L],
}

impl<L: Lane> Kernel<L> for Solve<'_, L> {
    type Out = ();
    #[inline(always)]
    fn run(self) {
        let Self { matrix, tree, x } = self;
        for limb in tree.limbs.iter().rev() {
            let rows = &matrix.rows[limb.row..limb.row + limb.joints * limb.width()];
            by_length!(limb, solve_up(limb, rows, x));
        }
        let base = &matrix.base;
        let mut b: [L; 6] = std::array::from_fn(|i| x[i]);
        for k in (0..6).rev() {
            for j in 0..k {
                b[j] = base[k][j].fnma(b[k], b[j]);
            }
        }
        for k in 0..6 {
            let mut a = b[k] * base[k][k];
            for j in 0..k {
                a = base[k][j].fnma(b[j], a);
            }
            b[k] = a;
        }
        x[..6].copy_from_slice(&b);
        for limb in &tree.limbs {
            let rows = &matrix.rows[limb.row..limb.row + limb.joints * limb.width()];
            by_length!(limb, solve_down(limb, rows, x));
        }
    }
}

#[inline(always)]
fn solve_up<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &mut [L]) {
    let (outer, first) = (limb.outer(), 6 + limb.first);
    let width = outer + N;
    let mut v: [L; N] = std::array::from_fn(|k| x[first + k]);
    for k in (0..N).rev() {
        for i in 0..k {
            v[i] = rows[k * width + outer + i].fnma(v[k], v[i]);
        }
    }
    for j in 0..outer {
        let at = limb.column(j);
        let mut b = x[at];
        for k in 0..N {
            b = rows[k * width + j].fnma(v[k], b);
        }
        x[at] = b;
    }
    for k in 0..N {
        x[first + k] = v[k] * rows[k * width + outer + k];
    }
}

#[inline(always)]
fn solve_down<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &mut [L]) {
    let (outer, first) = (limb.outer(), 6 + limb.first);
    let width = outer + N;
    let mut v: [L; N] = std::array::from_fn(|k| x[first + k]);
    for j in 0..outer {
        let b = x[limb.column(j)];
        for k in 0..N {
            v[k] = rows[k * width + j].fnma(b, v[k]);
        }
    }
    for k in 0..N {
        for j in 0..k {
            v[k] = rows[k * width + outer + j].fnma(v[j], v[k]);
        }
    }
    x[first..first + N].copy_from_slice(&v);
}
