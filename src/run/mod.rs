//! The loop: step, watch, observe, save, stop. What is told of a run is an [`Experiment`]; everything here is the same for all.

pub mod adaptive;
pub mod assembly;
pub mod changes;
pub mod columns;
pub mod experiment;
pub mod grid;
pub mod log;
mod options;
pub mod output;
pub mod planar_shear;
pub mod results;
pub mod start;
pub mod summary;
pub mod trial;
mod waits;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use scree_io::frames::Frame;
use scree_io::store;
use scree_partition::{Reader, Writer};
use serde_json::json;
use sha2::{Digest, Sha256};

use self::experiment::{Experiment, Picture};
use self::folder::{Folder, stop_file};
use crate::adapt::watch;
use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::program::{self, host};
use crate::base::record::{Cargo, FromParcel, Record, ToParcel};
use crate::base::space::Space;
use crate::couple::rest::CellStrain;
use crate::dem::drive::Missed;
use crate::domain::accounts::ledger::{Accounts, Entry};
use crate::domain::guards::grains::EnergyGuard;
use crate::domain::phases::Phase;
use crate::domain::step::cycle::is_due;
use crate::domain::stop::{self, Wish};
use crate::domain::transfer;
use crate::domain::world::World;
use crate::observe::contact_frame::contact_frame;
use crate::observe::element_frame::element_frame;
use crate::observe::frame::frame;
use crate::observe::rve_frame;
use crate::run::output::Outputs;
use crate::run::summary::Stretch;
use crate::run::waits::Waits;
use crate::store::checkpoint::{self, Progress};

pub mod folder;

pub use options::{Beginning, Options, Outcome};

/// Begins a run in the folder that rank 0 holds for it, and ends it.
pub fn begin<S: Space>(
    experiment: Experiment<'_, S>,
    mut world: World<S>,
    progress: Progress,
    options: &Options,
    folder: &mut Option<Folder>,
) -> Result<Outcome, Error> {
    world.open_accounts(experiment.accounts);
    let outputs = folder.take().map(|folder| Outputs::create(folder, &experiment, 0)).transpose();
    let outputs = transfer::agree(world.transport, outputs)?;
    let core = Core::new(world, progress, options, (outputs, &experiment));
    Run::new(experiment, core)?.go()
}

/// Goes on with a run from a checkpoint to its end, in the folder that rank 0 holds since before it read that.
pub fn go_on_with<S: Space>(
    experiment: Experiment<'_, S>,
    mut world: World<S>,
    progress: Progress,
    options: &Options,
    folder: Option<Folder>,
) -> Result<Outcome, Error> {
    world.resume_reactions(&progress.reactions)?;
    world.resume_accounts(experiment.accounts, &progress.ledger)?;
    let transport = world.transport;
    let outputs = folder.map(|folder| Outputs::resume(options, folder, &progress, &experiment)).transpose();
    let outputs = transfer::agree(transport, outputs)?;
    let is_done = matches!(outputs, Some(None));
    if transport.broadcast(vec![u8::from(is_done)]) == [1] {
        let out = options.out.display();
        return Ok(Outcome::Done(format!("{out}: this run is done already; nothing was changed.")));
    }
    let core = Core::new(world, progress, options, (outputs.flatten(), &experiment));
    Run::new(experiment, core)?.go()
}

/// The state of a run, and where it writes.
pub struct Core<'t, S: Space> {
    /// As this rank holds it.
    pub world: World<'t, S>,
    /// The same on every rank.
    pub progress: Progress,
    /// As the run was begun or gone on with.
    pub options: Options,
    /// On rank 0.
    outputs: Option<Outputs>,
    /// Accounts that are kept.
    pub accounts: Accounts,
    picture: Picture,
    /// Whether contacts are written with every frame, and of which points the grains of their RVEs.
    contact_frames: bool,
    drawn_rves: Vec<PointId>,
}

impl<'t, S: Space> Core<'t, S> {
    fn new(
        world: World<'t, S>,
        mut progress: Progress,
        options: &Options,
        (outputs, experiment): (Option<Outputs>, &Experiment<S>),
    ) -> Self {
        if options.beginning == Beginning::Branched {
            (progress.series_rows, progress.frames) = (0, 0);
        }
        let Experiment { accounts, picture, output, .. } = *experiment;
        let contact_frames = output.contact_frames;
        let drawn_rves = experiment.drawn_rves.iter().map(|(_, point)| *point).collect();
        Self { world, progress, options: options.clone(), outputs, accounts, picture, contact_frames, drawn_rves }
    }

    /// What only rank 0 does, with an outcome that all ranks share.
    pub fn on_root(&mut self, work: impl FnOnce(&mut Outputs) -> Result<(), Error>) -> Result<(), Error> {
        let outcome = self.outputs.as_mut().map_or(Ok(()), work);
        transfer::agree(self.world.transport, outcome)
    }

    /// Writes a frame, and where they are wanted contacts and RVEs at the same time.
    pub fn write_frame(&mut self) -> Result<(), Error> {
        let Picture { depth, may_have_points, flagged, .. } = self.picture;
        let mut made = frame(&mut self.world, depth, self.progress.fraction_start, may_have_points)?;
        if let (Some(frame), true) = (&mut made, flagged) {
            frame.fields.push(watch::flagged_rows(&self.world, &self.progress.oracle, &frame.positions));
        }
        let elements = element_frame(&self.world, made.as_ref())?;
        let contacts = if self.contact_frames { contact_frame(&mut self.world)? } else { None };
        let of_rves = rve_frame::of_points(&self.world, &self.drawn_rves)?;
        let frames: Vec<Frame> =
            made.into_iter().chain(elements).chain(contacts).chain(of_rves.into_iter().flatten()).collect();
        self.progress.frames += 1;
        self.on_root(|outputs| outputs.frames(&frames))
    }
}

impl Cargo for Progress {
    fn blank() -> Self {
        Self::default()
    }
    fn pack_rest(&mut self, to: &mut Writer) {
        to.u64_slice(&self.oracle.flagged);
        self.oracle.seen.iter_mut().for_each(|look| look.visit(&mut ToParcel(to)));
        to.f64_slice(&self.instants.times);
        to.u64(self.rest.cells.len() as u64);
        self.rest.cells.iter_mut().for_each(|cell| cell.visit(&mut ToParcel(to)));
        for entries in [&mut self.ledger, &mut self.reactions] {
            to.u64(entries.len() as u64);
            entries.iter_mut().for_each(|entry| entry.visit(&mut ToParcel(to)));
        }
        to.u64(self.missed.len() as u64);
        self.missed.iter_mut().for_each(|missed| missed.visit(&mut ToParcel(to)));
    }
    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), scree_partition::ParcelError> {
        self.oracle.flagged = from.u64_slice()?;
        let mut looks = FromParcel { reader: from, failure: None };
        self.oracle.seen.iter_mut().for_each(|look| look.visit(&mut looks));
        looks.failure.map_or(Ok(()), Err)?;
        self.instants.times = from.f64_slice()?;
        self.rest.cells = vec![CellStrain::default(); from.u64()? as usize];
        let mut cells = FromParcel { reader: from, failure: None };
        self.rest.cells.iter_mut().for_each(|cell| cell.visit(&mut cells));
        cells.failure.map_or(Ok(()), Err)?;
        for entries in [&mut self.ledger, &mut self.reactions] {
            *entries = vec![Entry::default(); from.u64()? as usize];
            let mut from = FromParcel { reader: from, failure: None };
            entries.iter_mut().for_each(|entry| entry.visit(&mut from));
            from.failure.map_or(Ok(()), Err)?;
        }
        self.missed = vec![Missed::default(); from.u64()? as usize];
        let mut from = FromParcel { reader: from, failure: None };
        self.missed.iter_mut().for_each(|missed| missed.visit(&mut from));
        from.failure.map_or(Ok(()), Err)
    }
}

/// Steps between two looks at the progress display.
const SHOW_EVERY: u64 = 2000;
/// Steps between two looks at energy, points and overlaps, and the deepest overlap that is still physics, as a share of the smaller
/// radius. Overlaps are looked at whenever lists have been made anew as well: in between nothing comes nearer by more than
/// the skin, so nothing passes through anything unseen.
const GUARD_EVERY: u64 = 1000;
const OVERLAP_MAX: f64 = 0.5;

/// Time between two looks for a stop file.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// 64 hex digits that stand for a job.
fn digest_of_text(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Intervals of simulated time as whole steps.
struct Cadence {
    series: u64,
    frame: u64,
    checkpoint: u64,
    /// Checkpoints by steps, beside those of an interval.
    checkpoint_steps: Option<u64>,
}

/// What is written in the course of a run.
#[derive(Clone, Copy, Debug)]
#[repr(usize)]
enum Written {
    Row,
    Frame,
    Checkpoint,
}

/// Seconds and times that each kind of [`Written`] took.
type Writing = [(f64, u64); 3];

/// A run under way.
struct Run<'t, 's, S: Space> {
    experiment: Experiment<'s, S>,
    core: Core<'t, S>,
    steps: u64,
    cadence: Cadence,
    /// Rebuilds at the last look at overlaps.
    rebuilds: u64,
    /// Whether a person has been told that energy grows.
    has_warned: bool,
    waits: Waits,
    started: Instant,
    first_step: u64,
    /// Steps that are taken at once: those of the last pass, whatever has come of it for the next.
    together: u64,
    /// When a checkpoint was last written, and after which step; none has been where it is the first.
    saved: Instant,
    saved_step: u64,
    /// When a stop file was last looked for.
    looked: Instant,
    /// Steps of single grains and of single points.
    grain_steps: u64,
    point_steps: u64,
    writing: Writing,
}

impl<'t, 's, S: Space> Run<'t, 's, S> {
    fn new(experiment: Experiment<'s, S>, mut core: Core<'t, S>) -> Result<Self, Error> {
        let step = core.world.settings.grains.dt;
        let every = |interval: f64| ((interval / step).round() as u64).max(1);
        let output = experiment.output;
        let cadence = Cadence {
            series: every(output.series_interval),
            frame: every(output.frame_interval),
            checkpoint: every(output.checkpoint_interval),
            checkpoint_steps: Some(output.checkpoint_steps).filter(|steps| *steps > 0),
        };
        let (first_step, steps) = (core.world.step, experiment.steps);
        if first_step == 0 || core.options.beginning == Beginning::Branched {
            core.progress.kept = core.world.kept_from_now()?;
            core.progress.guard = EnergyGuard::default();
        }
        let rebuilds = core.world.rebuilds;
        let started = Instant::now();
        // Until a checkpoint has been written.
        stop::reserve(
            stop::RESERVE_LEAST + stop::ROW_SAVED * (core.world.grains_total + core.world.points_total) as u32,
        );
        Ok(Self {
            experiment,
            core,
            steps,
            cadence,
            rebuilds,
            has_warned: false,
            waits: Waits::new(),
            started,
            first_step,
            together: 1,
            saved: started,
            saved_step: first_step,
            looked: started,
            grain_steps: 0,
            point_steps: 0,
            writing: Writing::default(),
        })
    }

    /// Goes on to the end of the run. A run that stops itself says where it can be taken up again.
    fn go(self) -> Result<Outcome, Error> {
        let out = self.core.options.out.clone();
        self.go_on().map_err(|error| match error {
            Error::Run(what) => {
                Error::Run(format!("{}. {}", what.trim_end_matches('.'), checkpoint::newest_in_words(&out)))
            }
            other => other,
        })
    }

    fn go_on(mut self) -> Result<Outcome, Error> {
        self.tell_beginning()?;
        let beginning = self.core.options.beginning;
        // Of a run that is gone on with from its first state that has been written.
        if self.core.progress.frames == 0 {
            self.write_frame()?;
            // Kept for good: whoever looks for the start finds it.
            self.save_in(&checkpoint::folder(&self.core.options.out).join(store::FOR_GOOD))?;
        } else if beginning == Beginning::Changed {
            self.save()?;
        }
        if beginning != Beginning::Plain {
            // Now that there is a state that goes with it.
            let job = self.experiment.job.clone();
            self.core.on_root(|outputs| outputs.folder().write_job(&job))?;
        }
        while self.core.world.step < self.steps {
            self.pass()?;
            self.show();
            match self.core.world.wish_agreed {
                Wish::Stop if self.core.world.step < self.steps => return self.stopped(),
                Wish::Save => self.save_unless_saved()?,
                _ => {}
            }
        }
        self.done()
    }

    /// Steps that are taken at once, with all that is due after them.
    fn pass(&mut self) -> Result<(), Error> {
        self.together = self.core.world.settings.grain_steps;
        self.core.world.wish = self.wish();
        self.core.world.assembly.forces_wanted = self.row_due(self.core.world.step + self.together);
        self.core.world.advance()?;
        self.grain_steps += self.together * self.core.world.grains_total;
        self.point_steps += self.core.world.points_total;
        (self.experiment.watch)(&mut self.core)?;
        self.observe()
    }

    /// What this rank wants of the run before its next step. Where all could tell, rank 0 does: clocks and file systems of
    /// others may say something else.
    fn wish(&mut self) -> Wish {
        let asked = stop::wish();
        if asked == Wish::Stop || self.core.outputs.is_none() {
            return asked;
        }
        let now = Instant::now();
        let is_over = self.core.options.steps_for.is_some_and(|limit| now - self.started >= limit);
        if is_over || self.stop_file_is_there(now) {
            return Wish::Stop;
        }
        if now - self.saved >= self.experiment.output.save_every() { Wish::Save } else { asked }
    }

    /// Looked for once a second, for looking may take long.
    fn stop_file_is_there(&mut self, now: Instant) -> bool {
        if now - self.looked < LOOK_EVERY {
            return false;
        }
        self.looked = now;
        stop_file(&self.core.options.out).exists()
    }

    /// Who runs what, in the log and for a person.
    fn tell_beginning(&mut self) -> Result<(), Error> {
        let (world, options, job) = (&self.core.world, &self.core.options, self.experiment.job.clone());
        let step = world.step;
        let job_digest = digest_of_text(&job);
        let what = match (options.beginning, step) {
            (Beginning::Branched, _) => "branched",
            (_, 0) => "started",
            _ => "resumed",
        };
        let fields = json!({
            "program": program::identity(),
            "machine": host(),
            "ranks": world.transport.size(),
            "threads": options.threads,
            "job": job_digest,
            "steps": self.steps,
            "time_step": world.settings.grains.dt,
            "grains": world.grains_total,
            "points": world.points_total,
            "allow_unstable": self.experiment.allows_unstable,
        });
        if self.core.outputs.is_some() {
            tracing::info!(
                "{} on {}, job {}: step {step} of {}, {:e} s each; {} grains, {} points",
                program::name(),
                host(),
                &job_digest[..12],
                self.steps,
                world.settings.grains.dt,
                world.grains_total,
                world.points_total,
            );
            let (blocks, ranks) = (world.subdomain.layout.block_count(), world.transport.size());
            if blocks < ranks {
                tracing::warn!(
                    "warning: ranks: {ranks}, blocks to be shared out: {blocks}. The ranks beyond have nothing to do; take no more ranks than blocks"
                );
            }
            if self.experiment.allows_unstable {
                tracing::warn!(
                    "warning: time.allow_unstable is on: an unstable step passes, and energy that grows is told instead of stopping the run"
                );
            }
        }
        self.core.on_root(|outputs| outputs.log(what, step, fields))
    }

    fn row_due(&self, step: u64) -> bool {
        self.is_due(step, self.cadence.series) || step >= self.steps
    }

    fn checkpoint_due(&self, step: u64) -> bool {
        let Cadence { checkpoint, checkpoint_steps, .. } = self.cadence;
        self.is_due(step, checkpoint) || checkpoint_steps.is_some_and(|every| self.is_due(step, every))
    }

    fn is_due(&self, step: u64, every: u64) -> bool {
        is_due(step, every, self.together)
    }

    /// Stops the run where it has left physics. Energies are compared from the first step of a run on, after which grains move as
    /// cell and bodies do. Of a run whose step was allowed to be unstable, energy that grows is told.
    fn guard(&mut self) -> Result<(), Error> {
        let step = self.core.world.step;
        let due = self.is_due(step, GUARD_EVERY) || step >= self.steps;
        let written = self.is_due(step, self.cadence.series) || self.checkpoint_due(step);
        let begins = self.first_step == 0 || self.core.options.beginning == Beginning::Branched;
        let is_first = begins && step == self.first_step + self.together;
        let Core { world, progress, .. } = &mut self.core;
        if due || written || world.rebuilds != self.rebuilds {
            self.rebuilds = world.rebuilds;
            world.refuse_deep_overlaps(OVERLAP_MAX)?;
        }
        if due || written {
            world.refuse_spoilt_points()?;
        }
        let grown = if due || is_first { progress.guard.look(world)? } else { None };
        let Some(grown) = grown else { return Ok(()) };
        if !self.experiment.allows_unstable {
            return Err(Error::Run(grown));
        }
        // Once is enough for a person; the log has all.
        if !std::mem::replace(&mut self.has_warned, true) && self.core.outputs.is_some() {
            tracing::warn!("warning: {grown} (time.allow_unstable is on, so the run goes on)");
        }
        self.core.on_root(|outputs| outputs.log("energy_grows", step, json!({ "why": grown })))
    }

    /// Rows, frames and checkpoints that are due.
    fn observe(&mut self) -> Result<(), Error> {
        let step = self.core.world.step;
        self.guard()?;
        if self.is_due(step, GUARD_EVERY) {
            self.tell_waits()?;
        }
        if self.row_due(step) {
            self.write_row()?;
        }
        if self.is_due(step, self.cadence.frame) || step >= self.steps {
            self.write_frame()?;
        }
        if self.checkpoint_due(step) || step >= self.steps {
            self.save()?;
        }
        Ok(())
    }

    /// How far the run is, for a person.
    fn show(&mut self) {
        let step = self.core.world.step;
        if self.is_due(step, SHOW_EVERY) && self.core.outputs.is_some() {
            let words = self.experiment.told(&self.core.world);
            if let Some(outputs) = &mut self.core.outputs {
                outputs.show(step, || words);
            }
        }
    }

    fn write_row(&mut self) -> Result<(), Error> {
        let timer = self.core.world.phases.start();
        let mut row = Vec::new();
        for columns in &mut self.experiment.columns {
            row.extend(columns.row(&mut self.core)?);
        }
        self.core.progress.series_step = self.core.world.step;
        self.core.progress.series_rows += 1;
        let outcome = self.core.on_root(|outputs| outputs.row(&row));
        self.book(Written::Row, timer);
        outcome
    }

    fn book(&mut self, written: Written, since: Instant) {
        self.core.world.phases.stop(Phase::Output, since);
        let (seconds, times) = &mut self.writing[written as usize];
        *seconds += since.elapsed().as_secs_f64();
        *times += 1;
    }

    /// Time that output takes of a step in the long run, s: a short one has its first frame and last checkpoint alone.
    fn output_per_step(&self) -> f64 {
        let Cadence { series, frame, checkpoint, checkpoint_steps } = self.cadence;
        let checkpoint = checkpoint_steps.map_or(checkpoint, |steps| steps.min(checkpoint));
        let kinds = self.writing.iter().zip([series, frame, checkpoint]);
        kinds.map(|((seconds, times), every)| seconds / ((*times).max(1) * every) as f64).sum()
    }

    fn write_frame(&mut self) -> Result<(), Error> {
        let timer = self.core.world.phases.start();
        let outcome = self.core.write_frame();
        self.book(Written::Frame, timer);
        outcome
    }

    /// Writes a checkpoint of the state as it is.
    fn save(&mut self) -> Result<(), Error> {
        self.save_in(&checkpoint::folder(&self.core.options.out))
    }

    fn save_in(&mut self, folder: &Path) -> Result<(), Error> {
        let core = &mut self.core;
        let timer = core.world.phases.start();
        // The checkpoint counts rows; they must be on disk before it is.
        let mut rows = 0;
        core.on_root(|outputs| outputs.sync().map(|digest| rows = digest))?;
        core.progress.series_digest = rows;
        core.progress.step = core.world.step;
        core.progress.ledger = core.world.ledger_entries()?;
        core.progress.reactions = core.world.reaction_entries()?;
        core.progress.missed = core.world.assembly.missed.rows();
        let saved = core.world.step;
        let file = folder.join(store::file_name(saved));
        let head = checkpoint::head(&core.world, core.progress.clone(), self.experiment.job.clone());
        let target = core.outputs.as_ref().map(|outputs| outputs.target(&file, head)).transpose();
        let target = transfer::agree(core.world.transport, target)?;
        let (_, written_before) = self.writing[Written::Checkpoint as usize];
        let (output, number) = (self.experiment.output, written_before + 1);
        let (kept, for_good) = (output.checkpoints_kept, output.checkpoints_for_good as u64);
        let out = &core.options.out.clone();
        let tidy = |_: &mut Outputs| {
            let keep = for_good > 0 && number.is_multiple_of(for_good);
            let tidied = if keep { store::keep_for_good(&file) } else { Ok(()) };
            let tidied = tidied.and_then(|()| store::prune(&checkpoint::folder(out), saved, kept));
            tidied.map(|_| ()).map_err(|error| Error::Run(error.to_string()))
        };
        let written = checkpoint::write(target, &core.world);
        let outcome = written.and_then(|()| core.on_root(tidy));
        self.book(Written::Checkpoint, timer);
        (self.saved, self.saved_step) = (Instant::now(), self.core.world.step);
        let step = self.started.elapsed() / (self.core.world.step - self.first_step).max(1) as u32;
        stop::reserve(stop::RESERVE_LEAST + 2 * (timer.elapsed() + step));
        stop::saved();
        outcome
    }

    /// One that somebody has wished for, or whose time has come by the clock on the wall.
    fn save_unless_saved(&mut self) -> Result<(), Error> {
        if self.saved_step == self.core.world.step {
            stop::saved();
            return Ok(());
        }
        self.save()
    }

    fn stopped(mut self) -> Result<Outcome, Error> {
        self.save_unless_saved()?;
        // It is heard once: who goes on later does not want to stop at once.
        let asked = stop_file(&self.core.options.out);
        self.core.on_root(|_| match asked.exists() {
            true => fs::remove_file(&asked).map_err(|error| Error::Run(format!("{}: {error}", asked.display()))),
            false => Ok(()),
        })?;
        let words = self.close("stopped")?;
        Ok(Outcome::Stopped(format!(
            "{words}\nStopped on request at step {} of {}, {}. Continue with `scree resume {}`.",
            self.core.world.step,
            self.steps,
            self.experiment.told(&self.core.world),
            self.core.options.out.display()
        )))
    }

    fn done(mut self) -> Result<Outcome, Error> {
        let words = format!("{}{}", self.close("done")?, self.without_zone());
        let (out, seconds) = (self.core.options.out.display(), self.started.elapsed().as_secs_f64());
        Ok(Outcome::Done(format!(
            "{words}\nDone: {} steps in {seconds:.1} s, {} at the end.\nResults are in {out}; `scree report {out}` draws them.",
            self.core.world.step - self.first_step,
            self.experiment.told(&self.core.world),
        )))
    }

    /// What a hybrid says that has remained a continuum.
    fn without_zone(&self) -> String {
        let Picture { may_have_grains, may_have_points, .. } = self.experiment.picture;
        if !(may_have_grains && may_have_points) || self.core.progress.enriched_step > 0 {
            return String::new();
        }
        let refused = log::told(&self.core.options.out, "zone_refused");
        match refused.last() {
            Some(last) => format!(
                "\nNo grains have entered: bands were found and their zones refused, {} times, at last at step {}: {}",
                refused.len(),
                last["step"],
                last["why"].as_str().unwrap_or_default()
            ),
            None => "\nNo grains have entered: no band that persists has been found.".to_owned(),
        }
    }

    /// Last words on disk, and for a person.
    fn close(&mut self, outcome: &str) -> Result<String, Error> {
        let seconds = self.started.elapsed().as_secs_f64();
        let conservation = self.core.world.conservation(&self.core.progress.kept)?;
        let (checkpoint_seconds, checkpoints) = self.writing[Written::Checkpoint as usize];
        let world = &self.core.world;
        let stretch = Stretch {
            first_step: self.first_step,
            seconds,
            threads: self.core.options.threads,
            grain_steps: self.grain_steps,
            point_steps: self.point_steps,
            checkpoints,
            checkpoint_seconds,
            conservation,
        };
        let mut figures = summary::figures(world, &stretch);
        figures["outcome"] = json!(outcome);
        figures["allow_unstable"] = json!(self.experiment.allows_unstable);
        let words = format!("{}\n{}", summary::words(&figures), conservation.words());
        if let Some(strain) = &self.experiment.strain {
            figures["strain"] = json!(strain(world));
        }
        let (step, steps) = (world.step, world.step - self.first_step);
        let output = self.output_per_step();
        let map = self.core.world.load_map(steps, stretch.threads, output);
        self.core.on_root(|outputs| {
            outputs.finish();
            // Costs that an earlier stretch has measured are better than none.
            if steps > 0 {
                outputs.write_load(&map)?;
            }
            outputs.log(outcome, step, figures.clone())?;
            outputs.note(figures);
            outputs.write_summary()
        })?;
        Ok(words)
    }
}
