//! The loop: step, watch, observe, save, stop. What is simulated is an [`Experiment`]; everything here is the same for all.

use std::path::PathBuf;
use std::time::Instant;

use scree_io::frames::Frame;
use scree_io::store;
use scree_partition::{Reader, Writer};
use serde_json::{Value, json};

use crate::checkpoint::{self, Progress, Snapshot};
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::observe::contact_frame::contact_frame;
use crate::observe::guard::EnergyGuard;
use crate::observe::ledger::Entry;
use crate::observe::phases::{self, Phase};
use crate::output::Outputs;
use crate::rebuild::Row;
use crate::record::{FromParcel, Record, ToParcel};
use crate::scenario::Output;
use crate::space::Space;
use crate::stop;
use crate::transfer::{self, Cargo};
use crate::world::World;

/// How a run is to be carried out; none of it is physics.
#[derive(Clone, Debug)]
pub struct Options {
    /// The run directory.
    pub out: PathBuf,
    /// Threads per rank, for the record: the pool is made by the caller.
    pub threads: usize,
}

/// How a run ended, with closing lines for the operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Done(String),
    /// Stopped on request, with a checkpoint written unless its packing was still being made.
    Stopped(String),
}

/// What is run: where one kind of job differs from another.
pub trait Experiment {
    type Space: Space;
    type Contact: ContactLaw<Self::Space>;
    type Material: MaterialLaw<Self::Space>;

    /// The resolved job.
    fn job(&self) -> String;
    fn output(&self) -> &Output;
    /// Steps of the whole run.
    fn steps(&self) -> u64;
    /// Names of the columns of `series.csv`.
    fn header(&self) -> Vec<String>;
    /// What happens between two steps beside observing.
    fn watch(&mut self, core: &mut CoreOf<Self>) -> Result<(), Error>;
    /// A row of the series.
    fn row(&mut self, core: &mut CoreOf<Self>) -> Result<Vec<f64>, Error>;
    /// A frame, on rank 0.
    fn frame(&mut self, core: &mut CoreOf<Self>) -> Result<Option<Frame>, Error>;
    /// How far the run is, for a person.
    fn words(&self, core: &CoreOf<Self>) -> String;
    /// Figures for the summary.
    fn figures(&self, core: &CoreOf<Self>) -> Value;
}

/// The world of an experiment with what a run keeps beside it.
pub type CoreOf<'t, E> = Core<'t, <E as Experiment>::Space, <E as Experiment>::Contact, <E as Experiment>::Material>;

/// The state of a run, and where it writes.
pub struct Core<'t, S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> {
    pub world: World<'t, S, C, L>,
    pub progress: Progress,
    pub options: Options,
    /// On rank 0.
    outputs: Option<Outputs>,
    /// Whether contacts are written with every frame.
    contact_frames: bool,
}

impl<'t, S: Space, C: ContactLaw<S>, L: MaterialLaw<S>> Core<'t, S, C, L> {
    pub fn new(world: World<'t, S, C, L>, progress: Progress, options: &Options, outputs: Option<Outputs>) -> Self {
        Self { world, progress, options: options.clone(), outputs, contact_frames: false }
    }

    /// What only rank 0 does, with an outcome that all ranks share.
    pub fn on_root(&mut self, work: impl FnOnce(&mut Outputs) -> Result<(), Error>) -> Result<(), Error> {
        let outcome = self.outputs.as_mut().map_or(Ok(()), work);
        transfer::agree(self.world.transport, outcome)
    }

    /// Writes a frame that rank 0 holds, and where they are wanted the contacts of the same time.
    pub fn write_frame(&mut self, made: Option<Frame>) -> Result<(), Error> {
        let contacts = if self.contact_frames { contact_frame(&mut self.world)? } else { None };
        self.progress.frames += 1;
        self.on_root(|outputs| {
            made.map_or(Ok(()), |frame| outputs.frame(&frame))?;
            contacts.map_or(Ok(()), |contacts| outputs.contacts(&contacts))
        })
    }
}

impl Cargo for Progress {
    fn blank() -> Self {
        Self::default()
    }
    fn pack_rest(&mut self, to: &mut Writer) {
        to.u64_slice(&self.oracle.flagged);
        to.f64_slice(&self.instants.times);
        for entries in [&mut self.ledger, &mut self.reactions] {
            to.u64(entries.len() as u64);
            entries.iter_mut().for_each(|entry| entry.visit(&mut ToParcel(to)));
        }
    }
    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), scree_partition::ParcelError> {
        self.oracle.flagged = from.u64_slice()?;
        self.instants.times = from.f64_slice()?;
        for entries in [&mut self.ledger, &mut self.reactions] {
            *entries = vec![Entry::default(); from.u64()? as usize];
            let mut from = FromParcel { reader: from, failure: None };
            entries.iter_mut().for_each(|entry| entry.visit(&mut from));
            from.failure.map_or(Ok(()), Err)?;
        }
        Ok(())
    }
}

/// Steps between two looks at the progress display.
const SHOW_EVERY: u64 = 2000;
/// Steps between two looks at energy, points and overlaps, and the deepest overlap that is still physics, as a share of the smaller
/// radius. Overlaps are looked at whenever lists have been made anew as well: in between nothing comes nearer by more than
/// the skin, so nothing passes through anything unseen.
const GUARD_EVERY: u64 = 1000;
const OVERLAP_MAX: f64 = 0.5;

/// Intervals of simulated time as whole steps.
struct Cadence {
    series: u64,
    frame: u64,
    checkpoint: u64,
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
pub struct Run<'t, E: Experiment> {
    experiment: E,
    core: CoreOf<'t, E>,
    steps: u64,
    cadence: Cadence,
    energy_guard: EnergyGuard,
    /// Rebuilds at the last look at overlaps.
    rebuilds: u64,
    started: Instant,
    first_step: u64,
    writing: Writing,
}

impl<'t, E: Experiment> Run<'t, E> {
    pub fn new(experiment: E, mut core: CoreOf<'t, E>) -> Result<Self, Error> {
        core.contact_frames = experiment.output().contact_frames;
        let step = core.world.settings.dt;
        let every = |interval: f64| ((interval / step).round() as u64).max(1);
        let output = experiment.output();
        let cadence = Cadence {
            series: every(output.series_interval),
            frame: every(output.frame_interval),
            checkpoint: every(output.checkpoint_interval),
        };
        let (first_step, steps) = (core.world.step, experiment.steps());
        let energy_guard = EnergyGuard::default();
        let rebuilds = core.world.rebuilds;
        let (started, writing) = (Instant::now(), Writing::default());
        Ok(Self { experiment, core, steps, cadence, energy_guard, rebuilds, started, first_step, writing })
    }

    /// Goes on to the end of the run. A run that stops itself says where it can be taken up again.
    pub fn go(self) -> Result<Outcome, Error> {
        let out = self.core.options.out.clone();
        self.go_on().map_err(|error| match error {
            Error::Run(what) => {
                Error::Run(format!("{}. {}", what.trim_end_matches('.'), checkpoint::newest_in_words(&out)))
            }
            other => other,
        })
    }

    fn go_on(mut self) -> Result<Outcome, Error> {
        if self.core.world.step == 0 {
            self.write_frame()?;
        }
        while self.core.world.step < self.steps {
            self.core.world.stop_wanted = stop::wanted() || stop::is_over(self.started);
            self.core.world.forces_wanted = self.row_due(self.core.world.step + 1);
            self.core.world.advance()?;
            self.experiment.watch(&mut self.core)?;
            self.observe()?;
            if self.core.world.stop_agreed && self.core.world.step < self.steps {
                return self.stopped();
            }
        }
        self.done()
    }

    fn row_due(&self, step: u64) -> bool {
        step.is_multiple_of(self.cadence.series) || step == self.steps
    }

    /// Stops the run where it has left physics. Energies are compared from the first step of a run or its resumption on,
    /// after which grains move as cell and bodies do.
    fn guard(&mut self) -> Result<(), Error> {
        let world = &mut self.core.world;
        let step = world.step;
        let due = step.is_multiple_of(GUARD_EVERY) || step == self.steps;
        let written =
            [self.cadence.series, self.cadence.checkpoint].into_iter().any(|every| step.is_multiple_of(every));
        if due || written || world.rebuilds != self.rebuilds {
            self.rebuilds = world.rebuilds;
            world.refuse_deep_overlaps(OVERLAP_MAX)?;
        }
        if due || written {
            world.refuse_spoilt_points()?;
        }
        if due || step == self.first_step + 1 {
            self.energy_guard.look(world)?;
        }
        Ok(())
    }

    /// Rows, frames and checkpoints that are due.
    fn observe(&mut self) -> Result<(), Error> {
        let step = self.core.world.step;
        self.guard()?;
        if self.row_due(step) {
            self.write_row()?;
        }
        if step.is_multiple_of(self.cadence.frame) || step == self.steps {
            self.write_frame()?;
        }
        if step.is_multiple_of(self.cadence.checkpoint) || step == self.steps {
            self.save()?;
        }
        if step.is_multiple_of(SHOW_EVERY) && self.core.outputs.is_some() {
            let words = self.experiment.words(&self.core);
            if let Some(outputs) = &mut self.core.outputs {
                outputs.show(step, || words);
            }
        }
        Ok(())
    }

    fn write_row(&mut self) -> Result<(), Error> {
        let timer = self.core.world.phases.start();
        let row = self.experiment.row(&mut self.core)?;
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
        let Cadence { series, frame, checkpoint } = self.cadence;
        let kinds = self.writing.iter().zip([series, frame, checkpoint]);
        kinds.map(|((seconds, times), every)| seconds / ((*times).max(1) * every) as f64).sum()
    }

    fn write_frame(&mut self) -> Result<(), Error> {
        let timer = self.core.world.phases.start();
        let made = self.experiment.frame(&mut self.core)?;
        let outcome = self.core.write_frame(made);
        self.book(Written::Frame, timer);
        outcome
    }

    /// Writes a checkpoint of the state as it is.
    fn save(&mut self) -> Result<(), Error> {
        let core = &mut self.core;
        let timer = core.world.phases.start();
        // The checkpoint counts rows; they must be on disk before it is.
        core.on_root(|outputs| outputs.sync())?;
        core.progress.step = core.world.step;
        core.progress.ledger = core.world.ledger_entries()?;
        core.progress.reactions = core.world.reaction_entries()?;
        let (grains, points) = core.world.rows();
        let grains: Option<Vec<Row<E::Space, E::Contact>>> = transfer::gather(core.world.transport, grains)?;
        let points = transfer::gather(core.world.transport, points)?;
        let written = match (grains, points) {
            (Some(grains), Some(points)) => {
                let snapshot = Snapshot {
                    scenario: self.experiment.job(),
                    progress: core.progress.clone(),
                    cell: core.world.cell,
                    bodies: core.world.bodies.clone(),
                    home: core.world.home(),
                    grains,
                    points,
                };
                let folder = checkpoint::folder(&core.options.out);
                store::write(&folder.join(store::file_name(core.world.step)), &snapshot.to_state())
                    .and_then(|()| store::prune(&folder, self.experiment.output().checkpoints_kept))
                    .map(|_| ())
                    .map_err(|error| Error::Run(error.to_string()))
            }
            _ => Ok(()),
        };
        let outcome = transfer::agree(core.world.transport, written);
        self.book(Written::Checkpoint, timer);
        outcome
    }

    fn stopped(mut self) -> Result<Outcome, Error> {
        self.save()?;
        self.close("stopped")?;
        Ok(Outcome::Stopped(format!(
            "Stopped on request at step {} of {}, {}. Continue with `scree resume {}`.",
            self.core.world.step,
            self.steps,
            self.experiment.words(&self.core),
            self.core.options.out.display()
        )))
    }

    fn done(mut self) -> Result<Outcome, Error> {
        let seconds = self.close("done")?;
        let out = self.core.options.out.display();
        Ok(Outcome::Done(format!(
            "Done: {} steps in {seconds:.1} s, {} at the end.\nResults are in {out}; `scree report {out}` draws them.",
            self.core.world.step - self.first_step,
            self.experiment.words(&self.core),
        )))
    }

    /// Last words on disk; returns the wall time of this stretch, s.
    fn close(&mut self, outcome: &str) -> Result<f64, Error> {
        let seconds = self.started.elapsed().as_secs_f64();
        let world = &self.core.world;
        let steps = world.step - self.first_step;
        let mut figures = json!({
            "outcome": outcome,
            "steps": world.step,
            "simulated_time": world.time(),
            "wall_seconds": seconds,
            "ranks": world.transport.size(),
            "threads": self.core.options.threads,
            "grains": world.grains_total,
            "points": world.points_total,
            "rebuilds": world.rebuilds,
            "microseconds_per_step": 1e6 * seconds / steps.max(1) as f64,
        });
        for (name, seconds) in phases::NAMES.iter().zip(world.phases.seconds) {
            figures[format!("seconds_{name}")] = json!(seconds);
        }
        figures["phases"] = world
            .phases
            .over_ranks(world.transport)
            .into_iter()
            .map(|(name, [mean, most])| (name.to_string(), json!({ "mean": mean, "most": most })))
            .collect::<serde_json::Map<_, _>>()
            .into();
        figures["imbalance"] = json!(world.phases.imbalance(world.transport));
        let mut sent = [world.sent.messages as i64, world.sent.bytes as i64, world.balance.rows_sent as i64];
        world.transport.sum(&mut sent);
        let [messages, bytes, rows] = sent;
        figures["messages_per_step"] = json!(messages as f64 / steps.max(1) as f64);
        figures["bytes_per_step"] = json!(bytes as f64 / steps.max(1) as f64);
        figures["rows_moved"] = json!(rows);
        figures["rebalances"] = json!(world.balance.deals);
        if let Value::Object(more) = self.experiment.figures(&self.core) {
            for (name, figure) in more {
                figures[name] = figure;
            }
        }
        let step = world.step;
        let outcome = outcome.to_string();
        let output = self.output_per_step();
        let map = self.core.world.load_map(steps, self.core.options.threads, output);
        self.core.on_root(|outputs| {
            outputs.finish();
            outputs.write_load(&map)?;
            outputs.log(&outcome, step, figures.clone())?;
            outputs.note(figures);
            outputs.write_summary()
        })?;
        Ok(seconds)
    }
}
