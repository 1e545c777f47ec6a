//! 64 hex digits that stand for a state: two runs agree to the bit exactly if their digests are equal.

use std::collections::BTreeMap;

use sha2::{Digest, Sha256};

use crate::column::{Kind, STATE_PREFIX, State, Table, Values};

/// SHA-256 over a canonical encoding of the state, as 64 lower-case hex digits.
///
/// In the given order: the attributes whose key begins with `state.`, then every table's name and row count, and every
/// column's name, width, type and the SHA-256 of its little-endian data. So columns may grow side by side: the digest is
/// the same in however many pieces their rows came. All lengths are written ahead of what they measure, so no two states
/// share an encoding. Bits count: -0.0 differs from 0.0, and one NaN from another.
pub fn digest(state: &State) -> String {
    let tables: Vec<TableDigest> = state.tables.iter().map(TableDigest::of_whole).collect();
    digest_of(&state.attributes, tables)
}

/// The digest of a state from those of its tables.
pub(crate) fn digest_of(attributes: &BTreeMap<String, String>, tables: Vec<TableDigest>) -> String {
    let mut hash = Sha256::new();
    hash.update(b"scree state 2");
    let attributes = attributes.iter().filter(|(key, _)| key.starts_with(STATE_PREFIX));
    put_count(&mut hash, attributes.clone().count());
    for (key, value) in attributes {
        put_text(&mut hash, key);
        put_text(&mut hash, value);
    }
    put_count(&mut hash, tables.len());
    for table in tables {
        put_text(&mut hash, &table.name);
        put_count(&mut hash, table.rows);
        put_count(&mut hash, table.columns.len());
        for column in table.columns {
            put_text(&mut hash, &column.name);
            put_count(&mut hash, column.width);
            put_text(&mut hash, &column.kind.to_string());
            hash.update(column.hash.finalize());
        }
    }
    hex(hash)
}

/// SHA-256 over a digest and all attributes, so that damage to an attribute outside the state shows as well.
pub(crate) fn seal(attributes: &BTreeMap<String, String>, digest: &str) -> String {
    let mut hash = Sha256::new();
    hash.update(b"scree seal 1");
    put_text(&mut hash, digest);
    put_count(&mut hash, attributes.len());
    for (key, value) in attributes {
        put_text(&mut hash, key);
        put_text(&mut hash, value);
    }
    hex(hash)
}

/// The part of a digest that one table has, taken while its rows come.
pub(crate) struct TableDigest {
    pub(crate) name: String,
    /// Rows of the whole table.
    pub(crate) rows: usize,
    columns: Vec<ColumnDigest>,
}

struct ColumnDigest {
    name: String,
    width: usize,
    kind: Kind,
    hash: Sha256,
}

impl TableDigest {
    /// Of a table with the columns of `like`, whose `rows` rows are all to come.
    pub(crate) fn like(like: &Table, rows: usize) -> TableDigest {
        let columns = like.columns.iter().map(|column| ColumnDigest {
            name: column.name.clone(),
            width: column.width,
            kind: column.values.kind(),
            hash: Sha256::new(),
        });
        TableDigest { name: like.name.clone(), rows, columns: columns.collect() }
    }

    fn of_whole(table: &Table) -> TableDigest {
        let mut digest = TableDigest::like(table, table.rows);
        digest.take(table);
        digest
    }

    /// Takes the next rows. Panics unless they have the columns of the table.
    pub(crate) fn take(&mut self, piece: &Table) {
        assert_eq!(piece.columns.len(), self.columns.len(), "table {}: columns of a piece", self.name);
        for (ours, column) in self.columns.iter_mut().zip(&piece.columns) {
            assert_eq!(
                (&ours.name, ours.width, ours.kind),
                (&column.name, column.width, column.values.kind()),
                "table {}: a column of a piece",
                self.name
            );
            put_values(&mut ours.hash, &column.values);
        }
    }
}

fn put_count(hash: &mut Sha256, count: usize) {
    hash.update((count as u64).to_le_bytes());
}

fn put_text(hash: &mut Sha256, text: &str) {
    put_count(hash, text.len());
    hash.update(text.as_bytes());
}

fn put_values(hash: &mut Sha256, values: &Values) {
    match values {
        Values::F64(values) => put_words(hash, values, |value| value.to_le_bytes()),
        Values::I64(values) => put_words(hash, values, |value| value.to_le_bytes()),
        Values::U64(values) => put_words(hash, values, |value| value.to_le_bytes()),
        Values::U8(values) => hash.update(values),
    }
}

/// Hands the hash a buffer at a time: value by value it would spend its time in calls.
fn put_words<T: Copy>(hash: &mut Sha256, values: &[T], bytes_of: impl Fn(T) -> [u8; 8]) {
    let mut buffer = [0_u8; 8 * 1024];
    for values in values.chunks(1024) {
        for (bytes, value) in buffer.chunks_exact_mut(8).zip(values) {
            bytes.copy_from_slice(&bytes_of(*value));
        }
        hash.update(&buffer[..8 * values.len()]);
    }
}

fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
