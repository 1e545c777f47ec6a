//! From a job to its experiment: the kind of job, its space and its contact law are chosen here, once per run.

use std::fs;
use std::path::Path;

use scree_io::column::State;
use scree_partition::Transport;

use crate::checkpoint::{self, Snapshot};
use crate::continuum;
use crate::error::Error;
use crate::law::contact::{ContactLaw, ForAnyLaw, with_law_of};
use crate::log::Log;
use crate::output::{self, scenario_file};
use crate::planar_shear;
use crate::run::{Beginning, Options, Outcome};
use crate::scenario::mpm::{Granular, Mpm};
use crate::scenario::{Assembly, Job, Scenario};
use crate::space::{Plane, Solid};
use crate::stop;
use crate::transfer;
use crate::{assembly, changes, coupled};

/// Runs a job from its start.
pub fn start(job: &Job, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let ended = match job {
        Job::Shear(job) => with_law_of(&job.contact, Start { job, options, transport }),
        Job::Assembly(job) => with_law_of(&job.contact, Start { job, options, transport }),
        Job::Mpm(job @ Mpm { grains: Some(granular), .. }) => {
            with_law_of(&granular.piece.contact, Start { job: &(job, granular.as_ref()), options, transport })
        }
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

/// How a run is to be gone on with.
#[derive(Clone, Copy, Debug, Default)]
pub struct Continuation<'a> {
    /// `key.path=value` over the job of the checkpoint.
    pub sets: &'a [String],
    /// The folder of a new run, whose first state is that of the checkpoint; its job may differ in anything.
    pub branch: Option<&'a Path>,
}

/// Continues a run from its newest good checkpoint, on any number of ranks and threads.
pub fn resume(
    dir: &Path,
    continuation: Continuation,
    options: &Options,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    stop::listen()?;
    let read = || -> Result<_, Error> {
        // Held from here on: whoever else goes on with this run would make of its newest checkpoint an old one.
        let log = continuation.branch.is_none().then(|| Log::open(dir)).transpose()?;
        let (_, state) = checkpoint::latest_state(dir)?;
        let text = continued_job(dir, &state, continuation)?;
        Ok(Some((state, (text, log))))
    };
    let read = if transport.rank() == 0 { read() } else { Ok(None) };
    let (state, rest) = transfer::agree(transport, read)?.unzip();
    let (job, log) = rest.unzip();
    let log = log.flatten();
    let (text, beginning) = job.unwrap_or((String::new(), Beginning::Plain));
    let text = String::from_utf8_lossy(&transport.broadcast(text.into_bytes())).into_owned();
    let beginning = Beginning::of_code(transport.broadcast(vec![beginning as u8])[0]);
    let options = &Options { beginning, ..options.clone() };
    match &Job::parse(&text, &scenario_file(dir).display().to_string(), &[])? {
        Job::Shear(job) => with_law_of(&job.contact, Resume { job, state, options, log, transport }),
        Job::Assembly(job) => with_law_of(&job.contact, Resume { job, state, options, log, transport }),
        Job::Mpm(job @ Mpm { grains: Some(granular), .. }) => with_law_of(
            &granular.piece.contact,
            Resume { job: &(job, granular.as_ref()), state, options, log, transport },
        ),
        Job::Mpm(job) if job.grid.dimension == 2 => continuum::resume::<Plane>(job, state, options, log, transport),
        Job::Mpm(job) => continuum::resume::<Solid>(job, state, options, log, transport),
    }
}

/// The job that a run goes on with, and what that makes of the run.
fn continued_job(dir: &Path, state: &State, continuation: Continuation) -> Result<(String, Beginning), Error> {
    let text = &checkpoint::scenario_of(state)?;
    let (shown, file) = (dir.display(), scenario_file(dir));
    let edited = !fs::read_to_string(&file).is_ok_and(|there| changes::between(text, &there).is_empty());
    let Continuation { sets, branch } = continuation;
    let job = Job::parse(text, &file.display().to_string(), sets)?;
    let (progress, steps) = (checkpoint::progress_of(state)?, job.steps());
    let step = progress.step;
    let job = job.to_toml();
    // What the run began with as this program writes it, which may have keys that an older one had not.
    let began = Job::parse(text, &file.display().to_string(), &[])?.to_toml();
    let changes = changes::between(&began, &job);
    if let Some(kept) = changes.iter().find(|change| change.is_kept()) {
        return Err(Error::User(format!(
            "{shown}: {} is not possible: the grains of a zone are those of the packing that the run began with, also in a branch. Start a new run by `scree run`.",
            kept.words()
        )));
    }
    let paths = changes.iter().find(|change| progress.enriched_step > 0 && change.asks_for_paths());
    if let Some(paths) = paths {
        return Err(Error::User(format!(
            "{shown}: {} is not possible: grains are there already, and the paths of the points beside them, along which more would have to be trained, have not been kept since. Start a new run by `scree run`.",
            paths.words()
        )));
    }
    // The last row and the last frame belong to the end that a run had.
    let refuse_the_past = || match step < steps {
        true => Ok(()),
        false => Err(Error::User(format!(
            "{shown}: the run has come to step {step}, and is to end after step {steps}: nothing is left to be done. Give a later end by --set time.end=..., or loading.strain_end of planar shear."
        ))),
    };
    if let Some(new) = branch {
        refuse_the_past()?;
        output::claim(new, &job)?;
        // What the grains of a zone are taken from.
        let packing = output::packing_file(dir);
        if packing.exists() {
            let copied = fs::copy(&packing, output::packing_file(new));
            copied.map_err(|error| Error::User(format!("{}: {error}", packing.display())))?;
        }
        return Ok((job, Beginning::Branched));
    }
    if let Some(bound) = changes.iter().find(|change| !change.is_free()) {
        return Err(Error::User(format!(
            "{shown}: with {} this would be another run than the one that began. A run may go on with other values of {}. To start a new run from this state, add --force-branch NEW_DIR.",
            bound.words(),
            changes::free_in_words()
        )));
    }
    if !changes.is_empty() {
        refuse_the_past()?;
    }
    for change in &changes {
        tracing::info!("going on with {}", change.words());
    }
    if changes.is_empty() && edited {
        tracing::warn!(
            "warning: {} has been edited, and a run goes on with the job of its checkpoint all the same; change that with --set",
            file.display()
        );
    }
    Ok((job, if changes.is_empty() { Beginning::Plain } else { Beginning::Changed }))
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

impl ForAnyLaw for Start<'_, (&Mpm, &Granular)> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        coupled::start::<C>(*self.job, self.options, self.transport)
    }
}

struct Resume<'a, J> {
    job: &'a J,
    /// On rank 0.
    state: Option<State>,
    options: &'a Options,
    /// Of the folder, on rank 0.
    log: Option<Log>,
    transport: &'a dyn Transport,
}

impl ForAnyLaw for Resume<'_, Scenario> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, log, transport } = self;
        let snapshot = transfer::agree(transport, state.map(Snapshot::from_state).transpose())?;
        planar_shear::resume::<C>(job, snapshot, options, log, transport)
    }
}

impl ForAnyLaw for Resume<'_, Assembly> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, log, transport } = self;
        match job.cell.dimension {
            2 => {
                let snapshot = transfer::agree(transport, state.map(Snapshot::from_state).transpose())?;
                assembly::resume::<Plane, C>(job, snapshot, options, log, transport)
            }
            _ => {
                let snapshot = transfer::agree(transport, state.map(Snapshot::from_state).transpose())?;
                assembly::resume::<Solid, C>(job, snapshot, options, log, transport)
            }
        }
    }
}

impl ForAnyLaw for Resume<'_, (&Mpm, &Granular)> {
    type Outcome = Result<Outcome, Error>;

    fn with<C: ContactLaw<Plane> + ContactLaw<Solid>>(self) -> Self::Outcome {
        let Self { job, state, options, log, transport } = self;
        let snapshot = transfer::agree(transport, state.map(Snapshot::from_state).transpose())?;
        coupled::resume::<C>(*job, snapshot, options, log, transport)
    }
}
