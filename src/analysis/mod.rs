//! Numbers from runs: no drawing.

pub mod band;
pub mod calibrate;
pub mod strip;
