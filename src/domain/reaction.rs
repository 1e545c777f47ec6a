//! What the material does to the bodies within a step, summed over all ranks, and how they move on under it.

use scree_partition::ExactSum;

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::bodies::body::{BODIES_MAX, Body, Reaction};
use crate::dem::walls::place_beside;
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::face_rows::is_met_by;

/// Sums over a body: force, torque and momentum of nodes (three components each), mass of nodes, and what its servo did not foresee.
pub(crate) const BODY_SLOTS: usize = 11;
const UNFORESEEN: usize = 10;

impl<S: Space> World<'_, S> {
    /// The body that holds a node at height `y`.
    pub(crate) fn holder(bodies: &[Body<S>], y: f64, cell: f64) -> Option<usize> {
        bodies.iter().position(|body| body.holds(y, cell))
    }

    pub(crate) fn accelerate_bodies(&mut self) -> Result<(), Error> {
        let timer = self.phases.start();
        let outcome = match self.bodies.len() {
            0 => Ok(()),
            1..=2 => self.accelerate::<{ 2 * BODY_SLOTS }>(),
            _ => self.accelerate::<{ BODIES_MAX * BODY_SLOTS }>(),
        };
        self.phases.stop(Phase::Bodies, timer);
        outcome
    }

    fn accelerate<const SLOTS: usize>(&mut self) -> Result<(), Error> {
        // The same on every rank, for what all of them know alone decides it.
        let has_nodes = self.has_grid() || self.has_elements();
        let feels_nodes = has_nodes && self.bodies.iter().any(Body::feels_nodes);
        // Forces on nodes and bodies in the middle of a cycle of several steps are not those of its beginning.
        let foresees = self.settings.grain_steps > 1 && feels_nodes;
        let mut sums = [0.0; SLOTS];
        if self.has_grains() || feels_nodes {
            let mut here = ExactSum::<SLOTS>::new();
            if foresees {
                self.reactions.take_unforeseen(&mut here, (UNFORESEEN, BODY_SLOTS));
            }
            self.add_grains(&mut here);
            if feels_nodes && self.has_elements() {
                self.add_nodes_of_elements(&mut here);
            } else if feels_nodes {
                self.add_nodes(&mut here);
                self.add_columns(&mut here);
            }
            sums = here.reduce(self.transport).map_err(|error| {
                Error::Run(format!("step {}: the forces on the bodies are not finite or beyond reason ({error}); the run is unstable: check the time step and the last frames", self.step))
            })?;
        }
        // Velocities are those of the middle of the step, so that the way of a body is the integral of its path.
        let (dt, kick) = (self.dt_of_continuum(), self.kick_share());
        let (time, booked) = (self.time() + 0.5 * dt, self.books_plates());
        let Self { bodies, reactions, transport, .. } = self;
        for (number, (body, slots)) in bodies.iter_mut().zip(sums.chunks_exact(BODY_SLOTS)).enumerate() {
            let reaction = reaction(slots, kick);
            body.accelerate(&reaction, time, dt);
            if let Some(servo) = body.servo.as_ref().filter(|_| foresees && transport.rank() == 0) {
                reactions.foresee(number, reaction.impulse(&body.velocity, dt).dot(&servo.direction));
            }
            // Else it is booked as it comes.
            if !(booked && body.is_plate()) {
                body.account(&reaction, dt);
            }
        }
        Ok(())
    }

    /// What the grains of this rank do to the bodies that they are glued to or touch.
    fn add_grains<const SLOTS: usize>(&self, sums: &mut ExactSum<SLOTS>) {
        self.assembly.pushes_on(&self.bodies, |body, force, torque| {
            for axis in 0..S::DIMENSION {
                sums.add(BODY_SLOTS * body + axis, force[axis]);
            }
            for axis in 0..S::Spin::COMPONENTS {
                sums.add(BODY_SLOTS * body + 3 + axis, torque[axis]);
            }
        });
    }

    /// What the nodes of this rank bring along that bodies move with them.
    fn add_nodes<const SLOTS: usize>(&self, sums: &mut ExactSum<SLOTS>) {
        let (gravity, dt) = (self.gravity_now(), self.dt_of_continuum());
        let mut add = |body: usize, momentum: &S::Vector, mass: f64| {
            for axis in 0..S::DIMENSION {
                sums.add(BODY_SLOTS * body + 6 + axis, momentum[axis]);
            }
            sums.add(BODY_SLOTS * body + 9, mass);
        };
        let carries = self.bodies.iter().any(Body::carries);
        let coupled = self.is_coupled();
        for (number, (node, sum)) in
            self.subdomain.nodes.mosaic.owned.iter().zip(&self.continuum.tiles.sums).enumerate()
        {
            if sum.mass() <= 0.0 {
                continue;
            }
            let holder = Self::holder(&self.bodies, self.node_height(node.place), self.subdomain.layout.cell);
            if holder.is_none() && !carries {
                continue;
            }
            let (mut momentum, mut mass) =
                (sum.momentum() + sum.force() * dt + gravity * (sum.mass() * dt), sum.mass());
            if coupled {
                // A body holds what a node makes of both.
                let grains = &self.continuum.tiles.grain_sums[number];
                momentum += grains.momentum() - grains.given();
                mass += grains.mass();
            }
            if let Some(body) = holder {
                add(body, &momentum, mass);
                continue;
            }
            let place: S::Vector = self.subdomain.layout.node_at(node.place);
            let met_by = self.continuum.tiles.faces.met_by(&self.subdomain.nodes.mosaic, number);
            for (body, held) in self.bodies.iter().enumerate().filter(|(_, body)| !is_met_by(met_by, body)) {
                let place = place_beside(held, &self.assembly.cell, &place);
                if let Some((momentum, mass)) = held.carried(&place, &momentum, mass) {
                    add(body, &momentum, mass);
                }
            }
        }
    }
}

/// The reaction of a body from its sums.
fn reaction<S: Space>(slots: &[f64], kick: f64) -> Reaction<S> {
    let mut reaction: Reaction<S> = Reaction {
        force: S::Vector::zero(),
        torque: S::Spin::zero(),
        kick,
        node_mass: slots[9],
        node_momentum: S::Vector::zero(),
        unforeseen: slots[UNFORESEEN],
    };
    for axis in 0..S::DIMENSION {
        reaction.force[axis] = slots[axis];
        reaction.node_momentum[axis] = slots[6 + axis];
    }
    for axis in 0..S::Spin::COMPONENTS {
        reaction.torque[axis] = slots[3 + axis];
    }
    reaction
}
