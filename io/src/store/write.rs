//! From a state to a file.

use std::path::Path;

use hdf5::plist::dataset_create::FillTime;
use hdf5::types::FixedUnicode;
use hdf5::{File, Group, H5Type};

use crate::column::{Column, State, Values};
use crate::digest::{digest, seal};
use crate::error::Error;
use crate::h5;
use crate::schema;
use crate::system::write_aside;

/// Bytes of the longest text that is kept as an attribute. HDF5 bounds attributes, and only datasets are compressed.
pub(super) const ATTRIBUTE_BYTES_MAX: usize = 1024;

/// Writes the state to `path` and returns once it is safely on disk. A file already there is replaced as a whole, or,
/// on an error, left as it was. Equal states give equal bytes.
///
/// Panics if a column's length is not rows times width, if a name is empty, repeated or has a `/`, or if an attribute
/// has one of the names in [`schema`](crate::schema).
pub fn write(path: &Path, state: &State) -> Result<(), Error> {
    state.assert_shape();
    for name in schema::RESERVED_ATTRIBUTES {
        assert!(!state.attributes.contains_key(name), "the attribute {name} is the file's own");
    }
    write_aside(path, |partial| {
        let file = h5::create(partial)?;
        fill(&file, state).map_err(|error| h5::explain("write", partial, &error))?;
        h5::close(file, partial)
    })
}

fn fill(file: &File, state: &State) -> hdf5::Result<()> {
    let digest = digest(state);
    file.new_attr::<u64>().create(schema::VERSION_ATTRIBUTE)?.write_scalar(&schema::SCHEMA_VERSION)?;
    write_attribute::<64>(file, schema::SEAL_ATTRIBUTE, &seal(state, &digest))?;
    write_attribute::<64>(file, schema::DIGEST_ATTRIBUTE, &digest)?;
    let texts = h5::create_group(file, schema::TEXT_GROUP)?;
    for (key, text) in &state.attributes {
        write_text(file, &texts, key, text)?;
    }
    let tables = h5::create_group(file, schema::TABLES_GROUP)?;
    for table in &state.tables {
        let group = h5::create_group(&tables, &table.name)?;
        group.new_attr::<u64>().create(schema::ROWS_ATTRIBUTE)?.write_scalar(&(table.rows as u64))?;
        for column in &table.columns {
            write_column(&group, column, table.rows)?;
        }
    }
    Ok(())
}

fn write_text(file: &File, texts: &Group, key: &str, text: &str) -> hdf5::Result<()> {
    // Attributes are padded with zeros, so a text that has some cannot be one.
    if text.len() > ATTRIBUTE_BYTES_MAX || text.contains('\0') {
        write_values(texts, key, (text.len(), 1), text.as_bytes())
    } else if text.len() <= 64 {
        write_attribute::<64>(file, key, text)
    } else {
        write_attribute::<ATTRIBUTE_BYTES_MAX>(file, key, text)
    }
}

/// Text of fixed length: the library keeps text of variable length without a checksum.
fn write_attribute<const N: usize>(file: &File, key: &str, text: &str) -> hdf5::Result<()> {
    let text: FixedUnicode<N> = text.parse().map_err(|error| format!("attribute {key}: {error}"))?;
    file.new_attr::<FixedUnicode<N>>().create(key)?.write_scalar(&text)
}

fn write_column(group: &Group, column: &Column, rows: usize) -> hdf5::Result<()> {
    let shape = (rows, column.width);
    match &column.values {
        Values::F64(values) => write_values(group, &column.name, shape, values),
        Values::I64(values) => write_values(group, &column.name, shape, values),
        Values::U64(values) => write_values(group, &column.name, shape, values),
        Values::U8(values) => write_values(group, &column.name, shape, values),
    }
}

fn write_values<T: H5Type>(group: &Group, name: &str, shape: (usize, usize), values: &[T]) -> hdf5::Result<()> {
    let (rows, width) = shape;
    let builder = group.new_dataset::<T>();
    if rows == 0 {
        // Nothing to compress or check, and a chunk may not be longer than its dataset.
        return builder.no_chunk().shape(shape).create(name).map(|_| ());
    }
    builder
        .chunk((h5::chunk_rows(rows, width * size_of::<T>()), width))
        .shuffle()
        .deflate(1)
        .fletcher32()
        .fill_time(FillTime::Never)
        .obj_track_times(false)
        .shape(shape)
        .create(name)?
        .write_raw(values)
}
