//! Frames for ParaView: points, lines or quadrilaterals with fields over time, in VTKHDF files (transient `PolyData`, version 2.0).
//!
//! Frames are added while the run goes on, and their files are whole at every moment. HDF5 changes a file in many places
//! at once, and a full disk or a kill in between would lose every frame in it; so there are two files of the same frames,
//! one of them in a folder of the caller's. A frame is added to that one, which then takes the name, and the one that had the
//! name waits for the next, when it gets both. So a frame costs twice what it weighs, whatever came before it.
//!
//! Readers see the file before or after, never between, and one that holds it open keeps what it had: if somebody still
//! has the file that waits, open or by another name, it is left to him, and the frame goes into a copy. That it is open is
//! told by the locks that the HDF5 library sets. Where a file system has none it is added to nevertheless, but nothing of
//! the frames in it is written again.
//!
//! A file that has reached [`PART_BYTES`] is closed for good, and the frames go on in another beside it: `frames.vtkhdf`,
//! `frames.2.vtkhdf`, `frames.3.vtkhdf`, each complete by itself. So the second file costs no more room than one such part.
//! The functions here take the name of the first part and see all frames as one list.
//!
//! A run cannot be continued from frames; one that resumes cuts them back with [`FrameFile::open_and_cut`].

mod file;
mod layout;
mod read;
mod shape;
mod vtu;

use std::path::{Path, PathBuf};

pub use file::FrameFile;
pub use read::{attributes, read, read_frame, read_part, refuse_fewer, times};
pub use vtu::{pvd, write_vtu};

use crate::column::Column;

/// Bytes at which a part of the frames is closed: rarely reached, and copied in a second where a run is resumed.
pub const PART_BYTES: u64 = 512 << 20;

/// What there is to be seen at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// s.
    pub time: f64,
    /// The same in all frames of a file.
    pub drawn: Drawn,
    /// In space; a plane's third coordinate is 0. One per point, of every line where it begins and where it ends, and of quadrilaterals four.
    pub positions: Vec<[f64; 3]>,
    /// One row per point, line or quadrilateral, of `f64` or `i64`. ParaView takes width 1 as a scalar, 3 as a vector, 9 as a tensor.
    pub fields: Vec<Column>,
    /// Of the frame as a whole: one row each, of `f64`.
    pub whole: Vec<Column>,
}

/// What a field is, for whoever has the file and nothing else: `units` and `long_name` of its dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// Its name; `Points` is the places, `Values` the times.
    pub field: &'static str,
    /// "1" of a pure number.
    pub unit: &'static str,
    /// In words: its `long_name`.
    pub what: &'static str,
}

/// The one of a field, if it is among them.
fn meaning_of(meanings: &'static [Meaning], field: &str) -> Option<&'static Meaning> {
    meanings.iter().find(|meaning| meaning.field == field)
}

/// What the rows of a frame are drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// One position each.
    Points,
    /// Of two ends each, one after the other.
    Lines,
    /// Of four corners each, one after the other around it.
    Quadrilaterals,
}

impl Drawn {
    /// Positions of a row.
    pub fn positions(self) -> usize {
        match self {
            Self::Points => 1,
            Self::Lines => 2,
            Self::Quadrilaterals => 4,
        }
    }
}

impl Frame {
    /// Points, lines or quadrilaterals.
    pub fn rows(&self) -> usize {
        self.positions.len() / self.drawn.positions()
    }
}

/// The name of a part, counted from 0.
fn part(path: &Path, number: usize) -> PathBuf {
    if number == 0 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_owned();
    let mut name = stem;
    name.push(format!(".{}", number + 1));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
