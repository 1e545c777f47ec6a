//! The inside of a VTKHDF file: which datasets there are, and how long each is after so many frames.
//!
//! Every dataset grows along its first axis and is checked by sums. Those with a row per point or line are compressed, and
//! a frame begins them at a chunk, whatever its predecessor left empty of the last one: nothing that a frame has written is
//! written again, and what lies between two frames is zero. Those with a row per frame are not compressed, so that their
//! chunks keep their size and their place. Where the format asks for the same numbers under several names, one dataset has
//! them all.

use hdf5::plist::dataset_create::FillTime;
use hdf5::types::FixedAscii;
use hdf5::{Dataset, DatasetBuilderEmpty, Extent, File, Group, H5Type, Hyperslab};
use ndarray::{ArrayViewD, IxDyn};

use super::shape::Shape;
use super::{Drawn, Frame, Meaning, meaning_of};
use crate::column::{Kind, Values};
use crate::h5;

pub(super) const ROOT: &str = "VTKHDF";
/// The kinds of cells that the format asks for. Points are vertices, quadrilaterals polygons; the last is empty.
const CELLS: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
pub(super) const STEPS: &str = "Steps";
pub(super) const STEP_COUNT: &str = "NSteps";
/// Rows of a chunk at which frames begin. Files of before this was kept have no such attribute of [`STEPS`].
pub(super) const CHUNK_ROWS: &str = "ChunkRows";
/// Positions of a row. Files of before quadrilaterals have no such attribute of [`STEPS`].
pub(super) const CORNERS: &str = "Corners";
pub(super) const WHOLE: &str = "FieldData";
/// Where each frame begins, in rows; where a field of points or lines does.
const ROW_OFFSETS: &str = "Steps/RowOffsets";

/// Frames in a chunk of what has a row per frame. Every frame rewrites the last of them.
const STEP_ROWS_PER_CHUNK: usize = 16;
/// Rows in a chunk at least, and bytes in one at most: larger ones take longer to compress.
const CHUNK_ROWS_MIN: usize = 64;
const CHUNK_BYTES_MAX: usize = 256 << 10;

impl Drawn {
    /// Which of [`CELLS`] it is.
    fn cells(self) -> usize {
        match self {
            Self::Points => 0,
            Self::Lines => 1,
            Self::Quadrilaterals => 2,
        }
    }

    /// The group of its fields.
    pub(super) fn data(self) -> &'static str {
        match self {
            Self::Points => "PointData",
            Self::Lines | Self::Quadrilaterals => "CellData",
        }
    }
}

/// How much a file holds: frames, and chunks that they take of each dataset with a row per point or line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Filled {
    pub frames: usize,
    pub chunks: usize,
}

/// How a file is laid out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub shape: Shape,
    pub chunk_rows: usize,
}

impl Layout {
    /// For frames of about `rows` rows: as few chunks of about one size as hold them.
    pub fn new(shape: Shape, rows: usize) -> Layout {
        let widest = shape.fields.iter().map(|field| field.width).chain([3 * shape.drawn.positions()]).max();
        let chunk_rows_max = CHUNK_BYTES_MAX / (widest.unwrap_or(1) * size_of::<f64>());
        let chunks = rows.div_ceil(chunk_rows_max.max(1)).max(1);
        Layout { shape, chunk_rows: rows.div_ceil(chunks).max(CHUNK_ROWS_MIN) }
    }

    /// What is filled with another frame of so many rows. One without any takes a chunk as well, of which nothing is written:
    /// frames that began at one place would be one and the same to VTK.
    pub fn and(&self, filled: Filled, rows: usize) -> Filled {
        Filled { frames: filled.frames + 1, chunks: filled.chunks + rows.div_ceil(self.chunk_rows).max(1) }
    }

    /// Lays out an empty file, whose datasets tell what they are.
    pub fn create(&self, file: &File, meanings: &'static [Meaning]) -> hdf5::Result<()> {
        let Layout { shape, chunk_rows } = self;
        let root = h5::create_group(file, ROOT)?;
        root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2_i64, 0])?;
        let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|error| error.to_string())?;
        root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
        for name in CELLS.into_iter().chain([STEPS, shape.drawn.data(), WHOLE]) {
            h5::create_group(&root, name)?;
        }
        let steps = root.group(STEPS)?;
        steps.new_attr::<i64>().create(STEP_COUNT)?.write_scalar(&0_i64)?;
        steps.new_attr::<i64>().create(CORNERS)?.write_scalar(&(shape.drawn.positions() as i64))?;
        steps.new_attr::<i64>().create(CHUNK_ROWS)?.write_scalar(&(*chunk_rows as i64))?;
        for (name, width) in self.step_numbers().into_iter().chain(self.step_zeros()) {
            grow_by_step::<i64>(&root, &name, width)?;
        }
        tell(&grow_by_step::<f64>(&root, "Steps/Values", 1)?, meaning_of(meanings, "Values"))?;
        for field in &shape.whole {
            let dataset = grow_by_step::<f64>(&root, &format!("{WHOLE}/{}", field.name), field.width)?;
            tell(&dataset, meaning_of(meanings, &field.name))?;
        }
        tell(&grow_by_row::<f64>(&root, "Points", 3, self.chunk_positions())?, meaning_of(meanings, "Points"))?;
        grow_by_row::<i64>(&root, &self.ours("Offsets"), 1, chunk_rows + 1)?;
        grow_by_row::<i64>(&root, &self.ours("Connectivity"), 1, self.chunk_positions())?;
        for field in &shape.fields {
            let name = format!("{}/{}", shape.drawn.data(), field.name);
            let dataset = match field.kind {
                Kind::F64 => grow_by_row::<f64>(&root, &name, field.width, *chunk_rows)?,
                _ => grow_by_row::<i64>(&root, &name, field.width, *chunk_rows)?,
            };
            tell(&dataset, meaning_of(meanings, &field.name))?;
        }
        self.link(&root)
    }

    /// Gives datasets the other names under which the format asks for their numbers.
    fn link(&self, root: &Group) -> hdf5::Result<()> {
        root.link_hard("NumberOfPoints", &self.ours("NumberOfConnectivityIds"))?;
        let zeros = self.zeros();
        for cells in CELLS.into_iter().filter(|cells| *cells != self.cells()) {
            for name in ["NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"] {
                let name = format!("{cells}/{name}");
                if name != zeros {
                    root.link_hard(&zeros, &name)?;
                }
            }
        }
        let Shape { drawn, fields, whole } = &self.shape;
        for (fields, data, offsets) in [(fields, drawn.data(), ROW_OFFSETS), (whole, WHOLE, "Steps/PartOffsets")] {
            let group = format!("{STEPS}/{data}Offsets");
            h5::create_group(root, &group)?;
            for field in fields {
                root.link_hard(offsets, &format!("{group}/{}", field.name))?;
            }
        }
        Ok(())
    }

    /// Writes a frame behind what is there.
    pub fn append(&self, file: &File, filled: Filled, frame: &Frame) -> hdf5::Result<()> {
        let root = file.group(ROOT)?;
        let Filled { frames, chunks } = filled;
        assert_frames(&root, frames)?;
        let (rows, per_row) = (frame.rows(), self.shape.drawn.positions());
        let start = chunks * self.chunk_rows;
        put(&root, "Points", start * per_row, frame.positions.as_flattened())?;
        // One more than cells.
        let ends: Vec<i64> = (0..=rows).map(|row| (row * per_row) as i64).collect();
        put(&root, &self.ours("Offsets"), self.offsets_start(filled), &ends)?;
        self.number_positions(&root, rows * per_row)?;
        for (columns, data, start) in [(&frame.fields, self.shape.drawn.data(), start), (&frame.whole, WHOLE, frames)] {
            for column in columns {
                let name = format!("{data}/{}", column.name);
                match &column.values {
                    Values::F64(values) => put(&root, &name, start, values)?,
                    Values::I64(values) => put(&root, &name, start, values)?,
                    Values::U64(_) | Values::U8(_) => unreachable!("a shape admits no other kind"),
                }
            }
        }
        put(&root, "Steps/Values", frames, &[frame.time])?;
        for (name, number) in [
            ("NumberOfPoints", rows * per_row),
            (&self.ours("NumberOfCells"), rows),
            ("Steps/PartOffsets", frames),
            ("Steps/NumberOfParts", 1),
            ("Steps/PointOffsets", start * per_row),
            (ROW_OFFSETS, start),
        ] {
            put(&root, name, frames, &[number as i64])?;
        }
        // VTK looks for a frame's offsets at this number and one more for each frame before it; from 9.4 on it counts only
        // frames until their cells reach this number. They never do, since every frame begins at a chunk of its own.
        let mut cells = [0; CELLS.len()];
        cells[self.shape.drawn.cells()] = (self.offsets_start(filled) - frames) as i64;
        put(&root, "Steps/CellOffsets", frames, &cells)?;
        self.grow_zeros(&root, frames + 1)?;
        set_step_count(&root.group(STEPS)?, frames + 1)
    }

    /// The positions of every frame are numbered from 0, so all frames share the numbers of the one with the most.
    fn number_positions(&self, root: &Group, positions: usize) -> hdf5::Result<()> {
        let name = self.ours("Connectivity");
        let there = root.dataset(&name)?.shape()[0];
        if positions <= there {
            return Ok(());
        }
        let end = positions.next_multiple_of(self.chunk_positions());
        let numbers: Vec<i64> = (there as i64..end as i64).collect();
        put(root, &name, there, &numbers)
    }

    /// Zeros need not be written.
    fn grow_zeros(&self, root: &Group, frames: usize) -> hdf5::Result<()> {
        self.step_zeros().into_iter().try_for_each(|(name, _)| set_rows(&root.dataset(&name)?, frames))
    }

    /// Brings a file that holds what was `filled` up to another that was like it and got one frame more.
    pub fn follow(&self, file: &File, other: &File, filled: Filled) -> hdf5::Result<()> {
        let (root, other) = (file.group(ROOT)?, other.group(ROOT)?);
        assert_frames(&root, filled.frames)?;
        assert_frames(&other, filled.frames + 1)?;
        let follow = |name: &str, first: usize| -> hdf5::Result<()> {
            let (dataset, other) = (root.dataset(name)?, other.dataset(name)?);
            let (rows, chunk) = (other.shape()[0], chunk_of(&other)?);
            set_rows(&dataset, rows)?;
            (first * chunk..rows).step_by(chunk).try_for_each(|row| h5::copy_chunk(&other, &dataset, row))
        };
        let Filled { frames, chunks } = filled;
        for name in self.step_datasets() {
            follow(&name, frames / STEP_ROWS_PER_CHUNK)?;
        }
        for name in self.row_datasets() {
            follow(&name, chunks)?;
        }
        let name = self.ours("Connectivity");
        let positions = root.dataset(&name)?.shape()[0];
        follow(&name, positions / self.chunk_positions())?;
        self.grow_zeros(&root, frames + 1)?;
        set_step_count(&root.group(STEPS)?, frames + 1)
    }

    /// Cuts a file back to what was filled then. No chunk that stays is written again.
    pub fn cut(&self, file: &File, filled: Filled) -> hdf5::Result<()> {
        cut(file, self.shape.drawn, filled.frames, filled.chunks * self.chunk_rows)?;
        shorten(&file.group(ROOT)?.dataset(&self.ours("Offsets"))?, self.offsets_start(filled))
    }

    /// Where the offsets of the next frame begin: in a chunk as well, which has one more than rows.
    fn offsets_start(&self, filled: Filled) -> usize {
        filled.chunks * (self.chunk_rows + 1)
    }

    fn cells(&self) -> &'static str {
        CELLS[self.shape.drawn.cells()]
    }

    /// The name of a dataset of the cells that the frames have.
    fn ours(&self, name: &str) -> String {
        format!("{}/{name}", self.cells())
    }

    /// The name of the dataset of zeros.
    fn zeros(&self) -> String {
        format!("{}/NumberOfCells", CELLS[3])
    }

    /// Whole numbers of every frame, with the first of the names that they have, and how many.
    fn step_numbers(&self) -> Vec<(String, usize)> {
        let offsets = ["Steps/PartOffsets", "Steps/NumberOfParts", "Steps/PointOffsets", ROW_OFFSETS];
        let names = ["NumberOfPoints", &self.ours("NumberOfCells")].map(str::to_owned).into_iter();
        let mut numbers: Vec<_> = names.chain(offsets.map(str::to_owned)).map(|name| (name, 1)).collect();
        numbers.push(("Steps/CellOffsets".to_owned(), CELLS.len()));
        numbers
    }

    /// Those of them that are zero in every frame.
    fn step_zeros(&self) -> [(String, usize); 2] {
        [(self.zeros(), 1), ("Steps/ConnectivityIdOffsets".to_owned(), CELLS.len())]
    }

    /// The datasets that have a row per frame, but for zeros.
    fn step_datasets(&self) -> Vec<String> {
        let numbers = self.step_numbers().into_iter().map(|(name, _)| name);
        let whole = self.shape.whole.iter().map(|field| format!("{WHOLE}/{}", field.name));
        numbers.chain(["Steps/Values".to_owned()]).chain(whole).collect()
    }

    /// The datasets in which every frame has chunks of its own.
    fn row_datasets(&self) -> Vec<String> {
        let data = self.shape.drawn.data();
        let fields = self.shape.fields.iter().map(|field| format!("{data}/{}", field.name));
        ["Points".to_owned(), self.ours("Offsets")].into_iter().chain(fields).collect()
    }

    /// Positions in a chunk.
    fn chunk_positions(&self) -> usize {
        self.chunk_rows * self.shape.drawn.positions()
    }
}

fn grow_by_step<T: H5Type>(group: &Group, name: &str, width: usize) -> hdf5::Result<Dataset> {
    build(group.new_dataset::<T>().fletcher32(), name, width, STEP_ROWS_PER_CHUNK)
}

fn grow_by_row<T: H5Type>(group: &Group, name: &str, width: usize, rows: usize) -> hdf5::Result<Dataset> {
    build(group.new_dataset::<T>().shuffle().deflate(1).fletcher32(), name, width, rows)
}

fn tell(dataset: &Dataset, meaning: Option<&Meaning>) -> hdf5::Result<()> {
    let Some(Meaning { unit, what, .. }) = meaning else { return Ok(()) };
    h5::write_text(dataset, "units", unit)?;
    h5::write_text(dataset, "long_name", what)
}

fn build(builder: DatasetBuilderEmpty, name: &str, width: usize, rows: usize) -> hdf5::Result<Dataset> {
    // Readers take a column of single numbers for a vector of one unless it has one axis.
    let tail = if width == 1 { Vec::new() } else { vec![width] };
    let chunk = [&[rows], tail.as_slice()].concat();
    let tail = tail.into_iter().map(Extent::fixed);
    let shape: Vec<Extent> = std::iter::once(Extent::resizable(0)).chain(tail).collect();
    // What of a chunk is not written is zero, and not what was in memory.
    builder.fill_time(FillTime::Alloc).chunk(chunk).shape(shape).create(name)
}

/// Cuts a file back to `frames` frames, behind which nothing is to be kept from row `rows` on.
pub(super) fn cut(file: &File, drawn: Drawn, frames: usize, rows: usize) -> hdf5::Result<()> {
    let root = file.group(ROOT)?;
    set_step_count(&root.group(STEPS)?, frames)?;
    shorten(&root.dataset("NumberOfPoints")?, frames)?;
    for cells in CELLS {
        let group = root.group(cells)?;
        shorten(&group.dataset("NumberOfCells")?, frames)?;
        shorten(&group.dataset("NumberOfConnectivityIds")?, frames)?;
    }
    shorten(&root.dataset("Points")?, rows * drawn.positions())?;
    for (group, rows) in [(STEPS, frames), (WHOLE, frames), (drawn.data(), rows)] {
        if root.link_exists(group) {
            shorten_all(&root.group(group)?, rows)?;
        }
    }
    Ok(())
}

fn shorten_all(group: &Group, rows: usize) -> hdf5::Result<()> {
    group.datasets()?.iter().try_for_each(|dataset| shorten(dataset, rows))?;
    group.groups()?.iter().try_for_each(|group| shorten_all(group, rows))
}

fn shorten(dataset: &Dataset, rows: usize) -> hdf5::Result<()> {
    if dataset.shape()[0] > rows { set_rows(dataset, rows) } else { Ok(()) }
}

pub(super) fn step_count(steps: &Group) -> hdf5::Result<usize> {
    let frames = steps.attr(STEP_COUNT)?.read_scalar::<i64>()?;
    Ok(usize::try_from(frames).map_err(|_| format!("{frames} frames are counted"))?)
}

/// That a file has so many frames, or an error: it may be another than it should be.
fn assert_frames(root: &Group, frames: usize) -> hdf5::Result<()> {
    let counted = step_count(&root.group(STEPS)?)?;
    if counted == frames { Ok(()) } else { Err(format!("it has {counted} frames where {frames} were written").into()) }
}

fn set_step_count(steps: &Group, frames: usize) -> hdf5::Result<()> {
    steps.attr(STEP_COUNT)?.write_scalar(&(frames as i64))
}

fn chunk_of(dataset: &Dataset) -> hdf5::Result<usize> {
    let chunk = dataset.chunk().and_then(|chunk| chunk.first().copied());
    chunk.filter(|rows| *rows > 0).ok_or_else(|| "a dataset without chunks".into())
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
