//! Packings: grains inserted loosely between two rough plates, to be compressed by the upper one.

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::math::PI;
use crate::base::space::{Linear, Plane, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, Mover};
use crate::job::Scenario;
use crate::job::assembly::Sizes;
use crate::prepare::insert::{places, radii};

/// Plates by their index in a world.
pub const LOWER: u8 = 0;
/// The sheared plate, at the larger y.
pub const UPPER: u8 = 1;

/// Solid volume fraction that the number of grains is reckoned with.
const FRACTION_EXPECTED: f64 = 0.845;
/// Depth of the layer of the finished packing that is glued to each plate, in mean diameters. A single flat row would
/// order the grains beside it into a smooth, weak interface along which the specimen slips instead of shearing.
const GLUED_LAYER: f64 = 3.0;

/// Grains as inserted, and the height of the upper plate's face above the lower's, m.
pub struct Inserted {
    /// By id: free ones, then the rows glued to the lower and the upper plate.
    pub grains: Vec<GrainRow<Plane>>,
    /// m.
    pub height: f64,
}

/// Glues the outer layers of a packing between faces at 0 and `height` to the plates, and lowers everything so that the
/// lower face is at y = 0 again; returns the height between the new faces, m.
pub fn glue_layers(scenario: &Scenario, height: f64, grains: &mut [GrainRow<Plane>]) -> f64 {
    let depth = glued_depth(scenario);
    for grain in grains.iter_mut() {
        if grain.hot.position[1] < depth {
            grain.hand_to(Mover::Body(LOWER));
        } else if grain.hot.position[1] > height - depth {
            grain.hand_to(Mover::Body(UPPER));
        }
        grain.hot.position[1] -= depth;
    }
    height - 2.0 * depth
}

/// Mass of a disc, kg.
pub fn mass_of(scenario: &Scenario, radius: f64) -> f64 {
    scenario.grains.density * Plane::grain_volume(radius, scenario.specimen.depth)
}

/// Depth of the layer glued to each plate once the packing is made, m.
fn glued_depth(scenario: &Scenario) -> f64 {
    GLUED_LAYER * scenario.grains.diameter_mean
}

/// How far glued grains reach beyond a plate's face: the layer and the row behind it, m.
pub fn glued_reach(scenario: &Scenario) -> f64 {
    glued_depth(scenario) + 1.5 * scenario.grains.diameter_mean
}

/// Grains that fill the specimen and the layers to be glued at the expected solid volume fraction.
pub fn count_of(scenario: &Scenario) -> usize {
    let (mean, deviation) = (scenario.grains.diameter_mean, scenario.grains.diameter_deviation);
    let area = 0.25 * PI * (mean * mean + deviation * deviation);
    let height = scenario.specimen.height + 2.0 * glued_depth(scenario);
    (FRACTION_EXPECTED * scenario.specimen.width * height / area).round() as usize
}

/// Inserts the grains: free ones at random places without overlap, row by row the glued ones of both plates.
pub fn insert(scenario: &Scenario) -> Result<Inserted, Error> {
    let width = scenario.specimen.width;
    let (mean, deviation) = (scenario.grains.diameter_mean, scenario.grains.diameter_deviation);
    let sizes = Sizes::Normal { mean, deviation };
    let radii = radii(&sizes, scenario.seed, count_of(scenario) as u64);
    let area: f64 = radii.iter().map(|radius| PI * radius * radius).sum();
    let height = area / (width * scenario.packing.fraction_start);
    let room =
        Cell::<Plane>::cuboid(Linear::zero(), <Plane as Space>::Vector::new(width, height), [true, false, false]);
    let places = places(&room, &sizes, scenario.seed, &radii, |_, _| true).map_err(|_| {
        Error::User(format!(
            "`packing.fraction_start` = {} is too dense to insert {} grains without overlap; use 0.45 or less",
            scenario.packing.fraction_start,
            radii.len()
        ))
    })?;
    let free = |(id, (place, radius)): (usize, (&<Plane as Space>::Vector, &f64))| {
        GrainRow::resting(GrainId(id as u64), *place, *radius, mass_of(scenario, *radius), Mover::Free)
    };
    let mut grains: Vec<GrainRow<Plane>> = places.iter().zip(&radii).enumerate().map(free).collect();
    glue_rows(scenario, height, &mut grains);
    Ok(Inserted { grains, height })
}

/// One row of mean grains, shoulder to shoulder, makes each plate rough; its outermost points lie on the plate's face.
fn glue_rows(scenario: &Scenario, height: f64, grains: &mut Vec<GrainRow<Plane>>) {
    let width = scenario.specimen.width;
    let number = (width / scenario.grains.diameter_mean).floor().max(1.0) as usize;
    let radius = 0.5 * width / number as f64;
    for (plate, y) in [(LOWER, -radius), (UPPER, height + radius)] {
        for column in 0..number {
            let id = GrainId(grains.len() as u64);
            let position = <Plane as Space>::Vector::new((column as f64 + 0.5) * 2.0 * radius, y);
            grains.push(GrainRow::resting(id, position, radius, mass_of(scenario, radius), Mover::Body(plate)));
        }
    }
}
