//! What a job on a grid will take on one core, part by part, before anything of it is done.

use super::{Granular, KnownBands, Mpm, Origin, figures};
use crate::base::math::PI;
use crate::job::Method;
use crate::job::assembly::{Packed, Preparation, Shape, Source};
use crate::job::derived::BYTES_GRAIN;
use crate::job::figures::sizes;

// Chosen on `jobs/triaxial.toml`, one core (VALIDATION.md, "Forecasts"); in space by `scree bench dem --space solid`.

/// Wall time of a grain and step, s: in a periodic piece that is compressed, among grains and bodies alone, and where grains share
/// nodes with points or membranes.
const COST_IN_PIECE: f64 = 80e-9;
const COST_OF_GRAIN: [f64; 2] = [40e-9, 120e-9];
const COST_OF_SHARING: f64 = 60e-9;
/// Of a node and step of a grid that grains share, s.
const COST_OF_NODE: f64 = 130e-9;
/// Time that a piece takes to come to rest under a stress, and a specimen that is cut of it, in t_p = d sqrt(rho/p).
const TIME_OF_PIECE: f64 = 120.0;
const TIME_OF_SPECIMEN: f64 = 80.0;
/// How often a specimen with bodies that are seated comes to rest, about.
const SEATINGS: f64 = 3.0;

/// A job's rows at its costliest time and what it takes on one core.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forecast {
    pub points: f64,
    pub grains: f64,
    /// Share of the material that grains take the place of.
    pub zone: f64,
    /// Of making the piece of packing and of bringing the specimen to rest, where neither is in the cache yet, s.
    pub piece: f64,
    pub specimen: f64,
    /// Of the steps, s; a hybrid is taken as enriched from the start.
    pub steps: f64,
    /// Of all ranks together, bytes.
    pub memory: f64,
}

impl Forecast {
    pub fn of(job: &Mpm) -> Self {
        let points: u64 = figures::points_of_regions(job).iter().sum();
        let Some(granular) = job.grains.as_deref() else {
            let steps = figures::wall_time(job, points);
            return Self { points: points as f64, steps, memory: figures::memory(job, points), ..Self::default() };
        };
        let all = grains_if_discrete(job, granular);
        let zone = match granular.method {
            Method::Dem => 1.0,
            Method::Mpm => 0.0,
            Method::Hybrid => zone_share(job, granular),
        };
        let has_points = granular.method != Method::Dem;
        let points = if has_points { points as f64 * (1.0 - zone) } else { 0.0 };
        let shares = has_points || !job.membranes.is_empty();
        let nodes = figures::nodes(job) * COST_OF_NODE;
        let cost = COST_OF_GRAIN[job.grid.dimension - 2];
        let of_grain = cost + if shares { COST_OF_SHARING } else { 0.0 };
        let of_cycle = points * figures::cost_of_point(job) + if shares && zone > 0.0 { nodes } else { 0.0 };
        let each = zone * all * of_grain + of_cycle / job.grain_steps as f64;
        let is_held = !job.membranes.is_empty();
        let of_rest = cost + if is_held { COST_OF_SHARING + nodes / all } else { 0.0 };
        let is_made = match granular.method {
            Method::Dem => true,
            Method::Hybrid => granular.reference == Origin::Specimen,
            Method::Mpm => false,
        };
        Self {
            points,
            grains: zone * all,
            zone,
            piece: steps_of_piece(job, granular) * count(granular) * COST_IN_PIECE,
            specimen: if is_made { steps_of_specimen(job, granular) * all * of_rest } else { 0.0 },
            steps: figures::steps(job) as f64 * each,
            memory: figures::memory(job, points as u64) + BYTES_GRAIN * zone.max(f64::from(u8::from(is_made))) * all,
        }
    }

    /// Of all parts, s.
    pub fn seconds(&self) -> f64 {
        self.piece + self.specimen + self.steps
    }
}

/// Packing fractions of dense grains of nearly one size, in the plane and in space.
pub const FRACTION_OF_PACKING: [f64; 2] = [0.84, 0.62];

/// Packing fraction of the material, of a law that has none that of such grains.
pub fn fraction_of_packing(job: &Mpm) -> f64 {
    job.material.law.fraction().unwrap_or(FRACTION_OF_PACKING[job.grid.dimension - 2])
}

/// Grains, if the whole material were discrete.
pub fn grains_if_discrete(job: &Mpm, granular: &Granular) -> f64 {
    let points: u64 = figures::points_of_regions(job).iter().sum();
    let volume = points as f64 * job.point_volume();
    let mean = sizes(&granular.piece).map_or(0.0, |sizes| sizes.power_mean(job.grid.dimension));
    let grain = if job.grid.dimension == 2 { 0.25 * PI * mean * job.grid.depth } else { PI / 6.0 * mean };
    volume * fraction_of_packing(job) / grain
}

/// Share of the material that the zones of a hybrid take: of bands that are known by their length; of one that is to be found as if it
/// went through the least extent of the material under 45 degrees, on both sides of a body that is narrower.
fn zone_share(job: &Mpm, granular: &Granular) -> f64 {
    let boxes: Vec<_> = job.regions.iter().map(|region| figures::bounding_box(&region.shape)).collect();
    let extent = |axis: usize| {
        let lower = boxes.iter().map(|corners| corners.0[axis]).fold(f64::INFINITY, f64::min);
        boxes.iter().map(|corners| corners.1[axis]).fold(f64::NEG_INFINITY, f64::max) - lower
    };
    let points: u64 = figures::points_of_regions(job).iter().sum();
    let area = points as f64 * job.point_volume() / job.grid.depth;
    let length = match &granular.known {
        Some(KnownBands { parts, .. }) => {
            let of = |[from, to]: &[[f64; 2]; 2]| {
                let [x, y] = [to[0] - from[0], to[1] - from[1]];
                (x * x + y * y).sqrt()
            };
            parts.iter().map(of).sum::<f64>()
        }
        None => {
            let presses = |body: &super::RigidBody| {
                let moves = body.body.motion.path.iter().any(|at| at.velocity != [0.0; 3]);
                moves && matches!(body.body.shape, Shape::Box { .. } | Shape::Cylinder { .. })
            };
            let bands = if job.bodies.iter().any(presses) { 2.0 } else { 1.0 };
            bands * 2.0_f64.sqrt() * extent(0).min(extent(1))
        }
    };
    (length * 2.0 * granular.enrichment.distance / area).min(1.0)
}

fn packed(granular: &Granular) -> Option<&Packed> {
    match &granular.piece.source {
        Source::Packed(packed) => Some(packed),
        Source::File(_) => None,
    }
}

fn count(granular: &Granular) -> f64 {
    packed(granular).map_or(0.0, |packed| packed.count as f64)
}

/// Steps in one t_p under a stress, Pa.
fn steps_per_time(job: &Mpm, granular: &Granular, stress: f64) -> f64 {
    let matter = &granular.piece.matter;
    matter.diameter_mean * (matter.density / stress).sqrt() / job.step
}

/// Stresses that a piece comes to rest under, one after the other, Pa.
fn stresses(granular: &Granular) -> Vec<f64> {
    match packed(granular).map(|packed| &packed.preparation) {
        Some(Preparation::Compress { stress, unloaded, .. }) => std::iter::once(*stress).chain(*unloaded).collect(),
        _ => Vec::new(),
    }
}

fn steps_of_piece(job: &Mpm, granular: &Granular) -> f64 {
    stresses(granular).iter().map(|stress| TIME_OF_PIECE * steps_per_time(job, granular, *stress)).sum()
}

fn steps_of_specimen(job: &Mpm, granular: &Granular) -> f64 {
    let times = if job.bodies.iter().any(|body| body.seat > 0.0) { SEATINGS } else { 1.0 };
    let last = stresses(granular).last().map_or(0.0, |stress| steps_per_time(job, granular, *stress));
    times * TIME_OF_SPECIMEN * last
}
