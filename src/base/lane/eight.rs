//! Eight numbers in an array: the path for any processor.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Kernel, LANES, Pack, Real};

#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Eight(pub [f64; LANES]);

impl Eight {
    #[inline(always)]
    fn zip<T>(self, other: Self, f: impl Fn(f64, f64) -> T) -> [T; LANES] {
        std::array::from_fn(|lane| f(self.0[lane], other.0[lane]))
    }
}

impl Add for Eight {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| a + b))
    }
}
impl Sub for Eight {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| a - b))
    }
}
impl Mul for Eight {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| a * b))
    }
}
impl Div for Eight {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.zip(other, |a, b| a / b))
    }
}
impl Neg for Eight {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl Real for Eight {
    type Mask = [bool; LANES];
    const COUNT: usize = LANES;
    type Numbers = [f64; LANES];

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.map(f64::floor))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.zip(other, Real::min))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.zip(other, Real::max))
    }
    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        self.zip(other, |a, b| a > b)
    }
    #[inline(always)]
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|lane| a[lane] & b[lane])
    }
    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|lane| a[lane] | b[lane])
    }
    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|lane| if mask[lane] { yes.0[lane] } else { no.0[lane] }))
    }
    #[inline(always)]
    fn holds(mask: Self::Mask, lane: usize) -> bool {
        mask[lane]
    }
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.contains(&true)
    }
    #[inline(always)]
    fn numbers(self) -> [f64; LANES] {
        self.0
    }
    #[inline(always)]
    fn of_numbers(numbers: &[f64; LANES]) -> Self {
        Self::load(numbers)
    }
}

impl Pack for Eight {
    #[inline(never)]
    fn enter<K: Kernel<Self>>(kernel: K) -> K::Outcome {
        kernel.run()
    }
    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        *to = self.0;
    }
    #[inline(always)]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES] {
        std::array::from_fn(|word| Self(std::array::from_fn(|lane| rows[lane].0[word])))
    }
}
