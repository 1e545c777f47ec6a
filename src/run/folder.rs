//! A run's folder and its one owner.
//!
//! ```text
//! RUN/run.lock        whose run it is and who writes it; held from before the packing to the end of the process
//! RUN/run.tmp/        files in the making, nowhere else: what a killed run has left there is nobody's
//! RUN/scenario.toml   the job; its first line names the run
//! RUN/run.msh         the mesh of a job that reads one
//! RUN/...             what a run writes, by the names of [`OURS`] and of frames
//! ```
//!
//! Whatever has another name is the operator's and is never touched.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, Write};
use std::path::{Component, Path, PathBuf};
use std::process;

use jiff::Timestamp;
use scree_io::column::State;
use scree_io::store;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::base::error::Error;
use crate::base::program::{self, host, now};
use crate::job::mpm::MESH_COPY;

const LOCK: &str = "run.lock";
const SCRATCH: &str = "run.tmp";
const SCENARIO: &str = "scenario.toml";
const STOP: &str = "stop";
const CHECKPOINTS: &str = "checkpoints";
const PACKING: &str = "packing.h5";
const SERIES: &str = "series.csv";
const LOG: &str = "log.jsonl";
/// What lay where at the end, for `scree plan`.
pub const LOAD: &str = "load.json";
/// Figures of a run.
pub const SUMMARY: &str = "summary.json";
/// Files of a run beside its lock and its frames.
const OURS: [&str; 8] = [PACKING, SERIES, LOG, SUMMARY, LOAD, SCENARIO, STOP, MESH_COPY];
/// Frames come in parts, `frames.vtkhdf`, `frames.2.vtkhdf` and so on.
const FRAMES: [&str; 2] = ["frames", "contacts"];
/// Files of frames of the RVE of a point that is followed, its name behind.
pub const GRAINS_OF: &str = "grains_of_";
/// The same of the contacts between these grains.
pub const CONTACTS_OF: &str = "contacts_of_";
/// Names that files in the making had in programs before this one, beside the files themselves.
const FORMER_ENDINGS: [&str; 2] = [".partial", ".tmp"];
/// What the first line of a scenario begins with.
const HEAD: &str = "# Run ";

/// 16 hex digits that tell a run from every other; nothing for a run of a program that gave none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunId(String);

impl RunId {
    fn fresh() -> Self {
        let mut noise = [0; 16];
        // Where there is no such device, time and process tell runs apart.
        let _ = File::open("/dev/urandom").and_then(|mut device| device.read_exact(&mut noise));
        let text = format!("{:?} {} {} {noise:?}", Timestamp::now(), process::id(), host());
        Self(Sha256::digest(text.as_bytes())[..8].iter().map(|byte| format!("{byte:02x}")).collect())
    }

    /// 16 hex digits, or nothing.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether the program gave one.
    pub fn is_known(&self) -> bool {
        !self.0.is_empty()
    }

    fn read(text: &str) -> Option<Self> {
        let is_one = text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        is_one.then(|| Self(text.to_string()))
    }
}

/// What stands in a lock file.
#[derive(Debug, Serialize, Deserialize)]
struct Owner {
    run: RunId,
    program: String,
    host: String,
    process: u32,
    since: String,
}

/// What a folder is, seen from outside.
#[derive(Debug, PartialEq, Eq)]
pub enum Standing {
    /// Not there, empty, or left by a run that ended before it had written its job.
    Free,
    /// A run without a checkpoint: its packing may be in the making.
    Begun,
    /// A run that can be gone on with.
    Resumable,
    /// Something else.
    Foreign,
}

/// A run's folder, which nobody else writes to while this is held.
#[derive(Debug)]
pub struct Folder {
    dir: PathBuf,
    id: RunId,
    /// Whether it was made for this run.
    is_new: bool,
    /// Locked until the process ends, however it ends.
    _lock: File,
}

/// The path of a run's folder without what a shell adds to it; refused where no folder can be.
pub fn settled(path: &Path) -> Result<PathBuf, Error> {
    // A name that ends in a slash is the same without it.
    let settled: PathBuf = path.components().filter(|part| *part != Component::CurDir).collect();
    let settled = if settled.as_os_str().is_empty() { PathBuf::from(".") } else { settled };
    let shown = settled.display();
    match (fs::symlink_metadata(&settled), fs::metadata(&settled)) {
        (Ok(link), Err(_)) if link.is_symlink() => Err(Error::User(format!(
            "{shown} is a link to a folder that is not there. Make that folder, or give another with --out DIR."
        ))),
        (_, Ok(about)) if !about.is_dir() => {
            Err(Error::User(format!("{shown} is a file, and a run needs a folder. Give another with --out DIR.")))
        }
        _ => Ok(settled),
    }
}

/// What the folder is. Nothing is written.
pub fn standing(dir: &Path) -> Result<Standing, Error> {
    let unreadable = |error: std::io::Error| Error::User(format!("{}: {error}", dir.display()));
    let entries = match fs::read_dir(dir) {
        Ok(entries) => entries,
        // Where there can be none, claiming it tells.
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Standing::Free);
        }
        Err(error) => return Err(unreadable(error)),
    };
    let mut names = Vec::new();
    for entry in entries {
        names.push(entry.map_err(unreadable)?.file_name());
    }
    let has = |name: &str| names.iter().any(|found| found == name);
    if names.is_empty() {
        return Ok(Standing::Free);
    }
    let checkpoints = dir.join(CHECKPOINTS);
    let kept = if checkpoints.is_dir() { store::all(&checkpoints) } else { Ok(Vec::new()) };
    let has_checkpoint = !kept.map_err(|error| Error::User(error.to_string()))?.is_empty();
    let is_locked = owner_of(dir).is_some();
    Ok(match (has(SCENARIO), is_locked, has_checkpoint) {
        // A checkpoint carries its job.
        (_, _, true) => Standing::Resumable,
        (true, _, false) => Standing::Begun,
        (false, true, false) => Standing::Free,
        (false, false, false) => Standing::Foreign,
    })
}

/// Who has taken the folder, now or at some time.
fn owner_of(dir: &Path) -> Option<Owner> {
    toml::from_str(&fs::read_to_string(dir.join(LOCK)).ok()?).ok()
}

/// The run that a folder is of, as its job says.
pub fn run_of(dir: &Path) -> RunId {
    let head = fs::read(scenario_file(dir)).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let named = head.ok().and_then(|text| {
        let line = text.lines().next()?.strip_prefix(HEAD)?;
        RunId::read(line.split(',').next()?)
    });
    named.unwrap_or_default()
}

/// A scenario without the line that names its run.
pub fn without_head(scenario: &str) -> &str {
    match scenario.split_once('\n') {
        Some((line, rest)) if line.starts_with(HEAD) => rest,
        _ => scenario,
    }
}

impl Folder {
    /// Takes a folder for a new run: one that is not there, is empty, or was left by a run that never wrote its job. The caller
    /// has looked at its [`standing`]. Made and locked before any work, so that what cannot be written to costs nothing.
    pub fn claim(dir: &Path) -> Result<Self, Error> {
        let refused = |error: std::io::Error| {
            Error::User(format!(
                "{}: cannot make the run's folder: {error}. Give another with --out DIR.",
                dir.display()
            ))
        };
        let is_new = !dir.exists();
        fs::create_dir_all(dir).map_err(refused)?;
        let folder = Self::lock(dir, RunId::fresh(), is_new)?;
        match standing(dir)? {
            Standing::Free => folder.clear()?,
            // Somebody was faster.
            _ => return Err(occupied(dir)?.unwrap_or_else(|| refused(ErrorKind::AlreadyExists.into()))),
        }
        fs::create_dir_all(folder.checkpoints()).map_err(refused)?;
        Ok(folder)
    }

    /// Takes the folder of a run to go on with it, or to begin it again.
    pub fn take(dir: &Path) -> Result<Self, Error> {
        refuse_links(dir)?;
        let named = run_of(dir);
        let known = if named.is_known() { named } else { owner_of(dir).map(|owner| owner.run).unwrap_or_default() };
        let folder = Self::lock(dir, known, false)?;
        folder.empty_scratch()?;
        // A wish of the time before.
        let stale = stop_file(dir);
        if stale.exists() {
            remove(&stale)?;
            tracing::warn!(
                "warning: {} was there from before and has been removed; make it again to stop this run",
                stale.display()
            );
        }
        Ok(folder)
    }

    /// Takes the lock and writes into it who has it.
    fn lock(dir: &Path, id: RunId, is_new: bool) -> Result<Self, Error> {
        let path = dir.join(LOCK);
        let refused = |error: std::io::Error| {
            Error::User(format!(
                "{}: {error}. A run must be able to write into its folder; check its owner and mode.",
                path.display()
            ))
        };
        let mut file =
            OpenOptions::new().create(true).truncate(false).read(true).write(true).open(&path).map_err(refused)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(busy(dir)),
            // Where a file system knows no locks there is nothing to hold.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let owner = Owner {
            run: id.clone(),
            program: program::identity().to_string(),
            host: host(),
            process: process::id(),
            since: now(),
        };
        let text = toml::to_string(&owner).map_err(|error| Error::Run(error.to_string()))?;
        file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(text.as_bytes())).map_err(refused)?;
        Ok(Self { dir: dir.to_path_buf(), id, is_new, _lock: file })
    }

    /// As the caller has given it.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Of the run in it; not known where the program that began it gave none.
    pub fn id(&self) -> &RunId {
        &self.id
    }

    /// The folder of checkpoints, which may not be there yet.
    pub fn checkpoints(&self) -> PathBuf {
        self.dir.join(CHECKPOINTS)
    }

    /// The folder of files in the making, which is made where it is not there.
    pub fn scratch(&self) -> Result<PathBuf, Error> {
        let scratch = self.dir.join(SCRATCH);
        fs::create_dir_all(&scratch).map_err(|error| failed(&scratch, &error))?;
        Ok(scratch)
    }

    /// Writes the job, under a line that names the run.
    pub fn write_job(&self, job: &str) -> Result<(), Error> {
        let named = if self.id.is_known() {
            format!("{HEAD}{}, by {}\n", self.id.as_str(), program::name())
        } else {
            String::new()
        };
        self.replace(SCENARIO, &(named + job))
    }

    /// Writes the packing that grains of a zone are taken from.
    pub fn write_packing(&self, state: &State) -> Result<(), Error> {
        let written = store::write_in(&self.scratch()?, &packing_file(&self.dir), state);
        written.map_err(|error| Error::Run(error.to_string()))
    }

    /// The same from another run.
    pub fn copy_packing(&self, from: &Path) -> Result<(), Error> {
        self.copy(from, PACKING)
    }

    /// Keeps the mesh of its job, so that the run goes on whatever becomes of the file.
    pub fn copy_mesh(&self, from: &Path) -> Result<(), Error> {
        self.copy(from, MESH_COPY)
    }

    fn copy(&self, from: &Path, name: &str) -> Result<(), Error> {
        let (path, aside) = (self.dir.join(name), self.scratch()?.join(name));
        let copied = fs::copy(from, &aside).and_then(|_| fs::rename(&aside, &path));
        copied.map_err(|error| failed(&path, &error))
    }

    /// Writes a small file as a whole: whoever reads it meanwhile has the old one, and whoever ends meanwhile leaves it.
    pub fn replace(&self, name: &str, text: &str) -> Result<(), Error> {
        let (path, aside) = (self.dir.join(name), self.scratch()?.join(name));
        fs::write(&aside, text).and_then(|()| fs::rename(&aside, &path)).map_err(|error| failed(&path, &error))
    }

    /// Results are never removed: a run writes its first checkpoint before its first row, so whatever has rows had checkpoints.
    pub fn refuse_results(&self) -> Result<(), Error> {
        let series = series_file(&self.dir);
        let rows = match File::open(&series) {
            // The first line is the header.
            Ok(file) => BufReader::new(file).split(b'\n').skip(1).count(),
            Err(_) => 0,
        };
        if rows == 0 && !self.dir.join(SUMMARY).exists() {
            return Ok(());
        }
        Err(Error::User(format!(
            "{0} has results ({rows} rows of {SERIES}) and no checkpoint, so this run cannot go on; to begin it anew would remove them. Restore {0}/{CHECKPOINTS} from a backup, or start its job elsewhere by `scree run {0}/{SCENARIO} --out DIR`.",
            self.dir.display()
        )))
    }

    /// Removes what a run has left that has come to no checkpoint, but for its job. What is not a run's by its name stays.
    pub fn clear_outputs(&self) -> Result<(), Error> {
        self.empty_scratch()?;
        let checkpoints = self.checkpoints();
        if checkpoints.is_dir() {
            store::prune(&checkpoints, u64::MAX, 1).map_err(|error| Error::User(error.to_string()))?;
            for (_, path) in store::all(&checkpoints).map_err(|error| Error::User(error.to_string()))? {
                remove(&path)?;
            }
        }
        let job = self.files_of_job();
        self.files()?.iter().filter(|path| !job.contains(path)).try_for_each(|path| remove(path))
    }

    /// The same with its job, which goes last: whoever ends in between leaves a run that can be begun again.
    fn clear(&self) -> Result<(), Error> {
        self.clear_outputs()?;
        self.files_of_job().iter().filter(|path| path.exists()).try_for_each(|path| remove(path))
    }

    /// What a run is begun from, the job last.
    fn files_of_job(&self) -> [PathBuf; 2] {
        [mesh_file(&self.dir), scenario_file(&self.dir)]
    }

    /// Leaves the folder as if there had been no run: one that was made for it goes, unless something else has come into it.
    pub fn abandon(self) -> Result<(), Error> {
        self.clear()?;
        // Empty ones go; what is in others is not ours.
        let _ = fs::remove_dir(self.checkpoints().join(store::FOR_GOOD));
        let _ = fs::remove_dir(self.checkpoints());
        remove(&self.dir.join(LOCK))?;
        if self.is_new {
            let _ = fs::remove_dir(&self.dir);
        }
        Ok(())
    }

    fn empty_scratch(&self) -> Result<(), Error> {
        let scratch = self.dir.join(SCRATCH);
        match fs::remove_dir_all(&scratch) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(failed(&scratch, &error)),
            _ => Ok(()),
        }
    }

    /// Files of a run that are there, those in the making of former programs among them.
    fn files(&self) -> Result<Vec<PathBuf>, Error> {
        let entries = fs::read_dir(&self.dir).map_err(|error| failed(&self.dir, &error))?;
        let named = entries.flatten().filter(|entry| entry.file_name().to_str().is_some_and(is_ours));
        Ok(named.map(|entry| entry.path()).filter(|path| !path.is_dir()).collect())
    }
}

/// A folder that does not outlive its use.
pub struct Scratch(pub PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is in the folder for such things.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Whether a path is that of a file which the run in its folder writes, or its checkpoints.
pub fn is_of_a_run(path: &Path) -> bool {
    let (dir, name) = (path.parent().unwrap_or(Path::new("")), path.file_name().and_then(|name| name.to_str()));
    let is_run = |dir: &Path| dir.join(SCENARIO).exists() || dir.join(LOCK).exists();
    let is_within = path.ancestors().skip(1).zip(path.ancestors().skip(2)).any(|(within, dir)| {
        let is_kept = |name: &str| within.file_name().is_some_and(|found| found == name);
        (is_kept(CHECKPOINTS) || is_kept(SCRATCH)) && is_run(dir)
    });
    is_within || is_run(dir) && name.is_some_and(|name| is_ours(name) || name == LOCK)
}

/// Whether a file of that name is one of a run's.
fn is_ours(name: &str) -> bool {
    let whole = FORMER_ENDINGS.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(name);
    OURS.contains(&whole) || is_frames(whole)
}

fn is_frames(name: &str) -> bool {
    let Some(stem) = name.strip_suffix(".vtkhdf") else { return false };
    let (first, part) = stem.split_once('.').map_or((stem, None), |(first, part)| (first, Some(part)));
    let is_of_rve =
        [GRAINS_OF, CONTACTS_OF].iter().any(|of| first.strip_prefix(of).is_some_and(|name| !name.is_empty()));
    let is_part = part.is_none_or(|number| number.parse::<u32>().is_ok_and(|number| number > 1));
    (FRAMES.contains(&first) || is_of_rve) && is_part
}

/// A run writes where its folder is and nowhere else: a link in the place of one of its files would lead it to somebody's file.
fn refuse_links(dir: &Path) -> Result<(), Error> {
    let entries = fs::read_dir(dir).map_err(|error| Error::User(format!("{}: {error}", dir.display())))?;
    let mut links: Vec<PathBuf> = entries
        .flatten()
        .filter(|entry| {
            let name = entry.file_name();
            let ours = |name: &str| is_ours(name) || [LOCK, SCRATCH, CHECKPOINTS].contains(&name);
            name.to_str().is_some_and(ours) && entry.file_type().is_ok_and(|kind| kind.is_symlink())
        })
        .map(|entry| entry.path())
        .collect();
    links.sort();
    let Some(link) = links.first() else { return Ok(()) };
    let target = fs::read_link(link).unwrap_or_default();
    Err(Error::User(format!(
        "{} is a link to {}, and a run that goes on would write there. Put the file or folder itself in its place.",
        link.display(),
        target.display()
    )))
}

/// Why a folder cannot take a new run; nothing where it can.
pub fn occupied(dir: &Path) -> Result<Option<Error>, Error> {
    let shown = dir.display();
    Ok(match standing(dir)? {
        Standing::Free => None,
        Standing::Resumable => Some(format!(
            "{shown} already holds a run, and a run is never overwritten. Go on with it by `scree resume {shown}`, or start a new one elsewhere with --out DIR."
        )),
        Standing::Begun => Some(format!(
            "{shown} holds a run that has no checkpoint yet. If it has ended, go on with it by `scree resume {shown}`; or start a new one elsewhere with --out DIR."
        )),
        Standing::Foreign => Some(format!(
            "{shown} exists and is no run of scree, so nothing is written there. Choose another folder with --out DIR."
        )),
    }
    .map(Error::User))
}

/// Whether a process writes the run in a folder; where a file system knows no locks nobody can tell.
pub fn is_held(dir: &Path) -> bool {
    // To be written to, or NFS has no lock to ask for.
    let lock = OpenOptions::new().read(true).write(true).open(dir.join(LOCK));
    lock.is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock)))
}

fn busy(dir: &Path) -> Error {
    let who = match owner_of(dir) {
        Some(Owner { program, host, process, since, .. }) => {
            format!("{} on {host}, process {process}, since {since}", program::name_in(&program))
        }
        None => "another scree".to_string(),
    };
    Error::User(format!(
        "{0}: another scree is writing this run: {who}. Wait until it has ended, or stop it by `touch {0}/stop`; `tail {0}/log.jsonl` shows how far it is.",
        dir.display()
    ))
}

fn remove(path: &Path) -> Result<(), Error> {
    fs::remove_file(path).map_err(|error| failed(path, &error))
}

fn failed(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Run(format!("{}: {error}; the run has stopped", path.display()))
}

/// The job of a run's folder.
pub fn scenario_file(dir: &Path) -> PathBuf {
    dir.join(SCENARIO)
}

/// The curve of a run's folder.
pub fn series_file(dir: &Path) -> PathBuf {
    dir.join(SERIES)
}

/// A run that finds it stops, with a checkpoint.
pub fn stop_file(dir: &Path) -> PathBuf {
    dir.join(STOP)
}

/// The packing that grains of a zone are taken from.
pub fn packing_file(dir: &Path) -> PathBuf {
    dir.join(PACKING)
}

/// The mesh that a run keeps of its job.
pub fn mesh_file(dir: &Path) -> PathBuf {
    dir.join(MESH_COPY)
}
