//! Numbers from runs: no drawing.

pub mod band;
pub mod calibrate;
pub mod columns;
pub mod curve;
pub mod drive;
pub mod interval;
pub mod measures;
pub mod run;
pub mod snapshot;
pub mod space;
pub mod strained;
pub mod strength;
pub mod strip;
pub mod sweep;
pub mod zone;
