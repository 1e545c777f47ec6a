//! Points and grains to the tile of their block.

use crate::dem::grains::{Cold, Hot, Mover};
use crate::mpm::points::Point;
use crate::mpm::shape::Spline;
use crate::mpm::tile::Gathered;
use crate::space::Space;

/// One block's tile: where its first node lies, and how a place is measured in it.
#[derive(Clone, Copy, Debug)]
pub struct TileFrame<S: Space> {
    /// Place of the tile's first node, m.
    pub corner: S::Vector,
    /// 1/cell, 1/m.
    pub cell_inverse: f64,
    /// Nodes per axis.
    pub edge: usize,
}

impl<S: Space> TileFrame<S> {
    #[inline(always)]
    pub fn spline(&self, position: &S::Vector) -> Spline<S> {
        Spline::new((*position - self.corner) * self.cell_inverse, self.cell_inverse)
    }
}

/// Mass, momentum and internal force of the block's points, weighted:
/// `m_i = sum w m N_i`, `p_i = sum w m v N_i`, `f_i = -sum w V0 tau grad N_i`.
pub fn scatter_points<S: Space, M>(frame: &TileFrame<S>, points: &[Point<S, M>], tile: &mut [Gathered<S>]) {
    for point in points {
        let mass = point.weight * point.mass;
        let momentum = point.velocity * mass;
        let stress = point.stress * (point.weight * point.volume);
        frame.spline(&point.position).for_each(frame.edge, |node, value, gradient| {
            let node = &mut tile[node];
            node.mass += mass * value;
            node.momentum += momentum * value;
            node.force -= stress * gradient;
        });
    }
}

/// Weighted mass and momentum of the block's free grains, at their positions before the step.
pub fn scatter_grains<S: Space>(frame: &TileFrame<S>, hot: &[Hot<S>], cold: &[Cold<S>], tile: &mut [Gathered<S>]) {
    for (hot, _) in hot.iter().zip(cold).filter(|(_, cold)| cold.mover == Mover::Free) {
        let mass = hot.weight * hot.mass;
        let momentum = hot.velocity * mass;
        frame.spline(&hot.position).for_each(frame.edge, |node, value, _| {
            let node = &mut tile[node];
            node.grain_mass += mass * value;
            node.grain_momentum += momentum * value;
        });
    }
}

/// Weighted mass of points with their weighted values of two fields, for fields on nodes: `sum w m N`, `sum w m N a`,
/// `sum w m N b`.
pub fn scatter_fields<S: Space, M>(
    frame: &TileFrame<S>,
    points: &[Point<S, M>],
    fields: impl Fn(&Point<S, M>) -> [f64; 2],
    tile: &mut [[f64; 3]],
) {
    for point in points {
        let mass = point.weight * point.mass;
        let [a, b] = fields(point);
        frame.spline(&point.position).for_each(frame.edge, |node, value, _| {
            let node = &mut tile[node];
            node[0] += mass * value;
            node[1] += mass * value * a;
            node[2] += mass * value * b;
        });
    }
}
