//! From a job to its experiment: the kind of job, its space and its contact law are chosen here, once per run.

use std::path::Path;

use scree_io::column::State;
use scree_partition::Transport;

use crate::assembly;
use crate::checkpoint::{self, Snapshot};
use crate::continuum;
use crate::error::Error;
use crate::law::contact::{ContactLaw, ForAnyLaw, with_law_of};
use crate::planar_shear;
use crate::run::{Options, Outcome};
use crate::scenario::{Assembly, Job, Scenario};
use crate::space::{Plane, Solid};
use crate::stop;
use crate::transfer;

/// Runs a job from its start.
pub fn start(job: &Job, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let ended = match job {
        Job::Shear(job) => with_law_of(&job.contact, Start { job, options, transport }),
        Job::Assembly(job) => with_law_of(&job.contact, Start { job, options, transport }),
        Job::Mpm(job) if job.grid.dimension == 2 => continuum::start::<Plane>(job, options, transport),
        Job::Mpm(job) => continuum::start::<Solid>(job, options, transport),
    };
    match ended {
        Err(Error::Stopped(step)) => Ok(Outcome::Stopped(format!(
            "Stopped on request while the packing was made, after {step} steps of it. Nothing of it is kept, and {} was not made: start the run again.",
            options.out.display()
        ))),
        ended => ended,
    }
}

/// Continues a run from its newest good checkpoint, on any number of ranks and threads.
pub fn resume(dir: &Path, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let read = if transport.rank() == 0 { checkpoint::latest_state(dir).map(Some) } else { Ok(None) };
    let state = transfer::agree(transport, read)?.map(|(_, state)| state);
    let text = state.as_ref().map(checkpoint::scenario_of).transpose();
    let text = transfer::agree(transport, text)?.unwrap_or_default();
    let text = String::from_utf8_lossy(&transport.broadcast(text.into_bytes())).into_owned();
    match &Job::parse(&text, &dir.join("scenario.toml").display().to_string(), &[])? {
        Job::Shear(job) => with_law_of(&job.contact, Resume { job, state, options, transport }),
        Job::Assembly(job) => with_law_of(&job.contact, Resume { job, state, options, transport }),
        Job::Mpm(job) if job.grid.dimension == 2 => continuum::resume::<Plane>(job, state, options, transport),
        Job::Mpm(job) => continuum::resume::<Solid>(job, state, options, transport),
    }
}

struct Start<'a, J> {
    job: &'a J,
    options: &'a Options,
    transport: &'a dyn Transport,
}

impl ForAnyLaw for Start<'_, Scenario> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        planar_shear::start::<C>(self.job, self.options, self.transport)
    }
}

impl ForAnyLaw for Start<'_, Assembly> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        match self.job.cell.dimension {
            2 => assembly::start::<Plane, C>(self.job, self.options, self.transport),
            _ => assembly::start::<Solid, C>(self.job, self.options, self.transport),
        }
    }
}

struct Resume<'a, J> {
    job: &'a J,
    /// On rank 0.
    state: Option<State>,
    options: &'a Options,
    transport: &'a dyn Transport,
}

impl ForAnyLaw for Resume<'_, Scenario> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, transport } = self;
        let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
        planar_shear::resume::<C>(job, snapshot, options, transport)
    }
}

impl ForAnyLaw for Resume<'_, Assembly> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, transport } = self;
        match job.cell.dimension {
            2 => {
                let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
                assembly::resume::<Plane, C>(job, snapshot, options, transport)
            }
            _ => {
                let snapshot = transfer::agree(transport, state.as_ref().map(Snapshot::from_state).transpose())?;
                assembly::resume::<Solid, C>(job, snapshot, options, transport)
            }
        }
    }
}
