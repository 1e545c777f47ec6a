//! Planar shear between rough plates (seed 000, 6.1): start, resume, the oracle's watch, and what a run shows.

use scree_io::frames::Frame;
use scree_partition::Transport;
use serde_json::{Value, json};

use crate::checkpoint::{Progress, Snapshot};
use crate::dem::packing::UPPER;
use crate::enrichment::{self, Enriched};
use crate::error::Error;
use crate::hybrid::track::Instants;
use crate::law::contact::ContactLaw;
use crate::law::material::{CriticalDruckerPrager, CriticalMemory};
use crate::log::Log;
use crate::observe::frame::frame;
use crate::observe::ledger::{Balance, SPENT};
use crate::observe::phases::Phase;
use crate::output;
use crate::packing::{self, PlanarWorld, cell_of, layout_for, settings_of_run};
use crate::rebuild::{Home, Parts};
use crate::run::{self, Core, Experiment, Options, Outcome};
use crate::scenario::{Method, Output, Scenario, derived};
use crate::space::{Linear, Plane};
use crate::specimen;
use crate::transfer;
use crate::watch;

/// Tracks taken over a whole run before they are thinned.
const TRACKS: u64 = 256;

/// Columns of `series.csv`.
const HEADER: [&str; 12] = [
    "step",
    "time",
    "strain",
    "shear_stress",
    "normal_stress",
    "volume_strain",
    "grains",
    "points",
    "kinetic_grains",
    "elastic_grains",
    "kinetic_points",
    "elastic_points",
];

/// Columns of the work of the account of the grains' energy since the start, or since they entered, J, before those of
/// [`SPENT`].
const WORK: [&str; 2] = ["work_bodies", "work_nodes"];

/// The job, with the contact law it names.
pub struct PlanarShear<'s, C> {
    scenario: &'s Scenario,
    law: std::marker::PhantomData<C>,
}

type PlanarCore<'t, C> = Core<'t, Plane, C, CriticalDruckerPrager>;
/// A run's state with the memories of a law.
pub type PlanarSnapshot<C> = Snapshot<Plane, <C as ContactLaw<Plane>>::Memory<f64>, CriticalMemory<Plane>>;

/// Runs a job from its start.
pub fn start<C: ContactLaw<Plane>>(
    scenario: &Scenario,
    options: &Options,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let root = transport.rank() == 0;
    let mut start = specimen::prepare::<C>(scenario, transport)?;
    // Only now, so that a job whose packing cannot be made leaves no folder behind.
    let claimed = if root { output::claim(&options.out, &scenario.to_toml()) } else { Ok(()) };
    transfer::agree(transport, claimed)?;
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
    let mut world = specimen::world(scenario, transport, start)?;
    if scenario.ledger {
        world.open_ledger();
    }
    let experiment = PlanarShear { scenario, law: std::marker::PhantomData::<C> };
    run::begin(experiment, world, progress, options)
}

/// Continues a run from a snapshot that rank 0 holds.
pub fn resume<C: ContactLaw<Plane>>(
    scenario: &Scenario,
    snapshot: Option<PlanarSnapshot<C>>,
    options: &Options,
    log: Option<Log>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let (mut world, progress) = world_of(scenario, snapshot, transport)?;
    if scenario.ledger {
        world.resume_ledger(&progress.ledger)?;
    }
    let experiment = PlanarShear { scenario, law: std::marker::PhantomData::<C> };
    run::go_on_with(experiment, world, progress, options, log)
}

/// The world of a snapshot that rank 0 holds, and how far its run is.
pub fn world_of<'t, C: ContactLaw<Plane>>(
    scenario: &Scenario,
    snapshot: Option<PlanarSnapshot<C>>,
    transport: &'t dyn Transport,
) -> Result<(PlanarWorld<'t, C>, Progress), Error> {
    let (progress, saved, at_home, grains, points) = match snapshot {
        Some(snapshot) => {
            (vec![snapshot.progress], snapshot.bodies, vec![snapshot.home], snapshot.grains, snapshot.points)
        }
        None => Default::default(),
    };
    let progress = transfer::broadcast(transport, progress)?.remove(0);
    let saved = transfer::broadcast(transport, saved)?;
    let at_home = transfer::broadcast(transport, at_home)?.remove(0);
    let mut bodies = specimen::bodies(scenario, progress.height_start);
    for (body, saved) in bodies.iter_mut().zip(saved) {
        body.take_motion_of(&saved);
    }
    let layout = layout_for(scenario, progress.height_start)?;
    let settings = settings_of_run(scenario);
    let cell = cell_of(&layout);
    let home = Home { cell, bodies: at_home.bodies };
    let parts = Parts { grains, points, bodies, cell, home };
    Ok((PlanarWorld::new(settings, layout, transport, progress.step, parts)?, progress))
}

impl<C: ContactLaw<Plane>> PlanarShear<'_, C> {
    /// Horizontal strain: displacement of the upper plate over the width.
    fn strain(&self, core: &PlanarCore<C>) -> f64 {
        core.world.bodies[UPPER as usize].displacement[0] / self.scenario.specimen.width
    }

    fn enrich(&mut self, core: &mut PlanarCore<C>) -> Result<(), Error> {
        let made = self.frame(core)?;
        core.write_frame(made)?;
        let strain = self.strain(core);
        tracing::info!(step = core.world.step, strain, "shear band found; training grains for it");
        let file = output::packing_file(&core.options.out);
        let (flagged, instants) = (&core.progress.oracle.flagged, &core.progress.instants);
        let stepped = core.world.phases.total() - core.world.phases.of(Phase::Output);
        let started = std::time::Instant::now();
        let enriched = enrichment::enrich(&mut core.world, self.scenario, flagged, instants, &file)?;
        core.progress.enriched_step = core.world.step;
        if self.scenario.ledger {
            // The grains that are there now have an account from here on.
            core.world.open_ledger();
        }
        let seconds = started.elapsed().as_secs_f64();
        Self::record(core, &enriched, strain, [stepped, seconds])?;
        let made = self.frame(core)?;
        core.write_frame(made)
    }

    /// `stepped`: seconds of the steps until then, `seconds`: of the training.
    fn record(
        core: &mut PlanarCore<C>,
        enriched: &Enriched,
        strain: f64,
        [stepped, seconds]: [f64; 2],
    ) -> Result<(), Error> {
        let (step, time) = (core.world.step, core.world.time());
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
            "seconds_of_steps_before_enrichment": stepped,
        });
        core.on_root(|outputs| {
            outputs.log("enriched", step, figures.clone())?;
            outputs.note(figures);
            outputs.write_summary()
        })
    }
}

impl<C: ContactLaw<Plane>> Experiment for PlanarShear<'_, C> {
    type Space = Plane;
    type Contact = C;
    type Material = CriticalDruckerPrager;

    fn job(&self) -> String {
        self.scenario.to_toml()
    }

    fn output(&self) -> &Output {
        &self.scenario.output
    }

    fn steps(&self) -> u64 {
        derived::steps(self.scenario)
    }

    fn header(&self) -> Vec<String> {
        let mut names: Vec<String> = HEADER.map(String::from).into();
        if self.scenario.ledger {
            names.extend(WORK.into_iter().chain(SPENT).map(String::from));
        }
        names
    }

    /// Tracks, oracle, enrichment.
    fn watch(&mut self, core: &mut PlanarCore<C>) -> Result<(), Error> {
        if self.scenario.method != Method::Hybrid || core.progress.enriched_step > 0 {
            return Ok(());
        }
        enrichment::track(&mut core.world, &mut core.progress.instants);
        let settings = &self.scenario.oracle;
        if !core.world.is_due(settings.every) {
            return Ok(());
        }
        let diameter = self.scenario.grains.diameter_mean;
        if watch::watch(&mut core.world, &mut core.progress.oracle, settings, diameter)? {
            self.enrich(core)?;
        }
        Ok(())
    }

    fn row(&mut self, core: &mut PlanarCore<C>) -> Result<Vec<f64>, Error> {
        let strain = self.strain(core);
        let energies = core.world.energies()?;
        let step = core.world.step;
        let duration = (step - core.progress.series_step) as f64 * self.scenario.time.step;
        let scale = 1.0 / (duration * self.scenario.specimen.width * self.scenario.specimen.depth);
        let plate = &mut core.world.bodies[UPPER as usize];
        let impulse = std::mem::replace(&mut plate.impulse, Linear::zero());
        let mut row = vec![
            step as f64,
            step as f64 * self.scenario.time.step,
            strain,
            -impulse[0] * scale,
            impulse[1] * scale,
            plate.face() / core.progress.height_start - 1.0,
            core.world.grains_total as f64,
            core.world.points_total as f64,
            energies.kinetic_grains,
            energies.elastic_grains,
            energies.kinetic_points,
            energies.elastic_points,
        ];
        if self.scenario.ledger {
            // None before the first step, nor right after an enrichment.
            let balance = if core.world.has_balance() { core.world.balance()? } else { Balance::default() };
            row.extend([balance.work_bodies, balance.work_nodes]);
            row.extend(balance.spent());
        }
        Ok(row)
    }

    fn frame(&mut self, core: &mut PlanarCore<C>) -> Result<Option<Frame>, Error> {
        let may_have_points = self.scenario.method != Method::Dem;
        frame(&mut core.world, self.scenario.specimen.depth, core.progress.fraction_start, may_have_points)
    }

    fn words(&self, core: &PlanarCore<C>) -> String {
        let (grains, points) = (core.world.grains_total, core.world.points_total);
        format!("horizontal strain {:.2} %, {grains} grains and {points} points", 100.0 * self.strain(core))
    }

    fn figures(&self, core: &PlanarCore<C>) -> Value {
        json!({ "strain": self.strain(core) })
    }
}
