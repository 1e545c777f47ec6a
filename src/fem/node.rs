//! Nodes of a mesh as rows.

use crate::base::ids::NodeId;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Space};

/// Where a node has come, and how fast it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<S: Space> {
    /// Its vertex in the mesh, one of several across a period.
    pub id: NodeId,
    /// From its place at the start, m.
    pub displacement: S::Vector,
    /// Half a step behind the displacement, m/s.
    pub velocity: S::Vector,
}

impl<S: Space> Record for Node<S> {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("id", &mut self.id.0);
        visitor.f64s("displacement", self.displacement.as_mut_slice());
        visitor.f64s("velocity", self.velocity.as_mut_slice());
    }
}

impl<S: Space> Cargo for Node<S> {
    fn blank() -> Self {
        Self { id: NodeId(0), displacement: S::Vector::zero(), velocity: S::Vector::zero() }
    }
}
