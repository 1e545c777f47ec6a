//! Planar shear.

use super::page::{Page, figures, megapascals, whole};
use super::{INERTIAL_NUMBER_QUASI_STATIC, STEP_SHARE_MIN, STIFFNESS_NUMBER_MIN};
use crate::job::stable::Bound;
use crate::job::{Method, Scenario, derived};
use crate::law::contact::Stiffening;

/// Moduli this many times the affine estimate cannot come from the contact law, which the estimate bounds from above.
const MODULUS_EXCESS_MAX: f64 = 1.5;
/// Below this factor a hybrid is not worth its trouble.
const SPEED_UP_MIN: f64 = 1.5;
/// Recent strain and distance that the paper calls the most one should take (Chen et al. 2021, 3.2 and 4).
const RECENT_STRAIN_MAX: f64 = 0.05;
const DISTANCE_IN_DIAMETERS_MAX: f64 = 30.0;
/// Mass conservation would want xi near chi; with much less the material does not soften as it dilates.
const SOFTENING_SHARE_MIN: f64 = 0.05;

/// The whole printout.
///
/// `grains`: what bounds the step of the grains.
pub fn page(scenario: &Scenario, grains: &[Bound]) -> String {
    let mut page = Page(String::new());
    page.line(&format!(
        "{}: method {}, {}",
        scenario.name,
        scenario.method.name(),
        match scenario.method {
            Method::Hybrid => "continuum with grains where it localises",
            Method::Dem => "grains alone",
            Method::Mpm => "continuum alone",
        }
    ));
    material(&mut page, scenario);
    grid(&mut page, scenario);
    loading(&mut page, scenario);
    steps(&mut page, scenario, grains);
    cost(&mut page, scenario);
    for warning in warnings(scenario, grains) {
        page.line(&format!("\nwarning: {warning}"));
    }
    page.0
}

fn material(page: &mut Page, scenario: &Scenario) {
    let specimen = &scenario.specimen;
    let [width, height, depth] = [specimen.width, specimen.height, specimen.depth].map(|edge| figures(1e3 * edge));
    page.section("Material");
    page.row("specimen", &format!("{width} x {height} x {depth} mm"), "width x height x depth");
    page.row(
        "grains, if all were discrete",
        &whole(derived::grains_if_discrete(scenario)),
        &source_of_fraction(scenario),
    );
    let smallest = figures(1e3 * derived::diameter_min(scenario));
    let largest = figures(1e3 * derived::diameter_max(scenario));
    page.row("diameters", &format!("{smallest} to {largest} mm"), "normal, cut at three deviations");
    page.row(
        "mass of the mean grain",
        &format!("{} kg", figures(derived::grain_mass_mean(scenario))),
        "rho pi r^2 depth",
    );
    page.row("mass of the specimen", &format!("{} kg", figures(derived::specimen_mass(scenario))), "");
    let affine = derived::moduli_of_grains(scenario);
    if scenario.method.has_points() {
        let continuum = &scenario.continuum;
        page.row(
            "K and G of the continuum",
            &megapascals(continuum.bulk_modulus, continuum.shear_modulus),
            "as in the job",
        );
    }
    if scenario.method.has_grains() {
        page.row("K and G of the contacts", &megapascals(affine.bulk, affine.shear), "affine estimate, an upper bound");
    }
}

fn source_of_fraction(scenario: &Scenario) -> String {
    let fraction = figures(derived::fraction_start(scenario));
    match scenario.continuum.fraction_start {
        Some(_) => format!("at a packing fraction of {fraction}"),
        None => format!("at a packing fraction of about {fraction}; the packing will tell"),
    }
}

fn grid(page: &mut Page, scenario: &Scenario) {
    let [blocks_x, blocks_y] = derived::blocks(scenario);
    let (cells_x, cells_y) = (derived::cells_x(scenario), derived::cells_y(scenario));
    page.section("Grid");
    page.row("cells", &format!("{cells_x} x {cells_y}"), &format!("of {} mm", figures(1e3 * scenario.continuum.cell)));
    page.row(
        "blocks",
        &format!("{blocks_x} x {blocks_y}"),
        &format!("of {0} x {0} cells; no more ranks than blocks", scenario.decomposition.cells_per_block),
    );
    if scenario.method.has_points() {
        page.row("material points", &whole(derived::points(scenario) as f64), "at the start");
        page.row("grains per cell", &figures(derived::grains_per_cell(scenario)), "");
    }
    if scenario.method == Method::Hybrid {
        let zone = figures(1e3 * derived::zone_height(scenario));
        page.row("height of the zone of grains", &format!("{zone} mm"), "around a flat band one cell thick");
    }
}

fn loading(page: &mut Page, scenario: &Scenario) {
    let number = |rate| figures(derived::inertial_number(scenario, rate));
    page.section("Loading");
    page.row("inertial number", &number(derived::shear_rate_mean(scenario)), "the whole height shearing alike");
    page.row("", &number(derived::shear_rate_band(scenario)), "a band of ten diameters taking it all");
    if scenario.method.has_grains() {
        page.row(
            "k_n/(P depth)",
            &figures(derived::stiffness_number(scenario)),
            "the mean overlap is one diameter over this",
        );
    }
    page.row("mass of the upper plate", &format!("{} kg", figures(scenario.loading.plate_mass)), "");
    page.row("damping of the upper plate", &format!("{} N s/m", figures(scenario.loading.plate_damping)), "");
}

fn steps(page: &mut Page, scenario: &Scenario, grains: &[Bound]) {
    page.section("Time step");
    page.row("step of the job", &format!("{} s", figures(scenario.time.step)), "");
    if scenario.method.has_grains() {
        page.bounds("stable step of the grains", grains);
    }
    let points = [derived::point_bound(scenario)];
    if scenario.method.has_points() {
        page.bounds("stable step of the continuum", &points);
        let (together, most) = (derived::grain_steps(scenario), derived::grain_steps_max(scenario));
        page.row(
            "steps of grains in one of it",
            &together.to_string(),
            &format!("time.grain_steps; {most} at most, within the stable step of the continuum alone"),
        );
    }
}

fn cost(page: &mut Page, scenario: &Scenario) {
    let steps = derived::steps(scenario);
    page.section("Cost");
    page.row("simulated time", &format!("{} s", figures(derived::duration(scenario))), "");
    page.row("steps", &whole(steps as f64), "");
    if scenario.method == Method::Hybrid {
        let (points, grains) = derived::population(scenario);
        page.row("after enrichment", &format!("{} points, {} grains", whole(points), whole(grains)), "");
        page.row(
            "speed-up over grains alone",
            &figures(derived::speed_up(scenario)),
            "1/(T_D/T + (1 - T_D/T) C_C/(C_D N_D))",
        );
    }
    page.row("memory", &format!("{} MB", whole(1e-6 * derived::memory(scenario))), "all ranks together, roughly");
    let seconds = derived::wall_time(scenario);
    page.row(
        "time to run",
        &format!("{} h ({} s)", figures(seconds / 3600.0), figures(seconds)),
        &format!(
            "on one core, without the packing, at {} ns a grain and {} ns a point and step of the continuum",
            whole(1e9 * derived::COST_GRAIN),
            whole(1e9 * derived::COST_POINT)
        ),
    );
    let (points, grains) = derived::population(scenario);
    page.pictures(&scenario.output, derived::duration(scenario), [points + grains, grains], 2);
}

/// What is allowed, but probably not meant.
fn warnings(scenario: &Scenario, grains: &[Bound]) -> Vec<String> {
    let mut warnings = warnings_of_motion(scenario, grains);
    if scenario.method.has_points() {
        warnings.extend(warnings_of_continuum(scenario));
    }
    if scenario.method == Method::Hybrid {
        warnings.extend(warnings_of_hybrid(scenario));
    }
    warnings
}

fn warnings_of_motion(scenario: &Scenario, grains: &[Bound]) -> Vec<String> {
    let mut warnings = Vec::new();
    let inertial = derived::inertial_number(scenario, derived::shear_rate_band(scenario));
    if inertial > INERTIAL_NUMBER_QUASI_STATIC {
        warnings.push(format!(
            "the inertial number of a band of ten diameters is {}; above {INERTIAL_NUMBER_QUASI_STATIC} stress depends on speed. Lower loading.speed to at most {} m/s for quasi-static shear.",
            figures(inertial),
            figures(scenario.loading.speed * INERTIAL_NUMBER_QUASI_STATIC / inertial)
        ));
    }
    let stiffness = derived::stiffness_number(scenario);
    let [key, _] = scenario.contact.keys_of_stiffness();
    // Where it grows with overlap it is that of an overlap which is not the mean one.
    if scenario.contact.stiffening() != Stiffening::WithOverlap
        && scenario.method.has_grains()
        && stiffness < STIFFNESS_NUMBER_MIN
    {
        warnings.push(format!(
            "k_n/(P depth) is {}, so mean overlaps exceed a hundredth of a diameter. Raise contact.{key} or lower loading.stress_normal.",
            figures(stiffness)
        ));
    }
    let bounds = derived::bounds_with(scenario, grains);
    let governing = derived::governing(&bounds);
    if scenario.time.step < STEP_SHARE_MIN * governing.step {
        warnings.push(format!(
            "the time step is {} of the stable one, {} s. A longer time.step would save time.",
            figures(scenario.time.step / governing.step),
            figures(governing.step)
        ));
    }
    warnings
}

fn warnings_of_continuum(scenario: &Scenario) -> Vec<String> {
    let mut warnings = Vec::new();
    let continuum = &scenario.continuum;
    if continuum.softening_rate < SOFTENING_SHARE_MIN * continuum.dilation_factor {
        warnings.push(format!(
            "continuum.softening_rate = {} hardly softens the material: keeping mass while it dilates would take a rate near continuum.dilation_factor = {}. The continuum will localise through its weak regions alone.",
            continuum.softening_rate, continuum.dilation_factor
        ));
    }
    let wave = derived::wave_speed(0.0, continuum.shear_modulus, derived::density_bulk(scenario));
    let crossing = scenario.specimen.height / wave;
    if scenario.loading.speed_ramp < 2.0 * crossing {
        warnings.push(format!(
            "a shear wave needs {} s through the specimen, and loading.speed_ramp = {} s is shorter than there and back: the start is a blow. A ramp of {} s would be gentle.",
            figures(crossing),
            figures(scenario.loading.speed_ramp),
            figures(10.0 * crossing)
        ));
    }
    warnings
}

fn warnings_of_hybrid(scenario: &Scenario) -> Vec<String> {
    let mut warnings = Vec::new();
    let affine = derived::moduli_of_grains(scenario);
    let continuum = &scenario.continuum;
    let (excess_bulk, excess_shear) = (continuum.bulk_modulus / affine.bulk, continuum.shear_modulus / affine.shear);
    if excess_bulk.max(excess_shear) > MODULUS_EXCESS_MAX {
        warnings.push(format!(
            "the continuum is stiffer than these contacts can make it: K is {} and G {} times the affine estimate, which is an upper bound. Stress will jump where grains replace points. Take moduli near {}, or stiffer contacts.",
            figures(excess_bulk),
            figures(excess_shear),
            megapascals(affine.bulk, affine.shear)
        ));
    }
    let speed_up = derived::speed_up(scenario);
    if speed_up < SPEED_UP_MIN {
        let verdict = match speed_up < 1.0 {
            true => "is slower than grains alone",
            false => "hardly pays",
        };
        warnings.push(format!(
            "with {} grains in a cell and a zone of {} of the height a hybrid {verdict}: its speed-up is {}. Larger cells, a smaller enrichment.distance or a higher specimen would help; method = \"dem\" is the alternative.",
            figures(derived::grains_per_cell(scenario)),
            figures(derived::zone_height(scenario) / scenario.specimen.height),
            figures(speed_up)
        ));
    }
    if scenario.oracle.recent_strain > RECENT_STRAIN_MAX {
        warnings.push(format!(
            "oracle.recent_strain = {} is more than the {RECENT_STRAIN_MAX} that the method's authors call the most; bands may never be found.",
            scenario.oracle.recent_strain
        ));
    }
    let distance = scenario.enrichment.distance / scenario.grains.diameter_mean;
    if distance > DISTANCE_IN_DIAMETERS_MAX {
        warnings.push(format!(
            "enrichment.distance is {} mean diameters; bands are 10 to 30 thick, and more than {DISTANCE_IN_DIAMETERS_MAX} only costs time.",
            figures(distance)
        ));
    }
    warnings
}
