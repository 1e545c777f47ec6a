//! The world of a continuum at time zero, or at a checkpoint.

use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::base::units::in_short;
use crate::bodies::body::{Body, MeshSide};
use crate::bodies::boundary::Grip;
use crate::dem::assembly::Constants;
use crate::dem::cell::Cell;
use crate::dem::grains::GrainRow;
use crate::dem::law::{SharedLaw, no_law};
use crate::dem::motion::{Damping, DampingForm, Field};
use crate::domain::grid::Grid;
use crate::domain::layout::{Ground, Layout};
use crate::domain::parts::Parts;
use crate::domain::transfer;
use crate::domain::world::{Settings, World};
use crate::job::mpm::{self, BodyContact, InitialStress, LoadKind, Mpm, Path};
use crate::mpm::load::{Kind, LOADS_MAX, Load, of_side};
use crate::mpm::membrane::{self, Membrane, Membranes, Vertex};
use crate::mpm::penalty::Penalty;
use crate::mpm::points::Point;
use crate::mpm::scheme::Transfer;
use crate::mpm::stress::SharedMaterial;
use crate::prepare::grain_world::{body_of, vector};
use crate::prepare::heterogeneity::Places;
use crate::prepare::mesh_world;
use crate::prepare::sheared;
use crate::store::checkpoint::Drawn;

/// Cells behind the walls, at least: nodes there belong to functions of points beside a wall.
const RIM: usize = 2;

/// The world at time zero. Each rank makes some of the points.
pub fn world<'t, S: Space>(
    job: &Mpm,
    law: &SharedMaterial<S>,
    transport: &'t dyn Transport,
) -> Result<World<'t, S>, Error> {
    world_at(job, law, transport, 0, parts(job, law, transport)?)
}

/// What it is made of.
pub fn parts<S: Space>(job: &Mpm, law: &SharedMaterial<S>, transport: &dyn Transport) -> Result<Parts<S>, Error> {
    let Drawn { cell, bodies, membranes } = drawn::<S>(job, vertices(job))?;
    let mut points = points(job, law, transport);
    let mut nodes = Vec::new();
    if let Some(how) = &job.mesh {
        let meshed = mesh_world::meshed::<S>(job, how);
        nodes = mesh_world::nodes(job, &meshed);
        mesh_world::move_points(&meshed, &nodes, &mut points);
        // Rank 0 has them all.
        nodes.retain(|_| transport.rank() == 0);
    }
    Ok(Parts { membranes, nodes, ..Parts::fresh(Vec::new(), points, bodies, cell) })
}

/// Cell, bodies and membranes as drawn, these with vertices as they are now.
pub(crate) fn drawn<S: Space>(job: &Mpm, vertices: Vec<Vertex<S>>) -> Result<Drawn<S>, Error> {
    Ok(Drawn { cell: cell::<S>(job, &layout::<S>(job)?), bodies: bodies(job), membranes: hung(job, vertices)? })
}

/// The world at a step.
pub fn world_at<'t, S: Space>(
    job: &Mpm,
    law: &SharedMaterial<S>,
    transport: &'t dyn Transport,
    step: u64,
    parts: Parts<S>,
) -> Result<World<'t, S>, Error> {
    let settings = settings(job, law.clone(), no_law());
    World::new(settings, layout::<S>(job)?, transport, step, parts)
}

/// The membranes of a job with vertices as they are now.
pub(crate) fn hung<S: Space>(job: &Mpm, vertices: Vec<Vertex<S>>) -> Result<Membranes<S>, Error> {
    let made_of = membranes(job);
    let owners =
        made_of.iter().enumerate().flat_map(|(number, membrane)| std::iter::repeat_n(number as u64, membrane.count));
    match owners.eq(vertices.iter().map(|vertex| vertex.membrane)) {
        true => Ok(Membranes::new(made_of, vertices)),
        false => Err(Error::User(format!(
            "the {} vertices of membranes in the checkpoint are not those of this job's membranes; it is of another job",
            vertices.len()
        ))),
    }
}

/// Whole blocks around the domain between its walls.
pub fn layout<S: Space>(job: &Mpm) -> Result<Layout, Error> {
    if job.mesh.is_some() {
        return mesh_world::layout::<S>(job).map_err(Error::User);
    }
    let per_block = job.cells_per_block;
    let (mut cells, mut rim, mut corner) = ([1; 3], [[0; 2]; 3], [0.0; 3]);
    for axis in 0..S::DIMENSION {
        cells[axis] = job.grid.cells[axis];
        corner[axis] = job.grid.lower[axis];
        if !job.grid.periodic[axis] {
            let whole = (job.grid.cells[axis] + 2 * RIM).next_multiple_of(per_block);
            rim[axis] = [RIM, whole - job.grid.cells[axis] - RIM];
            cells[axis] = whole;
            corner[axis] -= RIM as f64 * job.grid.cell;
        }
    }
    let ground = Ground {
        cells,
        cells_per_block: per_block,
        cell: job.grid.cell,
        corner,
        periodic: job.grid.periodic,
        rim,
        shape: job.scheme.shape,
        point_half: 0.5 / job.scheme.points_per_cell as f64,
        walled: true,
    };
    Layout::new::<S>(ground).map_err(Error::User)
}

pub(crate) fn cell<S: Space>(job: &Mpm, layout: &Layout) -> Cell<S> {
    let (mut corner, mut lengths) = (S::Vector::zero(), S::Vector::zero());
    for axis in 0..S::DIMENSION {
        corner[axis] = layout.corner[axis];
        lengths[axis] = layout.cells[axis] as f64 * job.edge(axis);
    }
    Cell::cuboid(corner, lengths, layout.periodic)
}

/// The same in the cell of this layout: a grid's does not deform, and one of blocks of another size is another.
pub(crate) fn laid_out<S: Space>(mut parts: Parts<S>, job: &Mpm, layout: &Layout) -> Parts<S> {
    (parts.cell, parts.home.cell) = (cell(job, layout), cell(job, layout));
    parts
}

pub(crate) fn bodies<S: Space>(job: &Mpm) -> Vec<Body<S>> {
    let made = |rigid: &mpm::RigidBody| {
        let mut body = body_of::<S>(&rigid.body);
        let grip = match rigid.contact {
            BodyContact::Rough => Grip::Rough,
            BodyContact::Smooth => Grip::Smooth,
            BodyContact::Coulomb { friction } => Grip::Coulomb(friction),
        };
        body.grip = Some((grip, rigid.separates));
        body.meets_points = rigid.at_face;
        let face = |face: mpm::Face| MeshSide::Face { axis: face.axis, upper: face.upper };
        let bits = |name: &String| MeshSide::Groups(job.drawn().map_or(0, |drawn| drawn.bits_of(name)));
        body.side = rigid.side.map(face).or(rigid.group.as_ref().map(bits));
        body
    };
    job.bodies.iter().map(made).collect()
}

/// Settings of a job's run by its laws.
pub(crate) fn settings<S: Space>(job: &Mpm, material: SharedMaterial<S>, law: SharedLaw<S>) -> Settings<S> {
    let density = job.inertial_density();
    let gravity = vector::<S>(&job.gravity.acceleration.map(|component| component / job.mass_scaling()));
    // Those of RVEs are not in the cells of the grid.
    let grains = job.grains.as_ref().filter(|grains| !grains.method.has_rves());
    // Of nodes of elements; points have none.
    let local = job.mesh.as_ref().map_or(0.0, |mesh| mesh.damping);
    let damping = Damping { local, form: DampingForm::Component, ..Damping::default() };
    let impedance = [material.p_wave_modulus(), material.shear_modulus()].map(|modulus| (modulus * density).sqrt());
    Settings {
        grains: Constants {
            field: Field { gravity, damping },
            // Velocities of points are of the time of their positions, and a grid's step is of one length; those of nodes of elements are half a step behind.
            first_kick: if grains.is_some() || job.mesh.is_some() { 0.5 } else { 1.0 },
            // Without grains there are no lists of pairs for the skin to reach into.
            ..Constants::new(job.step, grains.map_or(job.grid.cell, |grains| grains.piece.skin), law)
        },
        grain_steps: job.grain_steps,
        grid: Grid {
            shape: job.scheme.shape,
            update: job.scheme.update,
            transfer: job.scheme.transfer,
            averages_volume: job.scheme.averages_volume,
            faces: job.boundaries,
            impedance,
            depth: if S::DIMENSION == 2 { job.grid.depth } else { 1.0 },
            gravity_ramp: job.gravity.ramp,
            penalty: grains.map_or(Penalty::NONE, |grains| grains.penalty(job.step)),
        },
        loads: job.loads.iter().map(|load| load_of::<S>(job, load)).collect(),
        material,
        rves: None,
        nonlocal: job.nonlocal,
        meshed: job.mesh.as_ref().map(|how| mesh_world::meshed(job, how)),
        begins_as_grains: grains.is_some_and(|grains| grains.begins_as_grains()),
    }
}

/// The loads of a point have the area of its side.
fn load_of<S: Space>(job: &Mpm, load: &mpm::Load) -> Load<S> {
    let mut area = S::Vector::zero();
    area[load.face.axis] = if load.face.upper { job.point_area() } else { -job.point_area() };
    let kind = match load.kind {
        LoadKind::Traction(traction) => Kind::Traction(vector::<S>(&traction)),
        LoadKind::Pressure(pressure) => Kind::Pressure(pressure),
    };
    Load { area, kind, ramp: load.ramp, on_surface: load.on_surface }
}

/// What the membranes of a job are made of.
fn membranes(job: &Mpm) -> Vec<Membrane> {
    let mut first = 0;
    let made = |one: &mpm::Membrane| {
        let (segments, closed) = (one.segments(), one.is_closed());
        let count = if closed { segments } else { segments + 1 };
        first += count;
        let length = one.segment();
        Membrane {
            name: one.name.clone(),
            first: first - count,
            count,
            closed,
            mass: one.mass_of_segment(job.grid.depth),
            rest: length - one.tension / one.stiffness,
            stiffness: one.stiffness,
            damping: one.damping,
            pressure: one.pressure,
            ramp: one.ramp,
            depth: job.grid.depth,
        }
    };
    job.membranes.iter().map(made).collect()
}

/// Their vertices at the start.
pub(crate) fn vertices<S: Space>(job: &Mpm) -> Vec<Vertex<S>> {
    let of = |(number, one): (usize, &mpm::Membrane)| {
        let mut vertices = at_start::<S>(one);
        vertices.iter_mut().for_each(|vertex| vertex.membrane = number as u64);
        vertices
    };
    job.membranes.iter().enumerate().flat_map(of).collect()
}

fn at_start<S: Space>(one: &mpm::Membrane) -> Vec<Vertex<S>> {
    match one.path {
        Path::Line { from, to } => {
            membrane::along_line(&vector::<S>(&widened(from)), &vector::<S>(&widened(to)), one.segments())
        }
        Path::Circle { centre, radius } => membrane::on_circle(&vector::<S>(&widened(centre)), radius, one.segments()),
    }
}

fn widened([x, y]: [f64; 2]) -> [f64; 3] {
    [x, y, 0.0]
}

/// Points in the regions, in the middle of their places; ids count places.
pub(crate) fn points<S: Space>(job: &Mpm, law: &SharedMaterial<S>, transport: &dyn Transport) -> Vec<Point<S>> {
    let places = job.places();
    assert!(job.loads.len() <= LOADS_MAX, "a checked job has no more loads than a word has bits");
    let mut axes: Vec<usize> = job.loads.iter().filter(|load| load.on_surface).map(|load| load.face.axis).collect();
    axes.sort_unstable();
    axes.dedup();
    let mut points = Vec::new();
    let layers = (0..places[2]).flat_map(|z| (0..places[1]).map(move |y| [y, z]));
    for (number, [y, z]) in layers.enumerate() {
        if number % transport.size() != transport.rank() {
            continue;
        }
        for x in 0..places[0] {
            let index = [x, y, z];
            let Some(region) = job.region_of(index).map(|region| &job.regions[region]) else { continue };
            let (place, volume) = (job.place(index), job.volume_at(index));
            let mass = volume * job.inertial_density();
            let id = PointId(job.number(index));
            let mut point = Point::<S>::resting(id, vector::<S>(&place), mass, volume);
            point.hot.velocity = vector::<S>(&region.velocity_at(&place));
            if job.scheme.transfer == Transfer::Affine {
                point.affine = tensor::<S>(&region.velocity_gradient_at(&place));
            }
            point.hot.memory = law.start(&stress_at::<S>(job, &place), job.fraction_in(region));
            point.hot.stress = S::Symmetric::of(&law.stress(&point.hot.memory));
            // Sides of elements know their loads by themselves.
            if job.mesh.is_some() {
                points.push(point);
                continue;
            }
            for (load, _) in job.loads.iter().enumerate().filter(|(_, load)| job.bears(load, index)) {
                point.cold.loads |= 1 << load;
            }
            for face in axes.iter().flat_map(|axis| [false, true].map(|upper| mpm::Face { axis: *axis, upper })) {
                if !job.has_point_beyond(index, face) {
                    point.cold.loads |= of_side(face.axis, face.upper);
                }
            }
            points.push(point);
        }
    }
    points
}

/// Mean diameters that the kernel of a heterogeneity reaches to either side, at least: some sixty grains.
const KERNEL_IN_DIAMETERS: f64 = 7.5;

/// Points of a grid in the plane begin as dense as the grains of the specimen, all on rank 0, are around them: each is off the fraction and the mass of its region by
/// what the grains there are off their mean. Collective.
pub(crate) fn vary_as_grains_do<S: Space>(
    points: &mut [Point<S>],
    (job, law): (&Mpm, &SharedMaterial<S>),
    grains: &[GrainRow<S>],
    transport: &dyn Transport,
) -> Result<(), Error> {
    let [columns, rows, _] = job.places();
    let index = |place: usize| [place % columns, place / columns, 0];
    let filled: Vec<bool> = (0..columns * rows).map(|place| job.region_of(index(place)).is_some()).collect();
    let first = job.place([0, 0, 0]);
    let (periodic, diameter) = (job.grid.periodic, job.grains.as_ref().map_or(0.0, |it| it.piece.matter.diameter_mean));
    let places = Places {
        first: [first[0], first[1]],
        spacing: job.spacing(),
        counts: [columns, rows],
        periodic: [periodic[0], periodic[1]],
        filled: &filled,
    };
    let length = job.grid.cell.max(KERNEL_IN_DIAMETERS * diameter);
    let told = sheared::on_root(transport, || {
        places.deviations(grains, length).ok_or_else(|| {
            Error::User(format!(
                "material.heterogeneity = \"packing\" is told by the grains within {} mm of a point, and the material is nowhere as wide as that to all sides. Write \"none\".",
                in_short(1e3 * length)
            ))
        })
    });
    let deviations = transfer::broadcast_numbers(transport, &transfer::agree(transport, told)?.unwrap_or_default());
    for point in points {
        let place = index(point.cold.id.0 as usize);
        let Some(region) = job.region_of(place).map(|region| &job.regions[region]) else { continue };
        let (even, deviation) = (job.fraction_in(region), deviations[point.cold.id.0 as usize]);
        point.hot.mass *= 1.0 + deviation / even;
        point.hot.memory = law.start(&stress_at::<S>(job, &job.place(place)), even + deviation);
        point.hot.stress = S::Symmetric::of(&law.stress(&point.hot.memory));
    }
    Ok(())
}

fn tensor<S: Space>(rows: &[[f64; 3]; 3]) -> S::Tensor {
    let mut tensor = S::Tensor::zero();
    for column in 0..S::DIMENSION {
        for row in 0..S::DIMENSION {
            tensor[column * S::DIMENSION + row] = rows[row][column];
        }
    }
    tensor
}

/// Cauchy stress at the start, Pa.
pub fn stress_at<S: Space>(job: &Mpm, place: &[f64; 3]) -> S::Tensor {
    match job.stress {
        InitialStress::None => S::Tensor::zero(),
        InitialStress::Isotropic { pressure } => S::identity() * -pressure,
        InitialStress::Geostatic { axis, k0, .. } => {
            let vertical = job.overburden(place[axis]);
            let mut stress = S::identity() * (-k0 * vertical);
            stress[axis * S::DIMENSION + axis] = -vertical;
            stress
        }
    }
}
