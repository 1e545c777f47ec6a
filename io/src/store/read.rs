//! From a file to a state, believing nothing.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use hdf5::{Dataset, File, Group};

use crate::column::{Column, Kind, State, Table, Values};
use crate::digest::{digest, seal};
use crate::error::Error;
use crate::h5;
use crate::schema;

/// Reads a state back, exactly as it was written, or fails: [`Error::System`], or with [`Error::is_damage`] if the file
/// is not whole, or [`Error::Schema`] if another version of the program wrote it.
pub fn read(path: &Path) -> Result<State, Error> {
    let file = h5::open(path, false)?;
    check_schema(&file, path)?;
    let state = State { attributes: read_attributes(&file, path)?, tables: read_tables(&file, path)? };
    let digest = digest(&state);
    check_sum("the digest", schema::DIGEST_ATTRIBUTE, &digest, &file, path)?;
    check_sum("the seal", schema::SEAL_ATTRIBUTE, &seal(&state.attributes, &digest), &file, path)?;
    Ok(state)
}

fn check_schema(file: &File, path: &Path) -> Result<(), Error> {
    let names = file.attr_names().map_err(|error| damaged_attributes(path, &error))?;
    if !names.iter().any(|name| name == schema::VERSION_ATTRIBUTE) {
        let bytes = fs::metadata(path).map_or(0, |metadata| metadata.len());
        let reason = format!("it has no attribute \"{}\"", schema::VERSION_ATTRIBUTE);
        return Err(Error::Foreign { path: path.to_owned(), bytes, expected: "a checkpoint", reason });
    }
    let found = file
        .attr(schema::VERSION_ATTRIBUTE)
        .and_then(|attribute| attribute.read_scalar::<u64>())
        .map_err(|error| damaged_attributes(path, &error))?;
    let (oldest, newest) = (schema::SCHEMA_OLDEST, schema::SCHEMA_VERSION);
    if !(oldest..=newest).contains(&found) {
        return Err(Error::Schema { path: path.to_owned(), found, oldest, newest });
    }
    Ok(())
}

fn check_sum(what: &'static str, key: &str, found: &str, file: &File, path: &Path) -> Result<(), Error> {
    let stored = h5::read_text(file, key, path)?;
    if stored != found {
        return Err(Error::Digest { path: path.to_owned(), what, stored, found: found.to_owned() });
    }
    Ok(())
}

fn read_attributes(file: &File, path: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut attributes = BTreeMap::new();
    for key in file.attr_names().map_err(|error| damaged_attributes(path, &error))? {
        if !schema::RESERVED_ATTRIBUTES.contains(&key.as_str()) {
            let text = h5::read_text(file, &key, path)?;
            attributes.insert(key, text);
        }
    }
    let part = || "its long attributes".to_owned();
    let texts = file.group(schema::TEXT_GROUP).map_err(|error| h5::damaged(path, part, &error))?;
    for key in h5::members(&texts).map_err(|error| h5::damaged(path, part, &error))? {
        let part = || format!("attribute \"{key}\"");
        let damaged = |error: hdf5::Error| h5::damaged(path, part, &error);
        let dataset = texts.dataset(&key).map_err(damaged)?;
        refuse_too_large(&dataset, path, part)?;
        let bytes = dataset.read_raw::<u8>().map_err(damaged)?;
        attributes.insert(key.clone(), utf8(bytes, path, part)?);
    }
    Ok(attributes)
}

fn utf8(bytes: Vec<u8>, path: &Path, part: impl FnOnce() -> String) -> Result<String, Error> {
    String::from_utf8(bytes).map_err(|error| broken(path, part(), error.to_string()))
}

fn read_tables(file: &File, path: &Path) -> Result<Vec<Table>, Error> {
    let part = || "its list of tables".to_owned();
    let tables = file.group(schema::TABLES_GROUP).map_err(|error| h5::damaged(path, part, &error))?;
    let names = h5::members(&tables).map_err(|error| h5::damaged(path, part, &error))?;
    names.iter().map(|name| read_table(&tables, name, path)).collect()
}

fn read_table(tables: &Group, name: &str, path: &Path) -> Result<Table, Error> {
    let part = || format!("table \"{name}\"");
    let damaged = |error: hdf5::Error| h5::damaged(path, part, &error);
    let group = tables.group(name).map_err(damaged)?;
    let rows =
        group.attr(schema::ROWS_ATTRIBUTE).and_then(|attribute| attribute.read_scalar::<u64>()).map_err(damaged)?
            as usize;
    let names = h5::members(&group).map_err(damaged)?;
    let columns = names.iter().map(|column| read_column(&group, name, column, rows, path));
    Ok(Table { name: name.to_owned(), rows, columns: columns.collect::<Result<_, _>>()? })
}

fn read_column(group: &Group, table: &str, name: &str, rows: usize, path: &Path) -> Result<Column, Error> {
    let part = || format!("table \"{table}\", column \"{name}\"");
    let damaged = |error: hdf5::Error| h5::damaged(path, part, &error);
    let dataset = group.dataset(name).map_err(damaged)?;
    let shape = dataset.shape();
    let &[found, width] = shape.as_slice() else {
        return Err(broken(path, part(), format!("its shape is {shape:?}, not rows by values")));
    };
    if found != rows {
        return Err(broken(path, part(), format!("it has {found} rows, its table {rows}")));
    }
    if width == 0 {
        return Err(broken(path, part(), "its rows have no values".to_owned()));
    }
    refuse_too_large(&dataset, path, part)?;
    let Some(kind) = h5::kind(&dataset).map_err(damaged)? else {
        return Err(broken(path, part(), "its values are of an unknown type".to_owned()));
    };
    let values = read_values(&dataset, kind).map_err(damaged)?;
    Ok(Column { name: name.to_owned(), width, values })
}

/// Nothing is allocated on the word of a damaged file alone.
fn refuse_too_large(dataset: &Dataset, path: &Path, part: impl FnOnce() -> String) -> Result<(), Error> {
    let bytes = fs::metadata(path).map_or(0, |metadata| metadata.len());
    h5::too_large(dataset, bytes).map_or(Ok(()), |reason| Err(broken(path, part(), reason)))
}

fn read_values(dataset: &Dataset, kind: Kind) -> hdf5::Result<Values> {
    Ok(match kind {
        Kind::F64 => Values::F64(dataset.read_raw()?),
        Kind::I64 => Values::I64(dataset.read_raw()?),
        Kind::U64 => Values::U64(dataset.read_raw()?),
        Kind::U8 => Values::U8(dataset.read_raw()?),
    })
}

fn damaged_attributes(path: &Path, error: &hdf5::Error) -> Error {
    h5::damaged(path, || "its attributes".to_owned(), error)
}

fn broken(path: &Path, part: String, reason: String) -> Error {
    Error::Damaged { path: path.to_owned(), part, reason }
}
