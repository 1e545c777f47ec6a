//! `scree run`: from a job to a new run folder.

use std::path::{Path, PathBuf};

use scree_partition::transport::Transport;

use super::check::refuse_missing_file;
use super::{Ending, agreed, start_threads};
use crate::assembly;
use crate::checkpoint;
use crate::error::Error;
use crate::grain_file;
use crate::run::Options;
use crate::scenario::{Job, Scenario};
use crate::space::Components;
use crate::start;

/// Where runs go that are not told otherwise, below the current folder.
const RUNS: &str = "runs";

pub(super) fn command(
    job: &Path,
    out: Option<PathBuf>,
    threads: usize,
    sets: &[String],
    transport: &dyn Transport,
) -> Ending {
    let (job, options) = match prepare(job, out, threads, sets, transport) {
        Ok(prepared) => prepared,
        Err(error) => return Ending::Agreed(Err(error)),
    };
    if let Err(error) = start_threads(threads) {
        return Ending::Failed(error);
    }
    match start::start(&job, &options, transport) {
        Ok(outcome) => Ending::Agreed(Ok(outcome)),
        Err(error) => Ending::Failed(error),
    }
}

/// Rank 0 reads and checks the job; the others take the resolved text, so that no two ranks can mean different things.
pub(super) fn prepare(
    job: &Path,
    out: Option<PathBuf>,
    threads: usize,
    sets: &[String],
    transport: &dyn Transport,
) -> Result<(Job, Options), Error> {
    let resolved = agreed(transport, || {
        let job = Job::load(job, sets)?;
        match &job {
            Job::Shear(scenario) => refuse_bad_grains(scenario)?,
            Job::Assembly(job) => {
                refuse_missing_file(job)?;
                assembly::refuse_bad(job)?;
            }
            Job::Mpm(_) => {}
        }
        refuse_existing_run(&folder(&out, &job))?;
        Ok(job.to_toml())
    })?;
    let job = Job::parse(&resolved, &job.display().to_string(), &[])?;
    let out = folder(&out, &job);
    Ok((job, Options { out, threads }))
}

fn folder(out: &Option<PathBuf>, job: &Job) -> PathBuf {
    match out {
        Some(out) => out.clone(),
        None => Path::new(RUNS).join(job.name()),
    }
}

/// The file that grains are read from must exist and hold good grains before anything is started.
pub(super) fn refuse_bad_grains(scenario: &Scenario) -> Result<(), Error> {
    match &scenario.grains.file {
        Some(file) if !file.is_file() => Err(Error::User(format!(
            "grains.file: there is no file {}. Give a path that starts from the job's folder, or remove the key to make a packing.",
            file.display()
        ))),
        Some(file) => grain_file::read::<Components<f64, 1>>(scenario, file).map(|_| ()),
        None => Ok(()),
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
    let unfinished = std::fs::read_dir(checkpoint::folder(out)).map_or(true, |mut kept| kept.next().is_none());
    Err(Error::User(match (out.join("scenario.toml").exists(), unfinished) {
        (true, false) => format!(
            "{shown} already holds a run, and a run is never overwritten. Go on with it by `scree resume {shown}`, or start a new one elsewhere with --out DIR."
        ),
        (true, true) => format!(
            "{shown} holds a run that ended before its first checkpoint, or is still on its way there. If it has ended, remove it with `rm -r {shown}`; or start a new one elsewhere with --out DIR."
        ),
        (false, _) => format!(
            "{shown} exists and is no run of scree, so nothing is written there. Choose another folder with --out DIR."
        ),
    }))
}
