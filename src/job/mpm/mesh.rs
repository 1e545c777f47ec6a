//! `[mesh]`: a continuum of elements in place of points on a grid.

use super::{Grid, Mpm};
use crate::base::keys::{Form, LENGTH, POSITIVE, RATIO, Range, Wants, key, number, vector};
use crate::job::assembly::{depth, space};

/// A box of hexahedra, in the plane of quadrilaterals, with one point of quadrature each. The domain of the job is the box, and its cells are
/// the elements: those whose middle is in a region have material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh {
    /// Along each axis.
    pub elements: [f64; 3],
    /// Share of the stiffness that the hourglass modes of an elastic element have.
    pub hourglass: f64,
    /// Local damping of nodes.
    pub damping: f64,
}

impl Mesh {
    pub(in crate::job) const BLANK: Self = Self { elements: [1.0; 3], hourglass: 1.0, damping: 0.0 };

    pub(in crate::job) fn keys(&mut self, grid: &mut Grid, form: &mut dyn Form) {
        space(form, &mut grid.dimension, "plane for plane strain, solid for three dimensions");
        form.vector(&mut grid.lower, vector("lower", "the lower corner", LENGTH, "\"0 m\"").follows("the origin"));
        form.vector(&mut grid.upper, vector("upper", "the upper corner", LENGTH, "\"1 m\""));
        form.vector(&mut self.elements, vector("elements", "elements along each axis", RATIO, "10"));
        depth(form, &mut grid.depth, "a solid has");
        form.flags(
            &mut grid.periodic,
            key("periodic", "which axes are periodic", Wants::Flags, "false").follows("none"),
        );
        self.keys_of_elements(form);
    }

    /// How they resist and rest.
    pub fn keys_of_elements(&mut self, form: &mut dyn Form) {
        let about =
            "the stiffness of hourglass control, a share of that of an elastic element (Belytschko & Bindeman 1993)";
        form.number(&mut self.hourglass, number("hourglass", about, RATIO, POSITIVE, "1.0").or("1.0"));
        let about =
            "local damping, a share of the force on a node that acts against its motion, component by component";
        form.number(&mut self.damping, number("local_damping", about, RATIO, Range::below(0.0, 1.0), "0.1").or("0.0"));
    }
}

impl Mpm {
    /// Edge of a cell along an axis, m: of elements one of its own along each.
    pub fn edge(&self, axis: usize) -> f64 {
        match self.mesh {
            Some(_) if axis < self.grid.dimension => self.grid.extent(axis) / self.grid.cells[axis] as f64,
            _ => self.grid.cell,
        }
    }

    /// Volume of an element, m3.
    pub(super) fn element_volume(&self) -> f64 {
        let edges = (0..self.grid.dimension).map(|axis| self.edge(axis)).product::<f64>();
        if self.grid.dimension == 2 { edges * self.grid.depth } else { edges }
    }

    /// What frequencies of elements are bounded by: 4 times the sum of the inverse squares of their edges, 1/m2.
    pub fn element_stiffest(&self) -> f64 {
        (0..self.grid.dimension).map(|axis| 4.0 / (self.edge(axis) * self.edge(axis))).sum()
    }
}
