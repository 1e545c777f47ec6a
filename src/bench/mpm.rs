//! How long a point-step takes: a periodic block of Drucker-Prager material under pressure, sheared by a wave of velocity so
//! that it yields, the whole step with its rebuilds and messages.

use std::time::Instant;

use scree_partition::Transport;

use super::dem::{phases, resident_bytes};
use crate::continuum::setup;
use crate::error::Error;
use crate::law::material::{CriticalDruckerPrager, MaterialLaw};
use crate::scenario::mpm::MaterialLaw as LawOfJob;
use crate::scenario::{Job, Mpm};
use crate::space::{Plane, Solid, Space};

/// What is measured.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub points: u64,
    /// In space instead of the plane.
    pub solid: bool,
    /// Shape functions, stress update and transfer, as a job names them.
    pub shape: String,
    pub update: String,
    pub transfer: String,
    /// Stretches of steps; the median of their times counts.
    pub stretches: usize,
    pub steps: u64,
}

/// What came out. Times are of the slowest rank where ranks differ.
#[derive(Clone, Debug)]
pub struct Measured {
    pub space: &'static str,
    pub instructions: &'static str,
    pub points: u64,
    pub ranks: usize,
    pub steps: u64,
    /// Wall time of a point's step, every stretch, ns.
    pub stretches: Vec<f64>,
    pub rebuilds: u64,
    pub bytes_resident_per_point: f64,
    /// Name, ns per point-step as the mean over ranks, and the slowest rank over that mean.
    pub phases: Vec<(&'static str, f64, f64)>,
    /// Most points on a rank over their mean.
    pub imbalance: f64,
    /// Mean plastic strain at the end: a yielding material, not an elastic one.
    pub plastic_strain: f64,
}

impl Measured {
    /// Median stretch, ns per point-step.
    pub fn nanoseconds(&self) -> f64 {
        let mut sorted = self.stretches.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

/// Points per cell and axis.
const PER_CELL: f64 = 2.0;
/// Whole blocks, so that every axis can be periodic.
const BLOCK: [u64; 2] = [8, 4];

/// Runs the measurement on all ranks.
pub fn measure(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    match wanted.solid {
        false => measured::<Plane>(wanted, transport),
        true => measured::<Solid>(wanted, transport),
    }
}

fn job<S: Space>(wanted: &Wanted) -> Result<Mpm, Error> {
    let dimension = S::DIMENSION as f64;
    let edge = match S::DIMENSION {
        2 => (wanted.points as f64).sqrt(),
        _ => crate::math::cbrt(wanted.points as f64),
    };
    let block = BLOCK[S::DIMENSION - 2];
    let cells = ((edge / PER_CELL / block as f64).round() as u64).max(2) * block;
    let all = |value: &str| format!("[{}]", vec![value; S::DIMENSION].join(", "));
    let length = format!("\"{cells} cm\"");
    let along = |first: &str, second: &str| {
        if dimension == 2.0 { format!("[{first}, {second}]") } else { format!("[{first}, {second}, 0]") }
    };
    let text = format!(
        r#"
        name = "bench"
        [grid]
        space = "{space}"
        lower = {zero}
        upper = {upper}
        cell = "1 cm"
        periodic = {periodic}
        [scheme]
        shape = "{shape}"
        update = "{update}"
        transfer = "{transfer}"
        points_per_cell = 2
        [material]
        law = "critical_drucker_prager"
        density = "2000 kg/m3"
        bulk_modulus = "20 MPa"
        shear_modulus = "10 MPa"
        friction_angle_critical = "25 deg"
        fraction = 0.84
        fraction_critical = 0.8
        dilation_factor = 3
        softening_rate = 3
        cohesion = "1 kPa"
        [[region]]
        shape = "box"
        lower = {zero}
        upper = {upper}
        wave = [{{direction = {y}, length = {length}, amplitude = {amplitude}}}]
        [stress]
        kind = "isotropic"
        pressure = "100 kPa"
        [time]
        end = "100 s"
        [decomposition]
        cells_per_block = {block}
        "#,
        space = S::NAME,
        zero = all("0"),
        upper = all(&length),
        periodic = all("true"),
        shape = wanted.shape,
        update = wanted.update,
        transfer = wanted.transfer,
        y = along("0", "1"),
        amplitude = along("\"5 m/s\"", "0"),
    );
    match Job::parse(&text, "bench", &[])? {
        Job::Mpm(job) => Ok(job),
        _ => unreachable!("the text has a [grid]"),
    }
}

fn measured<S: Space>(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error>
where
    CriticalDruckerPrager: MaterialLaw<S>,
{
    let resident = resident_bytes();
    let job = job::<S>(wanted)?;
    let LawOfJob::CriticalDruckerPrager(law) = &job.material.law else { unreachable!("the text names it") };
    let mut world = setup::world::<S, _>(&job, &CriticalDruckerPrager::of_job(law), transport)?;
    for _ in 0..wanted.steps.min(WARM_UP) {
        world.advance()?;
    }
    let rebuilds = world.rebuilds;
    world.phases.seconds = Default::default();
    let points = world.points_total;
    let mut stretches = Vec::with_capacity(wanted.stretches);
    for _ in 0..wanted.stretches {
        transport.barrier();
        let started = Instant::now();
        for _ in 0..wanted.steps {
            world.advance()?;
        }
        let mut seconds = [started.elapsed().as_secs_f64()];
        transport.max(&mut seconds);
        stretches.push(1e9 * seconds[0] / (wanted.steps * points) as f64);
    }
    let steps = wanted.steps * wanted.stretches as u64;
    let scale = 1e9 / (steps * points) as f64;
    let phases = phases(&world.phases.seconds, transport);
    let mut strain = scree_partition::ExactSum::<1>::new();
    for hot in &world.points.hot {
        strain.add(0, crate::law::material::MaterialMemory::plastic_strain(&hot.memory));
    }
    let strain = world.reduce(strain)?[0];
    let mut resident = [(resident_bytes() - resident).max(0)];
    transport.sum(&mut resident);
    let mut most = [world.points.len() as i64];
    transport.max_integer(&mut most);
    Ok(Measured {
        space: S::NAME,
        instructions: world.contacts.instructions().name(),
        points,
        ranks: transport.size(),
        steps,
        stretches,
        rebuilds: world.rebuilds - rebuilds,
        bytes_resident_per_point: resident[0] as f64 / points as f64,
        phases: phases.into_iter().map(|(name, mean, most)| (name, mean * scale, most)).collect(),
        imbalance: most[0] as f64 * transport.size() as f64 / points as f64,
        plastic_strain: strain / points as f64,
    })
}

/// Steps before the first stretch, so that the start is forgotten.
const WARM_UP: u64 = 50;
