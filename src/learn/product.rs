//! The matrix product of the plain-Rust inference: rows of inputs times a layer's weights, stored in panels.
//!
//! An output starts at its bias and adds the inputs one after the other, each with one fused multiply-add, so
//! its bits depend on neither the batch nor the processor. General matrix products first copy the weights
//! into panels; for the few rows of a rollout's group the copy costs more than the product, so the panels are
//! made once per network.

use super::network::Layer;

/// Numbers in a vector: the size of the widest registers.
const LANES: usize = 16;
/// Vectors of outputs that a wide panel holds: with four rows their sums just fit the registers of AVX-512.
const WIDE: usize = 4;
/// Rows computed per load of a panel.
const ROWS: usize = 4;

/// A vector of neighbouring outputs.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Vector([f32; LANES]);

/// Neighbouring outputs of a layer: for every input in turn the weights to these outputs, the last vector
/// padded with zeros.
#[derive(Clone, Debug)]
struct Panel {
    first: usize,
    outputs: usize,
    vectors: usize,
    bias: Vec<Vector>,
    weights: Vec<Vector>,
}

/// A layer's weights and biases in panels.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    panels: Vec<Panel>,
}

impl Panels {
    /// Copies a layer into panels.
    pub(super) fn new(layer: &Layer) -> Self {
        let mut panels = Vec::new();
        let mut first = 0;
        while first < layer.outputs {
            let vectors = if layer.outputs - first >= WIDE * LANES { WIDE } else { 1 };
            let outputs = (layer.outputs - first).min(vectors * LANES);
            panels.push(Panel::new(layer, first..first + outputs, vectors));
            first += outputs;
        }
        Self { inputs: layer.inputs, outputs: layer.outputs, panels }
    }

    /// Writes `weight * input + bias` for each row.
    pub(super) fn apply(&self, inputs: &[f32], outputs: &mut [f32]) {
        assert!(inputs.len() * self.outputs == outputs.len() * self.inputs, "a layer's shape is kept");
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has AVX-512F.
            return unsafe { wide::apply_avx512(self, inputs, outputs) };
        }
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            // SAFETY: the processor has AVX2 and FMA.
            return unsafe { wide::apply_avx2(self, inputs, outputs) };
        }
        self.apply_plain(inputs, outputs);
    }

    /// The product without vector registers.
    fn apply_plain(&self, inputs: &[f32], outputs: &mut [f32]) {
        for (input, output) in inputs.chunks_exact(self.inputs).zip(outputs.chunks_exact_mut(self.outputs)) {
            for panel in &self.panels {
                for vector in 0..panel.vectors {
                    let mut sums = panel.bias[vector].0;
                    for (index, x) in input.iter().enumerate() {
                        let weights = &panel.weights[index * panel.vectors + vector].0;
                        sums.iter_mut()
                            .zip(weights)
                            .for_each(|(sum, weight)| *sum = x.mul_add(*weight, *sum));
                    }
                    panel.store(vector, &sums, output);
                }
            }
        }
    }
}

impl Panel {
    fn new(layer: &Layer, range: std::ops::Range<usize>, vectors: usize) -> Self {
        let padded = |vector: usize, of: &dyn Fn(usize) -> f32| {
            let place = |lane| range.start + vector * LANES + lane;
            Vector(std::array::from_fn(|lane| if place(lane) < range.end { of(place(lane)) } else { 0.0 }))
        };
        let weight = |input: usize| move |output: usize| layer.weight[output * layer.inputs + input];
        let rows = (0..layer.inputs).flat_map(|input| (0..vectors).map(move |vector| (input, vector)));
        Self {
            first: range.start,
            outputs: range.len(),
            vectors,
            bias: (0..vectors).map(|vector| padded(vector, &|output| layer.bias[output])).collect(),
            weights: rows.map(|(input, vector)| padded(vector, &weight(input))).collect(),
        }
    }

    /// Writes the sums of one of the panel's vectors to a row of outputs.
    #[inline]
    fn store(&self, vector: usize, sums: &[f32; LANES], row: &mut [f32]) {
        let count = (self.outputs - vector * LANES).min(LANES);
        let start = self.first + vector * LANES;
        row[start..start + count].copy_from_slice(&sums[..count]);
    }
}

/// The same sums in vector registers.
#[cfg(target_arch = "x86_64")]
#[expect(clippy::needless_range_loop, reason = "indices of constant length keep the sums in registers")]
mod wide {
    use std::arch::x86_64::*;

    use super::{LANES, Panel, Panels, ROWS, WIDE};

    #[target_feature(enable = "avx512f")]
    pub fn apply_avx512(layer: &Panels, inputs: &[f32], outputs: &mut [f32]) {
        let blocks = inputs.chunks(ROWS * layer.inputs).zip(outputs.chunks_mut(ROWS * layer.outputs));
        for (inputs, outputs) in blocks {
            for panel in &layer.panels {
                match (panel.vectors, outputs.len() == ROWS * layer.outputs) {
                    (WIDE, true) => sums_avx512::<ROWS, WIDE>(panel, inputs, outputs),
                    (_, true) => sums_avx512::<ROWS, 1>(panel, inputs, outputs),
                    (vectors, false) => {
                        let rows =
                            inputs.chunks_exact(layer.inputs).zip(outputs.chunks_exact_mut(layer.outputs));
                        for (input, output) in rows {
                            match vectors {
                                WIDE => sums_avx512::<1, WIDE>(panel, input, output),
                                _ => sums_avx512::<1, 1>(panel, input, output),
                            }
                        }
                    }
                }
            }
        }
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    fn sums_avx512<const R: usize, const V: usize>(panel: &Panel, inputs: &[f32], outputs: &mut [f32]) {
        let (width, count) = (inputs.len() / R, outputs.len() / R);
        assert!(panel.vectors == V && panel.weights.len() == width * V && inputs.len() == R * width);
        let mut sums = [[_mm512_setzero_ps(); V]; R];
        for row in &mut sums {
            for v in 0..V {
                // SAFETY: a vector holds sixteen numbers.
                row[v] = unsafe { _mm512_load_ps(panel.bias[v].0.as_ptr()) };
            }
        }
        let mut weight = [_mm512_setzero_ps(); V];
        for index in 0..width {
            for v in 0..V {
                // SAFETY: there are `width * V` vectors, of sixteen numbers each.
                weight[v] = unsafe { _mm512_load_ps(panel.weights.get_unchecked(index * V + v).0.as_ptr()) };
            }
            for r in 0..R {
                // SAFETY: there are `R * width` inputs.
                let x = _mm512_set1_ps(unsafe { *inputs.get_unchecked(r * width + index) });
                for v in 0..V {
                    sums[r][v] = _mm512_fmadd_ps(x, weight[v], sums[r][v]);
                }
            }
        }
        for (r, row) in sums.iter().enumerate() {
            for (v, sum) in row.iter().enumerate() {
                let mut numbers = [0.0; LANES];
                // SAFETY: the array has room for sixteen numbers.
                unsafe { _mm512_storeu_ps(numbers.as_mut_ptr(), *sum) };
                panel.store(v, &numbers, &mut outputs[r * count..(r + 1) * count]);
            }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn apply_avx2(layer: &Panels, inputs: &[f32], outputs: &mut [f32]) {
        let blocks = inputs.chunks(ROWS * layer.inputs).zip(outputs.chunks_mut(ROWS * layer.outputs));
        for (inputs, outputs) in blocks {
            for panel in &layer.panels {
                for vector in 0..panel.vectors {
                    if outputs.len() == ROWS * layer.outputs {
                        sums_avx2::<ROWS>(panel, vector, inputs, outputs);
                        continue;
                    }
                    let rows = inputs.chunks_exact(layer.inputs).zip(outputs.chunks_exact_mut(layer.outputs));
                    for (input, output) in rows {
                        sums_avx2::<1>(panel, vector, input, output);
                    }
                }
            }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn sums_avx2<const R: usize>(panel: &Panel, vector: usize, inputs: &[f32], outputs: &mut [f32]) {
        let (width, count) = (inputs.len() / R, outputs.len() / R);
        let mut sums = [[_mm256_setzero_ps(); 2]; R];
        let bias = &panel.bias[vector].0;
        for row in &mut sums {
            for half in 0..2 {
                // SAFETY: a vector holds two times eight numbers.
                row[half] = unsafe { _mm256_load_ps(bias.as_ptr().add(8 * half)) };
            }
        }
        for index in 0..width {
            let weights = &panel.weights[index * panel.vectors + vector].0;
            // SAFETY: a vector holds two times eight numbers.
            let weights =
                unsafe { [_mm256_load_ps(weights.as_ptr()), _mm256_load_ps(weights.as_ptr().add(8))] };
            for r in 0..R {
                let x = _mm256_set1_ps(inputs[r * width + index]);
                for half in 0..2 {
                    sums[r][half] = _mm256_fmadd_ps(x, weights[half], sums[r][half]);
                }
            }
        }
        for (r, row) in sums.iter().enumerate() {
            let mut numbers = [0.0; LANES];
            for (half, sum) in row.iter().enumerate() {
                // SAFETY: the array has room for two times eight numbers.
                unsafe { _mm256_storeu_ps(numbers.as_mut_ptr().add(8 * half), *sum) };
            }
            panel.store(vector, &numbers, &mut outputs[r * count..(r + 1) * count]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    #[test]
    fn every_version_gives_the_same_bits_and_the_right_sums() {
        let mut stream = Stream::new("test/product");
        for (inputs, outputs, rows) in
            [(30, 13, 9), (1, 1, 1), (16, 4, 4), (33, 87, 3), (256, 256, 5), (40, 64, 8)]
        {
            let mut numbers =
                |count: usize| -> Vec<f32> { (0..count).map(|_| stream.normal() as f32).collect() };
            let layer = Layer { weight: numbers(inputs * outputs), bias: numbers(outputs), inputs, outputs };
            let panels = Panels::new(&layer);
            let batch = numbers(rows * inputs);
            let mut fast = vec![0.0; rows * outputs];
            let mut plain = fast.clone();
            panels.apply(&batch, &mut fast);
            panels.apply_plain(&batch, &mut plain);
            assert!(fast.iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()));
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                fast.fill(0.0);
                // SAFETY: the processor has AVX2 and FMA.
                unsafe { wide::apply_avx2(&panels, &batch, &mut fast) };
                assert!(fast.iter().zip(&plain).all(|(a, b)| a.to_bits() == b.to_bits()));
            }
            for (index, found) in fast.iter().enumerate() {
                let (row, output) = (index / outputs, index % outputs);
                let weight = &layer.weight[output * inputs..(output + 1) * inputs];
                let products =
                    weight.iter().zip(&batch[row * inputs..]).map(|(w, x)| f64::from(*w) * f64::from(*x));
                let expected = f64::from(layer.bias[output]) + products.sum::<f64>();
                assert!((f64::from(*found) - expected).abs() < 1e-4, "{found} is not {expected}");
            }
        }
    }
}
