//! The quickstart under real `mpirun`: the same digest and the same curve on any number of ranks and threads, and
//! through an interruption on either side of the enrichment.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, OnceLock};
use std::time::{Duration, Instant};

use scree::job::Job;
use scree::run::start;
use scree_partition::transport::threads;

use crate::runs::{done, options};

pub const SCREE: &str = env!("CARGO_BIN_EXE_scree");
const JOB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/quickstart.toml");
/// A third of its way: grains enter at 1.6 % of strain.
const END: &str = "loading.strain_end=0.04";
/// Nothing here takes a tenth of this; a hang must not take the suite with it.
const PATIENCE: Duration = Duration::from_secs(300);

/// Runs one at a time: they share two cores.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// A folder of this test binary, kept until the machine cleans it up, with the packing that all runs share.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| tempfile::Builder::new().prefix("scree-mpirun-").tempdir().unwrap().keep())
}

/// `scree` on `ranks` ranks, with the environment that a launcher above this test may have left removed.
pub fn scree(ranks: usize, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["--oversubscribe", "--bind-to", "none", "-n", &ranks.to_string(), SCREE]).args(arguments);
    launching(&mut command);
    command.current_dir(folder()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The environment of a command that is mpirun or starts it.
pub fn launching(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if ["OMPI_COMM", "OMPI_UNIVERSE", "PMIX_", "PMI_"].iter().any(|prefix| name.starts_with(prefix)) {
            command.env_remove(name.as_ref());
        }
    }
    command
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_btl", "self,vader")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
        // A longer time before SIGKILL is also waited before SIGTERM is passed on.
        .env_remove("OMPI_MCA_odls_base_sigkill_timeout");
}

fn run_arguments<'a>(out: &'a str, threads: &'a str) -> Vec<&'a str> {
    vec!["run", JOB, "--out", out, "--threads", threads, "--set", "packing.cache=cache", "--set", END]
}

/// All that a process has said.
pub fn words(ended: &Output) -> String {
    String::from_utf8_lossy(&ended.stdout).into_owned() + &String::from_utf8_lossy(&ended.stderr)
}

/// The end of a process, which must come; its words are read meanwhile, so that they do not stop it.
pub fn finished(child: Child) -> Output {
    let started = Instant::now();
    let id = child.id();
    let (send, receive) = std::sync::mpsc::channel();
    std::thread::spawn(move || send.send(child.wait_with_output()));
    receive.recv_timeout(PATIENCE).map_or_else(
        |_| {
            signal(id, "KILL");
            panic!("no end after {:?}", started.elapsed())
        },
        |output| output.unwrap(),
    )
}

fn completed(mut command: Command) {
    let output = finished(command.spawn().expect("mpirun is installed"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

pub fn signal(process: u32, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &process.to_string()]).status().unwrap();
    assert!(status.success());
}

fn digest(out: &str) -> String {
    let output = Command::new(SCREE).args(["digest", out]).current_dir(folder()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let digest = String::from_utf8(output.stdout).unwrap().trim().to_string();
    assert_eq!(digest.len(), 64);
    digest
}

fn read(out: &str, file: &str) -> Vec<u8> {
    std::fs::read(folder().join(out).join(file)).unwrap()
}

/// Digest and curve of an uninterrupted run on one rank.
fn reference() -> &'static (String, Vec<u8>) {
    static REFERENCE: OnceLock<(String, Vec<u8>)> = OnceLock::new();
    REFERENCE.get_or_init(|| {
        completed(scree(1, &run_arguments("reference", "1")));
        // Through a cell that is sheared by plates, and through an enrichment.
        let kept = &conserved("reference")["momentum"];
        assert!(kept["error"].as_f64().unwrap() < 1e-9, "{kept:#}");
        (digest("reference"), read("reference", "series.csv"))
    })
}

/// What a run has kept, as its summary says.
fn conserved(out: &str) -> serde_json::Value {
    serde_json::from_slice::<serde_json::Value>(&read(out, "summary.json")).unwrap()["conservation"].take()
}

fn assert_same(out: &str) {
    let (digest_wanted, series_wanted) = reference();
    assert_eq!(&digest(out), digest_wanted, "{out}: another state");
    assert!(&read(out, "series.csv") == series_wanted, "{out}: another curve");
    assert!(conserved(out) == conserved("reference"), "{out}: another account of what is kept");
    let frames = |out: &str| scree_io::frames::read(&folder().join(out).join("frames.vtkhdf")).unwrap();
    assert!(frames(out) == frames("reference"), "{out}: other frames");
}

fn grains_in_last_row(out: &str) -> Option<String> {
    let text = std::fs::read_to_string(folder().join(out).join("series.csv")).ok()?;
    let row = text.lines().last().filter(|row| row.starts_with(|first: char| first.is_ascii_digit()))?;
    row.split(',').nth(6).map(str::to_string)
}

/// One of the ranks that mpirun has started.
pub fn a_rank_of(mpirun: u32) -> u32 {
    let children = std::fs::read_to_string(format!("/proc/{mpirun}/task/{mpirun}/children")).unwrap();
    children.split_whitespace().next().expect("mpirun has started ranks").parse().unwrap()
}

/// Starts on `ranks`, sends SIGTERM to the process that `whom` makes of mpirun's once `ready`, resumes on `ranks_after`.
fn interrupted(
    out: &str,
    ranks: usize,
    ranks_after: usize,
    whom: impl Fn(u32) -> u32,
    ready: impl Fn(&str) -> bool,
) -> String {
    let mut child = scree(ranks, &run_arguments(out, "1")).spawn().unwrap();
    let started = Instant::now();
    while !ready(out) {
        assert!(started.elapsed() < PATIENCE && child.try_wait().unwrap().is_none(), "{out}: ended before the signal");
        std::thread::sleep(Duration::from_millis(2));
    }
    signal(whom(child.id()), "TERM");
    finished(child);
    let summary = String::from_utf8(read(out, "summary.json")).unwrap();
    assert!(summary.contains("\"outcome\": \"stopped\""), "{out}: no word of the stop: {summary}");
    let grains = grains_in_last_row(out).unwrap();
    completed(scree(ranks_after, &["resume", out, "--threads", "1"]));
    grains
}

#[test]
fn the_same_on_two_three_and_four_ranks_and_on_two_threads() {
    let _turn = turn();
    reference();
    for ranks in 2..=4 {
        let out = format!("ranks-{ranks}");
        completed(scree(ranks, &run_arguments(&out, "1")));
        assert_same(&out);
    }
    completed(scree(1, &run_arguments("threads-2", "2")));
    assert_same("threads-2");
}

/// The ranks of the other tests are threads of one process: they and processes under mpirun mean the same.
#[test]
fn the_same_on_ranks_that_are_threads() {
    let _turn = turn();
    reference();
    let cache = format!("packing.cache={}", folder().join("cache").display());
    let job = Job::load(Path::new(JOB), &[cache, END.to_string()]).unwrap();
    let out = folder().join("in-process");
    threads::run(3, |rank| done(start::start(&job, &options(&out), &rank)));
    assert_same("in-process");
}

#[test]
fn the_same_through_an_interruption_before_enrichment() {
    let _turn = turn();
    reference();
    // mpirun would take its time to pass the signal on; one rank that hears it is enough.
    let grains = interrupted("early", 2, 3, a_rank_of, |out| grains_in_last_row(out).is_some());
    assert_eq!(grains, "0", "the signal came after enrichment");
    assert_same("early");
}

#[test]
fn the_same_through_an_interruption_after_enrichment() {
    let _turn = turn();
    reference();
    let grains =
        interrupted("late", 3, 2, |mpirun| mpirun, |out| grains_in_last_row(out).is_some_and(|grains| grains != "0"));
    assert_ne!(grains, "0");
    assert_same("late");
}
