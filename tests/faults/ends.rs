//! A run that fails on some rank ends on all of them within seconds, and its message is there once.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, scree, turn};

/// Where mpirun starts the ends of its ranks: the longest wait of a rank, and what it takes to end the others.
const PATIENCE: Duration = Duration::from_secs(20);

/// A lone disc that flies out of its cell.
const JOB: &str = r#"name = "flies"
[cell]
space = "plane"
upper = ["4 cm", "4 cm"]
periodic = [false, false]
[grains]
density = 2500
file = "one.csv"
diameter_mean = "1 mm"
[contact]
stiffness_normal = "100 kN/m"
stiffness_tangential = "50 kN/m"
restitution = 0.5
friction = 0.5
[time]
step = "1 us"
end = "10 ms"
[decomposition]
block = "1 cm"
"#;

/// Code, what was told, and how long it took; `place` is where the disc flies from.
fn ended(folder: &Path, place: &str, ranks: usize) -> (Option<i32>, String, Duration) {
    std::fs::write(folder.join("one.csv"), format!("id,x,y,radius,vx,vy,spin\n0,{place},5e-4,10,10,0\n")).unwrap();
    std::fs::write(folder.join("job.toml"), JOB).unwrap();
    let started = Instant::now();
    let output = scree(ranks, &["run", "job.toml", "--out", &format!("out-{ranks}"), "--threads", "1"])
        .current_dir(folder)
        .output()
        .unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap(), started.elapsed())
}

#[test]
fn a_failure_that_all_ranks_share_is_told_once() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let (code, words, took) = ended(folder.path(), "35e-3,35e-3", 4);
    assert_eq!(code, Some(3), "{words}");
    assert_eq!(words.matches("outside the domain").count(), 1, "{words}");
    assert!(took < PATIENCE, "{took:?}");
}

/// One rank, and then two, cannot start their threads, while the others wait for them in a message of the run.
#[test]
fn a_failure_of_other_ranks_than_the_first_is_told_once() {
    let _turn = turn();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("one.csv"), "id,x,y,radius,vx,vy,spin\n0,2e-2,2e-2,5e-4,0,0,0\n").unwrap();
    std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
    for good in [3, 2] {
        let started = Instant::now();
        let out = format!("out{good}");
        let mut command = scree(good, &["run", "job.toml", "--out", &out, "--threads", "1"]);
        // A stack that is larger than what a process can address fails before any thread runs. A limit on memory would
        // also meet threads that have started, which end the process in a way of their own.
        let poor = format!("RUST_MIN_STACK={} exec {SCREE} run job.toml --out {out} --threads 2", 1_u64 << 60);
        command.args([":", "-n", &(4 - good).to_string(), "bash", "-c", &poor]);
        let output = command.current_dir(folder.path()).output().unwrap();
        let words = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{words}");
        assert_eq!(words.matches("2 threads could not be started").count(), 1, "{good}: {words}");
        assert!(started.elapsed() < PATIENCE, "{:?}", started.elapsed());
    }
}
