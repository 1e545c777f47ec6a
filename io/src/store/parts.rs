//! What a file is made of: texts, and columns that are filled from their first row on.

use hdf5::plist::dataset_create::FillTime;
use hdf5::{Dataset, File, Group, H5Type, Hyperslab};
use ndarray::ArrayView2;

use crate::column::{Column, Kind, Values};
use crate::h5;

/// Rows in a chunk at most. The library holds a chunk or a few of every column that is not yet whole.
const CHUNK_ROWS_MAX: usize = 16 * 1024;

/// Values of a column that are looked at to see whether they repeat.
const SAMPLE: usize = 4096;

/// Keeps a text as an attribute of the file if it can be one, or else among the long `texts`, which are compressed.
pub(super) fn write_text(file: &File, texts: &Group, key: &str, text: &str) -> hdf5::Result<()> {
    if text.len() > h5::TEXT_BYTES_MAX || text.contains('\0') {
        create_dataset::<u8>(texts, key, (text.len(), 1), Packing::Deflated)?.write_raw(text.as_bytes())
    } else {
        h5::write_text(file, key, text)
    }
}

/// Room for `rows` rows of a column that begins with `first`.
pub(super) fn create_column(group: &Group, first: &Column, rows: usize) -> hdf5::Result<Dataset> {
    let (shape, packing) = ((rows, first.width), packing_of(&first.values));
    match first.values.kind() {
        Kind::F64 => create_dataset::<f64>(group, &first.name, shape, packing),
        Kind::I64 => create_dataset::<i64>(group, &first.name, shape, packing),
        Kind::U64 => create_dataset::<u64>(group, &first.name, shape, packing),
        Kind::U8 => create_dataset::<u8>(group, &first.name, shape, packing),
    }
}

/// Whether a column is compressed.
#[derive(Clone, Copy)]
enum Packing {
    Deflated,
    Plain,
}

/// Whole numbers shrink to a fourth or less, and so do numbers that repeat; others that were computed only to four fifths,
/// which takes ten times as long as writing them.
fn packing_of(values: &Values) -> Packing {
    let Values::F64(values) = values else { return Packing::Deflated };
    let sample = &values[..values.len().min(SAMPLE)];
    let repeated = sample.windows(2).filter(|pair| pair[0].to_bits() == pair[1].to_bits()).count();
    if 2 * repeated < sample.len() { Packing::Plain } else { Packing::Deflated }
}

/// Writes the `rows` rows of a piece behind the `filled` ones that are there.
pub(super) fn write_rows(dataset: &Dataset, filled: usize, piece: &Column, rows: usize) -> hdf5::Result<()> {
    let shape = (rows, piece.width);
    match &piece.values {
        Values::F64(values) => write_values(dataset, filled, shape, values),
        Values::I64(values) => write_values(dataset, filled, shape, values),
        Values::U64(values) => write_values(dataset, filled, shape, values),
        Values::U8(values) => write_values(dataset, filled, shape, values),
    }
}

fn create_dataset<T: H5Type>(
    group: &Group,
    name: &str,
    shape: (usize, usize),
    packing: Packing,
) -> hdf5::Result<Dataset> {
    let (rows, width) = shape;
    let builder = group.new_dataset::<T>();
    if rows == 0 {
        // Nothing to compress or check, and a chunk may not be longer than its dataset.
        return builder.no_chunk().shape(shape).create(name);
    }
    let builder = match packing {
        Packing::Deflated => builder.shuffle().deflate(1),
        Packing::Plain => builder,
    };
    builder
        .chunk((h5::chunk_rows(rows.min(CHUNK_ROWS_MAX), width * size_of::<T>()), width))
        .fletcher32()
        .fill_time(FillTime::Never)
        .obj_track_times(false)
        .shape(shape)
        .create(name)
}

fn write_values<T: H5Type>(dataset: &Dataset, filled: usize, shape: (usize, usize), values: &[T]) -> hdf5::Result<()> {
    let place = Hyperslab::from(vec![(filled..filled + shape.0).into(), (..).into()]);
    dataset.write_slice(ArrayView2::from_shape(shape, values)?, place)
}
