//! A state that is written piece by piece is the state that is written at once.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use scree_io::store::{self, Writer};
use scree_io::{Column, Error, State, Table, Values, digest};

use crate::sample;

/// Writes a state in pieces of up to `rows` rows, of all tables in turn as they grow together.
pub fn write(path: &Path, state: &State, mut rows: impl FnMut(usize) -> usize) -> Result<(), Error> {
    let mut writer = Writer::create(path, &state.attributes)?;
    for table in &state.tables {
        writer.begin(&part(table, 0, 0), table.rows)?;
    }
    let mut filled = vec![0; state.tables.len()];
    while filled.iter().zip(&state.tables).any(|(filled, table)| *filled < table.rows) {
        for (number, table) in state.tables.iter().enumerate() {
            let end = (filled[number] + rows(number)).min(table.rows);
            writer.append(&part(table, filled[number], end))?;
            filled[number] = end;
        }
    }
    writer.finish()
}

/// Rows `start..end` of a table.
fn part(table: &Table, start: usize, end: usize) -> Table {
    let columns = table.columns.iter().map(|column| {
        let range = start * column.width..end * column.width;
        let values = match &column.values {
            Values::F64(values) => Values::F64(values[range].to_vec()),
            Values::I64(values) => Values::I64(values[range].to_vec()),
            Values::U64(values) => Values::U64(values[range].to_vec()),
            Values::U8(values) => Values::U8(values[range].to_vec()),
        };
        Column { values, ..column.clone() }
    });
    Table { name: table.name.clone(), rows: end - start, columns: columns.collect() }
}

/// The digest that a file bears.
fn stored_digest(path: &Path) -> String {
    let file = hdf5::File::open(path).unwrap();
    let text = file.attr("digest").unwrap().read_scalar::<hdf5::types::FixedUnicode<64>>().unwrap();
    text.as_str().to_owned()
}

#[test]
fn pieces_make_the_same_state() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    // The long table has 70,000 rows: pieces shorter and longer than chunks, that do and do not end with one.
    for rows in [70_001, 16_384, 16_000, 30_000, 999] {
        write(&path, &sample::state(), |_| rows).unwrap();
        assert_eq!(store::read(&path).unwrap(), sample::state());
        assert_eq!(stored_digest(&path), digest(&sample::state()));
    }
    write(&path, &State::default(), |_| 1).unwrap();
    assert_eq!(store::read(&path).unwrap(), State::default());
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn pieces_cost_no_space() {
    let (_guard, folder) = sample::folder();
    let length = |name: &str| fs::metadata(folder.join(name)).unwrap().len();
    store::write(&folder.join("whole"), &sample::state()).unwrap();
    write(&folder.join("pieces"), &sample::state(), |_| 999).unwrap();
    let (whole, pieces) = (length("whole"), length("pieces"));
    assert!(pieces < whole + whole / 50, "{pieces} bytes in pieces, {whole} at once");
}

/// Bytes of a file that holds one column.
fn bytes_of(values: Values) -> u64 {
    let (_guard, folder) = sample::folder();
    let table = Table::new("t", values.len()).with("c", 1, values);
    store::write(&folder.join("f"), &State { tables: vec![table], ..State::default() }).unwrap();
    fs::metadata(folder.join("f")).unwrap().len()
}

#[test]
fn what_repeats_is_compressed_and_what_was_computed_is_not() {
    let rows = 100_000;
    let computed: Vec<f64> = (0..rows).map(|row| (row as f64).sqrt()).collect();
    assert!(bytes_of(Values::F64(computed)) > 8 * rows);
    assert!(bytes_of(Values::F64(vec![0.1; rows as usize])) < rows);
    assert!(bytes_of(Values::U64((0..rows).collect())) < 4 * rows);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn however_a_state_is_cut(lengths in prop::collection::vec((0_usize..7, 0_usize..7), 1..12)) {
        let (_guard, folder) = sample::folder();
        let path = folder.join("state.h5");
        let whole = sample::many_rows(30);
        let mut piece = 0;
        write(&path, &whole, |table| {
            piece += 1;
            let (grains, contacts) = lengths[piece / 2 % lengths.len()];
            // Some piece must bring it to an end.
            if piece > 100 { 30 } else if table == 0 { grains } else { contacts }
        }).unwrap();
        prop_assert_eq!(store::read(&path).unwrap(), whole.clone());
        prop_assert_eq!(stored_digest(&path), digest(&whole));
    }
}

#[test]
fn an_unfinished_writer_leaves_nothing_new() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    let begun = |path: &Path| {
        let mut writer = Writer::create(path, &sample::state().attributes).unwrap();
        sample::state().tables.iter().for_each(|table| writer.begin(table, table.rows + 1).unwrap());
        writer
    };
    drop(begun(&path));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    store::write(&path, &sample::small_state()).unwrap();
    drop(begun(&path));
    assert_eq!(store::read(&path).unwrap(), sample::small_state());
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

/// They used to share a name while they wrote: each spoilt what the other had written.
#[test]
fn two_that_write_the_same_file_at_once_do_not_meet() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    let (one, other) = (sample::many_rows(20_000), sample::state());
    let [mut first, mut second] = [&one, &other].map(|state| Writer::create(&path, &state.attributes).unwrap());
    one.tables.iter().for_each(|table| first.begin(table, table.rows).unwrap());
    other.tables.iter().for_each(|table| second.begin(table, table.rows).unwrap());
    first.finish().unwrap();
    assert_eq!(store::read(&path).unwrap(), one);
    second.finish().unwrap();
    assert_eq!(store::read(&path).unwrap(), other);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn nothing_is_ever_beside_a_file_that_is_made_elsewhere() {
    let (_guard, folder) = sample::folder();
    let (dir, scratch) = (folder.join("checkpoints"), folder.join("scratch"));
    [&dir, &scratch].into_iter().for_each(|folder| fs::create_dir(folder).unwrap());
    let count = |folder: &Path| fs::read_dir(folder).unwrap().count();
    let path = dir.join("state.h5");
    let mut writer = Writer::create_in(&scratch, &path, &sample::state().attributes).unwrap();
    sample::state().tables.iter().for_each(|table| writer.begin(table, table.rows).unwrap());
    assert_eq!([count(&dir), count(&scratch)], [0, 1]);
    writer.finish().unwrap();
    assert_eq!([count(&dir), count(&scratch)], [1, 0]);
    assert_eq!(store::read(&path).unwrap(), sample::state());
    store::write_in(&scratch, &path, &sample::small_state()).unwrap();
    assert_eq!([count(&dir), count(&scratch)], [1, 0]);
    assert_eq!(store::read(&path).unwrap(), sample::small_state());
    let error = store::write_in(&folder.join("absent"), &path, &sample::state()).unwrap_err().to_string();
    assert!(error.contains("absent/state.h5.") && error.contains("check the path"), "{error}");
}

/// A table `grains` of which two of three rows were written.
fn two_of_three(folder: &Path) -> (Writer, Table) {
    let grains = sample::state().tables.swap_remove(0);
    let mut writer = Writer::create(&folder.join("state.h5"), &sample::state().attributes).unwrap();
    writer.begin(&part(&grains, 0, 2), 3).unwrap();
    (writer, grains)
}

#[test]
#[should_panic(expected = "table grains: rows written of those in all")]
fn a_missing_row_is_a_bug() {
    let (_guard, folder) = sample::folder();
    let _ = two_of_three(&folder).0.finish();
}

#[test]
#[should_panic(expected = "table grains: more than 3 rows")]
fn a_row_too_many_is_a_bug() {
    let (_guard, folder) = sample::folder();
    let (mut writer, grains) = two_of_three(&folder);
    let _ = writer.append(&part(&grains, 0, 2));
}

#[test]
#[should_panic(expected = "table grains: a column of a piece")]
fn a_piece_with_another_column_is_a_bug() {
    let (_guard, folder) = sample::folder();
    let (mut writer, grains) = two_of_three(&folder);
    let mut piece = part(&grains, 2, 3);
    piece.columns.swap(0, 1);
    let _ = writer.append(&piece);
}
