//! The matrix products of the update on the processor, by the `gemm` crate: it takes the widest registers that the
//! processor has, whoever made it. One thread, fixed shapes: the same numbers give the same bits on a machine.

use gemm::Parallelism;

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

    /// Its columns as rows.
    pub fn transposed(self) -> Self {
        Self { rows: self.columns, columns: self.rows, is_transposed: !self.is_transposed, ..self }
    }

    /// How far apart neighbours in a column and in a row are.
    fn strides(&self) -> (isize, isize) {
        if self.is_transposed { (1, self.rows as isize) } else { (self.columns as isize, 1) }
    }
}

/// What stands in the target of a product before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// Nothing that is kept.
    Nothing,
    /// Numbers that the product is added to.
    Sum,
}

/// Writes `a b` into rows of as many numbers as `b` has columns, or adds it to what stands there.
pub fn multiply(target: &mut [f32], before: Before, a: Matrix, b: Matrix) {
    let (rows, columns, depth) = (a.rows, b.columns, a.columns);
    assert!(b.rows == depth && target.len() == rows * columns, "the shapes fit");
    let (kept, factor) = (before == Before::Sum, if before == Before::Sum { 1.0 } else { 0.0 });
    let ((a_row, a_column), (b_row, b_column)) = (a.strides(), b.strides());
    // SAFETY: with these strides each matrix is its whole slice, by `Matrix::new` and the assertion above, and no
    // other reference to the target lives.
    unsafe {
        gemm::gemm(
            rows,
            columns,
            depth,
            target.as_mut_ptr(),
            1,
            columns as isize,
            kept,
            a.numbers.as_ptr(),
            a_column,
            a_row,
            b.numbers.as_ptr(),
            b_column,
            b_row,
            factor,
            1.0,
            false,
            false,
            false,
            Parallelism::None,
        );
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
            let mut numbers = |count: usize| -> Vec<f32> { (0..count).map(|_| stream.normal() as f32).collect() };
            let (a, b, start) = (numbers(rows * depth), numbers(depth * columns), numbers(rows * columns));
            let flip = |numbers: &[f32], columns: usize| -> Vec<f32> {
                let rows = numbers.len() / columns;
                (0..columns).flat_map(|column| (0..rows).map(move |row| numbers[row * columns + column])).collect()
            };
            let (a_flipped, b_flipped) = (flip(&a, depth), flip(&b, columns));
            let ways_a = [Matrix::new(&a, depth), Matrix::new(&a_flipped, rows).transposed()];
            let ways_b = [Matrix::new(&b, columns), Matrix::new(&b_flipped, depth).transposed()];
            for (a_way, b_way) in ways_a.into_iter().flat_map(|a_way| ways_b.map(|b_way| (a_way, b_way))) {
                for before in [Before::Nothing, Before::Sum] {
                    let mut found = start.clone();
                    if before == Before::Nothing {
                        found.fill(f32::NAN);
                    }
                    multiply(&mut found, before, a_way, b_way);
                    for (place, found) in found.iter().enumerate() {
                        let (row, column) = (place / columns, place % columns);
                        let terms =
                            (0..depth).map(|k| f64::from(a[row * depth + k]) * f64::from(b[k * columns + column]));
                        let first = if before == Before::Sum { f64::from(start[place]) } else { 0.0 };
                        let expected = first + terms.sum::<f64>();
                        assert!((f64::from(*found) - expected).abs() < 1e-3, "{found} is not {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused_before_memory_is_touched() {
        let refused = std::panic::catch_unwind(|| {
            multiply(&mut [0.0; 4], Before::Nothing, Matrix::new(&[1.0; 4], 2), Matrix::new(&[1.0; 6], 2));
        });
        let words = refused.expect_err("two by two is not three by two");
        assert_eq!(words.downcast_ref::<&str>(), Some(&"the shapes fit"));
    }
}
