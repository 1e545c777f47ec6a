//! Figures that follow from a scenario: what `scree check` prints and what refuses an unstable time step.
//!
//! Everything here is a pure function of the checked input, in SI units.

use std::f64::consts::PI;

use super::stable::{self, GrainScale, HERTZ_OVERLAP, springs_at};

pub use super::stable::{Bound, governing};
use super::{Method, Scenario};
use crate::law::contact::{Contact, FLAT, Springs};

/// Packing fraction assumed where only the packing itself will tell (dense discs of this spread: 0.84 to 0.86).
pub const FRACTION_DENSE: f64 = 0.85;
/// Contacts of a disc in a dense frictional packing, for the affine estimates.
pub const COORDINATION_DENSE: f64 = 4.0;
/// Standard deviations at which the normal distribution of diameters is cut.
pub const DIAMETER_CUT: f64 = 3.0;
/// Share of sigma^2 that is left of a normal distribution cut at three deviations.
const VARIANCE_CUT: f64 = 0.973_3;
/// Share of the time a P wave takes through one cell that a step of the continuum may last.
pub const COURANT_MAX: f64 = 0.5;
/// Cost of one grain over one step on one core, s.
pub const COST_GRAIN: f64 = 50e-9;
/// Cost of one material point over one step on one core, s.
pub const COST_POINT: f64 = 150e-9;
/// Bytes that one grain takes with its contacts, neighbour list and ghosts.
pub const BYTES_GRAIN: f64 = 1000.0;
/// Bytes that one material point takes.
const BYTES_POINT: f64 = 500.0;
/// Bytes that one grid node takes over all of its fields.
const BYTES_NODE: f64 = 200.0;
/// Bytes that the program and its libraries take before there is any material.
const BYTES_PROGRAM: f64 = 40e6;

// Geometry of the grains

/// Diameter of the smallest grain that can be drawn, m.
pub fn diameter_min(scenario: &Scenario) -> f64 {
    scenario.grains.diameter_mean - DIAMETER_CUT * scenario.grains.diameter_deviation
}

/// Diameter of the largest grain that can be drawn, m.
pub fn diameter_max(scenario: &Scenario) -> f64 {
    scenario.grains.diameter_mean + DIAMETER_CUT * scenario.grains.diameter_deviation
}

/// Mass of the grain of mean diameter, kg. Table 1 of Chen et al. (2021) with a depth of 1 cm: 1.987e-5 kg.
pub fn grain_mass_mean(scenario: &Scenario) -> f64 {
    let radius = 0.5 * scenario.grains.diameter_mean;
    stable::grain_mass(scenario.grains.density, radius, scenario.specimen.depth, 2)
}

/// Mass of the lightest grain that can be drawn, kg.
pub fn grain_mass_min(scenario: &Scenario) -> f64 {
    let radius = 0.5 * diameter_min(scenario);
    stable::grain_mass(scenario.grains.density, radius, scenario.specimen.depth, 2)
}

/// Mean area of a grain's disc, m2: pi (mean^2 + variance) / 4.
pub fn grain_area_mean(scenario: &Scenario) -> f64 {
    let mean = scenario.grains.diameter_mean;
    let deviation = scenario.grains.diameter_deviation;
    0.25 * PI * (mean * mean + VARIANCE_CUT * deviation * deviation)
}

// Material

/// Packing fraction that the specimen starts with, as far as it is known before the packing is made.
pub fn fraction_start(scenario: &Scenario) -> f64 {
    scenario.continuum.fraction_start.unwrap_or(FRACTION_DENSE)
}

/// Mass of solid over the volume of solid and void, kg/m3.
pub fn density_bulk(scenario: &Scenario) -> f64 {
    scenario.grains.density * fraction_start(scenario)
}

/// Mass of the specimen without its plates, kg.
pub fn specimen_mass(scenario: &Scenario) -> f64 {
    let box_of = &scenario.specimen;
    density_bulk(scenario) * box_of.width * box_of.height * box_of.depth
}

/// Bulk and shear modulus of a packing, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moduli {
    pub bulk: f64,
    pub shear: f64,
}

/// What the contact law would give if every grain moved with the mean strain, Pa.
///
/// The Love-Weber sum over z Phi / (2 pi r^2) contacts per area with branch 2 r gives
///
/// ```text
/// K = z Phi  k_n        / (2 pi depth)
/// G = z Phi (k_n + k_t) / (4 pi depth)
/// ```
///
/// Grains that may also move against the mean are softer, so these are upper bounds (Kruyt & Rothenburg 1998).
pub fn moduli_affine(springs: &Springs, fraction: f64, depth: f64) -> Moduli {
    let contacts = COORDINATION_DENSE * fraction;
    Moduli {
        bulk: contacts * springs.normal / (2.0 * PI * depth),
        shear: contacts * (springs.normal + springs.tangential) / (4.0 * PI * depth),
    }
}

/// Springs between two mean grains.
pub fn springs_mean(contact: &Contact, diameter_mean: f64) -> Springs {
    springs_at(contact, [0.5 * diameter_mean; 2], [FLAT; 2], HERTZ_OVERLAP)
}

/// The affine estimate for this scenario's contact law.
pub fn moduli_of_grains(scenario: &Scenario) -> Moduli {
    let springs = springs_mean(&scenario.contact, scenario.grains.diameter_mean);
    moduli_affine(&springs, fraction_start(scenario), scenario.specimen.depth)
}

/// Speed of a P wave, m/s: sqrt((K + G) / rho) in plane strain.
pub fn wave_speed(bulk: f64, shear: f64, density: f64) -> f64 {
    ((bulk + shear) / density).sqrt()
}

/// Default mass of the upper plate, kg: a tenth of the specimen's.
pub fn plate_mass_default(specimen_mass: f64) -> f64 {
    0.1 * specimen_mass
}

/// Share of critical damping: enough to end the ringing of the start within a few periods, while the dashpot's own pull,
/// damping times the speed of dilation, stays below a per cent of the load.
const PLATE_DAMPING_RATIO: f64 = 0.1;

/// Default damping of the upper plate, N s/m: a tenth of critical for plate and specimen as one oscillator.
///
/// The specimen is an elastic column of stiffness k = (K + G) width depth / height; a third of its mass moves with the
/// plate, as for a rod held at its far end (Rayleigh). Critical damping is 2 sqrt(k m).
pub fn plate_damping_default(
    modulus_p: f64,
    [width, height, depth]: [f64; 3],
    plate_mass: f64,
    specimen_mass: f64,
) -> f64 {
    let stiffness = modulus_p * width * depth / height;
    let mass = plate_mass + specimen_mass / 3.0;
    PLATE_DAMPING_RATIO * 2.0 * (stiffness * mass).sqrt()
}

/// Mass, kg, and damping, N s/m, of a plate of which the job says nothing.
pub fn plate_default(scenario: &Scenario) -> [f64; 2] {
    let specimen_mass = specimen_mass(scenario);
    let mass = plate_mass_default(specimen_mass);
    [mass, plate_damping(scenario, mass)]
}

/// Default damping of a plate of that mass, kg, over the job's specimen, N s/m.
pub fn plate_damping(scenario: &Scenario, plate_mass: f64) -> f64 {
    let modulus_p = scenario.continuum.bulk_modulus + scenario.continuum.shear_modulus;
    let size = [scenario.specimen.width, scenario.specimen.height, scenario.specimen.depth];
    plate_damping_default(modulus_p, size, plate_mass, specimen_mass(scenario))
}

// The run

/// Time that the plate takes to the final strain, s. While the speed ramps up, half of the distance is lost.
pub fn duration(scenario: &Scenario) -> f64 {
    let loading = &scenario.loading;
    let travel = loading.strain_end * scenario.specimen.width;
    let ramp_travel = 0.5 * loading.speed * loading.speed_ramp;
    if travel < ramp_travel {
        return (2.0 * travel * loading.speed_ramp / loading.speed).sqrt();
    }
    travel / loading.speed + 0.5 * loading.speed_ramp
}

/// Steps of the whole run.
pub fn steps(scenario: &Scenario) -> u64 {
    (duration(scenario) / scenario.time.step).ceil() as u64
}

/// Steps of grains in one of the continuum.
pub fn grain_steps(scenario: &Scenario) -> u64 {
    if scenario.method.has_points() { scenario.time.grain_steps } else { 1 }
}

/// The most of them that are stable.
pub fn grain_steps_max(scenario: &Scenario) -> u64 {
    let alone = point_bound(scenario).step * scenario.time.grain_steps as f64;
    (alone / scenario.time.step).floor().max(1.0) as u64
}

/// I = rate D sqrt(rho / P): inertia against confinement; below about 1e-3 flow is quasi-static (GDR MiDi 2004).
pub fn inertial_number(scenario: &Scenario, shear_rate: f64) -> f64 {
    let time_of_grain =
        scenario.grains.diameter_mean * (scenario.grains.density / scenario.loading.stress_normal).sqrt();
    shear_rate * time_of_grain
}

/// Shear rate if the whole height shears alike, 1/s.
pub fn shear_rate_mean(scenario: &Scenario) -> f64 {
    scenario.loading.speed / scenario.specimen.height
}

/// Shear rate if a band of ten diameters takes it all, 1/s.
pub fn shear_rate_band(scenario: &Scenario) -> f64 {
    let band = (10.0 * scenario.grains.diameter_mean).min(scenario.specimen.height);
    scenario.loading.speed / band
}

/// k_n / (P depth): the reciprocal of the mean overlap in diameters.
pub fn stiffness_number(scenario: &Scenario) -> f64 {
    let springs = springs_mean(&scenario.contact, scenario.grains.diameter_mean);
    springs.normal / (scenario.loading.stress_normal * scenario.specimen.depth)
}

// Sizes

/// Grains, if the whole specimen were discrete.
pub fn grains_if_discrete(scenario: &Scenario) -> f64 {
    let area = scenario.specimen.width * scenario.specimen.height;
    area * fraction_start(scenario) / grain_area_mean(scenario)
}

/// Grains in one cell of the grid.
pub fn grains_per_cell(scenario: &Scenario) -> f64 {
    let cell = scenario.continuum.cell;
    cell * cell * fraction_start(scenario) / grain_area_mean(scenario)
}

/// Cells along x, an exact division after the scenario's checks.
pub fn cells_x(scenario: &Scenario) -> usize {
    (scenario.specimen.width / scenario.continuum.cell).round() as usize
}

/// Cells along y that the specimen touches; the grid itself also has room for the plate to rise.
pub fn cells_y(scenario: &Scenario) -> usize {
    let cells = scenario.specimen.height / scenario.continuum.cell;
    (cells - 1e-9).ceil() as usize
}

/// Blocks along x and y that the specimen touches.
pub fn blocks(scenario: &Scenario) -> [usize; 2] {
    let edge = scenario.decomposition.cells_per_block;
    [cells_x(scenario).div_ceil(edge), cells_y(scenario).div_ceil(edge)]
}

/// Edge of a block, m.
pub fn block_edge(scenario: &Scenario) -> f64 {
    scenario.decomposition.cells_per_block as f64 * scenario.continuum.cell
}

/// Material points, if the whole specimen is continuum.
pub fn points(scenario: &Scenario) -> usize {
    let per_cell = scenario.continuum.points_per_cell * scenario.continuum.points_per_cell;
    cells_x(scenario) * cells_y(scenario) * per_cell
}

/// Height of the zone of grains around a flat band one cell thick, m.
pub fn zone_height(scenario: &Scenario) -> f64 {
    let zone = 2.0 * scenario.enrichment.distance + 2.0 * scenario.continuum.cell;
    zone.min(scenario.specimen.height)
}

/// Material points and grains that are alive together at the costliest time.
pub fn population(scenario: &Scenario) -> (f64, f64) {
    let points = points(scenario) as f64;
    let grains = grains_if_discrete(scenario);
    match scenario.method {
        Method::Dem => (0.0, grains),
        Method::Mpm => (points, 0.0),
        Method::Hybrid => {
            let zone = zone_height(scenario) / scenario.specimen.height;
            (points * (1.0 - zone), grains * zone)
        }
    }
}

/// Memory of all ranks together, bytes; a rough figure. A hybrid also holds the packing that grains are taken from.
pub fn memory(scenario: &Scenario) -> f64 {
    let (points, grains) = match scenario.method {
        Method::Hybrid => {
            let share = scenario.packing.height.map_or(1.0, |height| height / scenario.specimen.height);
            (points(scenario) as f64, share * grains_if_discrete(scenario))
        }
        _ => population(scenario),
    };
    let nodes = (cells_x(scenario) * cells_y(scenario)) as f64;
    BYTES_PROGRAM + BYTES_GRAIN * grains + BYTES_POINT * points + BYTES_NODE * nodes
}

/// Wall time on one core, s, without the making of the packing; a hybrid is taken as enriched from the start.
pub fn wall_time(scenario: &Scenario) -> f64 {
    let (points, grains) = population(scenario);
    let per_step = points * cost_of_point(scenario) + grains * COST_GRAIN;
    steps(scenario) as f64 * per_step
}

/// Wall time that a point takes in a step of grains, s: it goes to the grid once for several.
fn cost_of_point(scenario: &Scenario) -> f64 {
    COST_POINT / grain_steps(scenario) as f64
}

/// How much faster the hybrid is than grains alone (Chen et al. 2021, 6.4.1):
/// 1 / (T_D/T + (1 - T_D/T) C_C / (C_D N_D)), with C_C per cell, C_D per grain and N_D grains per cell.
pub fn speed_up(scenario: &Scenario) -> f64 {
    let zone = zone_height(scenario) / scenario.specimen.height;
    let per_cell = scenario.continuum.points_per_cell * scenario.continuum.points_per_cell;
    let cost_continuum = per_cell as f64 * cost_of_point(scenario);
    let cost_grains = COST_GRAIN * grains_per_cell(scenario);
    speed_up_by(zone, cost_continuum, cost_grains)
}

/// The same with T_D/T, C_C and C_D N_D as they were measured; costs in s per cell and step.
pub fn speed_up_by(zone: f64, cost_continuum: f64, cost_grains: f64) -> f64 {
    1.0 / (zone + (1.0 - zone) * cost_continuum / cost_grains)
}

// Stable time steps

/// What bounds the step of the grains: [`stable::bounds`] with the lightest and the mean disc of this scenario.
pub fn grain_bounds(scenario: &Scenario) -> Vec<Bound> {
    let radius = 0.5 * scenario.grains.diameter_mean;
    let lightest = GrainScale { radius: 0.5 * diameter_min(scenario), mass: grain_mass_min(scenario), dimension: 2 };
    let mean = GrainScale { radius, mass: grain_mass_mean(scenario), dimension: 2 };
    stable::bounds(&scenario.contact, &lightest, &mean)
}

/// What bounds the step of the continuum: a P wave may cross half a cell.
pub fn point_bound(scenario: &Scenario) -> Bound {
    let continuum = &scenario.continuum;
    let speed = wave_speed(continuum.bulk_modulus, continuum.shear_modulus, density_bulk(scenario));
    Bound {
        cause: "P wave through a cell",
        formula: "0.5 cell/sqrt((K + G)/rho)/grain_steps",
        remedy: "Beyond it the grid blows up; shorten the step, or take fewer time.grain_steps, larger cells or a softer material.",
        step: COURANT_MAX * continuum.cell / speed / scenario.time.grain_steps as f64,
    }
}

/// Every bound that this method is held to.
pub fn bounds(scenario: &Scenario) -> Vec<Bound> {
    bounds_with(scenario, &grain_bounds(scenario))
}

/// The same with the bounds of the grains that there are.
pub fn bounds_with(scenario: &Scenario, grains: &[Bound]) -> Vec<Bound> {
    let mut bounds = Vec::new();
    if scenario.moves_grains() {
        bounds.extend_from_slice(grains);
    }
    if scenario.method.has_points() {
        bounds.push(point_bound(scenario));
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planar_shear(sets: &[&str]) -> Result<Scenario, crate::base::error::Error> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/planar_shear.toml");
        Scenario::load(path.as_ref(), &sets)
    }

    /// Section 6.4.1: where the continuum costs 24 % of the grains, which at 230 grains in an element is a zone of 1/130 of the
    /// height, the paper's triaxial test is about 100 times as fast.
    #[test]
    fn the_papers_speed_up() {
        let (element, grains): (f64, f64) = (4.87e-7, 230.0 * 1.14e-6);
        let zone = 1.0 / (1.0 + 0.24 * grains / element);
        assert!((1.0 / zone - 130.0).abs() < 1.0, "{zone}");
        assert!((speed_up_by(zone, element, grains) - 105.0).abs() < 1.0);
        assert_eq!(speed_up_by(1.0, element, grains), 1.0);
    }

    /// Table 1 with a depth of 1 cm: mean mass, stiffness number, affine K of about 100 MPa, 58 grains in a cell.
    #[test]
    fn figures_of_the_papers_specimen() {
        let scenario = planar_shear(&[]).unwrap();
        let near = |value: f64, wanted: f64| assert!((value / wanted - 1.0).abs() < 0.02, "{value}");
        near(grain_mass_mean(&scenario), 1.987e-5);
        near(stiffness_number(&scenario), 443.0);
        near(moduli_of_grains(&scenario).bulk, 95.9e6);
        near(moduli_of_grains(&scenario).shear, 71.9e6);
        near(grains_if_discrete(&scenario), 7740.0);
        near(grains_per_cell(&scenario), 60.5);
        assert_eq!([cells_x(&scenario), cells_y(&scenario)], [8, 16]);
        assert_eq!(blocks(&scenario), [4, 8]);
        assert_eq!(points(&scenario), 512);
        assert_eq!(steps(&scenario), 4_281_250);
    }

    /// Measured: gamma 7 is clean at 2e-7 s and not at 5e-7 s, gamma 3.5 is clean at 4e-7 s and not at 5e-7 s.
    #[test]
    fn table_1_as_printed_is_refused_and_what_was_measured_clean_is_not() {
        let gamma = ["contact.damping_normal=7", "contact.damping_tangential=7"];
        for (step, damping, stable) in [
            ("time.step=2e-7", 7, true),
            ("time.step=5e-7", 7, false),
            ("time.step=4e-7", 3, true),
            ("time.step=5e-7", 3, false),
        ] {
            let mut sets = vec![step];
            if damping == 7 {
                sets.extend(gamma);
            }
            assert_eq!(planar_shear(&sets).is_ok(), stable, "{sets:?}");
        }
    }

    /// While the plate still gathers speed it covers half of what it would at full speed.
    #[test]
    fn the_duration_knows_the_ramp() {
        let scenario = planar_shear(&["loading.speed_ramp=\"1 s\""]).unwrap();
        assert!((duration(&scenario) - 2.21).abs() < 1e-12);
        let within = planar_shear(&["loading.speed_ramp=\"10 s\""]).unwrap();
        let time = duration(&within);
        let travel = 0.5 * within.loading.speed * time * time / 10.0;
        assert!((travel - 0.57 * 0.06).abs() < 1e-12);
    }
}
