//! Named random streams: all randomness of a run.
//!
//! A stream is a ChaCha8 generator keyed by the BLAKE3 hash of its name (`1/train/env/17/episode/42`, where 1
//! is the run's seed), so streams do not depend on each other, on the thread that draws from them or on the
//! order of their creation, and a resumed run needs no stored state.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::spec::Sampler;

/// A named random stream.
#[derive(Clone, Debug)]
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// The stream with this name.
    pub fn new(name: &str) -> Self {
        let key = blake3::derive_key("specforge random stream v1", name.as_bytes());
        Self { generator: ChaCha8Rng::from_seed(key) }
    }

    /// A uniform number in `[0, 1)` with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A uniform whole number in `0..count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.generator.next_u64()) * count as u128) >> 64) as usize
    }

    /// A standard normal number (ziggurat method, Marsaglia and Tsang 2000): usually consumes one number of
    /// the generator, rarely more.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.generator)
    }

    /// A draw from a distribution; always consumes two uniform numbers, so that later draws do not depend on
    /// the distribution.
    pub fn draw(&mut self, sampler: &Sampler) -> f64 {
        let (first, second) = (self.uniform(), self.uniform());
        sampler.draw(first, second)
    }

    /// A random order of `0..count` (Fisher and Yates 1938).
    pub fn permutation(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.below(last + 1));
        }
        order
    }
}
