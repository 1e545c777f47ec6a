//! Contacts of grains with bodies: the same law, one grain at a time. They are few.

use crate::base::ids::{GrainId, Row};
use crate::base::lane::Real;
use crate::base::space::{Linear, Space};
use crate::bodies::body::{BODIES_MAX, Body, Nearest};
use crate::dem::cell::{Cell, Image};
use crate::dem::contacts::deeper;
use crate::dem::grains::{Grains, Hot, Mover, body_partner, lanes, vector};
use crate::dem::law::{Law, SharedLaw};
use crate::dem::memories::Carried;
use crate::law::contact::{FLAT, Memory, Touch};

/// A grain near a body.
#[derive(Clone, Debug)]
pub struct Wall<S: Space> {
    /// Of the grain, which is free and owned.
    pub row: Row,
    /// Its number among the bodies of the world.
    pub body: u8,
    /// After the last evaluation; blank where the two do not touch.
    pub memory: Memory,
    /// Force on the grain and where it acts on the body, of the last evaluation, N and m; and where the grain stands against
    /// its image beside the body, m.
    pub force: S::Vector,
    /// Where the force acts on the body, m.
    pub point: S::Vector,
    /// From the grain's image beside the body to the grain, m.
    pub shift: S::Vector,
    /// Resistance to rolling on the grain, N m.
    pub moment: S::Spin,
}

/// What a contact with a body does to a grain.
#[derive(Clone, Copy, Debug)]
pub struct Load<S: Space> {
    /// Of the grain.
    pub row: usize,
    /// N, N m.
    pub load: (S::Vector, S::Spin),
    /// Its part in the Love-Weber sum, J, and the energy of its springs, J.
    pub moment: S::Tensor,
    /// J, weighted.
    pub elastic: f64,
}

/// Grains near bodies in the order of rows, then bodies.
#[derive(Clone, Debug)]
pub struct Walls<S: Space> {
    /// One entry for each grain and body that are near each other.
    pub list: Vec<Wall<S>>,
    /// Laws of bodies in their order, where grains touch them otherwise than each other; empty where they do not.
    pub laws: Vec<SharedLaw<S>>,
}

impl<S: Space> Default for Walls<S> {
    fn default() -> Self {
        Self { list: Vec::new(), laws: Vec::new() }
    }
}

impl<S: Space> Walls<S> {
    /// Lists the free owned grains closer to a body than contact plus `margin`; memories are moved along.
    pub fn rebuild<I: Iterator<Item = Carried>>(
        &mut self,
        law: &dyn Law<S>,
        grains: &Grains<S>,
        (bodies, cell): (&[Body<S>], &Cell<S>),
        carried: impl Fn(usize) -> I,
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
                bodies.iter().enumerate().map(|(index, body)| (index as u8, nearest(body, cell, &cold.home)))
            {
                if nearest.is_some_and(|nearest| nearest.distance < hot.radius + margin) {
                    let memory = carried(row).find(|(partner, _)| *partner == body_partner(body));
                    let memory = memory.map_or_else(|| Memory::blank(law.memory_words()), |(_, memory)| memory);
                    let zero = S::Vector::zero();
                    self.list.push(Wall {
                        row: row as Row,
                        body,
                        memory,
                        force: zero,
                        point: zero,
                        shift: zero,
                        moment: S::Spin::zero(),
                    });
                }
            }
        }
    }

    /// Memories of the touching contacts of a row with bodies, in their order.
    pub fn carried_by(&self, row: usize) -> impl Iterator<Item = Carried> + '_ {
        let first = self.list.partition_point(|wall| (wall.row as usize) < row);
        let ours = self.list[first..].iter().take_while(move |wall| wall.row as usize == row);
        ours.filter(|wall| !wall.memory.is_blank()).map(|wall| (body_partner(wall.body), wall.memory))
    }

    /// The law of contacts with a body; `law` is that of grains with each other.
    pub fn law_of<'a>(&'a self, body: u8, law: &'a dyn Law<S>) -> &'a dyn Law<S> {
        self.laws.get(body as usize).map_or(law, |law| &**law)
    }

    /// Evaluates every contact and adds its force to the grain's; after the grains' own sums.
    pub fn evaluate(
        &mut self,
        law: &dyn Law<S>,
        grains: &mut Grains<S>,
        (bodies, cell): (&[Body<S>], &Cell<S>),
        [advance, dt]: [f64; 2],
    ) {
        let Self { list, laws } = self;
        for wall in list {
            let law = laws.get(wall.body as usize).map_or(law, |law| &**law);
            let (row, body) = (wall.row as usize, &bodies[wall.body as usize]);
            let (hot, shift) = beside(body, cell, &grains.hot[row]);
            let Some(nearest) = body.nearest(&hot.position) else { continue };
            let touch = touch_of(&hot, body, (body.velocity, body.spin), &nearest, [advance, dt]);
            let arm = hot.radius - 0.5 * touch.overlap;
            let given = law.give(&touch, hot.weight, [arm, 0.0], &mut wall.memory);
            wall.force = vector(&given.force);
            // Without an arm the body's side holds the resistance to rolling alone.
            wall.moment = -vector::<S::Spin, _>(&given.torque_b);
            (wall.point, wall.shift) = (middle(&nearest, touch.overlap), shift);
            grains.force[row] += wall.force;
            grains.torque[row] += vector::<S::Spin, _>(&given.torque_a);
        }
    }

    /// Elastic energies of the contacts, weighted, J.
    pub fn elastic_energies<'a>(
        &'a self,
        law: &'a dyn Law<S>,
        grains: &'a Grains<S>,
        (bodies, cell): (&'a [Body<S>], &'a Cell<S>),
    ) -> impl Iterator<Item = f64> + 'a {
        self.list.iter().filter_map(move |wall| {
            let body = &bodies[wall.body as usize];
            let (hot, _) = beside(body, cell, &grains.hot[wall.row as usize]);
            let touch = touch_of(&hot, body, (body.velocity, body.spin), &body.nearest(&hot.position)?, [0.0, 0.0]);
            let law = self.law_of(wall.body, law);
            law.holds(&touch, &wall.memory).then(|| hot.weight * law.elastic_energy(&touch, &wall.memory))
        })
    }

    /// What every contact that holds does at the coming evaluation, in the order of rows, then bodies.
    pub fn loads<'a>(
        &'a self,
        law: &'a dyn Law<S>,
        grains: &'a Grains<S>,
        (bodies, cell): (&'a [Body<S>], &'a Cell<S>),
        times: [f64; 2],
    ) -> impl Iterator<Item = Load<S>> + 'a {
        self.list.iter().filter_map(move |wall| {
            let (law, body) = (self.law_of(wall.body, law), &bodies[wall.body as usize]);
            let (hot, _) = beside(body, cell, &grains.hot[wall.row as usize]);
            let nearest = body.nearest(&hot.position)?;
            let touch = touch_of(&hot, body, (body.velocity, body.spin), &nearest, times);
            let mut memory = wall.memory;
            if !law.holds(&touch, &memory) {
                return None;
            }
            let arm = hot.radius - 0.5 * touch.overlap;
            let given = law.give(&touch, hot.weight, [arm, 0.0], &mut memory);
            let force: S::Vector = vector(&given.force);
            Some(Load {
                row: wall.row as usize,
                load: (force, vector(&given.torque_a)),
                moment: S::outer(&force, &(middle(&nearest, touch.overlap) - hot.position)),
                elastic: hot.weight * law.elastic_energy(&touch, &memory),
            })
        })
    }

    /// The deepest overlap of a grain with a body, as a share of its radius, with its id and the body's.
    pub fn deepest(&self, grains: &Grains<S>, (bodies, cell): (&[Body<S>], &Cell<S>)) -> Option<(f64, [GrainId; 2])> {
        let shares = self.list.iter().filter_map(|wall| {
            let (row, body) = (wall.row as usize, &bodies[wall.body as usize]);
            let (hot, _) = beside(body, cell, &grains.hot[row]);
            let overlap = hot.radius - body.nearest(&hot.position)?.distance;
            Some((overlap / hot.radius, [grains.cold[row].id, body_partner(wall.body)]))
        });
        shares.max_by(deeper)
    }

    /// Bytes that the list holds.
    pub fn bytes(&self) -> usize {
        self.list.capacity() * size_of::<Wall<S>>()
    }

    /// Force and torque (about the body's origin) of the grains on each body, one addend a contact.
    pub fn reactions_of(&self, bodies: &[Body<S>], mut add: impl FnMut(usize, S::Vector, S::Spin)) {
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

/// Where a body has its image nearest to a place, the point of its surface nearest to that, both beside the body itself.
pub fn nearest<S: Space>(body: &Body<S>, cell: &Cell<S>, place: &S::Vector) -> Option<Nearest<S>> {
    body.nearest(&place_beside(body, cell, place))
}

/// The image of a place beside a body itself.
pub fn place_beside<S: Space>(body: &Body<S>, cell: &Cell<S>, place: &S::Vector) -> S::Vector {
    *place - cell.shift(image_beside(body, cell, place))
}

/// A grain as its image beside a body stands and moves, and what the grain itself lies away from it, m.
pub fn beside<S: Space>(body: &Body<S>, cell: &Cell<S>, hot: &Hot<S>) -> (Hot<S>, S::Vector) {
    let image = image_beside(body, cell, &hot.position);
    let (mut moved, shift) = (*hot, cell.shift(image));
    moved.position -= shift;
    moved.velocity -= cell.shift_rate(image);
    (moved, shift)
}

fn image_beside<S: Space>(body: &Body<S>, cell: &Cell<S>, place: &S::Vector) -> Image {
    if body.is_bounded() { cell.image_towards(&body.origin(), place) } else { [0; 3] }
}

/// Where a contact's force acts: in the middle of the overlap, as the grain's arm has it; else the couple of the two sides
/// would make angular momentum.
pub(super) fn middle<S: Space>(nearest: &Nearest<S>, overlap: f64) -> S::Vector {
    nearest.point - nearest.normal * (0.5 * overlap)
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
    use crate::base::space::Lanewise;

    Touch {
        normal,
        overlap: hot.radius - nearest.distance,
        radius_a: hot.radius,
        radius_b: nearest.radius,
        mass_a: hot.mass,
        mass_b: FLAT,
        velocity_normal: relative.dot(&normal),
        velocity_centres,
        velocity_tangential: velocity_centres - S::surface(&normal, &(spin * hot.radius)),
        spin_relative: spin - spin_body,
        twist: S::twist(&normal, &(spin + spin_body)) * (f64::splat(0.5) * dt),
        advance,
    }
}
