//! `scree run`: from a job to a new run folder.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use scree_io::store;
use scree_partition::transport::Transport;

use super::check::refuse_bad_grains;
use super::cores::Placement;
use super::{Ending, agreed, resume, start_threads_of};
use crate::checkpoint;
use crate::error::Error;
use crate::log::Log;
use crate::output;
use crate::run::Options;
use crate::scenario::Job;
use crate::start::{self, Continuation};

/// Where runs go that are not told otherwise, below the current folder.
const RUNS: &str = "runs";

/// What the operator typed.
pub(super) struct Wanted<'a> {
    pub job: &'a Path,
    pub out: Option<PathBuf>,
    /// A run of this job that is there already is gone on with.
    pub go_on: bool,
    pub sets: &'a [String],
}

pub(super) fn command(wanted: &Wanted, placement: &Placement, transport: &dyn Transport) -> Ending {
    let (job, options, opening) = match prepare(wanted, placement.threads, transport) {
        Ok(prepared) => prepared,
        Err(error) => return Ending::Agreed(Err(error)),
    };
    if let Err(error) = start_threads_of(placement) {
        return Ending::Failed(error);
    }
    if opening == Opening::GoOn {
        return resume::go_on(&options.out, Continuation::default(), options.threads, transport);
    }
    match start::start(&job, &options, transport) {
        Ok(outcome) => Ending::Agreed(Ok(outcome)),
        Err(error) => Ending::Failed(error),
    }
}

/// Whether there is something to go on with.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Opening {
    Start,
    GoOn,
}

/// Rank 0 reads and checks the job; the others take the resolved text, so that no two ranks can mean different things.
pub(super) fn prepare(
    wanted: &Wanted,
    threads: usize,
    transport: &dyn Transport,
) -> Result<(Job, Options, Opening), Error> {
    let shared = agreed(transport, || {
        let (job, typed) = Job::load_typed(wanted.job, wanted.sets)?;
        refuse_bad_grains(&job, &typed)?;
        let (out, resolved) = (folder(&wanted.out, &job), job.to_toml());
        let opening = if wanted.go_on { opening(&out, &resolved)? } else { Opening::Start };
        if opening == Opening::Start {
            refuse_existing_run(&out)?;
        }
        Ok(if opening == Opening::Start { format!("{START}{resolved}") } else { format!("{GO_ON}{resolved}") })
    })?;
    let opening = if shared.starts_with(GO_ON) { Opening::GoOn } else { Opening::Start };
    let resolved = &shared[START.len_utf8()..];
    let job = Job::parse(resolved, &wanted.job.display().to_string(), &[])?;
    let out = folder(&wanted.out, &job);
    Ok((job, Options::new(out, threads), opening))
}

/// The opening as rank 0 tells it, ahead of the job.
const START: char = '0';
const GO_ON: char = '1';

/// Goes on with a run of the same job, and clears away one that has nothing to go on from.
fn opening(out: &Path, resolved: &str) -> Result<Opening, Error> {
    let scenario = out.join("scenario.toml");
    let there = match std::fs::read(&scenario) {
        // What is no text any more is another job.
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Opening::Start);
        }
        Err(error) => return Err(Error::User(format!("{}: {error}", scenario.display()))),
    };
    let shown = out.display();
    if there != resolved {
        let (old, new) = first_difference(&there, resolved);
        return Err(Error::User(format!(
            "{shown} holds a run of another job: it has `{old}` where this one has `{new}`. Start this one elsewhere with --out DIR, or go on with that one as it is by `scree resume {shown}`."
        )));
    }
    if has_checkpoint(out)? {
        return Ok(Opening::GoOn);
    }
    let log = Log::open(out)?;
    tracing::warn!("warning: {shown} holds a run that ended before its first checkpoint; it is started anew");
    // What makes the folder one of a run goes last: whoever ends in between leaves one that can be cleared again.
    let checkpoints = checkpoint::folder(out);
    // Of a first checkpoint that was never finished there may be a part.
    let _ = store::prune(&checkpoints, 1);
    match std::fs::remove_dir(&checkpoints) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            return Err(Error::User(format!(
                "{}: {error}. Look at what lies there, and remove the run with `rm -r {shown}`.",
                checkpoints.display()
            )));
        }
        _ => {}
    }
    // Of frames there may be further parts.
    let parts = std::fs::read_dir(out).into_iter().flatten().flatten().map(|entry| entry.path());
    let parts = parts.filter(|path| path.extension().is_some_and(|extension| extension == "vtkhdf"));
    let files = output::FILES.iter().map(|name| out.join(name)).flat_map(|path| [output::aside(&path), path]);
    for path in parts.chain(files) {
        if path.exists() {
            std::fs::remove_file(&path).map_err(|error| {
                Error::User(format!("{}: {error}. Remove the run with `rm -r {shown}`.", path.display()))
            })?;
        }
    }
    drop(log);
    // The folder is empty now, unless somebody has put something there.
    let _ = std::fs::remove_dir(out);
    Ok(Opening::Start)
}

/// The first lines that differ; jobs are written in one order.
fn first_difference<'a>(old: &'a str, new: &'a str) -> (&'a str, &'a str) {
    let (mut old, mut new) = (old.lines(), new.lines());
    loop {
        match (old.next(), new.next()) {
            (Some(a), Some(b)) if a == b => {}
            (a, b) => return (a.unwrap_or("nothing"), b.unwrap_or("nothing")),
        }
    }
}

/// Whether there is one, those that are kept for good among them; parts of one that was never finished are none.
fn has_checkpoint(out: &Path) -> Result<bool, Error> {
    let folder = checkpoint::folder(out);
    match folder.try_exists() {
        Ok(true) => Ok(!store::all(&folder).map_err(|error| Error::User(error.to_string()))?.is_empty()),
        Ok(false) => Ok(false),
        Err(error) => Err(Error::User(format!("{}: {error}", folder.display()))),
    }
}

fn folder(out: &Option<PathBuf>, job: &Job) -> PathBuf {
    match out {
        Some(out) => out.clone(),
        None => Path::new(RUNS).join(job.name()),
    }
}

fn refuse_existing_run(out: &Path) -> Result<(), Error> {
    let shown = out.display();
    let occupied = match std::fs::read_dir(out) {
        Ok(mut entries) => entries.next().is_some(),
        Err(_) => out.exists(),
    };
    if !occupied {
        return Ok(());
    }
    Err(Error::User(match (out.join("scenario.toml").exists(), has_checkpoint(out)?) {
        (true, true) => format!(
            "{shown} already holds a run, and a run is never overwritten. Go on with it by `scree resume {shown}`, or start a new one elsewhere with --out DIR."
        ),
        (true, false) => format!(
            "{shown} holds a run that ended before its first checkpoint, or is still on its way there. If it has ended, remove it with `rm -r {shown}`; or start a new one elsewhere with --out DIR."
        ),
        (false, _) => format!(
            "{shown} exists and is no run of scree, so nothing is written there. Choose another folder with --out DIR."
        ),
    }))
}
