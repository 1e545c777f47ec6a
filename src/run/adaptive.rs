//! A run that watches for a shear band and puts grains in its place (Chen et al. 2021, sections 3 and 4): tracks of the points, looks of
//! the oracle, and once a band persists or one that is known is due, the enrichment with its account. A zone that lives (beyond that
//! paper) goes on from there: it grows where the oracle finds a band beyond it, and its grains turn back into points where they rest. Or
//! it begins everywhere, so that where a band forms is up to the grains, and points take the places of those that rest beside it, and give them up again
//! where cells shear that are not of grains alone.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::adapt::enrichment::{self, BeforeAndAfter, Enriched, Plan, Refusal, Wanted};
use crate::adapt::flow::Flow;
use crate::adapt::{shear, watch};
use crate::base::error::Error;
use crate::base::space::{Plane, Space};
use crate::couple::oracle::Oracle;
use crate::couple::rest::RestWatch;
use crate::couple::zone::{Enrichment, ZoneLife};
use crate::domain::phases::Phase;
use crate::job::mpm::KnownBands;
use crate::mpm::track::Instants;
use crate::prepare::reference::Lies;
use crate::run::Core;
use crate::run::folder::packing_file;

/// What tells where a band is.
pub enum Finder<'s> {
    /// The oracle, for grains of a D50 (m).
    Oracle(&'s Oracle, f64),
    /// The job.
    Known(&'s KnownBands),
}

/// What becomes of a band.
pub struct Adaptive<'s> {
    /// The oracle or the job.
    pub finder: Finder<'s>,
    /// How grains take the place of points there, and how their zone lives.
    pub enrichment: &'s Enrichment,
    /// How the packing that grains are taken from lies in the specimen.
    pub lies: Lies<'s>,
    /// Of the plane, m.
    pub depth: f64,
}

/// Looks of the oracle in one at what rests, for which all ranks hear of all cells and go through all contacts.
const LOOKS_OF_ORACLE: u64 = 8;

type PlanarCore<'t> = Core<'t, Plane>;

impl Adaptive<'_> {
    /// What is due after a step. `strain` is told with it. Collective.
    pub fn adapt(&self, core: &mut PlanarCore, strain: Option<f64>) -> Result<(), Error> {
        if self.enrichment.life.is_everywhere {
            // From the first step on, also of a branch from grains alone.
            core.progress.enriched_step = core.progress.enriched_step.max(1);
        }
        if core.progress.enriched_step > 0 {
            return self.live(core, strain);
        }
        enrichment::track(&mut core.world, &mut core.progress.instants);
        let found = match self.finder {
            Finder::Oracle(oracle, diameter) => look(core, oracle, diameter)?,
            Finder::Known(bands) => {
                let due = core.world.time() >= bands.at;
                if due {
                    core.progress.oracle.flagged = enrichment::cell_grid(&core.world).nodes_along(&bands.parts);
                }
                due
            }
        };
        if found { self.enrich(core, strain) } else { Ok(()) }
    }

    /// The same of a zone that is there.
    fn live(&self, core: &mut PlanarCore, strain: Option<f64>) -> Result<(), Error> {
        let (life @ ZoneLife { grows, dissolves, .. }, Finder::Oracle(oracle, diameter)) =
            (self.enrichment.life, &self.finder)
        else {
            return Ok(());
        };
        if grows && !life.returns() {
            enrichment::track(&mut core.world, &mut core.progress.instants);
            if look(core, oracle, *diameter)? && self.grow(core, strain)? {
                // Whoever has just come would seem to rest.
                core.progress.rest.begin();
            }
        }
        let every = LOOKS_OF_ORACLE * oracle.every.max(core.world.settings.grain_steps);
        if dissolves && core.world.is_due(every) { self.judge(core, every, strain) } else { Ok(()) }
    }

    /// More grains, around the nodes that the oracle has flagged beyond the zone, a set of nodes that hang together after the other.
    /// Where they cannot be, the continuum stays.
    fn grow(&self, core: &mut PlanarCore, strain: Option<f64>) -> Result<bool, Error> {
        let flagged = std::mem::take(&mut core.progress.oracle.flagged);
        let (mut has_grown, mut is_refused) = (false, false);
        for set in enrichment::cell_grid(&core.world).connected(&flagged) {
            // What the set before has reached needs no grains of its own.
            let left = watch::beyond_grains(&core.world, set)?;
            if left.is_empty() {
                continue;
            }
            match self.plan(&left, core)? {
                Ok(plan) => {
                    self.extend(plan, ("flagged", left.len()), core, strain)?;
                    has_grown = true;
                }
                Err(refusal) => {
                    tell_refusal(&refusal, left.len(), core, strain)?;
                    is_refused = true;
                }
            }
        }
        if is_refused && !has_grown {
            core.progress.oracle.refuse();
        }
        Ok(has_grown)
    }

    /// Grains around these nodes.
    fn plan(&self, flagged: &[u64], core: &mut PlanarCore) -> Result<Result<Plan, Refusal>, Error> {
        let wanted = enrichment::around_band(&core.world, flagged, self.enrichment);
        let file = packing_file(&core.options.out);
        let how = (self.enrichment, self.depth);
        Plan::of(&mut core.world, how, wanted, &core.progress.instants, (&file, self.lies))
    }

    /// A zone that is there has grown, for so many nodes that are flagged or cells that shear.
    fn extend(
        &self,
        plan: Plan,
        (what, count): (&str, usize),
        core: &mut PlanarCore,
        strain: Option<f64>,
    ) -> Result<(), Error> {
        let enriched = plan.carry_out(&mut core.world)?;
        tracing::info!(step = core.world.step, strain, grains = enriched.grains, "the zone has grown");
        let mut figures = json!({
            "grains": enriched.grains,
            "grains_rim": enriched.grains_rim,
            "points_removed": enriched.points_removed,
            "points_rim": enriched.points_rim,
            "stress_points": enriched.stress_points,
            "stress_grains": enriched.stress_grains,
            "training_steps": enriched.training_steps,
        });
        figures[what] = json!(count);
        record_change(core, "zone_grew", (figures, &enriched.kept), strain)
    }

    /// A look at what shears, `every` so many steps; once the busiest cell has sheared enough to tell, grains come back to where cells shear that are not of grains alone, or else
    /// those far from all that shear turn into points. While the busiest cell is continuum that stays so, grains are judged by no band of theirs, and stay.
    fn judge(&self, core: &mut PlanarCore, every: u64, strain: Option<f64>) -> Result<(), Error> {
        let timer = core.world.phases.start();
        let time = every as f64 * core.world.settings.grains.dt;
        let flows = shear::look_for_rest(&core.world, &mut core.progress.rest, time)?;
        let borne = enrichment::strength_mobilised(&mut core.world, self.depth, core.progress.fraction_start)?;
        core.progress.rest.load(&borne);
        core.world.phases.stop(Phase::Oracle, timer);
        let life = self.enrichment.life;
        if core.progress.rest.most() < life.rest_strain {
            return Ok(());
        }
        let watch = core.progress.rest.clone();
        core.progress.rest.begin();
        let busy: Vec<u64> = watch.busy(life.rest_share).collect();
        let is_inside = |cell: u64| flows.get(&cell).is_some_and(Flow::is_inside);
        let beyond = busy.iter().filter(|cell| !is_inside(**cell)).count();
        tell_judgement(core, [busy.len(), beyond], shear::watched_inside_zones(&watch, &flows), strain)?;
        if life.returns() && self.follow(core, (&flows, &busy), strain)? {
            return Ok(());
        }
        match watch.busiest() {
            Some(cell) if is_inside(cell) => self.dissolve(core, (&watch, &busy), strain),
            _ => Ok(()),
        }
    }

    /// Grains that have turned into points come back where cells shear that are not of grains alone; whether any have. Where they cannot be, the continuum stays.
    fn follow(
        &self,
        core: &mut PlanarCore,
        (flows, busy): (&BTreeMap<u64, Flow>, &[u64]),
        strain: Option<f64>,
    ) -> Result<bool, Error> {
        // Where no grains have been kept, in a branch of a run that did not, none can come back before others have left.
        let is_kept = core.world.transport.broadcast(vec![u8::from(!core.progress.kept_grains.is_empty())])[0] > 0;
        if !is_kept {
            return Ok(false);
        }
        let grid = enrichment::cell_grid(&core.world);
        let mut has_grown = false;
        for wanted in enrichment::around_shear(grid, flows, busy, self.enrichment) {
            match self.plan_return(wanted, core)? {
                Ok(plan) => {
                    self.extend(plan, ("cells", busy.len()), core, strain)?;
                    has_grown = true;
                }
                Err(Refusal(why)) => {
                    tracing::warn!(step = core.world.step, strain, "what shears beside grains stays continuum: {why}");
                    record_event(core, "zone_refused", json!({ "why": why, "cells": busy.len() }), strain)?;
                }
            }
        }
        Ok(has_grown)
    }

    /// Grains that are kept, in a zone.
    fn plan_return(&self, wanted: Wanted, core: &mut PlanarCore) -> Result<Result<Plan, Refusal>, Error> {
        let file = packing_file(&core.options.out);
        let how = (self.enrichment, self.depth);
        let Core { world, progress, .. } = core;
        Plan::of(world, how, wanted, &progress.instants, (&file, Lies::Kept(&progress.kept_grains)))
    }

    /// Grains far from all that shear, `busy`, turn back into points.
    fn dissolve(&self, core: &mut PlanarCore, judged: (&RestWatch, &[u64]), strain: Option<f64>) -> Result<(), Error> {
        let how = (self.enrichment, self.depth, core.progress.fraction_start);
        let Core { world, progress, .. } = core;
        let of_past = (&mut progress.instants, &mut progress.kept_grains);
        let Some(done) = enrichment::dissolve(world, how, of_past, judged)? else {
            return Ok(());
        };
        let step = core.world.step;
        if !done.refused.is_empty() {
            let why = "points in their places would not weigh what grains do";
            record_refusal(core, why, json!({ "mass_factors": done.refused }), strain)?;
        }
        if !done.mobilised.is_empty() {
            let why = "grains at rest bear more than zone.rest_strength of the continuum's peak shear strength";
            // Without pressure there is no strength to be a share of.
            let (told, slack): (Vec<f64>, Vec<f64>) = done.mobilised.iter().partition(|share| share.is_finite());
            record_refusal(core, why, json!({ "strength_mobilised": told, "without_pressure": slack.len() }), strain)?;
        }
        if done.mass_factors.is_empty() {
            return Ok(());
        }
        tracing::info!(step, strain, grains = done.grains, "grains at rest have turned back into points");
        let figures = json!({
            "grains": done.grains,
            "grains_rim": done.grains_rim,
            "points": done.points,
            "points_whole": done.points_whole,
            "mass_factors": done.mass_factors,
            "seconds_of_steps": seconds_of_steps(core),
        });
        record_change(core, "zone_shrank", (figures, &done.kept), strain)
    }

    /// The first zone, around all flagged nodes; where it cannot be, around those of their sets where it can. What cannot be had is told
    /// and stays continuum, and the oracle looks on. A band that the job names is another matter: without its zone that would be
    /// another job.
    fn enrich(&self, core: &mut PlanarCore, strain: Option<f64>) -> Result<(), Error> {
        let what = match self.finder {
            Finder::Oracle(..) => "shear band found; training grains for it",
            Finder::Known(_) => "training grains for known shear bands",
        };
        tracing::info!(step = core.world.step, strain, "{what}");
        let stepped = seconds_of_steps(core);
        let started = std::time::Instant::now();
        let flagged = core.progress.oracle.flagged.clone();
        let refusal = match self.plan(&flagged, core)? {
            Ok(plan) => {
                self.begin(plan, core, strain, (stepped, started))?;
                self.forget_paths(core);
                return Ok(());
            }
            Err(refusal) => refusal,
        };
        if let Finder::Known(_) = self.finder {
            return Err(Error::Run(refusal.0));
        }
        tell_refusal(&refusal, flagged.len(), core, strain)?;
        let sets = enrichment::cell_grid(&core.world).connected(&flagged);
        for set in if sets.len() > 1 { &sets[..] } else { &[] } {
            let is_first = core.progress.enriched_step == 0;
            let left = if is_first { set.clone() } else { watch::beyond_grains(&core.world, set.clone())? };
            if left.is_empty() {
                continue;
            }
            match self.plan(&left, core)? {
                Ok(plan) if is_first => self.begin(plan, core, strain, (stepped, started))?,
                Ok(plan) => self.extend(plan, ("flagged", left.len()), core, strain)?,
                Err(refusal) => tell_refusal(&refusal, left.len(), core, strain)?,
            }
        }
        if core.progress.enriched_step == 0 {
            core.progress.oracle.refuse();
        } else {
            self.forget_paths(core);
        }
        Ok(())
    }

    /// Frames on either side show what has changed. What is there now has accounts of energy from here on.
    fn begin(
        &self,
        plan: Plan,
        core: &mut PlanarCore,
        strain: Option<f64>,
        (stepped, started): (f64, std::time::Instant),
    ) -> Result<(), Error> {
        core.write_frame()?;
        let enriched = plan.carry_out(&mut core.world)?;
        core.progress.enriched_step = core.world.step;
        let seconds = started.elapsed().as_secs_f64();
        record(core, &enriched, strain, [stepped, seconds])?;
        core.world.open_accounts(core.accounts);
        core.write_frame()
    }

    /// Where points were is asked for as long as zones are made.
    fn forget_paths(&self, core: &mut PlanarCore) {
        if !self.enrichment.life.grows {
            core.world.continuum.points.forget();
            core.progress.instants = Instants::default();
        }
    }
}

/// Wall time of the steps of this stretch, without what output took, s.
fn seconds_of_steps(core: &PlanarCore) -> f64 {
    core.world.phases.total() - core.world.phases.of(Phase::Output)
}

/// Told in the log and to whoever looks on.
fn tell_refusal(
    Refusal(why): &Refusal,
    flagged: usize,
    core: &mut PlanarCore,
    strain: Option<f64>,
) -> Result<(), Error> {
    tracing::warn!(step = core.world.step, strain, "a shear band stays continuum: {why}");
    record_event(core, "zone_refused", json!({ "why": why, "flagged": flagged }), strain)
}

/// A look of the oracle where one is due; whether a band has been found. Collective.
fn look(core: &mut PlanarCore, oracle: &Oracle, diameter: f64) -> Result<bool, Error> {
    match core.world.is_due(oracle.every) {
        true => watch::watch(&mut core.world, &mut core.progress.oracle, oracle, diameter),
        false => Ok(false),
    }
}

/// Logs a change of a zone that is there, with its account.
fn record_change(
    core: &mut PlanarCore,
    event: &str,
    (mut figures, kept): (Value, &BeforeAndAfter),
    strain: Option<f64>,
) -> Result<(), Error> {
    figures["mass"] = json!(kept.mass);
    figures["momentum"] = json!(kept.momentum);
    figures["grains_now"] = json!(core.world.grains_total);
    figures["points_now"] = json!(core.world.points_total);
    record_event(core, event, figures, strain)
}

/// What a judgement went by: how many cells shear, how many of them are continuum, and the share of the shear since the last one that was inside zones.
fn tell_judgement(
    core: &mut PlanarCore,
    [busy, beyond]: [usize; 2],
    inside: f64,
    strain: Option<f64>,
) -> Result<(), Error> {
    record_event(
        core,
        "zone_judged",
        json!({ "cells": busy, "cells_beyond": beyond, "shear_in_zones": inside }),
        strain,
    )
}

/// An event with its time and strain.
fn record_event(core: &mut PlanarCore, event: &str, mut figures: Value, strain: Option<f64>) -> Result<(), Error> {
    figures["time"] = json!(core.world.time());
    if let Some(strain) = strain {
        figures["strain"] = json!(strain);
    }
    let step = core.world.step;
    core.on_root(|outputs| outputs.log(event, step, figures))
}

/// Cells at rest that stay grains.
fn record_refusal(core: &mut PlanarCore, why: &str, mut figures: Value, strain: Option<f64>) -> Result<(), Error> {
    figures["why"] = json!(why);
    record_event(core, "zone_cannot_shrink", figures, strain)
}

/// `stepped`: seconds of the steps until then, `seconds`: of the training.
fn record(
    core: &mut PlanarCore,
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
        "enriched_mass_before": enriched.kept.mass[0],
        "enriched_mass_after": enriched.kept.mass[1],
        "enriched_momentum_x_before": enriched.kept.momentum[0][0],
        "enriched_momentum_x_after": enriched.kept.momentum[1][0],
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

/// A look where one is due; the first band that persists is told in the log and kept in mind, and left alone. Collective.
pub fn tell_band<S: Space>(core: &mut Core<S>, settings: &Oracle, diameter: f64) -> Result<(), Error> {
    if !core.world.is_due(settings.every) {
        return Ok(());
    }
    let found = watch::watch(&mut core.world, &mut core.progress.oracle, settings, diameter)?;
    if found && core.progress.enriched_step == 0 {
        let (step, time) = (core.world.step, core.world.time());
        core.progress.enriched_step = step;
        let nodes = core.progress.oracle.flagged.iter();
        let places: Vec<[f64; 2]> = nodes.map(|node| watch::place_of_node(&core.world, *node)).collect();
        core.on_root(|outputs| outputs.log("band", step, json!({ "time": time, "nodes": places })))?;
    }
    Ok(())
}
