//! How long a grain-step takes: a dense packing between two rough layers, sheared under constant normal stress, the
//! whole step with its rebuilds, messages and servo.

use scree_partition::Transport;

use super::{Speed, Stretches, resident_bytes};
use crate::base::error::Error;
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::bodies::body::{self, Body, Servo, Shape};
use crate::dem::cell::Cell;
use crate::dem::drive::CellDrive;
use crate::dem::grains::GrainRow;
use crate::dem::grains::Mover;
use crate::dem::tile::tile;
use crate::domain::parts::Parts;
use crate::domain::world::World;
use crate::job::assembly::{Packed, Source};
use crate::job::{Assembly, Job};
use crate::prepare::grain_world::{self, GrainWorld};

/// What is measured.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// About as many: whole copies of one packing lie side by side.
    pub grains: u64,
    /// In space instead of the plane.
    pub solid: bool,
    /// A step is one of every grain.
    pub stretches: Stretches,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Contact law as a job names it: "linear" in the plane, "hertz_mindlin" in space.
    pub law: &'static str,
    /// Of the sheared packing, once its start is forgotten.
    pub speed: Speed,
    /// Contacts that hold at the end, each counted once, over grains.
    pub contacts_per_grain: f64,
    /// Those of the neighbour lists at the end; one between two ranks is in the lists of both.
    pub pairs_per_grain: f64,
    /// Of the arrays of all ranks.
    pub bytes_per_grain: f64,
    /// Shear stress over normal stress of the upper layer at the end: a sheared packing, not a chattering one.
    pub stress_ratio: f64,
}

/// Layers glued to the bodies, in mean diameters.
const GLUED: f64 = 3.0;
/// Steps before the first stretch, so that the start is forgotten.
const WARM_UP: u64 = 2000;
const LOWER: u8 = 0;
const UPPER: u8 = 1;

/// Runs the measurement on all ranks.
pub fn measure(wanted: &Wanted, transport: &dyn Transport) -> Result<Measured, Error> {
    match wanted.solid {
        false => measured::<Plane>(wanted, "linear", transport),
        true => measured::<Solid>(wanted, "hertz_mindlin", transport),
    }
}

/// Tiles of the packing along each axis, and grains in one: twice as high as wide, as the shear test of Chen et al. (2021).
fn tiles<S: Space>(grains: u64) -> ([usize; 3], u64) {
    let (base, height) = if S::DIMENSION == 2 { (764.0, 2.0) } else { (1000.0, 1.0) };
    let whole = grains as f64 / base;
    let along = if S::DIMENSION == 2 { (whole / height).sqrt() } else { crate::base::math::cbrt(whole) };
    let along = along.round().max(1.0);
    let layer = if S::DIMENSION == 2 { along } else { along * along };
    let up = (whole / layer).round().max(1.0);
    let base = (grains as f64 / (layer * up)).round().max(100.0) as u64;
    let depth = if S::DIMENSION == 2 { 1 } else { along as usize };
    ([along as usize, up as usize, depth], base)
}

/// The packing that is tiled: Table 1 of Chen et al. (2021) with the damping that is stable, or spheres of Table I of Liu et al. (2016)
/// made softer, so that the step is that of a sheared packing and not of quartz.
pub(super) fn job<S: Space>(base: u64) -> Result<Assembly, Error> {
    let text = if S::DIMENSION == 2 {
        format!(
            r#"
            name = "bench"
            [cell]
            space = "plane"
            upper = [{edge:?}, {edge:?}]
            depth = "1 cm"
            [grains]
            density = "2530 kg/m3"
            count = {base}
            distribution = "normal"
            diameter_mean = "1 mm"
            diameter_deviation = "0.08 mm"
            [packing]
            preparation = "compress"
            stress = "400 kPa"
            energy_ratio_max = 1e-3
            [contact]
            stiffness_normal = 1772093.8
            stiffness_tangential = 886046.9
            damping_normal = 3.5
            damping_tangential = 3.5
            friction = 0.5
            [time]
            step = "0.4 us"
            end = "1 s"
            "#,
            edge = 1e-3 * (base as f64 * 0.92).sqrt()
        )
    } else {
        format!(
            r#"
            name = "bench"
            [cell]
            space = "solid"
            upper = [{edge:?}, {edge:?}, {edge:?}]
            [grains]
            density = "2650 kg/m3"
            count = {base}
            distribution = "uniform"
            diameter_min = "0.8 mm"
            diameter_max = "1.2 mm"
            [packing]
            preparation = "compress"
            stress = "100 kPa"
            energy_ratio_max = 1e-3
            [contact]
            law = "hertz_mindlin"
            shear_modulus = "290 MPa"
            poisson_ratio = 0.15
            friction = 0.5
            damping_normal = 0.01
            damping_tangential = 0.01
            [time]
            step = "0.8 us"
            end = "1 s"
            "#,
            edge = 1e-3 * crate::base::math::cbrt(base as f64 * 0.87)
        )
    };
    Ok(Job::parse(&text, "bench", &[])?.as_assembly().expect("the text has a [cell]").clone())
}

/// Keeps the packing of a job among temporary files.
pub(super) fn keep_packing(job: &mut Assembly) -> Packed {
    let Source::Packed(packed) = &mut job.source else { unreachable!("grains are made") };
    packed.cache = std::env::temp_dir().join("scree-bench");
    packed.clone()
}

/// The sheared world once its start is forgotten.
pub(super) fn warm<'t, S: Space>(wanted: &Wanted, transport: &'t dyn Transport) -> Result<GrainWorld<'t, S>, Error> {
    let mut world = world::<S>(wanted, transport)?;
    for _ in 0..WARM_UP.min(wanted.stretches.steps) {
        world.advance()?;
    }
    Ok(world)
}

/// The sheared world: periodic along all axes but y, where the outer layers are glued together.
fn world<'t, S: Space>(wanted: &Wanted, transport: &'t dyn Transport) -> Result<GrainWorld<'t, S>, Error> {
    let (counts, base) = tiles::<S>(wanted.grains);
    let mut job = job::<S>(base)?;
    let packed = keep_packing(&mut job);
    let packing = crate::prepare::packed::make::<S>(&job, &packed, job.output.save_every(), transport)?;
    let edges = packing.cell.edges;
    let mut grains: Vec<GrainRow<S>> = tile(packing.grains, &edges, counts, [true, false, true]);

    let diameter = job.matter.diameter_mean;
    let mut lengths = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        lengths[axis] = edges[axis * S::DIMENSION + axis] * counts[axis] as f64;
    }
    let (height, room) = (lengths[1], 4.0 * diameter);
    for grain in &mut grains {
        let y = grain.hot.position[1];
        if y < GLUED * diameter {
            grain.hand_to(Mover::Body(LOWER));
        } else if y > height - GLUED * diameter {
            grain.hand_to(Mover::Body(UPPER));
        }
    }
    let mut corner = S::Vector::zero();
    corner[1] = -room;
    lengths[1] = height + 2.0 * room;
    let cell = Cell::cuboid(corner, lengths, [true, false, true]);
    let settings = grain_world::settings_in::<S>(&job, CellDrive::default());
    let layout = grain_world::layout_of::<S>(&job, &cell)?;
    let bodies = bodies::<S>(&job, &lengths);
    World::new(settings, layout, transport, 0, Parts::fresh(grains, Vec::new(), bodies, cell))
}

fn bodies<S: Space>(job: &Assembly, lengths: &S::Vector) -> Vec<Body<S>> {
    let mut area = if S::DIMENSION == 2 { job.cell.depth } else { 1.0 };
    for axis in (0..S::DIMENSION).filter(|axis| *axis != 1) {
        area *= lengths[axis];
    }
    let stress = if S::DIMENSION == 2 { 400e3 } else { 100e3 };
    let mut upper = Body::new("upper", Shape::Layer);
    let (mut velocity, mut direction) = (S::Vector::zero(), S::Vector::zero());
    (velocity[0], direction[1]) = (0.02, 1.0);
    upper.path = vec![body::Instant { time: 0.0, velocity, spin: S::Spin::zero() }];
    let mass = 0.1 * job.matter.density * area * lengths[1];
    upper.servo = Some(Servo { direction, force: stress * area, mass, damping: 1e3 * mass, speed_max: 0.2 });
    vec![Body::new("lower", Shape::Layer), upper]
}

fn measured<S: Space>(wanted: &Wanted, law: &'static str, transport: &dyn Transport) -> Result<Measured, Error> {
    let resident = resident_bytes();
    let mut world = warm::<S>(wanted, transport)?;
    world.bodies[UPPER as usize].impulse = S::Vector::zero();
    let speed = Speed::of(&mut world, wanted.stretches, resident, transport)?;
    let impulse = world.bodies[UPPER as usize].impulse;
    let pairs = world.assembly.contacts.neighbours.real_pairs().count();
    let mut sums = [world.bytes() as i64, pairs as i64];
    transport.sum(&mut sums);
    let per_grain = |sum: f64| sum / speed.rows as f64;
    Ok(Measured {
        law,
        contacts_per_grain: per_grain(world.contact_count() as f64),
        pairs_per_grain: per_grain(sums[1] as f64),
        bytes_per_grain: per_grain(sums[0] as f64),
        stress_ratio: -impulse[0] / impulse[1],
        speed,
    })
}
