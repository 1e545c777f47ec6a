//! A checkpoint comes back exactly, or the reader says what is wrong with which file.

use std::fs;
use std::os::unix::fs::{FileExt, PermissionsExt};
use std::path::Path;
use std::time::{Duration, SystemTime};

use scree_io::schema::SCHEMA_VERSION;
use scree_io::{Error, State, Table, digest, store};

use crate::sample;

#[test]
fn comes_back_exactly() {
    let (_guard, folder) = sample::folder();
    for (name, state) in [("full", sample::state()), ("small", sample::small_state()), ("empty", State::default())] {
        let path = folder.join(name);
        store::write(&path, &state).unwrap();
        let found = store::read(&path).unwrap();
        assert_eq!(found, state);
        assert_eq!(digest(&found), digest(&state));
    }
}

#[test]
fn keeps_the_bits_of_every_float() {
    let (_guard, folder) = sample::folder();
    let odd = [f64::NAN, -f64::NAN, f64::from_bits(0x7ff0_0000_0000_0001), f64::INFINITY, -0.0, 5e-324];
    let state = State { tables: vec![Table::new("odd", 6).with_f64("value", 1, odd.to_vec())], ..State::default() };
    store::write(&folder.join("odd"), &state).unwrap();
    let found = store::read(&folder.join("odd")).unwrap();
    let bits =
        |state: &State| state.tables[0].f64s("value", 1).unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&found), bits(&state));
}

#[test]
fn many_columns_tables_and_attributes_keep_their_order() {
    let (_guard, folder) = sample::folder();
    let mut state = State::default();
    for number in (0..40).rev() {
        let columns = (0..30).rev().fold(Table::new(&format!("t{number}"), 1), |table, column| {
            table.with_u64(&format!("c{column}"), 1, vec![column])
        });
        state.tables.push(columns);
        state.attributes.insert(format!("state.{number}"), format!("value {number}"));
    }
    let path = folder.join("many");
    store::write(&path, &state).unwrap();
    assert_eq!(store::read(&path).unwrap(), state);
}

#[test]
fn equal_states_give_equal_bytes() {
    let (_guard, folder) = sample::folder();
    store::write(&folder.join("first"), &sample::state()).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1100));
    store::write(&folder.join("second"), &sample::state()).unwrap();
    assert!(fs::read(folder.join("first")).unwrap() == fs::read(folder.join("second")).unwrap());
}

#[test]
fn replaces_a_file_as_a_whole_and_leaves_nothing_aside() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::state()).unwrap();
    store::write(&path, &sample::small_state()).unwrap();
    assert_eq!(store::read(&path).unwrap(), sample::small_state());
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn what_an_interrupted_write_left_goes_once_nobody_can_be_at_it() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    let yesterday = SystemTime::now() - Duration::from_secs(25 * 3600);
    let files = [
        ("state.h5.partial", true, false),
        ("state.h5.77-3.partial", true, false),
        ("state.h5.78-3.partial", false, true),
        ("state.h5.copy", true, true),
        ("other.h5.77-3.partial", true, true),
    ];
    for (name, is_old, _) in files {
        fs::write(folder.join(name), "half").unwrap();
        let time = if is_old { yesterday } else { SystemTime::now() };
        fs::File::options().write(true).open(folder.join(name)).unwrap().set_modified(time).unwrap();
    }
    store::write(&path, &sample::small_state()).unwrap();
    for (name, _, stays) in files {
        assert_eq!(folder.join(name).exists(), stays, "{name}");
    }
}

#[test]
fn every_flipped_byte_is_found_or_harmless() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::small_state()).unwrap();
    let length = fs::metadata(&path).unwrap().len();
    let file = fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
    let mut found = 0;
    for offset in 0..length {
        let mut byte = [0];
        file.read_exact_at(&mut byte, offset).unwrap();
        for mask in [0x01, 0x80, 0xff] {
            file.write_all_at(&[byte[0] ^ mask], offset).unwrap();
            match store::read(&path) {
                Ok(state) => assert_eq!(state, sample::small_state(), "byte {offset}"),
                Err(error) => {
                    found += 1;
                    assert!(error.is_damage(), "byte {offset}: {error}");
                    assert!(error.to_string().contains("state.h5"), "byte {offset}: {error}");
                }
            }
        }
        file.write_all_at(&byte, offset).unwrap();
    }
    println!("{found} of {} changes found, the rest in unused places", 3 * length);
    assert_eq!(store::read(&path).unwrap(), sample::small_state());
}

#[test]
fn a_flipped_byte_of_data_names_file_table_and_column() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::state()).unwrap();
    // Nearly all of this file is the long column.
    flip(&path, fs::metadata(&path).unwrap().len() / 2);
    let error = store::read(&path).unwrap_err();
    assert!(matches!(error, Error::Damaged { .. }), "{error}");
    for part in ["state.h5", "a table that would come first by name", "\"long\"", "Fletcher32"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn a_file_cut_short_says_so() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::state()).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in [whole.len() - 1, whole.len() / 2, 2000, 100, 20, 0] {
        fs::write(&path, &whole[..length]).unwrap();
        let error = store::read(&path).unwrap_err();
        assert!(error.is_damage(), "{length} bytes: {error}");
        assert!(error.to_string().contains("state.h5"), "{error}");
        if length > 100 || length == 0 {
            assert!(matches!(error, Error::Truncated { .. }), "{length} bytes: {error}");
        }
    }
}

#[test]
fn other_files_are_refused_by_name() {
    let (_guard, folder) = sample::folder();
    let text = folder.join("notes.txt");
    fs::write(&text, "not a checkpoint ".repeat(100)).unwrap();
    let error = store::read(&text).unwrap_err();
    assert!(matches!(error, Error::Foreign { .. }) && error.to_string().contains("notes.txt"), "{error}");

    let frames = folder.join("frames.vtkhdf");
    sample::create(&frames, &sample::frame(0));
    let error = store::read(&frames).unwrap_err();
    assert!(matches!(error, Error::Foreign { .. }) && error.to_string().contains("frames.vtkhdf"), "{error}");

    let error = store::read(&folder.join("absent.h5")).unwrap_err();
    assert!(error.to_string().contains("absent.h5: No such file"), "{error}");
}

#[test]
fn another_schema_is_refused_and_not_taken_for_damage() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::small_state()).unwrap();
    let file = hdf5::File::open_rw(&path).unwrap();
    file.attr("schema_version").unwrap().write_scalar(&99_u64).unwrap();
    file.close().unwrap();
    let error = store::read(&path).unwrap_err();
    assert!(matches!(error, Error::Schema { found: 99, newest: SCHEMA_VERSION, .. }), "{error}");
    assert!(!error.is_damage());
}

#[test]
fn a_changed_value_with_good_checksums_fails_the_digest() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("state.h5");
    store::write(&path, &sample::small_state()).unwrap();
    let file = hdf5::File::open_rw(&path).unwrap();
    file.dataset("tables/grains/id").unwrap().write_raw(&[1_u64, 2, 3, 5]).unwrap();
    file.close().unwrap();
    let error = store::read(&path).unwrap_err();
    assert!(matches!(error, Error::Digest { .. }) && error.to_string().contains("state.h5"), "{error}");
}

#[test]
fn a_folder_that_cannot_be_written_to_gives_the_reason() {
    let (_guard, folder) = sample::folder();
    let error = store::write(&folder.join("absent/state.h5"), &sample::small_state()).unwrap_err();
    assert!(error.to_string().contains(".partial: No such file"), "{error}");

    fs::write(folder.join("file"), "").unwrap();
    let error = store::write(&folder.join("file/state.h5"), &sample::small_state()).unwrap_err();
    assert!(error.to_string().contains("Not a directory"), "{error}");

    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    match store::write(&folder.join("state.h5"), &sample::small_state()) {
        Ok(()) => println!("skipped: this user may write to a read-only folder"),
        Err(error) => assert!(error.to_string().contains("Permission denied"), "{error}"),
    }
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn getters_name_what_is_missing_and_what_is_there() {
    let state = sample::state();
    let grains = state.table("grains").unwrap();
    assert_eq!(grains.u64s("id", 1).unwrap(), [7, u64::MAX, 0]);
    assert_eq!(grains.i64s("image", 2).unwrap().len(), 6);
    assert_eq!(grains.u8s("kind", 1).unwrap(), [0, 255, 3]);
    assert_eq!(grains.column("position").unwrap().width, 2);
    let message = |error: Error| error.to_string();
    assert!(message(state.table("points").unwrap_err()).contains("tables: grains, contacts"));
    assert!(message(state.attribute("x").unwrap_err()).contains("program"));
    assert!(message(grains.f64s("mass", 1).unwrap_err()).contains("columns: position, id"));
    assert!(message(grains.f64s("position", 3).unwrap_err()).contains("2 x f64 per row, expected 3 x f64"));
    assert!(message(grains.f64s("id", 1).unwrap_err()).contains("1 x u64 per row, expected 1 x f64"));
}

#[test]
#[should_panic(expected = "column position must have 3 rows of 2 values")]
fn a_column_of_the_wrong_length_is_a_bug() {
    let _ = Table::new("grains", 3).with_f64("position", 2, vec![0.0; 5]);
}

pub fn flip(path: &Path, offset: u64) {
    let file = fs::OpenOptions::new().read(true).write(true).open(path).unwrap();
    let mut byte = [0];
    file.read_exact_at(&mut byte, offset).unwrap();
    file.write_all_at(&[byte[0] ^ 0x10], offset).unwrap();
}
