//! From a job to its run: the kind of job, its space and its material are chosen here, once per run.

use std::fs;
use std::path::Path;

use scree_io::column::State;
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::program;
use crate::base::space::{Plane, Solid};
use crate::domain::{stop, transfer};
use crate::job::mpm::MeshFile;
use crate::job::{Job, Method};
use crate::mpm::stress::MemoryColumns;
use crate::prepare::sheared::on_root;
use crate::run::assembly::InSpace;
use crate::run::experiment::{Setup, WorldOf};
use crate::run::folder::{self, Folder, mesh_file, packing_file, scenario_file};
use crate::run::grid::{Grains, Points};
use crate::run::{self, Beginning, Options, Outcome, changes};
use crate::store::checkpoint::{self, Progress, Snapshot};

/// Runs a job from its start, in a folder of its own that is taken before any work: what cannot be written costs nothing, and
/// nobody else begins there meanwhile.
pub fn start(job: &Job, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let folder = claim(&job.to_toml(), job.mesh_file(), options, transport)?;
    with_setup_of(job, Start { folder, options, transport })
}

/// The same of a setup that no job file describes.
pub fn start_setup(setup: &impl Setup, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let folder = claim(&setup.experiment().job, None, options, transport)?;
    Start { folder, options, transport }.with(setup)
}

/// A folder for a run of the resolved job and of the mesh that it reads, on rank 0.
fn claim(
    job: &str,
    mesh: Option<&MeshFile>,
    options: &Options,
    transport: &dyn Transport,
) -> Result<Option<Folder>, Error> {
    let claimed = on_root(transport, || {
        let folder = Folder::claim(&options.out)?;
        mesh.map_or(Ok(()), |mesh| folder.copy_mesh(&mesh.read_from))?;
        folder.write_job(job)?;
        Ok(folder)
    });
    transfer::agree(transport, claimed)
}

/// Runs the job of a folder whose run has not come to its first state: what it has made of its packing is gone on with.
pub fn start_again(dir: &Path, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    stop::listen()?;
    let taken = on_root(transport, || {
        let folder = Folder::take(dir)?;
        let text = fs::read_to_string(scenario_file(dir)).map_err(|error| Error::User(error.to_string()))?;
        folder.refuse_results()?;
        folder.clear_outputs()?;
        Ok((folder, text))
    });
    let (folder, text) = transfer::agree(transport, taken)?.unzip();
    let text = shared_text(transport, text);
    let job = Job::parse(&text, &scenario_file(dir).display().to_string(), &[])?;
    tracing::info!("{}: no checkpoint yet; the run begins", dir.display());
    with_setup_of(&job, Start { folder, options, transport })
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
    let read = on_root(transport, || {
        // Held from here on: whoever else goes on with this run would make of its newest checkpoint an old one.
        let held = continuation.branch.is_none().then(|| Folder::take(dir)).transpose()?;
        let (path, state) = checkpoint::latest_state(dir)?;
        refuse_other_run(dir, &path, &state)?;
        let (text, beginning) = continued_job(dir, &state, continuation)?;
        let folder = match (held, continuation.branch) {
            (Some(folder), _) => folder,
            (None, Some(new)) => branched(dir, new)?,
            (None, None) => unreachable!("a folder is taken or branched from"),
        };
        Ok((state, (folder, (text, beginning))))
    });
    let (state, rest) = transfer::agree(transport, read)?.unzip();
    let (folder, job) = rest.unzip();
    let (text, beginning) = job.unzip();
    let text = shared_text(transport, text);
    let beginning = beginning.unwrap_or(Beginning::Plain);
    let beginning = Beginning::of_code(transport.broadcast(vec![beginning as u8])[0]);
    let options = &Options { beginning, ..options.clone() };
    let job = Job::parse(&text, &scenario_file(dir).display().to_string(), &[])?;
    with_setup_of(&job, Resume { state, options, folder, transport })
}

/// Work that does not care with which kind of job it is done.
pub trait ForAnySetup<R> {
    /// Does it with the space and the law of that kind.
    fn with<J: Setup>(self, job: &J) -> Result<R, Error>;
}

/// Does the work with the kind of a job, in its space and with its law: the one place where these are told apart.
pub fn with_setup_of<R>(job: &Job, work: impl ForAnySetup<R>) -> Result<R, Error> {
    match job {
        Job::Shear(job) => work.with(job),
        Job::Assembly(job) if job.cell.dimension == 2 => work.with(&InSpace::<Plane>::new(job)),
        Job::Assembly(job) => work.with(&InSpace::<Solid>::new(job)),
        Job::Mpm(job) => match (job.grains.as_ref().filter(|_| job.rves().is_none()), job.grid.dimension) {
            (None, 2) => work.with(&Points::<Plane>::new(job)),
            (None, _) => work.with(&Points::<Solid>::new(job)),
            (Some(granular), 2) => work.with(&Grains::<Plane>::hybrid(job, granular)),
            (Some(granular), _) => work.with(&Grains::<Solid>::new(job, granular)),
        },
    }
}

/// A run from its start, in the folder that rank 0 holds for it.
struct Start<'a> {
    folder: Option<Folder>,
    options: &'a Options,
    transport: &'a dyn Transport,
}

impl ForAnySetup<Outcome> for Start<'_> {
    fn with<J: Setup>(self, job: &J) -> Result<Outcome, Error> {
        let Self { mut folder, options, transport } = self;
        let made = job.begin(&mut folder, transport);
        let ended =
            made.and_then(|(world, progress)| run::begin(job.experiment(), world, progress, options, &mut folder));
        match (ended, folder) {
            (Err(Error::Stopped(step)), _) => Ok(Outcome::Stopped(format!(
                "Stopped on request while the packing was made, after {step} steps of it, which are kept. `scree resume {0}` goes on.",
                options.out.display()
            ))),
            // A job whose packing cannot be made leaves no folder behind.
            (Err(error), Some(folder)) => folder.abandon().and(Err(error)),
            (ended, _) => ended,
        }
    }
}

/// A run from a state that rank 0 holds.
struct Resume<'a> {
    state: Option<State>,
    options: &'a Options,
    folder: Option<Folder>,
    transport: &'a dyn Transport,
}

impl ForAnySetup<Outcome> for Resume<'_> {
    fn with<J: Setup>(self, job: &J) -> Result<Outcome, Error> {
        let (world, progress) = world_of(job, self.state, self.transport)?;
        run::go_on_with(job.experiment(), world, progress, self.options, self.folder)
    }
}

/// The world of a state that rank 0 holds, and how far its run is.
pub fn world_of<'t, J: Setup>(
    job: &J,
    state: Option<State>,
    transport: &'t dyn Transport,
) -> Result<(WorldOf<'t, J>, Progress), Error> {
    let memory_words = job.law().memory_words();
    let read = |state| Snapshot::from_state(state, memory_words);
    let snapshot: Option<Snapshot<J::Space>> = transfer::agree(transport, state.map(read).transpose())?;
    let refused =
        snapshot.as_ref().map_or(Ok(()), |of| refuse_other_law(&of.memory_columns, &job.material().memory_columns()));
    transfer::agree(transport, refused)?;
    let (parts, progress) =
        checkpoint::restore(snapshot, |progress, vertices| job.drawn(progress, vertices), transport)?;
    Ok((job.world_at(&progress, parts, transport)?, progress))
}

/// What points remember under one law says nothing to another.
fn refuse_other_law(found: &MemoryColumns, wanted: &MemoryColumns) -> Result<(), Error> {
    let names = |columns: &MemoryColumns| columns.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>().join(", ");
    match found == wanted {
        true => Ok(()),
        false => Err(Error::User(format!(
            "points of the checkpoint remember {}, and those of this job {}; it is of another material law",
            names(found),
            names(wanted)
        ))),
    }
}

/// Rank 0's text, on every rank.
fn shared_text(transport: &dyn Transport, text: Option<String>) -> String {
    let bytes = transport.broadcast(text.unwrap_or_default().into_bytes());
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A checkpoint that was copied into the folder of another run is not gone on with; and whoever goes on by another program than
/// the one that wrote it is told.
fn refuse_other_run(dir: &Path, path: &Path, state: &State) -> Result<(), Error> {
    let of = |key: &str| state.attributes.get(key).map(String::as_str);
    let folder = folder::run_of(dir);
    if let Some(run) = of(checkpoint::RUN).filter(|run| folder.is_known() && *run != folder.as_str()) {
        return Err(Error::User(format!(
            "{} is a checkpoint of run {run}, and {} is the folder of run {}. Move it back to where it comes from, or start a new run from it there with `scree resume DIR --force-branch NEW_DIR`.",
            path.display(),
            dir.display(),
            folder.as_str()
        )));
    }
    if let Some(program) = of(checkpoint::PROGRAM).filter(|program| !program::is_this(program)) {
        tracing::warn!(
            "warning: {} was written by {}, and this is {}: the steps to come may have other bits than those of that program",
            path.display(),
            program::name_in(program),
            program::name()
        );
    }
    if checkpoint::is_of_schema_2(state) {
        tracing::warn!(
            "warning: rows of grains in a cell are of one instant from here on, and stress_xy and stress_yx change places (docs/grains.md, \"Its series\"); columns that this run did not have are left out"
        );
    }
    Ok(())
}

/// The folder of a new run, with what the grains of a zone are taken from.
fn branched(dir: &Path, new: &Path) -> Result<Folder, Error> {
    if let Some(refusal) = folder::occupied(new)? {
        return Err(refusal);
    }
    let folder = Folder::claim(new)?;
    let packing = packing_file(dir);
    if packing.exists() {
        folder.copy_packing(&packing)?;
    }
    let mesh = mesh_file(dir);
    if mesh.exists() {
        folder.copy_mesh(&mesh)?;
    }
    Ok(folder)
}

/// The job that a run goes on with, and what that makes of the run.
fn continued_job(dir: &Path, state: &State, continuation: Continuation) -> Result<(String, Beginning), Error> {
    let text = &checkpoint::scenario_of(state)?;
    let (shown, file) = (dir.display(), scenario_file(dir));
    let there = fs::read_to_string(&file).ok();
    let edited = there.is_some_and(|there| !changes::between(text, &there).is_empty());
    let Continuation { sets, branch } = continuation;
    let job = Job::parse(text, &file.display().to_string(), sets)?;
    let (progress, steps) = (checkpoint::progress_of(state)?, job.steps());
    let step = progress.step;
    // What the run began with as this program writes it, which may have keys that an older one had not.
    let began = Job::parse(text, &file.display().to_string(), &[])?;
    if job.method() == Method::Hybrid && began.begins_as_grains() != job.begins_as_grains() {
        let (has, wanted) = if began.begins_as_grains() { ("grains", "band") } else { ("points", "everywhere") };
        return Err(Error::User(format!(
            "{shown}: a hybrid with zone.begins = \"{wanted}\" is not possible, also in a branch: the run has begun with {has}. Write the other, or start a new run by `scree run`."
        )));
    }
    let job = job.to_toml();
    let changes = changes::between(&began.to_toml(), &job);
    if let Some(kept) = changes.iter().find(|change| change.is_kept()) {
        return Err(Error::User(format!(
            "{shown}: {} is not possible: {}, also in a branch. Start a new run by `scree run`.",
            kept.words(),
            kept.why_kept()
        )));
    }
    // Grains of a zone that begins everywhere are its own, and need no paths from the start.
    let has_forgotten = !began.begins_as_grains() && progress.enriched_step > 0;
    let paths = changes.iter().find(|change| has_forgotten && change.asks_for_paths());
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
    if branch.is_some() {
        refuse_the_past()?;
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
