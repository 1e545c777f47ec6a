//! A run that watches for a shear band and puts grains in its place (seed 000, sections 3 and 4): tracks of the points, looks of
//! the oracle, and once a band persists or one that is known is due, the enrichment with its account.

use serde_json::json;

use crate::enrichment::{self, Enriched};
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::CriticalDruckerPrager;
use crate::observe::phases::Phase;
use crate::output;
use crate::reference::Lies;
use crate::run::{Core, Experiment};
use crate::scenario::mpm::KnownBands;
use crate::scenario::{Enrichment, Oracle};
use crate::space::Plane;
use crate::watch;

/// What tells where a band is.
pub enum Finder<'s> {
    /// The oracle, for grains of a D50 (m).
    Oracle(&'s Oracle, f64),
    /// The job.
    Known(&'s KnownBands),
}

/// What becomes of a band.
pub struct Adaptive<'s> {
    pub finder: Finder<'s>,
    pub enrichment: &'s Enrichment,
    /// How the packing that grains are taken from lies in the specimen.
    pub lies: Lies<'s>,
    /// Of the plane, m.
    pub depth: f64,
}

type PlanarCore<'t, C> = Core<'t, Plane, C, CriticalDruckerPrager>;

impl Adaptive<'_> {
    /// What is due after a step; whether grains have just taken the place of points. `strain` is told with them. Collective.
    pub fn adapt<C, E>(&self, experiment: &mut E, core: &mut PlanarCore<C>, strain: Option<f64>) -> Result<bool, Error>
    where
        C: ContactLaw<Plane>,
        E: Experiment<Space = Plane, Contact = C, Material = CriticalDruckerPrager>,
    {
        if core.progress.enriched_step > 0 {
            return Ok(false);
        }
        enrichment::track(&mut core.world, &mut core.progress.instants);
        let found = match self.finder {
            Finder::Oracle(oracle, _) if !core.world.is_due(oracle.every) => false,
            Finder::Oracle(oracle, diameter) => {
                watch::watch(&mut core.world, &mut core.progress.oracle, oracle, diameter)?
            }
            Finder::Known(bands) => {
                let due = core.world.time() >= bands.at;
                if due {
                    core.progress.oracle.flagged = enrichment::cell_grid(&core.world).nodes_along(&bands.parts);
                }
                due
            }
        };
        if found {
            self.enrich(experiment, core, strain)?;
        }
        Ok(found)
    }

    /// Frames on either side show what has changed.
    fn enrich<C, E>(&self, experiment: &mut E, core: &mut PlanarCore<C>, strain: Option<f64>) -> Result<(), Error>
    where
        C: ContactLaw<Plane>,
        E: Experiment<Space = Plane, Contact = C, Material = CriticalDruckerPrager>,
    {
        let made = experiment.frame(core)?;
        core.write_frame(made)?;
        let what = match self.finder {
            Finder::Oracle(..) => "shear band found; training grains for it",
            Finder::Known(_) => "training grains for known shear bands",
        };
        tracing::info!(step = core.world.step, strain, "{what}");
        let file = output::packing_file(&core.options.out);
        let (flagged, instants) = (&core.progress.oracle.flagged, &core.progress.instants);
        let stepped = core.world.phases.total() - core.world.phases.of(Phase::Output);
        let started = std::time::Instant::now();
        let how = (self.enrichment, self.depth);
        let enriched = enrichment::enrich(&mut core.world, how, flagged, instants, (&file, self.lies))?;
        core.progress.enriched_step = core.world.step;
        let seconds = started.elapsed().as_secs_f64();
        record(core, &enriched, strain, [stepped, seconds])?;
        let made = experiment.frame(core)?;
        core.write_frame(made)
    }
}

/// `stepped`: seconds of the steps until then, `seconds`: of the training.
fn record<C: ContactLaw<Plane>>(
    core: &mut PlanarCore<C>,
    enriched: &Enriched,
    strain: Option<f64>,
    [stepped, seconds]: [f64; 2],
) -> Result<(), Error> {
    let (step, time) = (core.world.step, core.world.time());
    let mut figures = json!({
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
    if let Some(strain) = strain {
        figures["enriched_at_strain"] = json!(strain);
    }
    core.on_root(|outputs| {
        outputs.log("enriched", step, figures.clone())?;
        outputs.note(figures);
        outputs.write_summary()
    })
}
