//! A continuum of material points on a grid (`[grid]` in a job).

use scree_io::column::State;
use scree_partition::Transport;

use crate::error::Error;
use crate::run::{Options, Outcome};
use crate::scenario::Mpm;
use crate::space::Space;

/// Runs a job from its start.
pub fn start<S: Space>(job: &Mpm, _: &Options, _: &dyn Transport) -> Result<Outcome, Error> {
    Err(no_engine(job))
}

/// Continues a run from a state that rank 0 holds.
pub fn resume<S: Space>(job: &Mpm, _: Option<State>, _: &Options, _: &dyn Transport) -> Result<Outcome, Error> {
    Err(no_engine(job))
}

fn no_engine(job: &Mpm) -> Error {
    Error::User(format!(
        "{}: this build of scree checks continua on a grid and has no engine to run them. Take a newer build.",
        job.name
    ))
}
