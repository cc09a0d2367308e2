//! The matrix product of the plain-Rust inference: rows of inputs times a layer's weights as they are stored.
//!
//! Each output is a dot product in sixteen interleaved fused multiply-adds, summed in a fixed tree, so its bits depend
//! on neither the batch nor the processor. General matrix products first copy the weights into panels; for the small
//! batches of a rollout that costs more than the product.

use super::network::Layer;

/// Interleaved sums of a dot product.
const LANES: usize = 16;

/// Writes `weight * input + bias` for each row.
pub(super) fn apply(layer: &Layer, inputs: &[f32], outputs: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the processor has AVX-512F.
        return unsafe { wide::apply_avx512(layer, inputs, outputs) };
    }
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has AVX2 and FMA.
        return unsafe { wide::apply_avx2(layer, inputs, outputs) };
    }
    apply_blocks(layer, inputs, outputs, dots::<2, 2>, dots::<1, 2>);
}

/// Goes through the outputs in blocks of `R` rows and `O` outputs, whose sums stay in registers.
#[inline(always)]
fn apply_blocks<const R: usize, const O: usize>(
    layer: &Layer,
    inputs: &[f32],
    outputs: &mut [f32],
    dots: impl Fn([&[f32]; R], [&[f32]; O]) -> [[f32; O]; R],
    dots_of_one: impl Fn([&[f32]; 1], [&[f32]; O]) -> [[f32; O]; 1],
) {
    let (width, count) = (layer.inputs, layer.outputs);
    let input_blocks = inputs.chunks(R * width);
    for (inputs, outputs) in input_blocks.zip(outputs.chunks_mut(R * count)) {
        let rows = outputs.len() / count;
        let mut first = 0;
        if rows == R {
            let rows: [&[f32]; R] = std::array::from_fn(|row| &inputs[row * width..(row + 1) * width]);
            while first + O <= count {
                let weights = std::array::from_fn(|o| &layer.weight[(first + o) * width..(first + o + 1) * width]);
                let block = dots(rows, weights);
                for (row, sums) in block.iter().enumerate() {
                    for (o, sum) in sums.iter().enumerate() {
                        outputs[row * count + first + o] = layer.bias[first + o] + sum;
                    }
                }
                first += O;
            }
        }
        for row in 0..rows {
            let input = &inputs[row * width..(row + 1) * width];
            let mut next = first;
            while next < count {
                let size = (count - next).min(O);
                let weights: [&[f32]; O] = std::array::from_fn(|o| {
                    let at = next + o.min(size - 1);
                    &layer.weight[at * width..(at + 1) * width]
                });
                let [sums] = dots_of_one([input], weights);
                for o in 0..size {
                    outputs[row * count + next + o] = layer.bias[next + o] + sums[o];
                }
                next += size;
            }
        }
    }
}

/// All dot products of some rows with some weights.
#[inline(always)]
fn dots<const R: usize, const O: usize>(rows: [&[f32]; R], weights: [&[f32]; O]) -> [[f32; O]; R] {
    let rows = rows.map(|row| row.as_chunks::<LANES>());
    let weights = weights.map(|weight| weight.as_chunks::<LANES>());
    let mut sums = [[[0.0f32; LANES]; O]; R];
    let chunks = rows[0].0.len();
    for chunk in 0..chunks {
        let weight: [[f32; LANES]; O] = std::array::from_fn(|o| weights[o].0[chunk]);
        for r in 0..R {
            let row = rows[r].0[chunk];
            for o in 0..O {
                accumulate(&mut sums[r][o], &row, &weight[o]);
            }
        }
    }
    if !rows[0].1.is_empty() {
        let weight: [[f32; LANES]; O] = std::array::from_fn(|o| padded(weights[o].1));
        for r in 0..R {
            let row = padded(rows[r].1);
            for o in 0..O {
                accumulate(&mut sums[r][o], &row, &weight[o]);
            }
        }
    }
    sums.map(|sums| sums.map(total))
}

#[inline(always)]
fn accumulate(sum: &mut [f32; LANES], row: &[f32; LANES], weight: &[f32; LANES]) {
    for lane in 0..LANES {
        sum[lane] = row[lane].mul_add(weight[lane], sum[lane]);
    }
}

/// Numbers followed by zeros.
#[inline(always)]
fn padded(numbers: &[f32]) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    lanes[..numbers.len()].copy_from_slice(numbers);
    lanes
}

/// The sum of all lanes, halves first.
#[inline(always)]
fn total(lanes: [f32; LANES]) -> f32 {
    let eight: [f32; 8] = std::array::from_fn(|lane| lanes[lane] + lanes[lane + 8]);
    let four: [f32; 4] = std::array::from_fn(|lane| eight[lane] + eight[lane + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

/// The same dot products in vector registers.
#[cfg(target_arch = "x86_64")]
mod wide {
    use std::arch::x86_64::*;

    use super::{LANES, Layer, apply_blocks, total};

    #[target_feature(enable = "avx512f")]
    pub fn apply_avx512(layer: &Layer, inputs: &[f32], outputs: &mut [f32]) {
        apply_blocks(layer, inputs, outputs, |x, w| dots_avx512::<4, 4>(x, w), |x, w| dots_avx512::<1, 4>(x, w));
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn apply_avx2(layer: &Layer, inputs: &[f32], outputs: &mut [f32]) {
        apply_blocks(layer, inputs, outputs, |x, w| dots_avx2::<2, 2>(x, w), |x, w| dots_avx2::<1, 2>(x, w));
    }

    // Plain loops, because a closure is not compiled for the vector registers of the function around it.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn dots_avx512<const R: usize, const O: usize>(rows: [&[f32]; R], weights: [&[f32]; O]) -> [[f32; O]; R] {
        let length = rows[0].len();
        assert!(rows.iter().chain(&weights).all(|numbers| numbers.len() == length));
        let mut sums = [[_mm512_setzero_ps(); O]; R];
        let mut start = 0;
        while start < length {
            let mask = if length - start >= LANES { !0 } else { (1 << (length - start)) - 1 };
            let mut weight = [_mm512_setzero_ps(); O];
            for o in 0..O {
                // SAFETY: the mask keeps the load inside the slice, which is `length` long.
                weight[o] = unsafe { _mm512_maskz_loadu_ps(mask, weights[o].as_ptr().add(start)) };
            }
            for r in 0..R {
                // SAFETY: as above.
                let row = unsafe { _mm512_maskz_loadu_ps(mask, rows[r].as_ptr().add(start)) };
                for o in 0..O {
                    sums[r][o] = _mm512_fmadd_ps(row, weight[o], sums[r][o]);
                }
            }
            start += LANES;
        }
        let mut totals = [[0.0; O]; R];
        for r in 0..R {
            for o in 0..O {
                totals[r][o] = total_avx512(sums[r][o]);
            }
        }
        totals
    }

    /// The same sum as `total`.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn total_avx512(lanes: __m512) -> f32 {
        let high = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(lanes)));
        let eight = _mm256_add_ps(_mm512_castps512_ps256(lanes), high);
        let four = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
        let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two)))
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn dots_avx2<const R: usize, const O: usize>(rows: [&[f32]; R], weights: [&[f32]; O]) -> [[f32; O]; R] {
        let length = rows[0].len();
        let mut sums = [[[_mm256_setzero_ps(); 2]; O]; R];
        for start in (0..length).step_by(LANES) {
            let load = |numbers: &[f32]| {
                let mut lanes = [0.0; LANES];
                let end = length.min(start + LANES);
                lanes[..end - start].copy_from_slice(&numbers[start..end]);
                // SAFETY: the array holds sixteen numbers.
                unsafe { [_mm256_loadu_ps(lanes.as_ptr()), _mm256_loadu_ps(lanes.as_ptr().add(8))] }
            };
            let weight = weights.map(load);
            for (sums, row) in sums.iter_mut().zip(rows) {
                let row = load(row);
                for (sum, weight) in sums.iter_mut().zip(weight) {
                    *sum = [_mm256_fmadd_ps(row[0], weight[0], sum[0]), _mm256_fmadd_ps(row[1], weight[1], sum[1])];
                }
            }
        }
        sums.map(|sums| {
            sums.map(|sum| {
                let mut lanes = [0.0; LANES];
                // SAFETY: the array has room for sixteen numbers.
                unsafe {
                    _mm256_storeu_ps(lanes.as_mut_ptr(), sum[0]);
                    _mm256_storeu_ps(lanes.as_mut_ptr().add(8), sum[1]);
                }
                total(lanes)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    #[test]
    fn every_version_gives_the_same_bits_and_the_right_sums() {
        let mut stream = Stream::new("test/product");
        for (inputs, outputs, rows) in [(30, 13, 9), (1, 1, 1), (16, 4, 4), (33, 7, 3), (256, 31, 5)] {
            let mut numbers = |count: usize| -> Vec<f32> { (0..count).map(|_| stream.normal() as f32).collect() };
            let layer = Layer { weight: numbers(inputs * outputs), bias: numbers(outputs), inputs, outputs };
            let batch = numbers(rows * inputs);
            let mut fast = vec![0.0; rows * outputs];
            let mut plain = fast.clone();
            apply(&layer, &batch, &mut fast);
            apply_blocks(&layer, &batch, &mut plain, dots::<2, 2>, dots::<1, 2>);
            assert!(fast.iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()));
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                // SAFETY: the processor has AVX2 and FMA.
                unsafe { wide::apply_avx2(&layer, &batch, &mut fast) };
                assert!(fast.iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()));
            }
            for (index, found) in fast.iter().enumerate() {
                let (row, output) = (index / outputs, index % outputs);
                let weight = &layer.weight[output * inputs..(output + 1) * inputs];
                let products = weight.iter().zip(&batch[row * inputs..]).map(|(w, x)| f64::from(*w) * f64::from(*x));
                let expected = f64::from(layer.bias[output]) + products.sum::<f64>();
                assert!((f64::from(*found) - expected).abs() < 1e-4, "{found} is not {expected}");
            }
        }
    }
}
