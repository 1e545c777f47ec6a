//! Columns on disk. This crate knows files, not physics.
//!
//! | module | what it keeps | can a run go on from it? |
//! |---|---|---|
//! | [`store`] | a [`State`] in one HDF5 file, checked when read | yes |
//! | [`frames`] | points or lines with fields, a frame per time, for ParaView | no |
//! | [`series`] | rows of numbers in a CSV file | no |
//! | [`gmsh`] | a mesh that Gmsh has made, read only | |
//! | [`digest()`] | 64 hex digits that stand for a [`State`] | |
//!
//! Everything here is written by one process; gathering is the caller's task. The HDF5 library must be 1.10.7 or newer
//! (1.12.0 excepted): older ones cannot switch file locks off, and many cluster file systems have none.

#![deny(missing_docs)]

pub mod column;
pub mod digest;
pub mod error;
pub mod frames;
pub mod gmsh;
mod h5;
pub mod schema;
pub mod series;
pub mod store;
mod system;

pub use column::{Column, Kind, State, Table, Values};
pub use digest::digest;
pub use error::Error;
pub use frames::{Drawn, Frame, FrameFile, Meaning};
pub use series::Series;
