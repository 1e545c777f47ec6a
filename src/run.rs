//! The loop: step, watch, observe, save, stop.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use scree_io::store;
use scree_partition::{Reader, Transport, Writer};
use serde_json::json;

use crate::checkpoint::{self, PlanarPoint, Progress, Snapshot};
use crate::dem::packing::UPPER;
use crate::enrichment::{self, Enriched};
use crate::error::Error;
use crate::hybrid::track::Instants;
use crate::observe::frame::frame;
use crate::observe::phases::{self, Phase};
use crate::output::{self, Outputs};
use crate::packing::{self, Grain, PlanarWorld, layout_for, settings_for};
use crate::rebuild::Parts;
use crate::scenario::{Method, Scenario, derived};
use crate::specimen;
use crate::transfer::{self, Cargo};

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
    /// Stopped on request with a checkpoint written.
    Stopped(String),
}

/// Runs a job from its start.
pub fn start(scenario: &Scenario, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    let root = transport.rank() == 0;
    let claimed = if root { output::claim(&options.out, &scenario.to_toml()) } else { Ok(()) };
    transfer::agree(transport, claimed)?;
    let mut start = specimen::prepare(scenario, transport)?;
    if scenario.method == Method::Hybrid {
        let file = output::packing_file(&options.out);
        let kept = if root { packing::write(&file, &mut start.packing.grains, start.packing.height) } else { Ok(()) };
        transfer::agree(transport, kept)?;
    }
    let progress = Progress {
        height_start: start.packing.height,
        fraction_start: start.fraction,
        instants: Instants { times: Vec::new(), every: (derived::steps(scenario) / TRACKS).max(1) },
        ..Progress::default()
    };
    let world = specimen::world(scenario, transport, start)?;
    let steps = derived::steps(scenario);
    let outputs = if root { Outputs::create(&options.out, steps).map(Some) } else { Ok(None) };
    let outputs = transfer::agree(transport, outputs)?;
    let mut run = Run::new(scenario, options, world, progress, outputs)?;
    run.write_frame()?;
    run.go()
}

/// Continues a run from its newest good checkpoint, on any number of ranks and threads.
pub fn resume(dir: &Path, options: &Options, transport: &dyn Transport) -> Result<Outcome, Error> {
    let root = transport.rank() == 0;
    let read = if root { checkpoint::latest(dir).map(Some) } else { Ok(None) };
    let snapshot = transfer::agree(transport, read)?.map(|(_, snapshot)| snapshot);
    let text = snapshot.as_ref().map(|snapshot| snapshot.scenario.clone().into_bytes()).unwrap_or_default();
    let text = String::from_utf8_lossy(&transport.broadcast(text)).into_owned();
    let name = dir.join("scenario.toml").display().to_string();
    let scenario = Scenario::parse(&text, &name, &[])?;

    let (progress, saved, grains, points): (Vec<Progress>, _, Vec<Grain>, Vec<PlanarPoint>) = match snapshot {
        Some(snapshot) => (vec![snapshot.progress], snapshot.plates, snapshot.grains, snapshot.points),
        None => Default::default(),
    };
    let progress = transfer::broadcast(transport, progress)?.remove(0);
    let saved = transfer::broadcast(transport, saved)?;
    if progress.step >= derived::steps(&scenario) {
        return Ok(Outcome::Done(format!("{}: this run is done already; nothing was changed.", dir.display())));
    }
    let mut plates = specimen::plates(&scenario, progress.height_start);
    for (plate, saved) in plates.iter_mut().zip(saved) {
        plate.take_motion_of(&saved);
    }
    let layout = layout_for(&scenario, progress.height_start)?;
    let settings = settings_for(&scenario, scenario.contact.friction());
    let parts = Parts { grains, points, plates };
    let world = PlanarWorld::new(settings, layout, transport, progress.step, parts)?;
    let steps = derived::steps(&scenario);
    let outputs = if root { Outputs::resume(dir, &progress, steps).map(Some) } else { Ok(None) };
    let outputs = transfer::agree(transport, outputs)?;
    Run::new(&scenario, options, world, progress, outputs)?.go()
}

/// Tracks taken over a whole run before they are thinned.
const TRACKS: u64 = 256;
/// Steps between two looks at the progress display.
const SHOW_EVERY: u64 = 2000;

impl Cargo for Progress {
    fn blank() -> Self {
        Self::default()
    }
    fn pack_rest(&mut self, to: &mut Writer) {
        to.u64_slice(&self.oracle.flagged);
        to.f64_slice(&self.instants.times);
    }
    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), scree_partition::ParcelError> {
        self.oracle.flagged = from.u64_slice()?;
        self.instants.times = from.f64_slice()?;
        Ok(())
    }
}

/// Intervals of simulated time as whole steps.
struct Cadence {
    series: u64,
    frame: u64,
    checkpoint: u64,
}

/// A run under way.
struct Run<'s, 't> {
    scenario: &'s Scenario,
    options: &'s Options,
    world: PlanarWorld<'t>,
    progress: Progress,
    /// On rank 0.
    outputs: Option<Outputs>,
    steps: u64,
    cadence: Cadence,
    stop: Arc<AtomicBool>,
    started: Instant,
    first_step: u64,
}

impl<'s, 't> Run<'s, 't> {
    fn new(
        scenario: &'s Scenario,
        options: &'s Options,
        world: PlanarWorld<'t>,
        progress: Progress,
        outputs: Option<Outputs>,
    ) -> Result<Self, Error> {
        let every = |interval: f64| ((interval / scenario.time.step).round() as u64).max(1);
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
            signal_hook::flag::register(signal, Arc::clone(&stop))
                .map_err(|error| Error::Run(format!("cannot listen for signals: {error}")))?;
        }
        Ok(Self {
            scenario,
            options,
            first_step: world.step,
            world,
            progress,
            outputs,
            steps: derived::steps(scenario),
            cadence: Cadence {
                series: every(scenario.output.series_interval),
                frame: every(scenario.output.frame_interval),
                checkpoint: every(scenario.output.checkpoint_interval),
            },
            stop,
            started: Instant::now(),
        })
    }

    fn go(mut self) -> Result<Outcome, Error> {
        while self.world.step < self.steps {
            self.world.stop_wanted = self.stop.load(Ordering::Relaxed);
            self.world.advance()?;
            self.watch()?;
            self.observe()?;
            if self.world.stop_agreed && self.world.step < self.steps {
                return self.stopped();
            }
        }
        self.done()
    }

    /// Tracks, oracle, enrichment.
    fn watch(&mut self) -> Result<(), Error> {
        if self.scenario.method != Method::Hybrid || self.progress.enriched_step > 0 {
            return Ok(());
        }
        enrichment::track(&mut self.world, &mut self.progress.instants);
        let settings = &self.scenario.oracle;
        if !self.world.step.is_multiple_of(settings.every) {
            return Ok(());
        }
        let diameter = self.scenario.grains.diameter_mean;
        if enrichment::watch(&mut self.world, &mut self.progress.oracle, settings, diameter)? {
            self.enrich()?;
        }
        Ok(())
    }

    fn enrich(&mut self) -> Result<(), Error> {
        self.write_frame()?;
        let strain = self.strain();
        tracing::info!(step = self.world.step, strain, "shear band found; training grains for it");
        let file = output::packing_file(&self.options.out);
        let flagged = &self.progress.oracle.flagged;
        let started = Instant::now();
        let enriched = enrichment::enrich(&mut self.world, self.scenario, flagged, &self.progress.instants, &file)?;
        self.progress.enriched_step = self.world.step;
        let seconds = started.elapsed().as_secs_f64();
        self.record_enrichment(&enriched, strain, seconds)?;
        self.write_frame()
    }

    fn record_enrichment(&mut self, enriched: &Enriched, strain: f64, seconds: f64) -> Result<(), Error> {
        let (step, time) = (self.world.step, self.world.time());
        let figures = json!({
            "enriched_at_strain": strain,
            "enriched_at_time": time,
            "enriched_grains": enriched.grains,
            "enriched_grains_rim": enriched.grains_rim,
            "enriched_points_removed": enriched.points_removed,
            "enriched_points_rim": enriched.points_rim,
            "enriched_mass_before": enriched.mass_before,
            "enriched_mass_after": enriched.mass_after,
            "enriched_momentum_x_before": enriched.momentum_before[0],
            "enriched_momentum_x_after": enriched.momentum_after[0],
            "training_shear_stress_points": enriched.stress_points[2],
            "training_shear_stress_grains": enriched.stress_grains[2],
            "training_normal_stress_points": enriched.stress_points[1],
            "training_normal_stress_grains": enriched.stress_grains[1],
            "training_lateral_stress_points": enriched.stress_points[0],
            "training_lateral_stress_grains": enriched.stress_grains[0],
            "training_energy_ratio": enriched.training_energy_ratio,
            "training_steps": enriched.training_steps,
            "training_seconds": seconds,
        });
        self.on_root(|outputs| {
            outputs.log("enriched", step, figures.clone())?;
            outputs.note(figures);
            outputs.write_summary()
        })
    }

    /// Rows, frames and checkpoints that are due.
    fn observe(&mut self) -> Result<(), Error> {
        let step = self.world.step;
        if step.is_multiple_of(self.cadence.series) || step == self.steps {
            self.write_row()?;
        }
        if step.is_multiple_of(self.cadence.frame) || step == self.steps {
            self.write_frame()?;
        }
        if step.is_multiple_of(self.cadence.checkpoint) || step == self.steps {
            self.save()?;
        }
        if step.is_multiple_of(SHOW_EVERY)
            && let Some(outputs) = &mut self.outputs
        {
            let strain = self.world.plates[UPPER as usize].displacement[0] / self.scenario.specimen.width;
            let (grains, points) = (self.world.grains_total, self.world.points_total);
            outputs.show(step, || format!("strain {:.2} %, {grains} grains, {points} points", 100.0 * strain));
        }
        Ok(())
    }

    /// Horizontal strain: displacement of the upper plate over the width.
    fn strain(&self) -> f64 {
        self.world.plates[UPPER as usize].displacement[0] / self.scenario.specimen.width
    }

    fn write_row(&mut self) -> Result<(), Error> {
        let timer = self.world.phases.start();
        let energies = self.world.energies()?;
        let step = self.world.step;
        let duration = (step - self.progress.series_step) as f64 * self.scenario.time.step;
        let scale = 1.0 / (duration * self.scenario.specimen.width * self.scenario.specimen.depth);
        let strain = self.strain();
        let plate = &mut self.world.plates[UPPER as usize];
        let impulse = std::mem::replace(&mut plate.impulse, crate::space::Linear::zero());
        let row = [
            step as f64,
            step as f64 * self.scenario.time.step,
            strain,
            -impulse[0] * scale,
            impulse[1] * scale,
            plate.face / self.progress.height_start - 1.0,
            self.world.grains_total as f64,
            self.world.points_total as f64,
            energies.kinetic_grains,
            energies.elastic_grains,
            energies.kinetic_points,
            energies.elastic_points,
        ];
        self.progress.series_step = step;
        self.progress.series_rows += 1;
        let outcome = self.on_root(|outputs| outputs.row(&row));
        self.world.phases.stop(Phase::Output, timer);
        outcome
    }

    fn write_frame(&mut self) -> Result<(), Error> {
        let timer = self.world.phases.start();
        let made = frame(&mut self.world, self.scenario.specimen.depth, self.progress.fraction_start)?;
        self.progress.frames += 1;
        let outcome = self.on_root(|outputs| made.map_or(Ok(()), |frame| outputs.frame(&frame)));
        self.world.phases.stop(Phase::Output, timer);
        outcome
    }

    /// Writes a checkpoint of the state as it is.
    fn save(&mut self) -> Result<(), Error> {
        let timer = self.world.phases.start();
        // The checkpoint counts rows; they must be on disk before it is.
        self.on_root(|outputs| outputs.sync())?;
        self.progress.step = self.world.step;
        let (grains, points) = self.world.rows();
        let grains = transfer::gather(self.world.transport, grains)?;
        let points = transfer::gather(self.world.transport, points)?;
        let written = match (grains, points) {
            (Some(grains), Some(points)) => self.write_checkpoint(grains, points),
            _ => Ok(()),
        };
        let outcome = transfer::agree(self.world.transport, written);
        self.world.phases.stop(Phase::Output, timer);
        outcome
    }

    fn write_checkpoint(&mut self, grains: Vec<Grain>, points: Vec<PlanarPoint>) -> Result<(), Error> {
        let snapshot = Snapshot {
            scenario: self.scenario.to_toml(),
            progress: self.progress.clone(),
            plates: self.world.plates.clone(),
            grains,
            points,
        };
        let folder = checkpoint::folder(&self.options.out);
        let path = folder.join(store::file_name(self.world.step));
        store::write(&path, &snapshot.to_state()).map_err(|error| Error::Run(error.to_string()))?;
        store::prune(&folder, self.scenario.output.checkpoints_kept).map_err(|error| Error::Run(error.to_string()))?;
        Ok(())
    }

    /// What only rank 0 does, with an outcome that all ranks share.
    fn on_root(&mut self, work: impl FnOnce(&mut Outputs) -> Result<(), Error>) -> Result<(), Error> {
        let outcome = self.outputs.as_mut().map_or(Ok(()), work);
        transfer::agree(self.world.transport, outcome)
    }

    fn stopped(mut self) -> Result<Outcome, Error> {
        self.save()?;
        self.close("stopped")?;
        Ok(Outcome::Stopped(format!(
            "Stopped on request at step {} of {}, strain {:.3} %. Continue with `scree resume {}`.",
            self.world.step,
            self.steps,
            100.0 * self.strain(),
            self.options.out.display()
        )))
    }

    fn done(mut self) -> Result<Outcome, Error> {
        let seconds = self.close("done")?;
        let world = &self.world;
        Ok(Outcome::Done(format!(
            "Done: {} steps in {seconds:.1} s, horizontal strain {:.2} %, {} grains and {} points at the end.\nResults are in {}; `scree report {}` draws them.",
            world.step - self.first_step,
            100.0 * self.strain(),
            world.grains_total,
            world.points_total,
            self.options.out.display(),
            self.options.out.display()
        )))
    }

    /// Last words on disk; returns the wall time of this stretch, s.
    fn close(&mut self, outcome: &str) -> Result<f64, Error> {
        let seconds = self.started.elapsed().as_secs_f64();
        let world = &self.world;
        let steps = world.step - self.first_step;
        let mut figures = json!({
            "outcome": outcome,
            "steps": world.step,
            "simulated_time": world.time(),
            "strain": self.strain(),
            "wall_seconds": seconds,
            "ranks": world.transport.size(),
            "threads": self.options.threads,
            "grains": world.grains_total,
            "points": world.points_total,
            "rebuilds": world.rebuilds,
            "microseconds_per_step": 1e6 * seconds / steps.max(1) as f64,
        });
        for (name, seconds) in phases::NAMES.iter().zip(world.phases.seconds) {
            figures[format!("seconds_{name}")] = json!(seconds);
        }
        let step = world.step;
        let outcome = outcome.to_string();
        self.on_root(|outputs| {
            outputs.finish();
            outputs.log(&outcome, step, figures.clone())?;
            outputs.note(figures);
            outputs.write_summary()
        })?;
        Ok(seconds)
    }
}
