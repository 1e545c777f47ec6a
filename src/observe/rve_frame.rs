//! An RVE as pictures: its grains, and the contacts that bear force as lines, force chains.
//!
//! Places are in the frame of its point's deformation gradient, from the corner of the cell on. A line goes from the centre of the grain with
//! the lower id to that of its partner, or of the partner's image across the period; over the lines, the sum of force x (end - begin) over the
//! volume is the mean stress, tension positive, force being that on the grain where a line begins.

use scree_io::column::{Column, Values};
use scree_io::frames::{Drawn, Frame};

use crate::base::error::Error;
use crate::base::ids::PointId;
use crate::base::space::{Linear, Space};
use crate::domain::transfer;
use crate::domain::world::World;
use crate::observe::frame::spread;
use crate::rve::{Bearing, Rve, RveRow, Scratch};

fn whole(name: &str, values: Vec<i64>) -> Column {
    Column { name: name.into(), width: 1, values: Values::I64(values) }
}

fn numbers(name: &str, width: usize, values: Vec<f64>) -> Column {
    Column { name: name.into(), width, values: Values::F64(values) }
}

/// Its grains at a time, s, with their contacts that bear.
pub fn grains<S: Space>(rve: &Rve<S>, time: f64, scratch: &mut Scratch<S>) -> Frame {
    let (places, radii) = rve.places();
    let mut coordination = vec![0i64; places.len()];
    for bearing in rve.bearings(scratch) {
        bearing.grains.iter().for_each(|grain| coordination[*grain as usize] += 1);
    }
    let ids = (0..places.len() as i64).collect();
    Frame {
        time,
        drawn: Drawn::Points,
        positions: places.iter().map(spread).collect(),
        fields: vec![whole("id", ids), numbers("radius", 1, radii), whole("coordination", coordination)],
        whole: vec![numbers("cell_edges", 9, edges(rve))],
    }
}

/// Grains and contacts of the RVEs of points as they are, in the order of the points; on rank 0, and none on others. Collective.
pub fn of_points<S: Space>(world: &World<S>, points: &[PointId]) -> Result<Option<Vec<Frame>>, Error> {
    let Some(material) = world.settings.rves.as_ref().filter(|_| !points.is_empty()) else {
        return Ok(None);
    };
    let cold = &world.continuum.points.cold;
    let own = cold.iter().zip(&world.rves).filter(|(cold, _)| points.contains(&cold.id));
    let own: Vec<RveRow<S>> = own.map(|(cold, carried)| carried.rest(cold.id)).collect();
    let Some(rows) = transfer::gather(world.transport, own)? else { return Ok(None) };
    let (time, scratch) = (world.time(), &mut Scratch::default());
    let mut frames = Vec::with_capacity(2 * points.len());
    for point in points {
        let found = rows.iter().find(|row| row.point == *point);
        let row = found.ok_or_else(|| Error::Run(format!("point {}, which is followed, is not there", point.0)))?;
        let rve = row.wake(material, S::identity())?.rve;
        frames.extend([grains(&rve, time, scratch), contacts(&rve, time, scratch)]);
    }
    Ok(Some(frames))
}

/// Contacts that bear force.
pub fn contacts<S: Space>(rve: &Rve<S>, time: f64, scratch: &mut Scratch<S>) -> Frame {
    let bearings = rve.bearings(scratch);
    let id = |side: usize| bearings.iter().map(|bearing| i64::from(bearing.grains[side])).collect();
    let part = |bearing: &Bearing<S>| {
        let normal = (bearing.begin - bearing.end) * (1.0 / (bearing.begin - bearing.end).norm());
        let pushing = bearing.force.dot(&normal);
        [pushing, (bearing.force - normal * pushing).norm()]
    };
    // From where the grain is drawn.
    let places = rve.places().0;
    let ends = |bearing: &Bearing<S>| {
        let begin = places[bearing.grains[0] as usize];
        [spread(&begin), spread(&(begin + (bearing.end - bearing.begin)))]
    };
    let parts: Vec<[f64; 2]> = bearings.iter().map(part).collect();
    Frame {
        time,
        drawn: Drawn::Lines,
        positions: bearings.iter().flat_map(ends).collect(),
        fields: vec![
            whole("lower", id(0)),
            whole("higher", id(1)),
            numbers("force_normal", 1, parts.iter().map(|part| part[0]).collect()),
            numbers("force_tangential", 1, parts.iter().map(|part| part[1]).collect()),
            numbers("force", 3, bearings.iter().flat_map(|bearing| spread(&bearing.force)).collect()),
        ],
        whole: Vec::new(),
    }
}

/// Edges of the cell, one after the other, m.
fn edges<S: Space>(rve: &Rve<S>) -> Vec<f64> {
    let cell = rve.edges();
    let mut edges = vec![0.0; 9];
    for column in 0..S::DIMENSION {
        for row in 0..S::DIMENSION {
            edges[3 * column + row] = cell[column * S::DIMENSION + row];
        }
    }
    edges
}
