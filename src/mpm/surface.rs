//! Loads that act on the surface of the material, wherever in a cell that is.
//!
//! A point stands for its own volume, and its surface is half of a point's edge farther out. A load that acts at the point enters the grid
//! too deep: of a pressure on a body of one cell the material feels three quarters. Nodes themselves know how much of the surface they stand
//! for, since gradients of what is inside the material cancel (the divergence theorem):
//!
//! ```text
//! a_i = sum_p J_p V_p grad N_i(x_p)           m2, along the normal out of the material
//! A_i = sum_s N_i(x_s) J F^-T N A             m2, the same as the points s of the surface on a side have it (Nanson)
//! q_i = sum_s N_i(x_s) t_s                    N, the load as it would act at points
//! f_i = q_i (a_i . A_i)/(A_i . A_i)
//! ```
//!
//! Under a pressure P that is `-P (a_i . n) n`, and material with the stress -P is in balance at every node to round-off, whatever its
//! points, functions and strains are. A_i has all points of that side, so that a load which ends somewhere on it ends there. Where both
//! sides of an axis reach a node, as in material of less than three cells, it is of the side that a_i points out of. Sides of one axis at a
//! time: what a body bears on another side, or a plate there, has no part in it.

use crate::base::space::{Linear, Space};
use crate::mpm::points::Hot;
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::ShapeFunction;
use crate::mpm::shape::{Cubic, Generalised, LinearHat, Quadratic, Shape};
use crate::mpm::tile::{Gathered, Mosaic};

/// The lower and the upper side of an axis.
pub const SIDES: usize = 2;

/// What points bring to a node for the loads across an axis: a, and of the lower and the upper side A and q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceNode<S: Space> {
    /// a, m2, along the normal out of the material.
    pub outward: S::Vector,
    /// The lower and the upper side of the axis.
    pub sides: [Side<S>; SIDES],
}

/// Of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side<S: Space> {
    /// A, m2.
    pub area: S::Vector,
    /// q, N.
    pub load: S::Vector,
}

impl<S: Space> SurfaceNode<S> {
    /// Of a node that no point reaches.
    pub fn zero() -> Self {
        let side = Side { area: S::Vector::zero(), load: S::Vector::zero() };
        Self { outward: S::Vector::zero(), sides: [side; SIDES] }
    }

    /// What another tile brings to the same node.
    pub fn add(&mut self, other: &Self) {
        self.outward += other.outward;
        for (side, more) in self.sides.iter_mut().zip(&other.sides) {
            side.area += more.area;
            side.load += more.load;
        }
    }

    /// f of the loads on both sides, N.
    pub fn force(&self) -> S::Vector {
        let [lower, upper] = self.sides.map(|side| side.area.dot(&side.area) > 0.0);
        let mut force = S::Vector::zero();
        for side in &self.sides {
            let (square, along) = (side.area.dot(&side.area), self.outward.dot(&side.area));
            if square > 0.0 && (along > 0.0 || !(lower && upper)) {
                force += side.load * (along / square);
            }
        }
        force
    }

    /// Its vectors in order.
    fn vectors(&mut self) -> [&mut S::Vector; 1 + 2 * SIDES] {
        let [lower, upper] = &mut self.sides;
        [&mut self.outward, &mut lower.area, &mut lower.load, &mut upper.area, &mut upper.load]
    }

    /// As a message has it.
    pub fn words<const W: usize>(mut self) -> [f64; W] {
        let mut words = [0.0; W];
        for (to, vector) in words.chunks_exact_mut(S::DIMENSION).zip(self.vectors()) {
            to.copy_from_slice(vector.as_mut_slice());
        }
        words
    }

    /// From a message, as [`Self::words`] has it.
    pub fn of(words: &[f64]) -> Self {
        let mut node = Self::zero();
        for (from, vector) in words.chunks_exact(S::DIMENSION).zip(node.vectors()) {
            vector.as_mut_slice().copy_from_slice(from);
        }
        node
    }
}

/// Node rows of loads on the surface: laid as [`crate::mpm::tile::Tiles`], worked on in the tiles near the surface alone. Empty where no load
/// acts so.
#[derive(Clone, Debug)]
pub struct SurfaceRows<S: Space> {
    /// Tiles of this rank that have points of the surface, or are near some.
    pub near: Vec<bool>,
    /// By tile row, for the axis under way.
    pub brought: Vec<SurfaceNode<S>>,
    /// f of all axes, N, of owned nodes.
    pub forces: Vec<S::Vector>,
}

impl<S: Space> Default for SurfaceRows<S> {
    fn default() -> Self {
        Self { near: Vec::new(), brought: Vec::new(), forces: Vec::new() }
    }
}

impl<S: Space> SurfaceRows<S> {
    /// Rows of zeros for these tiles; `near` has one flag for each.
    pub fn lay(mosaic: &Mosaic, near: Vec<bool>) -> Self {
        Self {
            near,
            brought: vec![SurfaceNode::zero(); mosaic.rows() + mosaic.rows_received],
            forces: vec![S::Vector::zero(); mosaic.owned.len()],
        }
    }

    /// No load has acted on owned nodes yet.
    pub fn clear(&mut self) {
        self.forces.fill(S::Vector::zero());
    }

    /// Owned nodes take the force of the axis under way from what tiles have, in the one order of neighbours.
    pub fn push(&mut self, mosaic: &Mosaic, nodes: &mut [Gathered<S>]) {
        let per_tile = mosaic.owned_per_tile();
        for tile in (0..self.near.len()).filter(|tile| self.near[*tile]) {
            let owned = tile * per_tile..(tile + 1) * per_tile;
            let both = self.forces[owned.clone()].iter_mut().zip(&mut nodes[owned.clone()]);
            for (number, (total, node)) in owned.zip(both) {
                let mut sum = SurfaceNode::zero();
                mosaic.sources_of(number).iter().for_each(|source| sum.add(&self.brought[*source as usize]));
                let force = sum.force();
                *total += force;
                node.add_force(&force);
            }
        }
    }
}

/// What the points of a block bring; `sides` says of a point by its number what it has of the surface on the lower and the upper side.
pub fn scatter<S: Space>(
    frame: &TileFrame<S>,
    shape: ShapeFunction,
    points: &[Hot<S>],
    sides: impl Fn(usize) -> [Option<Side<S>>; SIDES],
    tile: &mut [SurfaceNode<S>],
) {
    tile.fill(SurfaceNode::zero());
    for (row, point) in points.iter().enumerate() {
        let sides = &sides(row);
        match shape {
            ShapeFunction::Linear => bring::<S, LinearHat, 3>(frame, point, sides, tile),
            ShapeFunction::Generalised => bring::<S, Generalised, 3>(frame, point, sides, tile),
            ShapeFunction::Quadratic => bring::<S, Quadratic, 3>(frame, point, sides, tile),
            ShapeFunction::Cubic => bring::<S, Cubic, 4>(frame, point, sides, tile),
        }
    }
}

fn bring<S: Space, F: Shape<N>, const N: usize>(
    frame: &TileFrame<S>,
    point: &Hot<S>,
    sides: &[Option<Side<S>>; SIDES],
    tile: &mut [SurfaceNode<S>],
) {
    let volume = point.weight * point.volume * point.volume_ratio();
    frame.stencil::<F, N>(&point.position).for_each_gradient(frame.edge, |node, value, gradient| {
        let node = &mut tile[node];
        for (axis, slope) in gradient.iter().enumerate().take(S::DIMENSION) {
            node.outward[axis] += volume * slope;
        }
        for (of, side) in node.sides.iter_mut().zip(sides) {
            if let Some(Side { area, load }) = side {
                of.area += *area * value;
                of.load += *load * value;
            }
        }
    });
}
