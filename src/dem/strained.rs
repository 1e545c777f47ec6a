//! Stress and stiffness of a cell's contacts at the last evaluation, in one pass, as a control of stress needs them.
//!
//! Where all grains move with the cell (the affine strain of a step, before they rearrange), stretching at the rate L_a along
//! the axis a changes the force of a contact with the branch b, |b| = l, by k_n L_a b_a^2/l along it and by less than
//! k_t L_a |b_a| along its surface, and the normal stress along a by no more than K_a L_a per second, nor do stretches along
//! all axes at once change it by more than K_a times the largest of them:
//!
//! ```text
//! K_a = 1/V sum k b_a^2,  C_a = 1/V sum c b_a^2        k = max(k_n, k_t), c = max(c_n, c_t)
//! ```
//!
//! K in Pa bounds what springs answer (isotropic stretch of contacts with k_n >= k_t meets it), C in Pa s what dashpots do at
//! once. Where a body or a glued grain does not follow the cell, the way of the other from the cell's corner takes the place
//! of one b_a.

use crate::base::exact::ExactSum;
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::contacts::Contacts;
use crate::dem::grains::{Grains, Mover};
use crate::dem::law::Law;
use crate::dem::walls::Walls;
use crate::law::contact::{FLAT, Springs};

/// Components of [`Strained`], in space.
pub const STRAINED: usize = 15;

/// Sums over contacts that bear force; over the volume they are stress, K and C.
#[derive(Clone, Copy, Debug)]
pub struct Strained<S: Space> {
    /// Love-Weber sum, minus force times branch, J.
    pub moment: S::Tensor,
    /// N m.
    pub springs: S::Vector,
    /// N m s.
    pub dashpots: S::Vector,
}

impl<S: Space> Strained<S> {
    /// Of no contacts.
    pub fn zero() -> Self {
        Self { moment: S::Tensor::zero(), springs: S::Vector::zero(), dashpots: S::Vector::zero() }
    }

    /// Adds every component to a sum of its own.
    pub fn add_to(&self, sums: &mut ExactSum<STRAINED>) {
        let [springs, dashpots] = Self::FIRST;
        (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(component, self.moment[component]));
        for axis in 0..S::DIMENSION {
            sums.add(springs + axis, self.springs[axis]);
            sums.add(dashpots + axis, self.dashpots[axis]);
        }
    }

    /// From those sums.
    pub fn of_sums(sums: &[f64; STRAINED]) -> Self {
        let [springs, dashpots] = Self::FIRST;
        let mut strained = Self::zero();
        (0..S::Tensor::COMPONENTS).for_each(|component| strained.moment[component] = sums[component]);
        for axis in 0..S::DIMENSION {
            strained.springs[axis] = sums[springs + axis];
            strained.dashpots[axis] = sums[dashpots + axis];
        }
        strained
    }

    /// Where springs and dashpots begin.
    const FIRST: [usize; 2] = [S::Tensor::COMPONENTS, S::Tensor::COMPONENTS + S::DIMENSION];

    /// A contact with the branch `branch` that strains as a bar from the origin to `strained` does.
    fn add(&mut self, force: &S::Vector, branch: &S::Vector, strained: &S::Vector, springs: Springs) {
        self.moment -= S::outer(force, branch);
        for axis in 0..S::DIMENSION {
            let square = (branch[axis] * strained[axis]).abs();
            self.springs[axis] += springs.stiffest() * square;
            self.dashpots[axis] += springs.most_damped() * square;
        }
    }
}

impl<S: Space> Contacts<S> {
    /// Of contacts of an owned row with grains of higher ids, with the forces of the last evaluation and its positions.
    pub fn strained(&self, law: &dyn Law<S>, grains: &Grains<S>, cell: &Cell<S>, row: usize) -> Strained<S> {
        let mut sums = Strained::zero();
        for term in self.neighbours.terms_of(row).filter(|term| !term.is_b) {
            let force = self.force_of(term.pair);
            if force == S::Vector::zero() {
                continue;
            }
            let pair = &self.neighbours.pairs[term.pair];
            let [a, b] = [pair.a, pair.b()].map(|row| &grains.hot[row as usize]);
            let branch = a.position - b.position + self.shift(pair).0;
            let strained = match grains.cold[row].mover {
                Mover::Free if b.weight > 0.0 => branch,
                Mover::Free => a.position - cell.corner,
                _ => b.position - cell.corner,
            };
            let overlap = a.radius + b.radius - branch.norm();
            let masses = [a, b].map(|hot| if hot.weight > 0.0 { hot.mass } else { FLAT });
            let springs = law.stiffness([a.radius, b.radius], masses, overlap);
            sums.add(&force, &branch, &strained, springs);
        }
        sums
    }
}

impl<S: Space> Walls<S> {
    /// Of all contacts with bodies, one by one.
    pub fn strained<'a>(
        &'a self,
        law: &'a dyn Law<S>,
        grains: &'a Grains<S>,
        cell: &'a Cell<S>,
    ) -> impl Iterator<Item = Strained<S>> + 'a {
        let bearing = self.list.iter().filter(|wall| wall.force != S::Vector::zero());
        bearing.map(move |wall| {
            let hot = &grains.hot[wall.row as usize];
            let branch = hot.position - wall.shift - wall.point;
            let overlap = 2.0 * (hot.radius - branch.norm());
            let mut sums = Strained::zero();
            let springs = self.law_of(wall.body, law).stiffness([hot.radius, FLAT], [hot.mass, FLAT], overlap);
            sums.add(&wall.force, &branch, &(hot.position - cell.corner), springs);
            sums
        })
    }
}
