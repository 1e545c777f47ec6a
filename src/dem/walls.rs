//! Contacts of grains with bodies: the same law, one grain at a time. They are few.

use crate::body::{BODIES_MAX, Body, Nearest};
use crate::dem::contacts::first_of_bodies;
use crate::dem::grains::{Grains, Hot, Mover, body_partner, lanes, vector};
use crate::dem::kernel::{Given, give};
use crate::ids::{GrainId, Row};
use crate::lane::Real;
use crate::law::contact::{ContactLaw, Touch};
use crate::space::{Linear, Space, Words};

/// A grain near a body.
#[derive(Clone, Debug)]
pub struct Wall<S: Space, M> {
    pub row: Row,
    pub body: u8,
    pub memory: M,
    /// Force on the grain and where it acts, of the last evaluation, N and m.
    pub force: S::Vector,
    pub point: S::Vector,
    /// Resistance to rolling on the grain, N m.
    pub moment: S::Spin,
}

/// Grains near bodies in the order of rows, then bodies.
#[derive(Clone, Debug)]
pub struct Walls<S: Space, C: ContactLaw<S>> {
    pub list: Vec<Wall<S, C::Memory<f64>>>,
}

impl<S: Space, C: ContactLaw<S>> Default for Walls<S, C> {
    fn default() -> Self {
        Self { list: Vec::new() }
    }
}

impl<S: Space, C: ContactLaw<S>> Walls<S, C> {
    /// Lists the free owned grains closer to a body than contact plus `margin`; memories are moved along.
    pub fn rebuild<'m>(
        &mut self,
        grains: &Grains<S>,
        bodies: &[Body<S>],
        carried: impl Fn(usize) -> &'m [(GrainId, C::Memory<f64>)],
        margin: f64,
    ) {
        self.list.clear();
        if !bodies.iter().any(Body::is_touched) {
            return;
        }
        for row in 0..grains.owned {
            let (hot, cold) = (&grains.hot[row], &grains.cold[row]);
            if cold.mover != Mover::Free {
                continue;
            }
            for (body, nearest) in
                bodies.iter().enumerate().map(|(index, body)| (index as u8, body.nearest(&cold.home)))
            {
                if nearest.is_some_and(|nearest| nearest.distance < hot.radius + margin) {
                    let memories = carried(row);
                    let memories = &memories[first_of_bodies(memories)..];
                    let memory = memories.iter().find(|(partner, _)| *partner == body_partner(body));
                    let memory = memory.map_or_else(Words::zero, |(_, memory)| *memory);
                    let zero = S::Vector::zero();
                    self.list.push(Wall {
                        row: row as Row,
                        body,
                        memory,
                        force: zero,
                        point: zero,
                        moment: S::Spin::zero(),
                    });
                }
            }
        }
    }

    /// Memories of the touching contacts of a row with bodies, in their order.
    pub fn carried_by(&self, row: usize) -> impl Iterator<Item = (GrainId, C::Memory<f64>)> + '_ {
        let first = self.list.partition_point(|wall| (wall.row as usize) < row);
        let ours = self.list[first..].iter().take_while(move |wall| wall.row as usize == row);
        let remembered =
            ours.filter(|wall| (0..<C::Memory<f64> as Words<f64>>::COUNT).any(|word| wall.memory.word(word) != 0.0));
        remembered.map(|wall| (body_partner(wall.body), wall.memory))
    }

    /// Evaluates every contact and adds its force to the grain's; after the grains' own sums.
    pub fn evaluate(&mut self, law: &C, grains: &mut Grains<S>, bodies: &[Body<S>], [advance, dt]: [f64; 2]) {
        for wall in &mut self.list {
            let (row, body) = (wall.row as usize, &bodies[wall.body as usize]);
            let hot = &grains.hot[row];
            let Some(nearest) = body.nearest(&hot.position) else { continue };
            let touch = touch_of(hot, body, (body.velocity, body.spin), &nearest, [advance, dt]);
            let arm = hot.radius - 0.5 * touch.overlap;
            let given: Given<S, f64> = give(law, &touch, hot.weight, [arm, 0.0], &mut wall.memory);
            wall.force = vector(&given.force);
            // Without an arm the body's side holds the resistance to rolling alone.
            wall.moment = -vector::<S::Spin, _>(&given.torque_b);
            // In the middle of the overlap, as the grain's arm has it: else the couple of the two would make angular momentum.
            wall.point = nearest.point - nearest.normal * (0.5 * touch.overlap);
            grains.force[row] += wall.force;
            grains.torque[row] += vector::<S::Spin, _>(&given.torque_a);
        }
    }

    /// Elastic energies of the contacts, weighted, J.
    pub fn elastic_energies<'a>(
        &'a self,
        law: &'a C,
        grains: &'a Grains<S>,
        bodies: &'a [Body<S>],
    ) -> impl Iterator<Item = f64> + 'a {
        self.list.iter().filter_map(move |wall| {
            let hot = &grains.hot[wall.row as usize];
            let body = &bodies[wall.body as usize];
            let touch = touch_of(hot, body, (body.velocity, body.spin), &body.nearest(&hot.position)?, [0.0, 0.0]);
            law.holds(&touch, &wall.memory).then(|| hot.weight * law.elastic_energy(&touch, &wall.memory))
        })
    }

    /// Love-Weber moments of the contacts, J, tension positive, with the forces of the positions and velocities of now.
    pub fn moments<'a>(
        &'a self,
        law: &'a C,
        grains: &'a Grains<S>,
        bodies: &'a [Body<S>],
    ) -> impl Iterator<Item = S::Tensor> + 'a {
        self.list.iter().filter_map(move |wall| {
            let hot = &grains.hot[wall.row as usize];
            let body = &bodies[wall.body as usize];
            let nearest = body.nearest(&hot.position)?;
            let touch = touch_of(hot, body, (body.velocity, body.spin), &nearest, [0.0, 0.0]);
            let mut memory = wall.memory;
            let force: S::Vector = vector(&give(law, &touch, hot.weight, [0.0, 0.0], &mut memory).force);
            Some(-S::outer(&force, &(hot.position - nearest.point)))
        })
    }

    /// Bytes that the list holds.
    pub fn bytes(&self) -> usize {
        self.list.capacity() * size_of::<Wall<S, C::Memory<f64>>>()
    }

    /// Force and torque (about the body's origin) of the grains on each body, one addend a contact.
    pub fn burdens(&self, bodies: &[Body<S>], mut add: impl FnMut(usize, S::Vector, S::Spin)) {
        let mut origins = [S::Vector::zero(); BODIES_MAX];
        for (origin, body) in origins.iter_mut().zip(bodies) {
            *origin = body.origin();
        }
        for wall in &self.list {
            let body = wall.body as usize;
            let force = -wall.force;
            add(body, force, S::moment(&(wall.point - origins[body]), &force) - wall.moment);
        }
    }
}

/// A grain and a body, which moves with `motion` (velocity and spin), as the law sees them.
pub fn touch_of<S: Space>(
    hot: &Hot<S>,
    body: &Body<S>,
    motion: (S::Vector, S::Spin),
    nearest: &Nearest<S>,
    [advance, dt]: [f64; 2],
) -> Touch<S, f64> {
    let normal: S::VectorOf<f64> = lanes(&nearest.normal);
    let relative: S::VectorOf<f64> = lanes(&(hot.velocity - body.velocity_in(&motion, &nearest.point)));
    let (spin, spin_body): (S::SpinOf<f64>, S::SpinOf<f64>) = (lanes(&hot.spin), lanes(&motion.1));
    let velocity_centres = S::tangential(&normal, &relative);
    use crate::space::Lanewise;
    Touch {
        normal,
        overlap: hot.radius - nearest.distance,
        radius_a: hot.radius,
        radius_b: nearest.radius,
        velocity_normal: relative.dot(&normal),
        velocity_centres,
        velocity_tangential: velocity_centres - S::surface(&normal, &(spin * hot.radius)),
        spin_relative: spin - spin_body,
        twist: S::twist(&normal, &(spin + spin_body)) * (f64::splat(0.5) * dt),
        advance,
    }
}
