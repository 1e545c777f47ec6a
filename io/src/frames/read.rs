//! Frames read back, for reports and tests.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use hdf5::{Dataset, File, Group};

use super::layout::{self, Filled, Layout};
use super::shape::{Field, Shape};
use super::{Drawn, Frame, part};
use crate::column::{Column, Kind, Values};
use crate::error::Error;
use crate::h5;
use crate::system::shared;

/// The files of all frames.
fn parts(path: &Path) -> impl Iterator<Item = PathBuf> {
    let others = (1..).map(|number| part(path, number)).take_while(|part| part.exists());
    std::iter::once(path.to_owned()).chain(others)
}

/// Opens a file of frames so that nobody changes it meanwhile.
fn open(path: &Path) -> Result<(File, fs::File), Error> {
    shared(path, || h5::open(path, false))
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
    let (file, _lock) = open(path)?;
    let index = Index::read(&file, path)?;
    (0..index.frames()).map(|frame| index.frame(&file, path, frame)).collect()
}

/// One frame, counted from 0, or [`Error::TooFewFrames`].
pub fn read_frame(path: &Path, frame: usize) -> Result<Frame, Error> {
    let mut before = 0;
    for path in parts(path) {
        let (file, _lock) = open(&path)?;
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

/// The texts that the file was created with, in the order of their keys.
pub fn attributes(path: &Path) -> Result<BTreeMap<String, String>, Error> {
    let (file, _lock) = open(path)?;
    let part = || "its list of attributes".to_owned();
    let keys = file.attr_names().map_err(|error| h5::damaged(path, part, &error))?;
    keys.into_iter().map(|key| Ok((key.clone(), h5::read_text(&file, &key, path)?))).collect()
}

/// [`Error::TooFewFrames`] unless so many are there.
pub fn refuse_fewer(path: &Path, expected: usize) -> Result<(), Error> {
    let found = times(path)?.len();
    if found < expected { Err(Error::TooFewFrames { path: path.to_owned(), found, expected }) } else { Ok(()) }
}

/// What there is in a file, and where.
pub(super) struct Index {
    pub shape: Shape,
    /// None of a file whose frames do not begin at chunks, as they did not in earlier versions of the program.
    chunk_rows: Option<usize>,
    times: Vec<f64>,
    /// Points or lines in each frame, and the number of the first among those of all frames.
    pub rows: Vec<usize>,
    starts: Vec<usize>,
}

impl Index {
    /// Reads the index of a file that is not open.
    pub fn open(path: &Path) -> Result<Index, Error> {
        let (file, _lock) = open(path)?;
        Index::read(&file, path)
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
        let ends = index.starts.iter().zip(&index.rows).map(|(start, rows)| start.saturating_add(*rows));
        let needed = ends.max().unwrap_or(0).saturating_mul(index.shape.drawn.positions());
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
        let frames = layout::step_count(&steps)?;
        let times = layout::get(&steps.dataset("Values")?, 0, frames)?;
        let corners = match steps.attr_names()?.iter().any(|name| name == layout::CORNERS) {
            true => Some(steps.attr(layout::CORNERS)?.read_scalar::<i64>()?),
            false => None,
        };
        let drawn = match (root.link_exists(Drawn::Lines.data()), corners) {
            (true, Some(4)) => Drawn::Quadrilaterals,
            (true, _) => Drawn::Lines,
            (false, _) => Drawn::Points,
        };
        let rows_in = |dataset: Dataset| -> hdf5::Result<Vec<usize>> {
            let points: Vec<i64> = layout::get(&dataset, 0, frames)?;
            let rows = |points: &i64| {
                Ok(usize::try_from(*points).map_err(|_| format!("{points} points"))? / drawn.positions())
            };
            points.iter().map(rows).collect()
        };
        let rows = rows_in(root.dataset("NumberOfPoints")?)?;
        let starts = rows_in(steps.dataset("PointOffsets")?)?;
        let chunk_rows = match steps.attr_names()?.iter().any(|name| name == layout::CHUNK_ROWS) {
            true => Some(steps.attr(layout::CHUNK_ROWS)?.read_scalar::<i64>()?.max(1) as usize),
            false => None,
        };
        if let Some(chunk_rows) = chunk_rows {
            assert_starts(chunk_rows, &rows, &starts)?;
        }
        let shape = Shape { drawn, fields: fields_in(&root, drawn.data())?, whole: fields_in(&root, layout::WHOLE)? };
        Ok(Index { shape, chunk_rows, times, rows, starts })
    }

    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// How the file is laid out, if more frames can be added to it.
    pub fn layout(&self) -> Option<Layout> {
        self.chunk_rows.map(|chunk_rows| Layout { shape: self.shape.clone(), chunk_rows })
    }

    /// What the file held before this frame.
    pub fn filled(&self, layout: &Layout, frame: usize) -> Filled {
        self.rows[..frame].iter().fold(Filled::default(), |filled, rows| layout.and(filled, *rows))
    }

    /// Where the rows of this frame begin, one of those there are.
    pub fn start(&self, frame: usize) -> usize {
        self.starts[frame]
    }

    fn frame(&self, file: &File, path: &Path, frame: usize) -> Result<Frame, Error> {
        let Shape { drawn, fields, whole } = &self.shape;
        let (start, rows, per_row) = (self.starts[frame], self.rows[frame], drawn.positions());
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

/// That frames begin where they would be written, or an error.
fn assert_starts(chunk_rows: usize, rows: &[usize], starts: &[usize]) -> hdf5::Result<()> {
    let mut chunks = 0;
    for (frame, (rows, start)) in rows.iter().zip(starts).enumerate() {
        if chunk_rows.checked_mul(chunks) != Some(*start) {
            return Err(
                format!("frame {frame} begins at row {start}, not after {chunks} chunks of {chunk_rows}").into()
            );
        }
        chunks += rows.div_ceil(chunk_rows).max(1);
    }
    Ok(())
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
