//! What happens on the nodes: momentum balance, what holds them, and how grains and continuum go together.
//!
//! ```text
//! P_c <- P_c + f dt + m_c g dt - J                    the continuum's own step, and what penalty springs have given grains
//! lambda = (m_d P_c - m_c P_d)/(m_c + m_d)            equal velocities, momentum kept (Yue et al. 2018)
//! P_c -= lambda,  P_d += lambda
//! ```
//!
//! A node makes one velocity of the mean velocities of grains and points around it, and what keeps single grains from going
//! their own way is then no more than a dashpot. At the free edges of both within a rim, forces drive grains and
//! continuum apart by `a dt` in every step, some 0.1 m/s, of which functions that smooth lambda leave a part for ever: the layer as
//! a whole slips, and its outermost grains are pushed out of it one by one. So each grain of the rim is tied as well, by a
//! spring q and a dashpot on the way that it slips against the velocities V of its nodes, with the continuum's share of
//! their mass as its strength:
//!
//! ```text
//! u = sum N S (v - V),  S = (m_c - sum m N t t)/(m_c + m_d)     after a step
//! q <- q - k u,  v <- v + q - b u                               in the next
//! J = sum w m N (q - b u)                                       what its nodes' continuum pays for it
//! ```
//!
//! With it a grain slips by `a dt^2/(k s)`, some nanometres, and stays there; where it comes among grains alone, its spring
//! slackens. A membrane, whose mass m is part of m_c, holds grains across itself alone: along it (t) they slide on, or some layers of
//! them would be glued to it by springs that wind up without end. Spring and dashpot are impulses between grains and continuum
//! at a node, so that momentum is kept, and a node's velocity does not feel them.

use crate::base::space::{Linear, Space};
use crate::dem::grains::PenaltySpring;
use crate::mpm::share::Share;
use crate::mpm::tile::{Gathered, GrainChange, GrainNode};

/// k and b. An oscillation of a grain against its nodes dies within tens of steps for all shares s, whatever part of it the
/// nodes see.
const SPRING: f64 = 0.1;
const DASHPOT: f64 = 0.5;
/// Share of the continuum below which springs slacken: half of what it has where rims weigh the same on both sides, and
/// what it has at the edge of such a rim.
const HOLDS: f64 = 0.25;

/// A node after its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped<S: Space> {
    /// Of the continuum, m/s.
    pub velocity: S::Vector,
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

/// A penalty spring after a step in which its grain has come to slip at `slip`, u, m/s, among nodes of which the continuum has `share`.
pub fn tied<S: Space>(spring: &PenaltySpring<S>, slip: &S::Vector, share: &Share<S>) -> PenaltySpring<S> {
    let spring = share.left_of(&(spring.spring - *slip * SPRING), HOLDS);
    PenaltySpring { spring, given: spring - *slip * DASHPOT }
}
