//! Tiles back to points and grains.

use crate::dem::grains::{Cold, Hot, Mover};
use crate::law::material::MaterialLaw;
use crate::mpm::points::Point;
use crate::mpm::scatter::TileFrame;
use crate::mpm::tile::Advanced;
use crate::space::{Linear, Space};

/// Velocity, place and stress of the block's points (stress update last):
/// `v <- alpha (v + sum N dv_i) + (1 - alpha) sum N v_i`, `x += sum N v_i dt`, `L = sum v_i grad N`.
pub fn gather_points<S: Space, L: MaterialLaw<S>>(
    frame: &TileFrame<S>,
    law: &L,
    flip: f64,
    dt: f64,
    tile: &[Advanced<S>],
    points: &mut [Point<S, L::Memory>],
) {
    for point in points {
        let (mut velocity, mut change, mut gradient) = (S::Vector::zero(), S::Vector::zero(), S::Tensor::zero());
        frame.spline(&point.position).for_each(frame.edge, |node, value, slope| {
            let node = &tile[node];
            velocity += node.velocity * value;
            change += node.velocity_change * value;
            gradient += S::outer(&node.velocity, &slope);
        });
        point.velocity = (point.velocity + change) * flip + velocity * (1.0 - flip);
        point.position += velocity * dt;
        point.volume_ratio *= S::determinant(&(S::identity() + gradient * dt));
        point.stress = law.update(&gradient, dt, &mut point.memory);
    }
}

/// Correction of the block's free grains: `v += sum N lambda_i/m_i`. Spin is left alone.
pub fn correct_grains<S: Space>(frame: &TileFrame<S>, tile: &[Advanced<S>], hot: &mut [Hot<S>], cold: &[Cold<S>]) {
    for (hot, _) in hot.iter_mut().zip(cold).filter(|(_, cold)| cold.mover == Mover::Free) {
        let mut change = S::Vector::zero();
        frame.spline(&hot.position).for_each(frame.edge, |node, value, _| {
            change += tile[node].grain_change * value;
        });
        hot.velocity += change;
    }
}
