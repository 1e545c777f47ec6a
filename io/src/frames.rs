//! Frames for ParaView: points with fields over time, in one VTKHDF file (transient `PolyData`, version 2.0).
//!
//! A frame file grows while the run goes on and is whole at every moment. HDF5 changes a file in many places at once,
//! and a full disk or a kill in between would lose every frame in it; so a frame is added to a copy, which then takes
//! the name. Readers see the file before or after, never between. The copying is nothing beside the steps between two
//! frames while the file has some gigabytes; for more, begin a new file from time to time.
//!
//! A run cannot be continued from frames; one that resumes cuts them back with [`FrameFile::open_and_cut`].

mod file;
mod layout;
mod read;

pub use file::FrameFile;
pub use read::{read, read_frame, times};

use crate::column::Column;

/// The points at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub time: f64,
    /// One per point, in space; a plane's third coordinate is 0.
    pub positions: Vec<[f64; 3]>,
    /// One row per point, of `f64` or `i64`. ParaView takes width 1 as a scalar, 3 as a vector, 9 as a tensor.
    pub fields: Vec<Column>,
}
