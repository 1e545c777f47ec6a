//! Eight numbers in the vector registers of x86-64: one of 512 bits, or two of 256, each of which is also a part by itself. Four words of a record are one of 256
//! bits with either: who has AVX-512 has AVX2.
//!
//! The methods are inlined into functions that enable the instructions ([`Pack::enter`]), which are entered by
//! [`super::Instructions::run`] alone, so the processor has what they need.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Kernel, LANES, Pack, Part, Quad, Real, Table, eight_mut, whole_part};

#[derive(Clone, Copy, Debug)]
pub struct Avx512(__m512d);

#[derive(Clone, Copy, Debug)]
pub struct Four(__m256d);

#[derive(Clone, Copy, Debug)]
pub struct Avx2(Four, Four);

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
        impl $trait for Four {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the enclosing kernel has AVX2.
                Self(unsafe { $half(self.0, other.0) })
            }
        }
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0), $trait::$method(self.1, other.1))
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd, _mm256_add_pd);
operator!(Sub, sub, _mm512_sub_pd, _mm256_sub_pd);
operator!(Mul, mul, _mm512_mul_pd, _mm256_mul_pd);
operator!(Div, div, _mm512_div_pd, _mm256_div_pd);

/// Lanes one by one, which go through memory in any registers.
macro_rules! through_memory {
    () => {
        const COUNT: usize = LANES;
        type Numbers = [f64; LANES];

        #[inline(always)]
        fn numbers(self) -> [f64; LANES] {
            let mut numbers = [0.0; LANES];
            self.store(&mut numbers);
            numbers
        }
        #[inline(always)]
        fn of_numbers(numbers: &[f64; LANES]) -> Self {
            Self::load(numbers)
        }
    };
}

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Neg for Four {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

// `min` and `max` of the processor return their second operand where the first is not less (more), as the scalar ones do.
impl Real for Avx512 {
    type Mask = __mmask8;
    through_memory!();

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_min_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn above(self, other: Self) -> __mmask8 {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
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
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_mask_blend_pd(mask, no.0, yes.0) })
    }
    #[inline(always)]
    fn holds(mask: __mmask8, lane: usize) -> bool {
        mask >> lane & 1 == 1
    }
    #[inline(always)]
    fn any(mask: __mmask8) -> bool {
        mask != 0
    }
}

#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn in_avx512<K: Kernel<Avx512>>(kernel: K) -> K::Outcome {
    kernel.run()
}

whole_part!(
    Avx512,
    Four,
    #[inline(always)]
    fn of_quads([r0, r1, r2, r3, r4, r5, r6, r7]: [Four; LANES]) -> [Self; 4] {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        unsafe { squares([beside(r0, r4), beside(r1, r5), beside(r2, r6), beside(r3, r7)]) }
    },
    #[inline(always)]
    fn picked(table: &Table, places: &[u64; LANES], _: usize) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { picked(table, places) })
    }
);

impl Pack for Avx512 {
    type Part = Self;

    #[inline]
    fn enter<K: Kernel<Self>>(kernel: K) -> K::Outcome {
        // SAFETY: nobody outside of `lane` can name these registers, and `Instructions` is entered here with those alone
        // that the processor was found to have.
        unsafe { in_avx512(kernel) }
    }
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }
    /// Neighbours within 128 bits, then across.
    #[inline(always)]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
        let (r0, r1, r2, r3, r4, r5, r6, r7) = (r0.0, r1.0, r2.0, r3.0, r4.0, r5.0, r6.0, r7.0);
        // SAFETY: the enclosing kernel has AVX-512 F and DQ.
        unsafe {
            // Words 0, 2, 4, 6 of two rows, one pair per 128 bits; below words 1, 3, 5, 7.
            let low = [
                _mm512_unpacklo_pd(r0, r1),
                _mm512_unpacklo_pd(r2, r3),
                _mm512_unpacklo_pd(r4, r5),
                _mm512_unpacklo_pd(r6, r7),
            ];
            let high = [
                _mm512_unpackhi_pd(r0, r1),
                _mm512_unpackhi_pd(r2, r3),
                _mm512_unpackhi_pd(r4, r5),
                _mm512_unpackhi_pd(r6, r7),
            ];
            let [w0, w2, w4, w6] = quarters(low);
            let [w1, w3, w5, w7] = quarters(high);
            [w0, w1, w2, w3, w4, w5, w6, w7]
        }
    }
}

/// Two registers as one.
#[inline(always)]
unsafe fn beside(low: Four, high: Four) -> __m512d {
    // SAFETY: the caller has AVX-512 F and DQ.
    unsafe { _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low.0), high.0) }
}

/// Four rows and the four after them side by side, each four by itself rows for columns.
#[inline(always)]
unsafe fn squares([r0, r1, r2, r3]: [__m512d; 4]) -> [Avx512; 4] {
    // SAFETY: the caller has AVX-512 F and DQ.
    unsafe {
        let (low, high) = (_mm512_unpacklo_pd(r0, r1), _mm512_unpackhi_pd(r0, r1));
        let (low_behind, high_behind) = (_mm512_unpacklo_pd(r2, r3), _mm512_unpackhi_pd(r2, r3));
        let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            Avx512(_mm512_permutex2var_pd(low, first, low_behind)),
            Avx512(_mm512_permutex2var_pd(high, first, high_behind)),
            Avx512(_mm512_permutex2var_pd(low, second, low_behind)),
            Avx512(_mm512_permutex2var_pd(high, second, high_behind)),
        ]
    }
}

/// The quarters of a table in registers, two and two of which a place is looked up in at once.
#[inline(always)]
unsafe fn picked(table: &Table, places: &[u64; LANES]) -> __m512d {
    // SAFETY: the caller has AVX-512 F and DQ, and the table four times eight numbers.
    unsafe {
        let places = _mm512_loadu_si512(places.as_ptr().cast());
        let quarter = |number: usize| _mm512_loadu_pd(table.as_ptr().add(number * LANES));
        let low = _mm512_permutex2var_pd(quarter(0), places, quarter(1));
        let high = _mm512_permutex2var_pd(quarter(2), places, quarter(3));
        _mm512_mask_blend_pd(_mm512_test_epi64_mask(places, _mm512_set1_epi64(16)), low, high)
    }
}

/// From four registers of four quarters each (128 bits), those that hold all first, all second, ... quarters.
#[inline(always)]
unsafe fn quarters([a, b, c, d]: [__m512d; 4]) -> [Avx512; 4] {
    // SAFETY: the caller has AVX-512 F and DQ.
    unsafe {
        let (even_ab, even_cd) =
            (_mm512_shuffle_f64x2::<0b10_00_10_00>(a, b), _mm512_shuffle_f64x2::<0b10_00_10_00>(c, d));
        let (odd_ab, odd_cd) =
            (_mm512_shuffle_f64x2::<0b11_01_11_01>(a, b), _mm512_shuffle_f64x2::<0b11_01_11_01>(c, d));
        [
            Avx512(_mm512_shuffle_f64x2::<0b10_00_10_00>(even_ab, even_cd)),
            Avx512(_mm512_shuffle_f64x2::<0b10_00_10_00>(odd_ab, odd_cd)),
            Avx512(_mm512_shuffle_f64x2::<0b11_01_11_01>(even_ab, even_cd)),
            Avx512(_mm512_shuffle_f64x2::<0b11_01_11_01>(odd_ab, odd_cd)),
        ]
    }
}

impl Real for Four {
    type Mask = __m256d;
    const COUNT: usize = 4;
    type Numbers = [f64; 4];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_set1_pd(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_floor_pd(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn above(self, other: Self) -> __m256d {
        // SAFETY: the enclosing kernel has AVX2.
        unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn both(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: the enclosing kernel has AVX2.
        unsafe { _mm256_and_pd(a, b) }
    }
    #[inline(always)]
    fn either(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: the enclosing kernel has AVX2.
        unsafe { _mm256_or_pd(a, b) }
    }
    #[inline(always)]
    fn choose(mask: __m256d, yes: Self, no: Self) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask) })
    }
    #[inline(always)]
    fn holds(mask: __m256d, lane: usize) -> bool {
        // SAFETY: the enclosing kernel has AVX2.
        let lanes = unsafe { _mm256_movemask_pd(mask) };
        lanes >> lane & 1 == 1
    }
    #[inline(always)]
    fn any(mask: __m256d) -> bool {
        // SAFETY: the enclosing kernel has AVX2.
        unsafe { _mm256_movemask_pd(mask) != 0 }
    }
    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        let mut numbers = [0.0; 4];
        // SAFETY: the enclosing kernel has AVX2.
        unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) }
        numbers
    }
    #[inline(always)]
    fn of_numbers(numbers: &[f64; 4]) -> Self {
        // SAFETY: the enclosing kernel has AVX2.
        Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
    }
}

impl Part for Four {
    type Quad = Self;

    #[inline(always)]
    fn of_quads([r0, r1, r2, r3, ..]: [Self; LANES]) -> [Self; 4] {
        square([r0, r1, r2, r3])
    }
    #[inline(always)]
    fn load_part(from: &[f64; LANES], part: usize) -> Self {
        let (halves, _) = from.as_chunks();
        Self::of_numbers(&halves[part])
    }
    #[inline(always)]
    fn store_part(self, to: &mut [f64; LANES], part: usize) {
        let (halves, _) = to.as_chunks_mut();
        halves[part] = self.numbers();
    }
    #[inline(always)]
    fn to_records(words: [Self; LANES], records: &mut [f64], width: usize) {
        let [w0, w1, w2, w3, w4, w5, w6, w7] = words;
        for (part, words) in [[w0, w1, w2, w3], [w4, w5, w6, w7]].into_iter().enumerate() {
            for (record, numbers) in square(words).into_iter().enumerate() {
                numbers.store_part(eight_mut(records, record * width), part);
            }
        }
    }
}

impl Quad for Four {
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    #[inline(always)]
    fn load(from: &[f64; 4]) -> Self {
        Self::of_numbers(from)
    }
    #[inline(always)]
    fn words(self) -> [f64; 4] {
        self.numbers()
    }
}

/// From the halves of four rows of eight numbers, the columns.
#[inline(always)]
fn columns([a, b, c, d]: [[Four; 2]; 4]) -> [Four; LANES] {
    let ([w0, w1, w2, w3], [w4, w5, w6, w7]) = (square([a[0], b[0], c[0], d[0]]), square([a[1], b[1], c[1], d[1]]));
    [w0, w1, w2, w3, w4, w5, w6, w7]
}

impl Real for Avx2 {
    type Mask = (__m256d, __m256d);
    through_memory!();

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(Four::splat(value), Four::splat(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.floor(), self.1.floor())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        (self.0.above(other.0), self.1.above(other.1))
    }
    #[inline(always)]
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        (Four::both(a.0, b.0), Four::both(a.1, b.1))
    }
    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        (Four::either(a.0, b.0), Four::either(a.1, b.1))
    }
    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(Four::choose(mask.0, yes.0, no.0), Four::choose(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn holds(mask: Self::Mask, lane: usize) -> bool {
        Four::holds([mask.0, mask.1][lane / 4], lane % 4)
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        Four::any(Four::either(mask.0, mask.1))
    }
}

#[target_feature(enable = "avx2")]
fn in_avx2<K: Kernel<Avx2>>(kernel: K) -> K::Outcome {
    kernel.run()
}

whole_part!(
    Avx2,
    Four,
    #[inline(always)]
    fn of_quads([r0, r1, r2, r3, r4, r5, r6, r7]: [Four; LANES]) -> [Self; 4] {
        let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (square([r0, r1, r2, r3]), square([r4, r5, r6, r7]));
        [Self(a0, b0), Self(a1, b1), Self(a2, b2), Self(a3, b3)]
    }
);

impl Pack for Avx2 {
    type Part = Four;

    #[inline]
    fn enter<K: Kernel<Self>>(kernel: K) -> K::Outcome {
        // SAFETY: nobody outside of `lane` can name these registers, and `Instructions` is entered here with those alone
        // that the processor was found to have.
        unsafe { in_avx2(kernel) }
    }
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        Self(Four::load_part(from, 0), Four::load_part(from, 1))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        self.0.store_part(to, 0);
        self.1.store_part(to, 1);
    }
    /// Four transpositions of 4 by 4.
    #[inline(always)]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
        let [a0, a1, a2, a3, a4, a5, a6, a7] = columns([[r0.0, r0.1], [r1.0, r1.1], [r2.0, r2.1], [r3.0, r3.1]]);
        let [b0, b1, b2, b3, b4, b5, b6, b7] = columns([[r4.0, r4.1], [r5.0, r5.1], [r6.0, r6.1], [r7.0, r7.1]]);
        [Self(a0, b0), Self(a1, b1), Self(a2, b2), Self(a3, b3), Self(a4, b4), Self(a5, b5), Self(a6, b6), Self(a7, b7)]
    }
}

/// Rows for columns, four by four.
#[inline(always)]
fn square([Four(r0), Four(r1), Four(r2), Four(r3)]: [Four; 4]) -> [Four; 4] {
    // SAFETY: nobody has a `Four` but in a kernel that has AVX2.
    unsafe {
        let (low, high) = (_mm256_unpacklo_pd(r0, r1), _mm256_unpackhi_pd(r0, r1));
        let (low_behind, high_behind) = (_mm256_unpacklo_pd(r2, r3), _mm256_unpackhi_pd(r2, r3));
        [
            Four(_mm256_permute2f128_pd::<0x20>(low, low_behind)),
            Four(_mm256_permute2f128_pd::<0x20>(high, high_behind)),
            Four(_mm256_permute2f128_pd::<0x31>(low, low_behind)),
            Four(_mm256_permute2f128_pd::<0x31>(high, high_behind)),
        ]
    }
}
