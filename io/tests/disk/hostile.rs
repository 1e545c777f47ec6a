//! Files that claim what they do not hold: refused before anything is allocated for it.

use std::path::Path;

use hdf5::{File, Group};
use scree_io::{Error, State, Table, store};

use crate::sample;

/// Rows that no machine holds.
const ROWS: usize = 1_000_000_000_000_000;

/// A good file with its tables changed.
fn changed(path: &Path, change: impl FnOnce(&Group)) -> Error {
    store::write(path, &sample::small_state()).unwrap();
    let file = File::open_rw(path).unwrap();
    change(&file.group("tables/grains").unwrap());
    file.close().unwrap();
    store::read(path).expect_err("it is no checkpoint any more")
}

/// A column with as many rows as its table claims, of which none was ever written.
fn claim(grains: &Group, rows: usize, width: usize) {
    grains.unlink("position").unwrap();
    grains.new_dataset::<f64>().chunk((64, width)).deflate(1).shape((rows, width)).create("position").unwrap();
    grains.attr("rows").unwrap().write_scalar(&(rows as u64)).unwrap();
}

#[test]
fn more_rows_than_the_file_can_hold() {
    let (_guard, folder) = sample::folder();
    let error = changed(&folder.join("rows"), |grains| {
        grains.unlink("id").unwrap();
        claim(grains, ROWS, 2);
    });
    assert!(error.is_damage(), "{error:?}");
    let said = error.to_string();
    assert!(said.contains("table \"grains\", column \"position\"") && said.contains("can hold"), "{said}");
}

#[test]
fn rows_without_values() {
    let (_guard, folder) = sample::folder();
    let error = changed(&folder.join("width"), |grains| {
        grains.unlink("position").unwrap();
        grains.new_dataset::<f64>().no_chunk().shape((4, 0)).create("position").unwrap();
    });
    assert!(error.is_damage() && error.to_string().contains("its rows have no values"), "{error}");
}

#[test]
fn more_text_than_the_file_can_hold() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("text");
    store::write(&path, &sample::small_state()).unwrap();
    let file = File::open_rw(&path).unwrap();
    let text = file.group("text").unwrap().new_dataset::<u8>().chunk((64, 1)).deflate(1);
    text.shape((ROWS, 1)).create("state.scenario").unwrap();
    file.close().unwrap();
    let error = store::read(&path).expect_err("nothing stands behind the text");
    assert!(error.is_damage() && error.to_string().contains("can hold"), "{error}");
}

/// What is constant is shrunk by more than a thousand, and still comes back.
#[test]
fn what_shrinks_most_comes_back() {
    let (_guard, folder) = sample::folder();
    let still = State {
        tables: vec![Table::new("still", 3_000_000).with_f64("zero", 3, vec![0.0; 9_000_000])],
        ..State::default()
    };
    store::write(&folder.join("still"), &still).unwrap();
    assert!(store::read(&folder.join("still")).unwrap() == still);
}

/// Damage to the list of a table's many columns ended the program inside of the library.
#[test]
fn damage_to_a_list_of_many_columns() {
    let (_guard, folder) = sample::folder();
    let many =
        (0..30).fold(Table::new("many", 1), |table, column| table.with_u64(&format!("c{column}"), 1, vec![column]));
    let state = State { tables: vec![many], ..State::default() };
    let path = folder.join("many");
    store::write(&path, &state).unwrap();
    let good = std::fs::read(&path).unwrap();
    // The list is where the names are.
    let names = good.windows(3).enumerate().filter(|(_, bytes)| bytes.starts_with(b"c2")).map(|(at, _)| at);
    let names: Vec<usize> = names.collect();
    assert!(!names.is_empty());
    for at in names {
        let mut spoilt = good.clone();
        spoilt[at] ^= 4;
        std::fs::write(&path, spoilt).unwrap();
        assert!(store::read(&path).is_err_and(|error| error.is_damage()), "byte {at}");
    }
}
