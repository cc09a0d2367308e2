//! One number per environment: arithmetic that gives the same bits under every instruction set.
//!
//! Only IEEE operations (+, -, *, /, square root, fused multiply-add), comparisons and selections. Nothing
//! here adds up the lanes of a value, so a lane never depends on its neighbours.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// One truth value per lane.
pub trait Mask: Copy + Send + Sync + 'static {
    /// The same value in every lane.
    fn splat(value: bool) -> Self;
    /// Logical and.
    fn and(self, other: Self) -> Self;
    /// Logical or.
    fn or(self, other: Self) -> Self;
    /// Logical not.
    fn not(self) -> Self;
    /// Whether any lane is true.
    fn any(self) -> bool;
}

/// Code that is compiled for the instruction set of a lane type.
pub trait Kernel<L> {
    /// Its result.
    type Out;
    /// The code; must be `#[inline(always)]`, otherwise it is compiled without the instruction set.
    fn run(self) -> Self::Out;
}

/// One `f64` per environment.
pub trait Lane:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Number of lanes.
    const LANES: usize;
    /// Truth values of as many lanes.
    type Mask: Mask;
    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// `self * b + c`, rounded once.
    fn fma(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, rounded once.
    fn fnma(self, b: Self, c: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Approximate inverse square root of a positive normal number, within 3.5 %: half the exponent, computed
    /// on the bits.
    fn rough_inverse_root(self) -> Self;
    /// The smaller one; `other` if they are equal or one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` if they are equal or one is NaN.
    fn max(self, other: Self) -> Self;
    /// Whether it is less.
    fn lt(self, other: Self) -> Self::Mask;
    /// Whether it is less or equal.
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` in the lanes of the mask, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Runs code under this type's instruction set.
    fn call<K: Kernel<Self>>(kernel: K) -> K::Out;

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.max(-self)
    }
    /// The number in the lanes of the mask, zero elsewhere.
    #[inline(always)]
    fn keep(mask: Self::Mask, value: Self) -> Self {
        Self::select(mask, value, Self::zero())
    }
    /// The numbers of a slice of values: `LANES` of each value, one after the other.
    #[inline(always)]
    fn numbers(values: &[Self]) -> &[f64] {
        // SAFETY: every lane type has the layout of `[f64; LANES]` and at least its alignment.
        unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), values.len() * Self::LANES) }
    }
    /// As [`Lane::numbers`], mutable.
    #[inline(always)]
    fn numbers_mut(values: &mut [Self]) -> &mut [f64] {
        // SAFETY: as above, and every bit pattern is a value.
        unsafe { std::slice::from_raw_parts_mut(values.as_mut_ptr().cast(), values.len() * Self::LANES) }
    }
}

/// Constant of the bit trick for the inverse square root (Blinn; Lomont's value for `f64`): half the bits are
/// subtracted from it.
const INVERSE_ROOT: u64 = 0x5fe6_eb50_c7b5_37a9;

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn not(self) -> Self {
        !self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

impl Lane for f64 {
    const LANES: usize = 1;
    type Mask = bool;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        self.mul_add(b, c)
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        (-self).mul_add(b, c)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn rough_inverse_root(self) -> Self {
        f64::from_bits(INVERSE_ROOT.wrapping_sub(self.to_bits() >> 1))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    /// With AVX2 and FMA if the processor has them. Otherwise every fused multiply-add is a call of the
    /// standard library, with the same bits.
    #[inline(always)]
    fn call<K: Kernel<Self>>(kernel: K) -> K::Out {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(x86::Run(kernel, std::marker::PhantomData::<Self>));
        }
        kernel.run()
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::{F64x4, F64x8};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m256d, __m512d, _CMP_LE_OQ, _CMP_LT_OQ};
    use std::marker::PhantomData;

    use pulp::x86::{V3, V4};

    use super::{Add, Div, INVERSE_ROOT, Kernel, Lane, Mask, Mul, Neg, Sub};

    pub(super) struct Run<K, L>(pub K, pub PhantomData<L>);

    impl<L, K: Kernel<L>> pulp::NullaryFnOnce for Run<K, L> {
        type Output = K::Out;
        #[inline(always)]
        fn call(self) -> K::Out {
            self.0.run()
        }
    }

    // SAFETY of both: values of a lane type are only made by `super::group::new`, which checks the processor
    // first.
    #[inline(always)]
    fn v3() -> V3 {
        unsafe { V3::new_unchecked() }
    }
    #[inline(always)]
    fn v4() -> V4 {
        unsafe { V4::new_unchecked() }
    }

    /// Four environments in 256 bits (AVX2 and FMA).
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct F64x4(__m256d);

    /// Eight environments in 512 bits (AVX-512).
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct F64x8(__m512d);

    /// Truth values in the bits of four lanes.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct Mask4(__m256d);

    /// Truth values in the bits of a mask register.
    #[derive(Clone, Copy)]
    #[repr(transparent)]
    pub struct Mask8(u8);

    impl Mask for Mask8 {
        #[inline(always)]
        fn splat(value: bool) -> Self {
            Self(if value { 0xff } else { 0 })
        }
        #[inline(always)]
        fn and(self, other: Self) -> Self {
            Self(self.0 & other.0)
        }
        #[inline(always)]
        fn or(self, other: Self) -> Self {
            Self(self.0 | other.0)
        }
        #[inline(always)]
        fn not(self) -> Self {
            Self(!self.0)
        }
        #[inline(always)]
        fn any(self) -> bool {
            self.0 != 0
        }
    }

    impl Mask4 {
        #[inline(always)]
        fn bits(self) -> i32 {
            v3().avx._mm256_movemask_pd(self.0)
        }
    }

    impl Mask for Mask4 {
        #[inline(always)]
        fn splat(value: bool) -> Self {
            let bits = if value { -1 } else { 0 };
            Self(v3().avx._mm256_castsi256_pd(v3().avx._mm256_set1_epi64x(bits)))
        }
        #[inline(always)]
        fn and(self, other: Self) -> Self {
            Self(v3().avx._mm256_and_pd(self.0, other.0))
        }
        #[inline(always)]
        fn or(self, other: Self) -> Self {
            Self(v3().avx._mm256_or_pd(self.0, other.0))
        }
        #[inline(always)]
        fn not(self) -> Self {
            Self(v3().avx._mm256_xor_pd(self.0, Self::splat(true).0))
        }
        #[inline(always)]
        fn any(self) -> bool {
            self.bits() != 0
        }
    }

    macro_rules! operators {
        ($type:ident, $token:ident . $set:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident,
            $div:ident) => {
            impl Add for $type {
                type Output = Self;
                #[inline(always)]
                fn add(self, other: Self) -> Self {
                    Self($token().$set.$add(self.0, other.0))
                }
            }
            impl Sub for $type {
                type Output = Self;
                #[inline(always)]
                fn sub(self, other: Self) -> Self {
                    Self($token().$set.$sub(self.0, other.0))
                }
            }
            impl Mul for $type {
                type Output = Self;
                #[inline(always)]
                fn mul(self, other: Self) -> Self {
                    Self($token().$set.$mul(self.0, other.0))
                }
            }
            impl Div for $type {
                type Output = Self;
                #[inline(always)]
                fn div(self, other: Self) -> Self {
                    Self($token().$set.$div(self.0, other.0))
                }
            }
            impl Neg for $type {
                type Output = Self;
                /// Exact for zeros too: -0 - x.
                #[inline(always)]
                fn neg(self) -> Self {
                    Self($token().$set.$sub($token().$set.$splat(-0.0), self.0))
                }
            }
        };
    }
    operators!(F64x4, v3.avx, _mm256_set1_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd);
    operators!(F64x8, v4.avx512f, _mm512_set1_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd);

    impl Lane for F64x4 {
        const LANES: usize = 4;
        type Mask = Mask4;
        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(v3().avx._mm256_set1_pd(value))
        }
        #[inline(always)]
        fn fma(self, b: Self, c: Self) -> Self {
            Self(v3().fma._mm256_fmadd_pd(self.0, b.0, c.0))
        }
        #[inline(always)]
        fn fnma(self, b: Self, c: Self) -> Self {
            Self(v3().fma._mm256_fnmadd_pd(self.0, b.0, c.0))
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(v3().avx._mm256_sqrt_pd(self.0))
        }
        #[inline(always)]
        fn rough_inverse_root(self) -> Self {
            let (avx, avx2) = (v3().avx, v3().avx2);
            let half = avx2._mm256_srli_epi64::<1>(avx._mm256_castpd_si256(self.0));
            let whole = avx._mm256_set1_epi64x(INVERSE_ROOT as i64);
            Self(avx._mm256_castsi256_pd(avx2._mm256_sub_epi64(whole, half)))
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(v3().avx._mm256_min_pd(self.0, other.0))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(v3().avx._mm256_max_pd(self.0, other.0))
        }
        #[inline(always)]
        fn lt(self, other: Self) -> Mask4 {
            Mask4(v3().avx._mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0))
        }
        #[inline(always)]
        fn le(self, other: Self) -> Mask4 {
            Mask4(v3().avx._mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0))
        }
        #[inline(always)]
        fn select(mask: Mask4, yes: Self, no: Self) -> Self {
            Self(v3().avx._mm256_blendv_pd(no.0, yes.0, mask.0))
        }
        #[inline(always)]
        fn call<K: Kernel<Self>>(kernel: K) -> K::Out {
            v3().vectorize(Run(kernel, PhantomData::<Self>))
        }
    }

    impl Lane for F64x8 {
        const LANES: usize = 8;
        type Mask = Mask8;
        #[inline(always)]
        fn splat(value: f64) -> Self {
            Self(v4().avx512f._mm512_set1_pd(value))
        }
        #[inline(always)]
        fn fma(self, b: Self, c: Self) -> Self {
            Self(v4().avx512f._mm512_fmadd_pd(self.0, b.0, c.0))
        }
        #[inline(always)]
        fn fnma(self, b: Self, c: Self) -> Self {
            Self(v4().avx512f._mm512_fnmadd_pd(self.0, b.0, c.0))
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(v4().avx512f._mm512_sqrt_pd(self.0))
        }
        #[inline(always)]
        fn rough_inverse_root(self) -> Self {
            let set = v4().avx512f;
            let half = set._mm512_srli_epi64::<1>(set._mm512_castpd_si512(self.0));
            let whole = set._mm512_set1_epi64(INVERSE_ROOT as i64);
            Self(set._mm512_castsi512_pd(set._mm512_sub_epi64(whole, half)))
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(v4().avx512f._mm512_min_pd(self.0, other.0))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(v4().avx512f._mm512_max_pd(self.0, other.0))
        }
        #[inline(always)]
        fn lt(self, other: Self) -> Mask8 {
            Mask8(v4().avx512f._mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0))
        }
        #[inline(always)]
        fn le(self, other: Self) -> Mask8 {
            Mask8(v4().avx512f._mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0))
        }
        #[inline(always)]
        fn select(mask: Mask8, yes: Self, no: Self) -> Self {
            Self(v4().avx512f._mm512_mask_blend_pd(mask.0, no.0, yes.0))
        }
        #[inline(always)]
        fn call<K: Kernel<Self>>(kernel: K) -> K::Out {
            v4().vectorize(Run(kernel, PhantomData::<Self>))
        }
    }
}
