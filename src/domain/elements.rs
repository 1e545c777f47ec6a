//! A mesh over ranks. Elements go with the points that they have, to the block of their place at the start. A node is wherever an element
//! around it is: every such rank sums the same forces in the same order and takes the same step, so that only forces on corners travel.

use std::collections::BTreeMap;
use std::sync::Arc;

use scree_partition::Halo;

use crate::base::error::Error;
use crate::base::ids::NodeId;
use crate::base::lane::LANES;
use crate::base::space::{Linear, Space};
use crate::bodies::body::MeshSide;
use crate::bodies::boundary::Grip;
use crate::domain::step::elements::{into_material, inwards};
use crate::domain::transfer;
use crate::domain::world::World;
use crate::fem::element::{CORNERS_MAX, Element, corners};
use crate::fem::elements::{ElementRow, Elements, Loaded, LoadedSide};
use crate::fem::hourglass::Modes;
use crate::fem::mesh::Mesh;
use crate::fem::node::Node;
use crate::fem::side::Side;

/// What a world of elements is laid from; no step changes it, and it is the same on every rank.
#[derive(Clone, Debug)]
pub struct Meshed<S: Space> {
    /// Vertices at the start, elements, and the nodes that they have.
    pub mesh: Arc<Mesh<S>>,
    /// Of each element at the start, m3; of the plane with its depth.
    pub volumes: Arc<Vec<f64>>,
    /// Groups of the file that the sides at each vertex are in; nothing of a box.
    pub groups: Arc<Vec<u32>>,
    /// Sides that belong to one element alone.
    pub bare: Arc<Vec<(u32, Side)>>,
    /// Those that bear loads.
    pub loaded: Arc<Vec<LoadedSide>>,
    /// Where the domain ends, lower and upper of each axis, m.
    pub walls: [[f64; 2]; 3],
    /// Share of the stiffness of hourglass control.
    pub hourglass: f64,
    /// Bound of all frequencies over those of waves: w^2 <= c^2 times this, 1/m2.
    pub stiffest: f64,
}

/// An element at the start.
type Shape = (Element, Modes);

/// Cosine of the angle up to which a plane looks the way of a face of the domain.
const ALONG: f64 = 0.99;

/// How far a vertex may be from a side of the domain and still lie on it, as a share of its extent.
const SIDE_SLACK: f64 = 1e-9;

impl<S: Space> Meshed<S> {
    /// Sides of elements that can be seen: those that belong to one alone, and those at the ends of the domain, beyond which a period begins.
    pub fn sides_seen(&self) -> Vec<(u32, Side)> {
        let mesh = &self.mesh;
        let elements = 0..mesh.elements.len() as u32;
        let sides = elements.flat_map(|element| Side::all(S::DIMENSION).map(move |side| (element, side)));
        let ends = sides.filter(|(element, side)| {
            let corners = side.corners::<S>().iter().map(|corner| mesh.elements[*element as usize][*corner] as usize);
            corners.fold(u64::MAX, |all, vertex| all & self.faces_at(&mesh.vertices[vertex])) != 0
        });
        let mut seen: Vec<(u32, Side)> = self.bare.iter().copied().chain(ends).collect();
        seen.sort_unstable();
        seen.dedup();
        seen
    }

    /// What of the surface a node is on at the start.
    fn sides_of(&self, node: NodeId) -> u64 {
        let groups = self.groups.get(node.0 as usize).copied().unwrap_or_default();
        self.faces_at(&self.mesh.place(node)) | MeshSide::Groups(groups).bits()
    }

    /// Faces of the domain that a place of the start is on.
    fn faces_at(&self, place: &S::Vector) -> u64 {
        let mut sides = 0;
        for axis in 0..S::DIMENSION {
            let [lower, upper] = self.walls[axis];
            for (bit, wall) in [lower, upper].into_iter().enumerate() {
                if (place[axis] - wall).abs() <= SIDE_SLACK * (upper - lower) {
                    sides |= MeshSide::Face { axis, upper: bit == 1 }.bits();
                }
            }
        }
        sides
    }
}

impl<S: Space> World<'_, S> {
    pub(crate) fn has_elements(&self) -> bool {
        self.settings.meshed.is_some()
    }

    /// Nodes that this rank answers for, in the order of blocks and ids: along the ranks the same on any number of them.
    pub fn owned_nodes(&self) -> Vec<Node<S>> {
        let Some(meshed) = &self.settings.meshed else { return Vec::new() };
        let elements = &self.elements;
        let of = |(node, _): (&Node<S>, &bool)| {
            let (first, _) = meshed.mesh.around(node.id)[0];
            (self.block_of_element(&meshed.mesh, first as usize), *node)
        };
        let owned = elements.nodes.iter().zip(&elements.owned).filter(|(_, owned)| **owned);
        let mut nodes: Vec<(usize, Node<S>)> = owned.map(of).collect();
        nodes.sort_unstable_by_key(|(block, node)| (*block, node.id));
        nodes.into_iter().map(|(_, node)| node).collect()
    }

    fn block_of_element(&self, mesh: &Mesh<S>, element: usize) -> usize {
        let fraction = self.assembly.cell_home.fraction(&mesh.middle_of(element));
        self.subdomain.layout.place::<S>(&fraction, 1).expect("a mesh lies inside of its domain").0
    }

    /// Brings nodes to the ranks that have elements around them, once points have settled, and lays everything that a step goes through. Of a world
    /// that begins every node is on one rank. Collective.
    pub(crate) fn settle_elements(&mut self, number: u64) -> Result<(), Error> {
        let Some(meshed) = self.settings.meshed.clone() else { return Ok(()) };
        let mesh = &*meshed.mesh;
        let owners: Vec<u32> = (0..mesh.elements.len())
            .map(|element| self.subdomain.deal.owner(self.block_of_element(mesh, element)) as u32)
            .collect();
        let nodes = self.send_nodes(number, mesh, &owners)?;
        let mut laid = Elements { nodes, ..Elements::default() };
        let row_of: BTreeMap<NodeId, u32> = (0..).zip(&laid.nodes).map(|(row, node)| (node.id, row)).collect();
        let mut here = vec![u32::MAX; mesh.elements.len()];
        let element_of = |id| mesh.element_of(id).expect("every point of a mesh has an element");
        let elements: Vec<usize> = self.continuum.points.cold.iter().map(|cold| element_of(cold.id)).collect();
        elements.iter().zip(0..).for_each(|(element, row)| here[*element] = row);
        let lay = elements.iter().map(|element| self.row_of_element(mesh, *element, &row_of)).collect();
        let laid_rows: Vec<(ElementRow, Shape)> = transfer::agree(self.transport, lay)?;
        let (rows, shapes): (Vec<_>, Vec<_>) = laid_rows.into_iter().unzip();
        let middles: Vec<S::Vector> = elements.iter().map(|element| mesh.middle_of(*element)).collect();
        for (middles, shapes) in middles.chunks(LANES).zip(shapes.chunks(LANES)) {
            laid.add_octet(middles, shapes);
        }
        laid.rows = rows;
        let local = |of: &LoadedSide| {
            let (row, places) = (here[of.element as usize], mesh.places_of(of.element as usize));
            (row != u32::MAX).then_some(Loaded { row, side: of.side, load: of.load, places })
        };
        laid.loaded = meshed.loaded.iter().filter_map(local).collect();
        laid.loaded.sort_unstable_by_key(|of| (of.row, of.side, of.load));
        self.lay_nodes(&mut laid, &meshed, &owners, &here);
        laid.hourglass = vec![0.0; laid.rows.len()];
        self.elements = laid;
        self.check_nodes(mesh)
    }

    /// Every node is somewhere, once. Collective.
    fn check_nodes(&self, mesh: &Mesh<S>) -> Result<(), Error> {
        let mut count = [self.elements.owned.iter().filter(|owned| **owned).count() as i64];
        self.transport.sum(&mut count);
        let wanted = mesh.nodes().count();
        match count[0] == wanted as i64 {
            true => Ok(()),
            false => Err(Error::Run(format!(
                "step {}: {wanted} nodes are wanted, and {} are there; some were lost, which must not happen: please report this",
                self.step, count[0]
            ))),
        }
    }

    /// Density of the material with its pores at the start, kg/m3: that of all points but for rounding, of which it is the most. Collective.
    fn density_of_points(&self) -> f64 {
        let mut density = [self.continuum.points.hot.iter().map(|hot| hot.mass / hot.volume).fold(0.0, f64::max)];
        self.transport.max(&mut density);
        density[0]
    }

    fn row_of_element(
        &self,
        mesh: &Mesh<S>,
        element: usize,
        row_of: &BTreeMap<NodeId, u32>,
    ) -> Result<(ElementRow, Shape), Error> {
        let (places, depth) = (mesh.shape_of(element), self.settings.grid.depth);
        let shape = Element::of::<S>(&places, depth).ok_or_else(|| {
            Error::User(format!(
                "element {} is turned inside out at the start: a corner of it lies on the wrong side",
                mesh.points[element].0
            ))
        })?;
        let mut nodes = [0; CORNERS_MAX];
        for (corner, node) in nodes.iter_mut().enumerate().take(corners::<S>()) {
            let id = mesh.node(element, corner);
            *node = *row_of.get(&id).ok_or_else(|| {
                Error::Run(format!(
                    "node {} of element {} is missing: the state is of another mesh",
                    id.0, mesh.points[element].0
                ))
            })?;
        }
        Ok((ElementRow { nodes }, (shape, Modes::of::<S>(&shape, &places, depth))))
    }

    /// Faces of the domain that do not hold a node in a group, since the body does that it is fastened to: a rough one holds it along all axes, and a smooth
    /// one, which is a plane, where it looks the way of the face.
    fn faces_given_up(&self, sides: u64) -> u64 {
        let mut given_up = 0;
        for body in &self.bodies {
            let (Some((grip, _)), Some(side @ MeshSide::Groups(_))) = (body.grip, body.side) else { continue };
            for (axis, upper) in
                (0..S::DIMENSION).flat_map(|axis| [(axis, false), (axis, true)]).filter(|_| side.has(sides))
            {
                let looks_along = || into_material(body, side, &body.origin()).dot(&inwards::<S>(axis, upper)) > ALONG;
                if grip == Grip::Rough || looks_along() {
                    given_up |= MeshSide::given_up(axis, upper);
                }
            }
        }
        given_up
    }

    /// Sends the nodes that this rank has answered for; returns those of its elements of now, in the order of their ids.
    fn send_nodes(&mut self, number: u64, mesh: &Mesh<S>, owners: &[u32]) -> Result<Vec<Node<S>>, Error> {
        let mut to_ranks: Vec<Vec<Node<S>>> = vec![Vec::new(); self.transport.size()];
        let elements = std::mem::take(&mut self.elements);
        for (node, _) in elements.nodes.iter().zip(&elements.owned).filter(|(_, owned)| **owned) {
            let mut ranks: Vec<u32> =
                mesh.around(node.id).iter().map(|(element, _)| owners[*element as usize]).collect();
            ranks.sort_unstable();
            ranks.dedup();
            ranks.into_iter().for_each(|rank| to_ranks[rank as usize].push(*node));
        }
        let mut nodes = std::mem::take(&mut to_ranks[self.transport.rank()]);
        nodes.extend(transfer::exchange(self.transport, number, to_ranks)?.into_iter().flatten());
        nodes.sort_unstable_by_key(|node| node.id);
        Ok(nodes)
    }

    /// Masses and sides of nodes, and where the forces on their corners are found: here, or in what other ranks send.
    fn lay_nodes(&mut self, laid: &mut Elements<S>, meshed: &Meshed<S>, owners: &[u32], here: &[u32]) {
        let (mesh, rank) = (&*meshed.mesh, self.transport.rank() as u32);
        let own = laid.rows.len() * CORNERS_MAX;
        let mut sends: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut wanted: BTreeMap<u32, u32> = BTreeMap::new();
        for node in &laid.nodes {
            let around = mesh.around(node.id);
            let others = around.iter().map(|(element, _)| owners[*element as usize]).filter(|owner| *owner != rank);
            let mut peers: Vec<u32> = others.collect();
            peers.iter().for_each(|peer| *wanted.entry(*peer).or_default() += 1);
            peers.sort_unstable();
            peers.dedup();
            for (element, corner) in around.iter().filter(|(element, _)| owners[*element as usize] == rank) {
                let slot = here[*element as usize] * CORNERS_MAX as u32 + u32::from(*corner);
                peers.iter().for_each(|peer| sends.entry(*peer).or_default().push(slot));
            }
        }
        let mut next = own as u32;
        let mut firsts_of: BTreeMap<u32, u32> = BTreeMap::new();
        let mut halo = Halo::default();
        for (peer, count) in wanted {
            halo.receives.push((peer as usize, next..next + count));
            firsts_of.insert(peer, next);
            next += count;
        }
        halo.sends = sends.into_iter().map(|(peer, slots)| (peer as usize, slots)).collect();
        laid.corner_forces = vec![S::Vector::zero(); next as usize];
        laid.firsts.push(0);
        let (corners, density) = (corners::<S>() as f64, self.density_of_points());
        for node in &laid.nodes {
            let mut mass = 0.0;
            for (element, corner) in mesh.around(node.id) {
                let owner = owners[*element as usize];
                let term = match owner == rank {
                    true => here[*element as usize] * CORNERS_MAX as u32 + u32::from(*corner),
                    false => {
                        let slot =
                            firsts_of.get_mut(&owner).expect("whoever has an element at a node here sends its forces");
                        *slot += 1;
                        *slot - 1
                    }
                };
                laid.terms.push(term);
                mass += meshed.volumes[*element as usize] * density / corners;
            }
            laid.firsts.push(laid.terms.len() as u32);
            laid.masses.push(mass);
            let sides = meshed.sides_of(node.id);
            laid.sides.push(sides | self.faces_given_up(sides));
            laid.owned.push(owners[mesh.around(node.id)[0].0 as usize] == rank);
        }
        laid.forces = vec![S::Vector::zero(); laid.nodes.len()];
        (laid.before, laid.damped) = (laid.forces.clone(), laid.forces.clone());
        self.subdomain.corners = halo;
    }
}
