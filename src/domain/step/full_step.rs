//! Grains at full steps. A state's velocities are those of half a step before its positions; here they are brought to the
//! time of the positions, by the step that comes next:
//!
//! ```text
//! v(n) = v(n-1/2) + a(n) dt/2 = (v(n-1/2) + v(n+1/2))/2
//! ```
//!
//! a(n) being all that moves a grain: contacts with grains and bodies, gravity, damping, the cell, the continuum, and for a
//! glued grain its body; not the change of the cell's velocity gradient that a control of stress makes then, with which free
//! grains jump. Forces are those at the positions, with which that step begins. It is taken in a world of its own,
//! so that springs and lists of the state stay as they are.

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::Mover;
use crate::domain::world::World;

/// All grains of a world at a full step.
#[derive(Clone, Debug)]
pub struct FullStep<S: Space> {
    /// In the order of their ids.
    pub grains: Vec<GrainNow<S>>,
    /// dh/dt of the cell, m/s: velocity of an image against its original.
    pub rate: S::Tensor,
}

/// Motion of a grain at the time of its position, and what its contacts do to it.
#[derive(Clone, Copy, Debug)]
pub struct GrainNow<S: Space> {
    /// m/s, rad/s; of the image that the state has.
    pub velocity: S::Vector,
    /// rad/s.
    pub spin: S::Spin,
    /// N, N m; of a grain that shares nodes with points, by its weight.
    pub force: S::Vector,
    /// N m.
    pub torque: S::Spin,
}

/// The full step at which a world on one rank stands; the world is used up.
pub fn full_step<S: Space>(mut world: World<'_, S>) -> Result<FullStep<S>, Error> {
    assert_eq!(world.transport.size(), 1, "the grains of a full step are all here");
    // The very first kick of a run begins at a full step, or half a step before it as every other does.
    let share = 1.0 - 0.5 / world.kick_share();
    let (before, Cell { rate, gradient, edges, .. }) = (world.assembly.grains.hot.clone(), world.assembly.cell);
    world.take_step()?;
    let (grains, cell) = (&world.assembly.grains, &world.assembly.cell);
    let jump = cell.gradient - gradient;
    let mut order: Vec<usize> = (0..grains.owned).collect();
    order.sort_unstable_by_key(|row| grains.cold[*row].id);
    let now = |row: usize| {
        let (before, mut after) = (&before[row], grains.hot[row]);
        if grains.cold[row].mover == Mover::Free && jump != S::Tensor::zero() {
            after.velocity -= jump * (before.position - cell.corner);
            after.spin -= S::vorticity(&jump);
        }
        GrainNow {
            velocity: before.velocity + (after.velocity - before.velocity) * share,
            spin: before.spin + (after.spin - before.spin) * share,
            force: grains.force[row],
            torque: grains.torque[row],
        }
    };
    let after = cell.rate - jump * edges;
    Ok(FullStep { grains: order.into_iter().map(now).collect(), rate: rate + (after - rate) * share })
}
