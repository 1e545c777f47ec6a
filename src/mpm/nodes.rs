//! What happens on the nodes: momentum balance, bodies that hold nodes, and the velocity that grains and continuum share.

use crate::mpm::tile::{Advanced, Gathered};
use crate::space::{Linear, Space};

/// The equation of motion of a node, and how grains and continuum share it.
///
/// ```text
/// v = (p + f dt)/m                                    the continuum's own step
/// lambda = (m_d P_c - m_c P_d)/(m_c + m_d)            equal velocities, momentum kept (Yue et al. 2018)
/// P_c -= lambda,  P_d += lambda
/// ```
///
/// A node held by a body has the body's velocity for both.
pub fn advance<S: Space>(node: &Gathered<S>, held: Option<&S::Vector>, dt: f64) -> Advanced<S> {
    let (mass, grain_mass) = (node.mass, node.grain_mass);
    let mut advanced = Advanced::zero();
    if mass > 0.0 {
        let before = node.momentum * (1.0 / mass);
        let momentum = node.momentum + node.force * dt;
        let mut lambda = S::Vector::zero();
        if grain_mass > 0.0 {
            lambda = (momentum * grain_mass - node.grain_momentum * mass) * (1.0 / (mass + grain_mass));
            advanced.grain_change = lambda * (1.0 / grain_mass);
        }
        advanced.velocity = (momentum - lambda) * (1.0 / mass);
        if let Some(held) = held {
            advanced.velocity = *held;
            if grain_mass > 0.0 {
                advanced.grain_change = *held - node.grain_momentum * (1.0 / grain_mass);
            }
        }
        advanced.velocity_change = advanced.velocity - before;
    }
    advanced
}

/// Momentum that a held node brings to its body: that of points and of grains with the force of this step, N s.
pub fn momentum_of_held<S: Space>(node: &Gathered<S>, dt: f64) -> S::Vector {
    node.momentum + node.force * dt
}
