//! Planar shear between rough plates (Chen et al. 2021, 6.1).

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Space};
use crate::dem::law::{SharedLaw, law_of};
use crate::domain::accounts::ledger::Accounts;
use crate::domain::grid;
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::job::{Method, Scenario, derived};
use crate::mpm::membrane::{Membranes, Vertex};
use crate::mpm::stress::{SharedMaterial, material_of};
use crate::mpm::track::Instants;
use crate::prepare::loose::UPPER;
use crate::prepare::plates;
use crate::prepare::reference::Lies;
use crate::prepare::sheared::{self, PlanarWorld, cell_of, layout_for, settings_of_run};
use crate::run::Core;
use crate::run::adaptive::{Adaptive, Finder};
use crate::run::columns::{self, Columns, Work};
use crate::run::experiment::{Experiment, Picture, Setup};
use crate::run::folder::Folder;
use crate::store::checkpoint::{Drawn, Progress};

/// Tracks taken over a whole run before they are thinned.
pub(crate) const TRACKS: u64 = 256;

/// Works of the account of the grains' energy.
const WORKS: [Work; 2] = [("work_bodies", |balance| balance.work_bodies), ("work_nodes", |balance| balance.work_nodes)];

type PlanarCore<'t> = Core<'t, Plane>;

impl Setup for Scenario {
    type Space = Plane;

    fn experiment(&self) -> Experiment<'_, Plane> {
        let mut columns = vec![plate(self), columns::counts(), columns::energies()];
        if self.ledger {
            columns.push(columns::account_of_grains(&WORKS));
        }
        columns.extend((self.method == Method::Hybrid).then(columns::shear_in_zones));
        Experiment {
            job: self.to_toml(),
            output: &self.output,
            steps: derived::steps(self),
            accounts: Accounts { grains: self.ledger, points: false },
            allows_unstable: false,
            picture: Picture {
                depth: self.specimen.depth,
                may_have_grains: true,
                may_have_points: self.method != Method::Dem,
                has_elements: false,
                flagged: false,
            },
            drawn_rves: Vec::new(),
            columns,
            watch: Box::new(|core| watch(self, core)),
            strain: Some(Box::new(|world| strain(self, world))),
        }
    }

    fn law(&self) -> SharedLaw<Plane> {
        law_of(&self.contact)
    }

    fn material(&self) -> SharedMaterial<Plane> {
        material_of(&self.material.law)
    }

    fn begin<'t>(
        &self,
        folder: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(PlanarWorld<'t>, Progress), Error> {
        let mut start = plates::prepare(self, transport)?;
        if let (Method::Hybrid, made) = (self.method, &mut start.packing) {
            let write = |folder: &mut Folder| {
                folder.write_packing(&sheared::state_of(&mut made.grains, &self.contact, made.height, &mut []))
            };
            transfer::agree(transport, folder.as_mut().map_or(Ok(()), write))?;
        }
        let progress = Progress {
            height_start: start.height,
            fraction_start: start.fraction,
            instants: Instants { times: Vec::new(), every: (derived::steps(self) / TRACKS).max(1) },
            ..Progress::default()
        };
        Ok((plates::world(self, transport, start)?, progress))
    }

    fn drawn(&self, progress: &Progress, _: Vec<Vertex<Plane>>) -> Result<Drawn<Plane>, Error> {
        let cell = cell_of(&layout_for(self, progress.height_start)?);
        Ok(Drawn { cell, bodies: plates::bodies(self, progress.height_start), membranes: Membranes::default() })
    }

    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<Plane>,
        transport: &'t dyn Transport,
    ) -> Result<PlanarWorld<'t>, Error> {
        let layout = layout_for(self, progress.height_start)?;
        let mut world = PlanarWorld::new(settings_of_run(self), layout, transport, progress.step, parts)?;
        plates::keep_step(self, &mut world);
        Ok(world)
    }
}

/// Horizontal strain: displacement of the upper plate over the width.
fn strain(scenario: &Scenario, world: &PlanarWorld) -> f64 {
    world.bodies[UPPER as usize].displacement[0] / scenario.specimen.width
}

/// Step, time (s), strain, what the upper plate takes over its area since the last row (Pa), and volume strain.
fn plate(scenario: &Scenario) -> Columns<'_, Plane> {
    let names = ["step", "time", "strain", "shear_stress", "normal_stress", "volume_strain"];
    Columns::new(names, |core| {
        let (strain, step, dt) = (strain(scenario, &core.world), core.world.step, scenario.time.step);
        let duration = (step - core.progress.series_step) as f64 * dt;
        let scale = 1.0 / (duration * scenario.specimen.width * scenario.specimen.depth);
        // Of a plate at a grid the account of nodes has it all, else its own.
        let reactions = core.world.take_reactions()?;
        core.progress.kept.take(&reactions);
        let plate = &mut core.world.bodies[UPPER as usize];
        let mut impulse = std::mem::replace(&mut plate.impulse, Linear::zero());
        let (booked, _) = grid::body_impulse(&reactions, UPPER as usize);
        (0..Plane::DIMENSION).for_each(|axis| impulse[axis] += booked[axis]);
        let volume_strain = plate.face() / core.progress.height_start - 1.0;
        Ok(vec![step as f64, step as f64 * dt, strain, -impulse[0] * scale, impulse[1] * scale, volume_strain])
    })
}

/// Tracks, oracle, enrichment.
fn watch(scenario: &Scenario, core: &mut PlanarCore) -> Result<(), Error> {
    if scenario.method != Method::Hybrid {
        return Ok(());
    }
    let Scenario { oracle, enrichment, grains, specimen, packing, .. } = scenario;
    let finder = Finder::Oracle(oracle, grains.diameter_mean);
    let lies = if packing.height.is_some() { Lies::Around } else { Lies::Whole };
    let how = Adaptive { finder, enrichment, lies, depth: specimen.depth };
    let strain = strain(scenario, &core.world);
    how.adapt(core, Some(strain))?;
    plates::keep_step(scenario, &mut core.world);
    Ok(())
}
