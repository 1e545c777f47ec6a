//! The mesh of a job of elements, and what of a world follows from it.

use std::sync::Arc;

use crate::base::ids::PointId;
use crate::base::space::{Linear, Space};
use crate::domain::elements::Meshed;
use crate::domain::layout::{Ground, Layout};
use crate::fem::element::{Element, corners, widened};
use crate::fem::elements::LoadedSide;
use crate::fem::mesh::{Lattice, Mesh};
use crate::fem::node::Node;
use crate::fem::side::{FACE_CORNERS, Side};
use crate::job::mpm::figures::indices;
use crate::job::mpm::{self, Mpm};
use crate::mpm::points::Point;
use crate::mpm::scheme::ShapeFunction;
use crate::prepare::grain_world::vector;

/// Whole blocks of elements, whatever their edges are: places are shares of the domain.
pub fn layout<S: Space>(job: &Mpm) -> Result<Layout, String> {
    let per_block = job.cells_per_block;
    let whole = |axis: usize| if axis < S::DIMENSION { job.grid.cells[axis].next_multiple_of(per_block) } else { 1 };
    let ground = Ground {
        shape: ShapeFunction::Linear,
        point_half: 0.5,
        ..Ground::open([whole(0), whole(1), whole(2)], per_block, job.grid.cell, job.grid.lower, job.grid.periodic)
    };
    Layout::new::<S>(ground)
}

/// The mesh of a job, and what bears its loads.
pub fn meshed<S: Space>(job: &Mpm, how: &mpm::Mesh) -> Meshed<S> {
    let lattice = Lattice {
        lower: job.grid.lower,
        edges: [0, 1, 2].map(|axis| job.edge(axis)),
        cells: job.grid.cells,
        periodic: job.grid.periodic,
    };
    let places = job.places().map(|count| 0..count);
    let is_there = |index: &[usize; 3]| job.region_at(&job.place(*index)).is_some();
    let wanted = indices(places).filter(is_there).map(|index| (PointId(job.number(index)), index));
    let mesh = Mesh::of_lattice(&lattice, wanted);
    let bare = mesh.bare_faces();
    // One that is turned inside out is refused where it is laid.
    let volume = |element| Element::of::<S>(&mesh.places_of(element), job.grid.depth).map_or(0.0, |shape| shape.volume);
    let volumes = (0..mesh.elements.len()).map(volume).collect();
    let loaded = loaded(job, &mesh, &bare);
    Meshed {
        mesh: Arc::new(mesh),
        volumes: Arc::new(volumes),
        bare: Arc::new(bare),
        loaded: Arc::new(loaded),
        walls: [0, 1, 2].map(|axis| [job.grid.lower[axis], job.grid.upper[axis]]),
        hourglass: how.hourglass,
        stiffest: job.element_stiffest(),
    }
}

/// Sides with nothing beyond them that look the way of a load and whose element has its middle in the window.
fn loaded<S: Space>(job: &Mpm, mesh: &Mesh<S>, bare: &[(u32, Side)]) -> Vec<LoadedSide> {
    let mut loaded = Vec::new();
    for (element, side) in bare.iter().copied() {
        let middle = mesh.middle_of(element as usize);
        for (load, of) in job.loads.iter().enumerate() {
            let inside = (0..S::DIMENSION).all(|axis| (of.lower[axis]..=of.upper[axis]).contains(&middle[axis]));
            if inside && looks_along(mesh, (element, side), of.face) {
                loaded.push(LoadedSide { element, side, load });
            }
        }
    }
    loaded
}

/// Whether a side looks along the normal of a face more than along any other axis.
fn looks_along<S: Space>(mesh: &Mesh<S>, (element, side): (u32, Side), face: mpm::Face) -> bool {
    let areas = side.areas::<S>(&mesh.places_of(element as usize), 1.0);
    let area = areas[..FACE_CORNERS[S::DIMENSION - 2]].iter().fold(S::Vector::zero(), |sum, area| sum + *area);
    let along = if face.upper { area[face.axis] } else { -area[face.axis] };
    (0..S::DIMENSION).all(|axis| axis == face.axis || area[axis].abs() < along)
}

/// Nodes at the start. Each has the mean of the velocities that the regions of the elements around it have at its place, by the mass that it has of each.
pub fn nodes<S: Space>(job: &Mpm, meshed: &Meshed<S>) -> Vec<Node<S>> {
    let mesh = &meshed.mesh;
    let node = |id| {
        let place = mesh.place(id);
        let (mut momentum, mut mass) = (S::Vector::zero(), 0.0);
        for (element, _) in mesh.around(id) {
            let region = job.region_at(&widened(&mesh.middle_of(*element as usize))).expect("elements are in regions");
            let share = meshed.volumes[*element as usize];
            momentum += vector::<S>(&job.regions[region].velocity_at(&widened(&place))) * share;
            mass += share;
        }
        Node { id, displacement: S::Vector::zero(), velocity: momentum * (1.0 / mass) }
    };
    mesh.nodes().map(node).collect()
}

/// Points at the start have the mean velocity of the corners of their elements.
pub fn move_points<S: Space>(meshed: &Meshed<S>, nodes: &[Node<S>], points: &mut [Point<S>]) {
    let mesh = &meshed.mesh;
    for point in points {
        let element = mesh.element_of(point.cold.id).expect("every point of a mesh has an element");
        let velocity = |corner: usize| {
            let id = mesh.node(element, corner);
            nodes[nodes.binary_search_by_key(&id, |node| node.id).expect("corners are nodes")].velocity
        };
        let sum = (0..corners::<S>()).fold(S::Vector::zero(), |sum, corner| sum + velocity(corner));
        point.hot.velocity = sum * (1.0 / corners::<S>() as f64);
    }
}
