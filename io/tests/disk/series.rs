//! A series comes back digit by digit, and a resumed run goes on from its checkpoint's row.

use std::fs;

use proptest::prelude::*;
use scree_io::{Error, Series, series};

use crate::sample;

const HEADER: [&str; 3] = ["step", "time", "energy"];

fn row(number: usize) -> Vec<f64> {
    vec![number as f64, 0.1 * number as f64, -1.0 / (number as f64 + 3.0)]
}

#[test]
fn comes_back_as_written() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("energy.csv");
    let mut series = Series::create(&path, &HEADER).unwrap();
    let rows = [row(0), row(1), vec![1e300, 5e-324, -0.0], vec![f64::INFINITY, f64::NEG_INFINITY, 1e16]];
    rows.iter().for_each(|row| series.push(row).unwrap());
    series.push(&[f64::NAN, 0.0, 0.0]).unwrap();
    series.sync().unwrap();
    let (header, found) = series::read(&path).unwrap();
    assert_eq!(header, HEADER);
    assert_eq!(found[..4], rows);
    assert!(found[2][2].is_sign_negative() && found[4][0].is_nan());
    assert_eq!(series.rows(), 5);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("step,time,energy\n0,0,-0.3333333333333333\n1,0.1,-0.25\n1e300,5e-324,-0\n"), "{text}");
}

#[test]
fn resuming_gives_the_file_of_an_uninterrupted_run() {
    let (_guard, folder) = sample::folder();
    let (whole, broken) = (folder.join("whole.csv"), folder.join("broken.csv"));
    let mut series = Series::create(&whole, &HEADER).unwrap();
    (0..10).for_each(|number| series.push(&row(number)).unwrap());
    for rows in [0, 4, 7] {
        for torn in ["", "7,0.7", "7,0.7,-0.1\n8,0.", "garbage\0\n\u{fffd}"] {
            let mut series = Series::create(&broken, &HEADER).unwrap();
            (0..rows).for_each(|number| series.push(&row(number)).unwrap());
            let digest = series.digest();
            (rows..7).for_each(|number| series.push(&row(number)).unwrap());
            drop(series);
            fs::write(&broken, fs::read_to_string(&broken).unwrap() + torn).unwrap();
            let mut series = Series::resume(&broken, &HEADER, rows, digest).unwrap();
            assert_eq!(series.rows(), rows);
            (rows..10).for_each(|number| series.push(&row(number)).unwrap());
            assert_eq!(fs::read(&broken).unwrap(), fs::read(&whole).unwrap(), "{rows} rows, then {torn:?}");
            fs::remove_file(&broken).unwrap();
        }
    }
}

#[test]
fn resuming_refuses_what_does_not_fit_and_leaves_it_untouched() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("energy.csv");
    let text = "step,time,energy\n0,0,1\n1,0.1,x\n2,0.2";
    fs::write(&path, text).unwrap();
    let message = |header: &[&str], rows| Series::resume(&path, header, rows, 0).unwrap_err().to_string();
    let other = message(&["step", "mass"], 1);
    assert!(other.contains("energy.csv") && other.contains("\"step,time,energy\""), "{other}");
    assert!(other.contains("\"step,mass\""), "{other}");
    let bad = message(&HEADER, 2);
    assert!(bad.contains("line 3: \"1,0.1,x\" is not a row of 3 numbers"), "{bad}");
    fs::write(&path, text.replace('x', "1")).unwrap();
    let few = message(&HEADER, 3);
    assert!(few.contains("energy.csv holds 2 whole rows, 3 are needed"), "{few}");
    let changed = message(&HEADER, 2);
    assert!(changed.contains("energy.csv: its first 2 rows are not those that were written"), "{changed}");
    assert_eq!(fs::read_to_string(&path).unwrap(), text.replace('x', "1"));
    fs::write(&path, "step,ti").unwrap();
    assert!(matches!(Series::resume(&path, &HEADER, 0, 0), Err(Error::SeriesHeader { .. })));
}

#[test]
fn creating_never_overwrites() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("energy.csv");
    Series::create(&path, &HEADER).unwrap();
    let error = Series::create(&path, &HEADER).unwrap_err();
    assert!(error.to_string().contains("energy.csv") && error.to_string().contains("move it aside"), "{error}");
}

#[test]
fn reading_passes_over_a_torn_last_line() {
    let (_guard, folder) = sample::folder();
    let path = folder.join("energy.csv");
    fs::write(&path, "a,b\n1,2\n3,4").unwrap();
    assert_eq!(series::read(&path).unwrap().1, [[1.0, 2.0]]);
    fs::write(&path, "").unwrap();
    assert!(matches!(series::read(&path), Err(Error::Truncated { .. })));
    assert!(series::read(&folder.join("absent")).unwrap_err().to_string().contains("absent"));
}

#[test]
#[should_panic(expected = "one value per column")]
fn a_row_of_the_wrong_length_is_a_bug() {
    let (_guard, folder) = sample::folder();
    let _ = Series::create(&folder.join("energy.csv"), &HEADER).unwrap().push(&[1.0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_float_comes_back_to_the_bit(bits in proptest::collection::vec(any::<u64>(), 50)) {
        let values: Vec<f64> = bits.into_iter().map(f64::from_bits).filter(|value| !value.is_nan()).collect();
        let (_guard, folder) = sample::folder();
        let path = folder.join("bits.csv");
        let mut series = Series::create(&path, &["value"]).unwrap();
        values.iter().for_each(|value| series.push(&[*value]).unwrap());
        let (_, rows) = series::read(&path).unwrap();
        prop_assert_eq!(rows.len(), values.len());
        for (row, value) in rows.iter().zip(&values) {
            prop_assert_eq!(row[0].to_bits(), value.to_bits());
        }
    }
}
