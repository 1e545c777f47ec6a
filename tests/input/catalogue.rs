//! The catalogue of bad input, `tests/bad_jobs/`. Each entry stands beside a text of the same name that holds, to the byte,
//! what the program says of it on stderr:
//!
//! * `NAME.toml` is a job, and is asked for by `scree check`;
//! * `NAME.h5` is a checkpoint, by `scree digest`;
//! * `NAME.run` is the folder of a run, by `scree resume`.
//!
//! To add an entry, put it there and run this test with `SCREE_ACCEPT=1`, which writes the texts anew; so are messages
//! accepted that were changed on purpose. Read what it wrote before it is committed. The program sees a copy: to be asked for
//! a run it takes that run's folder.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::runs::copy_folder;

/// Bytes that a refusal may take of address space, of which the libraries have most.
const MEMORY_MAX: u64 = 6 << 30;
const TIME_MAX: Duration = Duration::from_secs(60);
/// When this is set, what the program says is written and not compared.
const ACCEPT: &str = "SCREE_ACCEPT";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_jobs")
}

/// The subcommand that an entry is asked for by.
fn subcommand(entry: &Path) -> Option<&'static str> {
    match entry.extension()?.to_str()? {
        "toml" => Some("check"),
        "h5" => Some("digest"),
        "run" => Some("resume"),
        _ => None,
    }
}

/// The program at some input, held to an amount of memory. A library that finds none must not take the test with it.
pub fn scree(subcommand: &str, input: &Path, folder: &Path) -> Child {
    Command::new("sh")
        .args(["-c", &format!("ulimit -c 0; ulimit -v {}; exec \"$@\"", MEMORY_MAX >> 10), "sh"])
        .args([env!("CARGO_BIN_EXE_scree"), subcommand])
        .arg(input)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program can be started")
}

/// Exit code, none where a signal ended it, and all that it said on stderr. Panics where it takes too long.
pub fn told(mut child: Child, what: &str) -> (Option<i32>, String) {
    let mut stderr = child.stderr.take().expect("it is piped");
    let reader = std::thread::spawn(move || {
        let mut text = Vec::new();
        stderr.read_to_end(&mut text).map(|_| String::from_utf8_lossy(&text).into_owned())
    });
    let begun = Instant::now();
    let status = loop {
        match child.try_wait().expect("it can be waited for") {
            Some(status) => break status,
            None if begun.elapsed() > TIME_MAX => {
                child.kill().expect("it can be ended");
                panic!("{what}: no end after {TIME_MAX:?}");
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    (status.code(), reader.join().expect("the reader ends").expect("stderr can be read"))
}

/// The first line of a run tells of ranks and cores, which depend on the machine.
fn without_placement(said: &str) -> String {
    said.split_inclusive('\n').filter(|line| !line.starts_with("1 rank of ")).collect()
}

fn entries() -> Vec<PathBuf> {
    let listed = fs::read_dir(folder()).expect("the catalogue is there");
    let mut entries: Vec<PathBuf> = listed.map(|entry| entry.expect("it can be listed").path()).collect();
    entries.sort();
    entries
}

#[test]
fn bad_input_is_refused_as_the_catalogue_says() {
    let accept = std::env::var_os(ACCEPT).is_some();
    let copy = tempfile::tempdir().expect("a folder can be made");
    copy_folder(&folder(), copy.path());
    let here = format!("{}/", copy.path().display());
    let mut wrong: Vec<String> = Vec::new();
    let mut count = 0;
    for entry in entries() {
        let Some(subcommand) = subcommand(&entry) else { continue };
        count += 1;
        let name = Path::new(entry.file_name().expect("an entry has a name"));
        let (code, said) = told(scree(subcommand, name, copy.path()), &name.display().to_string());
        let said = without_placement(&said).replace(&here, "");
        let beside = entry.with_extension("txt");
        if accept {
            fs::write(&beside, &said).expect("the catalogue can be written");
        }
        let wanted = fs::read_to_string(&beside).unwrap_or_else(|_| "(no text stands beside it)".to_string());
        if code != Some(2) || said != wanted {
            wrong.push(format!("{}: exit code {code:?}\n  wanted: {wanted}\n  said:   {said}", name.display()));
        }
    }
    assert!(wrong.is_empty(), "{} of {count}; {ACCEPT}=1 accepts them:\n\n{}", wrong.len(), wrong.join("\n"));
    assert!(count >= 100, "the catalogue has {count} entries");
}

/// A message of an entry that is gone would be trusted for ever.
#[test]
fn every_message_has_its_input() {
    for text in entries().into_iter().filter(|entry| entry.extension().is_some_and(|ending| ending == "txt")) {
        let has = |ending: &str| text.with_extension(ending).exists();
        assert!(["toml", "h5", "run"].into_iter().any(has), "{} belongs to nothing", text.display());
    }
}

/// What names a place in a job names its file; the rest says what is wrong with the file as a whole. Below each mistake stands the line
/// that it is on, and nothing else.
#[test]
fn messages_name_their_file() {
    for entry in entries().into_iter().filter(|entry| subcommand(entry) == Some("check")) {
        let said = fs::read_to_string(entry.with_extension("txt")).expect("a text stands beside it");
        let name = entry.file_name().expect("an entry has a name").to_string_lossy().into_owned();
        let named = [format!("{name}:"), "grains/".to_string(), "materials/".to_string()];
        assert!(said.ends_with('\n'), "{name}: {said}");
        for mistake in said.trim_end().split("\n\n") {
            let (message, excerpt) = mistake.split_once('\n').unwrap_or((mistake, ""));
            assert!(named.iter().any(|file| message.starts_with(file)), "{name}: {message}");
            assert!(excerpt.lines().all(|line| line.starts_with("  ") && line.contains(" | ")), "{name}: {excerpt}");
        }
    }
}
