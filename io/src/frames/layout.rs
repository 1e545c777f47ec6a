//! The inside of a VTKHDF file: which datasets there are, and how long each is after so many frames.
//!
//! Every dataset grows along its first axis and is checked by sums. Those with a row per point or line are compressed;
//! those with a row per frame are not, so that their chunks keep their size and their place.

use std::fmt;

use hdf5::plist::dataset_create::FillTime;
use hdf5::types::FixedAscii;
use hdf5::{Dataset, DatasetBuilderEmpty, Extent, File, Group, H5Type, Hyperslab};
use ndarray::{ArrayViewD, IxDyn};

use super::{Drawn, Frame};
use crate::column::{Column, Kind, Values, assert_name};
use crate::h5;

pub(super) const ROOT: &str = "VTKHDF";
/// The kinds of cells that the format asks for. Points are vertices; the last two are empty.
pub(super) const CELLS: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
pub(super) const STEPS: &str = "Steps";
pub(super) const STEP_COUNT: &str = "NSteps";
pub(super) const WHOLE: &str = "FieldData";
/// Datasets of `Steps` with one number per frame, and with one per frame and kind of cell.
const STEP_NUMBERS: [&str; 3] = ["PartOffsets", "NumberOfParts", "PointOffsets"];
const STEP_CELL_NUMBERS: [&str; 2] = ["CellOffsets", "ConnectivityIdOffsets"];

const STEP_ROWS_PER_CHUNK: usize = 256;

impl Drawn {
    /// Which of [`CELLS`] it is.
    fn cells(self) -> usize {
        match self {
            Self::Points => 0,
            Self::Lines => 1,
        }
    }

    /// The group of its fields.
    pub(super) fn data(self) -> &'static str {
        match self {
            Self::Points => "PointData",
            Self::Lines => "CellData",
        }
    }
}

/// Where in a group's fields each frame begins.
fn offsets_of(data: &str) -> String {
    format!("{data}Offsets")
}

/// One field as the file declares it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub width: usize,
    pub kind: Kind,
}

/// What all frames of a file have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    pub drawn: Drawn,
    pub fields: Vec<Field>,
    pub whole: Vec<Field>,
}

/// How much a file holds: frames, and points or lines in all of them together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Filled {
    pub frames: usize,
    pub rows: usize,
    /// Frames since the last that had any.
    pub empty: usize,
}

impl Filled {
    /// With another frame of so many rows.
    pub fn and(self, rows: usize) -> Filled {
        let empty = if rows == 0 { self.empty + 1 } else { 0 };
        Filled { frames: self.frames + 1, rows: self.rows + rows, empty }
    }
}

impl Shape {
    /// Panics if a field is neither `f64` nor `i64`, or has not a row per point or line.
    pub fn of(frame: &Frame) -> Shape {
        let (rows, per_row) = (frame.rows(), frame.drawn.positions());
        assert!(frame.positions.len() == rows * per_row, "frame: a line lacks an end");
        let fields: Vec<Field> = frame.fields.iter().map(|column| declare(column, rows)).collect();
        let whole: Vec<Field> = frame.whole.iter().map(|column| declare(column, 1)).collect();
        assert!(whole.iter().all(|field| field.kind == Kind::F64), "frame: what is of the whole must be f64");
        for fields in [&fields, &whole] {
            for (index, field) in fields.iter().enumerate() {
                assert!(
                    fields[..index].iter().all(|other| other.name != field.name),
                    "frame: field {} twice",
                    field.name
                );
            }
        }
        Shape { drawn: frame.drawn, fields, whole }
    }
}

fn declare(column: &Column, rows: usize) -> Field {
    assert_name(&column.name);
    column.assert_shape("frame", rows);
    let kind = column.values.kind();
    assert!(matches!(kind, Kind::F64 | Kind::I64), "frame: field {} must be f64 or i64, not {kind}", column.name);
    Field { name: column.name.clone(), width: column.width, kind }
}

/// The fields in words, for a message.
impl fmt::Display for Shape {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        let words = |fields: &[Field]| -> String {
            let words = fields.iter().map(|field| format!("{}: {} x {}", field.name, field.width, field.kind));
            words.collect::<Vec<_>>().join(", ")
        };
        write!(to, "{}", words(&self.fields))?;
        if !self.whole.is_empty() {
            write!(to, "; of the whole {}", words(&self.whole))?;
        }
        match self.drawn {
            Drawn::Points => Ok(()),
            Drawn::Lines => write!(to, "; of lines"),
        }
    }
}

/// Lays out an empty file for frames of about `rows` points or lines.
pub(super) fn create(file: &File, shape: &Shape, rows: usize) -> hdf5::Result<()> {
    // The last chunk of a frame is rewritten, and its old place lost, when the next frame comes: keep chunks small.
    let rows = (rows / 8).clamp(64, 32 * 1024);
    let root = h5::create_group(file, ROOT)?;
    root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2_i64, 0])?;
    let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|error| error.to_string())?;
    root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
    grow_by_step::<i64>(&root, "NumberOfPoints", &[])?;
    grow_by_row::<f64>(&root, "Points", 3, rows)?;
    for cells in CELLS {
        let group = h5::create_group(&root, cells)?;
        grow_by_step::<i64>(&group, "NumberOfCells", &[])?;
        grow_by_step::<i64>(&group, "NumberOfConnectivityIds", &[])?;
        let rows = if cells == CELLS[shape.drawn.cells()] { rows } else { STEP_ROWS_PER_CHUNK };
        grow_by_row::<i64>(&group, "Offsets", 1, rows)?;
        grow_by_row::<i64>(&group, "Connectivity", 1, rows)?;
    }
    let steps = h5::create_group(&root, STEPS)?;
    steps.new_attr::<i64>().create(STEP_COUNT)?.write_scalar(&0_i64)?;
    grow_by_step::<f64>(&steps, "Values", &[])?;
    for name in STEP_NUMBERS {
        grow_by_step::<i64>(&steps, name, &[])?;
    }
    for name in STEP_CELL_NUMBERS {
        grow_by_step::<i64>(&steps, name, &[CELLS.len()])?;
    }
    let data = h5::create_group(&root, shape.drawn.data())?;
    let offsets = h5::create_group(&steps, &offsets_of(shape.drawn.data()))?;
    for field in &shape.fields {
        grow_by_step::<i64>(&offsets, &field.name, &[])?;
        match field.kind {
            Kind::F64 => grow_by_row::<f64>(&data, &field.name, field.width, rows)?,
            _ => grow_by_row::<i64>(&data, &field.name, field.width, rows)?,
        };
    }
    let data = h5::create_group(&root, WHOLE)?;
    let offsets = h5::create_group(&steps, &offsets_of(WHOLE))?;
    for field in &shape.whole {
        grow_by_step::<i64>(&offsets, &field.name, &[])?;
        let tail = [field.width];
        grow_by_step::<f64>(&data, &field.name, if field.width == 1 { &[] } else { &tail })?;
    }
    Ok(())
}

fn grow_by_step<T: H5Type>(group: &Group, name: &str, tail: &[usize]) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>().fletcher32().fill_time(FillTime::Never);
    build(builder, name, STEP_ROWS_PER_CHUNK, tail)
}

fn grow_by_row<T: H5Type>(group: &Group, name: &str, width: usize, rows: usize) -> hdf5::Result<Dataset> {
    let rows = h5::chunk_rows(rows, width * size_of::<T>());
    let builder = group.new_dataset::<T>().shuffle().deflate(1).fletcher32().fill_time(FillTime::Never);
    // Readers take a column of single numbers for a vector of one unless it has one axis.
    if width == 1 { build(builder, name, rows, &[]) } else { build(builder, name, rows, &[width]) }
}

fn build(builder: DatasetBuilderEmpty, name: &str, rows: usize, tail: &[usize]) -> hdf5::Result<Dataset> {
    let chunk: Vec<usize> = [&[rows], tail].concat();
    let tail = tail.iter().map(|length| Extent::fixed(*length));
    let shape: Vec<Extent> = std::iter::once(Extent::resizable(0)).chain(tail).collect();
    builder.chunk(chunk).shape(shape).create(name)
}

/// Writes a frame behind what is there, and counts it last: a reader goes by the count.
pub(super) fn append(file: &File, shape: &Shape, filled: Filled, frame: &Frame) -> hdf5::Result<()> {
    let root = file.group(ROOT)?;
    let Filled { frames, rows: start, .. } = filled;
    let (rows, per_row, ours) = (frame.rows(), shape.drawn.positions(), shape.drawn.cells());
    put(&root, "NumberOfPoints", frames, &[(rows * per_row) as i64])?;
    put(&root, "Points", start * per_row, frame.positions.as_flattened())?;
    for (kind, cells) in CELLS.into_iter().enumerate() {
        let (start, rows, empty) = if kind == ours { (start, rows, filled.empty) } else { (0, 0, frames) };
        let group = root.group(cells)?;
        let numbers: Vec<i64> = (0..(rows * per_row) as i64).collect();
        // One more offset than cells in every frame. VTK takes frames that begin at one cell for one and the same and
        // looks for their offsets where the first of them has its own: what empty frames leave over goes behind.
        let ends = (0..=rows + empty).map(|row| (row.min(rows) * per_row) as i64);
        let ends: Vec<i64> = ends.collect();
        put(&group, "NumberOfCells", frames, &[rows as i64])?;
        put(&group, "NumberOfConnectivityIds", frames, &[numbers.len() as i64])?;
        put(&group, "Connectivity", start * per_row, &numbers)?;
        put(&group, "Offsets", start + frames - empty, &ends)?;
    }
    let steps = root.group(STEPS)?;
    put(&steps, "Values", frames, &[frame.time])?;
    for (name, number) in STEP_NUMBERS.into_iter().zip([frames, 1, start * per_row]) {
        put(&steps, name, frames, &[number as i64])?;
    }
    for (name, number) in STEP_CELL_NUMBERS.into_iter().zip([start, start * per_row]) {
        let mut numbers = [0; CELLS.len()];
        numbers[ours] = number as i64;
        put(&steps, name, frames, &numbers)?;
    }
    for (columns, name, start) in [(&frame.fields, shape.drawn.data(), start), (&frame.whole, WHOLE, frames)] {
        if columns.is_empty() {
            continue;
        }
        let (offsets, data) = (steps.group(&offsets_of(name))?, root.group(name)?);
        for column in columns {
            put(&offsets, &column.name, frames, &[start as i64])?;
            match &column.values {
                Values::F64(values) => put(&data, &column.name, start, values)?,
                Values::I64(values) => put(&data, &column.name, start, values)?,
                Values::U64(_) | Values::U8(_) => unreachable!("a shape admits no other kind"),
            }
        }
    }
    file.flush()?;
    set_step_count(&steps, frames + 1)
}

/// Cuts every dataset back to what it held then.
pub(super) fn cut(file: &File, shape: &Shape, filled: Filled) -> hdf5::Result<()> {
    let root = file.group(ROOT)?;
    let Filled { frames, rows, .. } = filled;
    let (per_row, ours) = (shape.drawn.positions(), shape.drawn.cells());
    let steps = root.group(STEPS)?;
    set_step_count(&steps, frames)?;
    set_rows(&root.dataset("NumberOfPoints")?, frames)?;
    set_rows(&root.dataset("Points")?, rows * per_row)?;
    for (kind, cells) in CELLS.into_iter().enumerate() {
        let rows = if kind == ours { rows } else { 0 };
        let group = root.group(cells)?;
        set_rows(&group.dataset("NumberOfCells")?, frames)?;
        set_rows(&group.dataset("NumberOfConnectivityIds")?, frames)?;
        set_rows(&group.dataset("Connectivity")?, rows * per_row)?;
        set_rows(&group.dataset("Offsets")?, rows + frames)?;
    }
    for name in ["Values"].iter().chain(&STEP_NUMBERS).chain(&STEP_CELL_NUMBERS) {
        set_rows(&steps.dataset(name)?, frames)?;
    }
    for (fields, name, rows) in [(&shape.fields, shape.drawn.data(), rows), (&shape.whole, WHOLE, frames)] {
        if fields.is_empty() {
            continue;
        }
        let (offsets, data) = (steps.group(&offsets_of(name))?, root.group(name)?);
        for field in fields {
            set_rows(&offsets.dataset(&field.name)?, frames)?;
            set_rows(&data.dataset(&field.name)?, rows)?;
        }
    }
    Ok(())
}

fn set_step_count(steps: &Group, frames: usize) -> hdf5::Result<()> {
    steps.attr(STEP_COUNT)?.write_scalar(&(frames as i64))
}

/// Makes `values` the rows of a dataset from `start` on, and the last it has.
fn put<T: H5Type>(group: &Group, name: &str, start: usize, values: &[T]) -> hdf5::Result<()> {
    let dataset = group.dataset(name)?;
    let mut shape = dataset.shape();
    let rows = values.len() / shape[1..].iter().product::<usize>();
    set_rows(&dataset, start + rows)?;
    if rows == 0 {
        return Ok(());
    }
    shape[0] = rows;
    let values = ArrayViewD::from_shape(IxDyn(&shape), values)?;
    dataset.write_slice(values, rows_of(&dataset, start, rows))
}

/// Reads `rows` rows of a dataset from `start` on.
pub(super) fn get<T: H5Type>(dataset: &Dataset, start: usize, rows: usize) -> hdf5::Result<Vec<T>> {
    if rows == 0 {
        return Ok(Vec::new());
    }
    let values = dataset.read_slice::<T, _, IxDyn>(rows_of(dataset, start, rows))?;
    Ok(values.into_iter().collect())
}

fn rows_of(dataset: &Dataset, start: usize, rows: usize) -> Hyperslab {
    let mut slices = vec![(start..start + rows).into()];
    slices.resize(dataset.ndim(), (..).into());
    Hyperslab::from(slices)
}

fn set_rows(dataset: &Dataset, rows: usize) -> hdf5::Result<()> {
    let mut shape = dataset.shape();
    if shape[0] == rows {
        return Ok(());
    }
    shape[0] = rows;
    dataset.resize(shape)
}
