//! Figures that follow from planar shear, and what it is as grains and as a continuum on a grid, from which all other figures
//! follow ([`super::figures`], [`super::mpm::figures`]).
//!
//! Everything here is a pure function of the checked input, in SI units.

use std::f64::consts::PI;

use super::assembly::{
    Assembly, Body, BodyServo, Cell, Matter, Motion, Packed, PathPoint, Preparation, Shape, Sizes, Source,
};
use super::figures::{self, grain_measure};
use super::mpm::{
    self, BodyContact, Boundary, Granular, Grid, InitialStress, Material, Mpm, Region, RegionShape, RigidBody, Watch,
};
use super::stable::{Bound, HERTZ_OVERLAP, springs_at};
use super::{BLOCK_OF_DISCS, Method, Scenario};
use crate::law::contact::{Contact, FLAT, Springs};

/// Solid volume fraction assumed where only the packing itself will tell (dense discs of this spread: 0.84 to 0.86).
pub const FRACTION_DENSE: f64 = 0.85;
/// Contacts of a disc in a dense frictional packing, for the affine estimates.
pub const COORDINATION_DENSE: f64 = 4.0;
impl Scenario {
    /// Grains of the job's sizes that fill the whole specimen.
    pub fn grains_of_specimen(&self) -> Assembly {
        let (grains, packing) = (&self.grains, &self.packing);
        let sizes = Sizes::Normal { mean: grains.diameter_mean, deviation: grains.diameter_deviation };
        let area = self.specimen.width * self.specimen.height;
        let blank = Assembly::blank();
        Assembly {
            seed: self.seed,
            cell: Cell {
                upper: [self.specimen.width, self.specimen.height, 0.0],
                periodic: [true, false, false],
                depth: self.specimen.depth,
                ..blank.cell
            },
            matter: Matter { density: grains.density, diameter_mean: grains.diameter_mean },
            source: Source::Packed(Packed {
                count: (area * fraction_start(self) / grain_measure(&sizes, 2)) as u64,
                sizes,
                preparation: Preparation::Compress { stress: packing.stress, fraction: None, unloaded: None },
                friction: packing.friction,
                fraction_start: packing.fraction_start,
                energy_ratio_max: packing.energy_ratio_max,
                cache: packing.cache.clone(),
            }),
            contact: self.contact,
            step: self.time.step,
            skin: self.decomposition.skin,
            block: BLOCK_OF_DISCS * grains.diameter_mean,
            output: self.output,
            ..blank
        }
    }

    /// The continuum between the plates and the grains that may take its place, as a job on a grid has them.
    pub fn on_grid(&self) -> Mpm {
        let (continuum, specimen) = (&self.continuum, &self.specimen);
        let (lower, upper) = ([0.0; 3], [specimen.width, specimen.height, 0.0]);
        let fraction = fraction_start(self);
        let law = self.material.law.with_fraction(fraction);
        let watch = Watch { diameter: self.grains.diameter_mean, oracle: self.oracle };
        let granular = Granular {
            method: self.method,
            piece: self.grains_of_specimen(),
            coupling: self.coupling,
            enrichment: self.enrichment,
            ..Granular::blank()
        };
        let blank = Mpm::blank();
        Mpm {
            name: self.name.clone(),
            grid: Grid {
                lower,
                upper,
                cell: continuum.cell,
                cells: [cells_x(self), cells_y(self), 1],
                periodic: [true, false, false],
                depth: specimen.depth,
                ..blank.grid
            },
            scheme: self.scheme,
            material: Material { density: density_bulk(self), law },
            nonlocal: self.nonlocal,
            regions: vec![Region { shape: RegionShape::Box { lower, upper }, fraction, ..Region::BLANK }],
            stress: InitialStress::Isotropic { pressure: self.packing.stress },
            oracle: (self.method == Method::Hybrid).then_some(watch),
            grains: Some(Box::new(granular)),
            step: self.time.step,
            grain_steps: grain_steps(self),
            end: duration(self),
            cells_per_block: self.decomposition.cells_per_block,
            output: self.output,
            ledger: self.ledger,
            ..blank
        }
    }

    /// The continuum with its plates as bodies: what planar shear means in the tables of a job on a grid, which runs as one.
    pub fn lowered(&self) -> Mpm {
        let (on_grid, loading) = (self.on_grid(), &self.loading);
        let (cell, per_block) = (on_grid.grid.cell, self.decomposition.cells_per_block);
        // Two cells that nothing enters beyond the faces, and two to rise by, in whole blocks.
        let beyond = 4usize.div_ceil(per_block) * per_block;
        let (mut lower, mut upper) = (on_grid.grid.lower, on_grid.grid.upper);
        lower[1] = -(beyond as f64) * cell;
        upper[1] = (on_grid.grid.cells[1] + beyond) as f64 * cell;
        let plate = |name: &str, height: f64, normal: f64, motion: Motion| RigidBody {
            body: Body {
                name: name.into(),
                shape: Shape::Plane { point: [0.0, height, 0.0], normal: [0.0, normal, 0.0] },
                motion,
            },
            contact: BodyContact::Rough,
            separates: false,
            at_face: self.continuum.at_face,
            side: None,
            group: None,
            seat: 0.0,
        };
        let path = PathPoint::rising_to([loading.speed, 0.0, 0.0], [0.0; 3], loading.speed_ramp);
        let sheared = Motion { path, oscillation: None, servo: Some(servo_of_plate(self)) };
        let weak = self.continuum.weak.iter().map(|weak| Region {
            shape: RegionShape::Box {
                lower: [weak.lower[0], weak.lower[1], 0.0],
                upper: [weak.upper[0], weak.upper[1], 0.0],
            },
            fraction: fraction_start(self) - weak.fraction_deficit,
            ..Region::BLANK
        });
        // An elastic material has no solid volume fraction, and none that is weaker.
        let yields = self.material.law.yields();
        let weak = weak.filter(|_| yields);
        let whole = on_grid.regions.iter().cloned().map(|region| match yields {
            true => region,
            false => Region { fraction: 1.0, ..region },
        });
        let cells = [on_grid.grid.cells[0], on_grid.grid.cells[1] + 2 * beyond, 1];
        Mpm {
            grid: Grid { lower, upper, cells, ..on_grid.grid },
            regions: weak.chain(whole).collect(),
            bodies: vec![
                plate("lower", 0.0, 1.0, Motion { path: Vec::new(), oscillation: None, servo: None }),
                plate("upper", self.specimen.height, -1.0, sheared),
            ],
            boundaries: [[Boundary::Periodic; 2], [Boundary::Free; 2], [Boundary::Free; 2]],
            grains: None,
            step: on_grid.step * on_grid.grain_steps as f64,
            grain_steps: 1,
            ..on_grid
        }
    }
}

/// Fastest vertical motion of the plate's servo, as a multiple of the shearing speed.
const PLATE_SPEED: f64 = 10.0;

/// What holds the upper plate at the normal stress.
pub fn servo_of_plate(scenario: &Scenario) -> BodyServo {
    let (loading, specimen) = (&scenario.loading, &scenario.specimen);
    BodyServo {
        direction: [0.0, 1.0, 0.0],
        force: loading.stress_normal * specimen.width * specimen.depth,
        mass: loading.plate_mass,
        damping: loading.plate_damping,
        speed_max: PLATE_SPEED * loading.speed,
    }
}

// Material

/// Solid volume fraction that the specimen starts with, as far as it is known before the packing is made.
pub fn fraction_start(scenario: &Scenario) -> f64 {
    scenario.material.law.fraction().unwrap_or(FRACTION_DENSE)
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
    /// K, Pa.
    pub bulk: f64,
    /// G, Pa.
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

/// Share of critical damping: enough to end the ringing of the start within a few periods, while the dashpot's own pull,
/// damping times the speed of dilation, stays below a per cent of the load.
const PLATE_DAMPING_RATIO: f64 = 0.1;

/// Mass, kg, and damping, N s/m, of a plate of which the job says nothing: a tenth of the specimen's mass.
pub fn plate_default(scenario: &Scenario) -> [f64; 2] {
    let mass = 0.1 * specimen_mass(scenario);
    [mass, plate_damping(scenario, mass)]
}

/// Default damping of a plate of that mass, kg, N s/m: a tenth of critical for plate and specimen as one oscillator.
///
/// The specimen is an elastic column of stiffness k = M width depth / height; a third of its mass moves with the
/// plate, as for a rod held at its far end (Rayleigh). Critical damping is 2 sqrt(k m).
pub fn plate_damping(scenario: &Scenario, plate_mass: f64) -> f64 {
    let modulus_p = scenario.material.law.modulus_longitudinal(2);
    let stiffness = modulus_p * scenario.specimen.width * scenario.specimen.depth / scenario.specimen.height;
    let mass = plate_mass + specimen_mass(scenario) / 3.0;
    PLATE_DAMPING_RATIO * 2.0 * (stiffness * mass).sqrt()
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

/// Shear rate if the whole height shears alike, 1/s.
pub fn shear_rate_mean(scenario: &Scenario) -> f64 {
    scenario.loading.speed / scenario.specimen.height
}

/// Shear rate if a band of ten diameters takes it all, 1/s.
pub fn shear_rate_band(scenario: &Scenario) -> f64 {
    let band = (10.0 * scenario.grains.diameter_mean).min(scenario.specimen.height);
    scenario.loading.speed / band
}

// Sizes

/// Cells along x, an exact division after the scenario's checks.
pub fn cells_x(scenario: &Scenario) -> usize {
    (scenario.specimen.width / scenario.continuum.cell).round() as usize
}

/// Cells along y that the specimen touches; the grid itself also has room for the plate to rise.
pub fn cells_y(scenario: &Scenario) -> usize {
    let cells = scenario.specimen.height / scenario.continuum.cell;
    (cells - 1e-9).ceil() as usize
}

/// Edge of a block, m.
pub fn block_edge(scenario: &Scenario) -> f64 {
    scenario.decomposition.cells_per_block as f64 * scenario.continuum.cell
}

/// Material points, if the whole specimen is continuum.
pub fn points(scenario: &Scenario) -> usize {
    let per_cell = scenario.scheme.points_per_cell * scenario.scheme.points_per_cell;
    cells_x(scenario) * cells_y(scenario) * per_cell
}

/// Share of the specimen's grains that are held in memory: those that a hybrid takes grains from may fill its zone alone.
pub fn share_of_grains(scenario: &Scenario) -> f64 {
    match scenario.method {
        Method::Dem => 1.0,
        Method::Mpm | Method::MpmDem | Method::Fem | Method::FemDem => 0.0,
        Method::Hybrid => scenario.packing.height.map_or(1.0, |height| height / scenario.specimen.height),
    }
}

/// How much faster a hybrid is than grains alone (Chen et al. 2021, 6.4.1):
/// 1 / (T_D/T + (1 - T_D/T) C_C / (C_D N_D)), with costs in s per cell and step, C_D N_D of its grains.
pub fn speed_up_by(zone: f64, cost_continuum: f64, cost_grains: f64) -> f64 {
    1.0 / (zone + (1.0 - zone) * cost_continuum / cost_grains)
}

// Stable time steps

/// Every bound that this method is held to.
pub fn bounds(scenario: &Scenario) -> Vec<Bound> {
    let mut bounds = Vec::new();
    if scenario.moves_grains() {
        bounds.extend(figures::bounds(&scenario.grains_of_specimen()));
    }
    if scenario.method.has_points() {
        let of_points = mpm::figures::bounds(&scenario.on_grid());
        bounds.extend(
            of_points.into_iter().map(|bound| Bound { step: bound.step / scenario.time.grain_steps as f64, ..bound }),
        );
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::mpm::forecast::grains_if_discrete;

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
        let (grains, on_grid) = (scenario.grains_of_specimen(), scenario.on_grid());
        near(figures::grain(&grains, 1e-3).mass, 1.987e-5);
        near(figures::stiffness_over_load(&grains, 4e5), 443.0);
        let moduli = moduli_affine(&springs_mean(&scenario.contact, 1e-3), FRACTION_DENSE, 0.01);
        near(moduli.bulk, 95.9e6);
        near(moduli.shear, 71.9e6);
        near(figures::grains(&grains).unwrap() as f64, 7740.0);
        near(grains_if_discrete(&on_grid), 7740.0);
        assert_eq!([cells_x(&scenario), cells_y(&scenario)], [8, 16]);
        assert_eq!(mpm::figures::blocks(&on_grid), [4, 8, 1]);
        assert_eq!([points(&scenario), mpm::figures::points(&on_grid) as usize], [512; 2]);
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
