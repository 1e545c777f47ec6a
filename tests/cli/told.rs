//! What people are told never ends a run, and what they ask for too early is not lost.

use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::folders::Desk;
use crate::mpirun::{SCREE, finished, scree, signal, turn, words};

/// Closed, full, or piped into something that has ended: once a line to stderr that could not be written was a panic.
#[test]
fn a_run_whose_words_nobody_can_read_goes_on() {
    let _turn = turn();
    let desk = Desk::new();
    // A packing of its own, which says how far it is.
    let cases = ["2>&-", "2>/dev/full", "2> >(true)", ">&- 2>&-", ">/dev/full 2>/dev/full", "2>&1 | true"];
    for (number, how) in cases.iter().enumerate() {
        for ranks in [0, 2] {
            // mpirun itself comes to no end without both.
            if ranks > 0 && how.contains(">&- ") {
                continue;
            }
            let launcher = if ranks == 0 { String::new() } else { format!("mpirun --oversubscribe -n {ranks} ") };
            let cache = desk.path(&format!("cache_{number}_{ranks}"));
            let out = format!("out_{number}_{ranks}");
            let line = format!(
                "{launcher}\"$0\" run job.toml --out {out} --threads 1 --set packing.cache='\"{}\"' {how}",
                cache.display()
            );
            let mut command = Command::new("bash");
            command.args(["-c", &line, SCREE]);
            crate::mpirun::launching(&mut command);
            command.current_dir(desk.path(".")).stdin(Stdio::null());
            let ended = finished(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
            assert!(how.contains("| true") || ended.status.success(), "{line}: {}", words(&ended));
            assert!(desk.path(&out).join("summary.json").exists(), "{line}: no summary");
            desk.assert_same(&out);
        }
    }
}

/// Whether a process has a handler for a signal of that number.
fn catches(process: u32, number: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
    u64::from_str_radix(caught.trim(), 16).is_ok_and(|mask| mask >> (number - 1) & 1 == 1)
}

/// MPI takes half a second to start, in which these signals once ended a rank and left mpirun hanging.
#[test]
fn a_signal_before_the_run_has_begun_is_heard() {
    const USR1: u32 = 10;
    const USR2: u32 = 12;
    let _turn = turn();
    let desk = Desk::new();
    for (name, code) in [("USR1", 0), ("USR2", 4)] {
        let out = format!("early_{name}");
        let mut command = scree(2, &["run", "job.toml", "--out", &out, "--threads", "1"]);
        let child = command.current_dir(desk.path(".")).spawn().unwrap();
        let since = Instant::now();
        let ranks = || {
            let children = fs::read_to_string(format!("/proc/{0}/task/{0}/children", child.id())).unwrap_or_default();
            children.split_whitespace().filter_map(|rank| rank.parse().ok()).collect::<Vec<u32>>()
        };
        // As soon as they listen.
        while !(ranks().len() == 2 && ranks().iter().all(|rank| catches(*rank, USR1) && catches(*rank, USR2))) {
            assert!(since.elapsed() < Duration::from_secs(60), "{name}: no rank listens");
            std::thread::yield_now();
        }
        assert!(!desk.path(&out).exists(), "the ranks listen only once the run has begun");
        ranks().iter().for_each(|rank| signal(*rank, name));
        let ended = finished(child);
        assert_eq!(ended.status.code(), Some(code), "{name}: {}", words(&ended));
        if code == 4 {
            assert!(words(&ended).contains("Stopped on request"), "{}", words(&ended));
            desk.succeeded(&["resume", &out]);
        }
        desk.assert_same(&out);
    }
}

/// A run that is alive or was killed has a report, which says so.
#[test]
fn a_report_opens_runs_that_are_alive_or_were_killed() {
    let _turn = turn();
    let desk = Desk::new();
    let mut child = desk.command(&["run", "job.toml", "--out", "alive", "--set", "time.end=10"]).spawn().unwrap();
    let since = Instant::now();
    while fs::read_to_string(desk.path("alive/series.csv")).map_or(0, |text| text.lines().count()) < 5 {
        assert!(since.elapsed() < Duration::from_secs(60), "no rows");
        std::thread::sleep(Duration::from_millis(5));
    }
    let page = || {
        desk.succeeded(&["report", "alive"]);
        fs::read_to_string(desk.path("alive/report.html")).unwrap()
    };
    assert!(page().contains("still running, or killed"), "the page does not tell that the run goes on");
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(page().contains("still running, or killed"));
    let told = fs::read_to_string(desk.path("reference/report.html"));
    assert!(told.is_err());
    desk.succeeded(&["report", "reference"]);
    assert!(!fs::read_to_string(desk.path("reference/report.html")).unwrap().contains("still running, or killed"));
}

/// Once the nearest checkpoint was written, whatever time was asked for, without a word.
#[test]
fn an_export_is_of_the_time_that_was_asked_for() {
    let desk = Desk::new();
    let told = desk.succeeded(&["export", "reference", "--grains", "start.csv", "--at", "0"]);
    assert!(told.contains("The grains at 0 s are in start.csv"), "{told}");
    let told =
        desk.succeeded(&["export", "reference", "--grains", "middle.csv", "--at", "2 ms", "--contacts", "c.csv"]);
    assert!(told.contains("at 0.002 s are in middle.csv") && told.contains("at 0.002 s are in c.csv"), "{told}");
    let told = desk.succeeded(&["export", "reference", "--grains", "end.csv"]);
    assert!(told.contains("at 0.004 s are in end.csv"), "{told}");
    for at in ["5e-7", "1 ms", "3.9 ms", "-1", "7"] {
        let told = desk.refused(&["export", "reference", "--grains", "no.csv", "--at", at]);
        assert!(told.contains("has no checkpoint of that time. There are 0, 0.002, 0.004 s."), "{told}");
        assert!(!desk.path("no.csv").exists());
    }
    let rows = |name: &str| fs::read_to_string(desk.path(name)).unwrap();
    assert!(rows("start.csv") != rows("middle.csv") && rows("middle.csv") != rows("end.csv"));
}
