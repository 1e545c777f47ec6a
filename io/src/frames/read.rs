//! Frames read back, for reports and tests.

use std::fs;
use std::path::Path;

use hdf5::File;

use super::Frame;
use super::layout::{self, Field};
use crate::column::{Column, Kind, Values};
use crate::error::Error;
use crate::h5;

/// All frames of a file, first to last.
pub fn read(path: &Path) -> Result<Vec<Frame>, Error> {
    let file = h5::open(path, false)?;
    let index = Index::read(&file, path)?;
    (0..index.frames()).map(|frame| index.frame(&file, path, frame)).collect()
}

/// One frame, counted from 0, or [`Error::TooFewFrames`].
pub fn read_frame(path: &Path, frame: usize) -> Result<Frame, Error> {
    let file = h5::open(path, false)?;
    let index = Index::read(&file, path)?;
    if frame >= index.frames() {
        return Err(Error::TooFewFrames { path: path.to_owned(), found: index.frames(), expected: frame + 1 });
    }
    index.frame(&file, path, frame)
}

/// The times of all frames, first to last.
pub fn times(path: &Path) -> Result<Vec<f64>, Error> {
    Ok(Index::open(path)?.times)
}

/// What there is in a file, and where.
pub(super) struct Index {
    pub fields: Vec<Field>,
    times: Vec<f64>,
    /// Points in each frame.
    points: Vec<usize>,
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
        let stored = file.dataset(&point_dataset("Points")).map_err(damaged)?.shape();
        let needed = index.start(index.frames());
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
        let counts: Vec<i64> = layout::get(&root.dataset("NumberOfPoints")?, 0, frames)?;
        let points =
            counts.iter().map(|count| usize::try_from(*count).map_err(|_| format!("{count} points in a frame")));
        let points = points.collect::<Result<_, _>>()?;
        let data = root.group(layout::POINT_DATA)?;
        let fields = h5::members(&data)?.into_iter().map(|name| {
            let dataset = data.dataset(&name)?;
            let width = dataset.shape()[1..].iter().product();
            match h5::kind(&dataset)? {
                Some(kind @ (Kind::F64 | Kind::I64)) => Ok(Field { name, width, kind }),
                _ => Err(hdf5::Error::from(format!("field {name} is neither f64 nor i64"))),
            }
        });
        Ok(Index { fields: fields.collect::<Result<_, _>>()?, times, points })
    }

    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Points in the frames before this one.
    pub fn start(&self, frame: usize) -> usize {
        self.points[..frame].iter().sum()
    }

    fn frame(&self, file: &File, path: &Path, frame: usize) -> Result<Frame, Error> {
        let (start, points) = (self.start(frame), self.points[frame]);
        let damaged = |name: &str| {
            let part = format!("frame {frame}, {name}");
            move |error: hdf5::Error| h5::damaged(path, || part, &error)
        };
        let flat: Vec<f64> = file
            .dataset(&point_dataset("Points"))
            .and_then(|dataset| layout::get(&dataset, start, points))
            .map_err(damaged("points"))?;
        let (positions, _) = flat.as_chunks::<3>();
        let read_field = |field: &Field| {
            let dataset = file.dataset(&point_dataset(&format!("{}/{}", layout::POINT_DATA, field.name)))?;
            let values = match field.kind {
                Kind::F64 => Values::F64(layout::get(&dataset, start, points)?),
                _ => Values::I64(layout::get(&dataset, start, points)?),
            };
            Ok(Column { name: field.name.clone(), width: field.width, values })
        };
        let read_named = |field: &Field| read_field(field).map_err(damaged(&format!("field \"{}\"", field.name)));
        let fields = self.fields.iter().map(read_named).collect::<Result<_, _>>()?;
        Ok(Frame { time: self.times[frame], positions: positions.to_vec(), fields })
    }
}

fn point_dataset(name: &str) -> String {
    format!("{}/{name}", layout::ROOT)
}
