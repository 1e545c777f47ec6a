//! The mesh of a job, and which sides of its elements bear which loads.

use super::figures::indices;
use super::{Face, Mpm};
use crate::base::ids::{NodeId, PointId};
use crate::base::space::{Linear, Plane, Solid, Space};
use crate::fem::elements::LoadedSide;
use crate::fem::mesh::{Lattice, Mesh, key_of_side};
use crate::fem::side::{FACE_CORNERS, Side};

/// The elements that are in a region, of a box or of a file.
pub fn mesh<S: Space>(job: &Mpm) -> Mesh<S> {
    let all = indices(job.places().map(|count| 0..count)).filter(|index| job.region_of(*index).is_some());
    if let Some(drawn) = job.drawn() {
        let place = |vertex: &[f64; 3]| {
            let mut place = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| place[axis] = vertex[axis]);
            place
        };
        let nodes = (0..drawn.vertices.len() as u64).map(NodeId).collect();
        let (points, elements) = all.map(|[at, ..]| (PointId(at as u64), drawn.elements[at])).unzip();
        return Mesh::new(drawn.vertices.iter().map(place).collect(), nodes, elements, points);
    }
    let lattice = Lattice {
        lower: job.grid.lower,
        edges: [0, 1, 2].map(|axis| job.edge(axis)),
        cells: job.grid.cells,
        periodic: job.grid.periodic,
    };
    Mesh::of_lattice(&lattice, all.map(|index| (PointId(job.number(index)), index)))
}

/// Groups of the file that the sides at each vertex are in; nothing of a box.
pub fn groups(job: &Mpm) -> Vec<u32> {
    let Some(drawn) = job.drawn() else { return Vec::new() };
    let mut groups = vec![0; drawn.vertices.len()];
    for (vertices, bits) in &drawn.sides {
        vertices.iter().filter(|vertex| **vertex != u64::MAX).for_each(|vertex| groups[*vertex as usize] |= bits);
    }
    groups
}

/// Sides with nothing beyond them that are in the group of a load or look the way of its face, and whose element has its middle in the window.
pub fn loaded<S: Space>(job: &Mpm, mesh: &Mesh<S>, bare: &[(u32, Side)]) -> Vec<LoadedSide> {
    let groups_of = |(element, side): (u32, Side)| {
        let of = &mesh.elements[element as usize];
        let key = key_of_side::<S>(side, |corner| u64::from(of[corner]));
        job.drawn().and_then(|drawn| drawn.sides.get(&key)).copied().unwrap_or_default()
    };
    let bits: Vec<Option<u32>> =
        job.loads.iter().map(|load| Some(job.drawn()?.bits_of(load.group.as_ref()?))).collect();
    let mut loaded = Vec::new();
    for (element, side) in bare.iter().copied() {
        let middle = mesh.middle_of(element as usize);
        let groups = groups_of((element, side));
        for (load, of) in job.loads.iter().enumerate() {
            let inside = (0..S::DIMENSION).all(|axis| (of.lower[axis]..=of.upper[axis]).contains(&middle[axis]));
            let bears = match bits[load] {
                Some(bits) => groups & bits != 0,
                None => looks_along(mesh, (element, side), of.face),
            };
            if inside && bears {
                loaded.push(LoadedSide { element, side, load });
            }
        }
    }
    loaded
}

/// Whether a side looks along the normal of a face more than along any other axis.
fn looks_along<S: Space>(mesh: &Mesh<S>, of: (u32, Side), face: Face) -> bool {
    let area = area_of(mesh, of, 1.0);
    let along = if face.upper { area[face.axis] } else { -area[face.axis] };
    (0..S::DIMENSION).all(|axis| axis == face.axis || area[axis].abs() < along)
}

/// Whether any element that has material has a side in these groups.
pub fn has_group(job: &Mpm, bits: u32) -> bool {
    match job.grid.dimension {
        2 => has_group_in::<Plane>(job, bits),
        _ => has_group_in::<Solid>(job, bits),
    }
}

fn has_group_in<S: Space>(job: &Mpm, bits: u32) -> bool {
    let Some(drawn) = job.drawn() else { return false };
    let mut elements = drawn.elements.iter().enumerate().filter(|(at, _)| job.region_of([*at, 0, 0]).is_some());
    elements.any(|(_, of)| {
        let groups = |side| drawn.sides.get(&key_of_side::<S>(side, |corner| u64::from(of[corner])));
        Side::all(S::DIMENSION).filter_map(groups).any(|groups| groups & bits != 0)
    })
}

/// Sides that bear each load, and their area, m2.
pub fn bearing(job: &Mpm) -> Vec<(usize, f64)> {
    match job.grid.dimension {
        2 => bearing_in::<Plane>(job),
        _ => bearing_in::<Solid>(job),
    }
}

fn bearing_in<S: Space>(job: &Mpm) -> Vec<(usize, f64)> {
    let mesh = mesh::<S>(job);
    let mut found = vec![(0, 0.0); job.loads.len()];
    for LoadedSide { element, side, load } in loaded(job, &mesh, &mesh.bare_faces()) {
        let (count, area) = &mut found[load];
        *count += 1;
        *area += area_of(&mesh, (element, side), job.grid.depth).norm();
    }
    found
}

/// Area vector of a side out of its element, m2.
fn area_of<S: Space>(mesh: &Mesh<S>, (element, side): (u32, Side), depth: f64) -> S::Vector {
    let areas = side.areas::<S>(&mesh.places_of(element as usize), depth);
    areas[..FACE_CORNERS[S::DIMENSION - 2]].iter().fold(S::Vector::zero(), |sum, area| sum + *area)
}
