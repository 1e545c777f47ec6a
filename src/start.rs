//! From a job to its experiment: the kind of job, its space and its contact law are chosen here, once per run.

use std::path::Path;

use scree_partition::Transport;

use crate::assembly;
use crate::checkpoint::{self, Snapshot};
use crate::error::Error;
use crate::law::contact::{ContactLaw, ForAnyLaw, with_law_of};
use crate::planar_shear;
use crate::run::{Options, Outcome};
use crate::scenario::Job;
use crate::space::{Plane, Solid};
use crate::transfer;

/// Runs a job from its start.
pub fn start(job: &Job, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    with_law_of(job.contact(), Start { job, options, transport })
}

/// Continues a run from its newest good checkpoint, on any number of ranks and threads.
pub fn resume(dir: &Path, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    let read = if transport.rank() == 0 { checkpoint::latest_state(dir).map(Some) } else { Ok(None) };
    let state = transfer::agree(transport, read)?.map(|(_, state)| state);
    let text = state.as_ref().map(checkpoint::scenario_of).transpose();
    let text = transfer::agree(transport, text)?.unwrap_or_default();
    let text = String::from_utf8_lossy(&transport.broadcast(text.into_bytes())).into_owned();
    let job = Job::parse(&text, &dir.join("scenario.toml").display().to_string(), &[])?;
    with_law_of(job.contact(), Resume { job: &job, state, options, transport })
}

struct Start<'a> {
    job: &'a Job,
    options: &'a Options,
    transport: &'a dyn Transport,
}

impl ForAnyLaw for Start<'_> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let (options, transport) = (self.options, self.transport);
        match self.job {
            Job::Shear(scenario) => planar_shear::start::<C>(scenario, options, transport),
            Job::Assembly(job) if job.cell.dimension == 2 => assembly::start::<Plane, C>(job, options, transport),
            Job::Assembly(job) => assembly::start::<Solid, C>(job, options, transport),
        }
    }
}

struct Resume<'a> {
    job: &'a Job,
    /// On rank 0.
    state: Option<scree_io::column::State>,
    options: &'a Options,
    transport: &'a dyn Transport,
}

impl ForAnyLaw for Resume<'_> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, transport } = self;
        match job {
            Job::Shear(scenario) => {
                let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
                planar_shear::resume::<C>(scenario, snapshot, options, transport)
            }
            Job::Assembly(job) if job.cell.dimension == 2 => {
                let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
                assembly::resume::<Plane, C>(job, snapshot, options, transport)
            }
            Job::Assembly(job) => {
                let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
                assembly::resume::<Solid, C>(job, snapshot, options, transport)
            }
        }
    }
}
