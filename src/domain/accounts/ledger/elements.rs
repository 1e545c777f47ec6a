//! What a step of elements books, by the rules of [`super::points`]: every force works half over the drift ahead and half over the one behind.
//! Kinetic energy is that of nodes; what hourglass modes have stands with the elastic energy, and by itself beside it.

use scree_partition::ExactSum;

use super::points::{AHEAD, BEHIND, FORCES, Item, STORES, Store, Works};
use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::fem::element::{CORNERS_MAX, corners};
use crate::fem::elements::{Held, Holder};

impl<S: Space> World<'_, S> {
    /// Between the kick of nodes and their drift: books the work of the one, and energies where they are wanted.
    pub(crate) fn book_elements(&mut self) {
        if !self.books_points() {
            return;
        }
        let timer = self.phases.start();
        let works = self.works_on_elements();
        self.book(works, |world| world.stored_in_elements());
        self.point_ledger.forces = self.assembly.forces_wanted.then(|| self.forces_of_nodes());
        self.phases.stop(Phase::Output, timer);
    }

    /// Share of the forces of elements that is not in balance at nodes, after Liu et al. (2016), eq. 57:
    /// `I_uf = sqrt(mean f^2 over nodes / mean f^2 over the corners of elements)`, loads counted with the corners that they act on, at the last evaluation. Collective.
    pub fn unbalanced_of_nodes(&self) -> Result<f64, Error> {
        let [nodes, unbalanced, corners, borne] = self.reduce(self.point_ledger.forces.clone().unwrap_or_default())?;
        Ok(if borne > 0.0 { ((unbalanced / nodes) / (borne / corners)).sqrt() } else { 0.0 })
    }

    /// What moves nodes, without damping, once bodies and faces have held them; and what elements put on their corners.
    fn forces_of_nodes(&self) -> ExactSum<FORCES> {
        let (mut sums, elements) = (ExactSum::new(), &self.elements);
        let per_step = 1.0 / self.free_motion().dt;
        for row in (0..elements.nodes.len()).filter(|row| elements.owned[*row]) {
            let gained = (elements.nodes[row].velocity - elements.before[row]) * elements.masses[row];
            let force = (gained + elements.damped[row]) * per_step;
            sums.add(0, 1.0);
            sums.add(1, force.dot(&force));
        }
        for forces in elements.corner_forces[..elements.rows.len() * CORNERS_MAX].chunks_exact(CORNERS_MAX) {
            for force in &forces[..corners::<S>()] {
                sums.add(2, 1.0);
                sums.add(3, force.dot(force));
            }
        }
        sums
    }

    /// What elements and nodes of this rank have, kinetic energy at the velocities of before.
    fn stored_in_elements(&self) -> ExactSum<STORES> {
        let (mut sums, elements) = (ExactSum::new(), &self.elements);
        for (row, node) in elements.nodes.iter().enumerate().filter(|(row, _)| elements.owned[*row]) {
            let (mass, velocity) = (elements.masses[row], self.behind(row));
            sums.add(Store::Kinetic as usize, 0.5 * mass * velocity.dot(&velocity));
            let meshed = self.settings.meshed.as_ref().expect("nodes are those of a mesh");
            let place = meshed.mesh.place(node.id) + node.displacement;
            sums.add(Store::Potential as usize, -self.settings.grains.field.gravity.dot(&place) * mass);
        }
        for (hot, hourglass) in self.continuum.points.hot.iter().zip(&elements.hourglass) {
            let elastic = hot.volume * self.settings.material.elastic_energy(&hot.memory);
            sums.add(Store::Elastic as usize, elastic + *hourglass);
            sums.add(Store::Dissipated as usize, hot.volume * hot.plastic_work);
            sums.add(Store::Beside as usize, *hourglass);
        }
        sums
    }

    /// Velocity of a node half a step behind its place, m/s; that of the very first step follows from the one ahead.
    fn behind(&self, node: usize) -> S::Vector {
        let (before, after) = (self.elements.before[node], self.elements.nodes[node].velocity);
        match self.kick_share() {
            1.0 => before,
            share => after - (after - before) * (1.0 / share),
        }
    }

    fn works_on_elements(&self) -> Works {
        let (mut works, elements) = (Works::default(), &self.elements);
        let (dt, missing) = (self.dt_of_continuum(), self.gravity_now() - self.settings.grains.field.gravity);
        // Impulses of the first step are those of a part of it.
        let whole = 1.0 / self.kick_share();
        let velocities = |node: usize| [self.behind(node), elements.nodes[node].velocity];
        for node in (0..elements.nodes.len()).filter(|node| elements.owned[*node]) {
            let (mass, velocities) = (elements.masses[node], velocities(node));
            works.add(Item::Nodes, &((velocities[AHEAD] - velocities[BEHIND]) * mass), &velocities);
            if missing != S::Vector::zero() {
                works.add(Item::Ramp, &(missing * (mass * dt)), &velocities);
            }
            works.add(Item::Holds, &(elements.damped[node] * whole), &velocities);
        }
        for push in &elements.pushes {
            works.add(Item::Loads, &(push.force * dt), &velocities(push.node as usize));
        }
        for Held { node, by, impulse, place } in &elements.held {
            let (impulse, velocities) = (*impulse * whole, velocities(*node as usize));
            let with = match by {
                Holder::Face { .. } => [S::Vector::zero(); 2],
                Holder::Body(body) => {
                    let (rigid, motion) = (&self.bodies[*body], &self.point_ledger.bodies[*body]);
                    [rigid.velocity_in(motion, place), rigid.velocity_at(place)]
                }
            };
            works.add(Item::Bodies, &impulse, &with);
            works.add(Item::Holds, &impulse, &[with[BEHIND] - velocities[BEHIND], with[AHEAD] - velocities[AHEAD]]);
        }
        works
    }
}
