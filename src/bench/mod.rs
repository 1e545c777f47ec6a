//! Measurements of speed, for `scree bench`.

pub mod dem;
