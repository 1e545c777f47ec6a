//! A mesh: where its vertices are at the start, which of them make an element, and which are one node across a period. It is the same on
//! every rank and no state: it follows from the job.

use crate::base::ids::{NodeId, PointId};
use crate::base::space::{Linear, Space};
use crate::fem::element::{CORNERS_MAX, NATURAL, corners};
use crate::fem::side::{FACE_CORNERS, Side};

/// The corners of an element by their vertex, those of the plane in the first four.
pub type Corners = [u32; CORNERS_MAX];

/// A mesh of hexahedra, in the plane of quadrilaterals.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<S: Space> {
    /// Places of vertices at the start, m.
    pub vertices: Vec<S::Vector>,
    /// The node that each vertex is.
    pub node_of: Vec<NodeId>,
    /// Elements in the order of the points that they have, and these.
    pub elements: Vec<Corners>,
    /// By element the material point that it has, ascending.
    pub points: Vec<PointId>,
    /// Elements at each vertex that is a node, with the corner that it is of them: from one of these to the next.
    firsts: Vec<u32>,
    at_nodes: Vec<(u32, u8)>,
    /// Edges of the elements of a box, which are all alike, m.
    alike: Option<[f64; 3]>,
}

/// A box of cells along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// m.
    pub lower: [f64; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// One beyond the axes.
    pub cells: [usize; 3],
    /// By axis, whether the last vertices are the nodes of the first.
    pub periodic: [bool; 3],
}

impl<S: Space> Mesh<S> {
    /// The elements `wanted` of a box, which are the cells of that number, x fastest.
    pub fn of_lattice(lattice: &Lattice, wanted: impl Iterator<Item = (PointId, [usize; 3])>) -> Self {
        let along = |axis: usize| if axis < S::DIMENSION { lattice.cells[axis] + 1 } else { 1 };
        let counts = [along(0), along(1), along(2)];
        let number = |[x, y, z]: [usize; 3]| (z * counts[1] + y) * counts[0] + x;
        let mut vertices = Vec::with_capacity(counts.iter().product());
        let mut node_of = Vec::with_capacity(vertices.capacity());
        for z in 0..counts[2] {
            for y in 0..counts[1] {
                for x in 0..counts[0] {
                    let index = [x, y, z];
                    let mut place = S::Vector::zero();
                    (0..S::DIMENSION)
                        .for_each(|axis| place[axis] = lattice.lower[axis] + index[axis] as f64 * lattice.edges[axis]);
                    vertices.push(place);
                    let wrapped = |axis: usize| match lattice.periodic[axis] && axis < S::DIMENSION {
                        true => index[axis] % lattice.cells[axis],
                        false => index[axis],
                    };
                    node_of.push(NodeId(number([wrapped(0), wrapped(1), wrapped(2)]) as u64));
                }
            }
        }
        let corner = |index: [usize; 3], corner: usize| {
            let at = |axis: usize| index[axis] + usize::from(axis < S::DIMENSION && NATURAL[corner][axis] > 0.0);
            number([at(0), at(1), at(2)]) as u32
        };
        let of = |index: [usize; 3]| std::array::from_fn(|at| if at < corners::<S>() { corner(index, at) } else { 0 });
        let (points, elements) = wanted.map(|(point, index)| (point, of(index))).unzip();
        Self { alike: Some(lattice.edges), ..Self::new(vertices, node_of, elements, points) }
    }

    /// Of vertices (m) and the node of each, elements and the point of each. Panics where points do not ascend.
    pub fn new(vertices: Vec<S::Vector>, node_of: Vec<NodeId>, elements: Vec<Corners>, points: Vec<PointId>) -> Self {
        assert!(points.is_sorted(), "elements are in the order of their points");
        let mut counts = vec![0u32; vertices.len() + 1];
        let slots = || {
            elements
                .iter()
                .enumerate()
                .flat_map(|(number, of)| (0..corners::<S>()).map(move |corner| (number, corner, of[corner])))
        };
        slots().for_each(|(_, _, vertex)| counts[node_of[vertex as usize].0 as usize + 1] += 1);
        for at in 1..counts.len() {
            counts[at] += counts[at - 1];
        }
        let (firsts, mut next) = (counts.clone(), counts);
        let mut at_nodes = vec![(0, 0); elements.len() * corners::<S>()];
        for (number, corner, vertex) in slots() {
            let slot = &mut next[node_of[vertex as usize].0 as usize];
            at_nodes[*slot as usize] = (number as u32, corner as u8);
            *slot += 1;
        }
        Self { vertices, node_of, elements, points, firsts, at_nodes, alike: None }
    }

    /// The node at a corner of an element.
    pub fn node(&self, element: usize, corner: usize) -> NodeId {
        self.node_of[self.elements[element][corner] as usize]
    }

    /// Nodes that an element has, by their id.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> {
        (0..self.vertices.len())
            .filter(|node| self.firsts[*node] < self.firsts[node + 1])
            .map(|node| NodeId(node as u64))
    }

    /// Elements at a node with the corner that it is of them, in the order of elements: that of every sum over them.
    pub fn around(&self, node: NodeId) -> &[(u32, u8)] {
        let at = node.0 as usize;
        &self.at_nodes[self.firsts[at] as usize..self.firsts[at + 1] as usize]
    }

    /// Place of a node at the start, m.
    pub fn place(&self, node: NodeId) -> S::Vector {
        self.vertices[node.0 as usize]
    }

    /// The element of a point.
    pub fn element_of(&self, point: PointId) -> Option<usize> {
        self.points.binary_search(&point).ok()
    }

    /// Places of the corners of an element at the start, m.
    pub fn places_of(&self, element: usize) -> [S::Vector; CORNERS_MAX] {
        std::array::from_fn(|corner| self.vertices[self.elements[element][corner] as usize])
    }

    /// The same, but for those of a box about its middle: to the last bit the same of all of them, as their places are not.
    pub fn shape_of(&self, element: usize) -> [S::Vector; CORNERS_MAX] {
        let Some(edges) = self.alike else { return self.places_of(element) };
        NATURAL.map(|natural| {
            let mut place = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| place[axis] = 0.5 * edges[axis] * natural[axis]);
            place
        })
    }

    /// The middle of an element at the start, m.
    pub fn middle_of(&self, element: usize) -> S::Vector {
        let places = self.places_of(element);
        let sum = places[..corners::<S>()].iter().fold(S::Vector::zero(), |sum, place| sum + *place);
        sum * (1.0 / corners::<S>() as f64)
    }

    /// Faces that belong to one element alone: no other has the same vertices, nor lies against it across a period.
    pub fn bare_faces(&self) -> Vec<(u32, Side)> {
        let elements = 0..self.elements.len() as u32;
        let all = elements.flat_map(|element| Side::all(S::DIMENSION).map(move |side| (element, side)));
        let alone = unmatched(all.collect(), |(element, side)| {
            let vertex = |corner: usize| u64::from(self.elements[*element as usize][corner]);
            (key_of_side::<S>(*side, vertex), 0)
        });
        // A lower side and an upper one of the same axis, which are the same nodes.
        let mut bare = Vec::new();
        let of = |(element, side): &(u32, Side)| {
            (key_of_side::<S>(*side, |corner| self.node(*element as usize, corner).0), side.axis)
        };
        let mut keyed: Vec<_> = alone.iter().map(|face| (of(face), *face)).collect();
        keyed.sort_unstable();
        for same in keyed.chunk_by(|a, b| a.0 == b.0) {
            let uppers = same.iter().filter(|(_, (_, side))| side.upper).count();
            if 2 * uppers != same.len() {
                bare.extend(same.iter().map(|(_, face)| *face));
            }
        }
        bare.sort_unstable();
        bare
    }
}

/// What the corners of a side have, ascending: alike of sides with the same corners.
pub fn key_of_side<S: Space>(side: Side, of: impl Fn(usize) -> u64) -> [u64; 4] {
    let mut found = [u64::MAX; 4];
    for (found, corner) in found.iter_mut().zip(side.corners::<S>()) {
        *found = of(*corner);
    }
    found[..FACE_CORNERS[S::DIMENSION - 2]].sort_unstable();
    found
}

/// Those of which no other has the same key.
fn unmatched<T: Copy + Ord, K: Ord>(faces: Vec<T>, key: impl Fn(&T) -> K) -> Vec<T> {
    let mut keyed: Vec<(K, T)> = faces.into_iter().map(|face| (key(&face), face)).collect();
    keyed.sort_unstable();
    let alone = keyed.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    alone.map(|same| same[0].1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Plane, Solid};

    fn box_of<S: Space>(cells: [usize; 3], periodic: [bool; 3]) -> Mesh<S> {
        let lattice = Lattice { lower: [0.0; 3], edges: [1.0, 2.0, 3.0], cells, periodic };
        let all = (0..cells[2]).flat_map(|z| (0..cells[1]).flat_map(move |y| (0..cells[0]).map(move |x| [x, y, z])));
        Mesh::of_lattice(&lattice, all.enumerate().map(|(number, index)| (PointId(number as u64), index)))
    }

    #[test]
    fn nodes_know_the_elements_around_them() {
        let mesh = box_of::<Solid>([3, 2, 2], [false; 3]);
        assert_eq!((mesh.nodes().count(), mesh.elements.len()), (4 * 3 * 3, 12));
        let counts: Vec<usize> = mesh.nodes().map(|node| mesh.around(node).len()).collect();
        assert_eq!((counts.iter().sum::<usize>(), counts.iter().max()), (12 * 8, Some(&8)));
        for node in mesh.nodes() {
            assert!(mesh.around(node).is_sorted());
            assert!(
                mesh.around(node)
                    .iter()
                    .all(|(element, corner)| mesh.node(*element as usize, *corner as usize) == node)
            );
        }
        assert_eq!(mesh.bare_faces().len(), 2 * (3 * 2 + 3 * 2 + 2 * 2));
    }

    #[test]
    fn sides_of_a_period_are_one() {
        let mesh = box_of::<Plane>([4, 3, 1], [true, false, false]);
        assert_eq!(mesh.nodes().count(), 4 * 4);
        assert_eq!(mesh.bare_faces().len(), 2 * 4);
        assert!(mesh.nodes().all(|node| [2, 4].contains(&mesh.around(node).len())));
        // A single element across a period is its own neighbour, and two are each other's on both sides.
        for count in [1, 2] {
            let mesh = box_of::<Plane>([count, 1, 1], [true, false, false]);
            assert_eq!((mesh.nodes().count(), mesh.bare_faces().len()), (2 * count, 2 * count));
            let mesh = box_of::<Solid>([count, 2, 2], [true, false, true]);
            assert_eq!(mesh.bare_faces().len(), 4 * count);
        }
    }
}
