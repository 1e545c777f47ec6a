//! What a job will take, part by part, before anything of it is done: its rows times what each of them costs.

use super::{KnownBands, Mpm, Origin, figures};
use crate::job::assembly::{Assembly, Shape};
use crate::job::figures::{grain_measure, grains, sizes, stresses_of_packing};
use crate::job::{Job, Method, derived};
use crate::rve::Pace;

// Chosen on `jobs/triaxial.toml`, one core (docs/validation/forecasts.md); in space by `scree bench dem --space solid`.
// What is measured takes the place of a grain's and a point's cost, and what else grains cost keeps its share of a grain's.

/// Wall time of a grain and step, s: in a periodic cell that is compressed, among grains and bodies alone, and what it
/// takes more to share nodes with points or membranes. In space a cell takes twice what grains alone take, as in the
/// plane (`jobs/fem_dem/simple_shear.toml`).
const COST_IN_PIECE: [f64; 2] = [80e-9, 240e-9];
const COST_OF_GRAIN: [f64; 2] = [40e-9, 120e-9];
const COST_OF_SHARING: f64 = 60e-9;
/// Of a node and step of a grid that grains share, s.
const COST_OF_NODE: f64 = 130e-9;
/// Cost of one point over one step on one core, s, in the plane and in space.
const COST_OF_POINT: [f64; 2] = [50e-9, 140e-9];
/// Time that a piece takes to equilibrate under a stress, and a specimen that is cut of it, in t_p = d sqrt(rho/p).
const TIME_OF_PIECE: f64 = 120.0;
const TIME_OF_SPECIMEN: f64 = 80.0;
/// How often a specimen with bodies that are seated equilibrates, about.
const SEATINGS: f64 = 3.0;

/// Bytes that one grain takes with its contacts, neighbour list and ghosts.
const BYTES_OF_GRAIN: f64 = 1000.0;
/// Bytes that the program and its libraries take before there is any material.
const BYTES_OF_PROGRAM: f64 = 40e6;

/// What rows, nodes and outputs of a job cost, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCosts {
    /// Of a grain and step, and of one in a cell that is compressed.
    pub grain: f64,
    piece: f64,
    /// What it takes a grain more to share nodes, and what such a node takes.
    sharing: f64,
    node: f64,
    /// Of a point and step of the continuum.
    pub point: f64,
    /// None where nothing was measured.
    pub outputs: Option<Outputs>,
}

/// What a row of the series, a frame and a checkpoint take, s, of a world of so many grains and points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Grains and points of that world.
    pub rows: f64,
    /// s.
    pub row: f64,
    /// s.
    pub frame: f64,
    /// s.
    pub checkpoint: f64,
}

impl UnitCosts {
    /// Those of the machine that the constants were chosen on.
    pub fn assumed(job: &Job) -> Self {
        let space = job.dimension() - 2;
        Self {
            grain: COST_OF_GRAIN[space],
            piece: COST_IN_PIECE[space],
            sharing: COST_OF_SHARING,
            node: COST_OF_NODE,
            point: COST_OF_POINT[space],
            outputs: None,
        }
    }

    /// All that has to do with grains in the measure of what one of them was found to cost.
    pub fn scale_grains(&mut self, grain: f64) {
        let share = grain / self.grain;
        for cost in [&mut self.grain, &mut self.piece, &mut self.sharing, &mut self.node] {
            *cost *= share;
        }
    }

    /// Of all outputs of a run of so many rows whose steps take so long, s.
    fn of_outputs(&self, job: &Job, rows: f64, steps: f64) -> f64 {
        let Some(costs) = self.outputs else { return 0.0 };
        let (output, end) = (job.output(), job.end());
        let times = |interval: f64| (end / interval).floor();
        // At the start and at the end one of each, by simulated time, by steps and by the clock.
        let by_steps = job.steps().checked_div(output.checkpoint_steps).unwrap_or(0) as f64;
        let by_clock = (steps / output.checkpoint_wall_interval).floor();
        let checkpoints = 2.0 + times(output.checkpoint_interval) + by_steps + by_clock;
        let frames = 1.0 + times(output.frame_interval);
        let each = times(output.series_interval) * costs.row + frames * costs.frame + checkpoints * costs.checkpoint;
        each * (rows / costs.rows.max(1.0)).max(1.0)
    }
}

/// A job's rows at its costliest time and what it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Points or elements that grains do not stand for.
    pub points: f64,
    /// Those of the zone, or of all of the material; those of RVEs do not count.
    pub grains: f64,
    /// Share of the material that grains take the place of.
    pub zone: f64,
    /// Of compressing a packing in a cell and of equilibrating the specimen, where neither is in the cache yet, s.
    pub piece: f64,
    /// s.
    pub specimen: f64,
    /// Of a grain and of a point in a step of each, s; zero where there are none.
    pub cost_of_grain: f64,
    /// s.
    pub cost_of_point: f64,
    /// Of the steps, s; a hybrid is taken as enriched from the start.
    pub steps: f64,
    /// Of rows, frames and checkpoints, s; zero where they were not measured.
    pub outputs: f64,
    /// How much longer the steps of grains alone would take (Chen et al. 2021, 6.4.1).
    pub speed_up: f64,
    /// Of all ranks together, bytes.
    pub memory: f64,
}

impl Forecast {
    /// None of grains in a file that cannot be counted.
    pub fn of(job: &Job, costs: &UnitCosts) -> Option<Self> {
        let (method, assembly, on_grid) = (job.method(), job.grains(), job.continuum());
        let continuum = on_grid.as_deref();
        let all = match continuum {
            Some(continuum) => grains_if_discrete(continuum),
            None => grains(assembly.as_deref()?)? as f64,
        };
        let zone = match (method, continuum) {
            (Method::Hybrid, Some(continuum)) => zone_share(job, continuum),
            (Method::Dem, _) => 1.0,
            _ => 0.0,
        };
        let points =
            continuum.filter(|_| method.has_points()).map_or(0.0, |on| figures::points(on) as f64 * (1.0 - zone));
        let cycle = continuum.map_or(1.0, |on| on.grain_steps as f64);
        let is_held = continuum.is_some_and(|on| !on.membranes.is_empty());
        let of_nodes = continuum.map_or(0.0, |on| figures::nodes(on) * costs.node);
        let of_points = points * costs.point / cycle;
        let exchange =
            continuum.and_then(|on| on.grains.as_ref()).map_or(1.0, |grains| grains.coupling.interval as f64);
        let sharing = costs.sharing / exchange;
        let alone =
            |cycle: f64, sharing: f64| all * costs.grain + if is_held { all * sharing + of_nodes / cycle } else { 0.0 };
        let each = match method {
            Method::Dem => alone(cycle, sharing),
            Method::Mpm | Method::Fem => of_points,
            Method::MpmDem | Method::FemDem => {
                of_points + continuum.map_or(0.0, |on| points * grains_of_rve(on) * costs.grain)
            }
            Method::Hybrid => {
                let shared = if is_held { 1.0 } else { continuum.map_or(0.0, share_of_rim) };
                zone * (all * (costs.grain + shared * sharing) + of_nodes / cycle) + of_points
            }
        };
        let held = share_held(job, method);
        let piece = assembly.as_deref().map_or(0.0, |assembly| costs.piece * steps_of_piece(job, assembly));
        let specimen = job.as_mpm().map_or(0.0, |on| held * steps_of_specimen(on) * alone(1.0, costs.sharing));
        let steps = job.steps() as f64 * each;
        Some(Self {
            points,
            grains: zone * all,
            zone,
            piece,
            specimen,
            cost_of_grain: if zone > 0.0 || method.has_rves() { costs.grain } else { 0.0 },
            cost_of_point: if points > 0.0 { costs.point } else { 0.0 },
            steps,
            outputs: costs.of_outputs(job, zone * all + points, steps),
            speed_up: alone(cycle, sharing) / each,
            memory: memory(continuum, points, held.max(zone) * all),
        })
    }
}

/// Grains of an RVE times their steps in an increment, at least.
fn grains_of_rve(on: &Mpm) -> f64 {
    let Some((granular, rves)) = on.rves() else { return 0.0 };
    let steps = match rves.drive.pace {
        Pace::QuasiStatic { .. } => rves.drive.steps_min as f64,
        Pace::Synchronous => (on.step / granular.step_of_rves()).ceil().max(rves.drive.steps_min as f64),
    };
    grains(&granular.piece).unwrap_or_default() as f64 * steps
}

/// Bytes that so many points and grains take on all ranks together.
pub fn memory(continuum: Option<&Mpm>, points: f64, grains: f64) -> f64 {
    BYTES_OF_PROGRAM + BYTES_OF_GRAIN * grains + continuum.map_or(0.0, |on| figures::memory(on, points as u64))
}

/// Share of the grains of all of the material that are there, moving or not.
fn share_held(job: &Job, method: Method) -> f64 {
    if let Some(scenario) = job.as_shear() {
        return derived::share_of_grains(scenario);
    }
    let reference = job.as_mpm().and_then(|on| on.grains.as_ref()).map(|granular| granular.reference);
    let is_made = method == Method::Dem || (method == Method::Hybrid && reference == Some(Origin::Specimen));
    f64::from(u8::from(is_made))
}

/// Share of a zone's grains that lie in its rim, a cell at either side.
fn share_of_rim(on: &Mpm) -> f64 {
    on.grains.as_ref().map_or(0.0, |granular| (on.grid.cell / granular.enrichment.distance).min(1.0))
}

/// Solid volume fractions of dense grains of nearly one size, in the plane and in space.
pub const FRACTION_OF_PACKING: [f64; 2] = [0.84, 0.62];

/// Solid volume fraction of the material, of a law that has none that of such grains.
pub fn fraction_of_packing(job: &Mpm) -> f64 {
    job.material.law.fraction().unwrap_or(FRACTION_OF_PACKING[job.grid.dimension - 2])
}

/// Grains, if all of the material were discrete.
pub fn grains_if_discrete(job: &Mpm) -> f64 {
    let Some(sizes) = job.grains.as_ref().and_then(|granular| sizes(&granular.piece)) else { return 0.0 };
    let depth = if job.grid.dimension == 2 { job.grid.depth } else { 1.0 };
    let volume = figures::points(job) as f64 * job.point_volume();
    volume * fraction_of_packing(job) / (grain_measure(sizes, job.grid.dimension) * depth)
}

/// Share of the material that the zones of a hybrid take: between plates around a flat band; of bands that are known by their length; of
/// one that is to be found as if it went through the least extent of the material under 45 degrees, on both sides of a body that is
/// narrower.
fn zone_share(of: &Job, job: &Mpm) -> f64 {
    let Some(granular) = &job.grains else { return 0.0 };
    if of.plates().is_some() {
        return figures::zone_height(job, granular) / job.grid.extent(1);
    }
    let boxes: Vec<_> = job.regions.iter().map(|region| figures::bounding_box(&region.shape)).collect();
    let extent = |axis: usize| {
        let lower = boxes.iter().map(|corners| corners.0[axis]).fold(f64::INFINITY, f64::min);
        boxes.iter().map(|corners| corners.1[axis]).fold(f64::NEG_INFINITY, f64::max) - lower
    };
    let area = figures::points(job) as f64 * job.point_volume() / job.grid.depth;
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

/// Steps in which a grain crosses its own size under a stress, Pa.
fn steps_per_time(grains: &Assembly, step: f64, stress: f64) -> f64 {
    grains.matter.diameter_mean * (grains.matter.density / stress).sqrt() / step
}

/// Steps of single grains in which those of a cell are compressed; none of those that are poured, lie in a file or are compressed by
/// plates.
fn steps_of_piece(job: &Job, assembly: &Assembly) -> f64 {
    let stresses = stresses_of_packing(assembly);
    if job.plates().is_some() || stresses.is_empty() {
        return 0.0;
    }
    let piece = assembly.of_one_copy();
    // The step of a job whose points have grains of their own is that of the continuum.
    let has_own_step = assembly.cell.copies.is_some() || job.method().has_rves();
    let step = if has_own_step { piece.step } else { job.step() };
    let times = |stress: &f64| TIME_OF_PIECE * steps_per_time(&piece, step, *stress);
    let count = grains(&piece).unwrap_or_default() as f64;
    stresses.iter().map(times).sum::<f64>() * count
}

/// Steps in which a specimen equilibrates that is cut of its packing.
fn steps_of_specimen(job: &Mpm) -> f64 {
    let Some(granular) = &job.grains else { return 0.0 };
    let times = if job.bodies.iter().any(|body| body.seat > 0.0) { SEATINGS } else { 1.0 };
    let stresses = stresses_of_packing(&granular.piece);
    times * TIME_OF_SPECIMEN * stresses.last().map_or(0.0, |stress| steps_per_time(&granular.piece, job.step, *stress))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The packing of RVEs is made in steps of its grains, however long those of the continuum are.
    #[test]
    fn packings_of_rves_take_steps_of_their_own() {
        let text = include_str!("../../../jobs/fem_dem/element_biaxial.toml");
        let packing = |safety: &str| {
            let job = Job::parse(text, "element_biaxial.toml", &[format!("time.safety={safety}")]).unwrap();
            let piece = &job.as_mpm().unwrap().grains.as_ref().unwrap().piece;
            assert!(job.step() > 20.0 * piece.step);
            Forecast::of(&job, &UnitCosts::assumed(&job)).unwrap().piece
        };
        // 400 spheres of 0.8 mm under 416 kPa, t_p 62 us, steps of 39 ns.
        assert_eq!(packing("0.5"), packing("0.25"));
        assert!((2.0..120.0).contains(&packing("0.5")), "{}", packing("0.5"));
    }
}
