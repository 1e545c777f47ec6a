//! How grains move in a cell whose edges go straight, eight at a time: their kick, and the drift after it.

use crate::base::lane::{Instructions, LANES, Pack, Packed};
use crate::base::numbers::{Lanes, Numbers};
use crate::base::space::{Lanewise, Linear, Space, Words};
use crate::dem::cell::Cell;
use crate::dem::columns::{Largest, columns, splat, times};
use crate::dem::grains::{Grains, Hot};
use crate::dem::kernel::Side;
use crate::dem::motion::Damping;

/// What moves the velocities of grains, and what all of them share.
#[derive(Clone, Copy)]
pub struct KickDrift<'a, S: Space> {
    /// What changes velocities before the drift.
    pub push: Push<'a, S>,
    /// Before the drift.
    pub cell: &'a Cell<S>,
    /// Time step, s.
    pub dt: f64,
    /// Takes places of the cell at the last rebuild to those after the drift.
    pub strain: S::Tensor,
}

/// What changes velocities and spins.
#[derive(Clone, Copy)]
pub enum Push<'a, S: Space> {
    /// The mean field takes up a change of its gradient, 1/s.
    MeanField(&'a S::Tensor),
    /// Forces, with local damping and others where there are any.
    Forces(Option<&'a Damping>),
}

/// What a drift came to.
#[derive(Clone, Copy, Debug)]
pub struct Moved<S: Space> {
    /// The longest way from home against the mean field, m.
    pub way: f64,
    /// Sum of the spins of all grains, rad/s.
    pub spins: S::Spin,
}

impl<S: Space> KickDrift<'_, S> {
    /// Moves all grains. Without `DRIFTS` they stay where they are.
    pub fn run<const DRIFTS: bool>(self, grains: &mut Grains<S>, instructions: Instructions) -> Moved<S> {
        instructions.run(OfGrains::<S, DRIFTS> { kick_drift: self, grains })
    }
}

/// With the grains.
struct OfGrains<'a, S: Space, const DRIFTS: bool> {
    kick_drift: KickDrift<'a, S>,
    grains: &'a mut Grains<S>,
}

impl<S: Space, const DRIFTS: bool> Packed for OfGrains<'_, S, DRIFTS> {
    type Outcome = Moved<S>;

    #[inline(always)]
    fn run<P: Pack>(self) -> Moved<S> {
        let Grains { hot, homes, force, torque, .. } = self.grains;
        let mut farthest = Largest::<P>::none();
        let mut sum: S::SpinOf<P> = Words::<P>::zero();
        let all = hot.chunks_mut(LANES).zip(homes.chunks(LANES)).zip(force.chunks(LANES).zip(torque.chunks(LANES)));
        for ((hot, homes), (force, torque)) in all {
            let (square, spin) = eight::<S, P, DRIFTS>(&self.kick_drift, hot, homes, (force, torque));
            farthest.take(square);
            sum = sum + spin;
        }
        let mut spins = S::Spin::zero();
        for axis in 0..S::Spin::COMPONENTS {
            // Lane by lane, in this order.
            spins[axis] = sum.word(axis).numbers().into_iter().sum();
        }
        Moved { way: farthest.or(0.0).sqrt(), spins }
    }
}

/// As many grains as there are, at most eight, of which the last stands for those that lack. The squares of their ways, m2, and their
/// spins, none for those that lack.
#[inline(always)]
fn eight<S: Space, P: Pack, const DRIFTS: bool>(
    kick_drift: &KickDrift<S>,
    hot: &mut [Hot<S>],
    homes: &[S::Vector],
    (force, torque): (&[S::Vector], &[S::Spin]),
) -> (P, S::SpinOf<P>) {
    let last = hot.len() - 1;
    let mut record = Lanes::<P>::zero();
    record.load(&std::array::from_fn(|lane| &hot[lane.min(last)]), Hot::<S>::WIDTH);
    let grain = Side::<S, P>::of_record(&record);
    let Side { position, velocity, spin, radius, mass, .. } = grain;
    let (corner, dt) = (splat::<_, S::VectorOf<P>, P>(&kick_drift.cell.corner), P::splat(kick_drift.dt));
    let (velocity, spin) = match kick_drift.push {
        Push::MeanField(change) => {
            let turned: S::SpinOf<P> = splat(&S::vorticity(change));
            (velocity + times::<S, P>(change, &(position - corner)), spin + turned)
        }
        Push::Forces(damping) => {
            let one = P::splat(1.0);
            let mut linear = columns::<_, S::VectorOf<P>, P>(force) * (one / mass);
            let mut angular = columns::<_, S::SpinOf<P>, P>(torque) * (one / S::grain_inertia(mass, radius));
            if let Some(damping) = damping {
                (linear, angular) = damping.of_grain(&grain, (linear, angular), kick_drift.cell, kick_drift.dt);
            }
            (velocity + linear * dt, spin + angular * dt)
        }
    };
    record.set_words(S::DIMENSION, &velocity);
    record.set_words(2 * S::DIMENSION, &spin);
    let mut square = P::splat(0.0);
    if DRIFTS {
        let position = position + velocity * dt;
        record.set_words(0, &position);
        let homes: S::VectorOf<P> = columns(homes);
        let moved = position - corner - times::<S, P>(&kick_drift.strain, &(homes - corner));
        square = moved.dot(&moved);
    }
    record.store(hot);
    let there = P::load(&std::array::from_fn(|lane| f64::from(u8::from(lane <= last))));
    (square, spin * there)
}
