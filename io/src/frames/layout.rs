//! The inside of a VTKHDF file: which datasets there are, and how long each is after so many frames.
//!
//! Every dataset grows along its first axis and is checked by sums. Those with a row per point are compressed; those
//! with a row per frame are not, so that their chunks keep their size and their place.

use hdf5::plist::dataset_create::FillTime;
use hdf5::types::FixedAscii;
use hdf5::{Dataset, DatasetBuilderEmpty, Extent, File, Group, H5Type, Hyperslab};
use ndarray::{ArrayViewD, IxDyn};

use super::Frame;
use crate::column::{Column, Kind, Values, assert_name};
use crate::h5;

pub(super) const ROOT: &str = "VTKHDF";
/// The kinds of cells that the format asks for. Only the first has any here: a vertex per point.
pub(super) const CELLS: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
pub(super) const STEPS: &str = "Steps";
pub(super) const STEP_COUNT: &str = "NSteps";
pub(super) const POINT_DATA: &str = "PointData";
/// Datasets of `Steps` with one number per frame, and with one per frame and kind of cell.
const STEP_NUMBERS: [&str; 3] = ["PartOffsets", "NumberOfParts", "PointOffsets"];
const STEP_CELL_NUMBERS: [&str; 2] = ["CellOffsets", "ConnectivityIdOffsets"];
const POINT_DATA_OFFSETS: &str = "PointDataOffsets";

const STEP_ROWS_PER_CHUNK: usize = 256;

/// One field as the file declares it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub width: usize,
    pub kind: Kind,
}

/// How much a file holds: frames, and points in all of them together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filled {
    pub frames: usize,
    pub points: usize,
}

/// The fields of a frame. Panics if a field is neither `f64` nor `i64`, or has not a row per point.
pub(super) fn fields_of(frame: &Frame) -> Vec<Field> {
    let declare = |column: &Column| {
        assert_name(&column.name);
        column.assert_shape("frame", frame.positions.len());
        let kind = column.values.kind();
        assert!(matches!(kind, Kind::F64 | Kind::I64), "frame: field {} must be f64 or i64, not {kind}", column.name);
        Field { name: column.name.clone(), width: column.width, kind }
    };
    let fields: Vec<Field> = frame.fields.iter().map(declare).collect();
    for (index, field) in fields.iter().enumerate() {
        assert!(fields[..index].iter().all(|other| other.name != field.name), "frame: field {} twice", field.name);
    }
    fields
}

/// The fields in words, for a message.
pub(super) fn describe(fields: &[Field]) -> String {
    let words = fields.iter().map(|field| format!("{}: {} x {}", field.name, field.width, field.kind));
    words.collect::<Vec<_>>().join(", ")
}

/// Lays out an empty file for frames of about `points` points.
pub(super) fn create(file: &File, fields: &[Field], points: usize) -> hdf5::Result<()> {
    // The last chunk of a frame is rewritten, and its old place lost, when the next frame comes: keep chunks small.
    let rows = (points / 8).clamp(64, 32 * 1024);
    let root = h5::create_group(file, ROOT)?;
    root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2_i64, 0])?;
    let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|error| error.to_string())?;
    root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
    grow_by_step::<i64>(&root, "NumberOfPoints", &[])?;
    grow_by_point::<f64>(&root, "Points", 3, rows)?;
    for cells in CELLS {
        let group = h5::create_group(&root, cells)?;
        grow_by_step::<i64>(&group, "NumberOfCells", &[])?;
        grow_by_step::<i64>(&group, "NumberOfConnectivityIds", &[])?;
        let rows = if cells == CELLS[0] { rows } else { STEP_ROWS_PER_CHUNK };
        grow_by_point::<i64>(&group, "Offsets", 1, rows)?;
        grow_by_point::<i64>(&group, "Connectivity", 1, rows)?;
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
    let offsets = h5::create_group(&steps, POINT_DATA_OFFSETS)?;
    let data = h5::create_group(&root, POINT_DATA)?;
    for field in fields {
        grow_by_step::<i64>(&offsets, &field.name, &[])?;
        match field.kind {
            Kind::F64 => grow_by_point::<f64>(&data, &field.name, field.width, rows)?,
            _ => grow_by_point::<i64>(&data, &field.name, field.width, rows)?,
        };
    }
    Ok(())
}

fn grow_by_step<T: H5Type>(group: &Group, name: &str, tail: &[usize]) -> hdf5::Result<Dataset> {
    let builder = group.new_dataset::<T>().fletcher32().fill_time(FillTime::Never);
    build(builder, name, STEP_ROWS_PER_CHUNK, tail)
}

fn grow_by_point<T: H5Type>(group: &Group, name: &str, width: usize, rows: usize) -> hdf5::Result<Dataset> {
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
pub(super) fn append(file: &File, filled: Filled, frame: &Frame) -> hdf5::Result<()> {
    let root = file.group(ROOT)?;
    let points = frame.positions.len();
    let Filled { frames, points: start } = filled;
    put(&root, "NumberOfPoints", frames, &[points as i64])?;
    put(&root, "Points", start, frame.positions.as_flattened())?;
    for cells in CELLS {
        let (start, count) = if cells == CELLS[0] { (start, points) } else { (0, 0) };
        let group = root.group(cells)?;
        let numbers: Vec<i64> = (0..=count as i64).collect();
        put(&group, "NumberOfCells", frames, &[count as i64])?;
        put(&group, "NumberOfConnectivityIds", frames, &[count as i64])?;
        put(&group, "Connectivity", start, &numbers[..count])?;
        // One more offset than cells in every frame.
        put(&group, "Offsets", start + frames, &numbers)?;
    }
    let steps = root.group(STEPS)?;
    put(&steps, "Values", frames, &[frame.time])?;
    for (name, number) in STEP_NUMBERS.into_iter().zip([frames, 1, start]) {
        put(&steps, name, frames, &[number as i64])?;
    }
    for name in STEP_CELL_NUMBERS {
        put(&steps, name, frames, &[start as i64, 0, 0, 0])?;
    }
    let (offsets, data) = (steps.group(POINT_DATA_OFFSETS)?, root.group(POINT_DATA)?);
    for field in &frame.fields {
        put(&offsets, &field.name, frames, &[start as i64])?;
        match &field.values {
            Values::F64(values) => put(&data, &field.name, start, values)?,
            Values::I64(values) => put(&data, &field.name, start, values)?,
            Values::U64(_) | Values::U8(_) => unreachable!("fields_of admits no other kind"),
        }
    }
    file.flush()?;
    set_step_count(&steps, frames + 1)
}

/// Cuts every dataset back to what it held then.
pub(super) fn cut(file: &File, fields: &[Field], filled: Filled) -> hdf5::Result<()> {
    let root = file.group(ROOT)?;
    let Filled { frames, points } = filled;
    let steps = root.group(STEPS)?;
    set_step_count(&steps, frames)?;
    set_rows(&root.dataset("NumberOfPoints")?, frames)?;
    set_rows(&root.dataset("Points")?, points)?;
    for cells in CELLS {
        let count = if cells == CELLS[0] { points } else { 0 };
        let group = root.group(cells)?;
        set_rows(&group.dataset("NumberOfCells")?, frames)?;
        set_rows(&group.dataset("NumberOfConnectivityIds")?, frames)?;
        set_rows(&group.dataset("Connectivity")?, count)?;
        set_rows(&group.dataset("Offsets")?, count + frames)?;
    }
    for name in ["Values"].iter().chain(&STEP_NUMBERS).chain(&STEP_CELL_NUMBERS) {
        set_rows(&steps.dataset(name)?, frames)?;
    }
    let (offsets, data) = (steps.group(POINT_DATA_OFFSETS)?, root.group(POINT_DATA)?);
    for field in fields {
        set_rows(&offsets.dataset(&field.name)?, frames)?;
        set_rows(&data.dataset(&field.name)?, points)?;
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
