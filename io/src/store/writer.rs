//! From a state to a file, in one go or piece by piece.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5::{Dataset, File, Group};

use super::parts;
use crate::column::{State, Table, assert_name};
use crate::digest::{TableDigest, digest_of, seal};
use crate::error::Error;
use crate::h5;
use crate::schema;
use crate::system::Aside;

/// Writes the state to `path` and returns once it is safely on disk. A file already there is replaced as a whole, or,
/// on an error, left as it was. Equal states give equal bytes.
///
/// Panics if a column's length is not rows times width, if a name is empty, repeated or has a `/`, or if an attribute
/// has one of the names in [`schema`](crate::schema).
pub fn write(path: &Path, state: &State) -> Result<(), Error> {
    write_all(Writer::create(path, &state.attributes)?, state)
}

/// Writes the state as [`write`] does, with nothing ever beside `path`: the file is made in the folder `scratch`, which must be on the
/// same file system.
pub fn write_in(scratch: &Path, path: &Path, state: &State) -> Result<(), Error> {
    write_all(Writer::create_in(scratch, path, &state.attributes)?, state)
}

fn write_all(mut writer: Writer, state: &State) -> Result<(), Error> {
    for table in &state.tables {
        writer.begin(table, table.rows)?;
    }
    writer.finish()
}

/// A state on its way to a file, for states of which only a piece is at hand at a time.
///
/// ```text
/// let mut writer = Writer::create(path, &attributes)?;
/// writer.begin(&first_rows, rows_in_all)?;      // the tables, in their order
/// writer.append(&next_rows)?;                   // rows of any of them, in theirs
/// writer.finish()?;
/// ```
///
/// What is read back, and its digest, are the same in whatever pieces rows came. The file has another name until it is
/// finished; a writer that is dropped before, after an error say, leaves nothing, and an older file as it was.
pub struct Writer {
    tables: Vec<Growing>,
    group: Group,
    file: File,
    attributes: BTreeMap<String, String>,
    /// Last, so that the file is closed before it is removed.
    aside: Aside,
}

/// A table some of whose rows may be to come.
struct Growing {
    digest: TableDigest,
    /// Rows that have come.
    filled: usize,
    group: Group,
    /// Of its columns, from the first row on, which shows whether they are worth compressing; kept open until the last row
    /// has come, since what is not yet a chunk is in memory.
    datasets: Vec<Dataset>,
}

impl Writer {
    /// A file for a state with these attributes, and no table yet, made beside its name. Panics as [`write`] does.
    pub fn create(path: &Path, attributes: &BTreeMap<String, String>) -> Result<Writer, Error> {
        Writer::begun(Aside::of(path)?, attributes)
    }

    /// The same, made in the folder `scratch`, which must be on the file system of `path`.
    pub fn create_in(scratch: &Path, path: &Path, attributes: &BTreeMap<String, String>) -> Result<Writer, Error> {
        Writer::begun(Aside::within(scratch, path)?, attributes)
    }

    fn begun(aside: Aside, attributes: &BTreeMap<String, String>) -> Result<Writer, Error> {
        attributes.keys().for_each(|key| assert_name(key));
        for name in schema::RESERVED_ATTRIBUTES {
            assert!(!attributes.contains_key(name), "the attribute {name} is the file's own");
        }
        let file = h5::create(aside.partial())?;
        let group = write_head(&file, attributes).map_err(|error| h5::explain("write", aside.partial(), &error))?;
        Ok(Writer { tables: Vec::new(), group, file, attributes: attributes.clone(), aside })
    }

    /// Begins the next table, of `rows` rows in all, of which `first` has the first or none; it also names the columns.
    /// Panics as [`write`] does, and if `first` has more rows than that.
    pub fn begin(&mut self, first: &Table, rows: usize) -> Result<(), Error> {
        first.assert_shape();
        assert!(self.tables.iter().all(|table| table.digest.name != first.name), "table {} twice", first.name);
        let table = Growing::create(&self.group, first, rows).map_err(|error| self.explain(&error))?;
        self.tables.push(table);
        self.append(first)
    }

    /// Writes the next rows of a table that was begun. Panics unless they have its columns, and if there are more of them
    /// than are to come.
    pub fn append(&mut self, piece: &Table) -> Result<(), Error> {
        let table = self.tables.iter_mut().find(|table| table.digest.name == piece.name);
        let table = table.unwrap_or_else(|| panic!("table {} was not begun", piece.name));
        table.take(piece).map_err(|error| self.explain(&error))
    }

    /// Seals the file and gives it its name; returns once it is safely on disk. Panics if rows of a table are missing.
    pub fn finish(self) -> Result<(), Error> {
        let Writer { tables, group, file, attributes, aside } = self;
        for table in &tables {
            let (name, rows) = (&table.digest.name, table.digest.rows);
            assert_eq!(table.filled, rows, "table {name}: rows written of those in all");
        }
        let digest = digest_of(&attributes, tables.into_iter().map(|table| table.digest).collect());
        h5::write_text(&file, schema::SEAL_ATTRIBUTE, &seal(&attributes, &digest))
            .and_then(|()| h5::write_text(&file, schema::DIGEST_ATTRIBUTE, &digest))
            .map_err(|error| h5::explain("write", aside.partial(), &error))?;
        drop(group);
        h5::close(file, aside.partial())?;
        aside.name()
    }

    fn explain(&self, error: &hdf5::Error) -> Error {
        h5::explain("write", self.aside.partial(), error)
    }
}

impl Growing {
    fn create(tables: &Group, first: &Table, rows: usize) -> hdf5::Result<Growing> {
        let group = h5::create_group(tables, &first.name)?;
        group.new_attr::<u64>().create(schema::ROWS_ATTRIBUTE)?.write_scalar(&(rows as u64))?;
        let mut table = Growing { digest: TableDigest::like(first, rows), filled: 0, group, datasets: Vec::new() };
        if rows == 0 {
            table.create_columns(first)?;
        }
        Ok(table)
    }

    fn create_columns(&mut self, first: &Table) -> hdf5::Result<()> {
        for column in &first.columns {
            self.datasets.push(parts::create_column(&self.group, column, self.digest.rows)?);
        }
        Ok(())
    }

    fn take(&mut self, piece: &Table) -> hdf5::Result<()> {
        piece.assert_shape();
        let rows = self.digest.rows;
        assert!(self.filled + piece.rows <= rows, "table {}: more than {rows} rows", piece.name);
        self.digest.take(piece);
        if piece.rows == 0 {
            return Ok(());
        }
        if self.filled == 0 {
            self.create_columns(piece)?;
        }
        for (dataset, column) in self.datasets.iter().zip(&piece.columns) {
            parts::write_rows(dataset, self.filled, column, piece.rows)?;
        }
        self.filled += piece.rows;
        if self.filled == rows {
            // Closing would hide that the last chunks cannot be written.
            self.datasets.drain(..).try_for_each(|dataset| dataset.flush())?;
        }
        Ok(())
    }
}

/// All that comes before the tables; returns their group.
fn write_head(file: &File, attributes: &BTreeMap<String, String>) -> hdf5::Result<Group> {
    file.new_attr::<u64>().create(schema::VERSION_ATTRIBUTE)?.write_scalar(&schema::SCHEMA_VERSION)?;
    let texts = h5::create_group(file, schema::TEXT_GROUP)?;
    for (key, text) in attributes {
        parts::write_text(file, &texts, key, text)?;
    }
    h5::create_group(file, schema::TABLES_GROUP)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_device_without_space_gives_its_reason() {
        if !Path::new("/dev/full").exists() {
            println!("skipped: there is no /dev/full");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let (path, partial) = (folder.path().join("state.h5"), folder.path().join("full"));
        let state =
            State { tables: vec![Table::new("t", 50_000).with_u64("c", 1, (0..50_000).collect())], ..State::default() };
        write(&path, &State::default()).unwrap();
        std::os::unix::fs::symlink("/dev/full", &partial).unwrap();
        let aside = Aside::at(&path, &partial);
        let written = Writer::begun(aside, &state.attributes).and_then(|writer| write_all(writer, &state));
        let error = written.unwrap_err().to_string();
        assert!(error.contains("full: No space left on device") && error.contains("free some space"), "{error}");
        assert_eq!(super::super::read(&path).unwrap(), State::default());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
