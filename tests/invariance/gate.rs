//! Short jobs of every method, law, body, membrane and zone, in the plane and in space, end in the bits that they have always ended
//! in, on one rank and on three: their state, their series and their frames.
//!
//! `tests/gate/golden.csv` has the digests. Whoever means to change bits writes them anew, and says why in the commit:
//!
//! ```text
//! SCREE_GOLDEN=write cargo test --release --test main gate
//! ```

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use scree::job::Job;
use scree::observe::fields::MEANINGS;
use scree::run::start;
use scree::store::checkpoint;
use scree_io::column::{State, Table};
use scree_io::{digest, frames};
use scree_partition::Solo;
use scree_partition::transport::threads;

use crate::runs::{done, options};

/// A run: what it is called, its job, and what is set over that.
#[derive(serde::Deserialize)]
struct Case {
    name: String,
    job: String,
    #[serde(default)]
    set: Vec<String>,
}

#[derive(serde::Deserialize)]
struct Cases {
    case: Vec<Case>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gate")
}

/// State, series and frames of a run.
fn digests(out: &Path) -> [String; 3] {
    let series = std::fs::read(out.join("series.csv")).unwrap();
    let series = Table::new("series", series.len()).with_u8("bytes", 1, series);
    let of = |tables| digest(&State { tables, ..State::default() });
    let mut drawn = Vec::new();
    for name in ["frames.vtkhdf", "contacts.vtkhdf"] {
        let file = out.join(name);
        let read = if file.is_file() { frames::read(&file).unwrap() } else { Vec::new() };
        for (number, frame) in read.into_iter().enumerate() {
            let told = |name: &str| MEANINGS.iter().any(|meaning| meaning.field == name);
            let untold = frame.fields.iter().chain(&frame.whole).find(|column| !told(&column.name));
            assert!(untold.is_none(), "src/observe/fields.rs does not say what {} is", untold.unwrap().name);
            let rows = frame.rows();
            let whole = Table::new(&format!("{name} {number} whole"), 1).with_f64("time", 1, vec![frame.time]);
            drawn.push(
                frame
                    .whole
                    .into_iter()
                    .fold(whole, |table, column| table.with(&column.name, column.width, column.values)),
            );
            let width = 3 * frame.drawn.positions();
            let places =
                Table::new(&format!("{name} {number}"), rows).with_f64("positions", width, frame.positions.concat());
            drawn.push(
                frame
                    .fields
                    .into_iter()
                    .fold(places, |table, column| table.with(&column.name, column.width, column.values)),
            );
        }
    }
    assert!(!drawn.is_empty(), "no frames");
    [checkpoint::digest_of(out).unwrap(), of(vec![series]), of(drawn)]
}

/// Digests of every case, run by `run`, each with a packing of its own.
fn all(run: impl Fn(&Job, &Path)) -> BTreeMap<String, [String; 3]> {
    let scratch = tempfile::tempdir().unwrap();
    let one = |Case { name, job, mut set }: Case| {
        let path = folder().join(format!("{job}.toml"));
        if std::fs::read_to_string(&path).unwrap().contains("cache = ") {
            set.push(format!("packing.cache={}", scratch.path().join(job).display()));
        }
        let job = Job::load(&path, &set).unwrap_or_else(|error| panic!("{name}: {error}"));
        let out = scratch.path().join("runs").join(&name);
        run(&job, &out);
        (name, digests(&out))
    };
    let cases = std::fs::read_to_string(folder().join("cases.toml")).unwrap();
    toml::from_str::<Cases>(&cases).unwrap().case.into_iter().map(one).collect()
}

fn written(digests: &BTreeMap<String, [String; 3]>) -> String {
    let mut text = String::from("job,state,series,frames\n");
    digests
        .iter()
        .for_each(|(name, [state, series, frames])| writeln!(text, "{name},{state},{series},{frames}").unwrap());
    text
}

fn compare(found: &BTreeMap<String, [String; 3]>, ranks: &str) {
    let golden = std::fs::read_to_string(folder().join("golden.csv")).unwrap();
    let found = written(found);
    let others: Vec<&str> = found.lines().filter(|line| !golden.lines().any(|golden| golden == *line)).collect();
    assert!(found == golden, "on {ranks}, against tests/gate/golden.csv, these are other bits: {others:#?}");
}

#[test]
fn jobs_end_in_the_bits_of_old_on_one_rank() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let found = all(|job, out| pool.install(|| done(start::start(job, &options(out), &Solo))));
    if std::env::var("SCREE_GOLDEN").is_ok_and(|word| word == "write") {
        std::fs::write(folder().join("golden.csv"), written(&found)).unwrap();
    }
    compare(&found, "one rank");
}

#[test]
fn jobs_end_in_the_bits_of_old_on_three_ranks() {
    let found = all(|job, out| {
        threads::run(3, |rank| done(start::start(job, &options(out), &rank)));
    });
    compare(&found, "three ranks");
}
