//! Eight numbers in the vector registers of x86-64: one of 512 bits, or two of 256.
//!
//! The methods are inlined into functions that enable the instructions (`dem/contacts.rs`); nothing else makes one of
//! these types, so the processor has what they need.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{LANES, Pack, Real};

#[derive(Clone, Copy, Debug)]
pub struct Avx512(__m512d);

#[derive(Clone, Copy, Debug)]
pub struct Avx2(__m256d, __m256d);

macro_rules! operator {
    ($trait:ident, $method:ident, $wide:ident, $half:ident) => {
        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the enclosing kernel has AVX-512.
                Self(unsafe { $wide(self.0, other.0) })
            }
        }
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the enclosing kernel has AVX2.
                unsafe { Self($half(self.0, other.0), $half(self.1, other.1)) }
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd, _mm256_add_pd);
operator!(Sub, sub, _mm512_sub_pd, _mm256_sub_pd);
operator!(Mul, mul, _mm512_mul_pd, _mm256_mul_pd);
operator!(Div, div, _mm512_div_pd, _mm256_div_pd);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_xor_pd(self.0, sign), _mm256_xor_pd(self.1, sign))
        }
    }
}

// SAFETY of all that follows: the enclosing kernel has AVX-512 F and DQ. `min` and `max` of the processor return their
// second operand where the first is not less (more), as the scalar ones do.
impl Real for Avx512 {
    type Mask = __mmask8;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm512_min_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn above(self, other: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn both(a: __mmask8, b: __mmask8) -> __mmask8 {
        a & b
    }
    #[inline(always)]
    fn either(a: __mmask8, b: __mmask8) -> __mmask8 {
        a | b
    }
    #[inline(always)]
    fn choose(mask: __mmask8, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }
}

impl Pack for Avx512 {
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }
    /// An 8 by 8 transposition: neighbours within 128 bits, then within 256, then across.
    #[inline(always)]
    fn records(rows: &[&[f64]; LANES], first: usize) -> [Self; LANES] {
        unsafe {
            let r: [__m512d; LANES] = std::array::from_fn(|lane| _mm512_loadu_pd(rows[lane][first..first + LANES].as_ptr()));
            let low = |i: usize| _mm512_unpacklo_pd(r[i], r[i + 1]);
            let high = |i: usize| _mm512_unpackhi_pd(r[i], r[i + 1]);
            // Of rows i, i + 1: words 0, 2, 4, 6 (low) and 1, 3, 5, 7 (high), one pair per 128 bits.
            let (l01, l23, l45, l67) = (low(0), low(2), low(4), low(6));
            let (h01, h23, h45, h67) = (high(0), high(2), high(4), high(6));
            let quarter = |a: __m512d, b: __m512d, c: __m512d, d: __m512d| {
                let first = _mm512_shuffle_f64x2::<0b10_00_10_00>(a, b);
                let second = _mm512_shuffle_f64x2::<0b10_00_10_00>(c, d);
                let third = _mm512_shuffle_f64x2::<0b11_01_11_01>(a, b);
                let fourth = _mm512_shuffle_f64x2::<0b11_01_11_01>(c, d);
                [
                    Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(first, second)),
                    Self(_mm512_shuffle_f64x2::<0b10_00_10_00>(third, fourth)),
                    Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(first, second)),
                    Self(_mm512_shuffle_f64x2::<0b11_01_11_01>(third, fourth)),
                ]
            };
            let [w0, w2, w4, w6] = quarter(l01, l23, l45, l67);
            let [w1, w3, w5, w7] = quarter(h01, h23, h45, h67);
            [w0, w1, w2, w3, w4, w5, w6, w7]
        }
    }
}

// SAFETY of all that follows: the enclosing kernel has AVX2.
impl Real for Avx2 {
    type Mask = (__m256d, __m256d);

    #[inline(always)]
    fn splat(value: f64) -> Self {
        let half = unsafe { _mm256_set1_pd(value) };
        Self(half, half)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        unsafe { Self(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
        }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        unsafe { Self(_mm256_min_pd(self.0, other.0), _mm256_min_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        unsafe { Self(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        unsafe {
            (_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0), _mm256_cmp_pd::<_CMP_GT_OQ>(self.1, other.1))
        }
    }
    #[inline(always)]
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        unsafe { (_mm256_and_pd(a.0, b.0), _mm256_and_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        unsafe { (_mm256_or_pd(a.0, b.0), _mm256_or_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        unsafe { Self(_mm256_blendv_pd(no.0, yes.0, mask.0), _mm256_blendv_pd(no.1, yes.1, mask.1)) }
    }
}

impl Pack for Avx2 {
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        unsafe { Self(_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
        }
    }
    /// Four transpositions of 4 by 4.
    #[inline(always)]
    fn records(rows: &[&[f64]; LANES], first: usize) -> [Self; LANES] {
        unsafe {
            let square = |row: usize, word: usize| -> [__m256d; 4] {
                let r: [__m256d; 4] = std::array::from_fn(|i| _mm256_loadu_pd(rows[row + i][first + word..first + word + 4].as_ptr()));
                let (l01, h01) = (_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpackhi_pd(r[0], r[1]));
                let (l23, h23) = (_mm256_unpacklo_pd(r[2], r[3]), _mm256_unpackhi_pd(r[2], r[3]));
                [
                    _mm256_permute2f128_pd::<0x20>(l01, l23),
                    _mm256_permute2f128_pd::<0x20>(h01, h23),
                    _mm256_permute2f128_pd::<0x31>(l01, l23),
                    _mm256_permute2f128_pd::<0x31>(h01, h23),
                ]
            };
            let (a, b) = (square(0, 0), square(4, 0));
            let (c, d) = (square(0, 4), square(4, 4));
            std::array::from_fn(|word| {
                if word < 4 { Self(a[word], b[word]) } else { Self(c[word - 4], d[word - 4]) }
            })
        }
    }
}
