//! What a grain, a point and an output of a job cost on this machine, measured on a small world of the job's own law,
//! space, scheme and step for as long as a person waits without noticing. Nothing but forecasts depends on it.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use scree_partition::Solo;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::dem::grains::{GrainRow, Mover};
use crate::dem::walls;
use crate::job::assembly::{Assembly, Packed, Preparation, Read, Source};
use crate::job::mpm::forecast::{Outputs, UnitCosts};
use crate::job::mpm::{self, Mpm};
use crate::job::{Job, figures};
use crate::law::material::{ConstitutiveLaw, Elastic, GrainModuli};
use crate::prepare::grain_world;
use crate::run::assembly::InSpace;
use crate::run::experiment::Setup;
use crate::run::folder::{Folder, Scratch};
use crate::run::grid::Points;
use crate::run::trial::{Trial, trial};
use crate::store::checkpoint::Progress;

/// Wall time of the steps of each small world.
const TIME: Duration = Duration::from_millis(150);
/// The most grains and points of one; larger jobs have costs per row like these.
const GRAINS_MAX: u64 = 4000;
const POINTS_MAX: f64 = 20_000.0;
/// The most nodes, and the most blocks of a cell of grains: a vast domain takes memory whatever is in it.
const NODES_MAX: f64 = 1e6;
const BLOCKS_MAX: f64 = 1e5;
/// Places that are looked at for each grain that is poured.
const PLACES_PER_GRAIN: usize = 100;
/// Grains along an axis at least, so that none meets itself in the next period.
const ALONG_MIN: usize = 6;
/// Overlap of neighbours in a grid of grains, in diameters: they touch, and bear a little.
const OVERLAP: f64 = 1e-4;
/// The same where nothing holds them together but their weight.
const OVERLAP_POURED: f64 = 1e-6;

/// Measures what the job's steps and outputs cost here, with the threads of this process.
pub fn costs(job: &Job) -> Result<UnitCosts, Error> {
    let scratch = Scratch(folder_near(&Path::new("runs").join(job.name())));
    // Between plates, without which points of a continuum under pressure would fly apart.
    let lowered = job.as_shear().map(|shear| Cow::Owned(shear.lowered()));
    let (grains, continuum) = (job.grains(), lowered.or_else(|| job.continuum()));
    let mut costs = UnitCosts::assumed(job);
    let mut outputs = Outputs::default();
    if let Some(assembly) = grains.filter(|_| job.moves_grains()) {
        let tried = trial_of_grains(job, &assembly, &scratch.0.join("grains"))?;
        costs.scale_grains(tried.pass / tried.grains.max(1) as f64);
        outputs = outputs_of(&tried);
    }
    if let Some(continuum) = continuum.filter(|_| job.method().has_points()) {
        let tried = trial_of_points(&continuum, &scratch.0.join("points"))?;
        costs.point = tried.pass / tried.points.max(1) as f64;
        let of_points = outputs_of(&tried);
        // A hybrid has one file of all rows.
        outputs = if of_points.rows > outputs.rows { of_points } else { outputs };
    }
    costs.outputs = Some(outputs);
    Ok(costs)
}

fn outputs_of(tried: &Trial) -> Outputs {
    let Trial { row, frame, checkpoint, grains, points, .. } = *tried;
    Outputs { rows: (grains + points) as f64, row, frame, checkpoint }
}

/// A name for a folder on the file system that a run in `wanted` would write to: among temporary files where these are on
/// it as well.
fn folder_near(wanted: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = format!("scree-check-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let elsewhere = std::env::temp_dir().join(&name);
    let there = wanted.ancestors().skip(1).find(|folder| folder.is_dir()).unwrap_or(Path::new("."));
    let is_same = device_of(there).is_some_and(|device| device_of(&std::env::temp_dir()) == Some(device));
    if is_same || !is_writable(there) { elsewhere } else { there.join(format!(".{name}")) }
}

/// The number of a folder's file system, where the system tells.
fn device_of(folder: &Path) -> Option<u64> {
    use std::os::unix::fs::MetadataExt;
    folder.metadata().ok().map(|about| about.dev())
}

fn is_writable(folder: &Path) -> bool {
    folder.metadata().is_ok_and(|about| !about.permissions().readonly())
}

fn trial_of_grains(job: &Job, assembly: &Assembly, folder: &Path) -> Result<Trial, Error> {
    match assembly.cell.dimension {
        2 => grains_in::<Plane>(job, assembly, folder),
        _ => grains_in::<Solid>(job, assembly, folder),
    }
}

/// Grains of a small file are those of the job. All others stand in for a packing that is not made yet: they lie in a
/// grid, each in touch with as many as a grain of a frictional packing is; those that are poured on the job's bodies,
/// those that are compressed in a cell which they fill.
fn grains_in<S: Space>(job: &Job, assembly: &Assembly, folder: &Path) -> Result<Trial, Error> {
    let count = figures::grains(assembly).unwrap_or(u64::MAX);
    let blocks = figures::cell_measure(assembly) / (0..S::DIMENSION).map(|_| assembly.block).product::<f64>();
    let is_whole = job.continuum().is_none() && count <= GRAINS_MAX && blocks <= BLOCKS_MAX;
    let mut small = assembly.clone();
    let grains = match &assembly.source {
        Source::File(_) if is_whole => {
            let setup = InSpace::<S>::new(assembly);
            let (world, progress) = setup.begin(&mut None, &Solo)?;
            return trial(setup.experiment(), world, progress, Folder::claim(folder)?, TIME);
        }
        Source::Packed(Packed { preparation: Preparation::Pour, .. }) if is_whole => poured::<S>(assembly, count),
        _ => {
            let count = count.min(GRAINS_MAX) as f64;
            let root = if S::DIMENSION == 2 { count.sqrt() } else { crate::base::math::cbrt(count) };
            let along = (root.round() as usize).max(ALONG_MIN);
            filling::<S>(&mut small, along)
        }
    };
    if job.continuum().is_some() {
        // The cell is that of the packing alone.
        (small.cell.gradient, small.cell.servo) = ([[0.0; 3]; 3], None);
        small.output = *job.output();
    }
    small.ledger = job.keeps_account();
    small.source = Source::File(Read { grains: PathBuf::new(), contacts: None });
    let setup = InSpace::<S>::new(&small);
    let cell = grain_world::cell_of::<S>(&small);
    let grains = grains.into_iter().enumerate().map(|(number, place)| {
        let radius = 0.5 * small.matter.diameter_mean;
        let mass = small.matter.density * S::grain_volume(radius, small.cell.depth);
        GrainRow::resting(GrainId(number as u64), place, radius, mass, Mover::Free)
    });
    let world = grain_world::world_of::<S>(&small, grains.collect(), cell, &Solo)?;
    trial(setup.experiment(), world, Progress::default(), Folder::claim(folder)?, TIME)
}

/// Places of a grid of so many along each axis that fills a periodic cell, which the job is given. Nothing bears them, so
/// nothing pulls at them.
fn filling<S: Space>(job: &mut Assembly, along: usize) -> Vec<S::Vector> {
    let spacing = job.matter.diameter_mean * (1.0 - OVERLAP);
    for axis in 0..S::DIMENSION {
        job.cell.lower[axis] = 0.0;
        job.cell.upper[axis] = along as f64 * spacing;
        job.cell.periodic[axis] = true;
    }
    (job.gravity, job.bodies, job.cell.copies) = ([0.0; 3], Vec::new(), None);
    (0..along.pow(S::DIMENSION as u32)).map(|number| place::<S>(job, spacing, [along; 3], number)).collect()
}

/// The lowest places of a grid in the job's cell that its bodies leave.
fn poured<S: Space>(job: &Assembly, count: u64) -> Vec<S::Vector> {
    let spacing = job.matter.diameter_mean * (1.0 - OVERLAP_POURED);
    let along = std::array::from_fn(|axis| ((job.cell.upper[axis] - job.cell.lower[axis]) / spacing).floor() as usize);
    let (cell, bodies) = (grain_world::cell_of::<S>(job), grain_world::drawn::<S>(job).bodies);
    let is_open = |place: &S::Vector| {
        let nearest = |body| walls::nearest::<S>(body, &cell, place);
        bodies.iter().filter_map(nearest).all(|nearest| nearest.distance >= 0.5 * spacing * (1.0 - OVERLAP_POURED))
    };
    let all = along[..S::DIMENSION].iter().product();
    let places = (0..all).take(PLACES_PER_GRAIN * count as usize).map(|number| place::<S>(job, spacing, along, number));
    places.filter(is_open).take(count as usize).collect()
}

/// A place of a grid from the cell's lower corner on, that of the last axis slowest.
fn place<S: Space>(job: &Assembly, spacing: f64, along: [usize; 3], mut number: usize) -> S::Vector {
    let mut place = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        place[axis] = job.cell.lower[axis] + (0.5 + (number % along[axis]) as f64) * spacing;
        number /= along[axis];
    }
    place
}

/// The job's own points, or as many of larger cells as are measured soon enough.
fn trial_of_points(continuum: &Mpm, folder: &Path) -> Result<Trial, Error> {
    let mut small = continuum.clone();
    small.grains = None;
    if let ConstitutiveLaw::Grains(GrainModuli { bulk_modulus, shear_modulus }) = small.material.law {
        // No packing is made for it: points stand in that are as stiff. In the plane K is that of the plane.
        let bulk_modulus = if small.grid.dimension == 2 { bulk_modulus - shear_modulus / 3.0 } else { bulk_modulus };
        small.material.law = ConstitutiveLaw::Hencky(Elastic { bulk_modulus, shear_modulus });
    }
    (small.step, small.grain_steps) = (continuum.step_of_continuum(), 1);
    let points = mpm::figures::points(continuum) as f64;
    let share = (points / POINTS_MAX).max(mpm::figures::nodes(continuum) / NODES_MAX);
    if share > 1.0 {
        let times = if small.grid.dimension == 2 { share.sqrt() } else { crate::base::math::cbrt(share) }.ceil();
        let grid = &mut small.grid;
        grid.cell *= times;
        for axis in 0..grid.dimension {
            let cells = grid.cells[axis].div_ceil(times as usize);
            grid.cells[axis] = if grid.periodic[axis] { cells.next_multiple_of(small.cells_per_block) } else { cells };
            grid.upper[axis] = grid.lower[axis] + grid.cell * grid.cells[axis] as f64;
        }
    }
    match small.grid.dimension {
        2 => points_in(&Points::<Plane>::new(&small), folder),
        _ => points_in(&Points::<Solid>::new(&small), folder),
    }
}

fn points_in<S: Space>(setup: &Points<'_, S>, folder: &Path) -> Result<Trial, Error> {
    let (world, progress) = setup.begin(&mut None, &Solo)?;
    trial(setup.experiment(), world, progress, Folder::claim(folder)?, TIME)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A job of each kind is measured, and one whose points are more than a small world has.
    #[test]
    fn jobs_of_every_kind_are_measured() {
        let jobs = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs");
        for name in
            ["quickstart", "triaxial", "element/pour", "element/uniaxial", "element/two_discs", "bench/mpm_200k"]
        {
            let job = Job::load(&jobs.join(format!("{name}.toml")), &[]).unwrap_or_else(|error| panic!("{error}"));
            let costs = costs(&job).unwrap_or_else(|error| panic!("{name}: {error}"));
            let outputs = costs.outputs.expect("outputs are measured");
            let measured = [costs.grain, costs.point, outputs.rows, outputs.frame, outputs.checkpoint];
            assert!(measured.iter().all(|cost| *cost > 0.0), "{name}: {costs:?}");
            assert!(outputs.rows < 2.0 * POINTS_MAX, "{name}: {costs:?}");
        }
    }
}
