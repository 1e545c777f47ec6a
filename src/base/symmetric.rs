//! Symmetric tensors by their components, and their logarithms and exponentials without eigenvectors.
//!
//! A strain is held as `c = b - I`, not as b, so that a strain of 1e-6 keeps sixteen digits and not ten.
//!
//! ```text
//! ln(I + c)/2 = atanh(z) = z (1 + y/3 + y^2/5 + ...),   z = c (2 I + c)^-1,  y = z^2
//! exp(x) - I  = x (1 + x/2 + x^2/6 + ...)
//! ```
//!
//! Each series is cut where what is left is below half a unit in the last place: of the first, past the term of y^m, at
//! most `|y|^(m+1)/((2 m + 3)(1 - |y|))` of the sum. Powers above the second follow from the characteristic polynomial,
//! `y^3 = I1 y^2 - I2 y + I3 I`, so that a term costs three multiplications. Farther out the mean stretch is taken off by
//! its own logarithm, then `ln(b) = 2 ln(sqrt(b))` with the root of Denman and Beavers (1976), and
//! `exp(2 x) - I = (exp(x) - I)(exp(x) + I)`.
//!
//! Products are of tensors that commute, as functions of one tensor do; theirs are symmetric again.
//!
//! In lanes each takes as many terms as it would alone: a coefficient beyond its own last is zero, so that no lane knows
//! its neighbours. Lanes that are far out are done one by one.

use std::fmt::Debug;
use std::ops::{Add, Mul, Sub};

use nalgebra::{ArrayStorage, SMatrix};

use crate::base::lane::Real;
use crate::base::math;
use crate::base::space::Words;

/// |z|^2 beyond which the logarithm takes a root first.
const NEAR: f64 = 1.0 / 16.0;
/// Past this many terms the series of the logarithm is never needed: `NEAR^13/27` is below 2^-53.
const TERMS: usize = 13;
/// |x|^2 beyond which the exponential is halved.
const SMALL: f64 = 0.25;
/// Relative size of a term that no longer counts, with room for its divisor.
const NEGLIGIBLE: f64 = 2e-16;

/// Coefficients of 1, x and x^2: any polynomial of x, reduced.
#[derive(Clone, Copy)]
struct Reduced<R>([R; 3]);

impl<R: Real> Reduced<R> {
    /// Times x, plus a constant.
    #[inline(always)]
    fn next(self, invariants: &[R; 3], constant: R) -> Self {
        let [a, b, c] = self.0;
        Self([invariants[2] * c + constant, a - invariants[1] * c, b + invariants[0] * c])
    }
}

/// A symmetric tensor, or several in step.
pub trait Symmetric<R: Real = f64>: Words<R> + Add<Output = Self> + Sub<Output = Self> + Mul<R, Output = Self> {
    /// The same with both halves, column by column.
    type Tensor;
    /// One of the tensors in step.
    type Single: Symmetric<f64>;
    /// Columns.
    const DIMENSION: usize;

    /// `value I`.
    fn isotropic(value: R) -> Self;
    /// The symmetric part.
    fn of(tensor: &Self::Tensor) -> Self;
    /// With both halves.
    fn tensor(&self) -> Self::Tensor;
    /// The components as numbers, to be stored and sent: the diagonal, then xy, xz, yz.
    fn as_mut_slice(&mut self) -> &mut [R];
    /// Sum of the diagonal; in the plane without what is out of it.
    fn trace(&self) -> R;
    /// `a:b`.
    fn contract(&self, other: &Self) -> R;
    /// Product of two that commute.
    fn times(&self, other: &Self) -> Self;
    /// Of a tensor with a determinant, by cofactors: quick, right to the last places near a multiple of I.
    fn inverse(&self) -> Self;
    /// Of a positive tensor, its error no larger than the last place of its largest over its smallest stretch.
    fn inverse_positive(&self) -> Self;
    /// I1, I2 and I3 of the characteristic polynomial; I3 is 0 in the plane, where `x^3 = I1 x^2 - I2 x`.
    fn characteristic(&self) -> [R; 3];
    /// `(I + h)(I + c)(I + h)^T - I` of a strain c: what an increment of deformation h makes of it.
    fn pushed(&self, increment: &Self::Tensor) -> Self;
    /// det(I + c) of a strain c.
    fn volume_squared(&self) -> R;

    /// Squared Frobenius norm.
    #[inline(always)]
    fn square(&self) -> R {
        self.contract(self)
    }

    /// `x - tr(x)/d I`.
    #[inline(always)]
    fn deviator(&self) -> Self {
        *self - Self::isotropic(self.trace() / R::splat(Self::DIMENSION as f64))
    }

    /// `ln(I + c)/2`: logarithmic strain of c.
    #[inline(always)]
    fn half_logarithm(&self) -> Self {
        let z = self.times(&(*self + Self::isotropic(R::splat(2.0))).inverse());
        let y = z.times(&z);
        let size = y.trace();
        let far = size.above(R::splat(NEAR));
        let [a, b, c] = atanh_ratio(size, &y);
        let cubed = z.times(&y);
        let mut logarithm = z * a + cubed * b + cubed.times(&y) * c;
        if R::any(far) {
            each(&mut logarithm, far, self, half_logarithm_far);
        }
        logarithm
    }

    /// `exp(x) - I`.
    #[inline(always)]
    fn exponential(&self) -> Self {
        let size = self.square();
        let far = size.above(R::splat(SMALL));
        let mut grown = exponential_ratio(self, size);
        if R::any(far) {
            each(&mut grown, far, self, exponential_far);
        }
        grown
    }
}

/// Sets those of `values` where the mask holds to `function` of `arguments`, one by one.
#[inline(always)]
fn each<R: Real, T: Symmetric<R>>(
    values: &mut T,
    mask: R::Mask,
    arguments: &T,
    function: impl Fn(&T::Single) -> T::Single,
) {
    for lane in 0..R::COUNT {
        if R::holds(mask, lane) {
            let mut argument = T::Single::zero();
            for word in 0..T::COUNT {
                argument.set_word(word, arguments.word(word).numbers().as_ref()[lane]);
            }
            let value = function(&argument);
            for word in 0..T::COUNT {
                let mut numbers = values.word(word).numbers();
                numbers.as_mut()[lane] = value.word(word);
                values.set_word(word, R::of_numbers(&numbers));
            }
        }
    }
}

/// `1/(k + 1)!` for k = 0, 1, ...
const FACTORIALS: [f64; 17] = {
    let mut inverse = [1.0; 17];
    let mut k = 1;
    while k < inverse.len() {
        inverse[k] = inverse[k - 1] / (k as f64 + 1.0);
        k += 1;
    }
    inverse
};

/// `1/(2 k + 1)` for k = 0, 1, ...
const ODD: [f64; TERMS] = {
    let mut inverse = [1.0; TERMS];
    let mut k = 1;
    while k < inverse.len() {
        inverse[k] = 1.0 / (2.0 * k as f64 + 1.0);
        k += 1;
    }
    inverse
};

/// `atanh(z)/z` as a polynomial in `y = z^2` of trace `size`, of at most NEAR.
#[inline(always)]
fn atanh_ratio<R: Real, T: Symmetric<R>>(size: R, y: &T) -> [R; 3] {
    let negligible = R::splat(NEGLIGIBLE);
    // Term k counts where size^k does; the first three always do.
    let mut coefficients = [R::splat(0.0); TERMS];
    let (mut last, mut power) = (3, size * size * size);
    while last < TERMS {
        let counts = power.above(negligible);
        if !R::any(counts) {
            break;
        }
        coefficients[last] = R::choose(counts, R::splat(ODD[last]), R::splat(0.0));
        (last, power) = (last + 1, power * size);
    }
    let mut sum = Reduced([R::splat(ODD[0]), R::splat(ODD[1]), R::splat(ODD[2])]);
    if last > 3 {
        let invariants = y.characteristic();
        sum = Reduced([R::splat(0.0); 3]);
        for coefficient in coefficients[3..last].iter().rev() {
            sum = sum.next(&invariants, *coefficient);
        }
        for odd in ODD[..3].iter().rev() {
            sum = sum.next(&invariants, R::splat(*odd));
        }
    }
    sum.0
}

/// `exp(x) - I` by its series, |x|^2 of at most SMALL.
#[inline(always)]
fn exponential_ratio<R: Real, T: Symmetric<R>>(x: &T, size: R) -> T {
    let negligible = R::splat(NEGLIGIBLE * NEGLIGIBLE);
    let invariants = x.characteristic();
    // The size is squared: |x|^n/(n + 1)! against the first term.
    let mut coefficients = [R::splat(0.0); FACTORIALS.len()];
    let (mut last, mut term) = (3, size * size * size * R::splat(1.0 / 576.0));
    while last + 1 < FACTORIALS.len() {
        let counts = term.above(negligible);
        if !R::any(counts) {
            break;
        }
        coefficients[last] = R::choose(counts, R::splat(FACTORIALS[last]), R::splat(0.0));
        let ratio = FACTORIALS[last + 1] / FACTORIALS[last];
        (last, term) = (last + 1, term * size * R::splat(ratio * ratio));
    }
    let mut sum = Reduced([R::splat(0.0); 3]);
    for coefficient in coefficients[3..last].iter().rev() {
        sum = sum.next(&invariants, *coefficient);
    }
    for factorial in FACTORIALS[..3].iter().rev() {
        sum = sum.next(&invariants, R::splat(*factorial));
    }
    let [a, b, c] = sum.next(&invariants, R::splat(0.0)).0;
    T::isotropic(a) + *x * b + x.times(x) * c
}

/// Where the series of the exponential converges slowly: of halves, squared.
#[cold]
fn exponential_far<T: Symmetric>(x: &T) -> T {
    let mut size = x.square();
    let mut halvings = 0;
    while size > SMALL && halvings < 63 {
        (size, halvings) = (0.25 * size, halvings + 1);
    }
    let mut grown = exponential_ratio(&(*x * (1.0 / (1u64 << halvings) as f64)), size);
    for _ in 0..halvings {
        grown = grown.times(&grown) + grown * 2.0;
    }
    grown
}

/// Where the series converges slowly: without the mean stretch, then of the root.
#[cold]
fn half_logarithm_far<T: Symmetric>(strain: &T) -> T {
    let identity = T::isotropic(1.0);
    let mut stretch = *strain + identity;
    let (mut isotropic, mut factor) = (0.0, 1.0);
    // Each root halves the logarithm: of any finite positive tensor, ten leave less than NEAR.
    for _ in 0..12 {
        let mean = stretch.trace() / T::DIMENSION as f64;
        isotropic += factor * 0.5 * math::ln(mean);
        stretch = stretch * (1.0 / mean);
        let left = stretch - identity;
        let z = left.times(&(stretch + identity).inverse_positive());
        if z.square() <= NEAR {
            return left.half_logarithm() * factor + T::isotropic(isotropic);
        }
        stretch = root(&stretch);
        factor *= 2.0;
    }
    // Not positive: nothing that deforms gets here.
    T::isotropic(f64::NAN)
}

/// Square root of a positive tensor: `y <- (y + z^-1)/2, z <- (z + y^-1)/2` from `y = b, z = I`.
fn root<T: Symmetric>(b: &T) -> T {
    let (mut y, mut z) = (*b, T::isotropic(1.0));
    for _ in 0..64 {
        let next = (y + z.inverse_positive()) * 0.5;
        z = (z + y.inverse_positive()) * 0.5;
        let change = (next - y).square();
        y = next;
        // The error squares with each iteration.
        if change <= 1e-18 * y.square() {
            break;
        }
    }
    y
}

/// In the plane: xx, yy, xy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct PlaneSymmetric<R = f64>(pub [R; 3]);

/// In space: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct SolidSymmetric<R = f64>(pub [R; 6]);

macro_rules! linear {
    ($name:ident, $count:literal) => {
        impl<R: Real> Add for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
            }
        }
        impl<R: Real> Sub for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
            }
        }
        impl<R: Real> Mul<R> for $name<R> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, factor: R) -> Self {
                Self(std::array::from_fn(|i| self.0[i] * factor))
            }
        }
        impl<R: Real> Words<R> for $name<R> {
            const COUNT: usize = $count;
            #[inline(always)]
            fn zero() -> Self {
                Self([R::splat(0.0); $count])
            }
            #[inline(always)]
            fn word(&self, index: usize) -> R {
                self.0[index]
            }
            #[inline(always)]
            fn set_word(&mut self, index: usize, value: R) {
                self.0[index] = value;
            }
        }
    };
}
linear!(PlaneSymmetric, 3);
linear!(SolidSymmetric, 6);

/// A tensor from its columns.
#[inline(always)]
const fn columns<R, const N: usize>(columns: [[R; N]; N]) -> SMatrix<R, N, N> {
    SMatrix::from_array_storage(ArrayStorage(columns))
}

impl<R: Real> Symmetric<R> for PlaneSymmetric<R> {
    type Tensor = SMatrix<R, 2, 2>;
    type Single = PlaneSymmetric;
    const DIMENSION: usize = 2;

    #[inline(always)]
    fn isotropic(value: R) -> Self {
        Self([value, value, R::splat(0.0)])
    }
    #[inline(always)]
    fn of(tensor: &Self::Tensor) -> Self {
        Self([tensor[0], tensor[3], R::splat(0.5) * (tensor[1] + tensor[2])])
    }
    #[inline(always)]
    fn tensor(&self) -> Self::Tensor {
        let [xx, yy, xy] = self.0;
        columns([[xx, xy], [xy, yy]])
    }
    fn as_mut_slice(&mut self) -> &mut [R] {
        &mut self.0
    }
    #[inline(always)]
    fn trace(&self) -> R {
        self.0[0] + self.0[1]
    }
    #[inline(always)]
    fn contract(&self, other: &Self) -> R {
        let (a, b) = (&self.0, &other.0);
        a[0] * b[0] + a[1] * b[1] + R::splat(2.0) * (a[2] * b[2])
    }
    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let ([ax, ay, axy], [bx, by, bxy]) = (self.0, other.0);
        Self([ax * bx + axy * bxy, axy * bxy + ay * by, ax * bxy + axy * by])
    }
    #[inline(always)]
    fn inverse(&self) -> Self {
        let [xx, yy, xy] = self.0;
        Self([yy, xx, -xy]) * (R::splat(1.0) / (xx * yy - xy * xy))
    }
    fn inverse_positive(&self) -> Self {
        self.inverse()
    }
    #[inline(always)]
    fn characteristic(&self) -> [R; 3] {
        let [xx, yy, xy] = self.0;
        [xx + yy, xx * yy - xy * xy, R::splat(0.0)]
    }
    #[inline(always)]
    fn pushed(&self, increment: &Self::Tensor) -> Self {
        let ([xx, yy, xy], h) = (self.0, increment);
        // A = h (I + c); c + A + A^T + A h^T.
        let (a, b) = (deformed_in_plane(h, self, 0), deformed_in_plane(h, self, 1));
        Self([
            xx + (R::splat(2.0) * a[0] + (a[0] * h[0] + a[1] * h[2])),
            yy + (R::splat(2.0) * b[1] + (b[0] * h[1] + b[1] * h[3])),
            xy + (a[1] + b[0] + (a[0] * h[1] + a[1] * h[3])),
        ])
    }
    #[inline(always)]
    fn volume_squared(&self) -> R {
        let [xx, yy, xy] = self.0;
        (R::splat(1.0) + xx) * (R::splat(1.0) + yy) - xy * xy
    }
}

impl<R: Real> Symmetric<R> for SolidSymmetric<R> {
    type Tensor = SMatrix<R, 3, 3>;
    type Single = SolidSymmetric;
    const DIMENSION: usize = 3;

    #[inline(always)]
    fn isotropic(value: R) -> Self {
        Self([value, value, value, R::splat(0.0), R::splat(0.0), R::splat(0.0)])
    }
    #[inline(always)]
    fn of(tensor: &Self::Tensor) -> Self {
        let t = tensor;
        Self([
            t[0],
            t[4],
            t[8],
            R::splat(0.5) * (t[1] + t[3]),
            R::splat(0.5) * (t[2] + t[6]),
            R::splat(0.5) * (t[5] + t[7]),
        ])
    }
    #[inline(always)]
    fn tensor(&self) -> Self::Tensor {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        columns([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }
    fn as_mut_slice(&mut self) -> &mut [R] {
        &mut self.0
    }
    #[inline(always)]
    fn trace(&self) -> R {
        self.0[0] + self.0[1] + self.0[2]
    }
    #[inline(always)]
    fn contract(&self, other: &Self) -> R {
        let (a, b) = (&self.0, &other.0);
        (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + R::splat(2.0) * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
    }
    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let ([ax, ay, az, axy, axz, ayz], [bx, by, bz, bxy, bxz, byz]) = (self.0, other.0);
        let (xy, xz, yz) = (axy * bxy, axz * bxz, ayz * byz);
        Self([
            ax * bx + xy + xz,
            xy + ay * by + yz,
            xz + yz + az * bz,
            ax * bxy + axy * by + axz * byz,
            ax * bxz + axy * byz + axz * bz,
            axy * bxz + ay * byz + ayz * bz,
        ])
    }
    #[inline(always)]
    fn inverse(&self) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
        let scale = R::splat(1.0) / (xx * a + xy * b + xz * c);
        Self([a, xx * zz - xz * xz, xx * yy - xy * xy, b, c, xy * xz - xx * yz]) * scale
    }
    /// From `L D L^T`: cofactors would lose the square of the ratio of stretches.
    fn inverse_positive(&self) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let (l_yx, l_zx) = (xy / xx, xz / xx);
        let (d_y, left) = (yy - l_yx * xy, yz - l_yx * xz);
        let l_zy = left / d_y;
        let d_z = zz - l_zx * xz - l_zy * left;
        // L^-1 has -l_yx, -l_zy and this below its diagonal.
        let m = l_yx * l_zy - l_zx;
        let (by_x, by_y, by_z) = (R::splat(1.0) / xx, R::splat(1.0) / d_y, R::splat(1.0) / d_z);
        Self([
            by_x + l_yx * l_yx * by_y + m * m * by_z,
            by_y + l_zy * l_zy * by_z,
            by_z,
            -(l_yx * by_y + m * l_zy * by_z),
            m * by_z,
            -(l_zy * by_z),
        ])
    }
    #[inline(always)]
    fn characteristic(&self) -> [R; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let (a, b, c) = (yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy);
        [xx + yy + zz, a + b + c, xx * a + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy)]
    }
    #[inline(always)]
    fn pushed(&self, increment: &Self::Tensor) -> Self {
        let ([xx, yy, zz, xy, xz, yz], h) = (self.0, increment);
        // A = h (I + c); c + A + A^T + A h^T.
        let (a, b, c) = (deformed(h, self, 0), deformed(h, self, 1), deformed(h, self, 2));
        Self([
            xx + (R::splat(2.0) * a[0] + along(&a, h, 0)),
            yy + (R::splat(2.0) * b[1] + along(&b, h, 1)),
            zz + (R::splat(2.0) * c[2] + along(&c, h, 2)),
            xy + (a[1] + b[0] + along(&a, h, 1)),
            xz + (a[2] + c[0] + along(&a, h, 2)),
            yz + (b[2] + c[1] + along(&b, h, 2)),
        ])
    }
    #[inline(always)]
    fn volume_squared(&self) -> R {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let (a, b, c) = (R::splat(1.0) + xx, R::splat(1.0) + yy, R::splat(1.0) + zz);
        a * (b * c - yz * yz) + xy * (xz * yz - xy * c) + xz * (xy * yz - xz * b)
    }
}

// Functions, not closures: a closure may be compiled apart, for the plainest processor, and each operation on lanes in it becomes a call.

/// Row r of h (I + c), in the plane.
#[inline(always)]
fn deformed_in_plane<R: Real>(h: &SMatrix<R, 2, 2>, c: &PlaneSymmetric<R>, r: usize) -> [R; 2] {
    let [xx, yy, xy] = c.0;
    let (x, y) = (h[r], h[r + 2]);
    [x + (x * xx + y * xy), y + (x * xy + y * yy)]
}

/// Row r of h (I + c).
#[inline(always)]
fn deformed<R: Real>(h: &SMatrix<R, 3, 3>, c: &SolidSymmetric<R>, r: usize) -> [R; 3] {
    let [xx, yy, zz, xy, xz, yz] = c.0;
    let (x, y, z) = (h[r], h[r + 3], h[r + 6]);
    [x + (x * xx + y * xy + z * xz), y + (x * xy + y * yy + z * yz), z + (x * xz + y * yz + z * zz)]
}

/// This row times row r of h.
#[inline(always)]
fn along<R: Real>(row: &[R; 3], h: &SMatrix<R, 3, 3>, r: usize) -> R {
    row[0] * h[r] + row[1] * h[r + 3] + row[2] * h[r + 6]
}
