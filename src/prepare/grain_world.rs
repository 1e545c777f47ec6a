//! The world of an assembly at time zero, or at a checkpoint.

use std::sync::Arc;

use rand_chacha::rand_core::Rng;
use scree_partition::{ExactSum, Solo, Transport};

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{AXES, Linear, Space};
use crate::bodies::body::{self, Body};
use crate::dem::assembly::Constants;
use crate::dem::cell::Cell;
use crate::dem::drive::{CellDrive, Response, StressServo};
use crate::dem::grains::{GrainRow, Grains, Mover};
use crate::dem::law::law_of;
use crate::dem::motion::Field;
use crate::dem::sample::Sample;
use crate::domain::layout::{Ground, Layout};
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::job::assembly::{Assembly, BodyServo, Read, Shape, Source, Velocities};
use crate::job::figures;
use crate::mpm::membrane::Membranes;
use crate::prepare::grain_file;
use crate::prepare::insert::random_of;
use crate::rve::Rve;
use crate::store::checkpoint::Drawn;

/// A world of grains alone.
pub type GrainWorld<'t, S> = World<'t, S>;

/// Which stream of random numbers says which grains are taken out of a packing.
const STREAM_OF_REMOVED: u64 = 1 << 62;
/// Grid cells per block and axis: grains of a block stand in the order of its cells, for the sake of the caches.
const CELLS_PER_BLOCK: usize = 4;

/// The world at time zero.
pub fn world<'t, S: Space>(job: &Assembly, transport: &'t dyn Transport) -> Result<GrainWorld<'t, S>, Error> {
    let (grains, cell) = at_start(job, transport)?;
    world_of(job, grains, cell, transport)
}

/// The world at time zero of these grains, which lie on rank 0, with those of layers in the hands of these.
pub fn world_of<'t, S: Space>(
    job: &Assembly,
    mut grains: Vec<GrainRow<S>>,
    cell: Cell<S>,
    transport: &'t dyn Transport,
) -> Result<GrainWorld<'t, S>, Error> {
    let glued = if transport.rank() == 0 { glue_layers(job, &mut grains, &cell) } else { Ok(()) };
    transfer::agree(transport, glued)?;
    world_at(job, transport, 0, Parts::fresh(grains, Vec::new(), drawn::<S>(job).bodies, cell))
}

/// The grains of a job without bodies as a sample, with the bits of its world.
pub fn sample<S: Space>(job: &Assembly) -> Result<Sample<S>, Error> {
    let (grains, cell) = at_start(job, &Solo)?;
    let layout = layout::<S>(job)?;
    let parts = layout.parts_of_cell(job.skin);
    let order = move |fraction: &S::Vector| layout.place::<S>(fraction, parts).expect("a sample's cell is periodic");
    Sample::new(&grains, cell, constants(job), Arc::new(order))
}

/// The same as a representative volume element, whose grains stand in the order of their ids; the same on every rank. It serves free
/// grains in a cell that is periodic along every axis, without gravity and bodies. Collective.
pub fn volume_element<S: Space>(job: &Assembly, transport: &dyn Transport) -> Result<Rve<S>, Error> {
    let refused = |what: &str| Err(Error::User(format!("a grain assembly that stands for a material {what}")));
    if !(0..S::DIMENSION).all(|axis| job.cell.periodic[axis]) {
        return refused("lies in a cell that is periodic along every axis: write cell.periodic so");
    }
    if !job.bodies.is_empty() {
        return refused("has no bodies in it: remove [[body]]");
    }
    if job.gravity != [0.0; 3] {
        return refused("bears the stress of its point, and no weight: remove cell.gravity");
    }
    let (grains, cell) = at_start::<S>(job, transport)?;
    let mut grains = transfer::broadcast(transport, grains)?;
    number(&mut grains);
    let sample = Sample::in_order([cell, cell], &grains, constants(job))?;
    Rve::new(sample, depth_of::<S>(job))
}

/// The same without some of its grains, drawn by seed and id: what is left bears less than the packing did.
pub fn weakened<S: Space>(job: &Assembly, removed: u64, transport: &dyn Transport) -> Result<Rve<S>, Error> {
    let (grains, cell) = at_start::<S>(job, transport)?;
    let mut grains = transfer::broadcast(transport, grains)?;
    number(&mut grains);
    let mut drawn: Vec<(u64, GrainId)> = grains
        .iter()
        .map(|grain| (random_of(job.seed, STREAM_OF_REMOVED | grain.cold.id.0).next_u64(), grain.cold.id))
        .collect();
    drawn.sort_unstable();
    let mut gone: Vec<GrainId> = drawn.iter().take(removed as usize).map(|(_, id)| *id).collect();
    gone.sort_unstable();
    let is_gone = |id: &GrainId| gone.binary_search(id).is_ok();
    grains.retain(|grain| !is_gone(&grain.cold.id));
    grains.iter_mut().for_each(|grain| grain.contacts.retain(|(partner, _)| !is_gone(partner)));
    number(&mut grains);
    let sample = Sample::in_order([cell, cell], &grains, constants(job))?;
    Rve::new(sample, depth_of::<S>(job))
}

/// Ids from none on, in the order of those that they have, with which contacts keep their sense.
fn number<S: Space>(grains: &mut [GrainRow<S>]) {
    grains.sort_unstable_by_key(|grain| grain.cold.id);
    let ids: Vec<GrainId> = grains.iter().map(|grain| grain.cold.id).collect();
    let numbered = |id: GrainId| GrainId(ids.binary_search(&id).expect("contacts are of grains that are there") as u64);
    for grain in grains {
        grain.cold.id = numbered(grain.cold.id);
        grain.contacts.iter_mut().for_each(|(partner, _)| *partner = numbered(*partner));
    }
}

/// Grains on rank 0, and the cell that they start in.
fn at_start<S: Space>(job: &Assembly, transport: &dyn Transport) -> Result<(Vec<GrainRow<S>>, Cell<S>), Error> {
    match &job.source {
        Source::File(read) => {
            let read = match transport.rank() {
                0 => grain_file::read_start::<S>(job, read).map(|(grains, cell)| (grains, vec![cell])),
                _ => Ok((Vec::new(), Vec::new())),
            };
            let (grains, cell) = transfer::agree(transport, read)?;
            Ok((grains, super::packed::same_cell(job, cell, transport)?))
        }
        Source::Packed(packed) => {
            let packing = super::packed::make::<S>(&job.of_one_copy(), packed, job.output.save_every(), transport)?;
            Ok(packing.repeated(job))
        }
    }
}

/// Cell and bodies as drawn.
pub fn drawn<S: Space>(job: &Assembly) -> Drawn<S> {
    let bodies = job.bodies.iter().map(body_of).collect();
    Drawn { cell: cell_of(job), bodies, membranes: Membranes::default() }
}

/// The world at a step.
pub fn world_at<'t, S: Space>(
    job: &Assembly,
    transport: &'t dyn Transport,
    step: u64,
    parts: Parts<S>,
) -> Result<GrainWorld<'t, S>, Error> {
    World::new(Settings::of_grains(constants(job)), layout::<S>(job)?, transport, step, parts)
}

/// The cell as drawn.
pub fn cell_of<S: Space>(job: &Assembly) -> Cell<S> {
    scaled_cell(job, 1.0)
}

/// The cell as drawn with its lengths changed by a share.
pub(super) fn scaled_cell<S: Space>(job: &Assembly, share: f64) -> Cell<S> {
    let (lower, upper) = (vector::<S>(&job.cell.lower), vector::<S>(&job.cell.end()));
    let room = vector::<S>(&std::array::from_fn(|axis| figures::room(job, axis)));
    Cell::cuboid(lower - room, (upper - lower) * share + room * 2.0, job.cell.periodic)
}

/// The cell as drawn, or the smallest that grains which are compressed in it could fill.
pub(super) fn densest_cell<S: Space>(job: &Assembly) -> Cell<S> {
    scaled_cell(job, figures::shrinkage_most(job))
}

/// Blocks of the job's cell, however it has deformed: those of the smallest that it can start as. By the job alone, so that
/// a resumed run is cut alike.
pub(super) fn layout<S: Space>(job: &Assembly) -> Result<Layout, Error> {
    layout_of(job, &densest_cell::<S>(job))
}

/// Blocks near the wanted edge, as many as fill the cell.
pub fn layout_of<S: Space>(job: &Assembly, cell: &Cell<S>) -> Result<Layout, Error> {
    let (mut cells, mut corner) = ([1; 3], [0.0; 3]);
    for axis in 0..S::DIMENSION {
        cells[axis] = CELLS_PER_BLOCK * ((cell.height(axis) / job.block).floor() as usize).max(1);
        corner[axis] = cell.corner[axis];
    }
    let cell_edge = job.block / CELLS_PER_BLOCK as f64;
    let ground = Ground::open(cells, CELLS_PER_BLOCK, cell_edge, corner, cell.periodic);
    Layout::new::<S>(ground).map_err(Error::User)
}

/// Constants of the grains of a job.
pub(crate) fn constants<S: Space>(job: &Assembly) -> Constants<S> {
    let mut gradient = S::Tensor::zero();
    for i in 0..S::DIMENSION {
        for j in 0..S::DIMENSION {
            gradient[j * S::DIMENSION + i] = job.cell.gradient[i][j];
        }
    }
    let servo = job.cell.servo.as_ref().map(|servo| StressServo {
        stress: servo.stress,
        response: Response::Contacts { gain: servo.gain },
        interval: servo.interval,
        rate_max: servo.rate_max,
        depth: depth_of::<S>(job),
    });
    let first_kick = match job.velocities {
        Velocities::Now => 0.5,
        Velocities::HalfStepBefore => 1.0,
    };
    // Memories of the step before go on from it, as do velocities of half a step before.
    let goes_on = matches!(&job.source, Source::File(Read { contacts: Some(_), .. })) && first_kick == 1.0;
    let first_advance = if goes_on { job.step } else { 0.0 };
    Constants { first_kick, first_advance, ..constants_in(job, CellDrive { gradient, servo }) }
}

/// The same where the cell is driven otherwise, and grains start from velocities of time zero.
fn constants_in<S: Space>(job: &Assembly, drive: CellDrive<S>) -> Constants<S> {
    let field = Field { gravity: vector::<S>(&job.gravity), damping: job.damping };
    Constants { field, drive, ..Constants::new(job.step, job.skin, law_of(&job.contact)) }
}

/// Settings of a world of this job whose cell is driven otherwise, and whose grains start from velocities of time zero.
pub fn settings_in<S: Space>(job: &Assembly, drive: CellDrive<S>) -> Settings<S> {
    Settings::of_grains(constants_in(job, drive))
}

/// What the space's measure is multiplied with to give m3.
pub(super) fn depth_of<S: Space>(job: &Assembly) -> f64 {
    if S::DIMENSION == 2 { job.cell.depth } else { 1.0 }
}

/// Volume of the cell without the room at the open ends of copies, m3.
pub fn volume<S: Space>(cell: &Cell<S>, job: &Assembly) -> f64 {
    let filled = |axis: usize| 1.0 - 2.0 * figures::room(job, axis) / cell.height(axis);
    let open = (0..S::DIMENSION).filter(|axis| figures::room(job, *axis) > 0.0);
    cell.volume() * depth_of::<S>(job) * open.map(filled).product::<f64>()
}

/// Volume of all grains, m3.
pub fn solid_volume<S: Space>(world: &GrainWorld<S>, job: &Assembly) -> Result<f64, Error> {
    Ok(world.reduce(solid_of(&world.assembly.grains, job))?[0])
}

/// The same of the grains that are here.
pub fn solid_of<S: Space>(grains: &Grains<S>, job: &Assembly) -> ExactSum<1> {
    let mut sum = ExactSum::new();
    grains.hot[..grains.owned].iter().for_each(|hot| sum.add(0, S::grain_volume(hot.radius, job.cell.depth)));
    sum
}

/// Solid volume fraction of the cell as it is.
pub fn fraction<S: Space>(world: &GrainWorld<S>, job: &Assembly) -> Result<f64, Error> {
    Ok(solid_volume(world, job)? / volume(&world.assembly.cell, job))
}

pub(crate) fn vector<S: Space>(components: &[f64; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = components[axis];
    }
    vector
}

fn spin<S: Space>(components: &[f64; 3]) -> S::Spin {
    let mut spin = S::Spin::zero();
    for axis in 0..S::Spin::COMPONENTS {
        spin[axis] = components[3 - S::Spin::COMPONENTS + axis];
    }
    spin
}

pub(super) fn servo_of<S: Space>(servo: &BodyServo) -> body::Servo<S> {
    body::Servo {
        direction: vector::<S>(&servo.direction),
        force: servo.force,
        mass: servo.mass,
        damping: servo.damping,
        speed_max: servo.speed_max,
    }
}

pub(crate) fn body_of<S: Space>(body: &crate::job::assembly::Body) -> Body<S> {
    let shape = match &body.shape {
        Shape::Layer { .. } => body::Shape::Layer,
        Shape::Plane { point, normal } => body::Shape::Plane { point: vector::<S>(point), normal: vector::<S>(normal) },
        Shape::Box { lower, upper } => body::Shape::Box { lower: vector::<S>(lower), upper: vector::<S>(upper) },
        Shape::Cylinder { centre, radius, axis } => {
            body::Shape::Cylinder { centre: vector::<S>(centre), axis: vector::<S>(axis), radius: *radius }
        }
    };
    let mut made = Body::new(&body.name, shape);
    made.path = body
        .motion
        .path
        .iter()
        .map(|at| body::Instant { time: at.time, velocity: vector::<S>(&at.velocity), spin: spin::<S>(&at.spin) })
        .collect();
    made.oscillation = body.motion.oscillation.map(|sine| (vector::<S>(&sine.amplitude), sine.frequency));
    made.servo = body.motion.servo.as_ref().map(servo_of);
    made
}

/// Hands the grains in their regions to layers; a layer without grains would move nothing and feel nothing.
fn glue_layers<S: Space>(job: &Assembly, grains: &mut [GrainRow<S>], cell: &Cell<S>) -> Result<(), Error> {
    for (index, body) in job.bodies.iter().enumerate() {
        let Shape::Layer { lower, upper } = &body.shape else { continue };
        if glue(grains, index as u8, lower, upper) > 0 {
            continue;
        }
        let ends = |axis: usize| {
            let (start, room) = (cell.corner[axis], figures::room(job, axis));
            let end = start + cell.edges[axis * S::DIMENSION + axis];
            format!("{:.4e} to {:.4e} m along {}", start + room, end - room, AXES[axis])
        };
        let reaches: Vec<String> = (0..S::DIMENSION).map(ends).collect();
        return Err(Error::User(format!(
            "body `{}` holds no grain: none has its centre between body.lower and body.upper when the run starts, with the cell reaching from {}; a packing that is compressed has shrunk towards cell.lower by then. Move the region to where grains are.",
            body.name,
            reaches.join(", ")
        )));
    }
    Ok(())
}

/// Hands the grains in a box to a body; returns how many there are.
fn glue<S: Space>(grains: &mut [GrainRow<S>], body: u8, lower: &[f64; 3], upper: &[f64; 3]) -> usize {
    let mut count = 0;
    for grain in grains {
        let inside = (0..S::DIMENSION).all(|axis| (lower[axis]..=upper[axis]).contains(&grain.hot.position[axis]));
        if inside {
            grain.hand_to(Mover::Body(body));
            count += 1;
        }
    }
    count
}
