//! The tree of joints, and symmetric matrices with zeros between its branches.
//!
//! Joints are counted depth first. A *limb* is a run of joints without a branch, at most [`LONGEST`] of them;
//! every row of a matrix has entries for the base (6), for the joints above its limb, and for its own limb.
//! L'DL factorisation of such a matrix needs no entries beyond these (Featherstone 2008, section 6.5).

#![expect(
    clippy::needless_range_loop,
    reason = "indices run over axes, rows and columns in step, as the equations do"
)]

use std::ops::Range;

use super::lane::{Kernel, Lane};

/// Largest number of joints of a limb: loops over them are unrolled.
pub const LONGEST: usize = 6;

/// A run of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Its first joint.
    pub first: usize,
    /// Number of joints.
    pub joints: usize,
    /// The joints between the base and the limb, from the base down.
    pub above: Vec<usize>,
    /// Index of its block in a matrix: the columns of its rows one after the other, each with one number per
    /// joint, so that a column is an array of known length.
    pub block: usize,
    /// Index in a vector for each column before the limb's own.
    columns: Vec<usize>,
}

impl Limb {
    fn new(first: usize, joints: usize, above: Vec<usize>, block: usize) -> Self {
        let columns = (0..6).chain(above.iter().map(|joint| 6 + joint)).collect();
        Self { first, joints, above, block, columns }
    }
    /// Number of columns before the limb's own.
    #[inline(always)]
    pub fn outer(&self) -> usize {
        6 + self.above.len()
    }
    /// Range of its block.
    #[inline(always)]
    pub fn range(&self) -> Range<usize> {
        self.block..self.block + self.joints * (self.outer() + self.joints)
    }
}

/// The row of a joint, up to its diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its first entry.
    pub start: usize,
    /// Distance between entries.
    pub stride: usize,
    /// Number of entries.
    pub count: usize,
}

impl Row {
    /// Index of an entry.
    #[inline(always)]
    pub fn at(self, entry: usize) -> usize {
        self.start + entry * self.stride
    }
    /// Index of the diagonal entry.
    #[inline(always)]
    pub fn diagonal(self) -> usize {
        self.at(self.count - 1)
    }
}

/// Structure of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Parent body of each joint; body 0 is the base, body `i + 1` that of joint `i`.
    pub parent: Vec<usize>,
    /// Its limbs, parents first.
    pub limbs: Vec<Limb>,
    /// The rows of the joints in a matrix.
    pub rows: Vec<Row>,
    /// The joints above each joint, from the base down.
    pub above: Vec<Vec<usize>>,
    /// Number of matrix entries outside the base block.
    pub entries: usize,
}

impl Tree {
    /// Depth-first order of a tree's joints; children in the order of their indices.
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

    /// The tree of joints in depth-first order.
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
            let limb = Limb::new(first, count, above[first].clone(), entries);
            rows.extend((0..count).map(|k| Row {
                start: entries + k,
                stride: count,
                count: limb.outer() + k + 1,
            }));
            entries = limb.range().end;
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

/// A symmetric matrix of a tree, its lower half; after [`Matrix::factor`] its L'DL factors with 1/D on the
/// diagonal.
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

/// The block of a limb: the columns before its own, and its own.
#[inline(always)]
pub fn block<'a, L, const N: usize>(limb: &Limb, numbers: &'a [L]) -> (&'a [[L; N]], &'a [[L; N]; N]) {
    let (outer, own) = numbers.as_chunks::<N>().0.split_at(limb.outer());
    (outer, own.first_chunk().expect("a block ends with the limb's own columns"))
}

/// As [`block`], mutable.
#[inline(always)]
pub fn block_mut<'a, L, const N: usize>(
    limb: &Limb,
    numbers: &'a mut [L],
) -> (&'a mut [[L; N]], &'a mut [[L; N]; N]) {
    let (outer, own) = numbers.as_chunks_mut::<N>().0.split_at_mut(limb.outer());
    (outer, own.first_chunk_mut().expect("a block ends with the limb's own columns"))
}

/// Part of a vector, from an index on.
#[inline(always)]
fn part_of<L: Lane, const N: usize>(x: &[L], first: usize) -> [L; N] {
    *x[first..].first_chunk().expect("a vector has a number for every joint")
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

pub(super) use by_length;

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
            let rows = &matrix.rows[limb.range()];
            by_length!(limb, times_limb(limb, rows, x, y));
        }
    }
}

#[inline(always)]
fn times_limb<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &[L], y: &mut [L]) {
    let first = 6 + limb.first;
    let (outer, own) = block::<L, N>(limb, rows);
    let (x_own, mut sum) = (part_of::<L, N>(x, first), [L::zero(); N]);
    for j in 0..outer.len() {
        let (column, at) = (&outer[j], limb.columns[j]);
        let (xj, mut yj) = (x[at], y[at]);
        for k in 0..N {
            sum[k] = column[k].fma(xj, sum[k]);
            yj = column[k].fma(x_own[k], yj);
        }
        y[at] = yj;
    }
    for k in 0..N {
        for i in 0..k {
            sum[k] = own[i][k].fma(x_own[i], sum[k]);
            sum[i] = own[i][k].fma(x_own[k], sum[i]);
        }
        sum[k] = own[k][k].fma(x_own[k], sum[k]);
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

/// Eliminates the joints of a limb and subtracts them from the rows above.
#[inline(always)]
fn factor_limb<L: Lane, const N: usize>(limb: &Limb, tree: &Tree, matrix: &mut Matrix<L>, scratch: &mut [L]) {
    let (higher, rows) = matrix.rows.split_at_mut(limb.block);
    let (outer, own) = block_mut::<L, N>(limb, &mut rows[..limb.range().len()]);
    let mut a = [[L::zero(); N]; N];
    for k in 0..N {
        for i in 0..=k {
            a[k][i] = own[i][k];
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
    for k in 0..N {
        for i in 0..=k {
            own[i][k] = a[k][i];
        }
    }
    // The columns before division by D are stored in the scratch.
    let undivided = &mut scratch.as_chunks_mut::<N>().0[..outer.len()];
    for j in 0..outer.len() {
        let mut v = outer[j];
        for k in (0..N).rev() {
            for i in 0..k {
                v[i] = a[k][i].fnma(v[k], v[i]);
            }
        }
        undivided[j] = v;
        for k in 0..N {
            outer[j][k] = v[k] * a[k][k];
        }
    }
    let less = |mut entry: L, scaled: &[L; N], undivided: &[L; N]| {
        for k in 0..N {
            entry = scaled[k].fnma(undivided[k], entry);
        }
        entry
    };
    for i in 0..6 {
        for j in 0..=i {
            matrix.base[i][j] = less(matrix.base[i][j], &outer[i], &undivided[j]);
        }
    }
    for i in 0..limb.above.len() {
        let (scaled, row) = (&outer[6 + i], tree.rows[limb.above[i]]);
        for j in 0..row.count {
            let entry = &mut higher[row.at(j)];
            *entry = less(*entry, scaled, &undivided[j]);
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
            let rows = &matrix.rows[limb.range()];
            by_length!(limb, solve_up(limb, rows, x));
        }
        let base = &matrix.base;
        let mut b = part_of::<L, 6>(x, 0);
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
            let rows = &matrix.rows[limb.range()];
            by_length!(limb, solve_down(limb, rows, x));
        }
    }
}

#[inline(always)]
fn solve_up<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &mut [L]) {
    let first = 6 + limb.first;
    let (outer, own) = block::<L, N>(limb, rows);
    let mut v = part_of::<L, N>(x, first);
    for k in (0..N).rev() {
        for i in 0..k {
            v[i] = own[i][k].fnma(v[k], v[i]);
        }
    }
    for j in 0..outer.len() {
        let (column, at) = (&outer[j], limb.columns[j]);
        let mut b = x[at];
        for k in 0..N {
            b = column[k].fnma(v[k], b);
        }
        x[at] = b;
    }
    for k in 0..N {
        x[first + k] = v[k] * own[k][k];
    }
}

#[inline(always)]
fn solve_down<L: Lane, const N: usize>(limb: &Limb, rows: &[L], x: &mut [L]) {
    let first = 6 + limb.first;
    let (outer, own) = block::<L, N>(limb, rows);
    let mut v = part_of::<L, N>(x, first);
    for j in 0..outer.len() {
        let (column, b) = (&outer[j], x[limb.columns[j]]);
        for k in 0..N {
            v[k] = column[k].fnma(b, v[k]);
        }
    }
    for k in 0..N {
        for j in 0..k {
            v[k] = own[j][k].fnma(v[j], v[k]);
        }
    }
    x[first..first + N].copy_from_slice(&v);
}
