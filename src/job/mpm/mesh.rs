//! `[mesh]`: a continuum of elements in place of points on a grid.

use super::{Grid, MeshFile, Mpm};
use crate::base::keys::{Form, LENGTH, POSITIVE, RATIO, Range, Wants, key, number, text, vector};
use crate::job::assembly::{depth, space};

/// Hexahedra, in the plane quadrilaterals, with one point of quadrature each: those of a box, whose cells they are, or those of a file, with the box around
/// them for a domain. Elements in a region have material.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Along each axis of a box.
    pub elements: [f64; 3],
    /// In place of a box.
    pub file: Option<MeshFile>,
    /// Share of the stiffness that the hourglass modes of an elastic element have.
    pub hourglass: f64,
    /// Local damping of nodes.
    pub damping: f64,
    /// Inertia of the material over its mass.
    pub mass_scaling: f64,
}

impl Mesh {
    pub(in crate::job) const BLANK: Self =
        Self { elements: [1.0; 3], file: None, hourglass: 1.0, damping: 0.0, mass_scaling: 1.0 };

    pub(in crate::job) fn keys(&mut self, grid: &mut Grid, form: &mut dyn Form) {
        space(form, &mut grid.dimension, "plane for plane strain, solid for three dimensions");
        self.keys_of_file(form);
        if self.file.is_none() || form.describes() {
            Self::keys_of_box(grid, &mut self.elements, form);
        }
        depth(form, &mut grid.depth, "a solid has");
        self.keys_of_elements(form);
    }

    fn keys_of_file(&mut self, form: &mut dyn Form) {
        let mut path = self.file.as_ref().map(|file| file.path.clone());
        let about = "a mesh of hexahedra (in the plane of quadrilaterals) that Gmsh has made, as MSH 4.1 in text; in place of lower, upper, elements and periodic";
        form.path_if_given(&mut path, text("file", about, "\"slope.msh\"").optional());
        let mut blank = form.describes().then(MeshFile::blank);
        if let Some(path) = path {
            self.file.get_or_insert_with(MeshFile::blank).path = path;
            for key in ["lower", "upper", "elements", "periodic"] {
                if form.has(key) {
                    form.note(key, "stands beside mesh.file, which says where elements are. Remove one of the two.");
                }
            }
        }
        let Some(file) = self.file.as_mut().or(blank.as_mut()) else {
            for key in ["unit", "sha256"] {
                if form.has(key) {
                    form.note(key, "is of a mesh from a file, and there is no mesh.file. Add it, or remove the line.");
                }
            }
            return;
        };
        let about = "the length that the unit of the file stands for";
        form.number(&mut file.unit, number("unit", about, LENGTH, POSITIVE, "\"1 mm\"").or("1.0"));
        if form.has("sha256") || form.describes() || !file.digest.is_empty() {
            let about = "the SHA-256 of the file, which it has to have; a run writes it, so that it goes on with the mesh that it began with";
            form.text(&mut file.digest, text("sha256", about, "\"e3b0c442...\"").optional());
        }
    }

    fn keys_of_box(grid: &mut Grid, elements: &mut [f64; 3], form: &mut dyn Form) {
        let unless = "unless file is given";
        form.vector(&mut grid.lower, vector("lower", "the lower corner", LENGTH, "\"0 m\"").follows("the origin"));
        form.vector(&mut grid.upper, vector("upper", "the upper corner", LENGTH, "\"1 m\"").required(unless));
        form.vector(elements, vector("elements", "elements along each axis", RATIO, "10").required(unless));
        form.flags(
            &mut grid.periodic,
            key("periodic", "which axes are periodic", Wants::Flags, "false").follows("none"),
        );
    }

    /// How they resist and rest.
    pub fn keys_of_elements(&mut self, form: &mut dyn Form) {
        let about =
            "the stiffness of hourglass control, a share of that of an elastic element (Belytschko & Bindeman 1993)";
        form.number(&mut self.hourglass, number("hourglass", about, RATIO, Range::above(0.0, 1.0), "1.0").or("1.0"));
        let about =
            "local damping, a share of the force on a node that acts against its motion, component by component";
        form.number(&mut self.damping, number("local_damping", about, RATIO, Range::below(0.0, 1.0), "0.1").or("0.0"));
        let about = "inertia of the material over its mass, for slow loading: steps are longer by its root, and weight stays what it is";
        form.number(
            &mut self.mass_scaling,
            number("mass_scaling", about, RATIO, Range::closed(1.0, 1e6), "100").or("1.0"),
        );
    }
}

impl Mpm {
    /// Edge of a cell along an axis, m: of elements one of its own along each.
    pub fn edge(&self, axis: usize) -> f64 {
        match &self.mesh {
            Some(_) if axis < self.grid.dimension => self.grid.extent(axis) / self.grid.cells[axis] as f64,
            _ => self.grid.cell,
        }
    }

    /// Volume of the element at an index, m3.
    pub(super) fn element_volume(&self, index: [usize; 3]) -> f64 {
        if let Some(drawn) = self.drawn() {
            return drawn.volumes[index[0]];
        }
        let edges = (0..self.grid.dimension).map(|axis| self.edge(axis)).product::<f64>();
        if self.grid.dimension == 2 { edges * self.grid.depth } else { edges }
    }

    /// What frequencies of elements are bounded by: of boxes 4 times the sum of the inverse squares of their edges, 1/m2.
    pub fn element_stiffest(&self) -> f64 {
        if let Some(drawn) = self.drawn() {
            return drawn.stiffest;
        }
        (0..self.grid.dimension).map(|axis| 4.0 / (self.edge(axis) * self.edge(axis))).sum()
    }
}
