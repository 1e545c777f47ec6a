//! Frames: grains and points of the whole world as rows for pictures, on rank 0.

use scree_io::column::{Column, Values};
use scree_io::frames::Frame;

use crate::dem::grains::Mover;
use crate::error::Error;
use crate::law::material::MaterialMemory;
use crate::math::PI;
use crate::packing::PlanarWorld;
use crate::record::{Record, Visitor};
use crate::space::{Plane, Space};
use crate::transfer::{self, Cargo};

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
    /// Cauchy stress xx, yy, xy, Pa; of a grain its Love-Weber mean over its share of space.
    stress: [f64; 3],
    plastic_strain: f64,
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
        visitor.f64s("stress", &mut self.stress);
        visitor.f64s("plastic_strain", std::slice::from_mut(&mut self.plastic_strain));
    }
}

impl Cargo for Row {
    fn blank() -> Self {
        Self::default()
    }
}

type Vector = <Plane as Space>::Vector;

fn spread(vector: &Vector) -> [f64; 3] {
    [vector[0], vector[1], 0.0]
}

/// Displacement across periods, m.
fn displacement(position: &Vector, origin: &Vector, image: i64, period: f64) -> [f64; 3] {
    let moved = *position - *origin;
    [moved[0] + image as f64 * period, moved[1], 0.0]
}

/// The world as it is; `depth` in m, `fraction` the packing fraction that gives a grain its share of space.
pub fn frame(world: &mut PlanarWorld, depth: f64, fraction: f64) -> Result<Option<Frame>, Error> {
    world.refresh_ghosts();
    // Grains and points apart: along the ranks either is in the order of the curve, the two mixed would not be.
    let grains = transfer::gather(world.transport, grain_rows(world, depth, fraction))?;
    let points = transfer::gather(world.transport, point_rows(world, depth))?;
    let (Some(mut rows), Some(points)) = (grains, points) else { return Ok(None) };
    rows.extend(points);
    let wrapped = |row: &Row| {
        let mut position = Vector::new(row.position[0], row.position[1]);
        crate::rebuild::wrap::<Plane>(&mut position, world.layout.period());
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
    let fields = vec![
        whole("kind", &|row| row.kind),
        whole("id", &|row| row.id as i64),
        numbers(1, "radius", &|row| vec![row.radius]),
        numbers(1, "weight", &|row| vec![row.weight]),
        numbers(3, "displacement", &|row| row.displacement.to_vec()),
        numbers(3, "velocity", &|row| row.velocity.to_vec()),
        numbers(3, "stress", &|row| row.stress.to_vec()),
        numbers(1, "plastic_strain", &|row| vec![row.plastic_strain]),
    ];
    Ok(Some(Frame { time: world.time(), positions: rows.iter().map(wrapped).collect(), fields }))
}

fn grain_rows(world: &PlanarWorld, depth: f64, fraction: f64) -> Vec<Row> {
    let grains = &world.grains;
    let row = |(row, (hot, cold)): (usize, (&crate::dem::grains::Hot<Plane>, &crate::dem::grains::Cold<Plane>))| {
        let moment = world.contacts.moment(&world.settings.contact, grains, row);
        let space = Plane::grain_volume(hot.radius, depth) / fraction;
        Row {
            kind: if matches!(cold.mover, Mover::Body(_)) { Kind::Glued } else { Kind::Grain } as i64,
            id: cold.id.0,
            position: spread(&hot.position),
            radius: hot.radius,
            weight: hot.weight,
            displacement: displacement(&hot.position, &cold.origin, cold.image, world.layout.period()),
            velocity: spread(&hot.velocity),
            stress: [moment[0] / space, moment[3] / space, 0.5 * (moment[1] + moment[2]) / space],
            plastic_strain: 0.0,
        }
    };
    grains.hot[..grains.owned].iter().zip(&grains.cold).enumerate().map(row).collect()
}

fn point_rows(world: &PlanarWorld, depth: f64) -> Vec<Row> {
    let row = |point: &crate::checkpoint::PlanarPoint| Row {
        kind: Kind::Point as i64,
        id: point.id.0,
        position: spread(&point.position),
        radius: (point.volume * point.volume_ratio / (PI * depth)).sqrt(),
        weight: point.weight,
        displacement: displacement(&point.position, &point.origin, point.image, world.layout.period()),
        velocity: spread(&point.velocity),
        stress: [point.stress[0], point.stress[3], point.stress[2]].map(|tau| tau / point.volume_ratio),
        plastic_strain: point.memory.plastic_strain(),
    };
    world.points.iter().map(row).collect()
}
