//! One description of a row's fields serves messages, checkpoints and digests alike: a record shows its fields, in one
//! order, to a visitor that reads or writes them.

use scree_io::column::{Column, Table, Values};
use scree_partition::parcel::{ParcelError, Reader, Writer};

/// Sees the fields of a record one by one and may change them.
pub trait Visitor {
    /// A field of as many numbers as there are `values`.
    fn f64s(&mut self, name: &'static str, values: &mut [f64]);
    /// A field of one whole number from 0 on.
    fn u64(&mut self, name: &'static str, value: &mut u64);
    /// A field of one whole number with a sign.
    fn i64(&mut self, name: &'static str, value: &mut i64);
    /// A field of one byte: a code, a flag.
    fn u8(&mut self, name: &'static str, value: &mut u8);
    /// What tables of former programs lack: of those it stays as it is.
    fn later_f64s(&mut self, name: &'static str, values: &mut [f64]) {
        self.f64s(name, values);
    }
}

/// A row of named fields. The same fields in the same order for every row of a kind.
pub trait Record {
    /// Every field once, in the order of the columns.
    fn visit(&mut self, visitor: &mut dyn Visitor);
}

/// Writes records into a parcel.
pub struct ToParcel<'a>(pub &'a mut Writer);

impl Visitor for ToParcel<'_> {
    fn f64s(&mut self, _: &'static str, values: &mut [f64]) {
        for value in values {
            self.0.f64(*value);
        }
    }
    fn u64(&mut self, _: &'static str, value: &mut u64) {
        self.0.u64(*value);
    }
    fn i64(&mut self, _: &'static str, value: &mut i64) {
        self.0.i64(*value);
    }
    fn u8(&mut self, _: &'static str, value: &mut u8) {
        self.0.u8(*value);
    }
}

/// Reads records from a parcel; the first failure is kept.
pub struct FromParcel<'a, 'b> {
    /// Stands at the first field of the next record.
    pub reader: &'a mut Reader<'b>,
    /// None while all could be read; what could not is 0.
    pub failure: Option<ParcelError>,
}

impl FromParcel<'_, '_> {
    fn take<T: Default>(&mut self, value: Result<T, ParcelError>) -> T {
        value.unwrap_or_else(|error| {
            self.failure.get_or_insert(error);
            T::default()
        })
    }
}

impl Visitor for FromParcel<'_, '_> {
    fn f64s(&mut self, _: &'static str, values: &mut [f64]) {
        for value in values {
            let read = self.reader.f64();
            *value = self.take(read);
        }
    }
    fn u64(&mut self, _: &'static str, value: &mut u64) {
        let read = self.reader.u64();
        *value = self.take(read);
    }
    fn i64(&mut self, _: &'static str, value: &mut i64) {
        let read = self.reader.i64();
        *value = self.take(read);
    }
    fn u8(&mut self, _: &'static str, value: &mut u8) {
        let read = self.reader.u8();
        *value = self.take(read);
    }
}

/// Appends records to the columns of a table; the first record names the columns.
#[derive(Default)]
struct ToColumns {
    columns: Vec<Column>,
    next: usize,
}

impl ToColumns {
    fn column(&mut self, name: &'static str, width: usize, empty: Values) -> &mut Values {
        if self.next == self.columns.len() {
            self.columns.push(Column { name: name.to_string(), width, values: empty });
        }
        let column = &mut self.columns[self.next];
        debug_assert_eq!(column.name, name, "records of one kind show the same fields");
        self.next += 1;
        &mut column.values
    }
}

impl Visitor for ToColumns {
    fn f64s(&mut self, name: &'static str, values: &mut [f64]) {
        if let Values::F64(column) = self.column(name, values.len(), Values::F64(Vec::new())) {
            column.extend_from_slice(values);
        }
    }
    fn u64(&mut self, name: &'static str, value: &mut u64) {
        if let Values::U64(column) = self.column(name, 1, Values::U64(Vec::new())) {
            column.push(*value);
        }
    }
    fn i64(&mut self, name: &'static str, value: &mut i64) {
        if let Values::I64(column) = self.column(name, 1, Values::I64(Vec::new())) {
            column.push(*value);
        }
    }
    fn u8(&mut self, name: &'static str, value: &mut u8) {
        if let Values::U8(column) = self.column(name, 1, Values::U8(Vec::new())) {
            column.push(*value);
        }
    }
}

/// Rows as a table. A table without rows still has its columns, named by `blank`.
pub fn to_table<R: Record>(name: &str, rows: &mut [R], blank: &mut R) -> Table {
    let mut to = ToColumns::default();
    blank.visit(&mut to);
    for column in &mut to.columns {
        match &mut column.values {
            Values::F64(values) => values.clear(),
            Values::U64(values) => values.clear(),
            Values::I64(values) => values.clear(),
            Values::U8(values) => values.clear(),
        }
    }
    let count = rows.len();
    for row in rows {
        to.next = 0;
        row.visit(&mut to);
    }
    Table { name: name.to_string(), rows: count, columns: to.columns }
}

/// Reads one row of a table; a column that is missing or of another shape is kept as the failure.
struct FromColumns<'a> {
    table: &'a Table,
    row: usize,
    failure: Option<String>,
}

impl<'a> FromColumns<'a> {
    fn values(&mut self, name: &str, width: usize) -> Option<&'a Values> {
        let found = self.table.columns.iter().find(|column| column.name == name && column.width == width);
        if found.is_none() {
            let message = format!("table `{}` has no column `{name}` of width {width}", self.table.name);
            self.failure.get_or_insert(message);
        }
        found.map(|column| &column.values)
    }
    fn other_type(&mut self, name: &str) {
        let message = format!("column `{name}` of table `{}` has another type", self.table.name);
        self.failure.get_or_insert(message);
    }
}

impl Visitor for FromColumns<'_> {
    fn f64s(&mut self, name: &'static str, values: &mut [f64]) {
        let width = values.len();
        match self.values(name, width) {
            Some(Values::F64(column)) => values.copy_from_slice(&column[self.row * width..(self.row + 1) * width]),
            Some(_) => self.other_type(name),
            None => {}
        }
    }
    fn u64(&mut self, name: &'static str, value: &mut u64) {
        match self.values(name, 1) {
            Some(Values::U64(column)) => *value = column[self.row],
            Some(_) => self.other_type(name),
            None => {}
        }
    }
    fn i64(&mut self, name: &'static str, value: &mut i64) {
        match self.values(name, 1) {
            Some(Values::I64(column)) => *value = column[self.row],
            Some(_) => self.other_type(name),
            None => {}
        }
    }
    fn u8(&mut self, name: &'static str, value: &mut u8) {
        match self.values(name, 1) {
            Some(Values::U8(column)) => *value = column[self.row],
            Some(_) => self.other_type(name),
            None => {}
        }
    }
    fn later_f64s(&mut self, name: &'static str, values: &mut [f64]) {
        if self.table.columns.iter().any(|column| column.name == name) {
            self.f64s(name, values);
        }
    }
}

/// Refuses a table whose columns are not as long as it says, so that as many rows as it says can be there.
pub fn refuse_torn(table: &Table) -> Result<(), String> {
    let whole = |column: &Column| table.rows.checked_mul(column.width) == Some(column.values.len());
    if let Some(column) = table.columns.iter().find(|column| !whole(column)) {
        return Err(format!(
            "column `{}` of table `{}` has {} values, and {} rows of {} are wanted",
            column.name,
            table.name,
            column.values.len(),
            table.rows,
            column.width
        ));
    }
    match table.columns.is_empty() && table.rows > 0 {
        true => Err(format!("table `{}` has {} rows and no column", table.name, table.rows)),
        false => Ok(()),
    }
}

/// Rows of a table, each starting from `blank`.
pub fn from_table<R: Record + Clone>(table: &Table, blank: &R) -> Result<Vec<R>, String> {
    refuse_torn(table)?;
    let mut rows = Vec::with_capacity(table.rows);
    for row in 0..table.rows {
        let mut record = blank.clone();
        let mut from = FromColumns { table, row, failure: None };
        record.visit(&mut from);
        if let Some(failure) = from.failure {
            return Err(failure);
        }
        rows.push(record);
    }
    Ok(rows)
}

/// A kind of row that can be put into a parcel whole.
pub trait Cargo: Record + Clone {
    /// What a row of a parcel is read into.
    fn blank() -> Self;
    /// Fields beside those of the record.
    fn pack_rest(&mut self, _: &mut Writer) {}
    /// Reads what `pack_rest` wrote, in its order; the error is that of a parcel which has less.
    fn unpack_rest(&mut self, _: &mut Reader) -> Result<(), ParcelError> {
        Ok(())
    }
}
