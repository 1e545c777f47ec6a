//! Grains at one instant, that of their positions: forces are those of the coming evaluation, springs are stretched up to now,
//! and velocities, which the state has half a step before, are brought here by half of the coming kick:
//!
//! ```text
//! v(n) = v(n-1/2) + a(n) dt/2
//! ```
//!
//! with the acceleration of [`crate::dem::motion`] in the cell's gradient of the last step. Reckoned on copies, so that looking
//! changes nothing. It is of grains alone: what nodes and penalty springs of a continuum do to them is not in it.

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::grains::{Mover, vector};
use crate::dem::motion::{Damped, Falling, Kick};
use crate::domain::world::World;

/// Sums over the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant<S: Space> {
    /// Love-Weber sum over contacts, minus force times branch, J: over the volume the mean stress, tension positive, the
    /// direction of the force first.
    pub moment: S::Tensor,
    /// Of free grains, J.
    pub kinetic_translation: f64,
    /// Of the spins of free grains, J.
    pub kinetic_rotation: f64,
    /// Of the springs of contacts, J.
    pub elastic: f64,
    /// Contacts of grains with each other.
    pub contacts: u64,
}

/// Of a row.
struct Part<S: Space> {
    moment: S::Tensor,
    elastic: f64,
    contacts: u64,
    kinetic: [f64; 2],
}

const SUMS: usize = 9 + 3;

impl<S: Space> World<'_, S> {
    /// Grains as they are, between steps. Collective.
    pub fn instant(&mut self) -> Result<Instant<S>, Error> {
        self.refresh_ghosts();
        let of_walls = self.loads_of_walls();
        let mut sums = ExactSum::<SUMS>::new();
        let [translation, rotation, elastic] = [0, 1, 2].map(|place| S::Tensor::COMPONENTS + place);
        let mut contacts = 0;
        let mut of_walls = of_walls.into_iter().peekable();
        for row in 0..self.assembly.grains.owned {
            let mut load = (S::Vector::zero(), S::Spin::zero());
            let mut part = self.part_of_contacts(row, &mut load);
            while let Some(wall) = of_walls.next_if(|wall| wall.row == row) {
                load.0 += wall.load.0;
                load.1 += wall.load.1;
                part.moment += wall.moment;
                part.elastic += wall.elastic;
            }
            if self.assembly.grains.cold[row].mover == Mover::Free {
                part.kinetic = self.kinetic_of(row, &load);
            }
            (0..S::Tensor::COMPONENTS).for_each(|component| sums.add(component, part.moment[component]));
            sums.add(translation, part.kinetic[0]);
            sums.add(rotation, part.kinetic[1]);
            sums.add(elastic, part.elastic);
            contacts += part.contacts as i64;
        }
        let of = self.reduce(sums)?;
        let mut counts = [contacts];
        self.transport.sum(&mut counts);
        let mut moment = S::Tensor::zero();
        (0..S::Tensor::COMPONENTS).for_each(|component| moment[component] = of[component]);
        Ok(Instant {
            moment,
            kinetic_translation: of[translation],
            kinetic_rotation: of[rotation],
            elastic: of[elastic],
            contacts: counts[0] as u64,
        })
    }

    /// Contacts with grains: their load on the row, and of those with higher ids what they add to the sums.
    fn part_of_contacts(&self, row: usize, (force, torque): &mut (S::Vector, S::Spin)) -> Part<S> {
        let (law, grains, times) = (self.law(), &self.assembly.grains, self.contact_times());
        let mut part = Part { moment: S::Tensor::zero(), elastic: 0.0, contacts: 0, kinetic: [0.0; 2] };
        for term in self.assembly.contacts.neighbours.terms_of(row) {
            let pair = &self.assembly.contacts.neighbours.pairs[term.pair];
            let touch = self.assembly.contacts.touch_after(grains, pair, times);
            let mut memory = self.assembly.contacts.recall(term.pair);
            if !law.holds(&touch, &memory) {
                continue;
            }
            let weight = crate::dem::contacts::Contacts::<S>::weight_of(grains, pair);
            let half = 0.5 * touch.overlap;
            let given = law.give(&touch, weight, [touch.radius_a - half, touch.radius_b - half], &mut memory);
            let on_a: S::Vector = vector(&given.force);
            if term.is_b {
                *force -= on_a;
                *torque += vector::<S::Spin, _>(&given.torque_b);
                continue;
            }
            *force += on_a;
            *torque += vector::<S::Spin, _>(&given.torque_a);
            let normal: S::Vector = vector(&touch.normal);
            part.moment -= S::outer(&on_a, &(normal * (touch.radius_a + touch.radius_b - touch.overlap)));
            part.elastic += weight * law.elastic_energy(&touch, &memory);
            part.contacts += 1;
        }
        part
    }

    /// Energies of translation and rotation at the full step, with the acceleration of that load.
    fn kinetic_of(&self, row: usize, (force, torque): &(S::Vector, S::Spin)) -> [f64; 2] {
        let (field, cell, dt) = (self.settings.grains.field, self.assembly.cell, self.settings.grains.dt);
        let hot = &self.assembly.grains.hot[row];
        let mut after = *hot;
        match field.is_plain() && cell.gradient == S::Tensor::zero() {
            true => Falling { gravity: field.gravity }.kick_one(&mut after, (force, torque), self.kick_share() * dt),
            false => Damped { field, cell }.kick_one(&mut after, (force, torque), self.kick_share() * dt),
        }
        // The very first kick of a run begins at a full step, or half a step before it as every other does.
        let share = 1.0 - 0.5 / self.kick_share();
        let velocity = hot.velocity + (after.velocity - hot.velocity) * share;
        let spin = hot.spin + (after.spin - hot.spin) * share;
        let mass = hot.weight * hot.mass;
        let inertia = S::grain_inertia(mass, hot.radius);
        [0.5 * mass * velocity.dot(&velocity), 0.5 * inertia * spin.dot(&spin)]
    }

    fn loads_of_walls(&self) -> Vec<crate::dem::walls::Load<S>> {
        let bodies = (self.bodies.as_slice(), &self.assembly.cell);
        self.assembly.walls.loads(self.law(), &self.assembly.grains, bodies, self.contact_times()).collect()
    }
}
