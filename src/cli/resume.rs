//! `scree resume`: on from the newest good checkpoint.

use std::path::Path;

use scree_partition::transport::Transport;

use super::cores::Placement;
use super::{Ending, agreed, start_threads_of};
use crate::base::error::Error;
use crate::run::Options;
use crate::run::folder::{Standing, settled, standing};
use crate::run::start::{self, Continuation};

pub(super) fn command(
    dir: &Path,
    continuation: Continuation,
    placement: &Placement,
    transport: &dyn Transport,
) -> Ending {
    let branch = continuation.branch.map(settled).transpose();
    let found = agreed(transport, || {
        refuse_no_run(dir)?;
        branch.as_ref().map_or_else(|error| Err(Error::User(error.to_string())), |_| Ok(()))?;
        Ok(match standing(dir)? {
            Standing::Begun if continuation.branch.is_some() || !continuation.sets.is_empty() => {
                return Err(Error::User(format!(
                    "{0} has no checkpoint yet, so there is nothing to change or to branch from. Go on with it by `scree resume {0}`, or change its job and start that.",
                    dir.display()
                )));
            }
            Standing::Begun => BEGIN.to_string(),
            _ => String::new(),
        })
    });
    let begins = match found {
        Ok(word) => word == BEGIN,
        Err(error) => return Ending::Agreed(Err(error)),
    };
    if let Err(error) = start_threads_of(placement) {
        return Ending::Failed(error);
    }
    let branch = branch.ok().flatten();
    match begins {
        true => start_again(dir, placement.threads, transport),
        false => go_on(dir, Continuation { branch: branch.as_deref(), ..continuation }, placement.threads, transport),
    }
}

/// Rank 0's word for a run that has not come to its first state.
const BEGIN: &str = "begin";

/// The run in a folder that holds one, to its end.
pub(super) fn go_on(dir: &Path, continuation: Continuation, threads: usize, transport: &dyn Transport) -> Ending {
    let options = Options::new(continuation.branch.unwrap_or(dir).to_path_buf(), threads);
    match start::resume(dir, continuation, &options, transport) {
        Ok(outcome) => Ending::Agreed(Ok(outcome)),
        Err(error) => Ending::Failed(error),
    }
}

/// The run of a folder from its first step on.
pub(super) fn start_again(dir: &Path, threads: usize, transport: &dyn Transport) -> Ending {
    match start::start_again(dir, &Options::new(dir.to_path_buf(), threads), transport) {
        Ok(outcome) => Ending::Agreed(Ok(outcome)),
        Err(error) => Ending::Failed(error),
    }
}

/// What is no run cannot be gone on with.
pub(super) fn refuse_no_run(dir: &Path) -> Result<(), Error> {
    let shown = dir.display();
    if !dir.is_dir() {
        return Err(Error::User(format!(
            "There is no folder {shown}. Give the folder of a run, for example runs/quickstart."
        )));
    }
    if !matches!(standing(dir)?, Standing::Begun | Standing::Resumable) {
        return Err(Error::User(format!(
            "{shown} holds no run: its scenario.toml is missing. Give the folder that `scree run` wrote, for example runs/quickstart."
        )));
    }
    Ok(())
}
