//! The RVEs that a continuum of grains begins with: each point has the assembly of its packing at its stress.

use rand_chacha::rand_core::Rng;
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::space::{AXES, Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::domain::transfer;
use crate::job::assembly::Assembly;
use crate::job::mpm::figures::{bounds, pressures_at_start};
use crate::job::mpm::{Granular, InitialStress, Mpm, Rves};
use crate::job::stable::governing;
use crate::law::material::MaterialLaw;
use crate::law::material::{ConstitutiveLaw, GrainAssembly, GrainModuli};
use crate::mpm::points::Point;
use crate::mpm::stress::SharedMaterial;
use crate::prepare::grain_world;
use crate::prepare::insert::random_of;
use crate::rve::levels::{Path, levels};
use crate::rve::{GrainMaterial, Packing, Packings, Rve, RveRow, Scratch, Template};

/// How far the k0 of the job and that of its RVEs may be apart before it is worth a word.
const K0_OFF: f64 = 0.1;
/// How far their stress may be from a pressure, over it, before that is.
const UNEVEN: f64 = 0.02;
/// Which stream of random numbers says which packing a point begins from.
const STREAM_OF_PACKINGS: u64 = 1 << 63;

/// Assemblies of grains at every stress that points begin under.
pub struct Levels<S: Space> {
    /// Pa, ascending.
    pressures: Vec<f64>,
    /// Numbers of grains that regions have taken out of theirs, none first, and then ascending.
    removed: Vec<u64>,
    /// By packing and pressure: all packings whole, then again without as many grains as each of these says.
    rves: Vec<Vec<Rve<S>>>,
}

/// Numbers of grains that regions take out of their packings, none first.
fn removed_of(job: &Mpm) -> Vec<u64> {
    let mut removed: Vec<u64> = job.regions.iter().map(|region| region.grains_removed).chain([0]).collect();
    removed.sort_unstable();
    removed.dedup();
    removed
}

impl<S: Space> Levels<S> {
    /// Packings from the cache, or made now and cached, and the path of each through all stresses; the same on every rank. Collective.
    pub fn of(job: &Mpm, (granular, wanted): (&Granular, &Rves), transport: &dyn Transport) -> Result<Self, Error> {
        let (mut starts, removed) = (Vec::new(), removed_of(job));
        for taken in &removed {
            for number in 0..wanted.packings {
                // The state of a packing in the making is saved as often as that of the run.
                let piece =
                    Assembly { seed: granular.piece.seed + number, output: job.output, ..granular.piece.clone() };
                let start = match taken {
                    0 => grain_world::volume_element::<S>(&piece, transport)?,
                    taken => grain_world::weakened::<S>(&piece, *taken, transport)?,
                };
                starts.push(start.with_step(granular.step_of_rves()));
            }
        }
        // Mass and with it the overburden are those of the packing.
        let density = density_of(&starts[..wanted.packings as usize], granular);
        let job = Mpm { material: crate::job::mpm::Material { density, ..job.material }, ..job.clone() };
        let pressures = pressures_at_start(&job);
        let way = match job.stress {
            InitialStress::Geostatic { axis, k0, .. } if k0 < 1.0 => Path::Uniaxial { axis },
            _ => Path::Isotropic,
        };
        let path = |start: &Rve<S>| levels(start, way, &pressures, &wanted.drive_of_levels(), &mut Scratch::default());
        let rves = transfer::agree(transport, starts.iter().map(path).collect())?;
        let levels = Self { pressures, removed, rves };
        if transport.rank() == 0 {
            levels.tell_k0(&job);
            levels.tell_uneven(way);
        }
        Ok(levels)
    }

    /// What share of the stress along gravity RVEs bear across it, where that is theirs to say.
    fn tell_k0(&self, job: &Mpm) {
        let InitialStress::Geostatic { axis, k0, .. } = job.stress else { return };
        let across = usize::from(axis == 0);
        let scratch = &mut Scratch::default();
        let share = |rve: &Rve<S>, scratch: &mut Scratch<S>| {
            let stress = rve.observe(scratch).kirchhoff.tensor();
            stress[across * (S::DIMENSION + 1)] / stress[axis * (S::DIMENSION + 1)]
        };
        let shares: Vec<f64> = self.rves.iter().flatten().map(|rve| share(rve, scratch)).collect();
        let [least, most] = [f64::min, f64::max].map(|pick| shares.iter().copied().fold(shares[0], pick));
        match shares.iter().all(|share| (share - k0).abs() < K0_OFF) {
            true => tracing::info!("RVEs begin with a k0 of {least:.3} to {most:.3}"),
            false => tracing::warn!(
                "warning: RVEs begin with a k0 of {least:.3} to {most:.3}, and stress.k0 = {k0}: it is their grains that say it"
            ),
        }
    }

    /// Loose grains may rearrange for ever before they bear the same along all axes.
    fn tell_uneven(&self, way: Path) {
        if way != Path::Isotropic {
            return;
        }
        let scratch = &mut Scratch::default();
        let mut worst = 0.0_f64;
        for rve in self.rves.iter().flatten() {
            let stress = rve.observe(scratch).kirchhoff.tensor();
            let mean = S::trace(&stress) / S::DIMENSION as f64;
            let off = stress - S::identity() * mean;
            (0..S::Tensor::COMPONENTS).for_each(|at| worst = worst.max((off[at] / mean).abs()));
        }
        if worst > UNEVEN {
            tracing::warn!("warning: RVEs begin with stresses that differ from a pressure by {worst:.3} of it at most");
        }
    }

    /// Packings as they were made, by number, and again for each number of grains that is taken out.
    pub fn packings(&self) -> Packings {
        self.rves.iter().filter_map(|levels| levels.first()).map(|rve| rve.template().packing.clone()).collect()
    }

    /// Density of the material, kg/m3: the mean of its packings at the least stress.
    pub fn density(&self, granular: &Granular) -> f64 {
        let whole = self.rves.len() / self.removed.len();
        density_of(self.rves[..whole].iter().filter_map(|levels| levels.first()), granular)
    }

    /// The bound on the P-wave modulus that the stiffest of them has, Pa.
    pub fn modulus_most(&self) -> f64 {
        let scratch = &mut Scratch::default();
        self.rves.iter().flatten().map(|rve| rve.observe(scratch).modulus_most()).fold(0.0, f64::max)
    }

    /// Gives points the stress of their RVEs, and returns these.
    pub fn give(
        &self,
        job: &Mpm,
        (granular, wanted): (&Granular, &Rves),
        law: &SharedMaterial<S>,
        points: &mut [Point<S>],
    ) -> Vec<RveRow<S>> {
        let scratch = &mut Scratch::default();
        let observed: Vec<Vec<_>> =
            self.rves.iter().map(|levels| levels.iter().map(|rve| rve.observe(scratch)).collect()).collect();
        let row = |point: &mut Point<S>| {
            let packing = packing_of(granular.piece.seed, point.cold.id.0, wanted.packings)
                + wanted.packings * self.weakness_of(job, point);
            let level = self.level_of(job, point);
            let rve = &self.rves[packing as usize][level];
            let stress = observed[packing as usize][level].kirchhoff;
            let fraction = 1.0 / (1.0 + rve.void_ratio());
            point.hot.memory = law.start(&stress.tensor(), fraction);
            point.hot.stress = stress;
            let pairs = rve.sample().assembly.contacts.neighbours.pairs.len() as u64;
            let cost = pairs * wanted.drive.steps_min;
            RveRow { point: point.cold.id, packing, cost, increment: S::Tensor::zero(), resting: rve.rest() }
        };
        points.iter_mut().map(row).collect()
    }

    /// Which of the numbers of grains that are taken out is that of the region of a point.
    fn weakness_of(&self, job: &Mpm, point: &Point<S>) -> u64 {
        let region = job.region_of(job.index(point.cold.id.0)).map_or(0, |region| job.regions[region].grains_removed);
        self.removed.iter().position(|removed| *removed == region).unwrap_or_default() as u64
    }

    fn level_of(&self, job: &Mpm, point: &Point<S>) -> usize {
        match job.stress {
            InitialStress::Geostatic { axis, .. } => {
                let pressure = job.overburden(point.cold.origin[axis]);
                let next = self.pressures.partition_point(|level| *level < pressure);
                let nearer = |level: &usize| (self.pressures[*level] - pressure).abs();
                let around = next.saturating_sub(1)..(next + 1).min(self.pressures.len());
                around.min_by(|a, b| nearer(a).total_cmp(&nearer(b))).unwrap_or_default()
            }
            InitialStress::None | InitialStress::Isotropic { .. } => 0,
        }
    }
}

fn density_of<'r, S: Space>(rves: impl IntoIterator<Item = &'r Rve<S>>, granular: &Granular) -> f64 {
    let fractions: Vec<f64> = rves.into_iter().map(|rve| 1.0 / (1.0 + rve.void_ratio())).collect();
    granular.piece.matter.density * fractions.iter().sum::<f64>() / fractions.len() as f64
}

/// The packing that a point begins from.
fn packing_of(seed: u64, id: u64, packings: u64) -> u64 {
    if packings == 1 { 0 } else { random_of(seed, STREAM_OF_PACKINGS | id).next_u64() % packings }
}

/// What a world of such points needs, of packings as they were made.
pub fn material<S: Space>((granular, wanted): (&Granular, &Rves), packings: &Packings) -> GrainMaterial<S> {
    let mut constants = grain_world::constants::<S>(&granular.piece);
    constants.dt = granular.step_of_rves();
    let depth = grain_world::depth_of::<S>(&granular.piece);
    let template = |packing: &Packing| Template::new(packing.clone(), constants.clone(), depth);
    GrainMaterial { drive: wanted.drive, frame: wanted.frame, templates: packings.iter().map(template).collect() }
}

/// The stable step of the continuum of a job where the P-wave modulus of its grains is this (Pa), s; without end of one without grains.
pub fn stable_step<S: Space>(job: &Mpm, modulus: f64) -> f64 {
    let ConstitutiveLaw::Grains(moduli) = job.material.law else { return f64::INFINITY };
    let share = modulus / MaterialLaw::<S>::p_wave_modulus(&GrainAssembly(moduli));
    let [bulk_modulus, shear_modulus] = [moduli.bulk_modulus * share, moduli.shear_modulus * share];
    let mut job = job.clone();
    job.material.law = ConstitutiveLaw::Grains(GrainModuli { bulk_modulus, shear_modulus });
    governing(&bounds(&job)).step
}

/// Refuses a step of the continuum that is not stable with grains as stiff as they are, which only packings tell.
pub fn refuse_stiff<S: Space>(job: &Mpm, modulus: f64) -> Result<(), Error> {
    let bound = stable_step::<S>(job, modulus);
    match job.step <= bound {
        true => Ok(()),
        false => Err(Error::User(format!(
            "time.step = {:.4e} s is too long for these grains: their contacts are as stiff as a P-wave modulus of {:.4e} Pa if all move with the mean field, which bounds the step by {bound:.4e} s along {}. Write time.step = {:.3e}, or larger cells.",
            job.step,
            modulus,
            AXES[..S::DIMENSION].join(", "),
            0.5 * bound
        ))),
    }
}
