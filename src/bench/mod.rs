//! Measurements of speed, for `scree bench`.

pub mod dem;
pub mod mpm;
