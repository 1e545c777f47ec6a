//! A state as plain columns: what is saved, what is read back, and what a digest is taken of.

use std::collections::BTreeMap;
use std::fmt;

use crate::error::Error;

/// The values of one column, row after row.
///
/// Equality is that of the numbers: a NaN differs from itself, and -0.0 equals 0.0. Compare digests to compare bits.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Floating point numbers of 64 bits: quantities.
    F64(Vec<f64>),
    /// Whole numbers of 64 bits with a sign.
    I64(Vec<i64>),
    /// Whole numbers of 64 bits from 0 on: counts, ids.
    U64(Vec<u64>),
    /// Bytes: codes, flags.
    U8(Vec<u8>),
}

/// The type of a column's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of [`Values::F64`], 8 bytes each; "f64" in messages.
    F64,
    /// Of [`Values::I64`], 8 bytes each; "i64" in messages.
    I64,
    /// Of [`Values::U64`], 8 bytes each; "u64" in messages.
    U64,
    /// Of [`Values::U8`], 1 byte each; "u8" in messages.
    U8,
}

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Kind::F64 => "f64",
            Kind::I64 => "i64",
            Kind::U64 => "u64",
            Kind::U8 => "u8",
        })
    }
}

impl Values {
    /// Number of values: rows times width.
    pub fn len(&self) -> usize {
        match self {
            Values::F64(values) => values.len(),
            Values::I64(values) => values.len(),
            Values::U64(values) => values.len(),
            Values::U8(values) => values.len(),
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The type of the values.
    pub fn kind(&self) -> Kind {
        match self {
            Values::F64(_) => Kind::F64,
            Values::I64(_) => Kind::I64,
            Values::U64(_) => Kind::U64,
            Values::U8(_) => Kind::U8,
        }
    }
}

/// A named column of `rows * width` values; row `i` is `values[i * width..(i + 1) * width]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Once in a table: of 1 to 255 bytes, neither "." nor "..", without a slash or NUL.
    pub name: String,
    /// Values per row, at least 1.
    pub width: usize,
    /// `rows * width` of the table's rows, row after row.
    pub values: Values,
}

/// Columns of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Once in a state, under the same rule as a column's.
    pub name: String,
    /// Of every column alike.
    pub rows: usize,
    /// In the order in which they were added; the order is part of the digest.
    pub columns: Vec<Column>,
}

impl Table {
    /// A table without columns.
    pub fn new(name: &str, rows: usize) -> Table {
        assert_name(name);
        Table { name: name.to_owned(), rows, columns: Vec::new() }
    }

    /// Adds a column of any kind. Panics unless it has `rows * width` values and a name not yet taken.
    pub fn with(mut self, name: &str, width: usize, values: Values) -> Table {
        let column = Column { name: name.to_owned(), width, values };
        column.assert_shape(&self.name, self.rows);
        assert!(self.columns.iter().all(|other| other.name != name), "table {}: column {name} twice", self.name);
        self.columns.push(column);
        self
    }

    /// Adds a column of `f64`; panics as [`Table::with`] does.
    pub fn with_f64(self, name: &str, width: usize, values: Vec<f64>) -> Table {
        self.with(name, width, Values::F64(values))
    }

    /// Adds a column of `i64`; panics as [`Table::with`] does.
    pub fn with_i64(self, name: &str, width: usize, values: Vec<i64>) -> Table {
        self.with(name, width, Values::I64(values))
    }

    /// Adds a column of `u64`; panics as [`Table::with`] does.
    pub fn with_u64(self, name: &str, width: usize, values: Vec<u64>) -> Table {
        self.with(name, width, Values::U64(values))
    }

    /// Adds a column of bytes; panics as [`Table::with`] does.
    pub fn with_u8(self, name: &str, width: usize, values: Vec<u8>) -> Table {
        self.with(name, width, Values::U8(values))
    }

    /// The column of that name, or [`Error::NoColumn`].
    pub fn column(&self, name: &str) -> Result<&Column, Error> {
        self.columns.iter().find(|column| column.name == name).ok_or_else(|| Error::NoColumn {
            table: self.name.clone(),
            column: name.to_owned(),
            present: join(self.columns.iter().map(|column| &column.name)),
        })
    }

    /// The `rows * width` values of a column of `f64`, or [`Error::NoColumn`], [`Error::ColumnShape`].
    pub fn f64s(&self, name: &str, width: usize) -> Result<&[f64], Error> {
        match &self.column(name)?.values {
            Values::F64(values) if self.has_width(name, width) => Ok(values),
            _ => Err(self.shape_error(name, width, Kind::F64)),
        }
    }

    /// The `rows * width` values of a column of `i64`, or [`Error::NoColumn`], [`Error::ColumnShape`].
    pub fn i64s(&self, name: &str, width: usize) -> Result<&[i64], Error> {
        match &self.column(name)?.values {
            Values::I64(values) if self.has_width(name, width) => Ok(values),
            _ => Err(self.shape_error(name, width, Kind::I64)),
        }
    }

    /// The `rows * width` values of a column of `u64`, or [`Error::NoColumn`], [`Error::ColumnShape`].
    pub fn u64s(&self, name: &str, width: usize) -> Result<&[u64], Error> {
        match &self.column(name)?.values {
            Values::U64(values) if self.has_width(name, width) => Ok(values),
            _ => Err(self.shape_error(name, width, Kind::U64)),
        }
    }

    /// The `rows * width` values of a column of bytes, or [`Error::NoColumn`], [`Error::ColumnShape`].
    pub fn u8s(&self, name: &str, width: usize) -> Result<&[u8], Error> {
        match &self.column(name)?.values {
            Values::U8(values) if self.has_width(name, width) => Ok(values),
            _ => Err(self.shape_error(name, width, Kind::U8)),
        }
    }

    /// Panics unless every column has its shape and every name is usable and taken once.
    pub(crate) fn assert_shape(&self) {
        assert_name(&self.name);
        for (index, column) in self.columns.iter().enumerate() {
            column.assert_shape(&self.name, self.rows);
            let taken = self.columns[..index].iter().any(|other| other.name == column.name);
            assert!(!taken, "table {}: column {} twice", self.name, column.name);
        }
    }

    fn has_width(&self, name: &str, width: usize) -> bool {
        self.column(name).is_ok_and(|column| column.width == width)
    }

    fn shape_error(&self, name: &str, width: usize, kind: Kind) -> Error {
        match self.column(name) {
            Err(absent) => absent,
            Ok(column) => Error::ColumnShape {
                table: self.name.clone(),
                column: name.to_owned(),
                found: format!("{} x {}", column.width, column.values.kind()),
                expected: format!("{width} x {kind}"),
            },
        }
    }
}

impl Column {
    /// Panics unless the column has `rows * width` values and a usable name. `owner` names the table in the message.
    pub(crate) fn assert_shape(&self, owner: &str, rows: usize) {
        assert_name(&self.name);
        assert!(self.width > 0, "{owner}: column {} has no width", self.name);
        assert_eq!(
            self.values.len(),
            rows * self.width,
            "{owner}: column {} must have {rows} rows of {} values",
            self.name,
            self.width
        );
    }
}

/// All that a run needs to go on, as text and tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Those whose key begins with [`STATE_PREFIX`] are part of the state and of its digest; the rest (program version,
    /// wall time) only tell where the file comes from.
    pub attributes: BTreeMap<String, String>,
    /// In the caller's order, which is part of the digest.
    pub tables: Vec<Table>,
}

/// The mark of the attributes that enter the digest.
pub const STATE_PREFIX: &str = "state.";

impl State {
    /// The table of that name, or [`Error::NoTable`].
    pub fn table(&self, name: &str) -> Result<&Table, Error> {
        self.tables.iter().find(|table| table.name == name).ok_or_else(|| Error::NoTable {
            table: name.to_owned(),
            present: join(self.tables.iter().map(|table| &table.name)),
        })
    }

    /// The attribute of that name, or [`Error::NoAttribute`].
    pub fn attribute(&self, name: &str) -> Result<&str, Error> {
        self.attributes
            .get(name)
            .map(String::as_str)
            .ok_or_else(|| Error::NoAttribute { attribute: name.to_owned(), present: join(self.attributes.keys()) })
    }
}

/// A name that HDF5 can link and a message can quote.
pub(crate) fn assert_name(name: &str) {
    let usable = !name.is_empty() && name != "." && name != ".." && name.len() <= 255 && !name.contains(['/', '\0']);
    assert!(usable, "{name:?} cannot be the name of a table, column or attribute");
}

fn join<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
