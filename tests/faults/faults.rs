//! Disks that fill up and folders that go away under a run: it ends within seconds, once, with the file and the reason, its last
//! good checkpoint is as it was, and it goes on from there to the same end as a run that nobody has disturbed.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, launching, scree, turn, words};
use crate::queues::JOB;

/// Nothing here takes a tenth of this, unless a machine has much else to do.
const PATIENCE: Duration = Duration::from_secs(300);
const OFTEN: [&str; 4] = ["--set", "output.checkpoint_interval=2e-3", "--set", "output.frame_interval=4e-3"];

fn ended(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(SCREE).args(arguments).args(["--threads", "1"]).current_dir(folder).output().unwrap()
}

fn digest(folder: &Path, run: &str) -> String {
    let output = Command::new(SCREE).args(["digest", run]).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", words(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// A folder with the job and its undisturbed run, whose outputs come often, with more of it changed.
fn desk(more: &[&str]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
    let reference = [&["run", "job.toml", "--out", "reference"], &OFTEN[..], more].concat();
    let output = ended(folder.path(), &reference);
    assert!(output.status.success(), "{}", words(&output));
    let digest = digest(folder.path(), "reference");
    (folder, digest)
}

/// It stopped itself for this reason, said it once, and goes on to the same end when there is room again.
fn stopped_and_goes_on(folder: &Path, output: &Output, reason: &[&str; 2], wanted: &str) {
    let told = words(output);
    assert_eq!(output.status.code(), Some(3), "{told}");
    let [file, why] = reason;
    assert!(told.contains(file) && told.matches(why).count() == 1, "{told}");
    assert!(told.contains("`scree resume disturbed` goes on from it"), "{told}");
    let output = ended(folder, &["resume", "disturbed"]);
    assert!(output.status.success(), "{}", words(&output));
    assert_eq!(digest(folder, "disturbed"), wanted, "another state");
    let series = |run: &str| std::fs::read(folder.join(run).join("series.csv")).unwrap();
    assert!(series("disturbed") == series("reference"), "another curve");
}

/// Rows and frames beyond what a file may hold: as on a full disk, but for the reason.
#[test]
fn a_full_disk_ends_a_run_at_its_last_checkpoint() {
    let _turn = turn();
    let rows = ["--set", "output.series_interval=2e-6", "--set", "output.frame_interval=1"];
    for (more, file) in [(&rows[..], "series.csv: "), (&[][..], "frames.vtkhdf")] {
        let (folder, wanted) = desk(more);
        let size = std::fs::metadata(folder.path().join("reference").join(file.trim_end_matches(": "))).unwrap().len();
        // Two thirds of what the run wants.
        let limited = format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", size * 2 / 3 / 1024);
        let run = [&["run", "job.toml", "--out", "disturbed"], &OFTEN[..], more, &["--threads", "1"]].concat();
        let mut command = Command::new("bash");
        command.args(["-c", &limited, SCREE]).args(run).current_dir(folder.path());
        let output = command.output().unwrap();
        stopped_and_goes_on(folder.path(), &output, &[file, "File too large"], &wanted);
    }
}

/// The folder of checkpoints is gone, and something else is in its place; ranks of both kinds end.
#[test]
fn a_folder_that_goes_away_ends_all_ranks() {
    let _turn = turn();
    let (folder, wanted) = desk(&[]);
    let run = [&["run", "job.toml", "--out", "disturbed"], &OFTEN[..], &["--threads", "1"]].concat();
    let mut command = scree(2, &run);
    command.current_dir(folder.path()).stdin(Stdio::null());
    let child = command.spawn().unwrap();
    let (since, checkpoints) = (Instant::now(), folder.path().join("disturbed/checkpoints"));
    let there =
        || std::fs::read_dir(&checkpoints).is_ok_and(|mut kept| kept.any(|entry| whole(&entry.unwrap().path())));
    while !there() {
        assert!(since.elapsed() < PATIENCE, "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    let away = folder.path().join("away");
    std::fs::rename(&checkpoints, &away).unwrap();
    std::fs::write(&checkpoints, "in its place").unwrap();
    let since = Instant::now();
    let output = child.wait_with_output().unwrap();
    assert!(since.elapsed() < Duration::from_secs(60), "{:?}", since.elapsed());
    let told = words(&output);
    assert_eq!(output.status.code(), Some(3), "{told}");
    // Found gone, or something else in its place.
    assert_eq!(told.lines().filter(|line| line.contains("disturbed/checkpoints")).count(), 1, "{told}");
    std::fs::remove_file(&checkpoints).unwrap();
    std::fs::rename(&away, &checkpoints).unwrap();
    let output = ended(folder.path(), &["resume", "disturbed"]);
    assert!(output.status.success(), "{}", words(&output));
    assert_eq!(digest(folder.path(), "disturbed"), wanted, "another state");
}

fn whole(checkpoint: &Path) -> bool {
    checkpoint.extension().is_some_and(|extension| extension == "h5")
}

/// A folder that may not be written to, and one that cannot be made, are refused before any work.
#[test]
fn a_folder_that_cannot_be_written_to_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
    std::fs::write(folder.path().join("file"), "").unwrap();
    // Whoever runs this may write anywhere but here.
    for out in ["/proc/scree", "file/run"] {
        let output = ended(folder.path(), &["run", "job.toml", "--out", out]);
        let told = words(&output);
        assert!(output.status.code() == Some(2) && told.contains(out) && told.contains("--out"), "{told}");
    }
}

/// A disk of so many kB that fills up, and is then given room, with the run in `disk/run`.
const SMALL_DISK: &str = r#"
set -e
mkdir -p disk
mount -t tmpfs -o size="$1"k tmpfs disk
shift
code=0
"$SCREE" run job.toml --out disk/run --threads 1 "$@" || code=$?
echo "ended with $code"
mount -o remount,size=64m disk
"$SCREE" resume disk/run --threads 1
rm -rf disturbed
cp -r disk/run disturbed
"#;

/// Runs a script in which file systems may be mounted.
fn with_mounts(folder: &Path, script: &str, arguments: &[&str]) -> std::io::Result<Output> {
    let mut command = Command::new("unshare");
    command.args(["--map-root-user", "--mount", "bash", "-c", script, "bash"]).args(arguments);
    launching(&mut command);
    command.env("SCREE", SCREE).current_dir(folder).stdin(Stdio::null()).output()
}

/// Whether file systems can be mounted. Where they cannot, whoever starts the tests must say that he knows it.
fn may_mount() -> bool {
    if std::env::var_os("SCREE_TEST_NO_MOUNTS").is_some() {
        println!("skipped, as SCREE_TEST_NO_MOUNTS says");
        return false;
    }
    let folder = tempfile::tempdir().unwrap();
    let tried = with_mounts(folder.path(), "mkdir may && mount -t tmpfs tmpfs may", &[]);
    let why = match &tried {
        Ok(output) if output.status.success() => return true,
        Ok(output) => words(output),
        Err(error) => error.to_string(),
    };
    panic!(
        "unshare cannot mount file systems here, which this test needs; with SCREE_TEST_NO_MOUNTS=1 it is skipped: {why}"
    )
}

#[test]
fn a_small_disk_ends_a_run_at_its_last_checkpoint() {
    let _turn = turn();
    if !may_mount() {
        return;
    }
    let rows = ["output.series_interval=2e-6", "output.frame_interval=1", "output.checkpoint_interval=2e-3"];
    let frames = ["output.frame_interval=1e-4", "output.checkpoint_interval=2e-3"];
    let checkpoints = ["output.checkpoint_interval=1e-3", "output.frame_interval=1", "output.checkpoints_kept=1000"];
    let cases =
        [("series.csv", 1700, &rows[..]), ("frames.vtkhdf", 1200, &frames), ("run.tmp/step-", 1200, &checkpoints)];
    for (file, size, sets) in cases {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
        let reference = ended(folder.path(), &[&["run", "job.toml", "--out", "reference"], &sets[..]].concat());
        assert!(reference.status.success(), "{}", words(&reference));
        let wanted = digest(folder.path(), "reference");
        let size = size.to_string();
        let arguments = [&[size.as_str()], &sets[..]].concat();
        let output = with_mounts(folder.path(), SMALL_DISK, &arguments).unwrap();
        let told = words(&output);
        assert!(output.status.success() && told.contains("ended with 3"), "{file}: {told}");
        assert!(told.contains(&format!("disk/run/{file}")), "{file}: {told}");
        assert_eq!(told.matches("No space left on device").count(), 1, "{file}: {told}");
        assert!(told.contains("`scree resume disk/run` goes on from it"), "{file}: {told}");
        assert_eq!(digest(folder.path(), "disturbed"), wanted, "{file}: another state");
        let series = |run: &str| std::fs::read(folder.path().join(run).join("series.csv")).unwrap();
        assert!(series("disturbed") == series("reference"), "{file}: another curve");
    }
}

/// Rank 1 sees an empty folder where rank 0 has the run, and one that may not be written to.
const OTHER_FOLDER: &str = r#"
set -e
mkdir -p run
mpirun --oversubscribe -n 1 "$SCREE" "$@" : -n 1 unshare --mount bash -c 'mount -t tmpfs -o ro tmpfs "$0" && exec "$SCREE" "$@"' "$PWD/run" "$@"
"#;

/// Only rank 0 reads and writes: a folder that other ranks have not got is no fault.
#[test]
fn a_folder_that_only_the_first_rank_has_is_enough() {
    let _turn = turn();
    if !may_mount() {
        return;
    }
    let (folder, wanted) = desk(&[]);
    let run = [&["run", "job.toml", "--out", "run/disturbed"], &OFTEN[..], &["--threads", "1"]].concat();
    let stopped = [&run[..], &["--set", "time.end=20 ms"]].concat();
    let resumed = ["resume", "run/disturbed", "--set", "time.end=40 ms", "--threads", "1"];
    for arguments in [&stopped[..], &resumed] {
        let output = with_mounts(folder.path(), OTHER_FOLDER, arguments).unwrap();
        assert!(output.status.success(), "{}", words(&output));
    }
    assert_eq!(digest(folder.path(), "run/disturbed"), wanted, "another state");
}
