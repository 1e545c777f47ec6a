//! `scree run`: from a job to a new run folder.

use std::path::{Path, PathBuf};

use scree_partition::transport::Transport;

use super::check::{doubts, refuse_bad_grains};
use super::cores::Placement;
use super::{Ending, agreed, resume, start_threads_of};
use crate::base::error::Error;
use crate::job::Job;
use crate::run::Options;
use crate::run::folder::{Standing, occupied, scenario_file, settled, standing, without_head};
use crate::run::start::{self, Continuation};

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
    match opening {
        Opening::GoOn => return resume::go_on(&options.out, Continuation::default(), options.threads, transport),
        Opening::StartAgain => return resume::start_again(&options.out, options.threads, transport),
        Opening::Start => {}
    }
    match start::start(&job, &options, transport) {
        Ok(outcome) => Ending::Agreed(Ok(outcome)),
        Err(error) => Ending::Failed(error),
    }
}

/// What there is to be done with the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Opening {
    Start,
    StartAgain,
    GoOn,
}

impl Opening {
    /// What stands for it ahead of the job that rank 0 tells.
    fn letter(self) -> char {
        match self {
            Self::Start => 's',
            Self::StartAgain => 'a',
            Self::GoOn => 'g',
        }
    }
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
        let (out, resolved) = (settled(&folder(&wanted.out, &job))?, job.to_toml());
        let opening = match wanted.go_on {
            true => opening(&out, &resolved)?,
            false => occupied(&out)?.map_or(Ok(Opening::Start), Err)?,
        };
        if opening != Opening::GoOn {
            doubts(&job).iter().for_each(|doubt| tracing::warn!("warning: {doubt}"));
        }
        Ok(format!("{}{}\n{resolved}", opening.letter(), out.display()))
    })?;
    let (head, resolved) = shared.split_once('\n').unwrap_or_default();
    let job = Job::parse(resolved, &wanted.job.display().to_string(), &[])?;
    let opening = [Opening::Start, Opening::StartAgain, Opening::GoOn];
    let opening = opening.into_iter().find(|opening| head.starts_with(opening.letter())).unwrap_or(Opening::Start);
    Ok((job, Options::new(PathBuf::from(&head[1..]), threads), opening))
}

/// A run of the same job is gone on with, from its first step where it has come to no checkpoint.
pub(super) fn opening(out: &Path, resolved: &str) -> Result<Opening, Error> {
    let opening = match standing(out)? {
        Standing::Free | Standing::Foreign => return occupied(out)?.map_or(Ok(Opening::Start), Err),
        Standing::Begun => Opening::StartAgain,
        Standing::Resumable => Opening::GoOn,
    };
    // What is no text any more is another job.
    let there = std::fs::read(scenario_file(out)).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let shown = out.display();
    match there {
        Ok(there) if meaning(&there, out) != resolved => {
            let there = meaning(&there, out);
            let (old, new) = first_difference(&there, resolved);
            Err(Error::User(format!(
                "{shown} holds a run of another job: it has `{old}` where this one has `{new}`. Start this one elsewhere with --out DIR, or go on with that one as it is by `scree resume {shown}`."
            )))
        }
        // Its checkpoints have the job.
        Ok(_) | Err(_) => Ok(opening),
    }
}

/// A resolved job as this program would write it: one that an older program wrote has no line for what came later.
fn meaning(text: &str, folder: &Path) -> String {
    let file = scenario_file(folder).display().to_string();
    Job::parse(text, &file, &[]).map_or_else(|_| without_head(text).to_string(), |job| job.to_toml())
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

fn folder(out: &Option<PathBuf>, job: &Job) -> PathBuf {
    match out {
        Some(out) => out.clone(),
        None => Path::new(RUNS).join(job.name()),
    }
}
