//! `scree resume`: on from the newest good checkpoint.

use std::path::Path;

use scree_partition::transport::Transport;

use super::cores::Placement;
use super::{Ending, agreed, start_threads_of};
use crate::error::Error;
use crate::run::Options;
use crate::start::{self, Continuation};

pub(super) fn command(
    dir: &Path,
    continuation: Continuation,
    placement: &Placement,
    transport: &dyn Transport,
) -> Ending {
    let found = agreed(transport, || {
        refuse_no_run(dir)?;
        Ok(String::new())
    });
    if let Err(error) = found {
        return Ending::Agreed(Err(error));
    }
    if let Err(error) = start_threads_of(placement) {
        return Ending::Failed(error);
    }
    go_on(dir, continuation, placement.threads, transport)
}

/// The run in a folder that holds one, to its end.
pub(super) fn go_on(dir: &Path, continuation: Continuation, threads: usize, transport: &dyn Transport) -> Ending {
    let options = Options::new(continuation.branch.unwrap_or(dir).to_path_buf(), threads);
    match start::resume(dir, continuation, &options, transport) {
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
    if !dir.join("scenario.toml").is_file() {
        return Err(Error::User(format!(
            "{shown} holds no run: its scenario.toml is missing. Give the folder that `scree run` wrote, for example runs/quickstart."
        )));
    }
    Ok(())
}
