//! Planar shear. Tables that the method leaves asleep take the values of Chen et al. (2021), so that nothing later is optional.

use super::checks::margin_in_words;
use super::granular::check_method;
use super::limits::{refuse_faint_packing, refuse_size_of_shear, refuse_speed_of_plates, refuse_squeeze, refuse_steps};
use super::material::File;
use super::mpm::{check_nonlocal, scheme};
use super::mpm_checks::check_time;
use super::{
    BLOCK_OF_DISCS, SKIN_DEFAULT, check_name, digits, output, refuse_unstable, refuse_wide_sizes, significant,
};
use crate::base::error::Error;
use crate::base::keys::Form;
use crate::couple::oracle::Laplacian;
use crate::couple::zone::Enrichment;
use crate::job::raw::{Reader, Typed};
use crate::job::stable::step_default;
use crate::job::{Method, Scenario, Specimen, WeakRegion, derived, figures, stable};
use crate::law::material::{ConstitutiveLaw, CriticalConstants, Objection};
use crate::mpm::nonlocal::Nonlocal;
use crate::mpm::shape::margins;

/// phi_0 where nothing looks at it, in mean diameters.
const DISTANCE_ASLEEP: f64 = 22.0;
/// Looks of the oracle within its recent window when a band one cell thick takes the whole speed.
const LOOKS_PER_WINDOW: f64 = 16.0;
/// How exactly the cells must fill the width.
const FIT_TOLERANCE: f64 = 1e-9;

/// The checked scenario of a job; `file` is the job's path, whose folder the file of a material starts from.
pub fn scenario(typed: &Typed) -> Result<Scenario, Error> {
    let mut top = typed.table("", true, "a job");
    if !top.has("method") {
        return Err(typed.refusal_of_all(
            "the job does not say what it is. Add method = \"hybrid\", \"dem\" or \"mpm\" above the first table for planar shear, a table [cell] for an assembly of grains, or a table [grid] for a continuum.",
        ));
    }
    let mut job = Scenario::asleep();
    job.head(&mut top);
    check_name(&top, &job.name);
    if top.is_none_of("method", &Method::NAMES.map(|(name, _)| name)) {
        // What else a job needs hangs on it.
        typed.stop_if_wrong()?;
    }
    let method = job.method;
    let of_another_job = match method {
        Method::MpmDem => Some(
            "has grains at every point of a continuum on a grid: add the tables [grid], [material] and [rve] of such a job, or write \"hybrid\", \"dem\" or \"mpm\" for planar shear.",
        ),
        Method::Fem | Method::FemDem => Some(
            "is of elements: add the tables [mesh] and [material] of such a job, or write \"hybrid\", \"dem\" or \"mpm\" for planar shear.",
        ),
        Method::Hybrid | Method::Dem | Method::Mpm => None,
    };
    if let Some(why) = of_another_job {
        return Err(top.refusal("method", why));
    }
    let why = format!("method = \"{}\"", method.name());

    job.specimen.keys(&mut typed.table("specimen", true, &why));
    let mut table = typed.table("grains", true, &why);
    job.grains.keys(&mut table);
    typed.check(refuse_wide_sizes(&table, job.grains.diameter_mean, job.grains.diameter_deviation));
    let mut loading = typed.table("loading", true, &why);
    job.loading.keys(&mut loading);
    let mut time = typed.table("time", false, &why);
    job.time.keys(&mut time);
    let diameter = job.grains.diameter_mean;
    job.decomposition.skin = SKIN_DEFAULT * diameter;
    job.decomposition.keys(&mut typed.table("decomposition", false, &why));
    job.packing.stress = job.loading.stress_normal;
    job.packing.keys(&mut typed.table("packing", false, &why));

    job.scheme = scheme(&mut typed.table("scheme", false, &why))?;
    let made_of = typed.table("material", method.has_points(), &why);
    let mut table = typed.table("continuum", method.has_points(), &why);
    let packed = method.has_grains() || !made_of.has("fraction");
    let why_packed = match method.has_grains() {
        true => why.clone(),
        false => format!("{why} without material.fraction makes a packing, which"),
    };
    let mass_mean = stable::grain_mass(job.grains.density, 0.5 * diameter, job.specimen.depth, 2);
    job.contact.keys(&mut typed.table("contact", packed, &why_packed), mass_mean);
    let file = File::of(&made_of)?;
    material(&mut job, made_of, file.as_ref())?;
    continuum(&mut job, &mut table)?;
    refuse_size_of_shear(&job, typed)?;
    job.loading.plate_mass = derived::plate_default(&job)[0];
    job.loading.keys_of_plate(&mut loading);
    job.loading.plate_damping = derived::plate_damping(&job, job.loading.plate_mass);
    job.loading.keys_of_plate(&mut loading);
    if !time.has("step") {
        job.time.step = step_default(&derived::bounds(&job));
    }
    // Steps in which a band one cell thick shears by 1 at full speed.
    let steps_per_strain = job.continuum.cell / (job.loading.speed * job.time.step);
    let mut oracle = typed.table("oracle", false, &why);
    job.oracle.keys(&mut oracle, Laplacian::OF_SHEAR);
    if !oracle.has("every") {
        job.oracle.every = steps_between_looks(job.oracle.window(), steps_per_strain);
    }
    let mut nonlocal = typed.table_if_typed("nonlocal");
    if nonlocal.is_typed() {
        job.nonlocal.insert(Nonlocal::BLANK).keys(&mut nonlocal);
    }
    job.coupling.keys(&mut typed.table("coupling", false, &why));
    job.enrichment.distance = DISTANCE_ASLEEP * diameter;
    job.enrichment.keys(&mut typed.table("enrichment", method == Method::Hybrid, &why));
    job.enrichment.life.keys(&mut typed.table("zone", false, &why));

    let duration = derived::duration(&job);
    refuse_steps(typed, duration, job.time.step, "loading.strain_end")?;
    if duration < job.time.step {
        let problem =
            format!("is reached in {} s, less than one time step. Take more strain.", significant(duration, 3));
        return Err(loading.refusal("strain_end", &problem));
    }
    let mut shown = typed.table("output", false, &why);
    (job.output, job.ledger) = output(&mut shown, duration, job.time.step)?;
    if job.ledger && !method.has_grains() {
        return Err(shown.refusal(
            "energy_balance",
            "keeps the account of grains, and method = \"mpm\" has none. Remove it, or take another method.",
        ));
    }
    typed.stop_if_wrong()?;
    check_together(&job, typed);
    Ok(job)
}

fn steps_between_looks(window: f64, steps_per_strain: f64) -> u64 {
    (window * steps_per_strain / LOOKS_PER_WINDOW).clamp(1.0, 1e9) as u64
}

/// Asleep: moduli of the contact law.
fn material<'a>(job: &mut Scenario, mut table: Reader<'a>, file: Option<&'a File>) -> Result<(), Error> {
    if let Some(file) = file {
        table = table.over(file.table());
    }
    let mut start = job.material;
    start.keys(&mut table.clone(), true);
    let springs = derived::springs_mean(&job.contact, job.grains.diameter_mean);
    let fraction = start.law.fraction().unwrap_or(derived::FRACTION_DENSE);
    let moduli = derived::moduli_affine(&springs, fraction, job.specimen.depth);
    job.material.law = ConstitutiveLaw::CriticalDruckerPrager(CriticalConstants {
        bulk_modulus: moduli.bulk,
        shear_modulus: moduli.shear,
        ..CriticalConstants::CHEN
    });
    job.material.keys(&mut table, true);
    if matches!(job.material.law, ConstitutiveLaw::Grains(_)) {
        table.add(table.refusal("law", "makes every point a grain assembly, which is method = \"mpm_dem\" in a job with a table [grid]. Write another law."));
    }
    job.material.density = derived::density_bulk(job);
    file.map_or(Ok(()), File::stop_if_wrong)
}

/// Asleep: cells that make blocks fit for grains.
fn continuum(job: &mut Scenario, table: &mut Reader<'_>) -> Result<(), Error> {
    let Scenario { continuum, specimen, grains, decomposition, material, .. } = job;
    let blocks = (specimen.width / (BLOCK_OF_DISCS * grains.diameter_mean)).floor();
    continuum.cell = specimen.width / (blocks.max(2.0) * decomposition.cells_per_block as f64);
    continuum.keys(table);
    continuum.cell = fitted_cell(table, continuum.cell, specimen.width, decomposition.cells_per_block)?;
    for (weak, table) in continuum.weak.iter().zip(&table.list("weak")) {
        table.one_of_many(check_weak(weak, table, specimen));
        if !material.law.yields() {
            table.add(table.refusal("fraction_deficit", "is of no effect: an elastic material does not look at its solid volume fraction. Remove the region, or take another material.law."));
        }
    }
    Ok(())
}

/// The width over a whole number of cells, which the typed cell must equal to within rounding.
fn fitted_cell(table: &Reader<'_>, cell: f64, width: f64, cells_per_block: usize) -> Result<f64, Error> {
    let cells = width / cell;
    let per_block = cells_per_block as f64;
    let blocks = (cells / per_block).round();
    let fits = (cells - blocks * per_block).abs() <= FIT_TOLERANCE * cells;
    if fits && blocks >= 2.0 {
        return Ok(width / (blocks * per_block));
    }
    let below = (cells / per_block).floor().max(2.0);
    let choices: Vec<String> = [below, below + 1.0]
        .iter()
        .map(|blocks| {
            let cells = blocks * per_block;
            format!("\"{} mm\" ({cells} cells)", digits(1e3 * width / cells))
        })
        .collect();
    Err(table.refusal(
        "cell",
        &format!(
            "does not fit: blocks of {cells_per_block} cells (decomposition.cells_per_block) must fill specimen.width = {} mm exactly, at least two of them. Write {}.",
            digits(1e3 * width),
            choices.join(" or ")
        ),
    ))
}

fn check_weak(weak: &WeakRegion, region: &Reader<'_>, specimen: &Specimen) -> Result<(), Error> {
    let size = [specimen.width, specimen.height];
    for axis in 0..2 {
        if weak.lower[axis] < 0.0 {
            return Err(region
                .refusal("lower", "lies outside of the specimen, whose lower left corner is [0, 0]. Move it inside."));
        }
        if weak.upper[axis] > size[axis] * (1.0 + FIT_TOLERANCE) {
            let problem = format!(
                "lies outside of the specimen, whose upper right corner is [{}, {}] in m. Move it inside.",
                digits(size[0]),
                digits(size[1])
            );
            return Err(region.refusal("upper", &problem));
        }
        if weak.upper[axis] <= weak.lower[axis] {
            return Err(region.refusal("upper", "encloses nothing: it must lie above and to the right of lower."));
        }
    }
    Ok(())
}

/// What no single key can tell.
fn check_together(scenario: &Scenario, typed: &Typed) {
    typed.check(check_height(scenario, typed));
    if scenario.moves_grains() {
        typed.check(check_block_edge(scenario, typed));
        typed.check(check_height_of_packing(scenario, typed));
    }
    if scenario.method == Method::Hybrid {
        typed.check(check_zone(scenario, typed));
        typed.check(check_life(&scenario.enrichment, typed));
        typed.check(check_life_in_shear(scenario, typed));
    }
    let on_grid = scenario.on_grid();
    if let Some(nonlocal) = &scenario.nonlocal {
        check_nonlocal(&typed.table_if_typed("nonlocal"), nonlocal, &on_grid);
    }
    if let (true, Some(grains)) = (scenario.method.has_grains(), &on_grid.grains) {
        check_method(&on_grid, grains, typed);
    }
    if scenario.moves_grains() {
        let bounds = figures::bounds(&scenario.grains_of_specimen());
        typed.check(refuse_unstable(typed, scenario.time.step, &bounds, ""));
    }
    if scenario.method.has_points() {
        typed.check(check_law(scenario, typed));
        typed.check(check_heterogeneity(scenario, typed));
        typed.check(check_reach(scenario, typed));
        typed.check(check_time(&on_grid, typed));
    }
    typed.check(refuse_speed_of_plates(scenario, typed));
    if scenario.moves_grains() {
        typed.check(check_packing(scenario, typed));
    }
}

/// Why an account of energy cannot be kept of a zone that lives.
pub(super) const LEDGER_OF_LIVING_ZONE: &str = "begins anew whenever a zone changes, and this one lives. Remove it, or write zone.grows = false and zone.dissolves = false.";

/// Grains that stand in a zone have gone all of the continuum's way, and those that come to them must as well. Grains that are everywhere and stay are
/// another method.
pub(super) fn check_life(enrichment: &Enrichment, typed: &Typed) -> Result<(), Error> {
    let life = enrichment.life;
    if life.grows && enrichment.training < 1.0 {
        return Err(typed.refusal("enrichment", "training", "takes grains along a part of the way that those of a zone which grows have gone. Write 1.0, or zone.grows = false."));
    }
    if life.is_everywhere && !life.dissolves {
        return Err(typed.refusal("zone", "begins", "leaves grains for good where they are, which is method = \"dem\". Write zone.dissolves = true, begins = \"band\", or that method."));
    }
    Ok(())
}

fn check_life_in_shear(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let life = scenario.enrichment.life;
    if life.grows && scenario.packing.height.is_some() {
        return Err(typed.refusal("zone", "grows", "would lay the packing, which lies about the first band, about another one. Write false, or remove packing.height."));
    }
    if life.is_everywhere && scenario.packing.height.is_some() {
        return Err(typed.refusal("zone", "begins", "begins with all of the specimen as grains, and the packing is lower. Remove packing.height, or write begins = \"band\"."));
    }
    if scenario.ledger && (life.grows || life.dissolves) {
        return Err(typed.refusal("output", "energy_balance", LEDGER_OF_LIVING_ZONE));
    }
    Ok(())
}

/// The stress of the packing and that of the run must press grains together, and not into each other.
fn check_packing(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let (grains, stress) = (scenario.grains_of_specimen(), scenario.packing.stress);
    for (key, stress) in
        [(("loading", "stress_normal"), scenario.loading.stress_normal), (("packing", "stress"), stress)]
    {
        refuse_squeeze(typed, key, figures::stiffness_over_load(&grains, stress))?;
    }
    let time = scenario.grains.diameter_mean * (scenario.grains.density / stress).sqrt();
    match scenario.grains.file {
        Some(_) => Ok(()),
        None => refuse_faint_packing(typed, ("packing", "stress"), time, scenario.time.step),
    }
}

/// Heterogeneity is that of the packing that lies in the whole specimen.
fn check_heterogeneity(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let Scenario { method, continuum, material, packing, .. } = scenario;
    if !continuum.is_heterogeneous || !method.has_points() {
        return Ok(());
    }
    let refused = |problem: &str| Err(typed.refusal("continuum", "heterogeneity", problem));
    if packing.height.is_some() {
        return refused(
            "is that of the whole specimen, and packing.height makes grains for a zone alone. Write \"none\", or remove packing.height.",
        );
    }
    if *method == Method::Mpm && material.law.fraction().is_some() {
        return refused(
            "is that of a packing, and none is made for points whose material.fraction is given. Write \"none\", or remove material.fraction.",
        );
    }
    Ok(())
}

/// The law must be able to start from the solid volume fractions of the specimen.
fn check_law(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let (law, start) = (&scenario.material.law, derived::fraction_start(scenario));
    if let Some(Objection { key, problem }) = law.objection(2, start) {
        return Err(typed.refusal("material", key, &problem));
    }
    let tables = typed.table("continuum", false, "").list("weak");
    for (weak, table) in scenario.continuum.weak.iter().zip(&tables) {
        let fraction = start - weak.fraction_deficit;
        if let Some(Objection { problem, .. }) = law.objection(2, fraction) {
            let there = digits((1e6 * fraction).round() / 1e6);
            let problem = format!("leaves a solid volume fraction of {there} there, which {problem}");
            return Err(table.refusal("fraction_deficit", &problem));
        }
    }
    Ok(())
}

/// A block and its neighbours hold all nodes that its points reach.
fn check_reach(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let shape = scenario.scheme.shape;
    let least = margins(shape).into_iter().fold(0, usize::max);
    if scenario.decomposition.cells_per_block >= least {
        return Ok(());
    }
    let problem = format!(
        "is too few for the {least} nodes that scheme.shape = \"{}\" reaches beyond a block. Write {least}.",
        shape.name()
    );
    Err(typed.refusal("decomposition", "cells_per_block", &problem))
}

fn check_height(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let block = derived::block_edge(scenario);
    if scenario.specimen.height >= block {
        return Ok(());
    }
    let message = format!(
        "is lower than one block, which is {} mm ({} cells of {} mm). Make the specimen higher or continuum.cell smaller.",
        digits(1e3 * block),
        scenario.decomposition.cells_per_block,
        digits(1e3 * scenario.continuum.cell)
    );
    Err(typed.refusal("specimen", "height", &message))
}

/// A block's ghosts come from its neighbours alone, so a contact must not reach across one.
fn check_block_edge(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let edge = derived::block_edge(scenario);
    let edge_min = 2.0 * figures::diameter_max(&scenario.grains_of_specimen())
        + scenario.decomposition.skin
        + scenario.contact.reach();
    if edge >= edge_min {
        return Ok(());
    }
    let message = format!(
        "makes blocks of {} mm, but two of the largest grains and {} need {} mm. Take larger cells, more decomposition.cells_per_block, or smaller grains.",
        digits(1e3 * edge),
        margin_in_words(&scenario.contact),
        digits(1e3 * edge_min)
    );
    Err(typed.refusal("continuum", "cell", &message))
}

fn check_zone(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let cell = scenario.continuum.cell;
    let height = scenario.specimen.height;
    if 2.0 * (scenario.enrichment.distance + cell) < height {
        return Ok(());
    }
    let message = format!(
        "leaves no continuum: twice this distance and twice a cell must be less than specimen.height = {} mm, so less than {} mm is allowed. For grains everywhere write method = \"dem\".",
        digits(1e3 * height),
        digits(1e3 * (0.5 * height - cell).max(0.0))
    );
    Err(typed.refusal("enrichment", "distance", &message))
}

/// Of a packing about a zone: the band, one and a half cells on either side that grains may come from, and one that it may lose while it
/// is compressed or be off the middle by.
const CELLS_ABOUT_ZONE: f64 = 5.0;

/// A packing that is lower than the specimen.
fn check_height_of_packing(scenario: &Scenario, typed: &Typed) -> Result<(), Error> {
    let Some(height) = scenario.packing.height else { return Ok(()) };
    let refused = |message: &str| Err(typed.refusal("packing", "height", message));
    let zone = 2.0 * scenario.enrichment.distance + CELLS_ABOUT_ZONE * scenario.continuum.cell;
    if scenario.method == Method::Dem {
        return refused("makes less than the specimen, and grains alone fill all of it. Remove the line.");
    }
    if scenario.grains.file.is_some() {
        return refused("is for a packing that is made, and grains.file gives one. Remove one of the two.");
    }
    if height >= scenario.specimen.height || height <= zone {
        return refused(&format!(
            "must lie between what a zone takes, {} mm (twice enrichment.distance and five cells), and specimen.height = {} mm. Write more than the former, or remove the line.",
            digits(1e3 * zone),
            digits(1e3 * scenario.specimen.height)
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const HEAD: &str = r#"
        name = "small"
        method = "dem"
        [specimen]
        width = "24 mm"
        height = "30 mm"
        [grains]
        diameter_mean = "1 mm"
        diameter_deviation = "0.08 mm"
        density = 2530
        [loading]
        stress_normal = "400 kPa"
        speed = "2 cm/s"
        speed_ramp = 0
        strain_end = 0.1
        [time]
        step = "0.4 us"
    "#;
    const CONTACT: &str = r#"
        [contact]
        stiffness_normal = 1772093.8
        stiffness_tangential = 886046.9
        damping_normal = 3.5
        damping_tangential = 3.5
        friction = 0.5
    "#;

    fn parse(text: &str, sets: &[&str]) -> Result<Scenario, Error> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        Scenario::parse(text, "small.toml", &sets)
    }

    /// A job of grains alone need not speak of a continuum, and gets blocks that fit grains.
    #[test]
    fn tables_that_sleep_may_be_missing() {
        let scenario = parse(&format!("{HEAD}{CONTACT}"), &[]).unwrap();
        assert_eq!(crate::job::mpm::figures::blocks(&scenario.on_grid()), [2, 3, 1]);
        assert_eq!(scenario.continuum.weak, []);
        assert_eq!(scenario.packing.stress, 400e3);
        let error = parse(HEAD, &[]).unwrap_err().to_string();
        assert!(error.contains("needs the table [contact]"), "{error}");
    }

    /// A continuum alone makes a packing only if it is not told its fraction.
    #[test]
    fn a_continuum_needs_contacts_only_for_its_packing() {
        let continuum = r#"
            [continuum]
            bulk_modulus = "100 MPa"
            shear_modulus = "60 MPa"
            friction_angle_critical = 0.27
            fraction_critical = 0.815
            dilation_factor = 7
            softening_rate = 1
            cell = "3 mm"
        "#;
        let text = format!("{HEAD}{continuum}");
        let error = parse(&text, &["method=mpm"]).unwrap_err().to_string();
        assert!(error.contains("needs the table [contact]"), "{error}");
        let scenario = parse(&text, &["method=mpm", "material.fraction=0.855"]).unwrap();
        assert_eq!(scenario.material.law.fraction(), Some(0.855));
    }

    #[test]
    fn the_resolved_job_parses_back_to_the_same_scenario() {
        let text = format!("{HEAD}{CONTACT}");
        let sets = [
            "grains.file=\"a \\\" b.csv\"",
            "continuum.weak=[{lower=[0, 0], upper=[0.024, \"1 cm\"], fraction_deficit=0.02}]",
            "time.step=3.3333333333333e-7",
        ];
        let scenario = parse(&text, &sets).unwrap();
        assert_eq!(scenario.continuum.weak[0].upper, [0.024, 0.01]);
        let back = Scenario::parse(&scenario.to_toml(), "elsewhere/job.toml", &[]).unwrap();
        assert_eq!(back, scenario);
    }

    #[test]
    fn paths_start_from_the_folder_of_the_job() {
        let text = format!("{HEAD}{CONTACT}");
        let scenario = Scenario::parse(&text, "/jobs/small.toml", &[]).unwrap();
        assert_eq!(scenario.packing.cache, Path::new("/jobs/cache"));
    }
}
