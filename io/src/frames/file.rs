//! A frame file being written.

use std::fs;
use std::path::{Path, PathBuf};

use super::Frame;
use super::layout::{self, Field, Filled};
use super::read::Index;
use crate::error::Error;
use crate::h5;
use crate::system::{refused, write_aside};

/// A VTKHDF file that grows by frames; nothing of it is kept open or in memory between calls.
#[derive(Debug)]
pub struct FrameFile {
    path: PathBuf,
    fields: Vec<Field>,
    filled: Filled,
}

impl FrameFile {
    /// Creates the file with `first` in it; all later frames must have the same fields. A file already there is
    /// refused. Panics, as [`append`](FrameFile::append) does, if a field is neither `f64` nor `i64` or lacks a row per
    /// point.
    pub fn create(path: &Path, first: &Frame) -> Result<FrameFile, Error> {
        let fields = layout::fields_of(first);
        if fs::exists(path).unwrap_or(true) {
            let source = std::io::ErrorKind::AlreadyExists.into();
            return Err(Error::System { action: "create", path: path.to_owned(), source });
        }
        write_aside(path, |partial| create_in(partial, &fields, first))?;
        let filled = Filled { frames: 1, points: first.positions.len() };
        Ok(FrameFile { path: path.to_owned(), fields, filled })
    }

    /// Takes the file up again with its first `steps` frames; the rest are cut off.
    ///
    /// [`Error::TooFewFrames`] if it has fewer; with [`Error::is_damage`] if it is not whole.
    pub fn open_and_cut(path: &Path, steps: usize) -> Result<FrameFile, Error> {
        let index = Index::open(path)?;
        let found = index.frames();
        if found < steps {
            return Err(Error::TooFewFrames { path: path.to_owned(), found, expected: steps });
        }
        let filled = Filled { frames: steps, points: index.start(steps) };
        if found > steps {
            change_aside(path, "cut", |file| layout::cut(file, &index.fields, filled))?;
        }
        Ok(FrameFile { path: path.to_owned(), fields: index.fields, filled })
    }

    /// Adds a frame and returns once it is safely on disk.
    ///
    /// [`Error::FrameFields`] if the fields are not, in this order, those of the first frame. After any error the file
    /// is as it was, and the append may be tried again.
    pub fn append(&mut self, frame: &Frame) -> Result<(), Error> {
        let fields = layout::fields_of(frame);
        if fields != self.fields {
            let (found, expected) = (layout::describe(&fields), layout::describe(&self.fields));
            return Err(Error::FrameFields { path: self.path.clone(), found, expected });
        }
        change_aside(&self.path, "write", |file| layout::append(file, self.filled, frame))?;
        self.filled.frames += 1;
        self.filled.points += frame.positions.len();
        Ok(())
    }

    /// Frames in the file.
    pub fn frames(&self) -> usize {
        self.filled.frames
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn create_in(path: &Path, fields: &[Field], first: &Frame) -> Result<(), Error> {
    let file = h5::create(path)?;
    layout::create(&file, fields, first.positions.len())
        .and_then(|()| layout::append(&file, Filled { frames: 0, points: 0 }, first))
        .map_err(|error| h5::explain("write", path, &error))?;
    h5::close(file, path)
}

/// Changes a copy of the file, and gives it the file's name if all went well.
fn change_aside(
    path: &Path,
    action: &'static str,
    change: impl FnOnce(&hdf5::File) -> hdf5::Result<()>,
) -> Result<(), Error> {
    write_aside(path, |partial| {
        fs::copy(path, partial).map_err(refused("copy", path))?;
        let file = h5::open(partial, true)?;
        change(&file).map_err(|error| h5::explain(action, partial, &error))?;
        h5::close(file, partial)
    })
}
