//! Nothing of a user's is ever lost: a run owns its folder and touches nothing else, whoever is killed leaves one that can go on,
//! and runs that want one packing share it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, finished, scree, signal, turn, words};
use crate::queues::JOB;
use crate::runs::copy_folder;
use crate::zones::restless;

/// Nothing here takes a tenth of this, unless a machine has much else to do.
const PATIENCE: Duration = Duration::from_secs(300);

/// A folder with a short job and a run of it that nobody has disturbed.
pub struct Desk {
    folder: tempfile::TempDir,
    digest: String,
}

impl Desk {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let short = JOB.replace("end = \"40 ms\"", "end = \"4 ms\"").replace("\"30 ms\"", "\"2 ms\"")
            + "frame_interval = \"1 ms\"\n";
        fs::write(folder.path().join("job.toml"), short).unwrap();
        let mut desk = Self { folder, digest: String::new() };
        desk.succeeded(&["run", "job.toml", "--out", "reference"]);
        desk.digest = desk.digest_of("reference");
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(SCREE);
        let threads: &[&str] = if ["run", "resume"].contains(&arguments[0]) { &["--threads", "1"] } else { &[] };
        command.args(arguments).args(threads).current_dir(self.folder.path());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn ended(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// What it said.
    pub fn succeeded(&self, arguments: &[&str]) -> String {
        let output = self.ended(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", words(&output));
        words(&output)
    }

    /// Why it was refused.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let output = self.ended(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", words(&output));
        words(&output)
    }

    pub fn digest_of(&self, run: &str) -> String {
        let output = Command::new(SCREE).args(["digest", run]).current_dir(self.folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The same state and the same curve as that of the run that nobody has disturbed.
    pub fn assert_same(&self, run: &str) {
        assert_eq!(self.digest_of(run), self.digest, "{run}: another state");
        let series = |run: &str| fs::read(self.path(run).join("series.csv")).unwrap();
        assert!(series(run) == series("reference"), "{run}: another curve");
    }

    fn wait_for(&self, what: &str, is_there: impl Fn() -> bool) {
        let since = Instant::now();
        while !is_there() {
            assert!(since.elapsed() < PATIENCE, "{what}: not there");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// All files below a folder with what is in them.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.push((path.clone(), fs::read(&path).unwrap()));
        }
    }
    found.sort();
    found
}

/// The folder of a run was once made aside, as `X.new`, and whatever had that name was removed.
#[test]
fn a_folder_beside_that_of_a_run_is_left_alone() {
    let desk = Desk::new();
    desk.succeeded(&["run", "job.toml", "--out", "x.new", "--set", "time.end=\"2 ms\""]);
    fs::write(desk.path("x.new/letter.txt"), "mine").unwrap();
    let before = contents(&desk.path("x.new"));
    desk.succeeded(&["run", "job.toml", "--out", "x"]);
    desk.assert_same("x");
    fs::remove_dir_all(desk.path("x")).unwrap();
    desk.succeeded(&["resume", "x.new", "--set", "time.end=\"4 ms\"", "--force-branch", "x"]);
    assert!(contents(&desk.path("x.new")) == before);
}

/// Once a file in the making, a request to stop or a letter in its folder kept a run from ever going on.
#[test]
fn a_run_that_ended_before_its_first_state_goes_on() {
    let desk = Desk::new();
    let leftovers: [&[&str]; 4] = [
        &["frames.vtkhdf.partial", "summary.json.tmp"],
        &["packing.h5.partial", "run.tmp/frames.vtkhdf", "run.tmp/step-000000000500.h5"],
        &["stop", "letter.txt", "frames.vtkhdf", "frames.2.vtkhdf", "contacts.vtkhdf", "series.csv", "log.jsonl"],
        &["checkpoints/step-000000000951.h5.partial"],
    ];
    let lines: [&[&str]; 2] = [&["run", "job.toml", "--out", "again", "--continue"], &["resume", "again"]];
    for (leftovers, line) in leftovers.iter().flat_map(|leftovers| lines.iter().map(move |line| (leftovers, line))) {
        let _ = fs::remove_dir_all(desk.path("again"));
        fs::create_dir_all(desk.path("again/checkpoints")).unwrap();
        fs::create_dir_all(desk.path("again/run.tmp")).unwrap();
        fs::copy(desk.path("reference/scenario.toml"), desk.path("again/scenario.toml")).unwrap();
        for name in leftovers.iter() {
            fs::write(desk.path("again").join(name), "half").unwrap();
        }
        desk.succeeded(line);
        desk.assert_same("again");
        let is_ours = |name: &&&str| !name.contains("letter");
        for name in leftovers.iter().filter(is_ours) {
            let path = desk.path("again").join(name);
            assert!(fs::read(&path).map_or(true, |bytes| bytes != b"half"), "{name} is left");
        }
        assert_eq!(leftovers.contains(&"letter.txt"), desk.path("again/letter.txt").exists());
    }
}

/// A run that has come to no other state goes on from its first: the frame of that is there already and is not written again.
#[test]
fn a_run_goes_on_from_its_first_state() {
    let desk = Desk::new();
    copy_folder(&desk.path("reference"), &desk.path("first"));
    for kept in fs::read_dir(desk.path("first/checkpoints")).unwrap().map(|kept| kept.unwrap().path()) {
        if kept.is_file() {
            fs::remove_file(kept).unwrap();
        }
    }
    desk.succeeded(&["resume", "first"]);
    desk.assert_same("first");
    let frames = |run: &str| scree_io::frames::read(&desk.path(run).join("frames.vtkhdf")).unwrap();
    assert!(frames("first") == frames("reference"));
}

/// Whoever removes checkpoints to save space, and asks for the run again by mistake, has its results as they were.
#[test]
fn a_run_without_its_checkpoints_keeps_its_results() {
    let desk = Desk::new();
    copy_folder(&desk.path("reference"), &desk.path("kept"));
    fs::remove_dir_all(desk.path("kept/checkpoints")).unwrap();
    let names = ["series.csv", "summary.json", "frames.vtkhdf", "log.jsonl", "scenario.toml"];
    let read = |name: &str| fs::read(desk.path("kept").join(name)).unwrap();
    let before = names.map(read);
    for line in [&["resume", "kept"][..], &["run", "job.toml", "--out", "kept", "--continue"]] {
        let said = desk.refused(line);
        assert!(said.contains("has results") && said.contains("--out DIR"), "{said}");
    }
    assert!(before == names.map(read));
}

/// Killed while its packing is made, at any moment: whoever comes next goes on with that, to the same bits.
#[test]
fn a_run_killed_in_its_packing_goes_on_to_the_same_bits() {
    let _turn = turn();
    let desk = Desk::new();
    let cache = |name: &str| format!("packing.cache=\"{}\"", desk.path(name).display());
    let often = "output.checkpoint_wall_interval=0.05";
    let whole = desk.succeeded(&["run", "job.toml", "--out", "whole", "--set", &cache("whole_cache"), "--set", often]);
    assert!(whole.contains("making a packing"), "{whole}");
    let packing = |cache: &str| {
        let mut kept = fs::read_dir(desk.path(cache)).unwrap().map(|entry| entry.unwrap().path());
        let file = kept.find(|path| path.extension().is_some_and(|extension| extension == "h5")).unwrap();
        scree_io::digest(&scree_io::store::read(&file).unwrap())
    };
    let wanted = packing("whole_cache");
    assert_eq!(fs::read_dir(desk.path("whole_cache")).unwrap().count(), 1, "files in the making are left");
    let mut went_on = 0;
    for (number, name) in ["KILL", "TERM", "USR2", "KILL"].iter().enumerate() {
        let (out, other) = (format!("out_{number}"), format!("cache_{number}"));
        let line = |ranks: usize| {
            let arguments = [
                "run",
                "job.toml",
                "--out",
                &out,
                "--continue",
                "--threads",
                "1",
                "--set",
                &cache(&other),
                "--set",
                often,
            ];
            let mut command = scree(ranks, &arguments);
            command.current_dir(desk.folder.path());
            command
        };
        let saved = || {
            let makings = fs::read_dir(desk.path(&other)).into_iter().flatten().flatten();
            makings.map(|entry| entry.path().join("progress.h5")).any(|progress| progress.exists())
        };
        let mut child = line(1).spawn().unwrap();
        desk.wait_for("a saved packing", || saved() || desk.path(&out).join("series.csv").exists());
        std::thread::sleep(Duration::from_millis(40 * number as u64));
        end(&mut child, name);
        let told = words(&finished(child));
        if *name != "KILL" && told.contains("Stopped on request while the packing was made") {
            assert!(told.contains(&format!("`scree resume {out}` goes on")), "{told}");
        }
        let told = words(&finished(line(2).spawn().unwrap()));
        went_on += usize::from(told.contains("going on with a packing in the making"));
        assert_eq!(packing(&other), wanted, "{name}: another packing");
        assert_eq!(desk.digest_of(&out), desk.digest_of("whole"), "{name}: another state");
        assert_eq!(fs::read_dir(desk.path(&other)).unwrap().count(), 1, "files in the making are left");
    }
    assert!(went_on >= 2, "packings were made anew: {went_on}");
}

/// The piece that a specimen is cut from was once saved after every step, a hundred times slower than the steps themselves.
#[test]
fn a_piece_in_the_making_is_saved_as_often_as_a_run() {
    let _turn = turn();
    let desk = Desk::new();
    fs::write(desk.path("pieces.toml"), restless(4e-3)).unwrap();
    let cache = desk.path("pieces");
    let set = format!("packing.cache=\"{}\"", cache.display());
    let mut child = desk.command(&["run", "pieces.toml", "--out", "pieces_run", "--set", &set]).spawn().unwrap();
    let entries = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_made = |path: PathBuf| path.extension().is_some_and(|extension| extension == "h5");
    let begun = Instant::now();
    while !entries(&cache).any(is_made) {
        assert!(begun.elapsed() < PATIENCE && child.try_wait().unwrap().is_none(), "no packing");
        let saved = entries(&cache).flat_map(|making| entries(&making).collect::<Vec<_>>());
        let saved: Vec<PathBuf> = saved.filter(|path| path.ends_with("progress.h5")).collect();
        assert_eq!(saved, Vec::<PathBuf>::new(), "after {:?}, within checkpoint_wall_interval", begun.elapsed());
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    finished(child);
}

/// The ranks of mpirun are told, and mpirun with them where that is the end.
fn end(child: &mut Child, name: &str) {
    let ranks = fs::read_to_string(format!("/proc/{0}/task/{0}/children", child.id())).unwrap_or_default();
    for rank in ranks.split_whitespace() {
        let _ = Command::new("kill").args([&format!("-{name}"), rank]).stderr(Stdio::null()).status();
    }
}

/// A limit of time holds while a packing is made, too.
#[test]
fn a_packing_is_limited_by_time() {
    let _turn = turn();
    let desk = Desk::new();
    let cache = format!("packing.cache=\"{}\"", desk.path("other").display());
    let large = ["--set", "grains.count=20000", "--set", "cell.upper=[0.14, 0.14]", "--set", &cache];
    let line = [&["run", "job.toml", "--out", "limited", "--time-limit", "0:05"], &large[..]].concat();
    let since = Instant::now();
    let ended = desk.ended(&line);
    assert_eq!(ended.status.code(), Some(4), "{}", words(&ended));
    assert!(since.elapsed() < Duration::from_secs(7), "{:?}", since.elapsed());
    let told = words(&ended);
    assert!(told.contains("compressing: step ") && told.contains("(goal 1.0e-2)"), "no word of how far it is: {told}");
    let ended = desk.ended(&["resume", "limited", "--time-limit", "0:03"]);
    assert!(words(&ended).contains("going on with a packing in the making"), "{}", words(&ended));
}

/// Files in the making had one name for all processes, and runs that started together died after the packing.
#[test]
fn runs_that_start_together_share_a_packing() {
    let _turn = turn();
    let desk = Desk::new();
    let cache = format!("packing.cache=\"{}\"", desk.path("shared").display());
    let start = |number: usize| {
        let out = format!("together_{number}");
        desk.command(&["run", "job.toml", "--out", &out, "--set", &cache]).spawn().unwrap()
    };
    let children: Vec<Child> = (0..6).map(start).collect();
    let told: Vec<String> = children.into_iter().map(|child| words(&finished(child))).collect();
    let made = told.iter().filter(|told| told.contains("making a packing")).count();
    assert_eq!(made, 1, "{told:#?}");
    for number in 0..6 {
        assert_eq!(desk.digest_of(&format!("together_{number}")), desk.digest_of("together_0"));
    }
}

#[test]
fn a_damaged_packing_of_the_cache_is_made_again() {
    let desk = Desk::new();
    let packing = fs::read_dir(desk.path("cache")).unwrap().next().unwrap().unwrap().path();
    let whole = fs::read(&packing).unwrap();
    for number in 0..3 {
        let mut bytes = whole.clone();
        match number {
            0 => bytes.truncate(whole.len() / 2),
            1 => bytes[whole.len() / 2] ^= 4,
            _ => bytes.clear(),
        }
        fs::write(&packing, bytes).unwrap();
        let out = format!("damaged_{number}");
        let told = desk.succeeded(&["run", "job.toml", "--out", &out]);
        assert!(told.contains("it is made again"), "{told}");
        desk.assert_same(&out);
    }
}

#[test]
fn a_cache_that_cannot_be_written_to_is_told_before_the_packing() {
    let desk = Desk::new();
    fs::write(desk.path("file"), "").unwrap();
    for cache in ["/proc/scree", "file/cache"] {
        let set = format!("packing.cache=\"{cache}\"");
        let told = desk.refused(&["run", "job.toml", "--out", "nowhere", "--set", &set]);
        assert!(told.contains("packings cannot be kept there") && told.contains("packing.cache"), "{told}");
        assert!(!told.contains("making a packing") && !desk.path("nowhere").exists(), "{told}");
    }
}

/// As a shell completes them, and by links; what can be no folder is refused before any work, and nothing is left of it.
#[test]
fn a_path_is_settled_before_the_packing() {
    let desk = Desk::new();
    fs::create_dir_all(desk.path("disk/empty")).unwrap();
    std::os::unix::fs::symlink("disk/empty", desk.path("link")).unwrap();
    for out in ["runs/x/", "./runs/./y", "link"] {
        desk.succeeded(&["run", "job.toml", "--out", out]);
        desk.assert_same(out);
    }
    desk.assert_same("disk/empty");
    // The current folder, where it is empty.
    fs::create_dir(desk.path("here")).unwrap();
    let cache = format!("packing.cache=\"{}\"", desk.path("cache").display());
    let mut here = desk.command(&["run", "../job.toml", "--out", ".", "--set", &cache]);
    let ended = here.current_dir(desk.path("here")).output().unwrap();
    assert!(ended.status.success(), "{}", words(&ended));
    desk.assert_same("here");

    std::os::unix::fs::symlink("disk/gone", desk.path("dangling")).unwrap();
    fs::write(desk.path("file"), "mine").unwrap();
    for (out, why) in [
        ("dangling", "is a link to a folder that is not there"),
        ("file", "is a file, and a run needs a folder"),
        (".", "is no run of scree, so nothing is written there"),
        ("reference/", "already holds a run"),
    ] {
        let cache = "packing.cache=\"unused\"";
        let told = desk.refused(&["run", "job.toml", "--out", out, "--set", cache]);
        assert!(told.contains(why) && !told.contains("making a packing"), "{out}: {told}");
        assert!(!desk.path("unused").exists() && !desk.path("disk/gone").exists());
    }
    assert_eq!(fs::read_to_string(desk.path("file")).unwrap(), "mine");
}

/// A job whose packing cannot be made leaves no folder behind, and leaves one that was there as it was.
#[test]
fn a_run_that_is_refused_in_its_packing_leaves_nothing() {
    let desk = Desk::new();
    let cannot = ["--set", "packing.fraction=0.5", "--set", "packing.cache=\"other\""];
    let told = desk.refused(&[&["run", "job.toml", "--out", "none"], &cannot[..]].concat());
    assert!(told.contains("is less than compression to"), "{told}");
    assert!(!desk.path("none").exists());
    fs::create_dir(desk.path("empty")).unwrap();
    desk.refused(&[&["run", "job.toml", "--out", "empty"], &cannot[..]].concat());
    assert_eq!(fs::read_dir(desk.path("empty")).unwrap().count(), 0);
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let _turn = turn();
    let desk = Desk::new();
    let long = ["run", "job.toml", "--out", "held", "--set", "time.end=10"];
    let child = desk.command(&long).spawn().unwrap();
    desk.wait_for("a row", || {
        fs::read_to_string(desk.path("held/series.csv")).is_ok_and(|text| text.lines().count() > 2)
    });
    for line in [&["resume", "held"][..], &[&long[..], &["--continue"]].concat()] {
        let told = desk.refused(line);
        assert!(told.contains("another scree is writing this run: scree ") && told.contains("process "), "{told}");
        assert!(told.contains("`touch held/stop`"), "{told}");
    }
    fs::write(desk.path("held/stop"), "").unwrap();
    assert_eq!(finished(child).status.code(), Some(4));
    // A request of the time before is not one of now.
    fs::write(desk.path("held/stop"), "").unwrap();
    let child = desk.command(&["resume", "held"]).spawn().unwrap();
    let rows = || fs::read_to_string(desk.path("held/series.csv")).unwrap().lines().count();
    let before = rows();
    desk.wait_for("more rows", || rows() > before + 3);
    assert!(!desk.path("held/stop").exists());
    signal(child.id(), "TERM");
    let ended = finished(child);
    assert!(words(&ended).contains("was there from before and has been removed"), "{}", words(&ended));
}

/// A link in the place of one of its files would lead a run to somebody's file.
#[test]
fn a_run_does_not_follow_links_out_of_its_folder() {
    let desk = Desk::new();
    fs::write(desk.path("precious.csv"), "mine").unwrap();
    for name in ["series.csv", "log.jsonl", "summary.json", "frames.vtkhdf", "stop", "run.lock", "checkpoints"] {
        desk.succeeded(&["run", "job.toml", "--out", "linked", "--set", "time.end=\"2 ms\""]);
        let file = desk.path("linked").join(name);
        if file.is_dir() {
            fs::rename(&file, desk.path("elsewhere")).unwrap();
            std::os::unix::fs::symlink("../elsewhere", &file).unwrap();
        } else {
            let _ = fs::remove_file(&file);
            std::os::unix::fs::symlink("../precious.csv", &file).unwrap();
        }
        let told = desk.refused(&["resume", "linked", "--set", "time.end=\"4 ms\""]);
        assert!(told.contains(&format!("linked/{name} is a link to ")), "{told}");
        assert_eq!(fs::read_to_string(desk.path("precious.csv")).unwrap(), "mine");
        fs::remove_dir_all(desk.path("linked")).unwrap();
    }
}

/// What a report and an export write takes the place of nothing that is somebody's.
#[test]
fn a_report_and_an_export_leave_what_is_there() {
    let desk = Desk::new();
    fs::write(desk.path("mine.csv"), "mine").unwrap();
    let export = |file: &str, more: &[&str]| desk.ended(&[&["export", "reference", "--grains", file], more].concat());
    let told = words(&export("mine.csv", &[]));
    assert!(told.contains("mine.csv is there already") && told.contains("--overwrite"), "{told}");
    assert_eq!(fs::read_to_string(desk.path("mine.csv")).unwrap(), "mine");
    assert!(export("mine.csv", &["--overwrite"]).status.success());
    let before = contents(&desk.path("reference"));
    for line in [
        &["export", "reference", "--grains", "reference/series.csv", "--overwrite"][..],
        &["export", "reference", "--contacts", "reference/scenario.toml", "--overwrite"],
        &["export", "reference", "--lammps-dump", "reference/checkpoints/dump", "--overwrite"],
        &["report", "reference", "--out", "reference/scenario.toml"],
        &["report", "reference", "--out", "reference/frames.vtkhdf"],
    ] {
        let told = desk.refused(line);
        assert!(told.contains("is a file of the run in that folder"), "{told}");
    }
    for file in ["job.toml", "mine.csv"] {
        let job = fs::read(desk.path(file)).unwrap();
        let told = desk.refused(&["report", "reference", "--out", file]);
        assert!(told.contains(&format!("{file} is there already and was not written by scree")), "{told}");
        assert!(fs::read(desk.path(file)).unwrap() == job);
    }
    assert!(contents(&desk.path("reference")) == before);
    desk.succeeded(&["report", "reference", "--out", "page.html"]);
    desk.succeeded(&["report", "reference", "--out", "page.html"]);
    desk.succeeded(&["report", "reference"]);
    desk.succeeded(&["report", "reference"]);
}

/// Checkpoints, series and logs of another run are refused by the names of both.
#[test]
fn a_checkpoint_is_that_of_its_run() {
    let desk = Desk::new();
    let half = ["--set", "time.end=\"2 ms\""];
    let run = |out: &str| {
        desk.succeeded(&[&["run", "job.toml", "--out", out], &half[..]].concat());
        let head = fs::read_to_string(desk.path(out).join("scenario.toml")).unwrap();
        head.strip_prefix("# Run ").unwrap()[..16].to_string()
    };
    let [one, other] = ["one", "other"].map(run);
    assert_ne!(one, other);
    let go_on = ["resume", "one", "--set", "time.end=\"4 ms\""];
    let newest = "checkpoints/step-000000005000.h5";
    for file in [newest, "log.jsonl"] {
        let (ours, theirs) = (desk.path("one").join(file), desk.path("other").join(file));
        let kept = fs::read(&ours).unwrap();
        fs::copy(&theirs, &ours).unwrap();
        let told = desk.refused(&go_on);
        assert!(told.contains(&other) && told.contains(&one) && told.contains(file), "{told}");
        fs::write(&ours, kept).unwrap();
    }
    desk.succeeded(&go_on);
    desk.assert_same("one");
}
