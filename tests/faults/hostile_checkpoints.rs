//! Checkpoints of any bytes and of any tables. Files go to the program itself, since the library that reads them may end the
//! process that called it; tables that a good file can hold are tried in a process of their own, with only so much memory.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use scree::base::space::Plane;
use scree::job::Job;
use scree::store::checkpoint::{self, Snapshot};
use scree_io::column::{State, Values};
use scree_io::store;

use crate::catalogue::{scree, told};
use crate::hostile_jobs::within_limits;
use crate::runs::{done, options};

/// Bytes of address space of the process that tables are tried in.
const MEMORY_MAX: u64 = 3 << 30;
/// Spoilt files that the program is given.
const FILES: u64 = 150;

/// Discs under pressure, for a few steps.
const JOB: &str = r#"
name = "discs"
[cell]
space = "plane"
upper = [0.02, 0.02]
[grains]
density = 2500
count = 60
diameter_mean = "1 mm"
diameter_deviation = "0.1 mm"
[packing]
preparation = "compress"
stress = "100 kPa"
energy_ratio_max = 1e-2
[contact]
stiffness_normal = 1e6
stiffness_tangential = 5e5
restitution = 0.3
friction = 0.5
[time]
step = "0.2 us"
end = "2 us"
"#;

type Discs = Snapshot<Plane>;

/// The newest checkpoint of a run of the job.
fn checkpoint_in(folder: &Path) -> PathBuf {
    let out = folder.join("run");
    let sets = [format!("packing.cache={}", folder.join("cache").display())];
    let job = Job::parse(JOB, "job.toml", &sets).unwrap_or_else(|error| panic!("{error}"));
    done(scree::run::start::start(&job, &options(&out), &scree_partition::Solo));
    store::newest(&checkpoint::folder(&out)).expect("there are checkpoints").remove(0).1
}

/// A few bits, bytes or runs of bytes of a file changed, by a number that names the change.
fn spoilt(good: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed;
    let mut next = move |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut bytes = good.to_vec();
    let at = next(bytes.len());
    match seed % 6 {
        0..3 => bytes[at] ^= 1 << next(8),
        3 => bytes.truncate(at),
        4 => bytes[at..].iter_mut().take(64).for_each(|byte| *byte = next(256) as u8),
        _ => drop(bytes.drain(at..(at + next(64)).min(good.len()))),
    }
    bytes
}

/// Each is refused with a message, or no bit of the state was touched; the library survives.
#[test]
fn spoilt_files_are_refused_or_whole() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let path = checkpoint_in(folder.path());
    let good = std::fs::read(&path).expect("it can be read");
    let digest = checkpoint::digest_of(&path).expect("it is good");
    let file = folder.path().join("spoilt.h5");
    for seed in 0..FILES {
        std::fs::write(&file, spoilt(&good, seed)).expect("it can be written");
        match told(scree("digest", &file, folder.path()), &format!("change {seed}")) {
            (Some(0), _) => assert_eq!(checkpoint::digest_of(&file).expect("it was read just now"), digest, "{seed}"),
            (Some(2), said) => assert!(said.contains("spoilt.h5") && said.trim().len() > 30, "{seed}: {said}"),
            (code, said) => panic!("change {seed}: exit code {code:?}: {said}"),
        }
    }
}

#[test]
fn no_table_takes_the_program_down() {
    within_limits("hostile_checkpoints::in_a_cage", MEMORY_MAX);
}

/// What every table says is looked at before it is gone on from.
#[test]
fn tables_that_are_no_state() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let good = store::read(&checkpoint_in(folder.path())).expect("it is good");
    Discs::from_state(good.clone(), 1).unwrap_or_else(|error| panic!("{error}"));
    let refused = |wanted: &str, change: &dyn Fn(&mut State)| {
        let mut state = good.clone();
        change(&mut state);
        let said = Discs::from_state(state, 1).expect_err(wanted).to_string();
        assert!(said.contains(wanted), "wanted: {wanted}\nsaid: {said}");
    };
    refused("there is no table `grains`", &|state| state.tables.retain(|table| table.name != "grains"));
    refused("table `grains` has no column `radius` of width 1", &|state| rename(state, "grains", "radius"));
    refused("the checkpoint carries no scenario", &|state| drop(state.attributes.remove("scenario")));
    refused("radius is not a number", &|state| numbers(state, "grains", "radius")[0] = f64::NAN);
    refused("both must be positive", &|state| numbers(state, "grains", "mass")[3] = 0.0);
    refused("stands twice", &|state| {
        empty(state, "contacts");
        let ids = words(state, "grains", "id");
        ids[1] = ids[0];
    });
    refused("which table `grains` lacks", &|state| words(state, "contacts", "higher")[0] = 1_000_000);
    refused("and at most 999999999999 steps are counted", &|state| words(state, "run", "step")[0] = u64::MAX);
    refused("table `run` has 0 rows", &|state| empty(state, "run"));
    refused("and 1000000000000000 rows of", &|state| table(state, "grains").rows = 1_000_000_000_000_000);
    refused("and no column", &|state| {
        let flagged = table(state, "flagged");
        (flagged.rows, flagged.columns) = (1_000_000_000_000_000, Vec::new());
    });
}

fn table<'a>(state: &'a mut State, name: &str) -> &'a mut scree_io::column::Table {
    state.tables.iter_mut().find(|table| table.name == name).expect("the good state has it")
}

fn column<'a>(state: &'a mut State, of: &str, name: &str) -> &'a mut Values {
    let columns = &mut table(state, of).columns;
    &mut columns.iter_mut().find(|column| column.name == name).expect("the good state has it").values
}

fn numbers<'a>(state: &'a mut State, of: &str, name: &str) -> &'a mut Vec<f64> {
    match column(state, of, name) {
        Values::F64(values) => values,
        other => panic!("{other:?}"),
    }
}

fn words<'a>(state: &'a mut State, of: &str, name: &str) -> &'a mut Vec<u64> {
    match column(state, of, name) {
        Values::U64(values) => values,
        other => panic!("{other:?}"),
    }
}

fn rename(state: &mut State, of: &str, name: &str) {
    table(state, of).columns.iter_mut().filter(|column| column.name == name).for_each(|column| column.name.push('x'));
}

fn empty(state: &mut State, of: &str) {
    let table = table(state, of);
    table.rows = 0;
    for column in &mut table.columns {
        column.values = match column.values {
            Values::F64(_) => Values::F64(Vec::new()),
            Values::I64(_) => Values::I64(Vec::new()),
            Values::U64(_) => Values::U64(Vec::new()),
            Values::U8(_) => Values::U8(Vec::new()),
        };
    }
}

/// Turns over a bit of one value, whatever it is.
fn flip(values: &mut Values, at: usize, bit: u32) {
    let (at, turned) = (at % values.len().max(1), 1_u64 << (bit % 64));
    match values {
        Values::F64(values) => {
            values.iter_mut().skip(at).take(1).for_each(|value| *value = f64::from_bits(value.to_bits() ^ turned));
        }
        Values::I64(values) => values.iter_mut().skip(at).take(1).for_each(|value| *value ^= turned as i64),
        Values::U64(values) => values.iter_mut().skip(at).take(1).for_each(|value| *value ^= turned),
        Values::U8(values) => values.iter_mut().skip(at).take(1).for_each(|value| *value ^= 1 << (bit % 8)),
    }
}

mod in_a_cage {
    use super::*;

    /// One thing changed in the tables of a good checkpoint.
    fn change(state: &mut State, (of, column, at): (usize, usize, usize), kind: u32, bit: u32) {
        let count = state.tables.len();
        let other = at % count;
        let table = &mut state.tables[of % count];
        let columns = table.columns.len();
        let chosen = column % columns.max(1);
        match kind {
            0..4 => table.columns.iter_mut().skip(chosen).take(1).for_each(|column| flip(&mut column.values, at, bit)),
            4 => table.rows ^= 1 << (bit % 64),
            5 if columns > 0 => drop(table.columns.remove(chosen)),
            6 => table.columns.iter_mut().skip(chosen).take(1).for_each(|column| column.width ^= 1 << (bit % 64)),
            7 if columns > 0 => table.columns.swap(chosen, at % columns),
            8 => table
                .columns
                .iter_mut()
                .skip(chosen)
                .take(1)
                .for_each(|column| column.values = Values::U8(vec![1; at % 100])),
            9 => drop(state.tables.remove(of % count)),
            10 => {
                let columns = state.tables[other].columns.clone();
                state.tables[of % count].columns = columns;
            }
            _ => {
                let text = state.attributes.entry("scenario".into()).or_default();
                let cut = (0..=at % (text.len() + 1)).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
                text.truncate(cut);
            }
        }
    }

    /// Refused with a message, or a snapshot whose job is read or refused as any other.
    #[test]
    #[ignore = "no_table_takes_the_program_down runs it"]
    fn spoilt_tables() {
        let folder = tempfile::tempdir().unwrap();
        let good = store::read(&checkpoint_in(folder.path())).unwrap();
        let config = ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() };
        let places = (any::<usize>(), any::<usize>(), any::<usize>());
        proptest!(config, |(place in places, kind in 0..12_u32, bit in any::<u32>())| {
            let mut state = good.clone();
            change(&mut state, place, kind, bit);
            match Discs::from_state(state, 1) {
                Ok(snapshot) => drop(Job::parse(&snapshot.scenario, "scenario.toml", &[])),
                Err(error) => prop_assert_eq!(error.exit_code(), 2),
            }
        });
    }
}
