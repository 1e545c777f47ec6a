//! Grains in a cell: element tests, collisions, pours (`[cell]` in a job).

use std::marker::PhantomData;

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::space::{AXES, Linear, Plane, Solid, Space};
use crate::dem::law::{SharedLaw, law_of};
use crate::domain::accounts::ledger::Accounts;
use crate::domain::instant::Instant;
use crate::domain::parts::Parts;
use crate::job::assembly::{Assembly, CellServo, Source};
use crate::job::figures;
use crate::job::raw::Typed;
use crate::mpm::membrane::Vertex;
use crate::mpm::stress::{SharedMaterial, no_material};
use crate::prepare::grain_world::{self, GrainWorld};
use crate::prepare::{grain_file, packed};
use crate::run::Core;
use crate::run::columns::servo::Watch;
use crate::run::columns::{self, Columns, Work, of_body, of_tensor, row_of_tensor};
use crate::run::experiment::{Experiment, Picture, Setup};
use crate::run::folder::Folder;
use crate::store::checkpoint::{Drawn, Progress};

/// The job, with its space.
pub struct InSpace<'s, S> {
    job: &'s Assembly,
    kinds: PhantomData<S>,
}

impl<'s, S: Space> InSpace<'s, S> {
    /// A job of that dimension.
    pub fn new(job: &'s Assembly) -> Self {
        Self { job, kinds: PhantomData }
    }
}

type GrainCore<'t, S> = Core<'t, S>;

/// Refuses what a job's file or packing would be refused for, before anything is started.
pub fn refuse_bad(job: &Assembly, typed: &Typed) -> Result<(), Error> {
    match (&job.source, job.cell.dimension) {
        (Source::File(read), _) => grain_file::refuse_bad(job, read),
        (Source::Packed(packed), 2) => packed::refuse_bad::<Plane>(&job.of_one_copy(), packed, typed),
        (Source::Packed(packed), _) => packed::refuse_bad::<Solid>(&job.of_one_copy(), packed, typed),
    }
}

/// Works of the account of energy.
const WORKS: [Work; 3] = [
    ("work_bodies", |balance| balance.work_bodies),
    ("work_gravity", |balance| balance.work_gravity),
    ("work_cell", |balance| balance.work_cell),
];

impl<S: Space> Setup for InSpace<'_, S> {
    type Space = S;

    fn experiment(&self) -> Experiment<'_, S> {
        let job = self.job;
        let mut columns = vec![state(job), bodies(job)];
        if job.ledger {
            columns.push(columns::account_of_grains(&WORKS));
        }
        let steps = figures::steps(job.end, job.step);
        Experiment {
            job: job.to_toml(),
            output: &job.output,
            steps,
            accounts: Accounts { grains: job.ledger, points: false },
            allows_unstable: job.allow_unstable,
            picture: Picture {
                depth: job.cell.depth,
                may_have_grains: true,
                may_have_points: false,
                has_elements: false,
                flagged: false,
            },
            drawn_rves: Vec::new(),
            columns,
            watch: Box::new(move |core| match &job.cell.servo {
                Some(servo) if core.world.step.is_multiple_of(BEARING_EVERY) || core.world.step >= steps => {
                    refuse_bearing_nothing(job, core, servo)
                }
                _ => Ok(()),
            }),
            strain: None,
        }
    }

    fn law(&self) -> SharedLaw<S> {
        law_of(&self.job.contact)
    }

    fn material(&self) -> SharedMaterial<S> {
        no_material()
    }

    fn begin<'t>(
        &self,
        _: &mut Option<Folder>,
        transport: &'t dyn Transport,
    ) -> Result<(GrainWorld<'t, S>, Progress), Error> {
        let world = grain_world::world(self.job, transport)?;
        let fraction_start = grain_world::fraction(&world, self.job)?;
        Ok((world, Progress { fraction_start, ..Progress::default() }))
    }

    fn drawn(&self, _: &Progress, _: Vec<Vertex<S>>) -> Result<Drawn<S>, Error> {
        Ok(grain_world::drawn(self.job))
    }

    fn world_at<'t>(
        &self,
        progress: &Progress,
        parts: Parts<S>,
        transport: &'t dyn Transport,
    ) -> Result<GrainWorld<'t, S>, Error> {
        let mut world = grain_world::world_at(self.job, transport, progress.step, parts)?;
        world.assembly.missed = progress.missed.first().copied().unwrap_or_default();
        Ok(world)
    }
}

/// All at the instant of the positions ([`crate::domain::instant`]): mean stress of the contacts (tension positive, the
/// direction of the force first, Pa), edges of the cell (m), energies (J); and of every axis held at a stress the root mean square of
/// what was missing of it since the last row (Pa).
fn state<S: Space>(job: &Assembly) -> Columns<'_, S> {
    let axes: Vec<(usize, f64)> = job.cell.servo.iter().flat_map(held).collect();
    let mut names: Vec<String> = ["step", "time", "grains", "contacts", "fraction"].map(String::from).into();
    names.extend(of_tensor::<S>("stress"));
    names.extend(of_tensor::<S>("edge"));
    names.extend(["kinetic_translation", "kinetic_rotation", "elastic"].map(String::from));
    names.extend(axes.iter().map(|(axis, _)| format!("stress_error_{0}{0}", AXES[*axis])));
    Columns::new(names, move |core: &mut GrainCore<S>| {
        let world = &mut core.world;
        let Instant { moment, kinetic_translation, kinetic_rotation, elastic, contacts } = world.instant()?;
        let volume = grain_world::volume(&world.assembly.cell, job);
        let solid = grain_world::solid_volume(world, job)?;
        let mut row = vec![world.step as f64, world.time(), world.grains_total as f64, contacts as f64, solid / volume];
        row.extend(row_of_tensor::<S>(|component| moment[component] * (1.0 / volume)));
        row.extend(row_of_tensor::<S>(|component| world.assembly.cell.edges[component]));
        row.extend([kinetic_translation, kinetic_rotation, elastic]);
        let missed = std::mem::take(&mut world.assembly.missed);
        for (axis, target) in &axes {
            // A row without a look of the servo before it has what is missing now.
            let now = (moment[axis * S::DIMENSION + axis] / volume - target).abs();
            row.push(missed.root_mean_square(*axis).unwrap_or(now));
        }
        Ok(row)
    })
}

/// Of every body the mean force (N) and torque (N m) of the grains on it since the last row, and its displacement (m).
fn bodies<S: Space>(job: &Assembly) -> Columns<'_, S> {
    let mut watch = Watch::default();
    Columns::new(job.bodies.iter().flat_map(|body| of_body::<S>(&body.name)), move |core: &mut GrainCore<S>| {
        let (world, mut row) = (&mut core.world, Vec::new());
        let duration = (world.step - core.progress.series_step) as f64 * job.step;
        let speaker = (world.step, world.transport.rank() == 0);
        for (number, body) in world.bodies.iter_mut().enumerate() {
            let impulse = std::mem::replace(&mut body.impulse, S::Vector::zero());
            let turn = std::mem::replace(&mut body.impulse_angular, S::Spin::zero());
            watch.tell(number, body, &(impulse * (1.0 / duration)), speaker);
            row.extend((0..S::DIMENSION).map(|axis| impulse[axis] / duration));
            row.extend((0..S::Spin::COMPONENTS).map(|axis| turn[axis] / duration));
            row.extend((0..S::DIMENSION).map(|axis| body.displacement[axis]));
        }
        Ok(row)
    })
}

/// Steps between two looks at whether contacts bear what the cell is held at; the share of the solid volume fraction of the start
/// that is left when they are looked at, and that of the stress below which they bear nothing.
const BEARING_EVERY: u64 = 1000;
const FRACTION_LEFT_MIN: f64 = 0.5;
const SHARE_BORNE_MIN: f64 = 0.01;

/// Axes held at a stress, and at which, Pa.
fn held(servo: &CellServo) -> impl Iterator<Item = (usize, f64)> + '_ {
    (0..3).filter_map(|axis| Some((axis, servo.stress[axis]?)))
}

/// Stops the run where the grains fill half of what they filled at the start and bear nothing of a stress that an axis is
/// held at: grains that dilate go a third apart at most, and in a cell twice as large they have no contacts.
fn refuse_bearing_nothing<S: Space>(job: &Assembly, core: &mut GrainCore<S>, servo: &CellServo) -> Result<(), Error> {
    let start = core.progress.fraction_start;
    let world = &mut core.world;
    let fraction = grain_world::fraction(world, job)?;
    if fraction > FRACTION_LEFT_MIN * start {
        return Ok(());
    }
    let (moment, volume) = (world.contact_moment()?, grain_world::volume(&world.assembly.cell, job));
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
