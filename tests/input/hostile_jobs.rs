//! Jobs of any bytes, and good jobs with one thing changed. Whatever they are, they are read or refused in a sentence, within
//! seconds. The properties are tried in a process of their own that may have only so much memory: an allocation without bound
//! ends it, and its last words are shown.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use scree::base::error::Error;
use scree::job::Job;

/// Bytes of address space of that process, its libraries and thread stacks included.
const MEMORY_MAX: u64 = 2 << 30;
/// Time of one reading.
const TIME_MAX: Duration = Duration::from_secs(10);
/// Bytes of the longest refusal, of twenty mistakes.
const WORDS_MAX: usize = 20 * 1500;

/// Where they are said to stand: files that they name are looked for beside it.
const FILE: &str = "jobs/job.toml";

/// Good jobs of every kind.
const GOOD: [&str; 5] = [
    include_str!("../../jobs/planar_shear.toml"),
    include_str!("../../jobs/element/uniaxial.toml"),
    include_str!("../../jobs/element/pour.toml"),
    include_str!("../../jobs/continuum/column_collapse.toml"),
    include_str!("../../jobs/continuum/prandtl_surcharge.toml"),
];

/// What takes the place of a value: of another type, absurd, or nearly right.
#[rustfmt::skip]
const VALUES: [&str; 34] = [
    "nan", "inf", "-inf", "0", "-0.0", "1e308", "-1e308", "1e-308", "1e30", "1e-30", "1e12", "1e-12", "-1", "1", "2",
    "9223372036854775807", "-9223372036854775808", "99999999999999999999", "\"\"", "\"free\"", "\"1e999999999 m\"",
    "\"1e2147483647 km\"", "\"1 m\"", "\"1 s\"", "\"5 %\"", "[]", "{}", "[[]]", "[0, 0]", "[1e30, 1e30]", "true",
    "1979-05-27", "\"µ\"", "'''\n'''",
];

/// Runs tests of this binary that are ignored otherwise, in a process that may have so many bytes of address space.
pub fn within_limits(module: &str, bytes: u64) {
    let this = std::env::current_exe().expect("this program has a path");
    let output = Command::new("sh")
        .args(["-c", &format!("ulimit -c 0; ulimit -v {}; exec \"$@\"", bytes >> 10), "sh"])
        .arg(this)
        .args(["--ignored", "--test-threads=1", "--nocapture", module])
        .output()
        .expect("this program can be started");
    let told = [output.stdout, output.stderr].concat();
    let told = String::from_utf8_lossy(&told);
    assert!(output.status.success() && !told.contains(" 0 passed"), "{}: {told}", output.status);
}

#[test]
fn no_job_takes_the_program_down() {
    within_limits("hostile_jobs::in_a_cage", MEMORY_MAX);
}

/// Reads and checks a text, and looks at the refusal if it is one.
fn read(text: &str, sets: &[String]) -> Result<Job, Error> {
    let begun = Instant::now();
    let read = Job::parse(text, FILE, sets);
    assert!(begun.elapsed() < TIME_MAX, "{:?} for {text}", begun.elapsed());
    if let Err(error) = &read {
        let said = error.to_string();
        assert!(error.exit_code() == 2 && said.len() <= WORDS_MAX, "{said}");
        assert!(said.starts_with(&format!("{FILE}:")) || said.starts_with("--set"), "{said}");
    }
    read
}

/// A line of a job as key and value, if it is one.
fn parted(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.split_once(" = ")?;
    key.chars().all(|c| c.is_ascii_lowercase() || c == '_').then_some((key, value))
}

/// The lines of a good job that are keys with values.
fn keys(text: &str) -> Vec<usize> {
    text.lines().enumerate().filter(|(_, line)| parted(line).is_some()).map(|(at, _)| at).collect()
}

/// A good job with some of its lines changed by `change`.
fn changed(text: &str, at: usize, change: impl Fn(&str, &str) -> String) -> String {
    let keys = keys(text);
    let chosen = keys[at % keys.len()];
    let line = |(number, line): (usize, &str)| match parted(line) {
        Some((key, value)) if number == chosen => change(key, value),
        _ => line.to_string(),
    };
    text.lines().enumerate().map(line).collect::<Vec<String>>().join("\n")
}

/// A checked job means the same when it is written and read again, and its page can be drawn up.
fn means_the_same(job: &Job) {
    let written = job.to_toml();
    let back = Job::parse(&written, FILE, &[]).unwrap_or_else(|error| panic!("{error}\n{written}"));
    assert_eq!(&back, job);
}

mod in_a_cage {
    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        #[ignore = "no_job_takes_the_program_down runs it"]
        fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("job.toml");
            fs::write(&path, bytes).unwrap();
            let _ = Job::load(&path, &[]);
        }

        #[test]
        #[ignore = "no_job_takes_the_program_down runs it"]
        fn any_text(text in "[\\[\\]{}=\".,#'\\\\a-z_0-9 \n\u{e9}-]{0,300}", set in "[a-z._0-9=\\[\\]{}\" -]{0,60}") {
            let _ = read(&text, &[]);
            let _ = read(GOOD[0], &[set]);
        }

        /// Bytes cut out, put in, doubled and turned over.
        #[test]
        #[ignore = "no_job_takes_the_program_down runs it"]
        fn spoilt_bytes(
            job in 0..GOOD.len(),
            place in any::<prop::sample::Index>(),
            length in 0..200_usize,
            kind in 0..5,
            byte in any::<u8>(),
        ) {
            let mut bytes = GOOD[job].as_bytes().to_vec();
            let from = place.index(bytes.len());
            let to = (from + length).min(bytes.len());
            match kind {
                0 => bytes[from] ^= 1 << (byte % 8),
                1 => bytes.truncate(from),
                2 => drop(bytes.drain(from..to)),
                3 => bytes.insert(from, byte),
                _ => bytes.splice(from..from, bytes[from..to].to_vec()).for_each(drop),
            }
            let _ = read(&String::from_utf8_lossy(&bytes), &[]);
        }

        /// A key of another name, or gone, or there twice.
        #[test]
        #[ignore = "no_job_takes_the_program_down runs it"]
        fn renamed_keys(job in 0..GOOD.len(), at in 0..1000_usize, name in "[a-z_]{1,12}|\"[^\"\\\\\n]{0,200}\"", kind in 0..3) {
            let text = changed(GOOD[job], at, |key, value| match kind {
                0 => format!("{name} = {value}"),
                1 => String::new(),
                _ => format!("{key} = {value}\n{key} = {value}"),
            });
            let _ = read(&text, &[]);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

        /// Two values of other types or absurd sizes. What is accepted all the same can be checked to its end.
        #[test]
        #[ignore = "no_job_takes_the_program_down runs it"]
        fn other_values(job in 0..GOOD.len(), at in [0..1000_usize, 0..1000_usize], values in [0..VALUES.len(), 0..VALUES.len()]) {
            let once = changed(GOOD[job], at[0], |key, _| format!("{key} = {}", VALUES[values[0]]));
            if let Ok(job) = read(&once, &[]) {
                means_the_same(&job);
            }
            let _ = read(&changed(&once, at[1], |key, _| format!("{key} = {}", VALUES[values[1]])), &[]);
        }
    }
}

/// Longer than any job: not even read to its end.
#[test]
fn a_job_of_ten_million_bytes() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let path = folder.path().join("job.toml");
    fs::write(&path, vec![b'#'; 10_000_000]).expect("the job is written");
    let said = Job::load(&path, &[]).expect_err("it is too long").to_string();
    assert!(said.contains("this job cannot be read: it is longer than 1048576 bytes, and no job is."), "{said}");
    let endless = Job::load("/dev/zero".as_ref(), &[]).expect_err("it has no end").to_string();
    assert!(endless.starts_with("/dev/zero: this job cannot be read: it is longer than"), "{endless}");
}

/// Bytes that editors of other systems write change nothing.
#[test]
fn marks_and_line_ends_of_other_systems() {
    for text in GOOD {
        let plain = Job::parse(text, FILE, &[]).unwrap();
        assert_eq!(Job::parse(&format!("\u{feff}{text}"), FILE, &[]).unwrap(), plain);
        assert_eq!(Job::parse(&text.replace('\n', "\r\n"), FILE, &[]).unwrap(), plain);
    }
}

/// Work that grows with the square of what is typed would take minutes.
#[test]
fn lists_without_end() {
    let region = "\n[[region]]\nshape = \"ball\"\ncentre = [1, 1]\nradius = 0.1\n";
    let long = |text: &str, of: &str| {
        let said = read(text, &[]).expect_err("it is too long").to_string();
        assert!(said.contains(of), "{said}");
    };
    long(&(GOOD[3].to_string() + &region.repeat(15_000)), "entries, and at most 1000 are allowed");
    let corners = "[1, 1], ".repeat(100_000);
    let polygon = format!("{}\n[[region]]\nshape = \"polygon\"\nvertices = [{corners}]\n", GOOD[3]);
    long(&polygon, "region.vertices has 100000 entries, and at most 1000 are allowed");
    let keys: String = (0..60_000).map(|key| format!("k{key} = 1\n")).collect();
    long(&keys, "has no key k0");
    long(&format!("{} = 1", "x".repeat(900_000)), "has no key xxx");
}
