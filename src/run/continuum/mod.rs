//! A continuum of material points on a grid (`[grid]` in a job).

use scree_io::column::State;
use scree_io::frames::Frame;
use scree_partition::{ExactSum, Transport};
use serde_json::{Value, json};

use crate::adapt::watch;
use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Linear, Space};
use crate::dem::law::law_or_absent;
use crate::domain::grid::{self, REACTIONS};
use crate::domain::transfer;
use crate::job::mpm::{self, Mpm};
use crate::job::{Job, Output};
use crate::law::material::{Counted, CountedMemory, CriticalDruckerPrager, Hencky, LinearElastic, MaterialLaw};
use crate::observe::frame::frame;
use crate::observe::point::{OBSERVED, observed};
use crate::prepare::point_world::{self, PointWorld};
use crate::run::folder::Folder;
use crate::run::{self, Core, Experiment, Options, Outcome};
use crate::store::checkpoint::{self, Progress, Snapshot};

pub mod columns;

use columns::FACES;

use crate::base::space::AXES;

type PointCore<'t, S, L> = Core<'t, S, Counted<L>>;
type PointSnapshot<S, L> = Snapshot<S, CountedMemory<<L as MaterialLaw<S>>::Memory>>;

/// The job, with its space and material law.
pub struct Continuum<'s, S: Space, L> {
    job: &'s Mpm,
    /// Points followed through time.
    followed: Vec<PointId>,
    kinds: std::marker::PhantomData<(S, L)>,
}

/// Work that does not care which law it is done with.
trait ForAnyMaterial<S: Space> {
    fn with<L: MaterialLaw<S>>(self, law: L) -> Result<Outcome, Error>;
}

/// Does the work with the law that a job names: the one place where laws are told apart.
fn with_material_of<S: Space>(law: &mpm::MaterialLaw, work: impl ForAnyMaterial<S>) -> Result<Outcome, Error> {
    match law {
        mpm::MaterialLaw::LinearElastic(law) => {
            let bulk_modulus = law.bulk_modulus_in(S::DIMENSION);
            work.with(LinearElastic { bulk_modulus, shear_modulus: law.shear_modulus })
        }
        mpm::MaterialLaw::Hencky(law) => {
            let bulk_modulus = law.bulk_modulus_in(S::DIMENSION);
            work.with(Hencky { bulk_modulus, shear_modulus: law.shear_modulus })
        }
        mpm::MaterialLaw::CriticalDruckerPrager(law) => work.with(CriticalDruckerPrager::of(law)),
    }
}

struct Start<'a> {
    job: &'a Mpm,
    options: &'a Options,
    folder: &'a mut Option<Folder>,
    transport: &'a dyn Transport,
}

/// Runs a job from its start.
pub fn start<S: Space>(
    job: &Mpm,
    options: &Options,
    folder: &mut Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    with_material_of::<S>(&job.material.law, Start { job, options, folder, transport })
}

impl<S: Space> ForAnyMaterial<S> for Start<'_> {
    fn with<L: MaterialLaw<S>>(self, law: L) -> Result<Outcome, Error> {
        let Self { job, options, folder, transport } = self;
        let mut world = point_world::world::<S, L>(job, &law, transport)?;
        if job.ledger {
            world.point_ledger.open();
        }
        run::begin(Continuum::new(job), world, Progress::default(), options, folder)
    }
}

struct Resume<'a> {
    job: &'a Mpm,
    /// On rank 0.
    state: Option<State>,
    options: &'a Options,
    folder: Option<Folder>,
    transport: &'a dyn Transport,
}

/// Continues a run from a state that rank 0 holds.
pub fn resume<S: Space>(
    job: &Mpm,
    state: Option<State>,
    options: &Options,
    folder: Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    with_material_of::<S>(&job.material.law, Resume { job, state, options, folder, transport })
}

impl<S: Space> ForAnyMaterial<S> for Resume<'_> {
    fn with<L: MaterialLaw<S>>(self, law: L) -> Result<Outcome, Error> {
        let Self { job, state, options, folder, transport } = self;
        let read = |state| Snapshot::from_state(state, law_or_absent::<S>(&None).memory_words());
        let snapshot: Option<PointSnapshot<S, L>> = transfer::agree(transport, state.map(read).transpose())?;
        let draw = |_: &Progress, vertices| point_world::drawn(job, vertices);
        let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
        let mut world = point_world::world_at::<S, L>(job, &law, transport, progress.step, parts)?;
        world.resume_reactions(&progress.reactions)?;
        if job.ledger {
            world.resume_point_ledger(&progress.ledger)?;
        }
        run::go_on_with(Continuum::<S, L>::new(job), world, progress, options, folder)
    }
}

/// Columns of the account of energy, J.
const LEDGER: [&str; 6] =
    ["work_loads", "work_bodies", "work_ramp", "dissipated_holds", "energy_lost", "energy_lost_transfer"];

impl<'s, S: Space, L: MaterialLaw<S>> Continuum<'s, S, L> {
    fn new(job: &'s Mpm) -> Self {
        Self {
            job,
            followed: job.follow.iter().map(|follow| nearest(job, &follow.place)).collect(),
            kinds: std::marker::PhantomData,
        }
    }

    /// Faces that hold what they are reached by.
    fn holding_faces(&self) -> impl Iterator<Item = (usize, usize)> {
        let job = self.job;
        (0..S::DIMENSION).flat_map(|axis| [0, 1].map(|upper| (axis, upper))).filter(move |(axis, upper)| {
            !matches!(job.boundaries[*axis][*upper], mpm::Boundary::Periodic | mpm::Boundary::Free)
        })
    }

    /// Exact sums over points: mass, mass times place, momentum, volume as it is, volume times stress.
    fn sums(&self, world: &PointWorld<S, L>) -> Result<[f64; SUMS], Error> {
        let mut sums = ExactSum::<SUMS>::new();
        for (hot, cold) in world.continuum.points.hot.iter().zip(&world.continuum.points.cold) {
            let place = hot.position + world.assembly.cell.shift(cold.image);
            sums.add(0, hot.mass);
            for axis in 0..S::DIMENSION {
                sums.add(1 + axis, hot.mass * place[axis]);
                sums.add(4 + axis, hot.mass * hot.velocity[axis]);
            }
            sums.add(7, hot.volume * hot.volume_ratio());
            let stress = hot.kirchhoff();
            for component in 0..S::Tensor::COMPONENTS {
                sums.add(8 + component, hot.volume * stress[component]);
            }
        }
        world.reduce(sums)
    }

    /// What is told of a point wherever it is; the same on every rank.
    fn follow(&self, world: &PointWorld<S, L>, id: PointId) -> Vec<f64> {
        let mut told = vec![0.0; 3 * S::DIMENSION + OBSERVED.len()];
        if let Some(row) = world.continuum.points.cold.iter().position(|cold| cold.id == id) {
            let (hot, cold) = (&world.continuum.points.hot[row], &world.continuum.points.cold[row]);
            let place = hot.position + world.assembly.cell.shift(cold.image);
            for axis in 0..S::DIMENSION {
                told[axis] = place[axis];
                told[S::DIMENSION + axis] = place[axis] - cold.origin[axis];
                told[2 * S::DIMENSION + axis] = hot.velocity[axis];
            }
            told[3 * S::DIMENSION..].copy_from_slice(&observed(&world.settings.material, hot));
        }
        // One rank has the point, the others add nothing.
        let mut bits: Vec<i64> = told.iter().map(|number| number.to_bits() as i64).collect();
        world.transport.sum(&mut bits);
        bits.into_iter().map(|bits| f64::from_bits(bits as u64)).collect()
    }
}

/// Slots of [`Continuum::sums`].
const SUMS: usize = 17;

/// The point that is followed.
fn nearest(job: &Mpm, wanted: &[f64; 3]) -> PointId {
    let index = mpm::figures::nearest_point(job, wanted).expect("a checked job follows points that are there");
    PointId(job.number(index))
}

impl<S: Space, L: MaterialLaw<S>> Experiment for Continuum<'_, S, L> {
    type Space = S;
    type Material = Counted<L>;

    fn job(&self) -> String {
        Job::Mpm(self.job.clone()).to_toml()
    }

    fn output(&self) -> &Output {
        &self.job.output
    }

    fn steps(&self) -> u64 {
        mpm::figures::steps(self.job)
    }

    fn header(&self) -> Vec<String> {
        let axes = &AXES[..S::DIMENSION];
        let of = |name: &str| -> Vec<String> { axes.iter().map(|axis| format!("{name}_{axis}")).collect() };
        let mut names: Vec<String> = ["step", "time", "points", "mass", "volume"].map(String::from).into();
        names.extend(of("centre"));
        names.extend(of("momentum"));
        names.extend(axes.iter().flat_map(|i| axes.iter().map(move |j| format!("stress_{i}{j}"))));
        names.extend(["kinetic", "elastic", "potential", "dissipated"].map(String::from));
        if self.job.ledger {
            names.extend(LEDGER.map(String::from));
        }
        if self.job.oracle.is_some() {
            names.extend(columns::OF_ORACLE.map(String::from));
        }
        names.extend(columns::of_extents::<S>());
        for (axis, upper) in self.holding_faces() {
            names.extend(of(&format!("{}_{}_force", AXES[axis], FACES[upper])));
        }
        names.extend(columns::of_bodies::<S>(self.job));
        names.extend(columns::of_membranes(self.job));
        for follow in &self.job.follow {
            for what in ["place", "displacement", "velocity"] {
                names.extend(of(&format!("{}_{what}", follow.name)));
            }
            names.extend(OBSERVED.iter().map(|what| format!("{}_{what}", follow.name)));
        }
        names
    }

    /// A look of the oracle, where the job has one. The first band that persists is told, and left alone.
    fn watch(&mut self, core: &mut PointCore<S, L>) -> Result<(), Error> {
        match &self.job.oracle {
            Some(mpm::Watch { diameter, oracle }) => crate::run::adaptive::tell_band(core, oracle, *diameter),
            None => Ok(()),
        }
    }

    /// Mass (kg), volume (m3), centre of mass (m), momentum (N s), volume mean of the Cauchy stress (Pa), energies at the
    /// last evaluation of forces and where it is kept their account ([`crate::domain::accounts::ledger::points`], J), extents of the
    /// points (m), mean forces (N) and torques (N m) since the last row, stretch of membranes, and followed points.
    fn row(&mut self, core: &mut PointCore<S, L>) -> Result<Vec<f64>, Error> {
        let world = &mut core.world;
        let (energies, balance) = (world.point_energies()?, world.point_balance()?);
        let sums = self.sums(world)?;
        let (mass, volume) = (sums[0], sums[7]);
        let mut row = vec![world.step as f64, world.time(), world.points_total as f64, mass, volume];
        row.extend((0..S::DIMENSION).map(|axis| sums[1 + axis] / mass));
        row.extend((0..S::DIMENSION).map(|axis| sums[4 + axis]));
        for i in 0..S::DIMENSION {
            row.extend((0..S::DIMENSION).map(|j| sums[8 + j * S::DIMENSION + i] / volume));
        }
        row.extend([energies.kinetic, energies.elastic, energies.potential, energies.dissipated]);
        if let Some(balance) = balance {
            row.extend([balance.work_loads, balance.work_bodies, balance.work_ramp]);
            row.extend([balance.holds, balance.lost, balance.transfer]);
        }
        if self.job.oracle.is_some() {
            let memory = &core.progress.oracle;
            row.extend([memory.flagged.len() as f64, f64::from(u8::from(core.progress.enriched_step > 0))]);
        }
        row.extend(columns::row_of_extents(world));

        let reactions: [f64; REACTIONS] = world.take_reactions()?;
        core.progress.kept.take(&reactions);
        let duration = (world.step - core.progress.series_step) as f64 * self.job.step;
        for (axis, upper) in self.holding_faces() {
            let face = grid::face_impulse(&reactions, axis, upper == 1);
            row.extend((0..S::DIMENSION).map(|component| face[component] / duration));
        }
        row.extend(columns::row_of_bodies(world, &reactions, duration));
        row.extend(columns::row_of_membranes(world));
        for id in &self.followed {
            row.extend(self.follow(world, *id));
        }
        Ok(row)
    }

    fn frame(&mut self, core: &mut PointCore<S, L>) -> Result<Option<Frame>, Error> {
        let mut frame = frame(&mut core.world, self.job.grid.depth, 1.0, true)?;
        if let (Some(frame), Some(_)) = (&mut frame, &self.job.oracle) {
            frame.fields.push(watch::flagged_rows(&core.world, &core.progress.oracle, &frame.positions));
        }
        Ok(frame)
    }

    fn words(&self, core: &PointCore<S, L>) -> String {
        format!("time {:.4e} s, {} points", core.world.time(), core.world.points_total)
    }

    fn figures(&self, _: &PointCore<S, L>) -> Value {
        json!({})
    }
}
