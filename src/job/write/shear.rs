//! Planar shear.

use super::Page;
use crate::couple::oracle::Oracle;
use crate::couple::zone::{Enrichment, ZoneLife};
use crate::job::Scenario;

pub fn shear(scenario: &Scenario) -> String {
    let mut page = Page::new();
    page.text("name", &scenario.name);
    page.text("method", scenario.method.name());
    page.count("seed", scenario.seed);

    page.table("specimen");
    page.number("width", scenario.specimen.width);
    page.number("height", scenario.specimen.height);
    page.number("depth", scenario.specimen.depth);

    let grains = &scenario.grains;
    page.table("grains");
    page.number("diameter_mean", grains.diameter_mean);
    page.number("diameter_deviation", grains.diameter_deviation);
    page.number("density", grains.density);
    if let Some(file) = &grains.file {
        page.path("file", file);
    }

    page.contact(&scenario.contact);

    let packing = &scenario.packing;
    page.table("packing");
    page.number("friction", packing.friction);
    page.number("fraction_start", packing.fraction_start);
    page.number("stress", packing.stress);
    if let Some(height) = packing.height {
        page.number("height", height);
    }
    page.number("energy_ratio_max", packing.energy_ratio_max);
    page.path("cache", &packing.cache);

    let continuum = &scenario.continuum;
    page.table("continuum");
    page.number("bulk_modulus", continuum.bulk_modulus);
    page.number("shear_modulus", continuum.shear_modulus);
    page.number("friction_angle_critical", continuum.friction_angle_critical);
    page.number("fraction_critical", continuum.fraction_critical);
    page.number("dilation_factor", continuum.dilation_factor);
    page.number("softening_rate", continuum.softening_rate);
    page.number("cohesion", continuum.cohesion);
    if let Some(fraction) = continuum.fraction_start {
        page.number("fraction_start", fraction);
    }
    page.number("cell", continuum.cell);
    page.count("points_per_cell", continuum.points_per_cell as u64);
    page.number("flip", continuum.flip);
    for region in &continuum.weak {
        page.line("\n[[continuum.weak]]");
        page.corners(&region.lower, &region.upper);
        page.number("fraction_deficit", region.fraction_deficit);
    }

    let loading = &scenario.loading;
    page.table("loading");
    page.number("stress_normal", loading.stress_normal);
    page.number("speed", loading.speed);
    page.number("speed_ramp", loading.speed_ramp);
    page.number("strain_end", loading.strain_end);
    page.number("plate_mass", loading.plate_mass);
    page.number("plate_damping", loading.plate_damping);

    page.table("oracle");
    oracle(&mut page, &scenario.oracle);

    enrichment(&mut page, &scenario.enrichment);
    zone(&mut page, &scenario.enrichment.life);
    page.table("time");
    page.number("step", scenario.time.step);
    page.count("grain_steps", scenario.time.grain_steps);

    let decomposition = &scenario.decomposition;
    page.table("decomposition");
    page.count("cells_per_block", decomposition.cells_per_block as u64);
    page.number("skin", decomposition.skin);

    page.output(&scenario.output);
    page.flag("contact_frames", scenario.output.contact_frames);
    if scenario.ledger {
        // Runs from before there was the key go on as they are.
        page.flag("ledger", true);
    }
    page.text_of_all()
}

/// `[enrichment]`, of whatever kind of job.
pub(super) fn enrichment(page: &mut Page, enrichment: &Enrichment) {
    page.table("enrichment");
    page.number("distance", enrichment.distance);
    page.number("weight", enrichment.weight);
    page.number("training", enrichment.training);
    page.number("training_speed", enrichment.training_speed);
    page.number("training_rest", enrichment.training_rest);
}

/// `[zone]`, of whatever kind of job.
pub(super) fn zone(page: &mut Page, life: &ZoneLife) {
    page.table("zone");
    page.flag("grows", life.grows);
    page.flag("dissolves", life.dissolves);
    page.number("rest_strain", life.rest_strain);
    page.number("rest_share", life.rest_share);
}

/// The keys of the oracle, of whatever kind of job.
pub(super) fn oracle(page: &mut Page, oracle: &Oracle) {
    page.number("laplacian", oracle.laplacian);
    page.number("recent_strain", oracle.recent_strain);
    page.number("window", oracle.window);
    page.number("persistence", oracle.persistence);
    page.number("tolerance", oracle.tolerance);
    page.count("every", oracle.every);
}
