//! Planar shear between rough plates (Chen et al. 2021, 6.1): start, resume, the oracle's watch, and what a run shows.

use scree_io::column::State;
use scree_io::frames::Frame;
use scree_partition::Transport;
use serde_json::{Value, json};

use crate::base::error::Error;
use crate::base::space::{Linear, Plane};
use crate::dem::law::memory_words;
use crate::domain::accounts::ledger::{Balance, SPENT};
use crate::domain::transfer;
use crate::job::{Method, Output, Scenario, derived};
use crate::law::material::{CriticalDruckerPrager, CriticalMemory};
use crate::mpm::membrane::Membranes;
use crate::mpm::track::Instants;
use crate::observe::frame::frame;
use crate::prepare::loose::UPPER;
use crate::prepare::plates;
use crate::prepare::reference::Lies;
use crate::prepare::sheared::{self, PlanarWorld, cell_of, layout_for, settings_of_run};
use crate::run::adaptive::{Adaptive, Finder};
use crate::run::folder::Folder;
use crate::run::{self, Core, Experiment, Options, Outcome};
use crate::store::checkpoint::{self, Drawn, Progress, Snapshot};

/// Tracks taken over a whole run before they are thinned.
pub(crate) const TRACKS: u64 = 256;

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

/// The job.
pub struct PlanarShear<'s> {
    scenario: &'s Scenario,
}

type PlanarCore<'t> = Core<'t, Plane, CriticalDruckerPrager>;
/// A run's state.
pub type PlanarSnapshot = Snapshot<Plane, CriticalMemory<Plane>>;

/// Runs a job from its start.
pub fn start(
    scenario: &Scenario,
    options: &Options,
    folder: &mut Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let mut start = plates::prepare(scenario, transport)?;
    if let (Method::Hybrid, made) = (scenario.method, &mut start.packing) {
        let write = |folder: &mut Folder| {
            folder.write_packing(&sheared::state_of(&mut made.grains, &scenario.contact, made.height, &mut []))
        };
        transfer::agree(transport, folder.as_mut().map_or(Ok(()), write))?;
    }
    let progress = Progress {
        height_start: start.height,
        fraction_start: start.fraction,
        instants: Instants { times: Vec::new(), every: (derived::steps(scenario) / TRACKS).max(1) },
        ..Progress::default()
    };
    let mut world = plates::world(scenario, transport, start)?;
    if scenario.ledger {
        world.open_ledger();
    }
    let experiment = PlanarShear { scenario };
    run::begin(experiment, world, progress, options, folder)
}

/// Continues a run from a state that rank 0 holds.
pub fn resume(
    scenario: &Scenario,
    state: Option<State>,
    options: &Options,
    folder: Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let read = |state| Snapshot::from_state(state, memory_words::<Plane>(&scenario.contact));
    let snapshot = transfer::agree(transport, state.map(read).transpose())?;
    let (mut world, progress) = world_of(scenario, snapshot, transport)?;
    if scenario.ledger {
        world.resume_ledger(&progress.ledger)?;
    }
    let experiment = PlanarShear { scenario };
    run::go_on_with(experiment, world, progress, options, folder)
}

/// The world of a snapshot that rank 0 holds, and how far its run is.
pub fn world_of<'t>(
    scenario: &Scenario,
    snapshot: Option<PlanarSnapshot>,
    transport: &'t dyn Transport,
) -> Result<(PlanarWorld<'t>, Progress), Error> {
    let draw = |progress: &Progress, _| {
        let cell = cell_of(&layout_for(scenario, progress.height_start)?);
        Ok(Drawn { cell, bodies: plates::bodies(scenario, progress.height_start), membranes: Membranes::default() })
    };
    let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
    let layout = layout_for(scenario, progress.height_start)?;
    let settings = settings_of_run(scenario);
    Ok((PlanarWorld::new(settings, layout, transport, progress.step, parts)?, progress))
}

impl PlanarShear<'_> {
    /// Horizontal strain: displacement of the upper plate over the width.
    fn strain(&self, core: &PlanarCore) -> f64 {
        core.world.bodies[UPPER as usize].displacement[0] / self.scenario.specimen.width
    }
}

impl Experiment for PlanarShear<'_> {
    type Space = Plane;
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
    fn watch(&mut self, core: &mut PlanarCore) -> Result<(), Error> {
        if self.scenario.method != Method::Hybrid {
            return Ok(());
        }
        let Scenario { oracle, enrichment, grains, specimen, packing, .. } = self.scenario;
        let finder = Finder::Oracle(oracle, grains.diameter_mean);
        let lies = if packing.height.is_some() { Lies::Around } else { Lies::Whole };
        let how = Adaptive { finder, enrichment, lies, depth: specimen.depth };
        let strain = self.strain(core);
        if how.adapt(self, core, Some(strain))? && self.scenario.ledger {
            // The grains that are there now have an account from here on.
            core.world.open_ledger();
        }
        Ok(())
    }

    fn row(&mut self, core: &mut PlanarCore) -> Result<Vec<f64>, Error> {
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

    fn frame(&mut self, core: &mut PlanarCore) -> Result<Option<Frame>, Error> {
        let may_have_points = self.scenario.method != Method::Dem;
        frame(&mut core.world, self.scenario.specimen.depth, core.progress.fraction_start, may_have_points)
    }

    fn words(&self, core: &PlanarCore) -> String {
        let (grains, points) = (core.world.grains_total, core.world.points_total);
        format!("horizontal strain {:.2} %, {grains} grains and {points} points", 100.0 * self.strain(core))
    }

    fn figures(&self, core: &PlanarCore) -> Value {
        json!({ "strain": self.strain(core) })
    }
}
