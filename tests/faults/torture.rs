//! Runs of every kind that are killed again and again, at any moment and inside of their writing too, in their packings and with
//! nobody to read what they say, whose files are cut short or have a byte flipped between their lives, and which are taken up on
//! other numbers of ranks. They end in the same state and with the same curve as those that nobody disturbed, or say what is wrong
//! with which file; they never hang, never end wrong, and never leave a folder that cannot go on.
//!
//! `SCREE_TORTURE_SECONDS` says for how long, `SCREE_TORTURE_SEED` begins at that life's dice again, and `SCREE_TORTURE_JOB` names
//! the only job to be tortured. A torture that fails tells of its lives since the last end and leaves its folder.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::mpirun::{SCREE, finished, launching, turn, words};
use crate::runs::copy_folder;
use crate::zones::restless;

const SECONDS_DEFAULT: u64 = 60;
/// No life lasts so long.
const PATIENCE: Duration = Duration::from_secs(240);
/// How long MPI may take to be up, and how long a launcher may take to see that one of its processes is gone.
const YOUNG: Duration = Duration::from_secs(3);
const LAUNCHER_PATIENCE: Duration = Duration::from_secs(20);
/// Files of a run that are damaged between lives; what stands beside them is made anew or not read.
const FILES: [&str; 6] = ["series.csv", "frames.vtkhdf", "log.jsonl", "summary.json", "scenario.toml", "run.lock"];
const QUICKSTART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/quickstart.toml");

/// Spheres that are compressed and sheared.
const SPHERES: &str = r#"name = "spheres"
[cell]
space = "solid"
upper = ["8 mm", "8 mm", "8 mm"]
velocity_gradient = [[0, "20 1/s", 0], [0, 0, 0], [0, 0, 0]]
[grains]
density = 2500
count = 300
distribution = "uniform"
diameter_min = "0.9 mm"
diameter_max = "1.1 mm"
[packing]
preparation = "compress"
stress = "100 kPa"
energy_ratio_max = 1e-2
cache = "cache"
[contact]
law = "hertz_mindlin"
shear_modulus = "290 MPa"
poisson_ratio = 0.15
friction = 0.5
damping_normal = 0.01
damping_tangential = 0.01
[time]
step = "0.8 us"
end = "4 ms"
[output]
series_interval = "0.1 ms"
frame_interval = "0.2 ms"
checkpoint_interval = "2 ms"
contact_frames = true
"#;

/// A column of points that collapses.
const COLUMN: &str = r#"name = "column"
[grid]
space = "plane"
upper = ["40 cm", "16 cm"]
cell = "1 cm"
[material]
law = "critical_drucker_prager"
density = 1500
bulk_modulus = "1 MPa"
shear_modulus = "0.6 MPa"
friction_angle_critical = "0.4 rad"
dilation_angle = "0 rad"
cohesion = 0
[[region]]
shape = "box"
lower = [0, 0]
upper = ["10 cm", "12 cm"]
[gravity]
acceleration = [0, "-9.81 m/s2"]
[[boundary]]
face = "y_lower"
kind = "friction"
coefficient = 0.4
[time]
end = "120 ms"
[output]
series_interval = "1 ms"
frame_interval = "2 ms"
checkpoint_interval = "20 ms"
"#;

/// The jobs, each with what is set over it.
fn jobs() -> Vec<(&'static str, String, Vec<&'static str>)> {
    let quickstart = std::fs::read_to_string(QUICKSTART).unwrap();
    vec![
        // To some steps after enrichment.
        (
            "quickstart",
            quickstart,
            vec!["output.frame_interval=0.01", "loading.strain_end=0.025", "packing.cache=\"cache\""],
        ),
        ("zones", restless(3.84e-3), vec!["output.frame_interval=2e-4", "packing.cache=\"cache\""]),
        ("column", COLUMN.to_string(), vec![]),
        ("spheres", SPHERES.to_string(), vec![]),
    ]
}

/// Throws dice as SplitMix64 does.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }
}

#[derive(Default, Debug)]
struct Tally {
    lives: u64,
    kills: u64,
    kills_in_writing: u64,
    /// Launchers that hung, since one of their processes was killed before MPI was up: that is Open MPI's doing.
    hung_launchers: u64,
    damages: u64,
    /// Damaged checkpoints that were told of and passed over.
    passed_over: u64,
    refusals: u64,
    ends: u64,
}

struct Torture {
    folder: tempfile::TempDir,
    /// What has become of the run since the last end, a line for each life and each damage.
    story: Vec<String>,
    sets: Vec<&'static str>,
    dice: Dice,
    tally: Tally,
    digest: String,
}

/// What becomes of the words of a life.
#[derive(Clone, Copy, PartialEq)]
enum Words {
    Read,
    Nowhere,
}

/// When a life ends, but for its own end.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Death {
    /// After so long.
    At(Duration),
    /// Once a file in one of the folders for files in the making has changed, the cache's or the run's, for the so-manieth time.
    Writing(u64),
    Never,
}

impl Torture {
    fn new(seed: u64, job: &str, sets: &[&'static str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("job.toml"), job).unwrap();
        let sets = sets.to_vec();
        let (story, tally, digest) = (Vec::new(), Tally::default(), String::new());
        let mut torture = Self { folder, story, sets, dice: Dice(seed), tally, digest };
        let ended = finished(torture.start(2, "reference", Words::Read));
        assert!(ended.status.success(), "{}", words(&ended));
        torture.digest = torture.digest_of("reference");
        torture
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `--continue` starts a run, goes on with it, and begins again where it ended before its first checkpoint.
    fn start(&self, ranks: usize, out: &str, read: Words) -> Child {
        let mut line = format!(
            "exec mpirun --oversubscribe --bind-to none -n {ranks} {SCREE} run job.toml --out {out} --threads 1 --continue --set output.checkpoint_wall_interval=0.05"
        );
        self.sets.iter().for_each(|set| line += &format!(" --set '{set}'"));
        if read == Words::Nowhere {
            line += " 2>/dev/full";
        }
        let mut command = Command::new("bash");
        command.args(["-c", &line]).current_dir(self.folder.path()).stdin(Stdio::null());
        launching(&mut command);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn digest_of(&self, run: &str) -> String {
        let output = Command::new(SCREE).args(["digest", run]).current_dir(self.folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// A life, to its end or to its death; what it said, and whether it ended by itself. The last is not disturbed.
    fn live(&mut self, is_last: bool) -> (Output, bool, Words) {
        let ranks = 1 + self.dice.below(4) as usize;
        let read = if self.dice.below(4) == 0 { Words::Nowhere } else { Words::Read };
        // Most die young: within start-up, reading, the first steps, the first checkpoints; or in the midst of writing.
        let death = match self.dice.below(3) {
            _ if is_last => Death::Never,
            0 => Death::Writing(1 + self.dice.below(12)),
            _ => Death::At(Duration::from_millis(100 + self.dice.below(2 + self.dice.0 % 4000))),
        };
        let read = if is_last { Words::Read } else { read };
        let mut child = self.start(ranks, "tortured", read);
        self.tally.lives += 1;
        self.story.push(format!("{ranks} ranks, {death:?}"));
        let one = self.dice.below(2) == 0;
        let since = Instant::now();
        let mut watch = Watch::of(self.folder.path());
        loop {
            if child.try_wait().unwrap().is_some() {
                let output = finished(child);
                self.story.push(format!("ended with {:?}", output.status.code()));
                return (output, true, read);
            }
            let is_over = match death {
                Death::At(young) => since.elapsed() >= young,
                Death::Writing(number) => watch.look() >= number,
                Death::Never => false,
            };
            if is_over {
                break;
            }
            assert!(since.elapsed() < PATIENCE, "no end after {:?}", since.elapsed());
            if !matches!(death, Death::Writing(_)) {
                std::thread::sleep(Duration::from_millis(2));
            }
        }
        let processes = ranks_of(child.id());
        let victims = if one { &processes[..processes.len().min(1)] } else { &processes[..] };
        victims.iter().for_each(|process| kill(*process));
        if !one || victims.is_empty() {
            kill(child.id());
        }
        self.tally.kills += 1;
        self.tally.kills_in_writing += u64::from(matches!(death, Death::Writing(_)));
        let killed = Instant::now();
        while since.elapsed() < YOUNG + LAUNCHER_PATIENCE && child.try_wait().unwrap().is_none() {
            if killed.elapsed() > LAUNCHER_PATIENCE && killed - since < YOUNG {
                self.story.push("its launcher hung".into());
                self.tally.hung_launchers += 1;
                kill(child.id());
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let output = finished(child);
        // Whoever lost its launcher has lost its sense, and is not to write on.
        processes.iter().for_each(|process| kill(*process));
        while processes.iter().any(|process| is_alive(*process)) {
            std::thread::sleep(Duration::from_millis(5));
        }
        (output, false, read)
    }

    /// Cuts a file of the run or flips one of its bytes, and says which.
    fn damage(&mut self) -> Option<String> {
        let run = self.path("tortured");
        let mut files: Vec<PathBuf> = FILES.iter().map(|name| run.join(name)).collect();
        let checkpoints = std::fs::read_dir(run.join("checkpoints")).into_iter().flatten();
        let mut checkpoints: Vec<PathBuf> = checkpoints.map(|entry| entry.unwrap().path()).collect();
        // Those that are kept for good have a folder of their own.
        checkpoints.retain(|path| path.is_file());
        checkpoints.sort();
        // The newest counts most.
        files.extend(checkpoints.iter().rev().take(2).cloned());
        files.extend(checkpoints.last().cloned());
        files.retain(|file| file.metadata().is_ok_and(|about| about.len() > 0));
        if files.is_empty() {
            return None;
        }
        let file = &files[self.dice.below(files.len() as u64) as usize];
        let mut bytes = std::fs::read(file).unwrap();
        let at = self.dice.below(bytes.len() as u64) as usize;
        match self.dice.below(2) {
            0 => bytes.truncate(at),
            _ => bytes[at] ^= 1 << self.dice.below(8),
        }
        std::fs::write(file, bytes).unwrap();
        self.tally.damages += 1;
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        self.story.push(format!("{name} damaged at byte {at}"));
        Some(name)
    }

    /// A folder as it is, under another name.
    fn copy(&self, from: &str, to: &str) {
        let _ = std::fs::remove_dir_all(self.path(to));
        copy_folder(&self.path(from), &self.path(to));
    }

    /// A finished run is what the reference is.
    fn look_at_the_end(&mut self, was_damaged: bool) {
        assert_eq!(self.digest_of("tortured"), self.digest, "another state");
        let read = |run: &str, name: &str| std::fs::read(self.path(run).join(name)).unwrap();
        let curves = ["tortured", "reference"].map(|run| read(run, "series.csv"));
        let lines = curves.each_ref().map(|curve| curve.split(|byte| *byte == b'\n').count());
        let first = curves[0].iter().zip(&curves[1]).position(|(found, wanted)| found != wanted);
        assert!(curves[0] == curves[1], "another curve: {lines:?} lines, another byte at {first:?}");
        let frames = |run: &str| scree_io::frames::read(&self.path(run).join("frames.vtkhdf"));
        match frames("tortured") {
            Ok(found) => assert!(found == frames("reference").unwrap(), "other frames"),
            // A byte of an old frame: whoever reads it is told.
            Err(error) => assert!(was_damaged && error.is_damage(), "{error}"),
        }
        for line in String::from_utf8_lossy(&read("tortured", "log.jsonl")).lines() {
            assert!(was_damaged || serde_json::from_str::<serde_json::Value>(line).is_ok(), "log: {line}");
        }
        self.tally.ends += 1;
    }

    /// From nothing to an end; after `until` nothing is killed and damaged any more.
    fn run(&mut self, until: Instant) {
        let _ = std::fs::remove_dir_all(self.path("tortured"));
        self.story.clear();
        // With a packing of its own to be killed in, or with that of the run before.
        if self.dice.below(2) == 0 {
            self.story.push("a packing of its own".into());
            let _ = std::fs::remove_dir_all(self.path("cache"));
        }
        // Files that have been damaged since the copy of the run that is whole.
        let mut damaged: Vec<String> = Vec::new();
        loop {
            let (output, ended, read) = self.live(Instant::now() >= until);
            let said = words(&output);
            self.tally.passed_over += u64::from(said.contains("; going back to "));
            if ended {
                match output.status.code() {
                    Some(0) => return self.look_at_the_end(!damaged.is_empty()),
                    Some(2 | 3) if !damaged.is_empty() => {
                        let named = |name: &String| said.contains(name.as_str());
                        let named = damaged.iter().any(named) || said.contains("holds a run of another job");
                        assert!(named || read == Words::Nowhere, "not a word of {damaged:?}: {said}");
                        self.story.push("taken from its copy".into());
                        self.copy("whole", "tortured");
                        damaged.clear();
                        self.tally.refusals += 1;
                    }
                    code => panic!("{code:?} after damage to {damaged:?}: {said}"),
                }
            } else if self.dice.below(3) == 0 && self.path("tortured").is_dir() {
                if damaged.is_empty() {
                    self.story.push("copied".into());
                    self.copy("tortured", "whole");
                }
                damaged.extend(self.damage());
            }
        }
    }
}

/// Whoever looks for what went wrong finds the folder as it was.
impl Drop for Torture {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.folder.disable_cleanup(true);
            println!("left in {}: {:#?}", self.folder.path().display(), self.story);
        }
    }
}

/// Looks at what is in the making: files below `run.tmp` and the cache's `*.making`.
struct Watch {
    folders: [PathBuf; 2],
    seen: Vec<(PathBuf, u64, Option<std::time::SystemTime>)>,
    changes: u64,
}

impl Watch {
    fn of(folder: &Path) -> Self {
        Self { folders: ["tortured/run.tmp", "cache"].map(|name| folder.join(name)), seen: Vec::new(), changes: 0 }
    }

    /// How often anything has changed so far.
    fn look(&mut self) -> u64 {
        let list = |folder: &Path| -> Vec<PathBuf> {
            std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
        };
        let [run, cache] = &self.folders;
        let mut files = list(run);
        list(cache).iter().for_each(|within| files.extend(list(within)));
        files.sort();
        let about = |path: PathBuf| {
            let about = path.metadata();
            let (length, time) = about.map_or((0, None), |about| (about.len(), about.modified().ok()));
            (path, length, time)
        };
        let now: Vec<_> = files.into_iter().map(about).collect();
        if now != self.seen {
            self.seen = now;
            self.changes += 1;
        }
        self.changes
    }
}

fn ranks_of(mpirun: u32) -> Vec<u32> {
    let children = std::fs::read_to_string(format!("/proc/{mpirun}/task/{mpirun}/children")).unwrap_or_default();
    children.split_whitespace().filter_map(|process| process.parse().ok()).collect()
}

/// It may be gone.
fn kill(process: u32) {
    let _ = Command::new("kill").args(["-KILL", &process.to_string()]).stderr(Stdio::null()).status();
}

fn is_alive(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    status.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim_start().starts_with('Z'))
}

#[test]
fn a_run_survives_or_says_why_not() {
    let _turn = turn();
    let number = |name: &str, default: u64| std::env::var(name).map_or(default, |text| text.parse().unwrap());
    let (seconds, seed) = (number("SCREE_TORTURE_SECONDS", SECONDS_DEFAULT), number("SCREE_TORTURE_SEED", 1));
    let only = std::env::var("SCREE_TORTURE_JOB");
    let mut jobs = jobs();
    jobs.retain(|(name, ..)| only.as_ref().map_or(true, |only| only == name));
    assert!(!jobs.is_empty(), "no job has the name {only:?}");
    for (name, job, sets) in &jobs {
        let mut torture = Torture::new(seed, job, sets);
        let until = Instant::now() + Duration::from_secs(seconds) / jobs.len() as u32;
        while Instant::now() < until {
            println!("{name}: dice {}", torture.dice.0);
            torture.run(until);
        }
        println!("{name}: {:?}", torture.tally);
        assert!(torture.tally.kills > 0 && torture.tally.ends > 0, "{name}: {:?}", torture.tally);
    }
}
