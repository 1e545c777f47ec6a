//! What a world is made of, before it has blocks.

use scree_partition::{ParcelError, Reader, Writer};

use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::cell::Cell;
use crate::dem::grains::GrainRow;
use crate::fem::node::Node;
use crate::mpm::membrane::Membranes;
use crate::mpm::points::Point;
use crate::rve::{Packings, RveRow};

/// Of a world, as ranks hold them in any split.
pub struct Parts<S: Space> {
    /// With the memories of their contacts.
    pub grains: Vec<GrainRow<S>>,
    /// Of elements, one each.
    pub points: Vec<Point<S>>,
    /// Of points whose material is grains, and on every rank radii and masses of the grains of their packings.
    pub rves: Vec<RveRow<S>>,
    /// Those that RVEs begin from; empty where no material is grains.
    pub packings: Packings,
    /// Of elements, all on rank 0.
    pub nodes: Vec<Node<S>>,
    /// The same on every rank.
    pub bodies: Vec<Body<S>>,
    /// The same on every rank.
    pub membranes: Membranes<S>,
    /// As it is now; the same on every rank.
    pub cell: Cell<S>,
    /// The same on every rank.
    pub home: Home<S>,
}

impl<S: Space> Parts<S> {
    /// Of a world that begins: everything is at home. Without membranes.
    pub fn fresh(grains: Vec<GrainRow<S>>, points: Vec<Point<S>>, bodies: Vec<Body<S>>, cell: Cell<S>) -> Self {
        let home = Home { cell, bodies: bodies.iter().map(|body| body.displacement).collect() };
        Self {
            grains,
            points,
            rves: Vec::new(),
            packings: Vec::new(),
            nodes: Vec::new(),
            bodies,
            membranes: Membranes::default(),
            cell,
            home,
        }
    }
}

/// Cell and bodies at the last rebuild: lists and their age follow from them, as from the homes of grains.
#[derive(Clone, Debug)]
pub struct Home<S: Space> {
    /// As it was then.
    pub cell: Cell<S>,
    /// Displacements, m.
    pub bodies: Vec<S::Vector>,
}

impl<S: Space> Record for Home<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        self.cell.visit(visitor);
    }
}

impl<S: Space> Cargo for Home<S> {
    fn blank() -> Self {
        Self { cell: Cell::blank(), bodies: Vec::new() }
    }
    fn pack_rest(&mut self, to: &mut Writer) {
        to.u64(self.bodies.len() as u64);
        for displacement in &mut self.bodies {
            displacement.as_mut_slice().iter().for_each(|component| to.f64(*component));
        }
    }
    fn unpack_rest(&mut self, from: &mut Reader) -> Result<(), ParcelError> {
        for _ in 0..from.u64()? {
            let mut displacement = S::Vector::zero();
            for component in displacement.as_mut_slice() {
                *component = from.f64()?;
            }
            self.bodies.push(displacement);
        }
        Ok(())
    }
}
