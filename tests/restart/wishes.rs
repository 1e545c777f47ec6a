//! What operators wish of a run while it goes on or when it goes on again; whatever they wish, it ends in the same bits.

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, a_rank_of, scree, signal, turn, words};
use crate::queues::JOB;

/// Nothing here takes a tenth of this, unless a machine has much else to do.
const PATIENCE: Duration = Duration::from_secs(300);

/// A folder with a job of some seconds and a run of it that nobody has disturbed.
struct Desk {
    folder: tempfile::TempDir,
    digest: String,
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("job.toml"), JOB).unwrap();
        let mut desk = Self { folder, digest: String::new() };
        succeeded(&desk.ended(&["run", "job.toml", "--out", "reference"]));
        desk.digest = desk.digest_of("reference");
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, ranks: usize, arguments: &[&str]) -> Command {
        let arguments = [arguments, &["--threads", "1"]].concat();
        let mut command = match ranks {
            // Without a launcher.
            0 => Command::new(SCREE),
            ranks => scree(ranks, &arguments),
        };
        if ranks == 0 {
            command.args(&arguments);
        }
        command.current_dir(self.folder.path()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn ended(&self, arguments: &[&str]) -> Output {
        self.command(0, arguments).output().unwrap()
    }

    /// Starts a run and waits until it has so many rows of its series.
    fn started(&self, ranks: usize, arguments: &[&str], out: &str, rows: usize) -> Child {
        let child = self.command(ranks, arguments).spawn().unwrap();
        let since = Instant::now();
        let there =
            || std::fs::read_to_string(self.path(out).join("series.csv")).map_or(0, |text| text.lines().count());
        while there() <= rows {
            assert!(since.elapsed() < PATIENCE, "{out}: no rows");
            std::thread::sleep(Duration::from_millis(2));
        }
        child
    }

    fn digest_of(&self, run: &str) -> String {
        let output = Command::new(SCREE).args(["digest", run]).current_dir(self.folder.path()).output().unwrap();
        succeeded(&output);
        String::from_utf8(output.stdout).unwrap()
    }

    fn checkpoints(&self, run: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(run).join("checkpoints")).into_iter().flatten();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| name.ends_with(".h5"));
        names.sort();
        names
    }

    fn read(&self, run: &str, file: &str) -> String {
        std::fs::read_to_string(self.path(run).join(file)).unwrap()
    }

    /// The same state and the same curve as that of the run that nobody has disturbed.
    fn assert_same(&self, run: &str) {
        assert_eq!(self.digest_of(run), self.digest, "{run}: another state");
        assert!(self.read(run, "series.csv") == self.read("reference", "series.csv"), "{run}: another curve");
    }
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}", words(output));
}

#[test]
fn a_checkpoint_for_the_asking_and_on() {
    let _turn = turn();
    let desk = Desk::new();
    let child = desk.started(2, &["run", "job.toml", "--out", "asked"], "asked", 5);
    // One rank hears of it.
    signal(a_rank_of(child.id()), "USR1");
    let since = Instant::now();
    while desk.checkpoints("asked").is_empty() {
        assert!(since.elapsed() < PATIENCE, "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    succeeded(&child.wait_with_output().unwrap());
    desk.assert_same("asked");
}

#[test]
fn a_stop_file_ends_a_run_once() {
    let _turn = turn();
    let desk = Desk::new();
    let child = desk.started(2, &["run", "job.toml", "--out", "filed"], "filed", 3);
    std::fs::write(desk.path("filed/stop"), "").unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(4), "{}", words(&ended));
    assert!(words(&ended).contains("Stopped on request at step "), "{}", words(&ended));
    assert!(!desk.path("filed/stop").exists());
    succeeded(&desk.ended(&["resume", "filed"]));
    desk.assert_same("filed");
}

/// The end is within the limit, and comes as late as it may: not at once, and not by half.
#[test]
fn a_limit_of_time_is_kept_and_used() {
    let _turn = turn();
    let desk = Desk::new();
    let longer = ["run", "job.toml", "--out", "timed", "--set", "time.end=1", "--time-limit", "0:04"];
    let since = Instant::now();
    let ended = desk.command(2, &longer).output().unwrap();
    let took = since.elapsed();
    assert_eq!(ended.status.code(), Some(4), "{}", words(&ended));
    // The launcher takes some tenths of a second for itself.
    assert!(took > Duration::from_secs(2) && took < Duration::from_millis(5500), "{took:?}");
    assert!(!desk.checkpoints("timed").is_empty());
    let ended = desk.ended(&["run", "job.toml", "--out", "never", "--time-limit", "soon"]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(words(&ended).contains("\"soon\" is no time. Write hours:minutes:seconds"), "{}", words(&ended));
}

#[test]
fn a_second_interrupt_ends_at_once() {
    let _turn = turn();
    let desk = Desk::new();
    // In the making of a packing, which does not end between two steps that take long.
    let large = ["--set", "grains.count=40000", "--set", "cell.upper=[0.2, 0.2]", "--set", "packing.cache=other"];
    let mut child = desk.command(0, &[&["run", "job.toml", "--out", "twice"], &large[..]].concat()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    // By the shell itself, which starts no program between two of them; for so long that the run is on a core meanwhile,
    // since signals that wait together are one.
    let twice = format!("for i in {{1..5000}}; do kill -INT {} 2>/dev/null || exit 0; done", child.id());
    assert!(Command::new("bash").args(["-c", &twice]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// By the clock on the wall, and every so many for good.
#[test]
fn checkpoints_by_the_clock_change_nothing() {
    let _turn = turn();
    let desk = Desk::new();
    let often = [
        "--set",
        "output.checkpoint_wall_interval=0.1",
        "--set",
        "output.checkpoints_kept=4",
        "--set",
        "output.checkpoints_for_good=3",
    ];
    succeeded(&desk.command(2, &[&["run", "job.toml", "--out", "often"], &often[..]].concat()).output().unwrap());
    desk.assert_same("often");
    let found = desk.checkpoints("often");
    assert_eq!(found.len(), 4, "{found:?}");
    let good = std::fs::read_dir(desk.path("often/checkpoints/for_good")).unwrap().count();
    assert!(good > 1, "{good}");
    // The first of them is older than what is kept for a while, and can be exported.
    let steps = |folder: &str| {
        let entries = std::fs::read_dir(desk.path(folder)).unwrap().map(|entry| entry.unwrap().file_name());
        let step = |name: std::ffi::OsString| name.to_str()?.strip_prefix("step-")?.strip_suffix(".h5")?.parse().ok();
        entries.filter_map(step).min().unwrap()
    };
    let [first, kept]: [u64; 2] = ["often/checkpoints/for_good", "often/checkpoints"].map(steps);
    assert!(first < kept, "{first} {kept}");
    let at = (first as f64 * 0.4e-6).to_string();
    let export = ["export", "often", "--at", &at, "--grains", "first.csv"];
    succeeded(&Command::new(SCREE).args(export).current_dir(desk.folder.path()).output().unwrap());
}

/// By the count of steps, beside those of an interval.
#[test]
fn checkpoints_by_steps_come_when_they_are_due_and_change_nothing() {
    let _turn = turn();
    let desk = Desk::new();
    let often = [
        "--set",
        "output.checkpoint_steps=7000",
        "--set",
        "output.checkpoint_interval=0.016",
        "--set",
        "output.checkpoints_kept=99",
    ];
    succeeded(&desk.command(0, &[&["run", "job.toml", "--out", "steps"], &often[..]].concat()).output().unwrap());
    desk.assert_same("steps");
    let step_of = |name: &String| name.strip_prefix("step-")?.strip_suffix(".h5")?.parse::<u64>().ok();
    let steps: Vec<u64> = desk.checkpoints("steps").iter().map(|name| step_of(name).unwrap()).collect();
    let end = *steps.last().unwrap();
    let mut due: Vec<u64> = (1..=end).filter(|step| step % 7000 == 0 || step % 40_000 == 0).chain([end]).collect();
    due.dedup();
    assert_eq!(steps, due);
}

#[test]
fn a_run_goes_on_to_another_end_with_other_outputs() {
    let _turn = turn();
    let desk = Desk::new();
    // What is left to a default may follow from the end.
    let scenario = desk.read("reference", "scenario.toml");
    let interval = scenario.lines().find(|line| line.starts_with("frame_interval")).unwrap();
    let frames = format!("output.{}", interval.replace(' ', ""));
    succeeded(&desk.ended(&["run", "job.toml", "--out", "short", "--set", "time.end=0.02", "--set", &frames]));
    let ended = desk.ended(&["resume", "short", "--set", "contact.friction=0.4"]);
    assert_eq!(ended.status.code(), Some(2));
    let told = words(&ended);
    assert!(told.contains("with contact.friction from 0.5 to 0.4 this would be another run"), "{told}");
    assert!(told.contains("time.end") && told.contains("--force-branch NEW_DIR"), "{told}");

    // A crash at once: the new end is in a checkpoint already.
    let onward = ["resume", "short", "--set", "time.end=0.04", "--set", "output.checkpoints_kept=9"];
    let child = desk.started(0, &onward, "short", 120);
    signal(child.id(), "KILL");
    child.wait_with_output().unwrap();
    succeeded(&desk.ended(&["resume", "short"]));
    desk.assert_same("short");
    assert!(desk.read("short", "scenario.toml").contains("checkpoints_kept = 9"));

    // By hand nothing changes, and that is said.
    let edited = desk.read("short", "scenario.toml").replace("friction = 0.5", "friction = 0.3");
    std::fs::write(desk.path("short/scenario.toml"), edited).unwrap();
    let told = words(&desk.ended(&["resume", "short"]));
    assert!(told.contains("short/scenario.toml has been edited") && told.contains("done already"), "{told}");
}

#[test]
fn a_branch_is_a_run_of_its_own() {
    let _turn = turn();
    let desk = Desk::new();
    let stopped = ["run", "job.toml", "--out", "trunk", "--set", "time.end=0.02"];
    succeeded(&desk.ended(&stopped));
    let before = (desk.digest_of("trunk"), desk.read("trunk", "series.csv"));
    let branch = ["resume", "trunk", "--set", "time.end=0.04", "--force-branch"];
    succeeded(&desk.command(2, &[&branch[..], &["same"]].concat()).output().unwrap());
    let changed = ["other", "--set", "contact.friction=0.3"];
    succeeded(&desk.ended(&[&branch[..], &changed].concat()));
    assert_eq!((desk.digest_of("trunk"), desk.read("trunk", "series.csv")), before, "the trunk was touched");

    // With nothing changed it is the rest of the run that it comes from; otherwise it is not.
    let rows = |run: &str| desk.read(run, "series.csv").lines().skip(1).map(str::to_string).collect::<Vec<_>>();
    let (all, first) = (rows("reference"), rows("trunk").len());
    assert!(rows("same") == all[first..], "another curve");
    assert!(rows("other") != all[first..] && rows("other").len() == all.len() - first);
    assert!(desk.read("other", "scenario.toml").contains("friction = 0.3"));
    // What it has kept counts from where it begins.
    let kept = |run: &str| {
        let mut summary: serde_json::Value = serde_json::from_str(&desk.read(run, "summary.json")).unwrap();
        summary["conservation"].take()
    };
    let (trunk, other) = (kept("trunk"), kept("other"));
    assert_eq!((&trunk["since_step"], &other["since_step"]), (&0.into(), &50_000.into()));
    assert_eq!(trunk["momentum"]["end"], other["momentum"]["start"]);
    assert!(other["momentum"]["error"].as_f64().unwrap() < 1e-10, "{other:#}");
    let ended = desk.ended(&[&branch[..], &["other"]].concat());
    assert_eq!(ended.status.code(), Some(2));
    assert!(words(&ended).contains("already holds a run, and a run is never overwritten"), "{}", words(&ended));
}

/// It was found where a run was killed in its last moment, before anybody had seen its end.
#[test]
fn a_run_at_its_end_is_looked_at_and_tells_of_it() {
    let _turn = turn();
    let desk = Desk::new();
    let resumed = || desk.ended(&["resume", "reference"]);
    let (summary, series) = (desk.path("reference/summary.json"), desk.path("reference/series.csv"));
    let whole = std::fs::read(&series).unwrap();
    let told = words(&resumed());
    assert!(told.contains("this run is done already; nothing was changed"), "{told}");

    // Killed after its last checkpoint: what the summary holds is still to be told, once.
    std::fs::remove_file(&summary).unwrap();
    let told = words(&desk.command(2, &["resume", "reference"]).output().unwrap());
    assert!(told.contains("Done: 0 steps"), "{told}");
    assert!(std::fs::read(&series).unwrap() == whole, "another curve");
    assert!(std::fs::read_to_string(&summary).unwrap().contains("\"outcome\": \"done\""));
    assert!(words(&resumed()).contains("done already"));
    assert_eq!(desk.digest_of("reference"), desk.digest, "another state");
    let ended = desk.ended(&["resume", "reference", "--set", "time.end=0.03"]);
    assert_eq!(ended.status.code(), Some(2));
    assert!(words(&ended).contains("nothing is left to be done. Give a later end"), "{}", words(&ended));

    // Its outputs are what it wrote, or it says which are not.
    let mut other = whole.clone();
    let middle = other.len() / 2;
    other[middle] ^= 1;
    for damaged in [&whole[..middle], &other] {
        std::fs::write(&series, damaged).unwrap();
        let ended = resumed();
        assert!(ended.status.code() == Some(2) && words(&ended).contains("series.csv"), "{}", words(&ended));
    }
    std::fs::write(&series, &whole).unwrap();
    succeeded(&resumed());
}
