//! Grains for other programs.

pub mod grain_dump;
pub mod grain_export;
