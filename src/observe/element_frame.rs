//! Elements as pictures: in the plane each as a quadrilateral, in space the sides of elements that belong to one alone, which is what one sees of a body.
//! A row has what the frame of points has of the point of its element.

use std::collections::BTreeMap;

use scree_io::column::{Column, Values};
use scree_io::frames::{Drawn, Frame};

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::domain::elements::Meshed;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::fem::element::CORNERS_MAX;
use crate::fem::side::Side;
use crate::observe::frame::spread;

/// Fields of points that say nothing of an element.
const OF_POINTS: [&str; 6] = ["kind", "radius", "weight", "spin", "coordination", "stress_averaged"];
/// Corners of what is drawn.
const CORNERS: usize = 4;

/// Elements as they are, beside a frame of their points; on rank 0. Collective.
pub fn element_frame<S: Space>(world: &World<S>, points: Option<&Frame>) -> Result<Option<Frame>, Error> {
    let Some(meshed) = &world.settings.meshed else { return Ok(None) };
    let Some(nodes) = transfer::gather(world.transport, world.owned_nodes())? else { return Ok(None) };
    let points = points.expect("rank 0 has the frame of points");
    let mut displacements = vec![S::Vector::zero(); meshed.mesh.vertices.len()];
    nodes.iter().for_each(|node| displacements[node.id.0 as usize] = node.displacement);
    let rows = rows_of(points);
    let drawn = faces(meshed);
    let place = |(element, corner): (usize, usize)| {
        let vertex = meshed.mesh.elements[element][corner] as usize;
        spread(&(meshed.mesh.vertices[vertex] + displacements[meshed.mesh.node(element, corner).0 as usize]))
    };
    let corners = |(element, corners): &(usize, [usize; CORNERS])| corners.map(|corner| place((*element, corner)));
    let of_points: Vec<usize> =
        drawn.iter().map(|(element, _)| rows[&(meshed.mesh.points[*element].0 as i64)]).collect();
    let told = points.fields.iter().filter(|field| !OF_POINTS.contains(&field.name.as_str()));
    Ok(Some(Frame {
        time: points.time,
        drawn: Drawn::Quadrilaterals,
        positions: drawn.iter().flat_map(corners).collect(),
        fields: told.map(|field| picked(field, &of_points)).collect(),
        whole: Vec::new(),
    }))
}

/// What is drawn: an element, and corners of it.
fn faces<S: Space>(meshed: &Meshed<S>) -> Vec<(usize, [usize; CORNERS])> {
    if S::DIMENSION == 2 {
        return (0..meshed.mesh.elements.len()).map(|element| (element, [0, 1, 2, 3])).collect();
    }
    let corners =
        |side: Side| -> [usize; CORNERS] { std::array::from_fn(|corner| side.corners::<S>()[corner] % CORNERS_MAX) };
    meshed.sides_seen().iter().map(|(element, side)| (*element as usize, corners(*side))).collect()
}

/// Rows of a frame by the ids of its points.
fn rows_of(points: &Frame) -> BTreeMap<i64, usize> {
    let ids = points.fields.iter().find(|field| field.name == "id").expect("points have ids");
    let Values::I64(ids) = &ids.values else { unreachable!("ids are whole numbers") };
    ids.iter().copied().zip(0..).collect()
}

/// These rows of a field.
fn picked(field: &Column, rows: &[usize]) -> Column {
    let width = field.width;
    let values = match &field.values {
        Values::F64(values) => {
            Values::F64(rows.iter().flat_map(|row| values[row * width..(row + 1) * width].iter().copied()).collect())
        }
        Values::I64(values) => {
            Values::I64(rows.iter().flat_map(|row| values[row * width..(row + 1) * width].iter().copied()).collect())
        }
        Values::U64(_) | Values::U8(_) => unreachable!("frames have no other kind"),
    };
    Column { name: field.name.clone(), width, values }
}
