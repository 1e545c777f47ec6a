//! Eight numbers in pairs, in the registers of 128 bits that every x86-64 and every 64-bit ARM processor has, and in arrays elsewhere.

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::f64x2;

use super::{Kernel, LANES, Pack, Part, Quad, Real, eight_mut, whole_part};

/// Four pairs by name: as an array they would be held in memory.
#[derive(Clone, Copy, Debug)]
pub struct Eight(f64x2, f64x2, f64x2, f64x2);

/// Four words of a record.
#[derive(Clone, Copy, Debug)]
pub struct Pairs(f64x2, f64x2);

impl Eight {
    #[inline(always)]
    fn map(self, f: impl Fn(f64x2) -> f64x2) -> Self {
        Self(f(self.0), f(self.1), f(self.2), f(self.3))
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64x2, f64x2) -> f64x2) -> Self {
        Self(f(self.0, other.0), f(self.1, other.1), f(self.2, other.2), f(self.3, other.3))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Eight {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| $trait::$method(a, b))
            }
        }
        impl $trait for Pairs {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0), $trait::$method(self.1, other.1))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Eight {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| a ^ f64x2::splat(-0.0))
    }
}

impl Quad for Pairs {
    #[inline(always)]
    fn zero() -> Self {
        Self(f64x2::splat(0.0), f64x2::splat(0.0))
    }
    #[inline(always)]
    fn load(&[a, b, c, d]: &[f64; 4]) -> Self {
        Self(f64x2::new([a, b]), f64x2::new([c, d]))
    }
    #[inline(always)]
    fn words(self) -> [f64; 4] {
        let ([a, b], [c, d]) = (self.0.to_array(), self.1.to_array());
        [a, b, c, d]
    }
}

/// The whole number below. SSE2 cannot round: a size below 2^52 has no bits for anything but whole numbers beside 2^52, and above has none anyway.
#[inline(always)]
fn floor(a: f64x2) -> f64x2 {
    if !cfg!(all(target_feature = "sse2", not(target_feature = "sse4.1"))) {
        return a.floor();
    }
    let [whole, one, minus] = [4_503_599_627_370_496.0, 1.0, -0.0].map(f64x2::splat);
    let size = a.abs();
    let nearest = ((size + whole) - whole) | (a & minus);
    let below = nearest - (nearest.simd_gt(a) & one);
    whole.simd_gt(size).bitselect(below, a)
}

impl Real for Eight {
    /// All bits of a lane, or none.
    type Mask = Self;
    const COUNT: usize = LANES;
    type Numbers = [f64; LANES];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        let pair = f64x2::splat(value);
        Self(pair, pair, pair, pair)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64x2::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64x2::abs)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        self.map(floor)
    }
    // Each processor has a smaller one of its own of zeros and of what is no number.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| b.simd_gt(a).bitselect(a, b))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| a.simd_gt(b).bitselect(a, b))
    }
    #[inline(always)]
    fn above(self, other: Self) -> Self {
        self.zip(other, |a, b| a.simd_gt(b))
    }
    #[inline(always)]
    fn both(a: Self, b: Self) -> Self {
        a.zip(b, |a, b| a & b)
    }
    #[inline(always)]
    fn either(a: Self, b: Self) -> Self {
        a.zip(b, |a, b| a | b)
    }
    #[inline(always)]
    fn choose(mask: Self, yes: Self, no: Self) -> Self {
        Self(
            mask.0.bitselect(yes.0, no.0),
            mask.1.bitselect(yes.1, no.1),
            mask.2.bitselect(yes.2, no.2),
            mask.3.bitselect(yes.3, no.3),
        )
    }
    #[inline(always)]
    fn holds(mask: Self, lane: usize) -> bool {
        [mask.0, mask.1, mask.2, mask.3][lane / 2].to_bitmask() >> (lane % 2) & 1 == 1
    }
    #[inline(always)]
    fn any(mask: Self) -> bool {
        ((mask.0 | mask.1) | (mask.2 | mask.3)).any()
    }
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
}

whole_part!(
    Eight,
    Pairs,
    /// Eight transpositions of 2 by 2.
    #[inline(always)]
    fn of_quads([r0, r1, r2, r3, r4, r5, r6, r7]: [Pairs; LANES]) -> [Self; 4] {
        macro_rules! words {
            ($pair:tt) => {{
                let ([a, b], [c, d]) = (f64x2::transpose([r0.$pair, r1.$pair]), f64x2::transpose([r2.$pair, r3.$pair]));
                let ([e, f], [g, h]) = (f64x2::transpose([r4.$pair, r5.$pair]), f64x2::transpose([r6.$pair, r7.$pair]));
                [Self(a, c, e, g), Self(b, d, f, h)]
            }};
        }
        let ([w0, w1], [w2, w3]) = (words!(0), words!(1));
        [w0, w1, w2, w3]
    }
);

impl Pack for Eight {
    type Part = Self;

    #[inline(never)]
    fn enter<K: Kernel<Self>>(kernel: K) -> K::Outcome {
        kernel.run()
    }
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        let [a, b, c, d, e, f, g, h] = *from;
        Self(f64x2::new([a, b]), f64x2::new([c, d]), f64x2::new([e, f]), f64x2::new([g, h]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        let ([a, b], [c, d]) = (self.0.to_array(), self.1.to_array());
        let ([e, f], [g, h]) = (self.2.to_array(), self.3.to_array());
        *to = [a, b, c, d, e, f, g, h];
    }
    /// Sixteen transpositions of 2 by 2.
    #[inline(always)]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
        macro_rules! words {
            ($pair:tt) => {{
                let ([a, b], [c, d]) = (f64x2::transpose([r0.$pair, r1.$pair]), f64x2::transpose([r2.$pair, r3.$pair]));
                let ([e, f], [g, h]) = (f64x2::transpose([r4.$pair, r5.$pair]), f64x2::transpose([r6.$pair, r7.$pair]));
                [Self(a, c, e, g), Self(b, d, f, h)]
            }};
        }
        let ([w0, w1], [w2, w3], [w4, w5], [w6, w7]) = (words!(0), words!(1), words!(2), words!(3));
        [w0, w1, w2, w3, w4, w5, w6, w7]
    }
}
