//! What happens on the nodes: momentum balance, what holds them, and the velocity that grains and continuum share.

use crate::mpm::tile::{Advanced, Gathered, GrainChange, GrainNode};
use crate::space::{Linear, Space};

/// The equation of motion of a node, and how grains and continuum share it.
///
/// ```text
/// v = (p + f dt)/m + g dt                             the continuum's own step
/// lambda = (m_d P_c - m_c P_d)/(m_c + m_d)            equal velocities, momentum kept (Yue et al. 2018)
/// P_c -= lambda,  P_d += lambda
/// ```
///
/// `hold` says what becomes of a velocity where something holds the node; it acts on both.
pub fn advance<S: Space>(
    node: &Gathered<S>,
    grains: &GrainNode<S>,
    gravity: &S::Vector,
    dt: f64,
    hold: impl FnOnce(S::Vector) -> S::Vector,
) -> Advanced<S> {
    let (mass, grain_mass) = (node.mass(), grains.mass);
    if mass <= 0.0 {
        return Advanced::zero();
    }
    let before = node.momentum() * (1.0 / mass);
    let momentum = node.momentum() + node.force() * dt + *gravity * (mass * dt);
    let mut velocity = momentum * (1.0 / mass);
    if grain_mass > 0.0 {
        let lambda = (momentum * grain_mass - grains.momentum * mass) * (1.0 / (mass + grain_mass));
        velocity = (momentum - lambda) * (1.0 / mass);
    }
    let velocity = hold(velocity);
    Advanced::new(&velocity, &(velocity - before))
}

/// What brings grains to the velocity that they share with the continuum at a node, m/s.
pub fn correction<S: Space>(node: &Gathered<S>, grains: &GrainNode<S>, advanced: &Advanced<S>) -> GrainChange<S> {
    match node.mass() > 0.0 && grains.mass > 0.0 {
        true => advanced.velocity() - grains.momentum * (1.0 / grains.mass),
        false => S::Vector::zero(),
    }
}
