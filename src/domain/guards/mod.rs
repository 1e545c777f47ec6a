//! What tells that a run has left physics.

pub mod grains;
pub mod points;
