//! 64 hex digits that stand for a state: two runs agree to the bit exactly if their digests are equal.

use sha2::{Digest, Sha256};

use crate::column::{STATE_PREFIX, State, Values};

/// SHA-256 over a canonical encoding of the state, as 64 lower-case hex digits.
///
/// In the given order: every table's name and row count, every column's name, width, type and little-endian data, and
/// the attributes whose key begins with `state.`. All lengths are written ahead of what they measure, so no two states
/// share an encoding. Bits count: -0.0 differs from 0.0, and one NaN from another.
pub fn digest(state: &State) -> String {
    let mut hash = Sha256::new();
    hash.update(b"scree state 1");
    let attributes = state.attributes.iter().filter(|(key, _)| key.starts_with(STATE_PREFIX));
    put_count(&mut hash, attributes.clone().count());
    for (key, value) in attributes {
        put_text(&mut hash, key);
        put_text(&mut hash, value);
    }
    put_count(&mut hash, state.tables.len());
    for table in &state.tables {
        put_text(&mut hash, &table.name);
        put_count(&mut hash, table.rows);
        put_count(&mut hash, table.columns.len());
        for column in &table.columns {
            put_text(&mut hash, &column.name);
            put_count(&mut hash, column.width);
            put_text(&mut hash, &column.values.kind().to_string());
            put_values(&mut hash, &column.values);
        }
    }
    hex(hash)
}

/// SHA-256 over a digest and all attributes, so that damage to an attribute outside the state shows as well.
pub(crate) fn seal(state: &State, digest: &str) -> String {
    let mut hash = Sha256::new();
    hash.update(b"scree seal 1");
    put_text(&mut hash, digest);
    put_count(&mut hash, state.attributes.len());
    for (key, value) in &state.attributes {
        put_text(&mut hash, key);
        put_text(&mut hash, value);
    }
    hex(hash)
}

fn put_count(hash: &mut Sha256, count: usize) {
    hash.update((count as u64).to_le_bytes());
}

fn put_text(hash: &mut Sha256, text: &str) {
    put_count(hash, text.len());
    hash.update(text.as_bytes());
}

fn put_values(hash: &mut Sha256, values: &Values) {
    put_count(hash, values.len());
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
