//! Frames: grains and points of the whole world as rows for pictures, on rank 0.

use scree_io::column::{Column, Values};
use scree_io::frames::Frame;

use crate::dem::cell::{Cell, Image};
use crate::dem::grains::Mover;
use crate::error::Error;
use crate::law::contact::ContactLaw;
use crate::law::material::MaterialLaw;
use crate::math;
use crate::mpm::points::{Cold, Hot};
use crate::observe::point::{OBSERVED, observed};
use crate::record::{Record, Visitor};
use crate::space::{Linear, Space};
use crate::transfer::{self, Cargo};
use crate::world::World;

/// What a row of a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i64)]
pub enum Kind {
    Point = 0,
    Grain = 1,
    /// A grain glued to a plate.
    Glued = 2,
}

/// One grain or point as a picture needs it; SI units, third components zero in the plane.
#[derive(Clone, Debug, Default)]
struct Row {
    kind: i64,
    id: u64,
    position: [f64; 3],
    radius: f64,
    weight: f64,
    displacement: [f64; 3],
    velocity: [f64; 3],
    /// rad/s.
    spin: [f64; 3],
    /// Cauchy stress xx, yy, xy and in space zz, yz, xz, Pa; of a grain its Love-Weber mean over its share of space.
    stress: [f64; 6],
    /// What [`OBSERVED`] names; zero for grains.
    observed: [f64; OBSERVED.len()],
}

impl Record for Row {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.i64("kind", &mut self.kind);
        visitor.u64("id", &mut self.id);
        visitor.f64s("position", &mut self.position);
        visitor.f64s("radius", std::slice::from_mut(&mut self.radius));
        visitor.f64s("weight", std::slice::from_mut(&mut self.weight));
        visitor.f64s("displacement", &mut self.displacement);
        visitor.f64s("velocity", &mut self.velocity);
        visitor.f64s("spin", &mut self.spin);
        visitor.f64s("stress", &mut self.stress);
        visitor.f64s("observed", &mut self.observed);
    }
}

impl Cargo for Row {
    fn blank() -> Self {
        Self::default()
    }
}

fn spread<V: Linear>(vector: &V) -> [f64; 3] {
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

/// The world as it is; `depth` in m, `fraction` the packing fraction that gives a grain its share of space. All frames of a
/// run have the same fields: those of points where it `may_have_points`.
pub fn frame<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>>(
    world: &mut World<S, C, L>,
    depth: f64,
    fraction: f64,
    may_have_points: bool,
) -> Result<Option<Frame>, Error> {
    world.refresh_ghosts();
    // Grains and points apart: along the ranks either is in the order of the curve, the two mixed would not be.
    let grains = transfer::gather(world.transport, grain_rows(world, depth, fraction))?;
    let points = transfer::gather(world.transport, point_rows(world, depth))?;
    let (Some(mut rows), Some(points)) = (grains, points) else { return Ok(None) };
    rows.extend(points);
    let wrapped = |row: &Row| {
        let mut position = S::Vector::zero();
        for axis in 0..S::DIMENSION {
            position[axis] = row.position[axis];
        }
        world.cell.wrap(&mut position, &mut S::Vector::zero());
        spread(&position)
    };
    let numbers = |width: usize, name: &str, get: &dyn Fn(&Row) -> Vec<f64>| Column {
        name: name.to_string(),
        width,
        values: Values::F64(rows.iter().flat_map(get).collect()),
    };
    let whole = |name: &str, get: &dyn Fn(&Row) -> i64| Column {
        name: name.to_string(),
        width: 1,
        values: Values::I64(rows.iter().map(get).collect()),
    };
    let stresses = if S::DIMENSION == 2 { 3 } else { 6 };
    // Grains alone have the last of them, for one.
    let told = if may_have_points { 0..OBSERVED.len() } else { OBSERVED.len() - 1..OBSERVED.len() };
    let mut fields = vec![
        whole("kind", &|row| row.kind),
        whole("id", &|row| row.id as i64),
        numbers(1, "radius", &|row| vec![row.radius]),
        numbers(1, "weight", &|row| vec![row.weight]),
        numbers(3, "displacement", &|row| row.displacement.to_vec()),
        numbers(3, "velocity", &|row| row.velocity.to_vec()),
        numbers(3, "spin", &|row| row.spin.to_vec()),
        numbers(stresses, "stress", &|row| row.stress[..stresses].to_vec()),
    ];
    fields.extend(told.map(|which| numbers(1, OBSERVED[which], &|row| vec![row.observed[which]])));
    Ok(Some(Frame { time: world.time(), positions: rows.iter().map(wrapped).collect(), fields }))
}

fn grain_rows<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>>(
    world: &World<S, C, L>,
    depth: f64,
    fraction: f64,
) -> Vec<Row> {
    let grains = &world.grains;
    let row = |row: usize| {
        let (hot, cold) = (&grains.hot[row], &grains.cold[row]);
        let moment = world.contacts.moment(&world.settings.contact, grains, row);
        let space = S::grain_volume(hot.radius, depth) / fraction;
        let glued = matches!(cold.mover, Mover::Body(_));
        Row {
            kind: if glued { Kind::Glued } else { Kind::Grain } as i64,
            id: cold.id.0,
            position: spread(&hot.position),
            radius: hot.radius,
            weight: if glued { 1.0 } else { hot.weight },
            displacement: displacement(&hot.position, &cold.origin, cold.image, &world.cell),
            velocity: spread(&hot.velocity),
            spin: spread_spin(&hot.spin),
            stress: symmetric::<S>(&(moment * (1.0 / space))),
            observed: [0.0; OBSERVED.len()],
        }
    };
    (0..grains.owned).map(row).collect()
}

fn point_rows<S: Space, C: ContactLaw<S>, L: MaterialLaw<S>>(world: &World<S, C, L>, depth: f64) -> Vec<Row> {
    let row = |(hot, cold): (&Hot<S, L::Memory>, &Cold<S>)| Row {
        kind: Kind::Point as i64,
        id: cold.id.0,
        position: spread(&hot.position),
        // The disc or sphere of the point's volume; `grain_volume` grows with the radius to the power of the dimension.
        radius: {
            let share = hot.volume * hot.volume_ratio() / S::grain_volume(1.0, depth);
            if S::DIMENSION == 2 { share.sqrt() } else { math::cbrt(share) }
        },
        weight: hot.weight,
        displacement: displacement(&hot.position, &cold.origin, cold.image, &world.cell),
        velocity: spread(&hot.velocity),
        spin: [0.0; 3],
        stress: symmetric::<S>(&(hot.kirchhoff() * (1.0 / hot.volume_ratio()))),
        observed: observed(&world.settings.material, hot),
    };
    world.points.hot.iter().zip(&world.points.cold).map(row).collect()
}
