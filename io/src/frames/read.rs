//! Frames read back, for reports and tests.

use std::fs;
use std::path::{Path, PathBuf};

use hdf5::{Dataset, File, Group};

use super::layout::{self, Field, Filled, Shape};
use super::{Drawn, Frame, part};
use crate::column::{Column, Kind, Values};
use crate::error::Error;
use crate::h5;

/// The files of all frames.
fn parts(path: &Path) -> impl Iterator<Item = PathBuf> {
    let others = (1..).map(|number| part(path, number)).take_while(|part| part.exists());
    std::iter::once(path.to_owned()).chain(others)
}

/// All frames, first to last.
pub fn read(path: &Path) -> Result<Vec<Frame>, Error> {
    let mut all = Vec::new();
    for path in parts(path) {
        all.extend(read_part(&path)?);
    }
    Ok(all)
}

/// All frames of one file.
pub fn read_part(path: &Path) -> Result<Vec<Frame>, Error> {
    let file = h5::open(path, false)?;
    let index = Index::read(&file, path)?;
    (0..index.frames()).map(|frame| index.frame(&file, path, frame)).collect()
}

/// One frame, counted from 0, or [`Error::TooFewFrames`].
pub fn read_frame(path: &Path, frame: usize) -> Result<Frame, Error> {
    let mut before = 0;
    for path in parts(path) {
        let file = h5::open(&path, false)?;
        let index = Index::read(&file, &path)?;
        if frame < before + index.frames() {
            return index.frame(&file, &path, frame - before);
        }
        before += index.frames();
    }
    Err(Error::TooFewFrames { path: path.to_owned(), found: before, expected: frame + 1 })
}

/// The times of all frames, first to last.
pub fn times(path: &Path) -> Result<Vec<f64>, Error> {
    let mut all = Vec::new();
    for path in parts(path) {
        all.extend(Index::open(&path)?.times);
    }
    Ok(all)
}

/// [`Error::TooFewFrames`] unless so many are there.
pub fn refuse_fewer(path: &Path, expected: usize) -> Result<(), Error> {
    let found = times(path)?.len();
    if found < expected { Err(Error::TooFewFrames { path: path.to_owned(), found, expected }) } else { Ok(()) }
}

/// What there is in a file, and where.
pub(super) struct Index {
    pub shape: Shape,
    times: Vec<f64>,
    /// Points or lines in each frame.
    rows: Vec<usize>,
}

impl Index {
    /// Reads the index of a file that is not open.
    pub fn open(path: &Path) -> Result<Index, Error> {
        Index::read(&h5::open(path, false)?, path)
    }

    fn read(file: &File, path: &Path) -> Result<Index, Error> {
        if !file.link_exists(layout::ROOT) {
            let bytes = fs::metadata(path).map_or(0, |metadata| metadata.len());
            let reason = format!("it has no group \"{}\"", layout::ROOT);
            return Err(Error::Foreign { path: path.to_owned(), bytes, expected: "a frame file", reason });
        }
        let damaged = |error: hdf5::Error| h5::damaged(path, || "its list of frames".to_owned(), &error);
        let index = Index::read_parts(file).map_err(damaged)?;
        let stored = file.dataset(&dataset_of("Points")).map_err(damaged)?.shape();
        let needed = index.start(index.frames()) * index.shape.drawn.positions();
        if stored.first().is_none_or(|stored| *stored < needed) {
            return Err(Error::Damaged {
                path: path.to_owned(),
                part: "its points".to_owned(),
                reason: format!("the frames need {needed}, the shape is {stored:?}"),
            });
        }
        Ok(index)
    }

    fn read_parts(file: &File) -> hdf5::Result<Index> {
        let root = file.group(layout::ROOT)?;
        let steps = root.group(layout::STEPS)?;
        let frames = steps.attr(layout::STEP_COUNT)?.read_scalar::<i64>()?;
        let frames = usize::try_from(frames).map_err(|_| format!("{frames} frames are counted"))?;
        let times = layout::get(&steps.dataset("Values")?, 0, frames)?;
        let drawn = match root.link_exists(Drawn::Lines.data()) {
            true => Drawn::Lines,
            false => Drawn::Points,
        };
        let counts: Vec<i64> = layout::get(&root.dataset("NumberOfPoints")?, 0, frames)?;
        let rows = counts.iter().map(|count| {
            let points = usize::try_from(*count).map_err(|_| format!("{count} points in a frame"))?;
            Ok(points / drawn.positions())
        });
        let rows = rows.collect::<hdf5::Result<_>>()?;
        let shape = Shape { drawn, fields: fields_in(&root, drawn.data())?, whole: fields_in(&root, layout::WHOLE)? };
        Ok(Index { shape, times, rows })
    }

    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// What the file held before this frame.
    pub fn filled(&self, frame: usize) -> Filled {
        self.rows[..frame].iter().fold(Filled::default(), |filled, rows| filled.and(*rows))
    }

    /// Points or lines in the frames before this one.
    fn start(&self, frame: usize) -> usize {
        self.rows[..frame].iter().sum()
    }

    fn frame(&self, file: &File, path: &Path, frame: usize) -> Result<Frame, Error> {
        let Shape { drawn, fields, whole } = &self.shape;
        let (start, rows, per_row) = (self.start(frame), self.rows[frame], drawn.positions());
        let damaged = |name: &str| {
            let part = format!("frame {frame}, {name}");
            move |error: hdf5::Error| h5::damaged(path, || part, &error)
        };
        let flat: Vec<f64> = file
            .dataset(&dataset_of("Points"))
            .and_then(|dataset| layout::get(&dataset, start * per_row, rows * per_row))
            .map_err(damaged("points"))?;
        let (positions, _) = flat.as_chunks::<3>();
        let columns = |fields: &[Field], data: &str, start: usize, rows: usize| -> Result<Vec<Column>, Error> {
            let read_named = |field: &Field| {
                let dataset = file.dataset(&dataset_of(&format!("{data}/{}", field.name)));
                let column = dataset.and_then(|dataset| read_field(&dataset, field, start, rows));
                column.map_err(damaged(&format!("field \"{}\"", field.name)))
            };
            fields.iter().map(read_named).collect()
        };
        Ok(Frame {
            time: self.times[frame],
            drawn: *drawn,
            positions: positions.to_vec(),
            fields: columns(fields, drawn.data(), start, rows)?,
            whole: columns(whole, layout::WHOLE, frame, 1)?,
        })
    }
}

/// The fields in a group of the file; none where there is no such group.
fn fields_in(root: &Group, data: &str) -> hdf5::Result<Vec<Field>> {
    if !root.link_exists(data) {
        return Ok(Vec::new());
    }
    let data = root.group(data)?;
    let field = |name: String| {
        let dataset = data.dataset(&name)?;
        let width = dataset.shape()[1..].iter().product();
        match h5::kind(&dataset)? {
            Some(kind @ (Kind::F64 | Kind::I64)) => Ok(Field { name, width, kind }),
            _ => Err(hdf5::Error::from(format!("field {name} is neither f64 nor i64"))),
        }
    };
    h5::members(&data)?.into_iter().map(field).collect()
}

fn read_field(dataset: &Dataset, field: &Field, start: usize, rows: usize) -> hdf5::Result<Column> {
    let values = match field.kind {
        Kind::F64 => Values::F64(layout::get(dataset, start, rows)?),
        _ => Values::I64(layout::get(dataset, start, rows)?),
    };
    Ok(Column { name: field.name.clone(), width: field.width, values })
}

fn dataset_of(name: &str) -> String {
    format!("{}/{name}", layout::ROOT)
}
