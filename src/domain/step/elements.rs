//! The step of a continuum of elements: central differences, velocities half a step behind the places of nodes.

use rayon::prelude::*;

use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::bodies::body::{Body, MeshSide};
use crate::bodies::boundary::{Grip, Hold};
use crate::dem::cell::Cell;
use crate::dem::grains::{lanes, vector};
use crate::dem::motion::Damping;
use crate::dem::walls::place_beside;
use crate::domain::phases::Phase;
use crate::domain::reaction::BODY_SLOTS;
use crate::domain::world::World;
use crate::fem::elements::{Elements, Held, Holder};
use crate::fem::hourglass::Hourglass;
use crate::fem::node::Node;
use crate::job::mpm::Boundary;
use crate::mpm::points::Hot;
use crate::mpm::strain::Rates;
use scree_partition::ExactSum;

/// Steps between two looks at who should have which elements.
const DEAL_EVERY: u64 = 256;
/// Fewer nodes are not worth a task of their own.
const NODES_PER_TASK: usize = 1024;

/// What pushes and holds nodes of a mesh beside the forces of elements.
struct Conditions<'a, S: Space> {
    bodies: &'a [Body<S>],
    periods: &'a Cell<S>,
    faces: &'a [[Boundary; 2]; 3],
    walls: &'a [[f64; 2]; 3],
}

/// A node as it is held.
struct At<S: Space> {
    /// Where it is, m.
    place: S::Vector,
    sides: u64,
    mass: f64,
}

/// Forces, gravity and damping of a node.
pub(crate) struct FreeMotion<S: Space> {
    damping: Damping,
    pub gravity: S::Vector,
    /// Half a step in the very first one, before which velocities are those of time zero.
    pub dt: f64,
}

impl<S: Space> FreeMotion<S> {
    fn acceleration(&self, force: &S::Vector, mass: f64) -> S::Vector {
        *force * (1.0 / mass) + self.gravity
    }

    /// Velocity of a node after a step, before damping and before anything holds it, m/s.
    pub fn velocity(&self, before: &S::Vector, force: &S::Vector, mass: f64) -> S::Vector {
        *before + self.acceleration(force, mass) * self.dt
    }

    /// The same with damping.
    fn damped(&self, before: &S::Vector, force: &S::Vector, mass: f64) -> S::Vector {
        let acceleration = self.acceleration(force, mass);
        let opposed: S::VectorOf<f64> = self.damping.opposed(lanes(&acceleration), &lanes(before), self.dt);
        *before + vector::<S::Vector, _>(&opposed) * self.dt
    }
}

impl<S: Space> World<'_, S> {
    /// The step as a table of contents.
    pub(crate) fn step_of_elements(&mut self) -> Result<(), Error> {
        self.open_page();
        self.fill_nodes();
        self.accelerate_bodies()?;
        self.advance_elements();
        self.book_elements();
        match self.has_nonlocal_law() {
            true => self.strain_by_means(Self::drift_elements)?,
            false => self.drift_elements(),
        }
        self.follow_by_grains()?;
        self.drift_bodies();
        Ok(())
    }

    /// Who has which elements is looked at every so many steps: no place changes it. Collective.
    pub(crate) fn deal_elements_if_due(&mut self) -> Result<(), Error> {
        match self.step.is_multiple_of(DEAL_EVERY) && self.transport.size() > 1 {
            true => self.settle_anew(),
            false => Ok(()),
        }
    }

    pub(crate) fn hourglass(&self) -> Hourglass {
        let material = &self.settings.material;
        Hourglass {
            shear_modulus: material.shear_modulus(),
            p_wave_modulus: material.p_wave_modulus(),
            coefficient: self.settings.meshed.as_ref().map_or(1.0, |meshed| meshed.hourglass),
            yields: material.flows(),
        }
    }

    /// Forces of elements and loads on nodes, those of other ranks' elements among them.
    fn fill_nodes(&mut self) {
        let timer = self.phases.start();
        let (how, time) = (self.hourglass(), self.time() + 0.5 * self.dt_of_continuum());
        let instructions = self.assembly.contacts.instructions();
        self.elements.fill_corners(&self.continuum.points.hot, (&how, instructions));
        self.elements.push_loaded(&self.settings.loads, time, self.settings.grid.depth);
        self.phases.stop(Phase::Scatter, timer);
        match S::DIMENSION {
            2 => self.exchange_corners::<2>(),
            _ => self.exchange_corners::<3>(),
        }
        let timer = self.phases.start();
        self.elements.sum_corners();
        self.phases.stop(Phase::Nodes, timer);
    }

    fn exchange_corners<const W: usize>(&mut self) {
        self.travel(
            |world| &mut world.subdomain.corners,
            |world, slot| -> [f64; W] { std::array::from_fn(|axis| world.elements.corner_forces[slot][axis]) },
            |_| (),
            |world, slot, words| (0..W).for_each(|axis| world.elements.corner_forces[slot][axis] = words[axis]),
        );
    }

    /// What nodes bring along that servos move with bodies.
    pub(crate) fn add_nodes_of_elements<const SLOTS: usize>(&self, sums: &mut ExactSum<SLOTS>) {
        let (free, elements) = (self.free_motion(), &self.elements);
        for row in (0..elements.nodes.len()).filter(|row| elements.owned[*row]) {
            let (mass, node) = (elements.masses[row], &elements.nodes[row]);
            let momentum = free.velocity(&node.velocity, &elements.forces[row], mass) * mass;
            let place = self.place_of_node(row);
            for (number, body) in self.bodies.iter().enumerate() {
                let Some((momentum, mass)) = carried(body, (elements.sides[row], &place), &momentum, mass) else {
                    continue;
                };
                for axis in 0..S::DIMENSION {
                    sums.add(BODY_SLOTS * number + 6 + axis, momentum[axis]);
                }
                sums.add(BODY_SLOTS * number + 9, mass);
            }
        }
    }

    fn place_of_node(&self, row: usize) -> S::Vector {
        let node = &self.elements.nodes[row];
        let meshed = self.settings.meshed.as_ref().expect("nodes are those of a mesh");
        meshed.mesh.place(node.id) + node.displacement
    }

    /// How the nodes of elements move by themselves.
    pub(crate) fn free_motion(&self) -> FreeMotion<S> {
        let damping = self.settings.grains.field.damping;
        FreeMotion { damping, gravity: self.gravity_now(), dt: self.kick_share() * self.dt_of_continuum() }
    }

    /// Velocities of nodes half a step after their places, and what it took to hold them.
    fn advance_elements(&mut self) {
        let timer = self.phases.start();
        let motion = self.free_motion();
        let mut elements = std::mem::take(&mut self.elements);
        let meshed = self.settings.meshed.as_ref().expect("elements are those of a mesh");
        let conditions = Conditions {
            bodies: &self.bodies,
            periods: &self.assembly.cell,
            faces: &self.settings.grid.faces,
            walls: &meshed.walls,
        };
        let Elements { nodes, before, damped, forces, masses, sides, owned, held, .. } = &mut elements;
        let is_damped = !self.settings.grains.field.is_plain();
        let inner_free = conditions.inner_nodes_are_free();
        let is_free = |row: usize| inner_free && sides[row] == 0;
        let hold = |taken: &mut Vec<Held<S>>, row: usize, node: &mut Node<S>, [before, damped]: [&mut S::Vector; 2]| {
            *before = node.velocity;
            let mass = masses[row];
            let at = At { place: meshed.mesh.place(node.id) + node.displacement, sides: sides[row], mass };
            let mut keep = |by, impulse, place| {
                if owned[row] {
                    taken.push(Held { node: row as u32, by, impulse, place });
                }
            };
            // What holds a node bears all of the force on it, of which damping is no part: it acts along what is left free.
            let undamped = conditions.hold(motion.velocity(before, &forces[row], mass), &at, &mut keep);
            node.velocity = match is_damped {
                true => conditions.hold(motion.damped(before, &forces[row], mass), &at, &mut |_, _, _| ()),
                false => undamped,
            };
            *damped = (undamped - node.velocity) * mass;
        };
        let rows = nodes.par_iter_mut().zip(&mut *before).zip(&mut *damped).enumerate();
        rows.with_min_len(NODES_PER_TASK).for_each(|(row, ((node, before), damped))| {
            if is_free(row) {
                let mass = masses[row];
                *before = node.velocity;
                let free = motion.velocity(before, &forces[row], mass);
                node.velocity = if is_damped { motion.damped(before, &forces[row], mass) } else { free };
                *damped = (free - node.velocity) * mass;
            }
        });
        let rows = nodes.par_iter_mut().zip(before).zip(damped).enumerate().with_min_len(NODES_PER_TASK);
        let rows = rows.filter(|(row, _)| !is_free(*row));
        let taken = rows.fold(Vec::new, |mut taken, (row, ((node, before), damped))| {
            hold(&mut taken, row, node, [before, damped]);
            taken
        });
        *held = taken.reduce(Vec::new, |mut all, more| {
            all.extend(more);
            all
        });
        self.elements = elements;
        self.book_holds(motion.dt);
        self.phases.stop(Phase::Nodes, timer);
    }

    /// What bodies and faces took, and loads gave.
    fn book_holds(&mut self, dt: f64) {
        let Self { elements, reactions, bodies, .. } = self;
        for Held { by, impulse, place, .. } in &elements.held {
            match *by {
                Holder::Face { axis, upper } => reactions.on_face::<S>(axis, upper, &-*impulse),
                Holder::Body(body) => {
                    let (number, body) = (body, &bodies[body]);
                    let arm = *place - body.origin();
                    reactions.on_body((number, body), &-*impulse, &S::moment(&arm, &-*impulse));
                }
            }
        }
        elements.pushes.iter().for_each(|push| reactions.of_load::<S>(&(push.force * dt)));
    }

    /// Nodes drift, and the material follows where its law answers to the strain of each element by itself.
    pub(super) fn drift_elements(&mut self) {
        let timer = self.phases.start();
        let dt = self.dt_of_continuum();
        let how = self.hourglass();
        let points = &mut self.continuum.points.hot;
        let instructions = self.assembly.contacts.instructions();
        let (material, settings) = (&self.settings.material, &self.settings);
        let is_local = settings.rves.is_none() && settings.nonlocal.is_none();
        let strained = |rates: &[Rates], points: &mut [Hot<S>]| {
            if is_local {
                material.strain((rates, dt, instructions), points);
            }
        };
        self.elements.drift(points, (dt, instructions), strained, is_local.then_some(&how));
        self.phases.stop(Phase::Gather, timer);
    }

    fn drift_bodies(&mut self) {
        let timer = self.phases.start();
        let dt = self.settings.grains.dt;
        self.bodies.iter_mut().for_each(|body| body.drift(dt));
        self.phases.stop(Phase::Motion, timer);
    }
}

/// Inwards from a side of the domain.
pub(crate) fn inwards<S: Space>(axis: usize, upper: bool) -> S::Vector {
    let mut normal = S::Vector::zero();
    normal[axis] = if upper { -1.0 } else { 1.0 };
    normal
}

/// From what is fastened to a body into the material: of a face of the domain by its axis, of a group as the body's own face lies.
pub(crate) fn into_material<S: Space>(body: &Body<S>, side: MeshSide, place: &S::Vector) -> S::Vector {
    match side {
        MeshSide::Face { axis, upper } => inwards::<S>(axis, upper),
        MeshSide::Groups(_) => body.nearest(place).map_or(S::Vector::zero(), |nearest| nearest.normal),
    }
}

/// Momentum (N s) and mass (kg) of a node that a servo moves with the body, see [`Body::carried`].
fn carried<S: Space>(
    body: &Body<S>,
    (sides, place): (u64, &S::Vector),
    momentum: &S::Vector,
    mass: f64,
) -> Option<(S::Vector, f64)> {
    let Some(side) = body.side else { return body.carried(place, momentum, mass) };
    let ((grip, _), servo) = (body.grip?, body.servo.as_ref()?);
    if !side.has(sides) {
        return None;
    }
    Some(match grip {
        Grip::Rough => (*momentum, mass),
        Grip::Smooth | Grip::Coulomb(_) => {
            let (normal, along) = (into_material(body, side, place), servo.direction);
            let along_normal = normal.dot(&along);
            (along * (momentum.dot(&normal) * along_normal), mass * along_normal * along_normal)
        }
    })
}

impl<S: Space> Conditions<'_, S> {
    /// Whether nodes on no side are free: no body and no face with friction holds what comes into it.
    fn inner_nodes_are_free(&self) -> bool {
        let comes_in = |face: &Boundary| matches!(face, Boundary::Friction { .. });
        !self.bodies.iter().any(|body| body.grip.is_some() && body.side.is_none())
            && !self.faces.iter().flatten().any(comes_in)
    }

    /// The velocity of a node that forces would give `free`, after every body and every face of the domain that it is on has held it; `keep` is told of
    /// each by how much.
    fn hold(&self, free: S::Vector, at: &At<S>, keep: &mut impl FnMut(Holder, S::Vector, S::Vector)) -> S::Vector {
        let mut velocity = free;
        for (number, body) in self.bodies.iter().enumerate() {
            let Some((grip, separates)) = body.grip else { continue };
            let place = place_beside(body, self.periods, &at.place);
            let (normal, separates) = match body.side {
                // What is fastened stays, whatever rounding says of its place.
                Some(side) if side.has(at.sides) => (into_material(body, side, &place), false),
                Some(_) => continue,
                None => match body.nearest(&place).filter(|nearest| nearest.distance <= 0.0) {
                    Some(nearest) => (nearest.normal, separates),
                    None => continue,
                },
            };
            let hold = Hold::<S> { grip, separates, normal, velocity: body.velocity_at(&place) };
            let after = hold.on(&velocity, &velocity);
            if after != velocity || !separates {
                keep(Holder::Body(number), (after - velocity) * at.mass, place);
            }
            velocity = after;
        }
        for axis in 0..S::DIMENSION {
            for upper in [false, true] {
                let Some(after) = self.held_by_face(velocity, at, (axis, upper)) else { continue };
                keep(Holder::Face { axis, upper }, (after - velocity) * at.mass, at.place);
                velocity = after;
            }
        }
        velocity
    }

    /// None where it does not hold the node.
    fn held_by_face(&self, velocity: S::Vector, at: &At<S>, (axis, upper): (usize, bool)) -> Option<S::Vector> {
        if at.sides & MeshSide::given_up(axis, upper) != 0 {
            return None;
        }
        let is_on = MeshSide::Face { axis, upper }.has(at.sides);
        let wall = self.walls[axis][usize::from(upper)];
        let is_behind = if upper { at.place[axis] >= wall } else { at.place[axis] <= wall };
        let hold = |grip, separates| Hold::<S> {
            grip,
            separates,
            normal: inwards::<S>(axis, upper),
            velocity: S::Vector::zero(),
        };
        match self.faces[axis][usize::from(upper)] {
            Boundary::Fixed if is_on => Some(S::Vector::zero()),
            Boundary::Roller if is_on => Some(hold(Grip::Smooth, false).on(&velocity, &velocity)),
            Boundary::Friction { coefficient } if is_behind => {
                let after = hold(Grip::Coulomb(coefficient), true).on(&velocity, &velocity);
                (after != velocity).then_some(after)
            }
            _ => None,
        }
    }
}
