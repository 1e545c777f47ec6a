//! The one door to inexact mathematics (invariant 2): every function here gives the same bits on every machine, because
//! it is `libm`'s software routine and never the C library's or the processor's.

pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

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

pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

pub use std::f64::consts::PI;
