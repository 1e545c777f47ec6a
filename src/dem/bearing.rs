//! Contacts that bear force, as an observer sees them between steps: at the positions and velocities of now, reckoned on
//! copies of the memories, so that looking changes nothing and no step keeps anything for it. `times` are those over which
//! memories advance: with those of the coming evaluation its forces are seen ahead, with zeros springs stand where the last
//! evaluation left them.

use crate::base::ids::{GrainId, Row};
use crate::base::space::{Linear, Space};
use crate::bodies::body::Body;
use crate::dem::cell::Cell;
use crate::dem::contacts::Contacts;
use crate::dem::grains::{Grains, body_partner, vector};
use crate::dem::law::Law;
use crate::dem::walls::{Walls, beside, middle, touch_of};

/// A contact as a grain has it.
#[derive(Clone, Copy, Debug)]
pub struct Bearing<S: Space> {
    /// Of the grain, which this rank owns.
    pub row: Row,
    /// The other grain, or the body.
    pub partner: GrainId,
    /// On the grain, not weighted, N.
    pub force: S::Vector,
    /// From the grain's centre to the partner's, or to where the body is touched, m.
    pub branch: S::Vector,
    /// Share of the branch that is the grain's own.
    pub share: f64,
    /// Weight of the contact in the mixture.
    pub weight: f64,
}

impl<S: Space> Bearing<S> {
    /// The grain's part in the Love-Weber sum, J, tension positive: over the grain's share of space it is its mean stress.
    pub fn moment(&self) -> S::Tensor {
        S::outer(&self.force, &self.branch) * self.share
    }

    /// The force across the contact (N, positive where the two push each other) and along it.
    pub fn parts(&self) -> [f64; 2] {
        let normal = self.branch * (1.0 / self.branch.norm());
        let pushing = -self.force.dot(&normal);
        [pushing, (self.force + normal * pushing).norm()]
    }
}

impl<S: Space> Contacts<S> {
    /// Those of an owned row with other grains, in the order of the partners' ids.
    pub fn bearings(
        &self,
        law: &dyn Law<S>,
        grains: &Grains<S>,
        row: usize,
        times: [f64; 2],
    ) -> impl Iterator<Item = Bearing<S>> {
        self.neighbours.terms_of(row).filter_map(move |term| {
            let pair = &self.neighbours.pairs[term.pair];
            let touch = self.touch_after(grains, pair, times);
            let mut memory = self.recall(term.pair);
            let force: S::Vector = vector(&law.give(&touch, 1.0, [0.0, 0.0], &mut memory).force);
            if force == S::Vector::zero() {
                return None;
            }
            let reach = grains.hot[pair.a as usize].radius + grains.hot[pair.b() as usize].radius;
            let normal: S::Vector = vector(&touch.normal);
            // The normal points to `a`.
            let sign = if term.is_b { -1.0 } else { 1.0 };
            Some(Bearing {
                row: row as Row,
                partner: grains.cold[self.neighbours.partner(term) as usize].id,
                force: force * sign,
                branch: normal * (sign * (touch.overlap - reach)),
                share: 0.5,
                weight: Self::weight_of(grains, pair),
            })
        })
    }

    /// Love-Weber sum over the contacts of an owned row with other grains, not weighted, J; over the grain's share of space it
    /// is its mean stress, tension positive.
    pub fn moment(&self, law: &dyn Law<S>, grains: &Grains<S>, row: usize, times: [f64; 2]) -> S::Tensor {
        self.bearings(law, grains, row, times).fold(S::Tensor::zero(), |sum, bearing| sum + bearing.moment())
    }
}

impl<S: Space> Walls<S> {
    /// Those of grains with bodies, in the order of rows, then bodies.
    pub fn bearings<'a>(
        &'a self,
        law: &'a dyn Law<S>,
        grains: &'a Grains<S>,
        (bodies, cell): (&'a [Body<S>], &'a Cell<S>),
        times: [f64; 2],
    ) -> impl Iterator<Item = Bearing<S>> + 'a {
        self.list.iter().filter_map(move |wall| {
            let body = &bodies[wall.body as usize];
            let (hot, _) = beside(body, cell, &grains.hot[wall.row as usize]);
            let nearest = body.nearest(&hot.position)?;
            let touch = touch_of(&hot, body, (body.velocity, body.spin), &nearest, times);
            let mut memory = wall.memory;
            let law = self.law_of(wall.body, law);
            let force: S::Vector = vector(&law.give(&touch, 1.0, [0.0, 0.0], &mut memory).force);
            let branch = middle(&nearest, touch.overlap) - hot.position;
            let (partner, weight) = (body_partner(wall.body), hot.weight);
            let bearing = Bearing { row: wall.row, partner, force, branch, share: 1.0, weight };
            (force != S::Vector::zero()).then_some(bearing)
        })
    }
}
