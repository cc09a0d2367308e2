//! The matrix products of the update on the processor, with the same bits on every processor that has fused
//! multiply-adds.
//!
//! An entry of a product is the sum over the common dimension in its order, from zero, by fused
//! multiply-adds; products of more than [`DEPTH`] terms add up one such sum after the other. The `gemm` crate
//! takes large products: its kernels for AVX2, AVX-512 and NEON all sum in this order, in blocks of at least
//! that depth. Its fast paths for vectors and small matrices sum in the lanes of the processor's registers,
//! so these products are computed here instead. A test compares both with plain sums.

use std::ops::Range;

use gemm_common::Parallelism;

use crate::learn::backend::Beta;
use crate::learn::error::LearnError;

/// Number of terms that `gemm` 0.19 adds up in one block whatever the processor's caches: its smallest block
/// depth.
const DEPTH: usize = 512;
/// Entries of the largest matrix for which `gemm` has a fast path, unless it is a vector or the sums are
/// short.
const SMALL: usize = 16 * 16;
/// Terms of the longest sums for which `gemm` has a fast path.
const SHORT: usize = 2;
/// Neighbouring entries that are summed in parallel.
const LANES: usize = 16;

/// Numbers in memory as a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Matrix<'a> {
    numbers: &'a [f32],
    rows: usize,
    columns: usize,
    is_transposed: bool,
}

impl<'a> Matrix<'a> {
    /// Rows of this many numbers, one after the other.
    pub fn new(numbers: &'a [f32], columns: usize) -> Self {
        let rows = numbers.len() / columns;
        assert!(rows * columns == numbers.len(), "a matrix has whole rows");
        Self { numbers, rows, columns, is_transposed: false }
    }

    /// The transposed matrix.
    pub fn transposed(self) -> Self {
        Self { rows: self.columns, columns: self.rows, is_transposed: !self.is_transposed, ..self }
    }

    /// Distance in memory between neighbouring rows and between neighbouring columns, in numbers.
    fn strides(&self) -> [isize; 2] {
        if self.is_transposed { [1, self.rows as isize] } else { [self.columns as isize, 1] }
    }

    /// Index in memory of the entry in this row and column.
    #[inline(always)]
    fn place(&self, row: usize, column: usize) -> usize {
        if self.is_transposed { column * self.rows + row } else { row * self.columns + column }
    }

    /// Whether neighbours in a row are adjacent in memory.
    fn has_whole_rows(&self) -> bool {
        !self.is_transposed || self.rows == 1
    }
}

/// `target = a b + beta target`, in rows of as many numbers as `b` has columns.
pub fn multiply(target: &mut [f32], beta: Beta, a: Matrix, b: Matrix) {
    let (rows, columns, depth) = (a.rows, b.columns, a.columns);
    assert!(b.rows == depth && target.len() == rows * columns, "the shapes fit");
    if depth == 0 && beta == Beta::Zero {
        target.fill(0.0);
    }
    let mut beta = beta;
    for start in (0..depth).step_by(DEPTH) {
        let block = start..depth.min(start + DEPTH);
        let is_vector = rows == 1 || columns == 1;
        if is_vector || rows * columns <= SMALL || block.len() <= SHORT {
            multiply_small(target, beta, a, b, block);
        } else {
            multiply_large(target, beta, a, b, block);
        }
        beta = Beta::One;
    }
}

/// Fails on a processor for which `gemm` has no kernels with fused multiply-adds: its products would have
/// other bits.
pub fn check_processor() -> Result<(), LearnError> {
    is_fused().then_some(()).ok_or(LearnError::Processor)
}

fn is_fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    return cfg!(target_arch = "aarch64");
}

/// Adds up the terms of a block of at most [`DEPTH`] columns of `a` and rows of `b`, by `gemm`.
fn multiply_large(target: &mut [f32], beta: Beta, a: Matrix, b: Matrix, block: Range<usize>) {
    let (rows, columns, depth) = (a.rows, b.columns, block.len());
    assert!(
        block.end <= a.columns && a.columns == b.rows && target.len() == rows * columns,
        "the block is inside"
    );
    let (reads_target, alpha) = match beta {
        Beta::Zero => (false, 0.0),
        Beta::One => (true, 1.0),
    };
    let ([a_row, a_column], [b_row, b_column]) = (a.strides(), b.strides());
    let (a_start, b_start) = (a.place(0, block.start), b.place(block.start, 0));
    // The kernels are faster when the target's columns are contiguous in memory, so they compute the
    // transposed product from the transposed factors. SAFETY: with these strides each matrix covers exactly
    // its slice (`Matrix::new`), the block lies inside (asserted above), and no other reference to the target
    // lives.
    unsafe {
        gemm_f32::gemm::f32::get_gemm_fn()(
            columns,
            rows,
            depth,
            target.as_mut_ptr(),
            columns as isize,
            1,
            reads_target,
            b.numbers.as_ptr().add(b_start),
            b_row,
            b_column,
            a.numbers.as_ptr().add(a_start),
            a_row,
            a_column,
            alpha,
            1.0,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

/// The same without `gemm`.
fn multiply_small(target: &mut [f32], beta: Beta, a: Matrix, b: Matrix, block: Range<usize>) {
    // A column vector is computed as a row of the transposed product.
    let (a, b) = if b.columns == 1 { (b.transposed(), a.transposed()) } else { (a, b) };
    #[cfg(target_arch = "x86_64")]
    if is_fused() {
        // SAFETY: the processor has AVX2 and FMA.
        return unsafe { rows_of_product_fused(target, beta, a, b, block) };
    }
    rows_of_product(target, beta, a, b, block);
}

/// As [`rows_of_product`], with the processor's fused multiply-add instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn rows_of_product_fused(target: &mut [f32], beta: Beta, a: Matrix, b: Matrix, block: Range<usize>) {
    rows_of_product(target, beta, a, b, block);
}

/// Row by row, [`LANES`] neighbouring entries at a time.
#[inline(always)]
fn rows_of_product(target: &mut [f32], beta: Beta, a: Matrix, b: Matrix, block: Range<usize>) {
    for (row, target) in target.chunks_exact_mut(b.columns).enumerate() {
        for (part, target) in target.chunks_mut(LANES).enumerate() {
            let first = part * LANES;
            let mut sums = [0.0f32; LANES];
            for index in block.clone() {
                let x = a.numbers[a.place(row, index)];
                if b.has_whole_rows() && target.len() == LANES {
                    let start = b.place(index, first);
                    let numbers: &[f32; LANES] = b.numbers[start..start + LANES].try_into().expect("as many");
                    for lane in 0..LANES {
                        sums[lane] = x.mul_add(numbers[lane], sums[lane]);
                    }
                } else {
                    for (lane, sum) in sums.iter_mut().enumerate().take(target.len()) {
                        *sum = x.mul_add(b.numbers[b.place(index, first + lane)], *sum);
                    }
                }
            }
            for (target, sum) in target.iter_mut().zip(sums) {
                *target = if beta == Beta::One { *target + sum } else { sum };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    #[test]
    fn products_are_sums_of_products_whatever_is_transposed_and_added_to() {
        let mut stream = Stream::new("test/multiply");
        for (rows, columns, depth) in [(1, 1, 1), (4, 13, 256), (33, 87, 30), (256, 30, 1024), (5, 256, 17)] {
            let mut numbers =
                |count: usize| -> Vec<f32> { (0..count).map(|_| stream.normal() as f32).collect() };
            let (a, b, start) = (numbers(rows * depth), numbers(depth * columns), numbers(rows * columns));
            let flip = |numbers: &[f32], columns: usize| -> Vec<f32> {
                let rows = numbers.len() / columns;
                (0..columns)
                    .flat_map(|column| (0..rows).map(move |row| numbers[row * columns + column]))
                    .collect()
            };
            let (a_flipped, b_flipped) = (flip(&a, depth), flip(&b, columns));
            let ways_a = [Matrix::new(&a, depth), Matrix::new(&a_flipped, rows).transposed()];
            let ways_b = [Matrix::new(&b, columns), Matrix::new(&b_flipped, depth).transposed()];
            for (a_way, b_way) in ways_a.into_iter().flat_map(|a_way| ways_b.map(|b_way| (a_way, b_way))) {
                for beta in [Beta::Zero, Beta::One] {
                    let mut found = start.clone();
                    if beta == Beta::Zero {
                        found.fill(f32::NAN);
                    }
                    multiply(&mut found, beta, a_way, b_way);
                    for (place, found) in found.iter().enumerate() {
                        let (row, column) = (place / columns, place % columns);
                        let terms = (0..depth)
                            .map(|k| f64::from(a[row * depth + k]) * f64::from(b[k * columns + column]));
                        let first = if beta == Beta::One { f64::from(start[place]) } else { 0.0 };
                        let expected = first + terms.sum::<f64>();
                        assert!((f64::from(*found) - expected).abs() < 1e-3, "{found} is not {expected}");
                    }
                }
            }
        }
    }

    /// An entry of a product by its definition.
    fn entry(start: f32, beta: Beta, terms: &[(f32, f32)]) -> f32 {
        let blocks =
            terms.chunks(DEPTH).map(|block| block.iter().fold(0.0f32, |sum, (x, y)| x.mul_add(*y, sum)));
        let kept = if beta == Beta::One { Some(start) } else { None };
        kept.into_iter().chain(blocks).reduce(|sum, block| sum + block).unwrap_or_default()
    }

    #[test]
    fn products_have_the_bits_of_plain_sums_on_every_processor() {
        let mut stream = Stream::new("test/multiply");
        let large = [(128, 13, 256), (128, 256, 30), (512, 13, 256), (13, 256, 512), (30, 40, 1500)];
        let small =
            [(1, 256, 128), (128, 1, 256), (77, 40, 1), (64, 256, 2), (5, 3, 500), (1, 1, 600), (16, 16, 40)];
        for (rows, columns, depth) in large.into_iter().chain(small) {
            let mut numbers =
                |count: usize| -> Vec<f32> { (0..count).map(|_| stream.normal() as f32).collect() };
            let (a, b, start) = (numbers(rows * depth), numbers(depth * columns), numbers(rows * columns));
            let plain_a = Matrix::new(&a, depth);
            for (a, b) in [
                (plain_a, Matrix::new(&b, columns)),
                (plain_a, Matrix::new(&b, depth).transposed()),
                (Matrix::new(&a, rows).transposed(), Matrix::new(&b, columns)),
            ] {
                for beta in [Beta::Zero, Beta::One] {
                    let mut found = start.clone();
                    multiply(&mut found, beta, a, b);
                    let wrong = found.iter().enumerate().filter(|(place, found)| {
                        let (row, column) = (place / columns, place % columns);
                        let term =
                            |index| (a.numbers[a.place(row, index)], b.numbers[b.place(index, column)]);
                        let terms: Vec<(f32, f32)> = (0..depth).map(term).collect();
                        entry(start[*place], beta, &terms).to_bits() != found.to_bits()
                    });
                    assert_eq!(wrong.count(), 0, "{rows} x {columns} from {depth}, {beta:?}");
                }
            }
        }
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused_before_memory_is_touched() {
        let refused = std::panic::catch_unwind(|| {
            multiply(&mut [0.0; 4], Beta::Zero, Matrix::new(&[1.0; 4], 2), Matrix::new(&[1.0; 6], 2));
        });
        let words = refused.expect_err("two by two is not three by two");
        assert_eq!(words.downcast_ref::<&str>(), Some(&"the shapes fit"));
    }
}
