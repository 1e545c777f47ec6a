//! A digest stands for the state, all of it and nothing else.

use scree_io::{State, Values, digest};

use crate::sample;

fn changed(change: impl FnOnce(&mut State)) -> bool {
    let mut state = sample::state();
    change(&mut state);
    digest(&state) != digest(&sample::state())
}

#[test]
fn is_64_hex_digits_and_the_same_on_every_machine() {
    let found = digest(&sample::small_state());
    assert_eq!(found, "ccacbb777ef3dc5be7e4506ccf58535b282f5bceaf822d4a1e5cfa051e8ed0f2");
    assert_eq!(digest(&State::default()), "b890148e831445f9b081a451bcf77a1fd33e1f4db99efd63929da1c5f7ed19e2");
}

#[test]
fn any_single_value_changes_it() {
    let tables = sample::state().tables.len();
    for table in 0..tables {
        for column in 0..sample::state().tables[table].columns.len() {
            let values = sample::state().tables[table].columns[column].values.len();
            for value in [0, values / 2, values.saturating_sub(1)] {
                if value < values {
                    let flip = |state: &mut State| match &mut state.tables[table].columns[column].values {
                        Values::F64(values) => values[value] = f64::from_bits(values[value].to_bits() ^ 1),
                        Values::I64(values) => values[value] ^= 1,
                        Values::U64(values) => values[value] ^= 1,
                        Values::U8(values) => values[value] ^= 1,
                    };
                    assert!(changed(flip), "table {table}, column {column}, value {value}");
                }
            }
        }
    }
}

#[test]
fn the_sign_of_zero_and_the_bits_of_a_nan_change_it() {
    let with = |number: f64| {
        let mut state = sample::small_state();
        state.tables[0].columns[0].values = Values::F64(vec![number; 8]);
        digest(&state)
    };
    assert_ne!(with(0.0), with(-0.0));
    assert_ne!(with(f64::NAN), with(f64::from_bits(f64::NAN.to_bits() ^ 1)));
}

#[test]
fn names_order_rows_width_and_type_change_it() {
    assert!(changed(|state| state.tables[0].name.push('x')));
    assert!(changed(|state| state.tables[0].columns[0].name.push('x')));
    assert!(changed(|state| state.tables.swap(0, 1)));
    assert!(changed(|state| state.tables[0].columns.swap(1, 3)));
    assert!(changed(|state| state.tables[2].rows += 1));
    assert!(changed(|state| state.tables[1].columns[0].width = 2));
    assert!(changed(|state| state.tables[1].columns[0].values = Values::I64(vec![])));
    assert!(changed(|state| drop(state.tables.pop())));
}

#[test]
fn only_attributes_of_the_state_change_it() {
    let set = |key: &str, text: &str| {
        let (key, text) = (key.to_owned(), text.to_owned());
        changed(|state| drop(state.attributes.insert(key, text)))
    };
    assert!(set("state.time", "0.1250"));
    assert!(set("state.new", ""));
    assert!(!set("program", "2.0.0"));
    assert!(!set("wall_time", "3 h"));
}
