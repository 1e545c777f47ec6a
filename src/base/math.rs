//! The one door to inexact mathematics (invariant 2): every function here gives the same bits on every machine, because
//! it is `libm`'s software routine and never the C library's or the processor's.

/// `x` in rad.
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// `x` in rad.
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// `x` in rad.
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// rad, in [-pi/2, pi/2].
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Angle of the point (x, y) from the x axis, rad, counterclockwise, in [-pi, pi].
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// e to the power `x`.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// `exp(x) - 1`, to full precision where x is small.
pub fn exp_minus_one(x: f64) -> f64 {
    libm::expm1(x)
}

/// `ln(1 + x)`, to full precision where x is small.
pub fn ln_one_plus(x: f64) -> f64 {
    libm::log1p(x)
}

/// Natural logarithm; minus infinity of 0, NaN below.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The real root, negative below 0.
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

pub use std::f64::consts::PI;
