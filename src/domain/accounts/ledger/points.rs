//! Energies of a continuum, and where its work goes.
//!
//! Forces f(n) belong to positions x(n) and act on nodes, whose velocities are v(n) before and v'(n) after them; those of
//! points are half a step behind their positions. With J = m (v' - v) all that a step does to a node,
//!
//! ```text
//! T(n) = sum m_p (v_p.v_p + C D C^T)/2 + sum J(n).v(n)/2       kinetic energy at x(n), D as in [`crate::mpm::gather`]
//! T(n+1) - T(n) = sum J(n).v'(n)/2 + sum J(n+1).v(n+1)/2 - transfer(n)
//! ```
//!
//! so every impulse works half over the drift ahead and half over the one behind, as those of grains do, and the kinetic energy
//! that is lost between points and grid is known by itself: of points' own motion what a blend damps, and what is finer than
//! the grid or the affine fields. Elastic energy, that of gravity and what has been dissipated are those of the points at x(n),
//! with the stress that makes f(n):
//!
//! ```text
//! loads + bodies + ramp = change of (kinetic + elastic + potential + dissipated) + holds + lost
//! ```
//!
//! and what grains do to points through the nodes that both share on the side of the work,
//!
//! ```text
//! X = m_c V - (P_c + f dt + m_c g dt)      V: velocity of points and grains together before anything holds the node
//! ```
//!
//! with the powers: loads: push.v at their points, force.v at nodes of those on the surface, and force.v of membranes at their vertices, which are no part of the account
//! but for their mass; grains: X.v/dt, which with what these take ([`super`], nodes) is lost where the two are made one; bodies: force.V, the velocity of the body there; ramp: what bears the share of
//! gravity that is not there yet, for the potential is that in the whole field; holds: force.(V - v), by which friction, dashpots
//! and sudden stops take energy at faces and bodies. Gravity itself closes exactly. What is `lost` is the scheme's doing, and
//! negative where it makes energy: the transfer, what averaging of volume strain takes ([`crate::mpm::volumetric`]), and the difference between the work of stress on nodes, with the velocities on
//! either side of a transfer, and what the law has stored and dissipated, with one of them. The two belong together: where
//! strain is that of velocities which have been to the points, what the one takes the other gives back in part.

use rayon::prelude::*;
use scree_partition::ExactSum;

use super::Entry;
use crate::base::error::Error;
use crate::base::space::{Linear, Space};
use crate::dem::walls::place_beside;
use crate::domain::grid::{absorbed_by_faces, held_by_bodies, held_by_faces};
use crate::domain::phases::Phase;
use crate::domain::world::World;
use crate::mpm::look::{for_each_node, moments};
use crate::mpm::scatter::TileFrame;
use crate::mpm::scheme::{ShapeFunction, Transfer};
use crate::mpm::tile::{Advanced, Gathered, GrainNode, OwnedNode};

/// What is booked, by slot.
#[derive(Clone, Copy)]
pub(super) enum Item {
    /// Of everything that acts on nodes.
    Nodes,
    Loads,
    Bodies,
    Ramp,
    Holds,
    Grains,
}
const ITEMS: usize = 6;

/// What points have.
#[derive(Clone, Copy)]
pub(super) enum Store {
    Kinetic,
    Elastic,
    Potential,
    Dissipated,
    /// What averaging of volume strain has taken, of elements what hourglass modes have: no part of the sum. The last, for accounts of programs that had none.
    Beside,
}

pub(super) const STORES: usize = 5;

/// Entries of an account.
pub(super) const ENTRIES: usize = 2 * ITEMS + STORES;

/// Energies of the points at the last evaluation of forces, one step before the positions of now, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointEnergies {
    /// With that of affine fields, and of membranes.
    pub kinetic: f64,
    /// Stored by the law; of elements with that of hourglass modes.
    pub elastic: f64,
    /// In the whole field of gravity, zero at the origin.
    pub potential: f64,
    /// By the law, since the start.
    pub dissipated: f64,
    /// Taken by averaging of volume strain, since the start; of elements that of hourglass modes, a part of the elastic. No part of the sum.
    pub beside: f64,
}

impl PointEnergies {
    fn sum(&self) -> f64 {
        self.kinetic + self.elastic + self.potential + self.dissipated
    }
}

/// Where the work has gone since the first evaluation, J, up to the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointBalance {
    /// Of loads on points and on the surface, and of membranes.
    pub work_loads: f64,
    /// Of bodies that hold nodes, by the velocity of the body there.
    pub work_bodies: f64,
    /// Of what bears the share of gravity that is yet to come.
    pub work_ramp: f64,
    /// Of grains that share nodes with points.
    pub work_grains: f64,
    /// Change of kinetic, elastic and potential energy, and what the law has dissipated.
    pub stored: f64,
    /// By the law.
    pub dissipated: f64,
    /// Lost where faces and bodies hold nodes: friction, dashpots, sudden stops.
    pub holds: f64,
    /// Lost by the scheme; below zero it has made energy.
    pub lost: f64,
    /// Of this, kinetic energy between points and grid.
    pub transfer: f64,
    /// And what averaging of volume strain has taken from points.
    pub averaging: f64,
}

impl PointBalance {
    /// J, on the points, of all four kinds.
    pub fn work(&self) -> f64 {
        self.work_loads + self.work_bodies + self.work_ramp + self.work_grains
    }
}

/// Nodes and their unbalanced forces squared (N2), corners of elements and their forces squared.
pub(super) const FORCES: usize = 4;

/// The energies of a continuum as this rank keeps them; sums of ranks are exact.
#[derive(Clone, Debug)]
pub struct PointLedger<S: Space> {
    /// At the last evaluation at which they were wanted.
    stored: Option<ExactSum<STORES>>,
    /// Of elements, where they are wanted.
    pub(super) forces: Option<ExactSum<FORCES>>,
    account: Option<Account>,
    /// Velocity (m/s) and spin (rad/s) of bodies over the drift behind.
    pub(super) bodies: Vec<(S::Vector, S::Spin)>,
}

#[derive(Clone, Debug, Default)]
struct Account {
    /// Up to the last evaluation.
    booked: ExactSum<ITEMS>,
    /// Of its forces over the half step ahead of it.
    ahead: ExactSum<ITEMS>,
    /// At the first evaluation.
    start: Option<ExactSum<STORES>>,
}

/// The drifts on either side of an evaluation.
pub(super) const BEHIND: usize = 0;
pub(super) const AHEAD: usize = 1;

/// Work over both drifts, J.
#[derive(Clone, Debug, Default)]
pub(super) struct Works([ExactSum<ITEMS>; 2]);

impl Works {
    /// Books an impulse (N s) that acts while something moves with `velocities` (m/s) behind and ahead.
    pub(super) fn add<V: Linear>(&mut self, item: Item, impulse: &V, velocities: &[V; 2]) {
        for (work, velocity) in self.0.iter_mut().zip(velocities) {
            work.add(item as usize, 0.5 * impulse.dot(velocity));
        }
    }

    fn merged(mut self, other: Self) -> Self {
        self.0.iter_mut().zip(&other.0).for_each(|(work, more)| work.merge(more));
        self
    }
}

impl<S: Space> Default for PointLedger<S> {
    fn default() -> Self {
        Self { stored: None, forces: None, account: None, bodies: Vec::new() }
    }
}

impl<S: Space> PointLedger<S> {
    /// Keeps account from the next step on.
    pub fn open(&mut self) {
        self.account = Some(Account::default());
    }

    /// Goes on with what was stored of an account that is kept.
    pub(super) fn go_on(&mut self, entries: &mut impl Iterator<Item = Entry>) {
        if let Some(account) = &mut self.account {
            account.booked = Entry::take_all(entries);
            account.ahead = Entry::take_all(entries);
            account.start = Some(Entry::take_all(entries));
        }
    }

    /// Before a step: how bodies have moved.
    pub(crate) fn open_page(&mut self, motions: impl Iterator<Item = (S::Vector, S::Spin)>) {
        self.bodies.clear();
        self.bodies.extend(motions);
    }
}

impl<S: Space> World<'_, S> {
    /// The account as it is stored, the same on every rank; empty where none is kept. Collective.
    pub(crate) fn point_ledger_entries(&self) -> Result<Vec<Entry>, Error> {
        let Some(account) = &self.point_ledger.account else { return Ok(Vec::new()) };
        let Some(start) = account.start.clone() else { return Ok(Vec::new()) };
        let (booked, ahead) = (self.total(account.booked.clone())?, self.total(account.ahead.clone())?);
        let start = self.total(start)?;
        Ok(Entry::all_of(&booked).chain(Entry::all_of(&ahead)).chain(Entry::all_of(&start)).collect())
    }

    /// Energies at the last evaluation, the same on every rank; of a step of which [`Assembly::forces_wanted`](crate::dem::assembly::Assembly::forces_wanted) was set.
    /// Collective.
    pub fn point_energies(&self) -> Result<PointEnergies, Error> {
        self.energies_of(self.point_ledger.stored.as_ref())
    }

    /// Whether they were wanted of the last step.
    pub(crate) fn has_point_energies(&self) -> bool {
        self.point_ledger.stored.is_some()
    }

    fn energies_of(&self, stored: Option<&ExactSum<STORES>>) -> Result<PointEnergies, Error> {
        let Some(stored) = stored else {
            return Err(Error::Run(format!("step {}: no energies of points have been summed", self.step)));
        };
        let [kinetic, elastic, potential, dissipated, beside] = self.reduce(stored.clone())?;
        Ok(PointEnergies { kinetic, elastic, potential, dissipated, beside })
    }

    /// The account at the same evaluation, the same on every rank; none where none is kept, or nothing has been booked. Collective.
    pub fn point_balance(&self) -> Result<Option<PointBalance>, Error> {
        let Some(account) = self.point_ledger.account.as_ref().filter(|account| account.start.is_some()) else {
            return Ok(None);
        };
        let (start, now) = (self.energies_of(account.start.as_ref())?, self.point_energies()?);
        let [nodes, work_loads, work_bodies, work_ramp, holds, work_grains] = self.reduce(account.booked.clone())?;
        let transfer = nodes - (now.kinetic - start.kinetic);
        let work = work_loads + work_bodies + work_ramp + work_grains;
        let lost = work - (now.sum() - start.sum()) - holds;
        let dissipated = now.dissipated - start.dissipated;
        let stored = now.sum() - start.sum() - dissipated;
        let averaging = now.beside - start.beside;
        Ok(Some(PointBalance {
            work_loads,
            work_bodies,
            work_ramp,
            work_grains,
            stored,
            dissipated,
            holds,
            lost,
            transfer,
            averaging,
        }))
    }

    /// Whether this step is booked: where an account is kept, or of a continuum alone energies are wanted.
    pub(crate) fn books_points(&self) -> bool {
        let wanted = self.assembly.forces_wanted && !self.has_grains();
        self.has_points() && (wanted || self.point_ledger.account.is_some())
    }

    /// Between the step of the nodes and that of the points: books the work of the one, and energies of the other where they
    /// are wanted.
    pub(crate) fn book_points(&mut self) {
        let timer = self.phases.start();
        let works = self.works_on_nodes().merged(self.works_of_loads()).merged(self.works_of_membranes());
        self.book(works, Self::stored);
        self.phases.stop(Phase::Output, timer);
    }

    /// Books works, and where they are wanted the energies that are stored.
    pub(super) fn book(&mut self, Works([behind, ahead]): Works, stored: impl FnOnce(&Self) -> ExactSum<STORES>) {
        let opens = self.point_ledger.account.as_ref().is_some_and(|account| account.start.is_none());
        self.point_ledger.stored = (self.assembly.forces_wanted || opens).then(|| {
            let mut stored = stored(self);
            let mut kicks = ExactSum::<STORES>::new();
            kicks.set_parts(Store::Kinetic as usize, behind.parts(Item::Nodes as usize));
            stored.merge(&kicks);
            stored
        });
        if let Some(account) = &mut self.point_ledger.account {
            if opens {
                // Forces of the first evaluation work from then on.
                account.start.clone_from(&self.point_ledger.stored);
            } else {
                account.booked.merge(&account.ahead);
                account.booked.merge(&behind);
            }
            account.ahead = ahead;
        }
    }

    /// What the points of this rank have, kinetic energy at the velocities that they have.
    fn stored(&self) -> ExactSum<STORES> {
        let sums = self.subdomain.point_ranges.par_iter().enumerate().map(|(block, range)| {
            let mut sums = ExactSum::new();
            for row in range.clone() {
                let (hot, image) = (&self.continuum.points.hot[row], self.continuum.points.cold[row].image);
                let place = hot.position + self.assembly.cell.shift(image);
                let volume = hot.weight * hot.volume;
                sums.add(Store::Kinetic as usize, self.kinetic(&self.continuum.frames[block], row));
                sums.add(Store::Elastic as usize, volume * self.settings.material.elastic_energy(&hot.memory));
                let weight = self.settings.grains.field.gravity * (hot.weight * hot.mass);
                sums.add(Store::Potential as usize, -weight.dot(&place));
                sums.add(Store::Dissipated as usize, volume * hot.plastic_work);
                sums.add(Store::Beside as usize, volume * self.continuum.points.volumetric[row].lost);
            }
            sums
        });
        let mut sums = sums.reduce(ExactSum::new, |mut sums, more| {
            sums.merge(&more);
            sums
        });
        // Nodes move with the mass of membranes, which all ranks have.
        if self.transport.rank() == 0 {
            for (mass, velocity) in self.continuum.membranes.masses() {
                sums.add(Store::Kinetic as usize, 0.5 * mass * velocity.dot(velocity));
            }
        }
        sums
    }

    /// Kinetic energy of a point with its affine field, J.
    fn kinetic(&self, frame: &TileFrame<S>, row: usize) -> f64 {
        let (hot, affine) = (&self.continuum.points.hot[row], &self.continuum.points.beside[row].affine);
        let mut square = hot.velocity.dot(&hot.velocity);
        if self.settings.grid.transfer == Transfer::Affine {
            let moments = moments(frame, self.settings.grid.shape, &hot.position);
            for (along, moment) in moments.iter().enumerate().take(S::DIMENSION) {
                for axis in 0..S::DIMENSION {
                    let slope = affine[along * S::DIMENSION + axis];
                    square += moment * slope * slope;
                }
            }
        }
        0.5 * hot.weight * hot.mass * square
    }

    fn works_on_nodes(&self) -> Works {
        let nodes = self.subdomain.nodes.mosaic.owned.par_iter().enumerate().zip(&self.continuum.tiles.sums);
        let coupled = self.is_coupled();
        let booked = |mut works: Works, ((number, node), sum): ((usize, &OwnedNode), &Gathered<S>)| {
            if sum.mass() > 0.0 {
                let grains = if coupled { self.continuum.tiles.grain_sums[number] } else { GrainNode::zero() };
                let advanced = &self.continuum.tiles.advanced[node.row as usize];
                self.work_on_node((node, number), (sum, &grains), advanced, &mut works);
            }
            works
        };
        nodes.fold(Works::default, booked).reduce(Works::default, Works::merged)
    }

    /// As [`crate::mpm::nodes::step`] and [`crate::domain::grid::BoundaryConditions`] reckon it: grains and points become one, dashpots act, then
    /// bodies and faces hold, one after the other. Of what acts on both, points have their share of the mass.
    fn work_on_node(
        &self,
        (node, number): (&OwnedNode, usize),
        (sum, grains): (&Gathered<S>, &GrainNode<S>),
        advanced: &Advanced<S>,
        works: &mut Works,
    ) {
        let (mass, dt, gravity) = (sum.mass(), self.dt_of_continuum(), self.gravity_now());
        let velocities = [sum.momentum() * (1.0 / mass), advanced.velocity()];
        works.add(Item::Nodes, &((velocities[AHEAD] - velocities[BEHIND]) * mass), &velocities);
        if let Some(force) =
            self.continuum.tiles.surface.forces.get(number).filter(|force| **force != S::Vector::zero())
        {
            works.add(Item::Loads, &(*force * dt), &velocities);
        }
        let missing = gravity - self.settings.grains.field.gravity;
        if missing != S::Vector::zero() {
            works.add(Item::Ramp, &(missing * (mass * dt)), &velocities);
        }
        let alone = sum.momentum() + sum.force() * dt + gravity * (mass * dt);
        let (mut both, mut brought, mut free) = (mass, sum.momentum(), alone * (1.0 / mass));
        if grains.mass() > 0.0 {
            (both, brought) = (mass + grains.mass(), sum.momentum() + grains.momentum());
            free = (alone - grains.given() + grains.momentum()) * (1.0 / both);
            works.add(Item::Grains, &(free * mass - alone), &velocities);
        }
        let at = (&self.settings.grid, &self.subdomain.layout);
        let mut velocity = absorbed_by_faces::<S>(free, &brought, at, node, (both, dt), None);
        if velocity != free {
            works.add(Item::Holds, &((free - velocity) * mass), &velocities);
        }
        let place: S::Vector = self.subdomain.layout.node_at(node.place);
        let faces = &self.continuum.tiles.faces;
        let met = faces.met_at(&self.subdomain.nodes.mosaic, number);
        if let (Some(set), Some(met)) = (&faces.set, met) {
            for (side, impulse) in met.impulses.iter().enumerate() {
                // No face, no impulse.
                let Some(face) = set.face_at(node.place, side).filter(|_| *impulse != S::Vector::zero()) else {
                    continue;
                };
                let (body, beside) = (set.faces[face].body, set.place_beside::<S>(face, node.place));
                let (rigid, motion) = (&self.bodies[body], &self.point_ledger.bodies[body]);
                let with = [rigid.velocity_in(motion, &beside), rigid.velocity_at(&beside)];
                let impulse = &(*impulse * (mass / both));
                works.add(Item::Bodies, impulse, &with);
                works.add(Item::Holds, impulse, &[with[BEHIND] - velocities[BEHIND], with[AHEAD] - velocities[AHEAD]]);
            }
            for (order, given) in faces.askew.given_to(number).filter(|(_, given)| given.impulse != S::Vector::zero()) {
                let body = set.askew[order];
                let (rigid, motion) = (&self.bodies[body], &self.point_ledger.bodies[body]);
                let with = [rigid.velocity_in(motion, &given.place), rigid.velocity_at(&given.place)];
                let impulse = &(given.impulse * (mass / both));
                works.add(Item::Bodies, impulse, &with);
                works.add(Item::Holds, impulse, &[with[BEHIND] - velocities[BEHIND], with[AHEAD] - velocities[AHEAD]]);
            }
            velocity = met.velocities[0];
        }
        for (body, motion) in self.bodies.iter().zip(&self.point_ledger.bodies) {
            let [held, _] = held_by_bodies(
                [velocity; 2],
                (std::slice::from_ref(body), &self.assembly.cell, met.map_or([false; 2], |met| met.by)),
                &place,
                both,
                None,
            );
            if held != velocity {
                let (impulse, beside) = ((held - velocity) * mass, place_beside(body, &self.assembly.cell, &place));
                let with = [body.velocity_in(motion, &beside), body.velocity_at(&beside)];
                works.add(Item::Bodies, &impulse, &with);
                works.add(Item::Holds, &impulse, &[with[BEHIND] - velocities[BEHIND], with[AHEAD] - velocities[AHEAD]]);
                velocity = held;
            }
        }
        let held = held_by_faces::<S>([velocity; 2], at.0, at.1, node, both, None);
        if held != velocity {
            works.add(Item::Holds, &((velocity - held) * mass), &velocities);
        }
    }

    fn works_of_loads(&self) -> Works {
        let mut works = Works::default();
        let (len, shape) = (self.subdomain.nodes.mosaic.nodes_per_tile, self.settings.grid.shape);
        let mut loaded = self.continuum.points.loaded.iter().peekable();
        for (block, range) in self.subdomain.point_ranges.iter().enumerate() {
            let tile = &self.continuum.tiles.advanced[block * len..(block + 1) * len];
            while let Some((row, push)) = loaded.next_if(|(row, _)| range.contains(&(*row as usize))) {
                let position = &self.continuum.points.hot[*row as usize].position;
                let velocities = velocities_at(&self.continuum.frames[block], shape, position, tile);
                works.add(Item::Loads, &(*push * self.dt_of_continuum()), &velocities);
            }
        }
        works
    }

    /// Of vertices whose blocks are here.
    fn works_of_membranes(&self) -> Works {
        let mut works = Works::default();
        let (held, len, shape) =
            (self.subdomain.deal.held(), self.subdomain.nodes.mosaic.nodes_per_tile, self.settings.grid.shape);
        for brought in self.continuum.membranes.brought.iter().filter(|brought| held.contains(&brought.block)) {
            let block = brought.block - held.start;
            let tile = &self.continuum.tiles.advanced[block * len..(block + 1) * len];
            let velocities = velocities_at(&self.continuum.frames[block], shape, &brought.place, tile);
            works.add(Item::Loads, &(brought.force * self.dt_of_continuum()), &velocities);
        }
        works
    }
}

/// What nodes make of velocities before and after their step at a place, m/s.
fn velocities_at<S: Space>(
    frame: &TileFrame<S>,
    shape: ShapeFunction,
    place: &S::Vector,
    tile: &[Advanced<S>],
) -> [S::Vector; 2] {
    let mut velocities = [S::Vector::zero(); 2];
    for_each_node(frame, shape, place, |node, value| {
        velocities[BEHIND] += (tile[node].velocity() - tile[node].change()) * value;
        velocities[AHEAD] += tile[node].velocity() * value;
    });
    velocities
}
