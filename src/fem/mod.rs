//! Finite elements: hexahedra of eight nodes, and in the plane quadrilaterals of four, with one point of quadrature each. That point is a
//! material point like those of a grid ([`crate::mpm::points`]): laws and grain assemblies do not know the difference.
//!
//! Total Lagrangian: gradients are those of the start, so that a deformation is what the displacements say, whatever the steps before were.

pub mod element;
pub mod elements;
pub mod hourglass;
pub mod mesh;
pub mod node;
pub mod side;
