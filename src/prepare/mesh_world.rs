//! The mesh of a job of elements, and what of a world follows from it.

use std::sync::Arc;

use crate::base::space::{Linear, Space};
use crate::domain::elements::Meshed;
use crate::domain::layout::{Ground, Layout};
use crate::fem::element::{Element, corners, widened};
use crate::fem::node::Node;
use crate::job::mpm::surface;
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
    let mesh = surface::mesh::<S>(job);
    let bare = mesh.bare_faces();
    // One that is turned inside out is refused where it is laid.
    let volume = |element| Element::of::<S>(&mesh.shape_of(element), job.grid.depth).map_or(0.0, |shape| shape.volume);
    let volumes = (0..mesh.elements.len()).map(volume).collect();
    let loaded = surface::loaded(job, &mesh, &bare);
    Meshed {
        groups: Arc::new(surface::groups(job)),
        mesh: Arc::new(mesh),
        volumes: Arc::new(volumes),
        bare: Arc::new(bare),
        loaded: Arc::new(loaded),
        walls: [0, 1, 2].map(|axis| [job.grid.lower[axis], job.grid.upper[axis]]),
        hourglass: how.hourglass,
        stiffest: job.element_stiffest(),
    }
}

/// Nodes at the start. Each has the mean of the velocities that the regions of the elements around it have at its place, by the mass that it has of each.
pub fn nodes<S: Space>(job: &Mpm, meshed: &Meshed<S>) -> Vec<Node<S>> {
    let mesh = &meshed.mesh;
    let node = |id| {
        let place = mesh.place(id);
        let (mut momentum, mut mass) = (S::Vector::zero(), 0.0);
        for (element, _) in mesh.around(id) {
            let index = job.index(mesh.points[*element as usize].0);
            let region = job.region_of(index).expect("elements are in regions");
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
