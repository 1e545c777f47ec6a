//! What happens on the nodes: momentum balance, what holds them, and how grains and continuum go together.
//!
//! ```text
//! P_c <- P_c + f dt + m_c g dt - J                    the continuum's own step, and what penalty springs have given grains
//! lambda = (m_d P_c - m_c P_d)/(m_c + m_d)            equal velocities, momentum kept (Yue et al. 2018)
//! P_c -= lambda,  P_d += lambda
//! ```
//!
//! Single grains are held to their nodes by penalty springs beside ([`crate::mpm::penalty`]), impulses between grains and continuum at a
//! node, so that momentum is kept and a node's velocity does not feel them.

use crate::base::space::{Linear, Space};
use crate::mpm::share::Share;
use crate::mpm::tile::{Gathered, GrainChange, GrainNode};

/// A node after its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped<S: Space> {
    /// Of the continuum, m/s.
    pub velocity: S::Vector,
    /// What grains there take; zero where there are none.
    pub grains: GrainChange<S>,
}

/// The velocity that nothing holds of a node that has mass: (P_c - lambda)/m_c, without what a node that points hardly reach would lose to
/// round-off, for J goes with the grains' mass.
pub fn free<S: Space>(node: &Gathered<S>, grains: &GrainNode<S>, gravity: &S::Vector, dt: f64) -> S::Vector {
    let momentum = node.momentum() + node.force() * dt + *gravity * (node.mass() * dt) - grains.given();
    match grains.mass() > 0.0 {
        true => (momentum + grains.momentum()) * (1.0 / (node.mass() + grains.mass())),
        false => momentum * (1.0 / node.mass()),
    }
}

/// The step of a node that has mass. `hold` says what becomes of a velocity where something holds the node; it acts on both
/// sides.
pub fn step<S: Space>(
    node: &Gathered<S>,
    grains: &GrainNode<S>,
    gravity: &S::Vector,
    dt: f64,
    hold: impl FnOnce(S::Vector) -> S::Vector,
) -> Stepped<S> {
    let (mass, grain_mass) = (node.mass(), grains.mass());
    let velocity = hold(free(node, grains, gravity, dt));
    if grain_mass <= 0.0 {
        return Stepped { velocity, grains: GrainChange::zero() };
    }
    let both = mass + grain_mass;
    let share = Share::new(mass / both, node.along().map(|of_membranes| of_membranes / both));
    let change = velocity - grains.momentum() * (1.0 / grain_mass);
    Stepped { velocity, grains: GrainChange::new(&share, &change, &velocity) }
}

/// A node with grains alone, or with nothing: what penalty springs have given there, nobody has paid for.
pub fn without_points<S: Space>(grains: &GrainNode<S>) -> GrainChange<S> {
    let nothing = Share::new(0.0, [0.0; 3]);
    match grains.mass() > 0.0 {
        true => GrainChange::new(&nothing, &(grains.given() * (-1.0 / grains.mass())), &S::Vector::zero()),
        false => GrainChange::zero(),
    }
}
