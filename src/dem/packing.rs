//! Packings: grains thrown loosely between two rough plates, to be compressed by the upper one.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use crate::dem::grains::{GrainRow, Mover};
use crate::error::Error;
use crate::ids::GrainId;
use crate::math::PI;
use crate::scenario::Scenario;
use crate::space::{Plane, Space, Words};

/// Plates by their index in a world.
pub const LOWER: u8 = 0;
pub const UPPER: u8 = 1;

/// Packing fraction that the number of grains is reckoned with.
const FRACTION_EXPECTED: f64 = 0.845;
/// Depth of the layer of the finished packing that is glued to each plate, in mean diameters. A single flat row would
/// order the grains beside it into a smooth, weak interface along which the specimen slips instead of shearing.
const GLUED_LAYER: f64 = 3.0;
/// Throws per grain before the start counts as too dense.
const THROWS_MAX: usize = 20_000;

/// Grains as thrown, and the height of the upper plate's face above the lower's, m.
pub struct Thrown<M> {
    pub grains: Vec<GrainRow<Plane, M>>,
    pub height: f64,
}

/// Glues the outer layers of a packing between faces at 0 and `height` to the plates, and lowers everything so that the
/// lower face is at y = 0 again; returns the height between the new faces, m.
pub fn glue_layers<M: Words<f64>>(scenario: &Scenario, height: f64, grains: &mut [GrainRow<Plane, M>]) -> f64 {
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

/// Random numbers of one grain: from (job seed, id) alone.
fn random_of(seed: u64, id: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(id);
    random
}

/// Uniform in [0, 1) from the upper 53 bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * (0.5f64).powi(53)
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

/// Grains that fill the specimen and the layers to be glued at the expected packing fraction.
pub fn count_of(scenario: &Scenario) -> usize {
    let (mean, deviation) = (scenario.grains.diameter_mean, scenario.grains.diameter_deviation);
    let area = 0.25 * PI * (mean * mean + deviation * deviation);
    let height = scenario.specimen.height + 2.0 * glued_depth(scenario);
    (FRACTION_EXPECTED * scenario.specimen.width * height / area).round() as usize
}

/// Throws the grains: free ones at random places without overlap, row by row the glued ones of both plates.
pub fn throw<M: Words<f64>>(scenario: &Scenario) -> Result<Thrown<M>, Error> {
    let width = scenario.specimen.width;
    let count = count_of(scenario);
    let mut randoms: Vec<ChaCha8Rng> = (0..count as u64).map(|id| random_of(scenario.seed, id)).collect();
    let radii: Vec<f64> = randoms.iter_mut().map(|random| radius_of(scenario, random)).collect();
    let area: f64 = radii.iter().map(|radius| PI * radius * radius).sum();
    let height = area / (width * scenario.packing.fraction_start);
    let radius_max = radii.iter().copied().fold(0.0, f64::max);

    let mut places = Places::new(width, height, 2.0 * radius_max);
    let mut grains = Vec::with_capacity(count);
    for (id, (random, radius)) in randoms.iter_mut().zip(&radii).enumerate() {
        let place = (0..THROWS_MAX)
            .map(|_| [width * uniform(random), radius + (height - 2.0 * radius) * uniform(random)])
            .find(|place| places.is_free(*place, *radius))
            .ok_or_else(|| {
                Error::User(format!(
                    "`packing.fraction_start` = {} is too dense to throw {count} grains without overlap; use 0.45 or less",
                    scenario.packing.fraction_start
                ))
            })?;
        places.put(place, *radius);
        let position = <Plane as Space>::Vector::new(place[0], place[1]);
        grains.push(GrainRow::resting(GrainId(id as u64), position, *radius, mass_of(scenario, *radius), Mover::Free));
    }
    glue_rows(scenario, height, &mut grains);
    Ok(Thrown { grains, height })
}

/// A normal deviate of the diameter, cut at three deviations.
fn radius_of(scenario: &Scenario, random: &mut ChaCha8Rng) -> f64 {
    loop {
        let deviate: f64 = StandardNormal.sample(random);
        if deviate.abs() <= 3.0 {
            return 0.5 * (scenario.grains.diameter_mean + deviate * scenario.grains.diameter_deviation);
        }
    }
}

/// One row of mean grains, shoulder to shoulder, makes each plate rough; its outermost points lie on the plate's face.
fn glue_rows<M: Words<f64>>(scenario: &Scenario, height: f64, grains: &mut Vec<GrainRow<Plane, M>>) {
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

/// Occupied places in bins, periodic in x.
struct Places {
    width: f64,
    edge: [f64; 2],
    counts: [usize; 2],
    bins: Vec<Vec<([f64; 2], f64)>>,
}

impl Places {
    fn new(width: f64, height: f64, reach: f64) -> Self {
        let counts = [((width / reach) as usize).max(1), ((height / reach) as usize).max(1)];
        let edge = [width / counts[0] as f64, height / counts[1] as f64];
        Self { width, edge, counts, bins: vec![Vec::new(); counts[0] * counts[1]] }
    }

    fn bin(&self, place: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| ((place[axis] / self.edge[axis]) as usize).min(self.counts[axis] - 1))
    }

    fn put(&mut self, place: [f64; 2], radius: f64) {
        let [column, row] = self.bin(place);
        self.bins[row * self.counts[0] + column].push((place, radius));
    }

    fn is_free(&self, place: [f64; 2], radius: f64) -> bool {
        let [column, row] = self.bin(place);
        for row in row.saturating_sub(1)..=(row + 1).min(self.counts[1] - 1) {
            for step in 0..3 {
                let column = (column + self.counts[0] + step - 1) % self.counts[0];
                for (other, other_radius) in &self.bins[row * self.counts[0] + column] {
                    let apart = (place[0] - other[0]).abs();
                    let x = apart.min(self.width - apart);
                    let y = place[1] - other[1];
                    let reach = radius + other_radius;
                    if x * x + y * y < reach * reach {
                        return false;
                    }
                }
            }
        }
        true
    }
}
