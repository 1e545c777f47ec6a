//! A frame file being written.

use std::fs;
use std::path::{Path, PathBuf};

use super::layout::{self, Filled, Shape};
use super::read::Index;
use super::{Frame, PART_BYTES, part};
use crate::error::Error;
use crate::h5;
use crate::system::{folder, refused, sync, write_aside};

/// VTKHDF files that grow by frames; nothing of them is kept open or in memory between calls.
#[derive(Debug)]
pub struct FrameFile {
    path: PathBuf,
    shape: Shape,
    /// Parts that are closed, and frames in them.
    closed: usize,
    frames_closed: usize,
    /// What the part that grows holds.
    filled: Filled,
    part_bytes: u64,
}

impl FrameFile {
    /// Creates the file with `first` in it; all later frames must have the same fields. A file already there is
    /// refused. Panics, as [`append`](FrameFile::append) does, if a field is neither `f64` nor `i64` or lacks a row per
    /// point.
    pub fn create(path: &Path, _scratch: &Path, first: &Frame) -> Result<FrameFile, Error> {
        let shape = Shape::of(first);
        for path in [path.to_owned(), part(path, 1)] {
            if fs::exists(&path).unwrap_or(true) {
                let source = std::io::ErrorKind::AlreadyExists.into();
                return Err(Error::System { action: "create", path, source });
            }
        }
        write_aside(path, |partial| create_in(partial, &shape, first))?;
        let filled = Filled::default().and(first.rows());
        Ok(FrameFile { path: path.to_owned(), shape, closed: 0, frames_closed: 0, filled, part_bytes: PART_BYTES })
    }

    /// Takes the file up again with its first `steps` frames; the rest are cut off.
    ///
    /// [`Error::TooFewFrames`] if it has fewer; with [`Error::is_damage`] if it is not whole.
    pub fn open_and_cut(path: &Path, _scratch: &Path, steps: usize) -> Result<FrameFile, Error> {
        let (mut closed, mut frames_closed) = (0, 0);
        let mut index = Index::open(path)?;
        while frames_closed + index.frames() < steps {
            let found = frames_closed + index.frames();
            let next = part(path, closed + 1);
            if !next.exists() {
                return Err(Error::TooFewFrames { path: path.to_owned(), found, expected: steps });
            }
            (closed, frames_closed, index) = (closed + 1, found, Index::open(&next)?);
        }
        // The last goes first: what is left at any moment are the frames that were written first.
        let beyond = (closed + 1..).map(|number| part(path, number)).take_while(|part| part.exists());
        let beyond: Vec<PathBuf> = beyond.collect();
        for part in beyond.iter().rev() {
            fs::remove_file(part).map_err(refused("remove", part))?;
            sync(folder(part))?;
        }
        let filled = index.filled(steps - frames_closed);
        if index.frames() > filled.frames {
            change_aside(&part(path, closed), "cut", |file| layout::cut(file, &index.shape, filled))?;
        }
        let (path, shape) = (path.to_owned(), index.shape);
        Ok(FrameFile { path, shape, closed, frames_closed, filled, part_bytes: PART_BYTES })
    }

    /// Closes parts at other sizes than [`PART_BYTES`].
    pub fn with_parts_of(self, part_bytes: u64) -> FrameFile {
        FrameFile { part_bytes, ..self }
    }

    /// Adds a frame and returns once it is safely on disk.
    ///
    /// [`Error::FrameFields`] if the fields are not, in this order, those of the first frame. After any error the files
    /// are as they were, and the append may be tried again.
    pub fn append(&mut self, frame: &Frame) -> Result<(), Error> {
        let shape = Shape::of(frame);
        if shape != self.shape {
            let (found, expected) = (shape.to_string(), self.shape.to_string());
            return Err(Error::FrameFields { path: self.path.clone(), found, expected });
        }
        let path = part(&self.path, self.closed);
        let bytes = fs::metadata(&path).map_err(refused("look at", &path))?.len();
        if bytes >= self.part_bytes && self.filled.frames > 0 {
            return self.go_on_in_another(frame);
        }
        change_aside(&path, "write", |file| layout::append(file, &self.shape, self.filled, frame))?;
        self.filled = self.filled.and(frame.rows());
        Ok(())
    }

    fn go_on_in_another(&mut self, frame: &Frame) -> Result<(), Error> {
        write_aside(&part(&self.path, self.closed + 1), |partial| create_in(partial, &self.shape, frame))?;
        self.closed += 1;
        self.frames_closed += self.filled.frames;
        self.filled = Filled::default().and(frame.rows());
        Ok(())
    }

    /// Frames in all parts.
    pub fn frames(&self) -> usize {
        self.frames_closed + self.filled.frames
    }

    /// Where the first part is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn create_in(path: &Path, shape: &Shape, first: &Frame) -> Result<(), Error> {
    let file = h5::create(path)?;
    layout::create(&file, shape, first.rows())
        .and_then(|()| layout::append(&file, shape, Filled::default(), first))
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
