//! Grains in a cell: element tests, collisions, pours (`[cell]` in a job).

use scree_io::column::State;
use scree_io::frames::Frame;
use scree_partition::Transport;
use serde_json::{Value, json};

use crate::base::error::Error;
use crate::base::space::{AXES, Linear, Plane, Solid, Space};
use crate::dem::law::memory_words;
use crate::domain::accounts::ledger::SPENT;
use crate::domain::instant::Instant;
use crate::domain::transfer;
use crate::job::assembly::{Assembly, CellServo, Source};
use crate::job::raw::Typed;
use crate::job::{Output, figures};
use crate::law::material::{Absent, Nothing};
use crate::observe::frame::frame;
use crate::prepare::grain_world::{self, GrainWorld};
use crate::prepare::{grain_file, packed};
use crate::run::folder::Folder;
use crate::run::{self, Core, Experiment, Options, Outcome};
use crate::store::checkpoint::{self, Progress, Snapshot};

/// The job, with its space.
pub struct Element<'s, S> {
    job: &'s Assembly,
    kinds: std::marker::PhantomData<S>,
}

type GrainCore<'t, S> = Core<'t, S, Absent>;
/// A run's state.
pub type GrainSnapshot<S> = Snapshot<S, Nothing>;

/// Refuses what a job's file or packing would be refused for, before anything is started.
pub fn refuse_bad(job: &Assembly, typed: &Typed) -> Result<(), Error> {
    match (&job.source, job.cell.dimension) {
        (Source::File(read), _) => grain_file::refuse_bad(job, read),
        (Source::Packed(packed), 2) => packed::refuse_bad::<Plane>(job, packed, typed),
        (Source::Packed(packed), _) => packed::refuse_bad::<Solid>(job, packed, typed),
    }
}

/// Runs a job from its start.
pub fn start<S: Space>(
    job: &Assembly,
    options: &Options,
    folder: &mut Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let mut world = grain_world::world::<S>(job, transport)?;
    if job.ledger {
        world.open_ledger();
    }
    let progress = Progress { fraction_start: grain_world::fraction(&world, job)?, ..Progress::default() };
    let experiment = Element { job, kinds: std::marker::PhantomData::<S> };
    run::begin(experiment, world, progress, options, folder)
}

/// Continues a run from a state that rank 0 holds.
pub fn resume<S: Space>(
    job: &Assembly,
    state: Option<State>,
    options: &Options,
    folder: Option<Folder>,
    transport: &dyn Transport,
) -> Result<Outcome, Error> {
    let read = |state| Snapshot::from_state(state, memory_words::<S>(&job.contact));
    let snapshot = transfer::agree(transport, state.map(read).transpose())?;
    let (mut world, progress) = world_of::<S>(job, snapshot, transport)?;
    if job.ledger {
        world.resume_ledger(&progress.ledger)?;
    }
    let experiment = Element { job, kinds: std::marker::PhantomData::<S> };
    run::go_on_with(experiment, world, progress, options, folder)
}

/// The world of a snapshot that rank 0 holds, and how far its run is.
pub fn world_of<'t, S: Space>(
    job: &Assembly,
    snapshot: Option<GrainSnapshot<S>>,
    transport: &'t dyn Transport,
) -> Result<(GrainWorld<'t, S>, Progress), Error> {
    let draw = |_: &Progress, _| Ok(grain_world::drawn(job));
    let (parts, progress) = checkpoint::restore(snapshot, draw, transport)?;
    let mut world = grain_world::world_at(job, transport, progress.step, parts)?;
    world.assembly.missed = progress.missed.first().copied().unwrap_or_default();
    Ok((world, progress))
}

/// Columns of the work of the account of energy, J, before those of [`SPENT`].
const WORK: [&str; 3] = ["work_bodies", "work_gravity", "work_cell"];

/// Steps between two looks at whether contacts bear what the cell is held at; the share of the packing fraction of the start
/// that is left when they are looked at, and that of the stress below which they bear nothing.
const BEARING_EVERY: u64 = 1000;
const FRACTION_LEFT_MIN: f64 = 0.5;
const SHARE_BORNE_MIN: f64 = 0.01;

/// Axes held at a stress, and at which, Pa.
fn held(servo: &CellServo) -> impl Iterator<Item = (usize, f64)> + '_ {
    (0..3).filter_map(|axis| Some((axis, servo.stress[axis]?)))
}

impl<S: Space> Element<'_, S> {
    /// Stops the run where the grains fill half of what they filled at the start and bear nothing of a stress that an axis is
    /// held at: grains that dilate go a third apart at most, and in a cell twice as large they have no contacts.
    fn refuse_bearing_nothing(&self, core: &mut GrainCore<S>, servo: &CellServo) -> Result<(), Error> {
        let start = core.progress.fraction_start;
        let world = &mut core.world;
        let fraction = grain_world::fraction(world, self.job)?;
        if fraction > FRACTION_LEFT_MIN * start {
            return Ok(());
        }
        let (moment, volume) = (world.contact_moment()?, grain_world::volume(&world.assembly.cell, self.job));
        let borne = |axis: usize| moment[axis * S::DIMENSION + axis] / volume;
        let idle = held(servo).find(|(axis, target)| *target != 0.0 && borne(*axis) / target < SHARE_BORNE_MIN);
        let Some((axis, target)) = idle else { return Ok(()) };
        let name = AXES[axis];
        let pulls = match target > 0.0 {
            true => {
                "Compression is positive in cell.stress_normal: write it positive to press grains together, or take law = \"linear_cohesive\""
            }
            false => "The grains fly apart: lower their velocities or cell.rate_max, or start from a denser packing",
        };
        Err(Error::Run(format!(
            "step {}, time {:.6e} s: the cell has grown until its grains fill {fraction:.3} of it, {start:.3} at the start, and their contacts bear {:.3e} Pa of the {} Pa that cell.stress_normal holds {name} at; nothing bears the load. {pulls}.",
            world.step,
            world.time(),
            0.0 - borne(axis),
            0.0 - target,
        )))
    }
}

impl<S: Space> Experiment for Element<'_, S> {
    type Space = S;
    type Material = Absent;

    fn job(&self) -> String {
        crate::job::Job::Assembly(self.job.clone()).to_toml()
    }

    fn output(&self) -> &Output {
        &self.job.output
    }

    fn steps(&self) -> u64 {
        figures::steps(self.job)
    }

    fn header(&self) -> Vec<String> {
        let mut names: Vec<String> = ["step", "time", "grains", "contacts", "fraction"].map(String::from).into();
        let axes = &AXES[..S::DIMENSION];
        let pairs = |name: &str| -> Vec<String> {
            axes.iter().flat_map(|i| axes.iter().map(move |j| format!("{name}_{i}{j}"))).collect()
        };
        names.extend(pairs("stress"));
        names.extend(pairs("edge"));
        names.extend(["kinetic_translation", "kinetic_rotation", "elastic"].map(String::from));
        let held = self.job.cell.servo.iter().flat_map(held);
        names.extend(held.map(|(axis, _)| format!("stress_error_{0}{0}", AXES[axis])));
        for body in &self.job.bodies {
            let spins: &[&str] = if S::DIMENSION == 2 { &AXES[2..] } else { &AXES };
            names.extend(axes.iter().map(|axis| format!("{}_force_{axis}", body.name)));
            names.extend(spins.iter().map(|axis| format!("{}_torque_{axis}", body.name)));
            names.extend(axes.iter().map(|axis| format!("{}_displacement_{axis}", body.name)));
        }
        if self.job.ledger {
            names.extend(WORK.into_iter().chain(SPENT).map(String::from));
        }
        names
    }

    /// A cell that grows because nothing bears the stress it is held at has left physics.
    fn watch(&mut self, core: &mut GrainCore<S>) -> Result<(), Error> {
        let step = core.world.step;
        match &self.job.cell.servo {
            Some(servo) if step.is_multiple_of(BEARING_EVERY) || step >= self.steps() => {
                self.refuse_bearing_nothing(core, servo)
            }
            _ => Ok(()),
        }
    }

    /// All at the instant of the positions ([`crate::domain::instant`]): mean stress of the contacts (tension positive, the
    /// direction of the force first, Pa), edges of the cell (m), energies (J). Since the last row: of every axis held at a stress
    /// the root mean square of what was missing of it (Pa), and of every body the mean
    /// force (N) and torque (N m) of the grains on it since the last row and its displacement (m); last, where it is kept,
    /// the account of energy ([`crate::domain::accounts::ledger`]).
    fn row(&mut self, core: &mut GrainCore<S>) -> Result<Vec<f64>, Error> {
        let world = &mut core.world;
        let Instant { moment, kinetic_translation, kinetic_rotation, elastic, contacts } = world.instant()?;
        let volume = grain_world::volume(&world.assembly.cell, self.job);
        let solid = grain_world::solid_volume(world, self.job)?;
        let mut row = vec![world.step as f64, world.time(), world.grains_total as f64, contacts as f64, solid / volume];
        for (tensor, scale) in [(moment, 1.0 / volume), (world.assembly.cell.edges, 1.0)] {
            for i in 0..S::DIMENSION {
                row.extend((0..S::DIMENSION).map(|j| tensor[j * S::DIMENSION + i] * scale));
            }
        }
        row.extend([kinetic_translation, kinetic_rotation, elastic]);
        if let Some(servo) = &self.job.cell.servo {
            let missed = std::mem::take(&mut world.assembly.missed);
            for (axis, target) in held(servo) {
                // A row without a look of the servo before it has what is missing now.
                let now = (moment[axis * S::DIMENSION + axis] / volume - target).abs();
                row.push(missed.root_mean_square(axis).unwrap_or(now));
            }
        }
        let duration = (world.step - core.progress.series_step) as f64 * self.job.step;
        for body in &mut world.bodies {
            let impulse = std::mem::replace(&mut body.impulse, S::Vector::zero());
            let turn = std::mem::replace(&mut body.impulse_angular, S::Spin::zero());
            row.extend((0..S::DIMENSION).map(|axis| impulse[axis] / duration));
            row.extend((0..S::Spin::COMPONENTS).map(|axis| turn[axis] / duration));
            row.extend((0..S::DIMENSION).map(|axis| body.displacement[axis]));
        }
        if self.job.ledger {
            let balance = world.balance()?;
            row.extend([balance.work_bodies, balance.work_gravity, balance.work_cell]);
            row.extend(balance.spent());
        }
        Ok(row)
    }

    fn frame(&mut self, core: &mut GrainCore<S>) -> Result<Option<Frame>, Error> {
        frame(&mut core.world, self.job.cell.depth, core.progress.fraction_start, false)
    }

    fn words(&self, core: &GrainCore<S>) -> String {
        format!("time {:.4e} s, {} grains", core.world.time(), core.world.grains_total)
    }

    fn figures(&self, _: &GrainCore<S>) -> Value {
        json!({})
    }

    fn allows_unstable(&self) -> bool {
        self.job.allow_unstable
    }
}
