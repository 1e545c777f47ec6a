//! Frames: grains and points of the whole world as rows for pictures, on rank 0.
//!
//! Of a grain the stress is the Love-Weber mean of its contacts with grains and bodies over its share of space, with the
//! forces of the positions and velocities of now, which the coming evaluation will have ([`crate::dem::bearing`]):
//!
//! ```text
//! sigma_ij = phi/V sum f_i b_j
//! ```
//!
//! f the force on the grain, b the way from its centre to half way between the two centres, or to where a body is touched,
//! V the grain's volume and phi the solid volume fraction at the start. Its coordination is the number of contacts that bear
//! force. Its strains are those of the deformation that its neighbours tell ([`crate::observe::local_strain`]), by the
//! formulas that points have; they are zero where the neighbours do not tell any.

use std::ops::Range;

use rayon::prelude::*;
use scree_io::column::{Column, Values};
use scree_io::frames::{Drawn, Frame};

use crate::base::error::Error;
use crate::base::math;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Solid, Space};
use crate::dem::bearing::Bearing;
use crate::dem::cell::{Cell, Image, visit_image};
use crate::dem::grains::Mover;
use crate::domain::means::averaged;
use crate::domain::transfer::{self, PIECE_ROWS};
use crate::domain::world::World;
use crate::law::invariants::{Deformation, StressInvariants};
use crate::mpm::membrane::Vertex;
use crate::mpm::points::{Cold, Hot};
use crate::observe::local_strain::{Place, best_fit_deformations};
use crate::observe::point::{OBSERVED, OBSERVED_OF_RVES, observed, observed_of_rve};
use crate::rve::{PointRve, Scratch};

/// What a row of a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i64)]
pub enum Kind {
    /// A point of the continuum.
    Point = 0,
    /// A grain that is not glued.
    Grain = 1,
    /// A grain glued to a plate.
    Glued = 2,
    /// A vertex of a membrane.
    Membrane = 3,
}

/// One grain or point as a picture needs it; SI units, third components zero in the plane.
#[derive(Clone, Debug, Default)]
struct Row {
    kind: i64,
    id: u64,
    position: [f64; 3],
    radius: f64,
    weight: f64,
    /// kg; zero of vertices of membranes.
    mass: f64,
    displacement: [f64; 3],
    /// Periods that it has gone.
    image: Image,
    velocity: [f64; 3],
    /// rad/s.
    spin: [f64; 3],
    /// Cauchy stress xx, yy, xy and in space zz, yz, xz, Pa; of a grain its Love-Weber mean over its share of space.
    stress: [f64; 6],
    /// Of points as those around them have it on the mean ([`crate::domain::means`]); of all others their own.
    stress_averaged: [f64; 6],
    /// Contacts that bear force; none of points.
    coordination: i64,
    /// What [`OBSERVED`] names; of grains what [`OBSERVED_OF_GRAINS`] does, p and q.
    observed: [f64; OBSERVED.len()],
    /// What [`OBSERVED_OF_RVES`] names, of points that carry grains.
    of_rve: [f64; OBSERVED_OF_RVES.len()],
}

impl Record for Row {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.i64("kind", &mut self.kind);
        visitor.u64("id", &mut self.id);
        visitor.f64s("position", &mut self.position);
        visitor.f64s("radius", std::slice::from_mut(&mut self.radius));
        visitor.f64s("weight", std::slice::from_mut(&mut self.weight));
        visitor.f64s("mass", std::slice::from_mut(&mut self.mass));
        visitor.f64s("displacement", &mut self.displacement);
        visit_image::<Solid>(&mut self.image, visitor);
        visitor.f64s("velocity", &mut self.velocity);
        visitor.f64s("spin", &mut self.spin);
        visitor.f64s("stress", &mut self.stress);
        visitor.f64s("stress_averaged", &mut self.stress_averaged);
        visitor.i64("coordination", &mut self.coordination);
        visitor.f64s("observed", &mut self.observed);
        visitor.f64s("of_rve", &mut self.of_rve);
    }
}

impl Cargo for Row {
    fn blank() -> Self {
        Self::default()
    }
}

/// Bytes of a row in a file before they are compressed, at most: place, number, offset, and the fields.
pub const BYTES_PER_ROW: usize = 8 * (3 + 2 + 2 + 3 + 9 + 12 + 1 + OBSERVED.len() + OBSERVED_OF_RVES.len());

/// Which of [`OBSERVED`] a frame of grains alone has: strains, rotation, and plastic strain, which is zero.
const OBSERVED_OF_GRAINS: [usize; 4] = [3, 4, 5, 7];

pub(super) fn spread<V: Linear>(vector: &V) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < V::COMPONENTS { vector[axis] } else { 0.0 })
}

/// About z in the plane.
fn spread_spin<V: Linear>(spin: &V) -> [f64; 3] {
    if V::COMPONENTS == 1 { [0.0, 0.0, spin[0]] } else { spread(spin) }
}

/// Components in the order of a [`Row`], the shear ones of the symmetric part.
fn symmetric<S: Space>(tensor: &S::Tensor) -> [f64; 6] {
    let entry = |i: usize, j: usize| {
        let inside = i < S::DIMENSION && j < S::DIMENSION;
        let at = |row: usize, column: usize| tensor[column * S::DIMENSION + row];
        if inside { 0.5 * (at(i, j) + at(j, i)) } else { 0.0 }
    };
    [entry(0, 0), entry(1, 1), entry(0, 1), entry(2, 2), entry(1, 2), entry(0, 2)]
}

/// Displacement across periods, m.
fn displacement<S: Space>(position: &S::Vector, origin: &S::Vector, image: Image, cell: &Cell<S>) -> [f64; 3] {
    spread(&(*position - *origin + cell.shift(image)))
}

/// The world as it is; `depth` in m, `fraction` the solid volume fraction that gives a grain its share of space. All frames of a
/// run have the same fields: those of points where it `may_have_points`.
pub fn frame<S: Space>(
    world: &mut World<S>,
    depth: f64,
    fraction: f64,
    may_have_points: bool,
) -> Result<Option<Frame>, Error> {
    world.refresh_ghosts();
    let told = if may_have_points { (0..OBSERVED.len()).collect() } else { OBSERVED_OF_GRAINS.to_vec() };
    let rows = (world.grains_total + world.points_total) as usize + world.continuum.membranes.vertices.len();
    let has_rves = world.settings.rves.is_some();
    let mut drawn = Drawing { positions: Vec::new(), fields: fields::<S>(told, may_have_points, has_rves) };
    // Grains and points apart: along the ranks either is in the order of the curve, the two mixed would not be. And one after the
    // other, points in pieces, for rank 0 may not have room for all these rows beside the frame.
    if let Some(mut grains) = transfer::gather(world.transport, grain_rows(world, depth, fraction))? {
        drawn.reserve(rows);
        let positions = settle_grains(&mut grains, &world.assembly.cell, !world.settings.grains.drive.is_at_rest());
        drawn.add(&grains, positions);
    }
    let averaged = if world.points_total > 0 { averaged_stresses(world) } else { Vec::new() };
    let place = |row: &Row| wrapped::<S>(row, &world.assembly.cell).1;
    let pieces = |rows| point_rows(world, &averaged, rows, depth);
    transfer::stream(world.transport, PIECE_ROWS, world.continuum.points.len(), pieces, |points| {
        drawn.add(&points, points.iter().map(place));
        Ok(())
    })?;
    if world.transport.rank() > 0 {
        return Ok(None);
    }
    let vertices = vertex_rows(world);
    drawn.add(&vertices, vertices.iter().map(place));
    let (positions, fields) = (drawn.positions, drawn.fields.into_iter().map(Field::column).collect());
    let whole = of_cell(&world.assembly.cell, depth);
    Ok(Some(Frame { time: world.time(), drawn: Drawn::Points, positions, fields, whole }))
}

/// A frame that rows are added to.
struct Drawing {
    positions: Vec<[f64; 3]>,
    fields: Vec<Field>,
}

/// The name of a field, its values, and what of a row goes into it.
enum Field {
    Whole(&'static str, Vec<i64>, fn(&Row) -> i64),
    /// Numbers of a row from one to another.
    Numbers(&'static str, Vec<f64>, fn(&Row) -> &[f64], Range<usize>),
}

impl Drawing {
    fn reserve(&mut self, rows: usize) {
        self.positions.reserve_exact(rows);
        for field in &mut self.fields {
            match field {
                Field::Whole(_, values, _) => values.reserve_exact(rows),
                Field::Numbers(_, values, _, wanted) => values.reserve_exact(rows * wanted.len()),
            }
        }
    }

    fn add(&mut self, rows: &[Row], positions: impl IntoIterator<Item = [f64; 3]>) {
        self.positions.extend(positions);
        for field in &mut self.fields {
            match field {
                Field::Whole(_, values, of) => values.extend(rows.iter().map(*of)),
                Field::Numbers(_, values, of, wanted) => {
                    rows.iter().for_each(|row| values.extend(&of(row)[wanted.clone()]));
                }
            }
        }
    }
}

impl Field {
    fn column(self) -> Column {
        let (name, width, values) = match self {
            Self::Whole(name, values, _) => (name, 1, Values::I64(values)),
            Self::Numbers(name, values, _, wanted) => (name, wanted.len(), Values::F64(values)),
        };
        Column { name: name.to_string(), width, values }
    }
}

/// The fields of a frame, of [`OBSERVED`] those that are `told`.
fn fields<S: Space>(told: Vec<usize>, may_have_points: bool, has_rves: bool) -> Vec<Field> {
    let whole = |name, of| Field::Whole(name, Vec::new(), of);
    let numbers = |name, wanted, of| Field::Numbers(name, Vec::new(), of, wanted);
    let stresses = if S::DIMENSION == 2 { 3 } else { 6 };
    let mut fields = vec![
        whole("kind", |row| row.kind),
        whole("id", |row| row.id as i64),
        numbers("radius", 0..1, |row| std::slice::from_ref(&row.radius)),
        numbers("weight", 0..1, |row| std::slice::from_ref(&row.weight)),
        numbers("mass", 0..1, |row| std::slice::from_ref(&row.mass)),
        numbers("displacement", 0..3, |row| &row.displacement),
        numbers("velocity", 0..3, |row| &row.velocity),
        numbers("spin", 0..3, |row| &row.spin),
        numbers("stress", 0..stresses, |row| &row.stress),
    ];
    // Of RVEs it is a mean.
    if !has_rves {
        fields.push(whole("coordination", |row| row.coordination));
    }
    if may_have_points {
        fields.push(numbers("stress_averaged", 0..stresses, |row| &row.stress_averaged));
    }
    fields.extend(told.into_iter().map(|which| numbers(OBSERVED[which], which..which + 1, |row| &row.observed)));
    if has_rves {
        let names = OBSERVED_OF_RVES.iter().enumerate();
        fields.extend(names.map(|(which, name)| numbers(name, which..which + 1, |row| &row.of_rve)));
    }
    fields
}

/// The cell as it is: its corner and edges, one after the other, m, and along which of them it is periodic. In the plane it
/// is as thick as `depth`, with the plane in its middle.
fn of_cell<S: Space>(cell: &Cell<S>, depth: f64) -> Vec<Column> {
    let (mut corner, mut edges) = (spread(&cell.corner), [0.0; 9]);
    for column in 0..S::DIMENSION {
        for row in 0..S::DIMENSION {
            edges[3 * column + row] = cell.edges[column * S::DIMENSION + row];
        }
    }
    if S::DIMENSION == 2 {
        (corner[2], edges[8]) = (-0.5 * depth, depth);
    }
    let periodic: [bool; 3] = std::array::from_fn(|axis| axis < S::DIMENSION && cell.periodic[axis]);
    let column = |name: &str, values: Vec<f64>| Column {
        name: name.to_string(),
        width: values.len(),
        values: Values::F64(values),
    };
    vec![
        column("cell_corner", corner.to_vec()),
        column("cell_edges", edges.to_vec()),
        column("cell_periodic", periodic.map(|is| f64::from(u8::from(is))).to_vec()),
    ]
}

fn gathered<S: Space>(components: &[f64; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    (0..S::DIMENSION).for_each(|axis| vector[axis] = components[axis]);
    vector
}

/// The image of a row inside the cell: periods it was taken back by, where it is, and its velocity, which is another where the cell deforms.
fn wrapped<S: Space>(row: &Row, cell: &Cell<S>) -> (Image, [f64; 3], [f64; 3]) {
    let (mut position, mut velocity) = (gathered::<S>(&row.position), gathered::<S>(&row.velocity));
    let image = cell.wrap(&mut position, &mut velocity);
    (image, spread(&position), spread(&velocity))
}

/// Reckons what takes all grains to know, and returns where they are inside the cell.
fn settle_grains<S: Space>(rows: &mut [Row], cell: &Cell<S>, deforms: bool) -> Vec<[f64; 3]> {
    let images: Vec<_> = rows.iter().map(|row| wrapped(row, cell)).collect();
    rows.iter_mut().zip(&images).for_each(|(row, (.., velocity))| row.velocity = *velocity);
    let place = |(row, (image, position, _)): (&Row, &(Image, [f64; 3], [f64; 3]))| Place::<S> {
        position: gathered::<S>(position),
        displacement: gathered::<S>(&row.displacement),
        image: std::array::from_fn(|axis| row.image[axis] + image[axis]),
        radius: row.radius,
    };
    let places: Vec<Place<S>> = rows.iter().zip(&images).map(place).collect();
    for (row, found) in rows.iter_mut().zip(best_fit_deformations(&places, cell, deforms)) {
        if let Some(gradient) = found {
            let strain = Deformation::of::<S>(&gradient);
            row.observed[3..6].copy_from_slice(&[strain.volumetric, strain.deviatoric, strain.rotation_angle]);
        }
    }
    images.into_iter().map(|(_, position, _)| position).collect()
}

fn grain_rows<S: Space>(world: &World<S>, depth: f64, fraction: f64) -> Vec<Row> {
    let (grains, law, times) = (&world.assembly.grains, world.law(), world.contact_times());
    let on_bodies: Vec<Bearing<S>> =
        world.assembly.walls.bearings(law, grains, (&world.bodies, &world.assembly.cell), times).collect();
    let row = |row: usize| {
        let (hot, cold) = (&grains.hot[row], &grains.cold[row]);
        let first = on_bodies.partition_point(|bearing| (bearing.row as usize) < row);
        let on_bodies = on_bodies[first..].iter().take_while(|bearing| bearing.row as usize == row).copied();
        let (mut moment, mut coordination) = (S::Tensor::zero(), 0);
        for bearing in world.assembly.contacts.bearings(law, grains, row, times).chain(on_bodies) {
            moment += bearing.moment();
            coordination += 1;
        }
        let space = S::grain_volume(hot.radius, depth) / fraction;
        let stress = moment * (1.0 / space);
        let invariants = StressInvariants::of::<S>(&stress);
        let mut observed = [0.0; OBSERVED.len()];
        [observed[0], observed[1]] = [invariants.mean, invariants.deviatoric];
        let glued = matches!(cold.mover, Mover::Body(_));
        Row {
            kind: if glued { Kind::Glued } else { Kind::Grain } as i64,
            id: cold.id.0,
            position: spread(&hot.position),
            radius: hot.radius,
            weight: if glued { 1.0 } else { hot.weight },
            mass: hot.mass,
            displacement: displacement(&hot.position, &cold.origin, cold.image, &world.assembly.cell),
            image: cold.image,
            velocity: spread(&hot.velocity),
            spin: spread_spin(&hot.spin),
            stress: symmetric::<S>(&stress),
            stress_averaged: symmetric::<S>(&stress),
            coordination,
            observed,
            of_rve: Default::default(),
        }
    };
    (0..grains.owned).map(row).collect()
}

/// Vertices of membranes, as discs of half a segment at rest.
fn vertex_rows<S: Space>(world: &World<S>) -> Vec<Row> {
    let row = |(number, vertex): (usize, &Vertex<S>)| Row {
        kind: Kind::Membrane as i64,
        id: number as u64,
        position: spread(&vertex.position),
        radius: 0.25 * world.continuum.membranes.of(vertex).rest,
        weight: 1.0,
        displacement: spread(&(vertex.position - vertex.origin)),
        velocity: spread(&vertex.velocity),
        ..Row::default()
    };
    world.continuum.membranes.vertices.iter().enumerate().map(row).collect()
}

/// Cauchy stress of points as it is, Pa.
fn cauchy<S: Space>(hot: &Hot<S>) -> [f64; 6] {
    symmetric::<S>(&(hot.kirchhoff() * (1.0 / hot.volume_ratio())))
}

/// One, and the mean Cauchy stress of the points around each point, Pa; of elements their own.
fn averaged_stresses<S: Space>(world: &mut World<S>) -> Vec<[f64; 7]> {
    let own = |hot: &Hot<S>| {
        let [xx, yy, xy, zz, yz, xz] = cauchy(hot);
        [1.0, xx, yy, xy, zz, yz, xz]
    };
    match world.has_grid() {
        true => averaged(world, |_, hot| own(hot)),
        false => world.continuum.points.hot.iter().map(own).collect(),
    }
}

fn point_rows<S: Space>(world: &World<S>, averaged: &[[f64; 7]], rows: Range<usize>, depth: f64) -> Vec<Row> {
    let row = |((hot, cold), [_, averaged @ ..]): ((&Hot<S>, &Cold<S>), &[f64; 7])| Row {
        kind: Kind::Point as i64,
        id: cold.id.0,
        position: spread(&hot.position),
        // The disc or sphere of the point's volume; `grain_volume` grows with the radius to the power of the dimension.
        radius: {
            let share = hot.volume * hot.volume_ratio() / S::grain_volume(1.0, depth);
            if S::DIMENSION == 2 { share.sqrt() } else { math::cbrt(share) }
        },
        weight: hot.weight,
        mass: hot.mass,
        displacement: displacement(&hot.position, &cold.origin, cold.image, &world.assembly.cell),
        image: cold.image,
        velocity: spread(&hot.velocity),
        spin: [0.0; 3],
        coordination: 0,
        stress: cauchy(hot),
        stress_averaged: *averaged,
        observed: observed(&*world.settings.material, hot),
        of_rve: Default::default(),
    };
    let points = &world.continuum.points;
    let of_points = points.hot[rows.clone()].iter().zip(&points.cold[rows.clone()]).zip(&averaged[rows.clone()]);
    let mut told: Vec<Row> = of_points.map(row).collect();
    // Where points carry grains, every one has some.
    let rves = world.rves.get(rows).unwrap_or_default();
    let look = |scratch: &mut Scratch<S>, carried: &PointRve<S>| observed_of_rve(&carried.rve, scratch);
    let of_rves: Vec<_> = rves.par_iter().map_init(Scratch::default, look).collect();
    told.iter_mut().zip(of_rves).for_each(|(row, of_rve)| row.of_rve = of_rve);
    told
}
